// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/CellMeans.hpp>
#include <pkg/mpm/DeformationRecord.hpp>
#include <pkg/mpm/Check.hpp>
#include <pkg/mpm/FreeSurface.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/HeatTransfer.hpp>
#include <pkg/mpm/MomentumSolver.hpp>
#include <pkg/mpm/PoreContent.hpp>
#include <pkg/mpm/PoreWater.hpp>
#include <pkg/mpm/SolidMotion.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

namespace talik {

namespace {
	// Sorting now and then keeps neighbours together also where points only slide along their strip.
	constexpr long stepsBetweenSorts = 200;

	constexpr double infinity = std::numeric_limits<double>::infinity();

	/// Numbers that change from step to step, kept together so that a checkpoint holds them all.
	template <int D> struct Clock {
		double             time        = 0.0;
		double             dt          = 0.0;
		long               steps       = 0;
		long               lastSort    = 0;
		long               sortWanted  = 0;
		double             initialMass = 0.0;
		double             skeletonWork = 0.0, porePressureWork = 0.0, gravityImpulseTime = 0.0;
		Vec<D>             gravityImpulse {};
		MomentumAccount<D> account;
		ActiveRange        range;
	};
} // namespace

template <int D> struct Ground<D>::Parts {
	GroundSettings<D>          settings;
	std::vector<PointInput<D>> inputs;
	bool                       ready = false;

	Grid<D>                            grid;
	std::unique_ptr<MaterialPoints<D>> points;
	std::unique_ptr<ShapeFunction<D>>  shape;

	// effects; null if the scene does not have them
	std::unique_ptr<SolidMotion<D>>    motion;
	std::unique_ptr<DeformationRecord<D>> record;
	std::unique_ptr<HeatTransfer<D>>   heat;
	std::unique_ptr<PoreWater<D>>      water;
	std::unique_ptr<PoreContent<D>>    content;
	std::unique_ptr<FreeSurface<D>>    surface;
	std::unique_ptr<CellMeans<D>>      cells;
	std::unique_ptr<MomentumSolver<D>> momentum;

	std::vector<std::vector<int>> skeletonPlaces;
	Clock<D>                      clock {};
	std::vector<double>           partial;
	std::vector<int>              bad; ///< per strip: place of the first point that cannot go on, or -1
	mutable std::vector<double>   scratch;

	// ---- setting up -----------------------------------------------------------------------------------------------------
	void checkSettings() const;
	void checkBoundaries() const;
	void checkPoints() const;
	void declareFields();
	void placePoints();
	void fillPoint(int place, const PointInput<D>& in, double poreFill);
	void checkFreeSurface();
	void listSkeletons();
	double poreFill() const;
	bool   hasContent() const { return settings.heat || settings.water; }
	bool   averaging() const { return motion && motion->settings->cellAveraging; }
	const CellMeans<D>* averagingCells() const { return averaging() ? cells.get() : nullptr; }

	// ---- loops ----------------------------------------------------------------------------------------------------------
	/// work(block) for all points, with weights at their positions; never two neighbouring strips at once.
	template <class Work> void scatter(Work&& work)
	{
		points->strips().scatter([&](int, int first, int last) { overBlocks(first, last, work); });
	}
	template <class Work> void overBlocks(int first, int last, Work&& work)
	{
		WeightBlock<D>               w;
		std::array<const double*, D> x;
		for (int a = 0; a < D; ++a)
			x[a] = points->position(a);
		for (int p = first; p < last; p += blockSize) {
			shape->evaluate(grid, x, p, std::min(blockSize, last - p), w);
			work(w);
		}
	}
	template <class Work> double sumOverStrips(Work&& work)
	{
		const Strips& strips = points->strips();
		partial.assign(strips.count(), 0.0);
		strips.gather([&](int s, int first, int last) { partial[s] = work(first, last); });
		double sum = 0.0;
		for (double p : partial)
			sum += p;
		return sum;
	}

	// ---- pieces of a step -----------------------------------------------------------------------------------------------
	void clearNodes();
	void clearNodes(int first, int last);
	void afterReordering();
	void locateInCells();
	void useMeanStress(int first, int count);
	void seep();
	void checkPositions(int strip, int first, int last);
	void refuseBadPoints();
	void averageStrain(int first, int last);
	void keepStrainWork(bool atStart);
	/// Pore pressure is known per cell at both ends of a step.
	bool cellPressure() const { return water && averaging() && settings.water->state.massCoefficient == MassCoefficient::exact; }
	/// Work of pore pressure is taken half with the pressure at the start and half with that at the end of a step, if both are known.
	double startShare() const { return cellPressure() ? 0.5 : 1.0; }
	std::string whereabouts(int place) const;
	void        sort();

	SkeletonBatch<D> batch(int skeleton) const;
	double           liquidDensity() const { return settings.mixture.liquid.density; }
	const EnthalpyModel* enthalpyModel() const { return heat ? &content->enthalpyModel() : nullptr; }
};

// ---- setting up -----------------------------------------------------------------------------------------------------------

template <int D> double Ground<D>::Parts::poreFill() const
{
	return std::isnan(settings.poreFill) ? (hasContent() ? 1.0 : 0.0) : settings.poreFill;
}

template <int D> void Ground<D>::Parts::checkSettings() const
{
	const GroundSettings<D>& s = settings;
	s.mixture.validate();
	if (!s.motion && !s.heat) throw std::invalid_argument("no effect: the scene has neither motion nor heat; give it at least one");
	if (s.freezing && !s.heat)
		throw std::invalid_argument("freezing without heat: ice forms when heat leaves; add heat or leave freezing out");
	if (s.water && !s.motion)
		throw std::invalid_argument("water without motion: seepage needs the momentum balance; add motion or leave water out");
	requireSetting(
	        std::isnan(s.poreFill) || (s.poreFill >= 0.0 && s.poreFill <= 1.0), "poreFill", s.poreFill, "must lie in [0, 1]");
	requireSetting(!s.water || poreFill() == 1.0, "poreFill", s.poreFill, "must be 1 in a scene with water: the ground is saturated");
	requireSetting(s.waveFraction > 0.0 && s.waveFraction <= 1.0, "waveFraction", s.waveFraction, "must lie in (0, 1]");
	requireSetting(s.heatFraction > 0.0 && s.heatFraction <= 1.0, "heatFraction", s.heatFraction, "must lie in (0, 1]");
	requireSetting(s.motionFraction > 0.0 && s.motionFraction <= 0.5, "motionFraction", s.motionFraction, "must lie in (0, 0.5]");
	if (s.motion) {
		for (int a = 0; a < D; ++a)
			requireSetting(std::isfinite(s.motion->gravity[a]), "gravity", s.motion->gravity[a], "must be finite, in m/s^2");
		requireSetting(
		        s.motion->flipFraction >= 0.0 && s.motion->flipFraction <= 1.0, "flipFraction", s.motion->flipFraction, "must lie in [0, 1]");
		requireSetting(
		        s.motion->localDamping >= 0.0 && s.motion->localDamping < 1.0, "localDamping", s.motion->localDamping, "must lie in [0, 1)");
		if (s.skeletons.empty()) throw std::invalid_argument("skeletons = []: a scene with motion needs at least one skeleton model");
		for (const auto& skeleton : s.skeletons) {
			if (!skeleton) throw std::invalid_argument("skeletons: an entry is empty; give a skeleton model");
			skeleton->validate();
		}
	}
	if (s.heat) {
		requireSetting(
		        std::isfinite(s.heat->thermalTimeScale) && s.heat->thermalTimeScale > 0.0,
		        "thermalTimeScale",
		        s.heat->thermalTimeScale,
		        "must be positive (1: real time)");
		requireSetting(!(s.heat->smoothingTime <= 0.0), "smoothingTime", s.heat->smoothingTime, "must be positive, in s; infinity: none, NaN: chosen");
		requireSetting(std::isfinite(s.heat->source), "source", s.heat->source, "must be finite, in W/m^3");
		if (s.heat->enthalpyForm == EnthalpyForm::capacityIntegral && s.motion)
			throw std::invalid_argument(
			        "enthalpyForm = capacityIntegral: knows no strain and no moving water; use stateFunction in a scene with motion");
	}
	if (s.water) {
		s.water->state.validate();
		s.water->permeability.validate();
		requireSetting(
		        s.water->flipFraction >= 0.0 && s.water->flipFraction <= 1.0, "water.flipFraction", s.water->flipFraction, "must lie in [0, 1]");
	}
}

template <int D> void Ground<D>::Parts::checkBoundaries() const
{
	for (std::size_t i = 0; i < settings.boundaries.size(); ++i) {
		const auto& b = settings.boundaries[i];
		if (!b) throw std::invalid_argument("boundaries[" + std::to_string(i) + "] is empty; give a boundary condition");
		const std::string effect  = b->effect();
		const bool        present = effect == "motion" ? bool(settings.motion) : effect == "heat" ? bool(settings.heat) : bool(settings.water);
		if (!present)
			throw std::invalid_argument(
			        "boundaries[" + std::to_string(i) + "] = " + b->name() + " on " + b->region().describe() + ": the scene has no " + effect
			        + "; add it or leave this boundary out");
		b->validate(grid);
		for (std::size_t j = 0; j < i; ++j) {
			const auto& other = settings.boundaries[j];
			if (other->effect() != effect || b->loads() || other->loads() || b->drains() || other->drains()) continue;
			if (b->usesSurface() && other->usesSurface() && b->name() != other->name()) continue;
			const Region<D>&r = b->region(), &q = other->region();
			if (r.kind != q.kind || r.kind == Region<D>::Kind::nodeBox) continue;
			if (r.kind == Region<D>::Kind::side && (r.on.axis != q.on.axis || r.on.upper != q.on.upper)) continue;
			bool overlap = true;
			for (int a = 0; a < D; ++a) {
				if (r.kind == Region<D>::Kind::side && a == r.on.axis) continue;
				overlap = overlap && r.boxLower[a] < q.boxUpper[a] && q.boxLower[a] < r.boxUpper[a];
			}
			if (overlap)
				throw std::invalid_argument(
				        "boundaries[" + std::to_string(i) + "] = " + b->name() + " on " + r.describe() + " overlaps boundaries[" + std::to_string(j)
				        + "] = " + other->name() + " on " + q.describe() + "; limit one of them to a box or remove it");
		}
	}
}

template <int D> void Ground<D>::Parts::checkPoints() const
{
	if (inputs.empty()) throw std::invalid_argument("points = 0: the scene has no material points; add some before the start");
	const auto name = [](std::size_t id, const char* attribute) { return "point " + std::to_string(id) + "." + attribute; };
	for (std::size_t id = 0; id < inputs.size(); ++id) {
		const PointInput<D>& in = inputs[id];
		for (int a = 0; a < D; ++a) {
			requireSetting(
			        in.position[a] >= grid.lower()[a] && in.position[a] <= grid.upper()[a],
			        name(id, "position") + "[" + std::to_string(a) + "]",
			        in.position[a],
			        "outside the grid's box; move the point or enlarge the box");
			requireSetting(std::isfinite(in.velocity[a]), name(id, "velocity"), in.velocity[a], "must be finite, in m/s");
		}
		requireSetting(std::isfinite(in.volume) && in.volume > 0.0, name(id, "volume"), in.volume, "must be positive, in m^3 (m^2 in 2-D)");
		requireSetting(in.porosity > 1e-3 && in.porosity < 1.0, name(id, "porosity"), in.porosity, "must lie in (0.001, 1)");
		if (settings.heat)
			requireSetting(
			        in.temperature > -100.0 && in.temperature < 100.0, name(id, "temperature"), in.temperature, "must lie between -100 and 100 degC");
		if (settings.water) requireSetting(std::isfinite(in.pressure), name(id, "pressure"), in.pressure, "must be finite, in Pa");
		if (settings.motion) {
			requireSetting(
			        in.skeleton >= 0 && in.skeleton < static_cast<int>(settings.skeletons.size()),
			        name(id, "skeleton"),
			        in.skeleton,
			        "must be an index into the list of skeletons, 0 to " + std::to_string(settings.skeletons.size() - 1));
			for (double s : in.stress)
				requireSetting(std::isfinite(s), name(id, "stress"), s, "must be finite, in Pa");
		}
	}
}

template <int D> void Ground<D>::Parts::declareFields()
{
	points             = std::make_unique<MaterialPoints<D>>();
	PointFields& field = points->fields();
	if (settings.motion) motion = std::make_unique<SolidMotion<D>>(field, *settings.motion);
	if (settings.motion && settings.deformationRecord) record = std::make_unique<DeformationRecord<D>>(field);
	if (hasContent()) content = std::make_unique<PoreContent<D>>(field, settings);
	if (settings.heat) heat = std::make_unique<HeatTransfer<D>>(field, *settings.heat);
	if (settings.water) water = std::make_unique<PoreWater<D>>(field, *settings.water);
	if (settings.motion)
		for (std::size_t k = 0; k < settings.skeletons.size(); ++k)
			settings.skeletons[k]->declareFields(field, "skeleton" + std::to_string(k) + ".");

	const bool usesSurface = std::any_of(
	        settings.boundaries.begin(), settings.boundaries.end(), [](const auto& b) { return b->usesSurface(); });
	if (usesSurface) surface = std::make_unique<FreeSurface<D>>();
	if (usesSurface || averaging()) cells = std::make_unique<CellMeans<D>>();
	if (settings.motion) momentum = std::make_unique<MomentumSolver<D>>(grid, settings.boundaries);
}

template <int D> void Ground<D>::Parts::fillPoint(int p, const PointInput<D>& in, double fill)
{
	for (int a = 0; a < D; ++a)
		points->position(a)[p] = in.position[a];
	points->volume()[p]    = in.volume;
	points->skeletons()[p] = in.skeleton;
	if (motion) {
		for (int a = 0; a < D; ++a)
			motion->velocity[a][p] = in.velocity[a];
		for (int c = 0; c < stressSize<D>; ++c)
			motion->stress[c][p] = in.stress[c];
		motion->initialVolume[p] = in.volume;
		const MixtureProperties& m = settings.mixture;
		motion->mass[p] = in.volume * ((1.0 - in.porosity) * m.solid.density + fill * in.porosity * m.liquid.density);
	}
	if (water)
		for (int a = 0; a < D; ++a)
			water->velocity[a][p] = in.velocity[a];
	if (content) content->fill(p, in.porosity, in.temperature, in.pressure, fill);
}

template <int D> void Ground<D>::Parts::placePoints()
{
	const int n = static_cast<int>(inputs.size());
	points->allocate(n);
	if (motion) motion->bind(*points, grid);
	if (record) {
		record->bind(*points);
		record->start(n);
	}
	if (heat) heat->bind(*points, grid);
	if (content) {
		content->bind(*points, motion.get(), heat.get(), water.get());
		if (water) water->bind(*points, grid, content->iceMass, heat ? heat->temperature : nullptr, content->waterMass);
	}
	if (surface) {
		surface->bind(*points, grid, heat ? heat->conductivity : nullptr);
		surface->setBoundaries(settings.boundaries, grid);
	}
	if (heat) heat->constrain(grid, settings.boundaries);
	if (cells) cells->allocate(grid, n);
	if (water && averaging()) water->allocateCells(grid.cellCount());
	for (int id = 0; id < n; ++id)
		fillPoint(id, inputs[id], poreFill());
	sort();
	bad.assign(points->strips().count(), -1);
	partial.reserve(std::max(points->strips().count(), 1));
	scratch.assign(n, 0.0);
	if (content) {
		const int failed = content->update(0, n);
		if (failed < n) throw std::invalid_argument(whereabouts(failed) + " cannot exist: " + content->complaint(failed));
	}
	if (heat) heat->chooseSmoothing(grid, n);
}

template <int D> void Ground<D>::Parts::listSkeletons()
{
	skeletonPlaces.resize(settings.skeletons.size());
	for (auto& places : skeletonPlaces) {
		places.clear();
		places.reserve(points->count());
	}
	for (int p = 0; p < points->count(); ++p)
		skeletonPlaces[points->skeletons()[p]].push_back(p);
}

template <int D> SkeletonBatch<D> Ground<D>::Parts::batch(int k) const
{
	SkeletonBatch<D> b;
	b.count = static_cast<int>(skeletonPlaces[k].size());
	b.place = skeletonPlaces[k].data();
	b.id    = points->ids();
	for (int c = 0; c < D * D; ++c)
		b.gradient[c] = motion->gradient[c];
	b.iceSaturation = content ? content->iceSaturation : nullptr;
	for (int c = 0; c < stressSize<D>; ++c)
		b.stress[c] = motion->stress[c];
	b.volume = points->volume();
	return b;
}

template <int D> void Ground<D>::Parts::checkFreeSurface()
{
	if (!surface) return;
	clearNodes();
	locateInCells();
	scatter([&](const WeightBlock<D>& w) { surface->map(grid, w); });
	surface->collect(grid, *cells, clock.range);
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b) {
		const Boundary<D>& boundary = *settings.boundaries[b];
		if (!boundary.usesSurface() || !surface->patch(b).nodes.empty()) continue;
		throw std::invalid_argument(
		        "boundaries[" + std::to_string(b) + "] = " + boundary.name() + " on " + boundary.region().describe()
		        + ": no ground there; the free surface needs at least one empty row of cells between the ground and the box");
	}
}

