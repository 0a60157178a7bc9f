// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/points/MaterialPoints.hpp>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

namespace talik {

template <int D> MaterialPoints<D>::MaterialPoints()
{
	position_ = fields_.declare("position", "points", "m", D);
	volume_   = fields_.declare("volume", "points", D == 2 ? "m^2" : "m^3", 1);
}

template <int D> void MaterialPoints<D>::allocate(int count, int capacity)
{
	fields_.allocate(count, capacity);
	resize(count);
	std::iota(id_.begin(), id_.end(), 0);
	place_ = id_;
}

template <int D> void MaterialPoints<D>::resize(int count)
{
	fields_.resize(count);
	id_.resize(count);
	place_.resize(count);
	skeleton_.resize(count);
	if (!material_.empty()) material_.resize(count);
}

template <int D> std::vector<int> MaterialPoints<D>::divide(const std::vector<PointDivision>& own)
{
	const int        first = strips_.firstPoint(), end = strips_.endPoint(), before = count();
	std::vector<int> added(strips_.count(), 0), parents;
	int              strip = strips_.begin(), earlier = 0; // divisions of lower ranks
	for (const PointDivision& division : own) {
		while (division.place >= strips_.first[strip + 1])
			++strip;
		++added[strip];
		parents.push_back(id_[division.place]);
	}
	if (strips_.slabs) {
		added = strips_.slabs->sums(added);
		for (int s = 0; s < strips_.begin(); ++s)
			earlier += added[s];
		parents = strips_.slabs->ofAll(parents);
	}
	if (parents.empty()) return parents;
	resize(before + int(parents.size()));
	const int        at = first + earlier;
	std::vector<int> halves;
	from_.clear();
	for (int p = first, k = 0; p < end; ++p) {
		from_.push_back(p);
		if (k == int(own.size()) || own[k].place != p) continue;
		from_.push_back(p);
		const int here = at + p + ++k - first;
		halves.insert(halves.end(), { here - 1, here });
	}
	reorder(at);
	fields_.halve(halves);
	for (std::size_t k = 0; k < own.size(); ++k) {
		double* const x = position(own[k].axis) + halves[2 * k];
		x[0] -= own[k].distance;
		x[1] += own[k].distance;
		id_[halves[2 * k + 1]] = before + earlier + int(k);
	}
	for (int s = 0, sum = 0; s < strips_.count(); ++s)
		strips_.first[s + 1] += sum += added[s];
	return parents;
}

template <int D> void MaterialPoints<D>::distinguishMaterials() { material_.assign(count(), 0); }

namespace {
	/// Order of the points. In the plane it is that of their cells. In space points with the same support follow each other within a strip,
	/// so that the loops over nodes may keep the support in registers; it changes in the middle of a cell.
	template <int D> class Order {
	public:
		explicit Order(const Grid<D>& grid)
		        : grid_(grid)
		{}
		int of(const Vec<D>& x) const
		{
			int number = 0;
			for (int a = 0; a < D; ++a) {
				const double cells = (x[a] - grid_.lower()[a]) * grid_.inverseSpacing();
				if (D == 2) {
					number += std::clamp(int(cells), 0, grid_.cells(a) - 1) * grid_.cellStride(a);
					continue;
				}
				const int half  = std::clamp(int(2.0 * cells), 0, 2 * grid_.cells(a) - 1);
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
		const Grid<D>& grid_;
	};
} // namespace

/// Strips, and from_, the order of all points, which are at these positions.
template <int D> template <class At> void MaterialPoints<D>::findStrips(const Grid<D>& grid, At&& at)
{
	const int      n = count();
	const Order<D> order(grid);
	strips_.axis     = grid.slowAxis();
	const int strips = (grid.cells(strips_.axis) + Strips::rows - 1) / Strips::rows;
	number_.resize(n);
	for (int p = 0; p < n; ++p)
		number_[p] = order.of(at(p));
	strips_.first.assign(strips + 1, 0);
	for (int p = 0; p < n; ++p)
		++strips_.first[order.stripOf(number_[p]) + 1];
	std::partial_sum(strips_.first.begin(), strips_.first.end(), strips_.first.begin());
	findOrder(0, order.ofStrip(strips));
}

template <int D> void MaterialPoints<D>::wrap(const Grid<D>& grid, int first, int last)
{
	for (int a = 0; a < D; ++a)
		for (double* x = position(a) + first; grid.isPeriodic(a) && x < position(a) + last; ++x)
			if (*x < grid.lower()[a]) *x += grid.width(a);
			else if (*x > grid.upper()[a]) *x -= grid.width(a);
}

template <int D> void MaterialPoints<D>::arrange(const Grid<D>& grid, const std::function<Vec<D>(int)>& at)
{
	findStrips(grid, at);
	id_.swap(from_);
	idsRestored();
}

template <int D> void MaterialPoints<D>::sort(const Grid<D>& grid)
{
	findStrips(grid, [&](int p) { return this->at(p); });
	reorder(0);
	idsRestored();
}

/// The places from `at` on receive all that is at those in from_.
template <int D> void MaterialPoints<D>::reorder(int at)
{
	const auto take = [&](auto& values, auto& scratch) {
		scratch.resize(from_.size());
		for (std::size_t k = 0; k < from_.size(); ++k)
			scratch[k] = values[from_[k]];
		std::copy(scratch.begin(), scratch.end(), values.begin() + at);
	};
	fields_.reorder(from_, at);
	take(id_, scratch_);
	take(skeleton_, scratch_);
	if (!material_.empty()) take(material_, materialScratch_);
}

/// Stable: from_ becomes the order of the points whose numbers are in number_.
template <int D> void MaterialPoints<D>::findOrder(int firstNumber, int endNumber)
{
	const int n = int(number_.size());
	start_.assign(endNumber - firstNumber + 1, 0);
	for (int p = 0; p < n; ++p)
		++start_[number_[p] - firstNumber + 1];
	std::partial_sum(start_.begin(), start_.end(), start_.begin());
	from_.resize(n);
	for (int p = 0; p < n; ++p)
		from_[start_[number_[p] - firstNumber]++] = p;
}

namespace {
	/// Points that go from rank to rank. What comes from lower ranks, what stays and what comes from higher ones is in the order of their
	/// former places.
	class Crossing {
	public:
		/// going: places of the points that go to each rank, this one included.
		Crossing(SlabDecomposition& slabs, std::vector<std::vector<int>> going)
		        : slabs_(slabs)
		        , going_(std::move(going))
		        , parcels_(going_.size())
		        , taken_(going_.size(), 0)
		{}
		/// Packs values of these points; firstPlace: that of values[0].
		template <class T> void pack(const T* values, int firstPlace = 0)
		{
			perPoint_ += sizeof(T);
			for (std::size_t r = 0; r < parcels_.size(); ++r)
				for (const int p : going_[r])
					if (!isOwn(r)) parcels_[r].append(reinterpret_cast<const char*>(values + p - firstPlace), sizeof(T));
		}
		void exchange()
		{
			parcels_ = slabs_.ranks().exchange(parcels_);
			for (std::size_t r = 0; r < parcels_.size(); ++r)
				count_ += isOwn(r) ? going_[r].size() : coming(r);
		}
		/// Values of all points that are here now, in the order in which they were packed.
		template <class T> void merge(const T* present, std::vector<T>& into, int firstPlace = 0)
		{
			into.resize(count_);
			T* to = into.data();
			for (std::size_t r = 0; r < parcels_.size(); ++r) {
				if (isOwn(r)) {
					for (const int p : going_[r])
						*to++ = present[p - firstPlace];
					continue;
				}
				std::memcpy(to, parcels_[r].data() + taken_[r], coming(r) * sizeof(T));
				taken_[r] += coming(r) * sizeof(T);
				to += coming(r);
			}
		}
		/// The same, and puts them in order from a place on; from: index among the merged ones.
		template <class T> void place(T* values, int firstPlace, const std::vector<int>& from)
		{
			std::vector<T> merged;
			merge(values, merged);
			for (std::size_t k = 0; k < count_; ++k)
				values[firstPlace + k] = merged[from[k]];
		}

	private:
		bool        isOwn(std::size_t r) const { return int(r) == slabs_.rank(); }
		std::size_t coming(std::size_t r) const { return parcels_[r].size() / perPoint_; }

		SlabDecomposition&            slabs_;
		std::vector<std::vector<int>> going_;
		std::vector<std::string>      parcels_;
		std::vector<std::size_t>      taken_; ///< bytes of each parcel
		std::size_t                   perPoint_ = 0, count_ = 0;
	};
} // namespace

template <int D> void MaterialPoints<D>::sortInSlabs(const Grid<D>& grid, SlabDecomposition& slabs, const double* cost, const std::function<void()>& cut)
{
	const Order<D>      order(grid);
	const int           first = strips_.firstPoint(), end = strips_.endPoint();
	std::vector<int>    counts(strips_.count(), 0);
	std::vector<double> costs(strips_.count(), 0.0);
	number_.resize(end - first);
	for (int p = first; p < end; ++p) {
		const int strip = order.stripOf(number_[p - first] = order.of(at(p)));
		++counts[strip];
		if (cost) costs[strip] += cost[p];
	}
	counts = slabs.sums(counts);
	if (cost) slabs.weigh(slabs.sums(costs));
	std::partial_sum(counts.begin(), counts.end(), strips_.first.begin() + 1);
	cut();

	std::vector<std::vector<int>> going(slabs.count());
	for (int p = first; p < end; ++p)
		going[slabs.rankOf(order.stripOf(number_[p - first]))].push_back(p);
	Crossing crossing(slabs, std::move(going));
	crossing.pack(number_.data(), first);
	crossing.pack(id_.data());
	crossing.pack(skeleton_.data());
	if (!material_.empty()) crossing.pack(material_.data());
	for (const double* array : fields_.arrays())
		crossing.pack(array);
	crossing.exchange();

	std::vector<int> numbers;
	crossing.merge(number_.data(), numbers, first);
	number_.swap(numbers);
	findOrder(order.ofStrip(slabs.firstStrip()), order.ofStrip(slabs.endStrip()));
	const int begin = slabs.firstPoint();
	crossing.place(id_.data(), begin, from_);
	crossing.place(skeleton_.data(), begin, from_);
	if (!material_.empty()) crossing.place(material_.data(), begin, from_);
	for (double* array : fields_.arrays())
		crossing.place(array, begin, from_);
	slabs.shareByPoint(id_.data());
	slabs.shareByPoint(skeleton_.data());
	if (!material_.empty()) slabs.shareByPoint(material_.data());
	idsRestored();
}

template <int D> void MaterialPoints<D>::idsRestored()
{
	for (int k = 0; k < count(); ++k)
		place_[id_[k]] = k;
	++order_;
}

TALIK_IN_PLANE_AND_SPACE(MaterialPoints);

} // namespace talik
