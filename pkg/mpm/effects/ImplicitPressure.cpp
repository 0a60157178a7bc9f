// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/ImplicitPressure.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace talik {

namespace {
	/// The residual, in the norm of the energy of the pressure that is still to come, at which iterations end: over that of the start, and over the
	/// pressure that stands. What is left is in the content of the next step.
	constexpr double relativeResidual = 1e-2, smallestResidual = 1e-6;
	constexpr int    mostIterations = 500, mostRounds = 4;
	/// Of what the inertia of the ground lets a cell give way in a step, the share that alternating pressures store.
	constexpr double checkerboardPart = 0.25;
	/// The way of water through a cell is as long at least as in one that is filled so far [-].
	constexpr double leastFill = 0.01;
	/// Inertia of the liquid over its drag within a step [-]: of a difference between the velocities of liquid and grains this part is left.
	constexpr double leftOfDifference = 1e-9;
} // namespace

template <int D> ImplicitPressure<D>::ImplicitPressure(PointFields& fields)
{
	fields.declare("seepageVelocity", "water", "m/s", seepage);
	fields.declare("groundAcceleration", "water", "m/s^2", acceleration_);
}

template <int D> void ImplicitPressure<D>::bind(MaterialPoints<D>& points, const std::array<double*, D>& solidVelocity)
{
	for (int a = 0; a < D; ++a) {
		velocity_[a] = solidVelocity[a];
		startVelocity_[a].reset(points.capacity());
	}
}

template <int D> void ImplicitPressure<D>::allocate(const Grid<D>& grid, bool fed)
{
	const int n = grid.cellCount();
	cells_.reset(n);
	links_.reset(std::size_t(n) * corners * D);
	fed_ = fed;
	if (fed_) liquids_.reset(std::size_t(n) * corners);
	baseNodes_.reset(n);
	squares_.reset(n);
	grid_ = &grid;
	for (auto& faces : faces_)
		faces.reset(n);
	for (auto* values : { &change_, &residual_, &initial_, &direction_, &image_, &preconditioned_ })
		values->reset(n);
	multigrid_.allocate(grid);
	for (auto* field : { &response_, &force_, &moved_ })
		field->allocate(grid.nodeCount());
	open_.assign(grid.nodeCount(), Vec<D> {});
	for (int a = 0; a < D; ++a)
		for (auto* beside : { &next_[a], &before_[a] }) {
			beside->reset(n);
			for (int c = 0; c < n; ++c)
				(*beside)[c] = grid.neighbour(c, a, beside == &next_[a] ? 1 : -1);
		}
	for (int c = 0; c < n; ++c) {
		baseNodes_[c] = 0;
		for (int a = 0; a < D; ++a)
			baseNodes_[c] += grid.place(c, a) * grid.nodeStride(a);
	}
	std::iota(byStride_.begin(), byStride_.end(), 0);
	std::sort(byStride_.begin(), byStride_.end(), [&](int a, int b) { return grid.nodeStride(a) > grid.nodeStride(b); });
	for (int k = 0; k < D; ++k) {
		const int a = byStride_[D - 1 - k];
		strides_[a] = grid.nodeStride(a);
		step_[a]    = 1 << (2 * k);
	}
	for (int k = 0; k < corners; ++k) {
		nodeOffset_[k] = inward_[k] = 0;
		for (int a = 0; a < D; ++a) {
			nodeOffset_[k] += k / step_[a] % 4 * strides_[a];
			inward_[k] += std::clamp(k / step_[a] % 4, 1, 2) * step_[a];
		}
	}
	for (int k = 0; k < corners / 4; ++k)
		rowOffset_[k] = nodeOffset_[4 * k];
	for (int k = 0; k < supportCount<D>; ++k) {
		within_[k] = 0;
		for (int a = 0, rest = k; a < D; ++a, rest /= supportNodes)
			within_[k] += rest % supportNodes * step_[a];
	}
}

template <int D> void ImplicitPressure<D>::clear(const ActiveRange& range)
{
	range.overCells([&](int first, int last) {
		std::fill(cells_.begin() + first, cells_.begin() + last, Cell {});
		if (fed_) std::fill(liquids_.data() + std::size_t(first) * corners, liquids_.data() + std::size_t(last) * corners, 0.0);
	});
}

template <int D>
void ImplicitPressure<D>::addContent(
        const MaterialPoints<D>& points, const CellMeans<D>& cells, const PoreContent<D>& content, const PoreWater<D>& water, const double* temperature,
        int first, int last)
{
	const double* volume = points.volume();
	content.overFills(first, last, temperature, [&](int p, double excess, double compliance) {
		Cell&        c    = cells_[cells.cell(p)];
		const double mass = content.liquidMass(p);
		c.liquidMass += mass;
		c.drag += water.drag[p];
		const double opens = mass * mass / water.drag[p];
		c.open += opens;
		c.opensWell += opens * opens / volume[p];
		if (content.iceMass) {
			c.ice += content.iceMass[p];
			c.thawed += content.iceMass[p] > 0.0 ? volume[p] * content.thawedOpening(p) : opens;
		}
		c.excess += excess;
		c.compliance += compliance;
		c.pressure += volume[p] * water.pressure[p];
		c.temperature += temperature ? mass * temperature[p] : 0.0;
		c.carried += mass * ofPoint<D>(water.velocity, p);
		const double ofPlane = volume[p] / grid_->measureAt(points.at(p)[0]);
		c.ofPlane += ofPlane;
		c.middle += ofPlane * points.at(p);
		c.place += mass * points.at(p);
		c.weight += -mass * ofPoint<D>(acceleration_, p);
		for (int a = 0; a < D; ++a)
			startVelocity_[a][p] = velocity_[a][p];
	});
}