// ---- pieces of a step -----------------------------------------------------------------------------------------------------

template <int D> std::string Ground<D>::Parts::whereabouts(int place) const
{
	std::ostringstream text;
	text << "material point " << points->id(place) << " at (";
	for (int a = 0; a < D; ++a)
		text << (a ? ", " : "") << points->position(a)[place];
	text << ") in step " << clock.steps;
	return text.str();
}

template <int D> void Ground<D>::Parts::sort()
{
	points->strips().parallel = points->count() >= settings.parallelFrom;
	points->sort(grid);
	clock.range      = ActiveRange::of(grid, *points);
	clock.lastSort   = clock.steps;
	clock.sortWanted = 0;
	afterReordering();
}

template <int D> void Ground<D>::Parts::afterReordering()
{
	// what lies outside the active range stays zero until the next sorting
	clearNodes(0, grid.nodeCount());
	if (cells) cells->clearAll();
	if (water) water->clearCells(0, grid.cellCount());
	if (motion) listSkeletons();
}

template <int D> void Ground<D>::Parts::clearNodes(int first, int last)
{
	if (motion) motion->nodes.clear(first, last);
	if (water) water->nodes.clear(first, last);
	if (heat) heat->clear(first, last);
	if (surface) surface->nodes.clear(first, last);
}

