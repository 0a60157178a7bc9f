// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/mpm/GroundParts.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

template <int D> void Ground<D>::Parts::declareFields()
{
	points             = std::make_unique<MaterialPoints<D>>();
	PointFields& field = points->fields();
	listEffects();
	if (settings.motion)
		motion = std::make_unique<SolidMotion<D>>(
		        field, *settings.motion, settings.water || settings.motion->bBar || !stressingEffects.empty(), settings.axisymmetric);
	if (settings.motion && settings.motion->transfer != VelocityTransfer::flip)
		affine = std::make_unique<AffineVelocity<D>>(field, settings.motion->transfer);
	if (settings.motion && fillsCells && !affine) mappedBack = std::make_unique<MappedBack<D>>();
	for (const auto& effect : effects)
		effect->declareFields(field);
	if (hasContent()) content = std::make_unique<PoreContent<D>>(field, settings);
	if (settings.heat) heat = std::make_unique<HeatTransfer<D>>(field, *settings.heat, bool(settings.freezing));
	if (settings.water) water = std::make_unique<PoreWater<D>>(field, *settings.water);
	if (settings.water && settings.water->implicit) implicit = std::make_unique<ImplicitPressure<D>>(field);
	if (settings.motion)
		for (std::size_t k = 0; k < settings.skeletons.size(); ++k)
			settings.skeletons[k]->declareFields(field, "skeleton" + std::to_string(k) + ".");

	const bool usesSurface = std::any_of(settings.boundaries.begin(), settings.boundaries.end(), [](const auto& b) { return b->usesSurface(); });
	if (usesSurface) surface = std::make_unique<FreeSurface<D>>();
	if (usesSurface || averaging() || mappedBack) cells = std::make_unique<CellMeans<D>>();
	if (settings.heat && settings.heat->followsMotion) calendar = std::make_unique<Calendar<D>>(field, *settings.heat);
	if (settings.bodies) bodies = std::make_unique<RigidContact<D>>(field, *settings.bodies);
	if (hasFront()) front = std::make_unique<ThawFront<D>>(field, *settings.thawFront);
	if (hasThawStrain() || hasCompression()) thawStrain = std::make_unique<ThawStrain<D>>(field, settings);
	if (settings.segregation) segregation = std::make_unique<IceSegregation<D>>(field, settings);
	if (hasCompression()) compression = std::make_unique<ThawedCompression<D>>(field, settings);
	if (settings.motion) momentum = std::make_unique<MomentumSolver<D>>(grid, settings.boundaries);
}

/// Those of the scene, and one that has a switch.
template <int D> void Ground<D>::Parts::listEffects()
{
	effects = settings.effects;
	if (settings.motion && settings.deformationRecord) effects.push_back(std::make_shared<DeformationRecord<D>>());
	if (settings.motion && settings.pointsDivide) effects.push_back(division = std::make_shared<DividingPoints<D>>());
	for (std::size_t k = 0; k < effects.size(); ++k)
		if (effects[k]->addsStress()) stressingEffects.push_back(int(k));
}

template <int D> bool Ground<D>::Parts::facesBodies() const
{
	return std::any_of(settings.boundaries.begin(), settings.boundaries.end(), [](const auto& b) { return b->region().kind == Region<D>::Kind::bodies; });
}

template <int D> bool Ground<D>::Parts::hasFront() const
{
	return settings.motion && settings.freezing && settings.thawFront
	        && std::any_of(settings.skeletons.begin(), settings.skeletons.end(), [](const auto& skeleton) { return skeleton->canFail(); });
}

template <int D> bool Ground<D>::Parts::hasThawStrain() const
{
	return settings.segregation // whose ice leaves room where it melts, as pore ice that cannot expel its water does
	        || settings.iceExpands()
	        || std::any_of(settings.materials.begin(), settings.materials.end(), [](const SoilMaterial& m) { return m.thawStrain > 0.0; });
}

template <int D> bool Ground<D>::Parts::hasCompression() const
{
	return std::any_of(settings.materials.begin(), settings.materials.end(), [](const SoilMaterial& m) { return m.compression.given(); });
}