template <int D> int ImplicitPressure<D>::cornerOf(int cell, int node) const
{
	int shift = node - baseNodes_[cell], at = 0;
	for (const int a : byStride_)
		while (shift >= strides_[a]) {
			shift -= strides_[a];
			at += step_[a];
		}
	return at;
}

template <int D> void ImplicitPressure<D>::map(const WeightBlock<D>& w, const CellMeans<D>& cells, const PoreContent<D>& content)
{
	for (int k = 0; k < w.count; ++k) {
		const int     p = w.first + k, c = cells.cell(p), at = cornerOf(c, w.base[k]);
		const double  mass   = content.liquidMass(p);
		double* const liquid = liquids_.data() + std::size_t(c) * corners;
		int           node   = 0;
		overNodes<D>(w, k, [&](int, double s, const Vec<D>&) { liquid[at + within_[node++]] += mass * s; });
	}
}

template <int D>
void ImplicitPressure<D>::findLinks(const StepContext<D>& step, const CellMeans<D>& cells, const ShapeFunction<D>& shape, const PoreWater<D>& water)
{
	constexpr int  atOnce = blockSize / 2;
	const Grid<D>& grid   = step.grid;
	step.halo.overCells([&](int first, int last) {
		double                       places[D][blockSize], parts[D][blockSize];
		std::array<const double*, D> x;
		for (int a = 0; a < D; ++a)
			x[a] = places[a];
		std::array<int, atOnce> of {};
		int                     count = 0;
		WeightBlock<D>          w;
		const auto              link = [&] {
                        shape.evaluate(grid, x, 0, 2 * count, w);
                        for (int k = 0; k < count; ++k)
                                linkCell(of[k], w, 2 * k, parts, grid.isTurned() ? places[0] : nullptr, water);
                        count = 0;
		};
		for (int c = first; c < last; ++c) {
			Cell& cell  = cells_[c];
			cell.volume = cells.cellVolume(c);
			if (!(cell.volume > 0.0)) continue;
			cell.fill = std::min(1.0, filledBy(c));
			findMiddle(c);
			of[count]            = c;
			const double measure = grid.measureAt(grid.middle(c) + grid_->spacing() * cell.middle[0]);
			for (int a = 0; a < D; ++a) {
				// slopes of shape functions have kinks in the middle of the cell
				const double middle = cell.middle[a], half = std::max(0.5 * cell.fill, 0.5 - std::abs(middle)),
				             kink = std::clamp(0.0, middle - half, middle + half);
				for (const int side : { 0, 1 }) {
					const double end            = middle + (side ? half : -half);
					parts[a][2 * count + side]  = 0.5 * std::abs(end - kink) / half;
					places[a][2 * count + side] = grid.lower()[a] + grid_->spacing() * (grid.place(c, a) + 0.5 + 0.5 * (kink + end));
					if (a == 0) parts[a][2 * count + side] *= grid.measureAt(places[a][2 * count + side]) / measure;
				}
			}
			if (++count == atOnce) link();
		}
		if (count > 0) link();
	});
}

/// Means over the 2^D places of a cell. They are products of means over two places along each axis, those of points k and k + 1 of a block, to which
/// these parts of the ground belong. radius: of these places about an axis, where the divergence has S/r, too, else null.
template <int D>
void ImplicitPressure<D>::linkCell(int c, const WeightBlock<D>& w, int k, const double (&parts)[D][blockSize], const double* radius, const PoreWater<D>& water)
{
	double value[D][4] = {}, slope[D][4] = {};
	for (int at = k; at < k + 2; ++at) {
		const int corner = cornerOf(c, w.base[at]);
		for (int a = 0; a < D; ++a)
			for (int i = 0; i < supportNodes; ++i) {
				value[a][corner / step_[a] % 4 + i] += parts[a][at] * w.value[a][i][at];
				slope[a][corner / step_[a] % 4 + i] += parts[a][at] * w.slope[a][i][at];
				if (radius && a == 0) slope[a][corner / step_[a] % 4 + i] += parts[a][at] / radius[at] * w.value[a][i][at];
			}
	}
	double* const b = link(c);
	double        volumes[corners];
	for (int n = 0; n < corners; ++n) {
		volumes[n] = cells_[c].volume;
		for (int a = 0; a < D; ++a)
			volumes[n] *= value[a][n / step_[a] % 4];
		for (int a = 0; a < D; ++a) {
			b[n * D + a] = cells_[c].volume;
			for (int i = 0; i < D; ++i)
				b[n * D + a] *= (i == a ? slope : value)[i][n / step_[i] % 4];
		}
	}
	foldLinks(c, volumes, water);
}

/// The few points of a cell may reach fewer nodes than its volume does. What a node lacks of the volume that the cell has there [m^D] moves with the
/// nearest node of the cell itself, to which all of its points give mass. So forces add up to nothing, none is lost, and none accelerates a trace.
template <int D> void ImplicitPressure<D>::foldLinks(int c, const double* volumes, const PoreWater<D>& water)
{
	double* const b = link(c);
	for (int k = 0; k < corners; ++k) {
		const double there = water.nodes[baseNodes_[c] + nodeOffset_[k]][PoreWater<D>::volumeAt];
		if (k == inward_[k] || there >= volumes[k]) continue;
		const double lacks = 1.0 - there / volumes[k];
		for (int a = 0; a < D; ++a) {
			b[inward_[k] * D + a] += lacks * b[k * D + a];
			b[k * D + a] -= lacks * b[k * D + a];
		}
	}
}

// ---- flow between cells ---------------------------------------------------------------------------------------------------

template <int D> void ImplicitPressure<D>::tieLiquid(const StepContext<D>& step, PoreWater<D>& water)
{
	step.halo.eachNode([&](int i) {
		water.nodes[i][PoreWater<D>::dragAt] = water.nodes[i][PoreWater<D>::massAt] / (leftOfDifference * step.dt);
		std::fill_n(water.force[i], D, 0.0);
	});
}

