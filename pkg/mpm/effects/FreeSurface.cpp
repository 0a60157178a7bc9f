// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/FreeSurface.hpp>
#include <pkg/mpm/grid/NodeLoops.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

namespace {
	// A cell filled to less than a quarter counts as empty.
	constexpr double emptyFilling = 0.25;
	// Areas that are smaller against the volume that a node stands for are the noise of the points' arrangement. A node behind a
	// wall stands for little volume, and its share of the surface is as small.
	constexpr double smallestArea = 0.05;

	/// work(empty), with empty(cell): whether the points of a cell fill less of it than counts.
	template <int D, class Work> decltype(auto) withEmptiness(const Grid<D>& grid, const CellMeans<D>& cells, Work&& work)
	{
		const double enough = emptyFilling * grid.cellVolume();
		return grid.measured(
		        [&](auto&& measure) -> decltype(auto) { return work([&](int c) { return cells.cellVolume(c) < enough * measure(grid.middle(c)); }); });
	}
} // namespace

template <int D> void FreeSurface<D>::bind(MaterialPoints<D>& points, const Grid<D>& grid, const double* conductivity)
{
	strips_       = &points.strips();
	volume_       = points.volume();
	conductivity_ = conductivity;
	nodes.allocate(grid.nodeCount());
}

template <int D> void FreeSurface<D>::setBoundaries(const std::vector<std::shared_ptr<Boundary<D>>>& boundaries, const Grid<D>& grid, bool moves)
{
	boundaries_ = boundaries;
	for (auto& ends : openSides_)
		ends[0] = ends[1] = moves;
	for (const auto& b : boundaries)
		if (b->region().kind == Region<D>::Kind::side) openSides_[b->region().on.axis][b->region().on.upper] = false;
	openSides_[D - 1][1] = true; // the sky
	for (int a = 0; a < D; ++a)
		if (grid.isPeriodic(a)) openSides_[a][0] = openSides_[a][1] = false;
	patches_.assign(boundaries.size(), {});
	sideNodes_.assign(boundaries.size(), {});
	std::size_t most = 0;
	for (std::size_t b = 0; b < boundaries.size(); ++b) {
		if (!boundaries[b]->usesSurface()) continue;
		const Region<D>& region = boundaries[b]->region();
		sideNodes_[b]           = wallNodes(grid, region);
		const bool anywhere     = region.kind == Region<D>::Kind::freeSurface || region.kind == Region<D>::Kind::bodies;
		patches_[b].nodes.reserve(anywhere ? grid.nodeCount() : 3 * sideNodes_[b].size());
		if (region.kind == Region<D>::Kind::freeSurface) most = grid.nodeCount();
	}
	surface_.reserve(most);
	ofSurface_.reserve(most);
	if (most > 0) emptiness_.assign(grid.cellCount(), filled);
	if (most > 0) empty_.assign(grid.cellCount(), 0);
	reached_.reserve(most > 0 ? grid.cellCount() : 0);

	// boxes of nodes and bodies may lie anywhere, and near a periodic side the cells at the other one matter
	needsAll_ = !grid.images().empty();
	for (const auto& b : boundaries) {
		needsAll_   = needsAll_ || (b->usesSurface() && (b->region().kind == Region<D>::Kind::nodeBox || b->region().kind == Region<D>::Kind::bodies));
		needsSides_ = needsSides_ || (b->usesSurface() && b->region().kind == Region<D>::Kind::side);
	}
	int size = 1;
	for (int a = 0; a < D; ++a) {
		stride_[a] = size;
		size *= grid.cells(a) + 2 * reach;
	}
	needed_.assign(size, 0);
	widened_.assign(size, 0);
	place_.resize(grid.cellCount());
	for (int c = 0; c < grid.cellCount(); ++c)
		place_[c] = paddedIndex(grid, c);
}

template <int D> int FreeSurface<D>::paddedIndex(const Grid<D>& grid, int cell) const
{
	int index = 0;
	for (int a = 0; a < D; ++a)
		index += (grid.place(cell, a) + reach) * stride_[a];
	return index;
}

template <int D> void FreeSurface<D>::widen(int stride)
{
	const int size = int(needed_.size()), margin = reach * stride;
	for (int i = margin; i < size - margin; ++i) {
		unsigned char any = 0;
		for (int d = -reach; d <= reach; ++d)
			any |= needed_[i + d * stride];
		widened_[i] = any;
	}
	needed_.swap(widened_);
}