template <int D> void Ground<D>::Parts::clearNodes()
{
	clock.range.overNodes([&](int, int first, int last) { clearNodes(first, last); });
}

template <int D> void Ground<D>::Parts::locateInCells()
{
	if (!cells) return;
	cells->clearVolumes(clock.range);
	cells->clearSums(clock.range);
	const bool average = averaging();
	if (water) water->clearCells(clock.range.firstCell, clock.range.lastCell);
	points->strips().scatter([&](int, int first, int last) {
		cells->locate(grid, *points, first, last);
		if (!average) return;
		if (water) water->addPressure(*cells, first, last);
		useMeanStress(first, last - first);
		const double* volume = points->volume();
		for (int p = first; p < last; ++p)
			cells->add(p, volume[p] * motion->meanStress[p]);
	});
}

template <int D> void Ground<D>::Parts::useMeanStress(int first, int count)
{
	double* mean = motion->meanStress;
	for (int p = first; p < first + count; ++p) {
		double sum = motion->stress[0][p];
		for (int a = 1; a < D; ++a)
			sum += motion->stress[a][p];
		mean[p] = sum * (1.0 / D);
	}
	if (!water) return;
	for (int p = first; p < first + count; ++p)
		mean[p] -= water->pressure[p];
}

template <int D> void Ground<D>::Parts::seep()
{
	scatter([&](const WeightBlock<D>& w) { water->seep(grid, w, clock.dt, liquidDensity(), enthalpyModel()); });
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b) {
		const Boundary<D>& boundary = *settings.boundaries[b];
		if (boundary.drains())
			water->drain(
			        surface->patch(b), boundary.recharges(), clock.dt, liquidDensity(), enthalpyModel(), heat ? &heat->mapped : nullptr);
	}
	if (settings.energyLedger) {
		double work = 0.0;
		for (int i = clock.range.firstNode; i < clock.range.lastNode; ++i)
			work += water->nodal[i][0] * water->exchange[i][0];
		clock.porePressureWork += startShare() * work / liquidDensity();
	}
	water->finishExchange(clock.range);
}