/// work(node, corner) for the nodes at the corners of a cell; bit a of a corner is set on the upper side along axis a.
template <int D> template <class Work> void ImplicitPressure<D>::overCorners(int cell, Work&& work) const
{
	for (int k = 0; k < 1 << D; ++k) {
		int node = baseNodes_[cell];
		for (int a = 0; a < D; ++a)
			node += (1 + (k >> a & 1)) * strides_[a];
		work(node, k);
	}
}

/// Pressure by which the weight of water drives it between the middles of the liquid of two cells, of which the second is farther away along an axis by
/// some way than its place says [Pa].
template <int D> double ImplicitPressure<D>::weightBetween(const Cell& from, const Cell& to, int axis, double farther)
{
	double sum = 0.0;
	for (int a = 0; a < D; ++a)
		sum += 0.5 * (from.weight[a] + to.weight[a]) * (to.place[a] - from.place[a] + (a == axis ? farther : 0.0));
	return sum;
}

/// Mobility of the half of a cell before its neighbour. What has thawed in a cell lies on the side of the thawed neighbour: a layer whose water has
/// but its own thickness to go.
template <int D> double ImplicitPressure<D>::wayFrom(const Cell& cell, const Cell& neighbour)
{
	if (cell.part > 0.0 && (cell.part == 1.0 || neighbour.ice == 0.0 || neighbour.part == 1.0)) return cell.layer;
	if (neighbour.mobility < cell.mobility) return cell.mobility;
	return cell.mobility < PoreWater<D>::tight * neighbour.mobility ? cell.layer : cell.open;
}

/// The cell so many further along an axis, if it holds water; else -1.
template <int D> int ImplicitPressure<D>::wetCell(const ActiveRange& range, int cell, int axis, int by) const
{
	for (; by != 0 && cell >= range.firstCell && cell<range.lastCell; by -= by> 0 ? 1 : -1)
		cell = by > 0 ? next_[axis][cell] : before_[axis][cell];
	return cell >= range.firstCell && cell < range.lastCell && cells_[cell].state != none ? cell : -1;
}

/// Part of a cell that the thawed layer takes whose ground lies in front of it along an axis, and frozen ground behind it. A front melts points of the
/// two cells behind it, too, because nodes are warmed on both sides of it: what has melted in the first three cells with ice is a layer that begins at
/// the thawed ground. The first two see the same three cells. So the front goes on evenly, and passes from cell to cell without a jump.
template <int D> double ImplicitPressure<D>::thawedPart(const ActiveRange& range, int c, int axis, int side) const
{
	const auto next       = [&](int by) { return wetCell(range, c, axis, by * side); };
	const auto liquidPart = [&](int at) { return cells_[at].liquidMass / (cells_[at].liquidMass + cells_[at].ice); };
	const int  before = next(1), behind = next(-1);
	if (before < 0 || behind < 0 || liquidPart(behind) >= liquidPart(c)) return 0.0;
	const bool first  = cells_[before].ice == 0.0;
	double     frozen = 1.0;
	for (int k = 1; k <= (first ? 3 : 2) && next(-k) >= 0; ++k)
		frozen = std::min(frozen, liquidPart(next(-k)));
	const auto thawed = [&](int at) { return at < 0 ? 0.0 : (liquidPart(at) - frozen) / (1.0 - frozen); };
	if (first) return std::min(1.0, thawed(c) + thawed(behind) + thawed(next(-2)));
	if (next(2) < 0 || cells_[next(2)].ice > 0.0 || liquidPart(before) <= liquidPart(c)) return 0.0;
	return std::clamp(thawed(before) + thawed(c) + thawed(behind) - 1.0, 0.0, 1.0);
}

/// Cells that a thaw front passes, and the pressure of their thawed layer, eq. (7.6).
template <int D> void ImplicitPressure<D>::findLayers(const ActiveRange& range)
{
	range.eachCell([&](int c) {
		Cell& cell = cells_[c];
		if (cell.state == none || cell.ice == 0.0) return;
		double frozenPressure = 0.0, lowest = cell.pressure;
		for (int a = 0; a < D; ++a)
			for (const int side : { -1, 1 }) {
				const double weight = side * cell.weight[a] * grid_->spacing();
				if (const int before = wetCell(range, c, a, side); before >= 0) lowest = std::min(lowest, cells_[before].pressure - weight);
				const double part = thawedPart(range, c, a, side);
				if (part <= cell.part) continue;
				cell.part      = part;
				frozenPressure = cells_[wetCell(range, c, a, -side)].pressure + weight;
			}
		if (cell.part == 0.0) return;
		cell.layer           = cell.thawed / cell.part;
		const double inLayer = (cell.pressure - (1.0 - cell.part) * frozenPressure) / cell.part;
		cell.drivingExcess   = frozenPressure <= cell.pressure ? 0.0 : std::max(lowest, inLayer) - cell.pressure;
	});
}

/// Middle of the ground of a cell, when its volume is known. A cell that is filled has it in its own middle, wherever its points lie, and what is not
/// filled can move it by no more than half of its height.
template <int D> void ImplicitPressure<D>::findMiddle(int c)
{
	Cell&        cell = cells_[c];
	const double most = 0.5 * (1.0 - cell.fill);
	for (int a = 0; a < D; ++a) {
		const double place = (cell.middle[a] / cell.ofPlane - grid_->lower()[a]) * grid_->inverseSpacing();
		cell.middle[a]     = std::clamp(place - grid_->place(c, a) - 0.5, -most, most);
	}
}

/// Part of the face of a cell on one side of an axis that its ground covers, if the section of the ground changes evenly along the axis, eq. (7.9).
template <int D> double ImplicitPressure<D>::section(const Cell& cell, int axis, int side) const
{
	return std::clamp(cell.fill * (1.0 + 6.0 * side * cell.middle[axis]), 0.0, 1.0);
}

