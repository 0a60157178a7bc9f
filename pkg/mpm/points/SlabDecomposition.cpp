// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/points/SlabDecomposition.hpp>

#include <algorithm>

namespace talik {

namespace {
	/// Rows from the row of cells on with which a strip begins.
	struct Extent {
		int first, end; ///< that this strip and the one below touch
		int beyond;     ///< more on both sides, as far as a solution at the touched nodes reaches: the direction of the thaw front takes nodes
		                ///< two rows away; what stands up to six cells behind an unfrozen one counts for it and the one before, which give water
	};
	constexpr Extent ofNodes { 0, 3, 2 }, ofCells { -1, 1, 7 };
} // namespace

SlabDecomposition::SlabDecomposition(std::shared_ptr<Communicator> communicator, std::function<std::string(const std::string&)> answer)
        : communicator_(std::move(communicator))
        , answer_(std::move(answer))
        , number_(communicator_->enrol(this))
{
	strips_.assign(std::size_t(count()) + 1, 0);
	points_ = strips_;
}

SlabDecomposition::~SlabDecomposition() { communicator_->dismiss(number_); }

namespace {
	/// Of the slabs.
	double largestCost(const std::vector<int>& firstStrips, const std::vector<double>& before)
	{
		double largest = 0.0;
		for (std::size_t r = 0; r + 1 < firstStrips.size(); ++r)
			largest = std::max(largest, before[firstStrips[r + 1]] - before[firstStrips[r]]);
		return largest;
	}
} // namespace

void SlabDecomposition::cut(const std::vector<int>& firstPoints, const Rows& rows)
{
	constexpr double worthMoving = 1.05; // largest cost of a band now over that after the cut
	rows_                        = rows;
	const std::size_t   strips   = firstPoints.size() - 1;
	const bool          weighed  = costs_.size() == strips;
	std::vector<double> before(strips + 1, 0.0);
	for (std::size_t s = 0; s < strips; ++s)
		before[s + 1] = before[s] + (weighed ? costs_[s] : firstPoints[s + 1] - firstPoints[s]);
	std::vector<int> next = fairly(before);
	if (strips_.back() != int(strips) || largestCost(strips_, before) > worthMoving * largestCost(next, before)) strips_ = std::move(next);
	for (int r = 0; r <= count(); ++r)
		points_[r] = firstPoints[strips_[r]];
}

std::vector<int> SlabDecomposition::fairly(const std::vector<double>& before) const
{
	const int        strips = int(before.size()) - 1, n = count();
	std::vector<int> first(std::size_t(n) + 1, 0);
	for (int r = 1; r < n; ++r) {
		// the strip that begins nearest to the rank's share
		const double wanted = before[strips] * r / n;
		int          s      = first[r - 1] + leastStrips;
		while (s < strips - leastStrips * (n - r) && wanted - before[s] > before[s + 1] - wanted)
			++s;
		first[r] = s;
	}
	first[n] = strips;
	return first;
}

SlabDecomposition::Part SlabDecomposition::touched(bool beyond) const
{
	const int  low = firstStrip() * rows_.ofStrip, high = endStrip() * rows_.ofStrip;
	const bool lowest = rank() == 0, highest = rank() + 1 == count();
	const auto first = [&](const Extent& e) { return lowest ? 0 : low + e.first - (beyond ? e.beyond : 0); };
	const auto end   = [&](const Extent& e, int all) { return highest ? all : std::min(all, high + e.end + (beyond ? e.beyond : 0)); };
	return { first(ofNodes), end(ofNodes, rows_.nodes), first(ofCells), end(ofCells, rows_.cells) };
}

template <class Work> void SlabDecomposition::overInterfaces(Work&& work) const
{
	if (rank() > 0) work(Interface { rank() - 1, firstStrip() * rows_.ofStrip, true, firstStrip() % 2 == 0 });
	if (rank() + 1 < count()) work(Interface { rank() + 1, endStrip() * rows_.ofStrip, false, endStrip() % 2 != 0 });
}

std::size_t SlabDecomposition::before(const HaloExchange::Array& a, int row) const
{
	if (a.rowStarts) return std::size_t((*a.rowStarts)[row]) * a.number;
	const int numbers = a.of == HaloExchange::Of::nodes ? row * rows_.nodesOfRow
	        : a.of == HaloExchange::Of::cells           ? row * rows_.cellsOfRow
	                                                    : (row + 1) * rows_.nodesOfRow;
	return std::size_t(numbers) * a.number;
}

void SlabDecomposition::pass(const HaloExchange::Array& a, int neighbour, int first, int end, bool going)
{
	const int         all  = a.of == HaloExchange::Of::nodes ? rows_.nodes : rows_.cells;
	const std::size_t from = before(a, std::clamp(first, 0, all)), to = before(a, std::clamp(end, 0, all));
	if (from < to) (going ? going_ : coming_).push_back({ neighbour, a.begin + from, to - from });
}

void SlabDecomposition::exchange(bool completed)
{
	going_.clear();
	coming_.clear();
	overInterfaces([&](const Interface& m) {
		for (const HaloExchange::Array& a : shared_.arrays) {
			const Extent& e     = a.of == HaloExchange::Of::nodes ? ofNodes : ofCells;
			const int     first = m.row + e.first, end = m.row + e.end;
			pass(a, m.neighbour, first, end, m.even != completed);
			if (!completed || !shared_.beyond) continue;
			pass(a, m.neighbour, first - e.beyond, first, !m.upper);
			pass(a, m.neighbour, end, end + e.beyond, m.upper);
		}
	});
	ranks().pass(going_, coming_);
}

void SlabDecomposition::handOver() { exchange(false); }

void SlabDecomposition::complete()
{
	exchange(true);
	shared_.arrays.clear();
	shared_.beyond = false;
}

void SlabDecomposition::gatherParts(void* values, std::size_t size, const std::vector<int>& begins)
{
	lengths_.resize(std::size_t(count()));
	for (int r = 0; r < count(); ++r)
		lengths_[r] = std::size_t(begins[r + 1] - begins[r]) * size;
	ranks().allGather(static_cast<char*>(values) + std::size_t(begins[rank()]) * size, lengths_, values);
}

void SlabDecomposition::shareByCell(std::vector<unsigned char>& flags)
{
	constexpr int bits   = 8;
	const auto    begin  = [&](int r) { return std::min(strips_[r] * rows_.ofStrip, rows_.cells) * rows_.cellsOfRow; };
	const auto    length = [&](int r) { return (begin(r + 1) - begin(r) + bits - 1) / bits; };
	std::size_t   all    = 0;
	lengths_.resize(std::size_t(count()));
	for (int r = 0; r < count(); ++r)
		all += lengths_[r] = std::size_t(length(r));
	packed_.assign(all, 0);
	std::vector<unsigned char> own(lengths_[rank()], 0);
	for (int c = begin(rank()), k = 0; c < begin(rank() + 1); ++c, ++k)
		own[k / bits] |= flags[c] << k % bits;
	ranks().allGather(own.data(), lengths_, packed_.data());
	const unsigned char* from = packed_.data();
	for (int r = 0; r < count(); from += lengths_[r++])
		for (int c = begin(r), k = 0; c < begin(r + 1); ++c, ++k)
			flags[c] = from[k / bits] >> k % bits & 1;
}

int SlabDecomposition::rankOf(int strip) const { return int(std::upper_bound(strips_.begin() + 1, strips_.end() - 1, strip) - strips_.begin()) - 1; }

unsigned SlabDecomposition::anyOf(unsigned bits)
{
	unsigned all = 0;
	for (const unsigned b : byRank(bits))
		all |= b;
	return all;
}

std::vector<std::string> SlabDecomposition::say(const std::string& own) { return ranks().exchange(std::vector<std::string>(std::size_t(count()), own)); }

void SlabDecomposition::meet(long step) { communicator_->meet("step " + std::to_string(step) + " of a ground in slabs"); }

} // namespace talik