template <int D> void Ground<D>::Parts::fillPoint(int p, const PointInput<D>& in, double fill)
{
	for (int a = 0; a < D; ++a)
		points->position(a)[p] = in.position[a];
	const double volume = in.volume * grid.measureAt(in.position[0]);
	points->volume()[p] = volume;
	if (motion) {
		for (int a = 0; a < D; ++a)
			motion->velocity[a][p] = in.velocity[a];
		for (int c = 0; c < stressSize<D>; ++c)
			motion->stress[c][p] = in.stress[c];
		motion->initialVolume[p]   = volume;
		const MixtureProperties& m = settings.mixtureOf(in.material);
		motion->mass[p]            = volume * ((1.0 - in.porosity) * m.solid.density + fill * in.porosity * m.liquid.density);
	}
	if (water)
		for (int a = 0; a < D; ++a)
			water->velocity[a][p] = in.velocity[a];
	if (content) content->fill(p, in.porosity, in.temperature, in.pressure, fill, contentOf());
}

namespace {
	template <std::size_t N> std::array<const double*, N> readOnly(const std::array<double*, N>& arrays)
	{
		std::array<const double*, N> same;
		std::copy(arrays.begin(), arrays.end(), same.begin());
		return same;
	}
} // namespace

template <int D> SkeletonBatch<D> Ground<D>::Parts::arraysOfSkeletons() const
{
	SkeletonBatch<D> all;
	all.gradient      = readOnly(motion->gradient);
	all.hoop          = motion->hoop;
	all.stress        = motion->stress;
	all.iceSaturation = content ? content->iceSaturation : nullptr;
	all.volume        = points->volume();
	all.temperature   = heat ? heat->temperature : nullptr;
	return all;
}

template <int D> void Ground<D>::Parts::bindEffects()
{
	const int n = points->capacity();
	passes.bind(grid, *points, *shape, cost);
	if (motion) motion->bind(*points, grid);
	if (bodies) bodies->bind(*points, *motion);
	if (bodies && facesBodies()) bodies->allocateFaces(grid);
	if (motion)
		inMotion = { points->positions(), readOnly(motion->velocity), readOnly(motion->gradient),     readOnly(motion->stress), motion->mass,
			     points->volume(),    motion->addedStress,        readOnly(motion->displacement), motion->initialVolume,    motion->hoop };
	if (heat) heat->bind(*points, grid);
	if (content) {
		content->bind(*points);
		if (water) {
			water->liquid = { settings.mixtureOf(0).liquid.density, heat ? &content->enthalpyModel() : nullptr };
			water->bind(*points, grid, content->iceMass, heat ? heat->temperature : nullptr, content->waterMass);
		}
	}
	if (front) front->bind(*points, grid, bool(water));
	if (thawStrain) thawStrain->bind(*points, grid.cellCount());
	if (segregation) {
		segregation->bind(*points, grid.cellCount());
		heat->keepOutside(grid);
		content->holdExcessIce(segregation->volume, segregation->iceMass);
	}
	if (compression) compression->bind(*points, *thawStrain, content->porosity, content->iceSaturation);
	if (motion) skeletons.bind(settings.skeletons, *points, arraysOfSkeletons());
	shareRecords();
	if (surface) {
		surface->bind(*points, grid, heat ? heat->conductivity : nullptr);
		surface->setBoundaries(settings.boundaries, grid, bool(settings.motion));
	}
	if (heat) heat->constrain(grid, settings.boundaries);
	stateDependent.find(grid, settings.boundaries);
	if (cells) cells->allocate(grid, n);
	if (mappedBack) mappedBack->bind(grid, settings.motion->gravity);
	if (averaging()) bBar.allocate(grid);
	strainWork = { startShare(), bool(implicit) };
	if (averaging() && frontHasOwnMeans()) cells->allowExceptions();
	if (water && averaging()) water->allocateCells(grid.cellCount(), grid.cellVolume());
	if (implicit) {
		implicit->bind(*points, motion->velocity);
		implicit->allocate(grid, std::any_of(settings.boundaries.begin(), settings.boundaries.end(), [](const auto& b) { return b->feeds(); }));
	}
	listReadArrays();
}