template <int D> void FreeSurface<D>::findNeeded(const Grid<D>& grid, const CellMeans<D>& cells)
{
	if (needsAll_) return;
	cells_ = &cells;
	std::fill(needed_.begin(), needed_.end(), static_cast<unsigned char>(needsSides_));
	std::fill(widened_.begin(), widened_.end(), static_cast<unsigned char>(needsSides_));
	withEmptiness(grid, cells, [&](auto&& empty) {
		for (int c = 0; c < grid.cellCount(); ++c)
			needed_[place_[c]] = empty(c);
	});
	for (int a = 0; a < D; ++a)
		widen(stride_[a]);
}

template <int D> void FreeSurface<D>::map(const WeightBlock<D>& w)
{
	if (cells_) {
		bool any = false;
		for (int k = 0; k < w.count; ++k)
			any |= needed_[place_[cells_->cell(w.first + k)]] != 0;
		if (!any) return;
	}
	nodeLoops<D>().mapSurface(w, volume_, conductivity_, nodes[0]);
}

template <int D> void FreeSurface<D>::findOpenAir(const Grid<D>& grid, const CellMeans<D>& cells)
{
	withEmptiness(grid, cells, [&](auto&& empty) { flagCells(grid, *strips_, empty_, empty); });
	bool changed = false;
	for (int c = 0; c < grid.cellCount(); ++c)
		changed |= empty_[c] != (emptiness_[c] != filled);
	// what is empty tells all: as long as that stays there is nothing to do
	if (!changed) return;
	for (int c = 0; c < grid.cellCount(); ++c)
		emptiness_[c] = empty_[c] ? cavity : filled;
	reached_.clear();
	for (int c = 0; c < grid.cellCount(); ++c)
		for (int a = 0; a < D; ++a) {
			const int at = grid.place(c, a);
			if ((at == 0 && openSides_[a][0]) || (at == grid.cells(a) - 1 && openSides_[a][1])) letAirIn(c);
		}
	while (!reached_.empty()) {
		const int c = reached_.back();
		reached_.pop_back();
		for (int a = 0; a < D; ++a)
			for (const int side : { -1, 1 })
				if (const int next = grid.neighbour(c, a, side); next >= 0) letAirIn(next);
	}
}

template <int D> void FreeSurface<D>::letAirIn(int cell)
{
	if (emptiness_[cell] != cavity) return;
	emptiness_[cell] = openAir;
	reached_.push_back(cell);
}

template <int D> typename FreeSurface<D>::Emptiness FreeSurface<D>::emptinessAt(const Grid<D>& grid, const std::array<int, D>& node, const double* area) const
{
	// cells that a quadratic shape function of the node reaches into, those beside it first: most of the others then lie farther away than what was found
	constexpr int nearestFirst[] = { 1, 2, 0, 3 }, reached = 4;
	double        nearest  = INFINITY;
	Emptiness     found    = filled;
	const auto    fromNode = [](int back) { return 1.5 - back; }; // to the middle of the cell that many behind the one ahead of the node [cells]
	for (int rowNumber = 0; rowNumber < (D == 2 ? reached : reached * reached); ++rowNumber) {
		const int          back[2] = { nearestFirst[rowNumber % reached], nearestFirst[rowNumber / reached] };
		std::array<int, D> places;
		double             apart = 0.0;
		for (int a = 1; a < D; ++a) {
			places[a] = node[a] - back[a - 1];
			apart += fromNode(back[a - 1]) * fromNode(back[a - 1]);
		}
		if (apart > nearest) continue;
		for (const int behind : nearestFirst) {
			places[0]       = node[0] - behind;
			const int  cell = grid.cellAt(places);
			const auto here = cell < 0 ? filled : emptiness_[cell];
			if (here == filled) continue;
			double distance = apart + fromNode(behind) * fromNode(behind), ahead = fromNode(behind) * area[0];
			for (int a = 1; a < D; ++a)
				ahead += fromNode(back[a - 1]) * area[a];
			// behind the surface lies another one
			if (ahead <= 0.0) distance += 1e3;
			if (distance < nearest || (distance == nearest && here == openAir)) nearest = distance, found = here;
		}
	}
	return found;
}

template <int D> bool FreeSurface<D>::atWall(const Grid<D>& grid, const CellMeans<D>& cells, const std::array<int, D>& node, int axis) const
{
	const bool lower = node[axis] <= 2, upper = node[axis] >= grid.cells(axis);
	if (grid.isPeriodic(axis) || (!lower && !upper)) return false;
	std::array<int, D> low, high, cell;
	for (int a = 0; a < D; ++a) {
		low[a]  = grid.isPeriodic(a) ? node[a] - 3 : std::max(0, node[a] - 3);
		high[a] = grid.isPeriodic(a) ? node[a] : std::min(grid.cells(a) - 1, node[a]);
	}
	return withEmptiness(grid, cells, [&](auto&& empty) {
		for (const bool atUpper : { false, true }) {
			if (atUpper ? !upper : !lower) continue;
			low[axis] = high[axis] = atUpper ? grid.cells(axis) - 1 : 0;
			for (int a = 0; a < D; ++a)
				if (!grid.isPeriodic(a)) high[a] = std::max(high[a], 0), low[a] = std::min(low[a], high[a]);
			cell = low;
			while (true) {
				if (!empty(grid.cellAt(cell))) return true;
				int a = 0;
				while (a < D && ++cell[a] > high[a])
					cell[a] = low[a], ++a;
				if (a == D) break;
			}
		}
		return false;
	});
}

