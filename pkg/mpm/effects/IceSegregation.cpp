// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/HeatTransfer.hpp>
#include <pkg/mpm/effects/IceSegregation.hpp>
#include <pkg/mpm/effects/PoreContent.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/effects/ThawStrain.hpp>
#include <pkg/mpm/points/CellMeans.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

namespace {
	/// Part of its liquid that a cell gives to ice beside it in a step at most.
	constexpr double largestPart = 0.1;
} // namespace

template <int D>
IceSegregation<D>::IceSegregation(PointFields& fields, const GroundSettings<D>& settings)
        : settings_(&settings)
{
	volumeField_                    = fields.declare("segregatedVolume", "segregation", "m^D", 1);
	iceField_                       = fields.declare("segregatedIceMass", "segregation", "kg", 1);
	std::vector<SoilMaterial> given = settings.materials;
	if (given.empty()) {
		given.emplace_back();
		given.front().mixture = settings.mixture;
	}
	for (const SoilMaterial& m : given) {
		const FreezingCurve& curve = *(m.freezing ? m.freezing : settings.freezing);
		curves_.push_back(&curve);
		leastIce_.push_back(m.segregation.value_or(*settings.segregation).isGiven() ? littleIce : 0.0);
		freezingTemperature_.push_back(curve.freezingTemperature());
		soils_.emplace_back(m.segregation.value_or(*settings.segregation), curve, m.permeability.value_or(settings.water->permeability), m.mixture);
	}
	liquidDensity_ = given.front().mixture.liquid.density;
	iceDensity_    = given.front().mixture.ice.density;
}

template <int D> void IceSegregation<D>::bind(MaterialPoints<D>& points, int cells)
{
	points_ = &points;
	volume  = points.fields().component(volumeField_);
	iceMass = points.fields().component(iceField_);
	cells_.reset(cells);
	taken_.reset(points.capacity());
	opened_.reserve(points.capacity());
}

namespace {
	template <int D> Vec<D> middleOf(const Grid<D>& grid, int cell)
	{
		Vec<D> x;
		for (int a = 0; a < D; ++a)
			x[a] = grid.lower()[a] + (grid.place(cell, a) + 0.5) * grid.spacing();
		return x;
	}
} // namespace

template <int D>
void IceSegregation<D>::collect(
        const Grid<D>& grid, const CellMeans<D>& cells, const SolidMotion<D>& motion, const HeatTransfer<D>& heat, const PoreContent<D>& content,
        const ActiveRange& range)
{
	heat_ = &heat;
	ice_  = content.iceSaturation;
	std::fill(cells_.begin() + range.firstCell, cells_.begin() + range.lastCell, Cell {});
	const double* const size = points_->volume();
	points_->strips().scatter(
	        [&](int, int first, int last) {
		        int    at = -1;
		        Vec<D> middle;
		        for (int p = first; p < last; ++p) {
			        Cell& c = cells_[cells.cell(p)];
			        if (at != cells.cell(p)) middle = middleOf(grid, at = cells.cell(p));
			        const int    material = points_->material(p);
			        const double v = size[p], depth = heat.temperature[p] - freezingTemperature_[material];
			        c.volume += v;
			        c.ice += v * content.iceSaturation[p];
			        c.lenses += volume[p] * (1.0 - content.iceSaturation[p]);
			        c.depth += v * depth;
			        for (int a = 0; a < D; ++a)
				        c.middle[a] += v * points_->position(a)[p];
			        c.conductivity += v * heat.conductivity[p];
			        c.pores += v * content.porosity[p];
			        c.fill += (content.waterMass[p] - content.iceMass[p]) / liquidDensity_ + content.iceMass[p] / iceDensity_;
			        for (int k = 0; k < stressSize<D>; ++k)
				        c.stress[k] += v * motion.stress[k][p];
			        addLeaning(c, middle, grid.inverseSpacing(), motion, p);
			        c.soil = std::max(c.soil, double(material));
		        }
	        },
	        [&](HaloExchange& rows) {
		        rows.beyond = true;
		        rows.cells(cells_.data());
	        });
	range.overCells([&](int first, int last) {
		for (int i = first; i < last; ++i) {
			Cell& c = cells_[i];
			if (!(c.volume > 0.0)) continue;
			const double perVolume = 1.0 / c.volume;
			c.depth *= perVolume;
			c.frozen = c.depth < -barely && c.ice > leastIce_[int(c.soil)] * c.volume;
			c.conductivity *= perVolume;
			for (double& x : c.middle)
				x *= perVolume;
			for (double& s : c.stress)
				s *= perVolume;
		}
	});
}