template <int D> void Ground<D>::Parts::checkPositions(int strip, int first, int last)
{
	// a point that is not a number fails the comparisons too
	bool inside = true;
	for (int a = 0; a < D; ++a) {
		const double* x     = points->position(a);
		const double  lower = grid.lower()[a], upper = grid.upper()[a];
		int           out   = 0;
		for (int p = first; p < last; ++p)
			out += !(x[p] >= lower) | !(x[p] <= upper);
		inside = inside && out == 0;
	}
	if (!inside) {
		for (int p = last - 1; p >= first; --p) {
			Vec<D> x;
			for (int a = 0; a < D; ++a)
				x[a] = points->position(a)[p];
			if (!grid.contains(x)) bad[strip] = p;
		}
		return;
	}
	const Strips& strips = points->strips();
	const double  low    = grid.lower()[strips.axis] + (strip * Strips::rows - Strips::stray) * grid.spacing();
	const double  high   = grid.lower()[strips.axis] + ((strip + 1) * Strips::rows + Strips::stray) * grid.spacing();
	const double* x      = points->position(strips.axis);
	int           strayed = 0;
	for (int p = first; p < last; ++p)
		strayed += (x[p] < low) | (x[p] >= high);
	if (strayed > 0) {
#pragma omp atomic write
		clock.sortWanted = 1;
	}
}

template <int D> void Ground<D>::Parts::refuseBadPoints()
{
	std::string names;
	int         count = 0, firstBad = -1;
	for (int& p : bad) {
		if (p < 0) continue;
		if (firstBad < 0) firstBad = p;
		if (count++ < 5) names += (names.empty() ? "" : ", ") + std::to_string(points->id(p));
		p = -1;
	}
	if (count == 0) return;
	Vec<D> x;
	for (int a = 0; a < D; ++a)
		x[a] = points->position(a)[firstBad];
	const bool number = std::isfinite(x[0] + x[1] + x[D - 1]);
	throw std::runtime_error(
	        whereabouts(firstBad) + (number ? " left the grid's box" : " is not a number: the run became unstable")
	        + " (points concerned: " + names + ", ...); "
	        + (number ? "enlarge the box or hold the ground with a boundary there" : "use a smaller time step"));
}

