// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/ranks/RankTalk.hpp>

#include <functional>
#include <vector>

namespace talik {

/// Arrays by rows of nodes, or of cells, to which the points of several strips add. Rows are those along the grid's slowest axis.
class SharedRows {
public:
	struct Array {
		char*                   begin;
		std::size_t             number;    ///< bytes of a node or cell
		bool                    ofCells;   ///< else of nodes
		const std::vector<int>* rowStarts; ///< of the numbers of each row of nodes, where only some nodes have any; null: all have
	};

	template <int Size> void nodes(NodeField<Size>& field)
	{
		if (field.ownsRecords()) arrays.push_back({ reinterpret_cast<char*>(field[0]), Size * sizeof(double), false, nullptr });
	}
	template <class T> void nodes(T* ofNodeZero) { arrays.push_back({ reinterpret_cast<char*>(ofNodeZero), sizeof(T), false, nullptr }); }
	template <class T> void cells(T* ofCellZero) { arrays.push_back({ reinterpret_cast<char*>(ofCellZero), sizeof(T), true, nullptr }); }
	void                    someNodes(double* begin, int numbers, const std::vector<int>& rowStarts)
	{
		arrays.push_back({ reinterpret_cast<char*>(begin), numbers * sizeof(double), false, &rowStarts });
	}

	std::vector<Array> arrays;
};

/// Strips of the ground shared out among ranks: each has a band of consecutive strips and does what is to be done for the points in them.
/// Nodes and cells are those of all ranks, and all know the sums there. Only the band's own points are current until they are gathered.
///
/// A sum at a node has the order that it has on one rank, even strips first, then odd ones: where two bands meet, the rank of the even strip
/// hands the rows over that both strips touch, the rank of the odd strip goes on adding to them, and then all ranks get all rows.
class Bands final : public RankTalk::Answerer {
public:
	/// Strips of how many rows of cells; a point adds to its cell, and to this many nodes from the row of its cell on, strayed points included.
	struct Rows {
		int ofStrip = 0, nodes = 0, cells = 0, nodesOfRow = 0, cellsOfRow = 0;
		int firstNode = 0, lastNode = 0; ///< rows of nodes in use, [first, last)
		int firstCell = 0, lastCell = 0; ///< the same of cells
	};

	Bands(std::shared_ptr<RankTalk> talk, std::function<std::string(const std::string&)> answer);
	~Bands() override;

	int    count() const { return talk_->count(); }
	int    rank() const { return talk_->rank(); }
	Ranks& ranks() const { return talk_->ranks(); }

	/// Cuts the strips anew; firstPoints: place of the first point of each strip, and the end.
	void cut(const std::vector<int>& firstPoints, const Rows& rows);
	int  firstStrip() const { return strips_[rank()]; }
	int  endStrip() const { return strips_[rank() + 1]; }
	int  firstPoint() const { return points_[rank()]; }
	int  endPoint() const { return points_[rank() + 1]; }

	/// To be filled before handOver(), complete() empties it.
	SharedRows& shared() { return shared_; }
	/// Between even and odd strips.
	void handOver();
	/// After the odd strips.
	void complete();

	/// Values by strip, of which every rank has those of its own strips, become known to all.
	template <class T> void shareByStrip(T* values) { gatherParts(values, sizeof(T), strips_); }
	/// The same by point.
	template <class T> void shareByPoint(T* values) { gatherParts(values, sizeof(T), points_); }
	/// The value of the rank that owns the point at a place.
	double valueAt(int place, double own);
	/// Combined bits of all ranks.
	unsigned anyOf(unsigned bits);
	/// What every rank says, by rank.
	std::vector<std::string> say(const std::string& own);
	/// Waits for the others, and answers what they ask.
	void meet(long step);
	/// Asks all ranks; may be called by some of them only.
	std::vector<std::string> ask(const std::string& question) const { return talk_->ask(number_, question); }

	std::string answerTo(const std::string& question) const override { return answer_(question); }

	/// The points of other bands are current too.
	bool allCurrent = true;
	/// Points of the band of a rank.
	std::pair<int, int> pointsOf(int rank) const { return { points_[rank], points_[rank + 1] }; }

private:
	/// Numbers of an array before a row.
	std::size_t before(const SharedRows::Array& array, int row) const;
	void        gatherParts(void* values, std::size_t size, const std::vector<int>& begins);
	void        passBoundary(int strip, int neighbour, bool evenIsMine);

	std::shared_ptr<RankTalk>                      talk_;
	std::function<std::string(const std::string&)> answer_;
	int                                            number_;
	std::vector<int>                               strips_, points_;     ///< first of each rank, and the end
	std::vector<int>                               nodeRows_, cellRows_; ///< the same of rows whose sums are complete on the rank first
	Rows                                           rows_;
	SharedRows                                     shared_;
	std::vector<Parcel>                            going_, coming_;
	std::vector<std::size_t>                       lengths_;
	std::vector<unsigned>                          bits_;
	std::vector<double>                            values_;
};

} // namespace talik
