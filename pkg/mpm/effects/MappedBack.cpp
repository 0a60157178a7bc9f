// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/MappedBack.hpp>

#include <algorithm>

namespace talik {

namespace {
	/// work(node) for the nodes of a cell's support that are from first on, in number along each axis; 1 and 2 for its corners, 0 and 4 for all.
	template <int D, class Work> void nodesAround(const Grid<D>& grid, int cell, int first, int number, Work&& work)
	{
		std::array<int, D> at {};
		for (bool more = true; more;) {
			std::array<int, D> node;
			for (int a = 0; a < D; ++a)
				node[a] = grid.place(cell, a) + first + at[a];
			work(grid.nodeIndex(node));
			int a = 0;
			while (a < D && ++at[a] == number)
				at[a++] = 0;
			more = a < D;
		}
	}
} // namespace

template <int D> void MappedBack<D>::bind(const Grid<D>& grid, const Vec<D>& gravity)
{
	upright_ = layerNormal<D>(gravity);
	up_      = gravity[upright_] > 0.0 ? -1 : gravity[upright_] < 0.0 ? 1 : 0;
	missing.allocate(grid.nodeCount());
	empty_.assign(grid.cellCount(), 0);
	emptyBefore_.clear();
	beside_.resize(grid.nodeCount());
	reaches_.resize(grid.cellCount());
}

template <int D> void MappedBack<D>::find(const Grid<D>& grid, const CellMeans<D>& cells, const Strips& strips)
{
	const int count = grid.cellCount();
	flagCells(grid, strips, empty_, [&](int c) { return !(cells.cellVolume(c) > 0.0); });
	if (empty_ == emptyBefore_) return;
	emptyBefore_ = empty_;
	open_        = empty_;
	for (int k = 0; k < count && up_ != 0; ++k) {
		const int c = up_ > 0 ? count - 1 - k : k, above = grid.neighbour(c, upright_, up_);
		if (above >= 0) open_[c] &= open_[above];
	}
	std::fill(beside_.begin(), beside_.end(), 0);
	for (int c = 0; c < count; ++c)
		if (open_[c]) nodesAround(grid, c, 1, 2, [&](int node) { beside_[node] = 1; });
	for (const NodeImage& image : grid.images())
		beside_[image.original] |= beside_[image.node];
	for (const NodeImage& image : grid.images())
		beside_[image.node] = beside_[image.original];
	std::fill(reaches_.begin(), reaches_.end(), 0);
	for (int c = 0; c < count; ++c)
		nodesAround(grid, c, 0, 4, [&](int node) { reaches_[c] |= beside_[node]; });
}

template <int D> void MappedBack<D>::map(const CellMeans<D>& cells, const SolidMotion<D>& motion, const WeightBlock<D>& w)
{
	for (int k = 0; k < w.count; ++k) {
		const int p = w.first + k;
		if (!reaches_[cells.cell(p)]) continue;
		Vec<D> v;
		for (int a = 0; a < D; ++a)
			v[a] = motion.kept * motion.velocity[a][p];
		overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) {
			for (int a = 0; a < D; ++a)
				v[a] += s * motion.solved[node][a];
		});
		overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) {
			for (int a = 0; a < D; ++a)
				missing[node][a] += s * motion.mass[p] * (v[a] - motion.solved[node][motion.velocityAt + a]);
		});
	}
}

TALIK_IN_PLANE_AND_SPACE(MappedBack);

} // namespace talik