template <int D> void Ground<D>::Parts::averageStrain(int first, int last)
{
	auto& g = motion->gradient;
	if (averaging())
		for (int p = first; p < last; ++p) {
			double trace = g[0][p];
			for (int a = 1; a < D; ++a)
				trace += g[a * D + a][p];
			const double replace = (cells->mean(p) - trace) * (1.0 / D);
			for (int a = 0; a < D; ++a)
				g[a * D + a][p] += replace;
		}
	double* volume = points->volume();
	for (int p = first; p < last; ++p) {
		if constexpr (D == 2) {
			volume[p] *= (1.0 + g[0][p]) * (1.0 + g[3][p]) - g[1][p] * g[2][p];
		} else {
			const double a = 1.0 + g[0][p], b = g[1][p], c = g[2][p], d = g[3][p], e = 1.0 + g[4][p], f = g[5][p], h = g[6][p], i = g[7][p],
			             j = 1.0 + g[8][p];
			volume[p] *= a * (e * j - f * i) - b * (d * j - f * h) + c * (d * i - e * h);
		}
	}
}

/// Work of stress and pressure on the strain of the step, half at its start (before cell means replace the divergence) and half at
/// its end: the mean of both is what an elastic skeleton stores, either alone is off by the first order of dt.
template <int D> void Ground<D>::Parts::keepStrainWork(bool atStart)
{
	const auto&   g       = motion->gradient;
	const double* volume  = points->volume();
	const bool    replace = atStart && averaging();
	clock.skeletonWork += 0.5 * sumOverStrips([&](int first, int last) {
		double work = 0.0;
		for (int p = first; p < last; ++p) {
			double trace = 0.0;
			for (int a = 0; a < D; ++a)
				trace += g[a * D + a][p];
			const double missing = replace ? (cells->mean(p) - trace) * (1.0 / D) : 0.0;
			double       density = 0.0;
			for (int i = 0; i < D; ++i)
				for (int j = 0; j < D; ++j)
					density += motion->stress[stressIndex<D>(i, j)][p] * (g[i * D + j][p] + (i == j ? missing : 0.0));
			work += volume[p] * density;
		}
		return work;
	});
	const double share = atStart ? startShare() : 1.0 - startShare();
	if (!water || share == 0.0) return;
	const double strained = sumOverStrips([&](int first, int last) {
		double work = 0.0;
		for (int p = first; p < last; ++p) {
			double trace = 0.0;
			for (int a = 0; a < D; ++a)
				trace += g[a * D + a][p];
			work += volume[p] * water->pressure[p] * (replace ? cells->mean(p) : trace);
		}
		return work;
	});
	clock.porePressureWork -= share * strained;
	if (!atStart) clock.porePressureWork += share * water->seepageWork(clock.range.firstCell, clock.range.lastCell) / liquidDensity();
}

// ---- public interface -------------------------------------------------------------------------------------------------------

template <int D>
Ground<D>::Ground()
        : parts_(std::make_unique<Parts>())
{
}

template <int D>
Ground<D>::Ground(const GroundSettings<D>& settings)
        : Ground()
{
	parts_->settings = settings;
}

template <int D> Ground<D>::~Ground()                           = default;
template <int D> Ground<D>::Ground(Ground&&) noexcept            = default;
template <int D> Ground<D>& Ground<D>::operator=(Ground&&) noexcept = default;

template <int D> GroundSettings<D>&       Ground<D>::settings() { return parts_->settings; }
template <int D> const GroundSettings<D>& Ground<D>::settings() const { return parts_->settings; }

template <int D> int Ground<D>::addPoint(const PointInput<D>& point)
{
	if (parts_->ready) throw std::logic_error("addPoint: points are added before initialise()");
	parts_->inputs.push_back(point);
	return static_cast<int>(parts_->inputs.size()) - 1;
}

template <int D> void Ground<D>::initialise()
{
	Parts& g = *parts_;
	if (g.ready) throw std::logic_error("initialise: the ground is initialised already");
	g.grid = Grid<D>(g.settings.lower, g.settings.upper, g.settings.gridSpacing);
	g.checkSettings();
	g.checkBoundaries();
	g.checkPoints();
	g.shape = makeShapeFunction<D>(g.settings.shapeFunction);
	g.declareFields();
	g.placePoints();
	g.checkFreeSurface();
	if (g.motion) {
		for (std::size_t k = 0; k < g.settings.skeletons.size(); ++k)
			g.settings.skeletons[k]->initialise(g.batch(k));
		for (int p = 0; p < g.points->count(); ++p)
			g.clock.initialMass += g.motion->mass[p] + (g.water ? g.content->waterMass[p] - (g.content->iceMass ? g.content->iceMass[p] : 0.0) : 0.0);
	}
	g.inputs.clear();
	g.inputs.shrink_to_fit();
	g.ready = true;
}

template <int D> bool Ground<D>::initialised() const { return parts_->ready; }

template <int D> void Ground<D>::step(double dt)
{
	beginStep(dt);
	mapToGrid();
	updateTemperature();
	solveMomentum();
	mapToPoints();
	updateStrainAndPressure();
	updateEffectiveStress();
}

