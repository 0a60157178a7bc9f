// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/points/Bands.hpp>

#include <algorithm>

namespace talik {

namespace {
	/// Rows of nodes and cells that two neighbouring strips touch, from the row of cells on with which the upper one begins.
	constexpr int firstSharedNode = 0, endSharedNode = 3, firstSharedCell = -1, endSharedCell = 1;
} // namespace

Bands::Bands(std::shared_ptr<RankTalk> talk, std::function<std::string(const std::string&)> answer)
        : talk_(std::move(talk))
        , answer_(std::move(answer))
        , number_(talk_->enrol(this))
{
	const std::size_t n = static_cast<std::size_t>(count());
	strips_.assign(n + 1, 0);
	points_ = nodeRows_ = cellRows_ = strips_;
	lengths_.assign(n, 0);
	bits_.assign(n, 0);
	values_.assign(n, 0.0);
}

Bands::~Bands() { talk_->dismiss(number_); }

void Bands::cut(const std::vector<int>& firstPoints, const Rows& rows)
{
	rows_            = rows;
	const int strips = static_cast<int>(firstPoints.size()) - 1, n = count();
	strips_[0] = points_[0] = 0;
	nodeRows_[0]            = rows.firstNode;
	cellRows_[0]            = rows.firstCell;
	for (int r = 1; r <= n; ++r) {
		// the strip that begins nearest to the rank's share of the points; every band has one strip at least
		const double wanted = static_cast<double>(firstPoints[strips]) * r / n;
		int          s      = strips_[r - 1] + 1;
		while (s < strips - (n - r) && wanted - firstPoints[s] > firstPoints[s + 1] - wanted)
			++s;
		strips_[r]     = r == n ? strips : s;
		points_[r]     = firstPoints[strips_[r]];
		const int  row = strips_[r] * rows.ofStrip;
		const bool odd = strips_[r] % 2 != 0;
		nodeRows_[r]   = r == n ? rows.lastNode : std::clamp(row + (odd ? firstSharedNode : endSharedNode), nodeRows_[r - 1], rows.lastNode);
		cellRows_[r]   = r == n ? rows.lastCell : std::clamp(row + (odd ? firstSharedCell : endSharedCell), cellRows_[r - 1], rows.lastCell);
	}
}

std::size_t Bands::before(const SharedRows::Array& a, int row) const
{
	if (a.rowStarts) return static_cast<std::size_t>((*a.rowStarts)[row]) * a.number;
	return static_cast<std::size_t>(row) * (a.ofCells ? rows_.cellsOfRow : rows_.nodesOfRow) * a.number;
}

void Bands::passBoundary(int strip, int neighbour, bool evenIsMine)
{
	const int row = strip * rows_.ofStrip;
	for (const SharedRows::Array& a : shared_.arrays) {
		const int all  = a.ofCells ? rows_.cells : rows_.nodes;
		const int from = row + (a.ofCells ? firstSharedCell : firstSharedNode), to = std::min(all, row + (a.ofCells ? endSharedCell : endSharedNode));
		const std::size_t begin = before(a, from), end = before(a, to);
		if (begin < end) (evenIsMine ? going_ : coming_).push_back({ neighbour, a.begin + begin, end - begin });
	}
}

void Bands::handOver()
{
	going_.clear();
	coming_.clear();
	if (rank() > 0) passBoundary(firstStrip(), rank() - 1, firstStrip() % 2 == 0);
	if (rank() + 1 < count()) passBoundary(endStrip(), rank() + 1, endStrip() % 2 != 0);
	ranks().pass(going_, coming_);
}

void Bands::complete()
{
	for (const SharedRows::Array& a : shared_.arrays) {
		const std::vector<int>& begins = a.ofCells ? cellRows_ : nodeRows_;
		for (int r = 0; r < count(); ++r)
			lengths_[r] = before(a, begins[r + 1]) - before(a, begins[r]);
		ranks().allGather(a.begin + before(a, begins[rank()]), lengths_, a.begin + before(a, begins[0]));
	}
	shared_.arrays.clear();
}

void Bands::gatherParts(void* values, std::size_t size, const std::vector<int>& begins)
{
	for (int r = 0; r < count(); ++r)
		lengths_[r] = static_cast<std::size_t>(begins[r + 1] - begins[r]) * size;
	ranks().allGather(static_cast<char*>(values) + static_cast<std::size_t>(begins[rank()]) * size, lengths_, values);
}

double Bands::valueAt(int place, double own)
{
	std::fill(lengths_.begin(), lengths_.end(), sizeof(double));
	ranks().allGather(&own, lengths_, values_.data());
	return values_[std::upper_bound(points_.begin() + 1, points_.end() - 1, place) - points_.begin() - 1];
}

unsigned Bands::anyOf(unsigned bits)
{
	std::fill(lengths_.begin(), lengths_.end(), sizeof(unsigned));
	ranks().allGather(&bits, lengths_, bits_.data());
	unsigned all = 0;
	for (const unsigned b : bits_)
		all |= b;
	return all;
}

std::vector<std::string> Bands::say(const std::string& own) { return ranks().exchange(std::vector<std::string>(static_cast<std::size_t>(count()), own)); }

void Bands::meet(long step)
{
	talk_->meet("step " + std::to_string(step) + " of a ground in bands");
	allCurrent = false;
}

} // namespace talik