/// Eq. (26.7): the force between two halves of a row of cells is the sum of V T (1 - |x|/h) over the points, with their distances x from the cell between.
/// So the splines of the nodes transmit it.
template <int D> void IceSegregation<D>::addLeaning(Cell& c, const Vec<D>& middle, double inverseSpacing, const SolidMotion<D>& motion, int p)
{
	const double v = points_->volume()[p], added = motion.addedStress[p];
	c.added += v * added;
	for (int a = 0; a < D; ++a) {
		const double away = (points_->position(a)[p] - middle[a]) * inverseSpacing;
		c.leaning[a][away > 0.0] += v * std::abs(away) * (motion.stress[stressIndex<D>(a, a)][p] + added);
	}
}

/// The cells along an axis, seen from an unfrozen one towards a side.
template <int D> struct IceSegregation<D>::Row {
	const IceSegregation& of;
	const Grid<D>&        grid;
	const ActiveRange&    range;
	int                   from, axis, side;

	/// Behind a front.
	struct Line {
		double gradient;  ///< [K/m]
		double ahead;     ///< of the front before the middle of the unfrozen cell [m]
		double coldest;   ///< temperature of the ground behind, less T_f [K]
		int    reference; ///< the cell whose heat conduction counts
	};
	struct Outside {
		double depth, heat; ///< temperature less T_f [K], NaN: none is known; heat that leaves there [W/m^2]
	};

	/// The cell beside, or -1 where there is no ground.
	int beside(int cell, int axis, int side) const
	{
		const int at = grid.place(cell, axis) + side, next = cell + side * grid.cellStride(axis);
		if (at < 0 || at == grid.cells(axis) || next < range.firstCell || next >= range.lastCell || !(of.cells_[next].volume > 0.0)) return -1;
		return next;
	}

	/// The next cell with ground behind a cell, on the way from an unfrozen one; or -1. A point that a lens has made long leaves up to two cells empty.
	int behindOf(int cell) const { return behindOf(cell, from); }
	int behindOf(int cell, int from) const
	{
		constexpr int mostEmpty = 2; // with 1 the column of 20 days has half of its ice on cells of 2.5 cm, with 4 no row changes
		const int     stride    = side * grid.cellStride(axis);
		int           at        = grid.place(cell, axis);
		for (int next = cell + stride; next != cell + (mostEmpty + 2) * stride; next += stride) {
			at += side;
			if (at < 0 || at == grid.cells(axis) || next < range.firstCell || next >= range.lastCell || (next - from) / stride > farthestBehind)
				return -1;
			if (of.cells_[next].volume > 0.0) return next;
		}
		return -1;
	}

	/// The next colder cell behind one; or -1. Temperatures of cells of one lens differ by noise.
	int colderBehind(int cell) const
	{
		int next = behindOf(cell);
		while (next >= 0 && frozen(of.cells_[next]) && !(of.cells_[next].depth < of.cells_[cell].depth))
			next = behindOf(next);
		return next >= 0 && of.cells_[next].depth < of.cells_[cell].depth ? next : -1;
	}

	/// Where the water goes that the first cell gives: the frozen cell there, the cell itself if the front stands in it and no ground lies behind, or -1.
	int destination() const
	{
		if (from < 0 || frozen(of.cells_[from])) return -1;
		const int to = behindOf(from);
		if (to < 0) return of.cells_[from].ice > 0.0 ? from : -1;
		return frozen(of.cells_[to]) ? to : -1;
	}

	/// Unit vector along the gradient of temperature, towards warmer ground.
	Vec<D> direction(int cell) const
	{
		Vec<D> n {};
		double square = 0.0;
		for (int a = 0; a < D; ++a) {
			const int    below = beside(cell, a, -1), above = beside(cell, a, 1);
			const double difference = of.cells_[above < 0 ? cell : above].depth - of.cells_[below < 0 ? cell : below].depth;
			n[a]                    = below < 0 || above < 0 ? 2.0 * difference : difference;
			square += n[a] * n[a];
		}
		for (int a = 0; a < D && square > 0.0; ++a)
			n[a] /= std::sqrt(square);
		return n;
	}

	/// Ice of both, in cells that are as frozen as ground so far below T_f [K].
	double icePart(int unfrozen, int first, double depth) const
	{
		return (of.cells_[first].ice + (unfrozen == first ? 0.0 : of.cells_[unfrozen].ice)) / (grid.cellVolume() * fullIce(first, depth));
	}

	/// How far the ground is frozen before the middle of the second frozen cell, in cells less a half. A sharp front is smeared over two cells, and their
	/// ice tells where it is; where ice forms over a range of temperatures, these do: they fall along two straight lines that meet at T_f.
	double frozenPart(int unfrozen, int first, int second) const
	{
		const double warm = std::max(0.0, of.cells_[unfrozen].depth), at = of.cells_[first].depth, behind = of.cells_[second].depth;
		const double byIce = icePart(unfrozen, first, behind);
		if (3.0 * at <= behind) return std::min(2.0, 0.5 - at / (at - behind));
		double low = 0.0, high = 1.0;
		for (int k = 0; k < 40; ++k) {
			const double x = 0.5 * (low + high), cold = 1.0 - x;
			(behind * x * x / (1.0 + 2.0 * x) + warm * cold * cold / (1.0 + 2.0 * cold) > at ? low : high) = x;
		}
		return std::max(byIce, 0.5 * (low + high));
	}

	/// How many cells behind the first one another is.
	int cellsTo(int cell) const { return (cell - from) / (side * grid.cellStride(axis)); }

	/// Ice saturation of ground so far below T_f [K], < 0.
	double fullIce(int cell, double depth) const
	{
		const int material = int(of.cells_[cell].soil);
		return 1.0 - of.curves_[material]->liquidSaturation(of.freezingTemperature_[material] + depth);
	}

	/// The wall or surface of a cell on the side.
	Outside outside(int cell) const
	{
		if (cellsTo(cell) > farthestSurface) return { NAN, 0.0 };
		int corner = 0;
		for (int a = 0; a < D; ++a)
			corner += (grid.place(cell, a) + 1 + (a == axis && side > 0)) * grid.nodeStride(a); // node 0 is a ghost
		double area = 0.0, sum = 0.0, heat = 0.0;
		for (int k = 0; k < 1 << D; ++k) {
			if (k >> axis & 1) continue; // the nodes of the face
			int node = corner;
			for (int a = 0; a < D; ++a)
				node += (k >> a & 1) * grid.nodeStride(a);
			const double* const at     = of.heat_->outside[node];
			const double        facing = side * at[axis];
			if (!(facing > 0.0)) continue;
			area += facing;
			sum += facing * at[D + 1] / at[D];
			heat += facing * at[D + 2] / at[D];
		}
		if (!(area > 0.0)) return { NAN, 0.0 };
		return { sum / area - of.freezingTemperature_[int(of.cells_[cell].soil)], heat / area };
	}

	/// Eq. (26.6). Behind a front in the cell at a wall or surface: from its temperature to T_f at the front, whose depth the ice tells. No thinner than
	/// that quarter of a cell through which heat leaves, and no more than the heat that does.
	Line atSurface(int first) const
	{
		const auto [cold, heat] = outside(first);
		const double h          = grid.spacing();
		if (!(cold < 0.0 && heat > 0.0)) return { 0.0, 0.0, 0.0, first };
		const double part  = icePart(from, first, cold);
		const double front = placeOfFront(first, part);
		const double thick = part + (of.cells_[first].lenses + (from == first ? 0.0 : of.cells_[from].lenses)) / grid.cellVolume();
		const double slope = std::min(-cold / (h * std::max(thick, 0.25)), heat / of.cells_[first].conductivity);
		return { slope, std::max(0.0, side * (front - of.cells_[from].middle[axis])), cold, first };
	}

	/// Where a front lies along an axis.
	double placeOfFront(int cell, double part) const
	{
		const int row = grid.place(cell, axis) + (side > 0);
		return grid.lower()[axis] + (row - side * part) * grid.spacing();
	}

	/// The gradient of temperature behind a front: of the straight line from there that fits the cells behind, which have no part in the front. Where ice
	/// forms over a range of temperatures, the front for this is where most of it has formed.
	Line behind(int first) const
	{
		constexpr int most     = 3; // cells of the line
		int           unfrozen = from;
		int           second   = colderBehind(first);
		if (behindOf(first) < 0 && (unfrozen == first || !std::isnan(outside(first).depth))) return atSurface(first);
		const bool   falls = second >= 0;
		const double h     = grid.spacing(),
		             part  = falls ? frozenPart(unfrozen, first, second) : std::max(0.25, icePart(unfrozen, first, 2.0 * of.cells_[first].depth));
		double       front = placeOfFront(first, part);
		const double ahead = std::max(0.0, side * (front - of.cells_[unfrozen].middle[axis]));
		if (!falls) {
			// warmer ground behind it, or an end that takes no heat: the frozen part has one gradient, which in ground that is warm in front is no
			// larger than that of both
			const double warm = of.cells_[unfrozen].depth, cold = of.cells_[first].depth, within = -2.0 * cold / (h * part * part);
			return { warm > 0.0 ? std::min(within, (warm - cold) / h) : within, ahead, cold, first };
		}
		const int  reference = second;
		const auto formsIce  = [&](int third) { // in the second
                        return third >= 0 && !(of.cells_[second].ice > 0.5 * of.cells_[second].volume * fullIce(second, of.cells_[third].depth));
		};
		for (int third; formsIce(third = colderBehind(second));) {
			unfrozen = first;
			first    = second;
			second   = third;
			front    = placeOfFront(first, frozenPart(unfrozen, first, second));
		}
		double moment = 0.0, square = 0.0, coldest = 0.0;
		for (int c = second, k = 0; k < most && c >= 0; ++k, c = colderBehind(c)) {
			const double distance = side * (of.cells_[c].middle[axis] - front);
			coldest               = of.cells_[c].depth;
			moment -= coldest * distance;
			square += distance * distance;
		}
		return { moment / square, ahead, coldest, reference };
	}

	/// -n T n for the stress T that the grid transmits through a cell along the axis.
	double transmitted(int cell, const Vec<D>& n) const
	{
		const Cell& c = of.cells_[cell];
		// at an end the cell is filled in part, and the stress of its points is that of the surface
		const bool ends   = beside(cell, axis, -side) < 0 || behindOf(cell, cell) < 0;
		const int  stride = grid.cellStride(axis);
		double     sum    = 0.0;
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D; ++j) {
				const int k = stressIndex<D>(i, j);
				double    t = c.volume * c.stress[k] + (i == j ? c.added : 0.0);
				if (!ends && i == axis && j == axis)
					t += of.cells_[cell - stride].leaning[axis][1] + of.cells_[cell + stride].leaning[axis][0] - c.leaning[axis][0]
					        - c.leaning[axis][1];
				sum -= n[i] * t * n[j];
			}
		return sum / (ends ? c.volume : grid.cellVolume());
	}

	/// Total pressure normal to a front, of the cells at it. In cells that are not full of points force is in balance, and stress is not.
	double pressureOn(int to) const
	{
		Vec<D> n {};
		if (from == to) n[axis] = 1.0;
		else n = direction(to);
		return 0.5 * (transmitted(from, n) + transmitted(to, n));
	}

	/// The cell that gives a front half of its water, the one before the last unfrozen cell; or -1: that cell gives all.
	/// Pressures alternate from cell to cell around a cell that alone loses water, as the nodes hardly see that. So two cells give it, and the mean of
	/// their pressures counts.
	int secondSource() const
	{
		const int next = beside(from, axis, -side);
		return next < 0 || frozen(of.cells_[next]) ? -1 : next;
	}

	/// The cell with the lens of a front, whose temperature less T_f is lens [K]: the first frozen one or one behind it. Ground behind a lens has one
	/// gradient, and the lens lies on its line.
	int cellOfLens(int first, double lens, double gradient) const
	{
		int        cell = first;
		const auto at   = [&](int next) { return of.cells_[next].depth + gradient * side * (of.cells_[next].middle[axis] - placeOfFront(next, 1.0)); };
		for (int next; (next = colderBehind(cell)) >= 0 && cellsTo(next) < farthestBehind && at(next) > lens;) // at the face of the next cell
			cell = next;
		return cell;
	}

	/// The front seen from a lens that lies in a cell behind the first frozen one. Unchanged where nothing is known of the ground behind it.
	/// Near a surface, where cells are filled in part, the heat that leaves there tells the gradient; of surfaces ranks know less far than of cells.
	void seeFrom(int lens, SegregationPotential::Front& front) const
	{
		const int     next = colderBehind(lens), second = next < 0 ? -1 : colderBehind(next);
		const int     last      = second >= 0 ? second : next >= 0 ? next : lens;
		const bool    atSurface = behindOf(last) < 0;
		const Outside beyond    = atSurface ? outside(last) : Outside { NAN, 0.0 };
		const bool    known     = !std::isnan(beyond.depth);
		if (!known && second < 0) return;
		front.gradient = known
		        ? beyond.heat / of.cells_[last].conductivity
		        : (of.cells_[next].depth - of.cells_[second].depth) / (side * (of.cells_[second].middle[axis] - of.cells_[next].middle[axis]));
		front.ice      = fullIce(lens, next < 0 ? front.coldest : of.cells_[next].depth);
	}

	/// That comes through the unfrozen ground to the front [W/m^2]. The last unfrozen cell may have its temperature from ice in it.
	double heatBefore() const
	{
		const int next = beside(from, axis, -side);
		if (next < 0) return 0.0;
		const int    before = beside(next, axis, -side), warm = before < 0 ? next : before, cold = before < 0 ? from : next;
		const double distance = side * (of.cells_[cold].middle[axis] - of.cells_[warm].middle[axis]);
		return of.cells_[warm].conductivity * std::max(0.0, (of.cells_[warm].depth - of.cells_[cold].depth) / distance);
	}

	/// Water that the first cell and its second source give in the step to the one with the lens, eq. (26.4): 0 unless a front lies beside it.
	Flux drawn(const PoreWater<D>& water, const Vec<D>& weight, double dt) const
	{
		const int first = destination();
		if (first < 0) return { 0.0, -1 };
		const SegregationPotential& soil = of.soils_[int(of.cells_[first].soil)];
		if (soil.drawsNothing()) return { 0.0, -1 };
		const Line                  line   = behind(first);
		const int                   second = secondSource();
		const double                ahead  = second < 0 ? 0.0 : 0.5 * side * (of.cells_[from].middle[axis] - of.cells_[second].middle[axis]);
		SegregationPotential::Front f {};
		f.gradient     = line.gradient;
		f.conductivity = of.cells_[line.reference].conductivity;
		f.coldest      = line.coldest;
		f.distance     = line.ahead + ahead;
		f.rise         = -side * f.distance * weight[axis];
		f.pressure     = 0.5 * (water.pressureOfCell(from) + water.pressureOfCell(second < 0 ? from : second));
		f.load         = pressureOn(first);
		f.unfrozen     = heatBefore() / f.conductivity;
		f.ice          = fullIce(line.reference, line.coldest);
		auto intake    = soil.intake(f);
		int  lens      = first;
		// what stands behind the lens depends on where it lies, which depends on that
		for (int k = 0; k < 2 && first != from && intake.lens < 0.0; ++k) {
			lens = cellOfLens(first, intake.lens, f.gradient);
			if (lens == first) break;
			seeFrom(lens, f);
			const auto seen = soil.intake(f);
			intake          = { seen.water, seen.lens < 0.0 ? seen.lens : intake.lens };
		}
		// ground that has run dry in part lets as much less of its water go as anywhere
		const double full  = std::min(1.0, of.cells_[from].fill / of.cells_[from].pores);
		const double least = std::min(water.liquidOfCell(from), second < 0 ? HUGE_VAL : water.liquidOfCell(second));
		return { std::min(of.liquidDensity_ * dt * grid.faceArea() * full * full * full * intake.water, largestPart * least), lens };
	}
};