template <int D> void Ground<D>::beginStep(double dt)
{
	Parts& g = *parts_;
	if (!g.ready) throw std::logic_error("step: the ground is not initialised");
	requireSetting(std::isfinite(dt) && dt > 0.0, "dt", dt, "must be a positive time in s; stableTimeStep() proposes one");
	g.clock.dt = dt;
	if (g.clock.sortWanted || g.clock.steps - g.clock.lastSort >= stepsBetweenSorts) g.sort();
}

template <int D> void Ground<D>::mapToGrid()
{
	Parts& g = *parts_;
	g.clearNodes();
	g.locateInCells();
	const bool average = g.averaging();
	g.scatter([&](const WeightBlock<D>& w) {
		if (g.motion) {
			if (average)
				for (int k = 0; k < w.count; ++k)
					g.motion->meanStress[w.first + k] = g.cells->mean(w.first + k);
			else
				g.useMeanStress(w.first, w.count);
			g.motion->map(g.grid, w);
		}
		if (g.water) g.water->map(g.grid, w, g.averagingCells());
		if (g.heat) g.heat->map(g.grid, w);
		if (g.surface) g.surface->map(g.grid, w);
	});
	if (g.surface) g.surface->collect(g.grid, *g.cells, g.clock.range);
}

template <int D> void Ground<D>::updateTemperature()
{
	Parts& g = *parts_;
	if (!g.heat) return;
	const double time = g.clock.time + g.clock.dt;
	g.heat->nodalTemperature(g.grid, g.clock.range, g.settings.boundaries, time);
	g.scatter([&](const WeightBlock<D>& w) { g.heat->conduct(g.grid, w, g.clock.dt); });
	for (std::size_t b = 0; b < g.settings.boundaries.size(); ++b) {
		const Boundary<D>& boundary = *g.settings.boundaries[b];
		if (boundary.heats()) g.heat->exchange(boundary.heat(time), g.surface->patch(b), *g.surface, g.grid.spacing(), g.clock.dt);
	}
	g.heat->finishNodes(g.clock.range, g.clock.dt);
	if (g.settings.heat->source != 0.0) {
		const double* volume = g.points->volume();
		const double  ground = g.sumOverStrips([&](int first, int last) {
                        double v = 0.0;
                        for (int p = first; p < last; ++p)
                                v += volume[p];
                        return v;
                });
		g.heat->heatIn += g.settings.heat->source * g.settings.heat->thermalTimeScale * ground * g.clock.dt;
	}
}

template <int D> void Ground<D>::solveMomentum()
{
	Parts& g = *parts_;
	if (!g.motion) return;
	const double time = g.clock.time + g.clock.dt;
	if (g.water) {
		g.water->nodalPressure(g.clock.range);
		g.scatter([&](const WeightBlock<D>& w) { g.water->pressureForce(g.grid, w); });
		g.water->liquidForce(g.clock.range, g.motion->settings->gravity);
	}
	g.momentum->addGravity(g.clock.range, *g.motion, g.water.get());
	for (std::size_t b = 0; b < g.settings.boundaries.size(); ++b) {
		const Boundary<D>& boundary = *g.settings.boundaries[b];
		if (boundary.loads()) g.momentum->addLoad(boundary, g.surface->patch(b), time, *g.motion);
		if (boundary.drains()) g.water->drainedForce(g.surface->patch(b), boundary.pressure(time));
	}
	g.momentum->solve(g.clock.range, *g.motion, g.water.get(), g.clock.dt, g.settings.energyLedger, g.clock.account);
	const double mass = g.clock.initialMass - (g.water ? g.water->waterOut : 0.0);
	for (int a = 0; a < D; ++a)
		g.clock.account.impulse[a] += g.clock.dt * mass * g.motion->settings->gravity[a];
	if (g.water) g.seep();
}

template <int D> void Ground<D>::mapToPoints()
{
	Parts& g = *parts_;
	if (g.averaging()) g.cells->clearSums(g.clock.range);
	const bool average = g.averaging();
	const auto gather  = [&](int strip, int first, int last) {
                g.overBlocks(first, last, [&](const WeightBlock<D>& w) {
                        if (g.heat) g.heat->gather(g.grid, w, g.clock.dt);
                        if (g.water)
                                g.water->gather(g.grid, w, g.content->waterMass, g.heat ? g.heat->enthalpy : nullptr, g.averagingCells());
                        if (g.motion) g.motion->gather(g.grid, w, g.clock.dt);
                });
                if (!g.motion) return;
                if (average) {
                        const double* volume = g.points->volume();
                        for (int p = first; p < last; ++p) {
                                double trace = g.motion->gradient[0][p];
                                for (int a = 1; a < D; ++a)
                                        trace += g.motion->gradient[a * D + a][p];
                                g.cells->add(p, volume[p] * trace);
                        }
                }
                g.checkPositions(strip, first, last);
	};
	g.points->strips().scatter(gather);
	if (g.motion) g.refuseBadPoints();
}

template <int D> void Ground<D>::updateStrainAndPressure()
{
	Parts& g = *parts_;
	if (g.motion && g.settings.energyLedger) g.keepStrainWork(true);
	const CellMeans<D>* cells  = g.water ? g.averagingCells() : nullptr;
	const auto          update = [&](int strip, int first, int last) {
                if (cells) g.water->receive(*cells, first, last, g.content->waterMass, g.heat ? g.heat->enthalpy : nullptr);
                if (g.motion) g.averageStrain(first, last);
                if (g.record) g.record->accumulate(first, last, g.motion->gradient);
                if (!g.content) return;
                const int failed = g.content->update(first, last, cells);
                if (failed < last) g.bad[strip] = failed;
	};
	if (cells) {
		g.points->strips().scatter(update);
		if (g.cellPressure())
			g.points->strips().gather([&](int, int first, int last) { g.water->shareCellPressure(*cells, first, last); });
	} else
		g.points->strips().gather(update);
	if (!g.content) return;
	for (int& failed : g.bad) {
		if (failed < 0) continue;
		const int p = failed;
		std::fill(g.bad.begin(), g.bad.end(), -1);
		throw std::runtime_error(g.whereabouts(p) + " is in an impossible state: " + g.content->complaint(p));
	}
}