template <int D> void Ground<D>::Parts::listReadArrays()
{
	const auto reads = [](Prefetch& ahead, const auto&... arrays) { (ahead.add(arrays), ...); };
	for (Prefetch* ahead : { &passes.toGrid, &passes.flows, &passes.back, &passes.seepage, &passes.toPoints })
		reads(*ahead, points->positions());
	if (motion) {
		reads(passes.toGrid, motion->mass, motion->volume, motion->velocity, motion->stress, motion->addedStress);
		reads(passes.back, motion->mass, motion->velocity);
		reads(passes.toPoints, motion->velocity, motion->displacement, motion->gradient);
	}
	if (averaging()) reads(passes.toPoints, motion->volume);
	if (heat) {
		reads(passes.toGrid, heat->capacityWeight, heat->temperature);
		reads(passes.flows, heat->volume, heat->conductivity, heat->capacityWeight, heat->temperature);
		reads(passes.toPoints, heat->enthalpy, heat->capacityWeight, heat->temperature);
	}
	if (heat && surface) reads(passes.toGrid, heat->conductivity);
	if (water) {
		reads(passes.toGrid, water->velocity, water->pressure, water->liquidFraction, water->drag, content->waterMass, content->iceMass);
		reads(passes.seepage, points->volume(), water->velocity, heat ? heat->temperature : nullptr);
		reads(passes.toPoints, water->velocity, content->waterMass, content->iceMass);
	}
	if (water && !heat) reads(passes.flows, points->volume());
	if (averaging() && water)
		for (Prefetch* ahead : { &passes.toGrid, &passes.toPoints })
			reads(*ahead, cells->cells());
}

/// Each rank of a ground in slabs fills its own points, at the places that these have among all.
template <int D> void Ground<D>::Parts::fillPoints()
{
	const int n = points->count();
	for (int id = 0; id < n; ++id) {
		const double fill = given.at(id).poreFill;
		if (std::isnan(fill)) continue;
		if (given.fill.empty()) given.fill.assign(n, settings.usedPoreFill());
		given.fill[id] = fill;
	}
	points->strips().parallel = n >= settings.parallelFrom;
	points->arrange(grid, [&](int id) { return given.at(id).position; });
	for (int p = 0; p < n; ++p) {
		const PointInput<D> in = given.at(points->id(p));
		points->skeletons()[p] = in.skeleton;
		if (points->materials()) points->materials()[p] = std::uint16_t(in.material);
	}
	ranks.start(grid, *points, refusalOfRanks(), [this] { return ownLimits(); });
	if (content) content->holdsAir = given.fill.empty() ? settings.usedPoreFill() < 1.0 : *std::min_element(given.fill.begin(), given.fill.end()) < 1.0;
	for (int p = points->strips().firstPoint(); p < points->strips().endPoint(); ++p)
		fillPoint(p, given.at(points->id(p)), fillOf(points->id(p)));
	clock.range = ActiveRange::of(grid, *points);
	afterReordering();
}

template <int D> void Ground<D>::Parts::placePoints()
{
	points->allocate(given.count, division ? division->room * given.count : 0);
	if (!grid.images().empty()) points->strips().images = &grid.images();
	if (settings.materials.size() > 1) points->distinguishMaterials();
	bindEffects();
	fillPoints();
	const int n = points->count(), first = points->strips().firstPoint(), end = points->strips().endPoint();
	impossible.assign(points->strips().count(), -1);
	ledger = StepLedger<D>(grid);
	scratch.reset(points->capacity());
	cost.allocate(points->strips().count(), int(settings.skeletons.size()), int(effects.size()));
	for (const auto& effect : effects)
		effect->start(points->fields(), first, end);
	if (content) {
		const int   failed = content->update(first, end, contentOf());
		std::string words;
		if (failed < end) words = whereabouts(*points, failed, clock.steps) + " cannot exist: " + whyImpossible(failed);
		words = context().firstWords(words);
		if (!words.empty()) throw std::invalid_argument(words);
	}
	if (heat) {
		ranks.showAll(heat->heatCapacity, heat->volume, heat->conductivity);
		heat->chooseSmoothing(grid, n);
	}
	if (front) front->start(first, end, content->iceSaturation);
	if (thawStrain) thawStrain->start(first, end, content->iceSaturation, content->iceMass);
	if (compression) compression->start(first, end, inMotion);
}