template <int D>
void IceSegregation<D>::draw(
        const Grid<D>& grid, const ActiveRange& range, PoreWater<D>& water, const EnthalpyModel& enthalpy, const Vec<D>& gravity, double dt)
{
	const double size = lengthOf<D>(gravity);
	Vec<D>       down {};
	for (int a = 0; a < D && size > 0.0; ++a)
		down[a] = gravity[a] / size;
	const double strength = size / Permeability::gravity;
	for (double& component : down)
		component *= strength; // heads are those of the earth's gravity
	range.overCells([&](int firstCell, int lastCell) {
		for (int i = firstCell; i < lastCell; ++i) {
			Cell& c = cells_[i];
			if (!(c.volume > 0.0) || frozen(c)) continue;
			for (int a = 0; a < D; ++a)
				for (const int side : { -1, 1 }) {
					const Flux flux              = Row { *this, grid, range, i, a, side }.drawn(water, down, dt);
					c.fluxes[2 * a + (side > 0)] = flux;
					c.lost += flux.mass;
				}
		}
	});
	handOver(grid, range, water, enthalpy);
	range.overCells([&](int firstCell, int lastCell) {
		for (int i = firstCell; i < lastCell; ++i) {
			Cell& c = cells_[i];
			if (c.lost > 0.0) water.give(i, c.lost, enthalpy);
			if (!(c.mass > 0.0)) continue;
			c.opened = c.mass / (iceDensity_ * c.volume);
			Vec<D> n;
			if (frozen(c)) n = Row { *this, grid, range, i, 0, 1 }.direction(i);
			else {
				double square = 0.0;
				for (const double part : c.across)
					square += part * part;
				for (int k = 0; k < D; ++k)
					n[k] = square > 0.0 ? c.across[k] / std::sqrt(square) : 0.0;
			}
			std::copy(n.begin(), n.end(), c.normal);
		}
	});
}