template <int D> void Ground<D>::updateEffectiveStress()
{
	Parts& g = *parts_;
	if (g.motion)
		for (std::size_t k = 0; k < g.settings.skeletons.size(); ++k)
			if (!g.skeletonPlaces[k].empty()) g.settings.skeletons[k]->updateStress(g.batch(k));
	if (g.motion && g.settings.energyLedger) g.keepStrainWork(false);
	g.clock.time += g.clock.dt;
	++g.clock.steps;
}

template <int D> StableTimeStep Ground<D>::stableTimeStep() const
{
	const Parts& g = *parts_;
	if (!g.ready) throw std::logic_error("stableTimeStep: the ground is not initialised");
	const GroundSettings<D>& s = g.settings;
	const double             h = g.grid.spacing();
	const int                n = g.points->count();
	const double*            volume = g.points->volume();

	StableTimeStep result;
	const auto     add = [&](const char* name, const std::function<double(int)>& limitOf) {
                TimeStepLimit limit { name, infinity, -1 };
                for (int p = 0; p < n; ++p) {
                        const double step = limitOf(p);
                        if (step < limit.step) limit.step = step, limit.point = g.points->id(p);
                }
                result.limits.push_back(limit);
	};
	const auto speed = [&](const std::array<double*, D>& v, int p) {
		double sum = 0.0;
		for (int a = 0; a < D; ++a)
			sum += v[a][p] * v[a][p];
		return std::sqrt(sum);
	};

	if (g.motion) {
		for (std::size_t k = 0; k < s.skeletons.size(); ++k)
			s.skeletons[k]->tangentModulus(g.batch(k), g.scratch.data());
		add("wave", [&](int p) {
			const double modulus = g.scratch[p];
			double       c       = std::sqrt(modulus * volume[p] / g.motion->mass[p]);
			double       v       = speed(g.motion->velocity, p);
			if (g.water) {
				const double  porosity = g.content->porosity[p];
				const double  sl       = g.content->iceSaturation ? 1.0 - g.content->iceSaturation[p] : 1.0;
				const double  t        = g.heat ? g.heat->temperature[p] : s.mixture.referenceTemperature;
				const PressureCoefficients k = s.water->state.coefficients(s.mixture, { porosity, sl, 0.0, t });
				c = largestWaveSpeed(s.mixture, VolumeFractions::of(porosity, sl), k, modulus);
				v = std::max(v, speed(g.water->velocity, p));
			}
			return s.waveFraction * h / (c + v);
		});
		add("velocity", [&](int p) { return s.motionFraction * h / speed(g.motion->velocity, p); });
	}
	if (g.heat) {
		const double scale = 2.0 * D * s.heat->thermalTimeScale / (s.heatFraction * h * h);
		add("heat", [&](int p) { return g.heat->heatCapacity[p] / (volume[p] * g.heat->conductivity[p] * scale); });
		if (g.water)
			add("heat advection", [&](int p) {
				double q = 0.0;
				for (int a = 0; a < D; ++a) {
					const double w = g.water->velocity[a][p] - g.motion->velocity[a][p];
					q += w * w;
				}
				q = g.water->liquidFraction[p] * std::sqrt(q);
				return h * g.heat->heatCapacity[p] / (volume[p] * s.mixture.liquid.density * s.mixture.liquid.specificHeat * q);
			});
	}
	result.step = infinity;
	for (const TimeStepLimit& limit : result.limits)
		if (limit.step < result.step) {
			result.step      = limit.step;
			result.governing = limit.name;
		}
	return result;
}

template <int D> Balance<D> Ground<D>::balance() const
{
	const Parts& g = *parts_;
	if (!g.ready) throw std::logic_error("balance: the ground is not initialised");
	Balance<D> b;
	b.time      = g.clock.time;
	const int n = g.points->count();
	for (int p = 0; p < n; ++p) {
		double moving = 0.0, liquid = 0.0;
		if (g.content) {
			const double ice = g.content->iceMass ? g.content->iceMass[p] : 0.0;
			b.solidMass += g.content->solidMass[p];
			b.waterMass += g.content->waterMass[p];
			b.iceMass += ice;
			if (g.water) liquid = g.content->waterMass[p] - ice;
		}
		if (g.motion) {
			moving = g.motion->mass[p];
			if (!g.content) b.solidMass += moving;
			const Vec<D>& gravity = g.motion->settings->gravity;
			for (int a = 0; a < D; ++a) {
				const double v = g.motion->velocity[a][p], vl = g.water ? g.water->velocity[a][p] : 0.0;
				b.momentum[a] += moving * v + liquid * vl;
				b.kineticEnergy += 0.5 * (moving * v * v + liquid * vl * vl);
				b.gravityEnergy -= (moving + liquid) * gravity[a] * g.motion->position[a][p];
			}
		}
		if (g.heat) b.enthalpy += g.heat->enthalpy[p];
	}
	b.impulse            = g.clock.account.impulse;
	b.dragDissipation    = g.clock.account.dragDissipation;
	b.dampingDissipation = g.clock.account.dampingDissipation;
	b.loadWork           = g.clock.account.loadWork;
	b.skeletonWork       = g.clock.skeletonWork;
	b.porePressureWork   = g.clock.porePressureWork;
	if (g.heat) b.heatIn = g.heat->heatIn;
	if (g.water) {
		b.waterOut    = g.water->waterOut;
		b.enthalpyOut = g.water->enthalpyOut;
		for (int a = 0; a < D; ++a)
			b.impulse[a] -= g.water->momentumOut[a];
	}
	return b;
}

