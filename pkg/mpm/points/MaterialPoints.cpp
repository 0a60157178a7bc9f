// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/points/MaterialPoints.hpp>

#include <algorithm>
#include <cstring>
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
	place_ = id_;
	skeleton_.assign(count, 0);
}

template <int D> void MaterialPoints<D>::distinguishMaterials() { material_.assign(count(), 0); }

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
		int stripOf(int number) const
		{
			const int axis = grid_.slowAxis();
			return number / (D == 2 ? Strips::rows * grid_.cellStride(axis) : (Strips::rows + 1) * grid_.nodeStride(axis));
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
	number_.resize(n);
	for (int p = 0; p < n; ++p)
		number_[p] = order.of(p);
	strips_.first.assign(strips + 1, 0);
	for (int p = 0; p < n; ++p)
		++strips_.first[order.stripOf(number_[p]) + 1];
	std::partial_sum(strips_.first.begin(), strips_.first.end(), strips_.first.begin());
	findOrder(0, order.ofStrip(strips));

	const auto reorder = [&](auto& values, auto& scratch) {
		scratch.resize(n);
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

/// Stable: from_ becomes the order of the points whose numbers are in number_.
template <int D> void MaterialPoints<D>::findOrder(int firstNumber, int endNumber)
{
	const int n = static_cast<int>(number_.size());
	start_.assign(endNumber - firstNumber + 1, 0);
	for (int p = 0; p < n; ++p)
		++start_[number_[p] - firstNumber + 1];
	std::partial_sum(start_.begin(), start_.end(), start_.begin());
	from_.resize(n);
	for (int p = 0; p < n; ++p)
		from_[start_[number_[p] - firstNumber]++] = p;
}

template <int D> void MaterialPoints<D>::sortInBands(const Grid<D>& grid, Bands& bands, const std::function<void()>& cut)
{
	std::array<const double*, D> x;
	for (int a = 0; a < D; ++a)
		x[a] = position(a);
	const Order<D> order(grid, x);
	const int      first = strips_.firstPoint(), end = strips_.endPoint(), ranks = bands.count(), own = bands.rank(), strips = strips_.count();
	number_.resize(end - first);
	std::vector<int> counts(strips, 0);
	for (int p = first; p < end; ++p)
		++counts[order.stripOf(number_[p - first] = order.of(p))];
	counts = bands.sums(counts);
	strips_.first.assign(strips + 1, 0);
	std::partial_sum(counts.begin(), counts.end(), strips_.first.begin() + 1);
	cut();

	// by rank, in the order of their former places: numbers of the points that go there, then what they have
	std::vector<std::vector<int>> going(ranks);
	for (int p = first; p < end; ++p)
		going[bands.rankOf(order.stripOf(number_[p - first]))].push_back(p);
	std::vector<std::string> parcels(ranks);
	for (int r = 0; r < ranks; ++r) {
		if (r == own) continue;
		const auto pack = [&](const auto* values, int firstPlace = 0) {
			for (const int p : going[r])
				parcels[r].append(reinterpret_cast<const char*>(values + p - firstPlace), sizeof *values);
		};
		pack(number_.data(), first);
		pack(id_.data());
		pack(skeleton_.data());
		if (!material_.empty()) pack(material_.data());
		for (const double* array : fields_.arrays())
			pack(array);
	}
	parcels                    = ranks > 1 ? bands.ranks().exchange(parcels) : parcels;
	const std::size_t perPoint = 3 * sizeof(int) + (material_.empty() ? 0 : sizeof material_[0]) + fields_.arrays().size() * sizeof(double);

	// what comes from lower ranks, what stays, what comes from higher ones: the order of the former places
	std::vector<std::size_t> taken(ranks, 0), coming(ranks);
	std::size_t              count = going[own].size();
	for (int r = 0; r < ranks; ++r)
		if (r != own) count += coming[r] = parcels[r].size() / perPoint;
	const auto merged = [&](const auto* present, auto& into, int firstPlace = 0) {
		into.resize(count);
		auto* to = into.data();
		for (int r = 0; r < ranks; ++r) {
			if (r == own) {
				for (const int p : going[own])
					*to++ = present[p - firstPlace];
				continue;
			}
			std::memcpy(to, parcels[r].data() + taken[r], coming[r] * sizeof *to);
			taken[r] += coming[r] * sizeof *to;
			to += coming[r];
		}
	};
	std::vector<int> numbers;
	merged(number_.data(), numbers, first);
	number_.swap(numbers);
	findOrder(order.ofStrip(bands.firstStrip()), order.ofStrip(bands.endStrip()));
	const int  begin = bands.firstPoint();
	const auto place = [&](auto* values, auto& scratch) {
		merged(values, scratch);
		for (std::size_t k = 0; k < count; ++k)
			values[begin + k] = scratch[from_[k]];
	};
	place(id_.data(), scratch_);
	place(skeleton_.data(), scratch_);
	if (!material_.empty()) place(material_.data(), materialScratch_);
	std::vector<double> numbersOfArray;
	for (double* array : fields_.arrays())
		place(array, numbersOfArray);
	bands.shareByPoint(id_.data());
	bands.shareByPoint(skeleton_.data());
	if (!material_.empty()) bands.shareByPoint(material_.data());
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