/// Part of a face of a cell behind which there is ground, or the box.
template <int D> double ImplicitPressure<D>::coveredAt(const ActiveRange& range, int c, int axis, int side) const
{
	const int next = side > 0 ? next_[axis][c] : before_[axis][c];
	if (next < 0) return section(cells_[c], axis, side);
	return next < range.firstCell || next >= range.lastCell ? 0.0 : faces_[axis][side > 0 ? c : next].covered;
}

template <int D> void ImplicitPressure<D>::findFaces(const ActiveRange& range)
{
	for (int a = 0; a < D; ++a)
		range.eachCell([&](int c) {
			Face& f = faces_[a][c];
			f       = {};
			if (!hasNext(range, c, a)) return;
			const Cell &here = cells_[c], &there = cells_[next_[a][c]];
			if (here.state == none || there.state == none) return;
			// a plane that cuts both leaves no less of their face than of the emptier one
			f.covered = std::max({ section(here, a, 1), section(there, a, -1), std::min(here.fill, there.fill) });
			if (!(here.mobility > 0.0 && there.mobility > 0.0)) return;
			const double from = wayFrom(here, there), to = wayFrom(there, here);
			const double before = 0.5 - here.middle[a], behind = 0.5 + there.middle[a], farther = std::max(1.0, leastFill / (before + behind));
			f.conductance = grid_->faceArea() / grid_->spacing() * f.covered / (farther * (before / from + behind / to))
			        * grid_->measureOfFace(c, a);
			const double goesOn = next_[a][c] <= c ? grid_->width(a) : 0.0; // behind a periodic side places go on
			f.weight            = weightBetween(here, there, a, goesOn) + here.drivingExcess - there.drivingExcess;
		});
}

/// What the faces of a cell leave uncovered. The divergence theorem gives its area and, as the volume of a pyramid, its distance from the middle of
/// the ground; both are exact where the surface is a plane. Points that hold more ground than a cell, as two rows that have moved together, reach
/// beyond it.
template <int D> typename ImplicitPressure<D>::Surface ImplicitPressure<D>::surfaceIn(const ActiveRange& range, int c) const
{
	const Cell& cell = cells_[c];
	Surface     s {};
	double      pyramid = 0.0;
	for (int a = 0; a < D; ++a) {
		const double low = coveredAt(range, c, a, -1), high = coveredAt(range, c, a, 1);
		s.area[a] = low - high;
		pyramid += cell.fill - low * (0.5 + cell.middle[a]) - high * (0.5 - cell.middle[a]);
	}
	const double area = lengthOf<D>(s.area);
	s.distance        = area > 0.0 ? pyramid / area * std::max(1.0, filledBy(c)) : 0.0;
	return s;
}

template <int D> void ImplicitPressure<D>::beginFlow(const StepContext<D>& step, const PoreWater<D>& water)
{
	const ActiveRange& range = step.halo;
	const double       dt = step.dt, liquidDensity = water.liquid.density;
	lowest_ = water.settings->state.cavitationPressure;
	range.eachCell([&](int c) {
		Cell& cell = cells_[c];
		if (!(cell.liquidMass > 0.0 && cell.compliance > 0.0)) return;
		const double liquid = cell.liquidMass / liquidDensity;
		cell.mobility       = liquid * liquid / (cell.volume * cell.drag);
		// the part of the cell that is open, as if it were open evenly and the rest closed
		const double part = cell.open * cell.open / (cell.volume * cell.opensWell);
		cell.open /= liquidDensity * liquidDensity * cell.volume;
		cell.layer = cell.open / (part * part);
		cell.thawed /= liquidDensity * liquidDensity * cell.volume;
		cell.pressure /= cell.volume;
		cell.temperature /= cell.liquidMass;
		cell.place         = cell.place / cell.liquidMass;
		cell.weight        = water.weight + liquidDensity * cell.weight / cell.liquidMass;
		cell.recent        = -std::expm1(-dt * cell.drag / cell.liquidMass);
		cell.drivingExcess = water.drivingExcess(c);
		cell.state         = cell.pressure > lowest_ || cell.excess > cell.compliance * lowest_ ? wet : cavitated;
		cell.base          = cell.state == cavitated ? lowest_ : cell.pressure;
	});
	findSquares(range);
	findLayers(range);
	findFaces(range);
	exposed_.clear();
	for (int c = step.owned.firstCell; c < step.owned.lastCell; ++c) {
		if (cells_[c].state == none) continue;
		bool bare = false;
		for (int a = 0; a < D; ++a)
			bare = bare || next_[a][c] < 0 || before_[a][c] < 0 || coveredAt(range, c, a, -1) < 1.0 || coveredAt(range, c, a, 1) < 1.0;
		if (bare) exposed_.push_back(c);
	}
}

/// Part of a surface with a normal, in or around a cell, through which water may leave: as far as nodes around the cell see open surface that faces
/// there. A face has 2^(D-1) of them.
template <int D> double ImplicitPressure<D>::openAt(int c, const Vec<D>& outward) const
{
	double open = 0.0;
	overCorners(c, [&](int node, int) { open += std::max(0.0, dot<D>(open_[node], outward)) / (1 << (D - 1)); });
	return std::min(1.0, open);
}

/// area over that of a face; distance from the middle of the ground [spacings]. About an axis the radius is that half way.
template <int D> void ImplicitPressure<D>::drainThrough(int c, double area, double distance, const Vec<D>& outward, double outside, bool recharges)
{
	if (area == 0.0) return;
	Cell&        cell   = cells_[c];
	const double way    = grid_->spacing() * std::max(distance, 0.5 * leastFill);
	double       drives = cell.drivingExcess - outside;
	for (int a = 0; a < D; ++a)
		drives += way * cell.weight[a] * outward[a];
	if (!recharges && !(cell.base + drives > 0.0)) return;
	const double measure     = grid_->measureAt(grid_->middle(c) + grid_->spacing() * cell.middle[0] + 0.5 * way * outward[0]);
	const double conductance = cell.open * grid_->faceArea() / way * area * measure;
	cell.drained += conductance;
	cell.drives += conductance * drives;
	cell.leaves += conductance * outward;
}