template <int D> double Ground<D>::time() const { return parts_->clock.time; }
template <int D> long   Ground<D>::steps() const { return parts_->clock.steps; }
template <int D> double Ground<D>::dt() const { return parts_->clock.dt; }

template <int D> const Grid<D>&           Ground<D>::grid() const { return parts_->grid; }
template <int D> MaterialPoints<D>&       Ground<D>::points() { return *parts_->points; }
template <int D> const MaterialPoints<D>& Ground<D>::points() const { return *parts_->points; }

template <int D> std::vector<FieldInfo> Ground<D>::fields() const
{
	const Parts&           g    = *parts_;
	std::vector<FieldInfo> list = g.points->fields().list();
	const auto             node = [&](const char* name, const char* owner, const char* unit, int components, std::size_t bytes) {
                list.push_back({ name, owner, unit, "nodes", components, bytes, false });
	};
	if (g.motion) {
		node("massMomentumForce", "motion", "kg, kg m/s, N", 2 * D + 1, g.motion->nodes.bytes());
		node("solvedVelocity", "motion", "m/s", 2 * D, g.motion->solved.bytes());
	}
	if (g.heat) {
		node("heatCapacitySum", "heat", "J/K, J", 2, g.heat->nodes.bytes());
		node("nodalTemperature", "heat", "J/K, degC", 3, g.heat->capacity.bytes() + g.heat->mapped.bytes() + g.heat->nodal.bytes());
		node("nodalHeat", "heat", "J, K", 3, g.heat->energy.bytes() + g.heat->noise.bytes() + g.heat->rise.bytes());
		if (g.heat->moments.bytes() > 0) node("heatMoments", "heated walls", "J m/K", D, g.heat->moments.bytes());
	}
	if (g.water) {
		node("liquidMassMomentumDrag", "water", "kg, kg m/s, m^D, J, kg/s", 5 + D, g.water->nodes.bytes());
		node("nodalPressure", "water", "Pa, -, 1/kg", 3, g.water->nodal.bytes());
		node("liquidForce", "water", "N", D, g.water->force.bytes());
		node("solvedLiquidVelocity", "water", "m/s", 2 * D, g.water->solved.bytes() + g.water->start.bytes());
		node("seepageFlux", "water", "m/s", D, g.water->flux.bytes());
		node("seepageExchange", "water", "kg, J, kg m/s", 2 + D, g.water->exchange.bytes());
	}
	if (g.surface) node("surfaceArea", "surface boundaries", "m^(D-1), m^D, W m^(D-1)/K", D + 2, g.surface->nodes.bytes());
	return list;
}

template <int D> void Ground<D>::copyById(const std::string& field, int component, double* out) const
{
	const Parts&  g      = *parts_;
	const double* values = g.points->fields().find(field, component);
	if (!values) {
		std::string known;
		for (const FieldInfo& f : g.points->fields().list())
			known += (known.empty() ? "" : ", ") + f.name + "[" + std::to_string(f.components) + "]";
		throw std::invalid_argument("field '" + field + "' component " + std::to_string(component) + " does not exist; there are " + known);
	}
	for (int p = 0; p < g.points->count(); ++p)
		out[g.points->id(p)] = values[p];
}

template <int D> SkeletonBatch<D> Ground<D>::skeletonBatch(int skeleton) const { return parts_->batch(skeleton); }

template <int D> void Ground<D>::setThermalState(int id, double temperature, double pressure)
{
	Parts&    g = *parts_;
	const int p = g.points->place(id);
	if (!g.content) throw std::logic_error("setThermalState: the scene has neither heat nor water");
	g.content->fill(p, g.content->porosity[p], temperature, pressure, g.poreFill());
	if (g.content->update(p, p + 1) != p + 1) throw std::invalid_argument(g.whereabouts(p) + " cannot exist: " + g.content->complaint(p));
}

template <int D> std::vector<StateArray> Ground<D>::state()
{
	Parts&                  g = *parts_;
	std::vector<StateArray> list;
	const std::size_t       n = g.points->count();
	PointFields&            f = g.points->fields();
	for (std::size_t k = 0; k < f.list().size(); ++k)
		if (f.list()[k].persistent)
			for (int c = 0; c < f.list()[k].components; ++c)
				list.push_back({ f.list()[k].name + "." + std::to_string(c), f.component(static_cast<int>(k), c), n * sizeof(double) });
	list.push_back({ "id", g.points->idArray().data(), n * sizeof(int) });
	list.push_back({ "skeleton", g.points->skeletons(), n * sizeof(int) });
	std::vector<int>& first = g.points->strips().first;
	list.push_back({ "strips", first.data(), first.size() * sizeof(int) });
	list.push_back({ "clock", &g.clock, sizeof(g.clock) });
	if (g.heat) {
		list.push_back({ "heatIn", &g.heat->heatIn, sizeof(double) });
		list.push_back({ "smoothingTime", &g.heat->smoothingTime, sizeof(double) });
	}
	if (g.water) {
		list.push_back({ "waterOut", &g.water->waterOut, sizeof(double) });
		list.push_back({ "enthalpyOut", &g.water->enthalpyOut, sizeof(double) });
		list.push_back({ "momentumOut", &g.water->momentumOut, sizeof(Vec<D>) });
	}
	return list;
}

template <int D> void Ground<D>::stateRestored()
{
	Parts& g = *parts_;
	g.points->idsRestored();
	g.afterReordering();
}

template class Ground<2>;
template class Ground<3>;

} // namespace talik
