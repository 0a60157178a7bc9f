// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/mpm/grid/Grid.hpp>

namespace talik {

namespace {
	const char* const axisNames[] = { "x", "y", "z" };

	template <int D> int wholeCells(int axis, double lower, double upper, double spacing)
	{
		const std::string name = std::string("MpmEngine.upper.") + axisNames[axis];
		requireSetting(std::isfinite(lower), std::string("MpmEngine.lower.") + axisNames[axis], lower, "the grid's box must be finite");
		requireSetting(std::isfinite(upper) && upper > lower, name, upper, "must be finite and above the lower corner");
		const double cells = (upper - lower) / spacing;
		const double whole = std::round(cells);
		requireSetting(cells < 1e6, "MpmEngine.gridSpacing", spacing, "gives more than a million cells along one axis; use a larger spacing");
		requireSetting(whole >= 1.0 && std::abs(cells - whole) < 1e-6, name, upper, "the box must be a whole number of grid spacings wide");
		return int(whole);
	}
} // namespace

template <int D>
Grid<D>::Grid(const Vec<D>& lower, const Vec<D>& upper, double spacing)
        : lower_(lower)
        , upper_(upper)
        , spacing_(spacing)
{
	requireSetting(std::isfinite(spacing) && spacing > 0.0, "MpmEngine.gridSpacing", spacing, "must be positive, in m");
	inverseSpacing_ = 1.0 / spacing;
	for (int a = 0; a < D; ++a)
		cells_[a] = wholeCells<D>(a, lower[a], upper[a], spacing);

	slowAxis_    = int(std::max_element(cells_.begin(), cells_.end()) - cells_.begin());
	double nodes = 1.0;
	for (int a = 0; a < D; ++a)
		nodes *= cells_[a] + 3;
	requireSetting(nodes < 2e8, "MpmEngine.gridSpacing", spacing, "gives more than 200 million nodes; use a larger spacing or a smaller box");

	int        nodeStride = 1, cellStride = 1;
	const auto place = [&](int a) {
		nodeStride_[a] = nodeStride;
		cellStride_[a] = cellStride;
		nodeStride *= cells_[a] + 3;
		cellStride *= cells_[a];
	};
	for (int a = 0; a < D; ++a)
		if (a != slowAxis_) place(a);
	place(slowAxis_);
	nodeCount_ = nodeStride;
	cellCount_ = cellStride;
}

template <int D> double Grid<D>::cellVolume() const
{
	double v = 1.0;
	for (int a = 0; a < D; ++a)
		v *= spacing_;
	return v;
}

template <int D> int Grid<D>::nodeIndex(const std::array<int, D>& node) const
{
	int index = 0;
	for (int a = 0; a < D; ++a)
		index += node[a] * nodeStride_[a];
	return index;
}

template <int D> std::array<int, D> Grid<D>::nodeOf(int index) const
{
	std::array<int, D> node;
	for (int a = 0; a < D; ++a)
		node[a] = (index / nodeStride_[a]) % nodes(a);
	return node;
}

/// Which nodes are the same, eq. (8.6).
template <int D> void Grid<D>::joinSides(int axis)
{
	periodic_[axis] = true;
	images_.clear();
	originals_.resize(nodeCount_);
	for (int n = 0; n < nodeCount_; ++n) {
		std::array<int, D> node = nodeOf(n);
		for (int a = 0; a < D; ++a)
			if (periodic_[a]) node[a] = (node[a] - 1 + cells_[a]) % cells_[a] + 1;
		originals_[n] = nodeIndex(node);
		if (originals_[n] != n) images_.push_back({ n, originals_[n] });
	}
}

template <int D> int Grid<D>::cellAt(const std::array<int, D>& places) const
{
	int index = 0;
	for (int a = 0; a < D; ++a) {
		const int n = cells_[a], place = periodic_[a] ? (places[a] % n + n) % n : places[a];
		if (place < 0 || place >= n) return -1;
		index += place * cellStride_[a];
	}
	return index;
}

template <int D> bool Grid<D>::contains(const Vec<D>& x) const
{
	for (int a = 0; a < D; ++a)
		if (!(x[a] >= lower_[a] && x[a] <= upper_[a])) return false;
	return true;
}

TALIK_IN_PLANE_AND_SPACE(Grid);

} // namespace talik