template <int D> void FreeSurface<D>::collectSide(const Grid<D>& grid, const CellMeans<D>& cells, const ActiveRange& range, int boundary)
{
	// the surface of a wall spreads over the nodes behind, on and in front of it, where ground rests against it
	const Side side   = boundaries_[boundary]->region().on;
	const int  inward = side.upper ? -grid.nodeStride(side.axis) : grid.nodeStride(side.axis);
	const auto sign   = side.upper ? 1.0 : -1.0;
	for (int node : sideNodes_[boundary]) {
		if (!range.holds(node) || !atWall(grid, cells, grid.nodeOf(node), side.axis)) continue;
		for (int layer : { -inward, 0, inward }) {
			const double area = nodes[node + layer][side.axis];
			if (area * sign <= 0.0) continue;
			SurfaceNode<D> n { node + layer, {} };
			n.area[side.axis] = area;
			patches_[boundary].nodes.push_back(n);
		}
	}
}

template <int D> void FreeSurface<D>::collectBox(const Grid<D>& grid, const ActiveRange& range, int boundary)
{
	// no normal here: the size of the area only, a cell face per node and half of it at the ends of a line
	const std::vector<int>& all = sideNodes_[boundary];
	for (int node : all) {
		if (!range.holds(node)) continue;
		double area = grid.faceArea() * grid.measureAt(grid.nodePosition(0, grid.nodeOf(node)[0]));
		for (int a = 0; a < D; ++a) {
			const bool before = std::binary_search(all.begin(), all.end(), node - grid.nodeStride(a));
			const bool after  = std::binary_search(all.begin(), all.end(), node + grid.nodeStride(a));
			if (before != after) area *= 0.5;
		}
		SurfaceNode<D> n { node, {} };
		n.area[0] = area;
		patches_[boundary].nodes.push_back(n);
	}
}

template <int D> void FreeSurface<D>::collect(const Grid<D>& grid, const CellMeans<D>& cells, const ActiveRange& range)
{
	surface_.clear();
	ofSurface_.clear();
	if (surface_.capacity() > 0) {
		findOpenAir(grid, cells);
		for (int index = range.firstNode; index < range.lastNode; ++index) {
			const double* r = nodes[index];
			if (r[D] <= 0.0) continue;
			const double noise   = smallestArea * r[D] * grid.inverseSpacing();
			const auto   isNoise = [&](const double* area) {
                                double size = 0.0;
                                for (int a = 0; a < D; ++a)
                                        size += area[a] * area[a];
                                return size <= noise * noise;
			};
			// first the test that sorts out the interior of regularly filled ground
			if (isNoise(r)) continue;
			const std::array<int, D> node   = grid.nodeOf(index);
			const Emptiness          before = emptinessAt(grid, node, r);
			if (before == filled) continue;
			SurfaceNode<D> n { index, {} };
			for (int a = 0; a < D; ++a)
				n.area[a] = atWall(grid, cells, node, a) ? 0.0 : r[a];
			if (isNoise(n.area.data())) continue;
			surface_.push_back(n);
			ofSurface_.push_back(before);
		}
	}

	for (std::size_t b = 0; b < boundaries_.size(); ++b) {
		if (!boundaries_[b]->usesSurface()) continue;
		const Region<D>& region = boundaries_[b]->region();
		patches_[b].nodes.clear();
		if (region.kind == Region<D>::Kind::side) collectSide(grid, cells, range, b);
		else if (region.kind == Region<D>::Kind::nodeBox) collectBox(grid, range, b);
		else if (region.kind == Region<D>::Kind::freeSurface)
			for (std::size_t k = 0; k < surface_.size(); ++k) {
				if (ofSurface_[k] != (region.cavities ? cavity : openAir)) continue;
				const SurfaceNode<D>&    n    = surface_[k];
				const std::array<int, D> node = grid.nodeOf(n.node);
				Vec<D>                   x;
				for (int a = 0; a < D; ++a)
					x[a] = grid.nodePosition(a, node[a]);
				if (region.holds(x, 0.5 * grid.spacing())) patches_[b].nodes.push_back(n);
			}
	}
}

TALIK_IN_PLANE_AND_SPACE(FreeSurface);

} // namespace talik