/// Nodal numbers of heat lie in the records of other effects as far as these have columns for them, so that one pass over the points serves all.
template <int D> void Ground<D>::Parts::shareRecords()
{
	using Columns = NodeColumns<D>;
	if (!heat) return;
	if (motion && Columns::Moving::carriesHeat) {
		motion->nodes.shareColumns(heat->nodes, Columns::Moving::capacity);
		heat->carriedAlong();
	}
	if (motion && Columns::Solved::carriesIncrement) motion->solved.shareColumns(heat->increment, Columns::Solved::increment);
	if (!water) return heat->receiveInOneRecord(grid);
	water->nodal.shareColumns(heat->nodal, Columns::Driving::temperature);
	water->force.shareColumns(heat->energy, Columns::Driven::heat);
	water->force.shareColumns(heat->nullSpaceResidual, Columns::Driven::nullSpace);
	if (Columns::Liquid::carriesHeat) {
		water->nodes.shareColumns(heat->nodes, Columns::Liquid::capacity);
		heat->carriedAlong();
	}
	if (Columns::Gathered::carriesIncrement) water->exchange.shareColumns(heat->increment, Columns::Gathered::increment);
}

template <int D> void Ground<D>::Parts::checkFreeSurface()
{
	if (!surface) return;
	clearNodes();
	locateInCells();
	passes.scatter(
	        passes.toGrid, [&](const WeightBlock<D>& w) { mapSurface(w); },
	        [&](HaloExchange& rows) {
		        rows.beyond = true;
		        rows.nodes(surface->nodes);
	        });
	surface->collect(grid, *cells, ranks.halo());
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b) {
		const Boundary<D>& boundary = *settings.boundaries[b];
		// a cavity may come later, with the body that makes it, and a body may come from outside
		if (!boundary.usesSurface() || boundary.region().cavities || boundary.region().kind == Region<D>::Kind::bodies) continue;
		const bool found = !surface->patch(b).nodes.empty();
		if (context().onAnyRank(found)) continue;
		throw std::invalid_argument(
		        "MpmEngine.boundaries[" + std::to_string(b) + "] = " + boundary.name() + " on " + boundary.region().describe()
		        + ": no ground there; the free surface needs at least one empty row of cells between the ground and the box, and a layer on a wall "
		          "more than one point in height; hollows that no air from above reaches are cavities");
	}
}

template <int D> double Ground<D>::Parts::largestModulus() const
{
	skeletons.tangentModulus(stepTime(), scratch.data());
	const Strips& strips  = points->strips();
	double        largest = 0.0;
	for (int p = strips.firstPoint(); p < strips.endPoint(); ++p)
		largest = std::max(largest, scratch[p]);
	if (ranks)
		for (const double ofRank : ranks.slabs()->byRank(largest))
			largest = std::max(largest, ofRank);
	return largest;
}

template <int D> void Ground<D>::Parts::beginSkeletons()
{
	for (int k = 0; k < skeletons.count(); ++k) {
		SkeletonModel<D>& model = skeletons.law(k);
		if (!ranks || !model.beginsWithAll()) {
			model.initialise(skeletons.batch(k, stepTime()));
			continue;
		}
		if (content) ranks.showAll(content->iceSaturation);
		model.initialise(skeletons.batch(skeletons.placesOfAll(k), stepTime()));
	}
}