template <int D> void ImplicitPressure<D>::drain(const StepContext<D>& step, const SurfacePatch<D>& patch, double outside, bool recharges)
{
	const ActiveRange& range = step.halo;
	for (const SurfaceNode<D>& n : patch.nodes)
		if (const double area = lengthOf<D>(n.area); area > 0.0) open_[n.node] = n.area / area;
	for (const int c : exposed_) {
		const Cell& cell = cells_[c];
		for (int a = 0; a < D; ++a)
			for (const int side : { -1, 1 }) {
				if ((side > 0 ? next_ : before_)[a][c] >= 0) continue;
				Vec<D> outward {};
				outward[a] = side;
				drainThrough(c, section(cell, a, side) * openAt(c, outward), 0.5 - side * cell.middle[a], outward, outside, recharges);
			}
		const Surface surface = surfaceIn(range, c);
		const double  area    = lengthOf<D>(surface.area);
		if (area == 0.0) continue;
		const Vec<D> outward = surface.area / area;
		drainThrough(c, area * openAt(c, outward), surface.distance, outward, outside, recharges);
	}
	for (const SurfaceNode<D>& n : patch.nodes)
		open_[n.node] = {};
}

// ---- the system -----------------------------------------------------------------------------------------------------------

/// Rows of cells in fours, every other four at the same time: these have no nodes in common.
template <int D> void ImplicitPressure<D>::forces(const ActiveRange& range, const double* x, NodeField<D>& force) const
{
	range.overNodes([&](int, int first, int last) { std::fill(force[first], force[last], 0.0); });
	const int four = Strips::rows * cellsOfRow(), begin = range.firstCell / four, end = (range.lastCell + four - 1) / four;
	for (const int parity : { 0, 1 }) {
		const int from = begin + (begin + parity) % 2;
		ThreadPool::run(std::max(0, (end - from + 1) / 2), range.parallel ? ThreadPool::threads() : 1, [&](int k, int) {
			const int at = (from + 2 * k) * four;
			push(std::max(range.firstCell, at), std::min(range.lastCell, at + four), x, force);
		});
	}
	foldImages(grid_->images(), D, [&](int node) { return force[node]; });
}

template <int D> void ImplicitPressure<D>::push(int first, int last, const double* x, NodeField<D>& force) const
{
	for (int c = first; c < last; ++c) {
		if (x[c] == 0.0) continue;
		const double* b = link(c);
		for (const int offset : rowOffset_) {
			double* const f = force[baseNodes_[c] + offset];
#pragma GCC ivdep
			for (int i = 0; i < inRow; ++i)
				f[i] += b[i] * x[c];
			b += inRow;
		}
	}
}

template <int D> void ImplicitPressure<D>::divergence(int first, int last, const NodeField<D>& values, double* sums) const
{
	for (int c = first; c < last; ++c) {
		if (cells_[c].state == none) continue;
		const double* b           = link(c);
		double        part[inRow] = {};
		for (const int offset : rowOffset_) {
			const double* const v = values[baseNodes_[c] + offset];
#pragma GCC ivdep
			for (int i = 0; i < inRow; ++i)
				part[i] += b[i] * v[i];
			b += inRow;
		}
		sums[c] = 0.0;
		for (int i = 0; i < inRow; ++i)
			sums[c] += part[i];
	}
}

/// Flow out of a cell, more than through its drained faces [m^D/s]: drives(other cell, weight on the way) [Pa].
template <int D> template <class Drives> double ImplicitPressure<D>::flowOut(int c, double out, Drives&& drives) const
{
	for (int a = 0; a < D; ++a) {
		const int   before = before_[a][c];
		const Face& ahead  = faces_[a][c];
		if (ahead.conductance > 0.0) out += ahead.conductance * drives(next_[a][c], ahead.weight);
		if (before >= 0 && faces_[a][before].conductance > 0.0) out += faces_[a][before].conductance * drives(before, -faces_[a][before].weight);
	}
	return out;
}

/// Which pairs of axes have all four cells from c on filled with water, a bit each.
template <int D> void ImplicitPressure<D>::findSquares(const ActiveRange& range)
{
	range.eachCell([&](int c) {
		int pair    = 0;
		squares_[c] = 0;
		for (int a = 0; a < D; ++a)
			for (int b = a + 1; b < D; ++b, ++pair) {
				const int na = next_[a][c], nb = next_[b][c];
				if (cells_[c].state == none || na < 0 || nb < 0 || next_[b][na] >= range.lastCell) continue;
				if (cells_[na].state != none && cells_[nb].state != none && cells_[next_[b][na]].state != none) squares_[c] |= 1 << pair;
			}
	});
}

/// What alternates over the four cells from c on, along axes a and b; 0 if not all of them hold water.
template <int D> double ImplicitPressure<D>::hourglass(int c, int pair, int a, int b, const double* x) const
{
	if (c < 0 || !(squares_[c] >> pair & 1)) return 0.0;
	return grid_->measureOfFace(c, 0) * (x[c] - x[next_[a][c]] - x[next_[b][c]] + x[next_[b][next_[a][c]]]);
}