template <int D> void IceSegregation<D>::handOver(const Grid<D>& grid, const ActiveRange& range, const PoreWater<D>& water, const EnthalpyModel& enthalpy)
{
	for (int i = range.firstCell; i < range.lastCell; ++i) {
		if (!(cells_[i].lost > 0.0)) continue;
		for (int k = 0; k < 2 * D; ++k) {
			const auto [mass, to] = cells_[i].fluxes[k];
			if (!(mass > 0.0)) continue;
			const int    second = Row { *this, grid, range, i, k / 2, k % 2 ? 1 : -1 }.secondSource();
			const double half   = second < 0 ? 0.0 : 0.5 * mass;
			Cell&        c      = cells_[to];
			c.mass += mass;
			c.across[k / 2] += (k % 2 ? 1.0 : -1.0) * mass;
			const auto carry = [&](int source, double part) {
				const Vec<D> v = water.velocityOfCell(source);
				c.enthalpy += part * water.enthalpyOfCell(source, enthalpy);
				for (int a = 0; a < D; ++a)
					c.carried[a] += part * v[a];
			};
			carry(i, mass - half);
			if (second < 0) continue;
			carry(second, half);
			cells_[i].lost -= half;
			cells_[second].lost += half;
		}
	}
}

/// What the water that is drawn does to the works: it leaves at one pressure and height and comes in at others, and its ice parts grains that press
/// on each other. All of that is work of suction.
template <int D> void IceSegregation<D>::book(const ActiveRange& range, const PoreWater<D>& water, StepLedger<D>& ledger) const
{
	for (int i = range.firstCell; i < range.lastCell; ++i) {
		const Cell& c = cells_[i];
		if (c.mass == 0.0 && c.lost == 0.0) continue;
		StepAccount<D>& account = ledger.ofCell(i);
		const double    taken = c.mass - c.lost, stored = water.pressureOfCell(i) * taken / liquidDensity_;
		double          parted = 0.0;
		for (int k = 0; k < D; ++k)
			for (int l = 0; l < D; ++l)
				parted -= c.normal[k] * c.stress[stressIndex<D>(k, l)] * c.normal[l] * c.opened * c.volume;
		account.waterDrawn += c.mass;
		account.porePressureWork += stored;
		account.skeletonWork += parted;
		account.segregationWork += stored + parted + water.heightOfCell(i) * taken / liquidDensity_;
	}
}