template <int D> void Ground<D>::Parts::checkCompression()
{
	std::string words;
	for (int k = 0; k < skeletons.count() && words.empty(); ++k) {
		SkeletonBatch<D> thawed = skeletons.batch(k, stepTime());
		thawed.iceSaturation    = compression->noIce();
		skeletons.law(k).tangentModulus(thawed, compression->thawedModulus());
		for (const int p : skeletons.places(k))
			if (words.empty()) words = compression->fault(skeletons.law(k).name(), p);
	}
	words = context().firstWords(words);
	if (!words.empty()) throw std::invalid_argument(words);
}

/// In the order of places, whatever ranks there are.
template <int D> double Ground<D>::Parts::initialMass() const
{
	if (!motion) return 0.0;
	ranks.showAll(motion->mass);
	if (water) ranks.showAll(content->waterMass, content->iceMass);
	double sum = 0.0;
	for (int p = 0; p < points->count(); ++p)
		sum += motion->mass[p] + (water ? content->liquidMass(p) : 0.0);
	return sum;
}

template <int D> int Ground<D>::addPoint(const PointInput<D>& point)
{
	if (parts_->ready) throw std::logic_error("addPoint: points are added before initialise()");
	parts_->given.list.push_back(point);
	return int(parts_->given.list.size()) - 1;
}

template <int D> void Ground<D>::takePoints(int count, std::function<PointInput<D>(int)> point)
{
	parts_->given.count = count;
	parts_->given.at    = std::move(point);
}

template <int D> void Ground<D>::initialise()
{
	Parts& g = *parts_;
	if (g.ready) throw std::logic_error("initialise: the ground is initialised already");
	g.grid = Grid<D>(g.settings.lower, g.settings.upper, g.settings.gridSpacing);
	checkSettings(g.settings);
	if (g.settings.axisymmetric) {
		auto&      all   = g.settings.boundaries;
		const auto onIt  = [](const auto& b) { return b && b->name() == "RollerBoundary" && b->region().on.axis == 0 && !b->region().on.upper; };
		const bool reach = g.settings.motion && g.settings.lower[0] == 0.0; // the axis is a plane of symmetry
		if (reach && std::none_of(all.begin(), all.end(), onIt)) all.push_back(std::make_shared<RollerBoundary<D>>(Region<D>::side("left")));
		g.grid.turn();
	}
	checkBoundaries(g.settings, g.grid);
	for (const auto& b : g.settings.boundaries)
		if (b->joinsSides()) g.grid.joinSides(b->region().on.axis);
	if (!g.given.at) takePoints(int(g.given.list.size()), [&g](int id) { return g.given.list[id]; });
	checkPoints(g.settings, g.grid, g.given.count, g.given.at);
	for (int id = 0; id < g.given.count && !g.fillsCells; ++id)
		g.fillsCells = 2.0 * g.given.at(id).volume > g.grid.cellVolume();
	g.shape = makeShapeFunction<D>(g.settings.shapeFunction);
	g.declareFields();
	g.placePoints();
	g.checkFreeSurface();
	if (g.motion) {
		g.beginSkeletons();
		if (g.compression) g.checkCompression();
		if (g.bodies) g.bodies->chooseStiffness(g.largestModulus(), g.grid.spacing());
		if (g.water) g.water->chooseLargestConductivity(g.content->smallestReferencePorosity());
		if (g.calendar) g.calendar->measure(g.context(), g.inMotion, g.conducting(), nullptr, g.settings.heatFraction, g.clock.calendar);
		g.clock.initialMass = g.initialMass();
	}
	g.useScale();
	for (int p = g.points->strips().firstPoint(); g.water && p < g.points->strips().endPoint(); ++p)
		g.water->drag[p] = g.content->scaledDrag(p, g.water->drag[p], g.water->liquidFraction[p]);
	g.given.at = nullptr;
	g.given.list.clear();
	g.given.list.shrink_to_fit();
	if (g.ranks) g.ranks.keepOwnPoints();
	g.ready = true;
}

TALIK_IN_PLANE_AND_SPACE(Ground);

} // namespace talik