/// What a cell gives to others because pressures alternate [m^D].
template <int D> double ImplicitPressure<D>::checkerboard(int c, const double* x) const
{
	double sum  = 0.0;
	int    pair = 0;
	for (int a = 0; a < D; ++a)
		for (int b = a + 1; b < D; ++b, ++pair) {
			const int before = before_[a][c];
			sum += hourglass(c, pair, a, b, x);
			sum -= hourglass(before, pair, a, b, x);
			sum -= hourglass(before_[b][c], pair, a, b, x);
			sum += hourglass(before < 0 ? -1 : before_[b][before], pair, a, b, x);
		}
	return checkerboard_ * sum;
}

template <int D> void ImplicitPressure<D>::apply(const StepContext<D>& step, const MomentumSolver<D>& momentum, const double* x, double* y)
{
	const double dt = step.dt;
	forces(step.halo, x, moved_);
	momentum.foldForces(step.halo, moved_);
	step.halo.eachNode([&](int i) {
		for (int a = 0; a < D; ++a)
			moved_[i][a] *= response_[i][a];
	});
	momentum.unfoldChanges(step.halo, moved_);
	step.owned.overCells([&](int first, int last) {
		divergence(first, last, moved_, y);
		for (int c = first; c < last; ++c) {
			const Cell& cell   = cells_[c];
			const auto  drives = [&](int other, double) { return x[c] - x[other]; };
			y[c] = cell.state == none ? 0.0 : cell.compliance * x[c] + dt * (y[c] + flowOut(c, cell.drained * x[c], drives)) + checkerboard(c, x);
		}
	});
}

template <int D> void ImplicitPressure<D>::findResiduals(const StepContext<D>& step, SolidMotion<D>& motion, const PoreWater<D>& water)
{
	const double dt = step.dt;
	step.halo.eachNode([&](int i) { std::copy_n(motion.solved[i] + motion.velocityAt, D, moved_[i]); });
	step.halo.eachCell([&](int c) { change_[c] = cells_[c].state == none ? 0.0 : cells_[c].base - cells_[c].pressure; });
	step.owned.overCells([&](int first, int last) {
		divergence(first, last, moved_, image_.data());
		for (int c = first; c < last; ++c) {
			const Cell& cell = cells_[c];
			initial_[c]      = 0.0;
			if (cell.state == none) continue;
			double fed = 0.0;
			for (int k = 0; k < corners && fed_; ++k) {
				const int    node = baseNodes_[c] + nodeOffset_[k];
				const double got  = water.exchange[node][PoreWater<D>::Gathered::water];
				if (got != 0.0) fed += liquids_[std::size_t(c) * corners + k] * got * water.nodal[node][PoreWater<D>::Driving::perLiquidMass];
			}
			const auto   drives = [&](int other, double weight) { return cell.pressure - cells_[other].pressure + weight; };
			const double out = flowOut(c, cell.drained * cell.pressure + cell.drives, drives), off = cell.excess - cell.compliance * cell.pressure;
			initial_[c] = off + fed / water.liquid.density - dt * out - dt * image_[c];
		}
	});
}

/// Conductance by the inertia of the ground between a cell and the next one along an axis: what its face moves in the step [m^D/Pa], eq. (7.10).
template <int D> double ImplicitPressure<D>::movedAcross(int c, int axis) const
{
	const double area  = grid_->faceArea() * grid_->measureOfFace(c, axis);
	double       gives = 0.0;
	overCorners(c, [&](int node, int corner) {
		if (corner >> axis & 1) gives += response_[node][axis];
	});
	return area * area * cells_[c].fill * cells_[next_[axis][c]].fill * gives / (1 << (D - 1));
}

/// The matrix of the preconditioner. A pressure that is the same in all cells moves the ground at its surface only; what it moves there is stored.
template <int D> void ImplicitPressure<D>::findPreconditioner(const StepContext<D>& step, const MomentumSolver<D>& momentum)
{
	const double dt = step.dt;
	// the states of the halo are those at the start of the step
	step.owned.eachCell([&](int c) { direction_[c] = cells_[c].state == wet ? 1.0 : 0.0; });
	Multigrid::share(step, direction_);
	apply(step, momentum, direction_.data(), image_.data());
	step.halo.eachCell([&](int c) {
		auto& m = multigrid_[c];
		m       = {};
		if (direction_[c] == 0.0) return;
		m.storage = cells_[c].compliance + dt * cells_[c].drained;
		if (c >= step.owned.firstCell && c < step.owned.lastCell) m.storage = std::max(m.storage, image_[c]);
		for (int a = 0; a < D; ++a)
			// without the faces of periodic sides: iterations find what these do
			if (hasNext(step.halo, c, a) && next_[a][c] > c && direction_[next_[a][c]] != 0.0)
				m.conductance[a] = dt * (faces_[a][c].conductance + movedAcross(c, a));
	});
	multigrid_.build(step);
}

/// Sums by strips of the points, as the accounts of a step have them: so they have one order for any number of threads and ranks.
template <int D> template <class Work> double ImplicitPressure<D>::sumOfStrips(const StepContext<D>& step, Work&& ofStrip)
{
	const Strips& strips = step.strips;
	partial_.assign(strips.count(), 0.0);
	ThreadPool::run(strips.end() - strips.begin(), strips.parallel ? ThreadPool::threads() : 1, [&](int k, int) {
		partial_[strips.begin() + k] = ofStrip(strips.begin() + k);
	});
	if (step.slabs) step.slabs->shareByStrip(partial_.data());
	return std::accumulate(partial_.begin(), partial_.end(), 0.0);
}

/// Over the cells that hold water.
template <int D> template <class Value> double ImplicitPressure<D>::sum(const StepContext<D>& step, Value&& value)
{
	const int cells = Strips::rows * cellsOfRow();
	return sumOfStrips(step, [&](int strip) {
		double part = 0.0;
		for (int c = std::max(step.owned.firstCell, strip * cells); c < std::min(step.owned.lastCell, (strip + 1) * cells); ++c)
			if (cells_[c].state == wet) part += value(c);
		return part;
	});
}

