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
	number_.assign(count, 0);
}

template <int D> void MaterialPoints<D>::distinguishMaterials()
{
	material_.assign(count(), 0);
	materialScratch_ = material_;
}

namespace {
	/// Order of the points. In the plane it is that of their cells. In space points with the same support follow each other within a strip,
	/// so that the loops over nodes may keep the support in registers; it changes in the middle of a cell.
	template <int D> class Order {
	public:
		Order(const Grid<D>& grid, const std::array<const double*, D>& position)
		        : grid_(grid)
		        , position_(position)
		{}
		int of(int p) const
		{
			int number = 0;
			for (int a = 0; a < D; ++a) {
				const double cells = (position_[a][p] - grid_.lower()[a]) * grid_.inverseSpacing();
				if (D == 2) {
					number += std::clamp(static_cast<int>(cells), 0, grid_.cells(a) - 1) * grid_.cellStride(a);
					continue;
				}
				const int half  = std::clamp(static_cast<int>(2.0 * cells), 0, 2 * grid_.cells(a) - 1);
				const int strip = a == grid_.slowAxis() ? half / (2 * Strips::rows) : 0;
				number += ((half + 1) / 2 + strip) * grid_.nodeStride(a);
			}
			return number;
		}
		/// Smallest number of a strip.
		int ofStrip(int strip) const
		{
			const int axis = grid_.slowAxis();
			return D == 2 ? std::min(strip * Strips::rows * grid_.cellStride(axis), grid_.cellCount())
			              : strip * (Strips::rows + 1) * grid_.nodeStride(axis);
		}

	private:
		const Grid<D>&               grid_;
		std::array<const double*, D> position_;
	};
} // namespace

template <int D> void MaterialPoints<D>::sort(const Grid<D>& grid)
{
	const int                          n = count();
	const std::array<const double*, D> x = positions();
	const Order<D>                     order(grid, x);
	strips_.axis     = grid.slowAxis();
	const int strips = (grid.cells(strips_.axis) + Strips::rows - 1) / Strips::rows;
	for (int p = 0; p < n; ++p)
		number_[p] = order.of(p);

	start_.assign(order.ofStrip(strips) + 1, 0);
	for (int p = 0; p < n; ++p)
		++start_[number_[p] + 1];
	for (std::size_t k = 1; k < start_.size(); ++k)
		start_[k] += start_[k - 1];
	strips_.first.resize(strips + 1);
	for (int s = 0; s <= strips; ++s)
		strips_.first[s] = start_[order.ofStrip(s)];

	for (int p = 0; p < n; ++p)
		from_[start_[number_[p]]++] = p;

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