template <int D> void IceSegregation<D>::receive(const CellMeans<D>& cells, int first, int last, double* waterMass, double* enthalpy, PoreWater<D>& water)
{
	const double* const size = points_->volume();
	for (int p = first; p < last; ++p) {
		const Cell& c = cells_[cells.cell(p)];
		if (!(c.mass > 0.0) || !(ice_[p] > 0.0)) continue;
		const double part = size[p] * ice_[p] / c.ice, mass = part * c.mass;
		Vec<D>       carried;
		for (int a = 0; a < D; ++a)
			carried[a] = part * c.carried[a];
		water.mixIn(p, mass, carried);
		waterMass[p] += mass;
		enthalpy[p] += part * c.enthalpy;
		volume[p] += mass / iceDensity_;
		taken_[p] = mass / iceDensity_;
	}
}

template <int D> void IceSegregation<D>::shareVolume(const CellMeans<D>& cells, int first, int last)
{
	double* const size = points_->volume();
	for (int p = first; p < last; ++p) {
		const Cell& c = cells_[cells.cell(p)];
		if (!(c.opened > 0.0)) continue;
		size[p] += taken_[p] - c.opened * size[p];
		taken_[p] = 0.0;
	}
}

template <int D> void IceSegregation<D>::release(ThawStrain<D>& thawStrain)
{
	const Strips& strips = points_->strips();
	for (int p = strips.firstPoint(); p < strips.endPoint(); ++p) {
		if (!(volume[p] > 0.0) || iceMass[p] > 0.0) continue;
		thawStrain.addRoom(p, volume[p]);
		volume[p] = 0.0;
	}
}

template <int D> void IceSegregation<D>::part(const CellMeans<D>& cells, SolidMotion<D>& motion)
{
	const Strips& strips = points_->strips();
	for (int p = strips.firstPoint(); p < strips.endPoint(); ++p) {
		const Cell& c = cells_[cells.cell(p)];
		if (!(c.opened > 0.0)) continue;
		Vec<D> normal;
		std::copy(std::begin(c.normal), std::end(c.normal), normal.begin());
		opened_.add(motion.gradient, p, -c.opened, normal);
	}
}

TALIK_IN_PLANE_AND_SPACE(IceSegregation);

} // namespace talik