/// Over the nodes; a strip has the four rows in its middle and before its end.
template <int D> template <class Value> double ImplicitPressure<D>::sumOfNodes(const StepContext<D>& step, Value&& value)
{
	const int nodesOfRow = step.grid.nodeStride(step.grid.slowAxis()), last = step.strips.count() - 1;
	return sumOfStrips(step, [&](int strip) {
		const int from = strip == 0 ? 0 : Strips::rows * strip + 1,
		          to   = strip == last ? step.grid.nodes(step.grid.slowAxis()) : Strips::rows * (strip + 1) + 1;
		double part    = 0.0;
		for (int i = std::max(step.owned.firstNode, from * nodesOfRow); i < std::min(step.owned.lastNode, to * nodesOfRow); ++i)
			part += value(i);
		return part;
	});
}

/// Conjugate gradients, preconditioned by multigrid, from the change that stands. goal: the largest of the rounds of a step.
template <int D> void ImplicitPressure<D>::iterate(const StepContext<D>& step, const MomentumSolver<D>& momentum, double& goal)
{
	const ActiveRange& range = step.owned;
	findPreconditioner(step, momentum);
	const bool begun = std::any_of(change_.data() + step.halo.firstCell, change_.data() + step.halo.lastCell, [](double x) { return x != 0.0; });
	if (begun) apply(step, momentum, change_.data(), image_.data());
	range.eachCell([&](int c) { residual_[c] = begun ? initial_[c] - image_[c] : initial_[c]; });
	multigrid_.solve(step, residual_, direction_);
	double       norm  = sum(step, [&](int c) { return residual_[c] * direction_[c]; });
	const double stand = sum(step, [&](int c) { return multigrid_.diagonal(c) * cells_[c].base * cells_[c].base; });
	goal               = std::max({ goal, relativeResidual * relativeResidual * norm, smallestResidual * smallestResidual * stand });
	for (int k = 0; k < mostIterations && norm > goal; ++k) {
		Multigrid::share(step, direction_);
		apply(step, momentum, direction_.data(), image_.data());
		const double way = norm / sum(step, [&](int c) { return direction_[c] * image_[c]; });
		range.eachCell([&](int c) {
			change_[c] += way * direction_[c];
			residual_[c] -= way * image_[c];
		});
		multigrid_.solve(step, residual_, preconditioned_);
		const double next = sum(step, [&](int c) { return residual_[c] * preconditioned_[c]; });
		range.eachCell([&](int c) { direction_[c] = preconditioned_[c] + next / norm * direction_[c]; });
		norm = next;
	}
}

/// Cells whose water would be torn leave a gap, and gaps that would be overfilled close.
template <int D> bool ImplicitPressure<D>::changeStates(const StepContext<D>& step)
{
	bool changed = false;
	for (int c = step.owned.firstCell; c < step.owned.lastCell; ++c) {
		Cell& cell = cells_[c];
		if (cell.state == wet && cell.pressure + change_[c] < lowest_) {
			cell.state = cavitated;
			change_[c] = lowest_ - cell.pressure;
			changed    = true;
		} else if (cell.state == cavitated && residual_[c] > 0.0) {
			cell.state = wet;
			changed    = true;
		}
	}
	return step.onAnyRank(changed);
}

template <int D> void ImplicitPressure<D>::findMoved(const ActiveRange& range, double dt)
{
	range.eachCell([&](int c) {
		Cell& cell = cells_[c];
		cell.out   = dt * (cell.drained * (cell.pressure + change_[c]) + cell.drives);
		for (int a = 0; a < D; ++a) {
			Face&     f    = faces_[a][c];
			const int next = next_[a][c];
			if (!hasNext(range, c, a) || cell.state == none || cells_[next].state == none) continue;
			f.moved = dt * f.conductance * (cell.pressure + change_[c] - cells_[next].pressure - change_[next] + f.weight);
			for (int b = 0; b < D; ++b) {
				if (b == a) continue;
				const int low = std::min(a, b), high = std::max(a, b), pair = low == 0 ? high - 1 : 2;
				f.moved += 0.5 * checkerboard_ * hourglass(c, pair, low, high, change_.data());
				f.moved -= 0.5 * checkerboard_ * hourglass(before_[b][c], pair, low, high, change_.data());
			}
		}
	});
}

/// The mean of what flows through both faces of a cell along an axis, and through its surface.
template <int D> void ImplicitPressure<D>::findSeepage(const ActiveRange& range, double dt, double liquidDensity)
{
	range.eachCell([&](int c) {
		Cell& cell = cells_[c];
		if (cell.state == none) return;
		for (int a = 0; a < D; ++a) {
			const double behind  = before_[a][c] >= 0 ? faces_[a][before_[a][c]].moved : 0.0;
			const double through = cell.drained > 0.0 ? cell.out * cell.leaves[a] / cell.drained : 0.0;
			cell.flows[a]        = 0.5 * (faces_[a][c].moved + behind + through) * grid_->spacing() * liquidDensity / (dt * cell.liquidMass);
		}
	});
}

template <int D> void ImplicitPressure<D>::giveToPoints(const CellMeans<D>& cells, double dt, int first, int last)
{
	for (int p = first; p < last; ++p) {
		const Cell& cell = cells_[cells.cell(p)];
		for (int a = 0; a < D; ++a) {
			seepage[a][p] = cell.flows[a];
			acceleration_[a][p] += cell.recent * ((velocity_[a][p] - startVelocity_[a][p]) / dt - acceleration_[a][p]);
		}
	}
}

