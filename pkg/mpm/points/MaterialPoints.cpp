// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/points/MaterialPoints.hpp>

#include <algorithm>
#include <numeric>

namespace talik {

template <int D> MaterialPoints<D>::MaterialPoints()
{
	position_ = fields_.declare("position", "points", "m", D);
	volume_   = fields_.declare("volume", "points", D == 2 ? "m^2" : "m^3", 1);
}

template <int D> void MaterialPoints<D>::allocate(int count)
{
	fields_.allocate(count);
	id_.resize(count);
	std::iota(id_.begin(), id_.end(), 0);
	place_   = id_;
	from_    = id_;
	scratch_ = id_;
	skeleton_.assign(count, 0);
	cell_.assign(count, 0);
}

template <int D> void MaterialPoints<D>::distinguishMaterials()
{
	material_.assign(count(), 0);
	materialScratch_ = material_;
}

template <int D> void MaterialPoints<D>::sort(const Grid<D>& grid)
{
	const int n = count();
	for (int p = 0; p < n; ++p) {
		int c = 0;
		for (int a = 0; a < D; ++a) {
			const int i = static_cast<int>((position(a)[p] - grid.lower()[a]) * grid.inverseSpacing());
			c += std::min(std::max(i, 0), grid.cells(a) - 1) * grid.cellStride(a);
		}
		cell_[p] = c;
	}

	cellStart_.assign(grid.cellCount() + 1, 0);
	for (int p = 0; p < n; ++p)
		++cellStart_[cell_[p] + 1];
	for (int c = 0; c < grid.cellCount(); ++c)
		cellStart_[c + 1] += cellStart_[c];

	strips_.axis       = grid.slowAxis();
	const int rowCells = grid.cellStride(strips_.axis);
	const int count    = (grid.cells(strips_.axis) + Strips::rows - 1) / Strips::rows;
	strips_.first.resize(count + 1);
	for (int s = 0; s <= count; ++s)
		strips_.first[s] = cellStart_[std::min(s * Strips::rows * rowCells, grid.cellCount())];

	for (int p = 0; p < n; ++p)
		from_[cellStart_[cell_[p]]++] = p;

	const auto reorder = [&](auto& values, auto& scratch) {
		for (int k = 0; k < n; ++k)
			scratch[k] = values[from_[k]];
		values.swap(scratch);
	};
	fields_.reorder(from_.data());
	reorder(id_, scratch_);
	reorder(skeleton_, scratch_);
	if (!material_.empty()) reorder(material_, materialScratch_);
	idsRestored();
}

template <int D> void MaterialPoints<D>::idsRestored()
{
	for (int k = 0; k < count(); ++k)
		place_[id_[k]] = k;
	++order_;
}

template class MaterialPoints<2>;
template class MaterialPoints<3>;

} // namespace talik