template <int D> void ImplicitPressure<D>::solve(const StepContext<D>& step, MomentumSolver<D>& momentum, SolidMotion<D>& motion, PoreWater<D>& water)
{
	const double dt = step.dt;
	momentum.findResponse(step.halo, motion, water, dt, response_);
	const double mass   = sumOfNodes(step, [&](int i) { return motion.nodes[i][motion.massAt] + water.nodes[i][PoreWater<D>::massAt]; });
	const double volume = sumOfNodes(step, [&](int i) { return water.nodes[i][PoreWater<D>::volumeAt]; });
	checkerboard_       = volume > 0.0 ? checkerboardPart * dt * dt * grid_->cellVolume() / (grid_->spacing() * grid_->spacing() * mass / volume) : 0.0;
	findResiduals(step, motion, water);
	double goal = 0.0;
	for (int round = 0; round < mostRounds; ++round) {
		iterate(step, momentum, goal);
		const bool changed = changeStates(step);
		Multigrid::share(step, change_);
		if (!changed) break;
	}
	findMoved(step.halo, dt);
	findSeepage(step.owned, dt, water.liquid.density);
	forces(step.halo, change_.data(), force_);
	momentum.correct(step.halo, motion, water, force_, response_, dt, step.ledger);
}

template <int D> void ImplicitPressure<D>::keepOnly(const ActiveRange& range, int firstPoint, int endPoint)
{
	const std::size_t first = range.firstCell, last = range.lastCell;
	cells_.keepOnly(first, last);
	links_.keepOnly(first * corners * D, last * corners * D);
	if (fed_) liquids_.keepOnly(first * corners, last * corners);
	for (auto& faces : faces_)
		faces.keepOnly(first, last);
	for (auto* values : { &change_, &residual_, &initial_, &direction_, &image_, &preconditioned_ })
		values->keepOnly(first, last);
	multigrid_.keepOnly(range);
	for (auto* field : { &response_, &force_, &moved_ })
		field->keepOnly(range.firstNode, range.lastNode);
	for (auto& values : startVelocity_)
		values.keepOnly(firstPoint, endPoint);
}

template <int D> void ImplicitPressure<D>::bookDissipation(const StepContext<D>& step) const
{
	for (int c = step.owned.firstCell; c < step.owned.lastCell; ++c) {
		const Cell& cell = cells_[c];
		if (cell.state == none) continue;
		double lost = cell.drained > 0.0 ? cell.out * (cell.pressure + change_[c] + cell.drives / cell.drained) : 0.0;
		for (int a = 0; a < D; ++a) {
			const Face& f    = faces_[a][c];
			const int   next = next_[a][c];
			if (f.moved != 0.0) lost += f.moved * (cell.pressure + change_[c] - cells_[next].pressure - change_[next] + f.weight);
		}
		step.ledger.ofCell(c).dragDissipation += lost;
	}
}

template <int D> double ImplicitPressure<D>::givenTemperature(const ActiveRange& range, int cell, int axis, int step) const
{
	const int    next = (step > 0 ? next_ : before_)[axis][cell], before = wetCell(range, cell, axis, -step);
	const double mean = cells_[cell].temperature;
	if (before < 0) return mean;
	const double behind = mean - cells_[before].temperature, ahead = cells_[next].temperature - mean; // the limiter of van Leer
	return behind * ahead > 0.0 ? mean + behind * ahead / (behind + ahead) : mean;
}

template <int D> void ImplicitPressure<D>::exchange(const StepContext<D>& step, PoreWater<D>& water)
{
	const ActiveRange&         range         = step.owned;
	const double               liquidDensity = water.liquid.density;
	const EnthalpyModel* const enthalpy      = water.liquid.enthalpy;
	using Gathered                           = typename PoreWater<D>::Gathered;
	const auto take                          = [&](double* to, int donor, double mass, double temperature) {
                to[Gathered::water] += mass;
                if (enthalpy) to[Gathered::enthalpy] += mass * enthalpy->liquidEnthalpy(temperature);
                addTo<D>(to + Gathered::momentum, mass / cells_[donor].liquidMass * cells_[donor].carried);
	};
	range.eachCell([&](int c) {
		if (cells_[c].state == none) return;
		double* const to = water.cellExchange(c);
		for (int a = 0; a < D; ++a) {
			const int    next = next_[a][c], before = before_[a][c];
			const double ahead = faces_[a][c].moved, behind = before >= step.halo.firstCell ? faces_[a][before].moved : 0.0;
			// both cells of a face ask for the same number, so that none is lost
			const auto warmth = [&](int face, double moved) {
				return !enthalpy      ? 0.0
				        : moved > 0.0 ? givenTemperature(step.halo, face, a, 1)
				                      : givenTemperature(step.halo, next_[a][face], a, -1);
			};
			if (ahead != 0.0) take(to, ahead > 0.0 ? c : next, -liquidDensity * ahead, warmth(c, ahead));
			if (behind != 0.0) take(to, behind > 0.0 ? before : c, liquidDensity * behind, warmth(before, behind));
		}
		if (cells_[c].out != 0.0) take(to, c, -liquidDensity * cells_[c].out, cells_[c].temperature);
	});
	for (const int c : exposed_) {
		const double mass = liquidDensity * cells_[c].out;
		if (mass == 0.0) continue;
		StepAccount<D>& account = step.ledger.ofCell(c);
		account.waterOut += mass;
		account.waterEnergyOut += cells_[c].out * (water.heightOfCell(c) - cells_[c].drives / cells_[c].drained);
		if (enthalpy) account.enthalpyOut += mass * enthalpy->liquidEnthalpy(cells_[c].temperature);
		account.momentumOut += mass / cells_[c].liquidMass * cells_[c].carried;
	}
}

template <int D> void ImplicitPressure<D>::givePressure(const ActiveRange& range, PoreWater<D>& water) const
{
	range.eachCell([&](int c) {
		if (cells_[c].state != none) water.setCellPressure(c, std::max(cells_[c].pressure + change_[c], lowest_));
	});
}

TALIK_IN_PLANE_AND_SPACE(ImplicitPressure);

} // namespace talik
