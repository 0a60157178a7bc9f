// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/ranks/Communicator.hpp>
#include <pkg/ranks/PartedFile.hpp>

#include <functional>
#include <vector>

namespace talik {

/// Arrays by nodes, or by cells, to which the points of several strips add, and points at both of two periodic sides. Rows are those along the
/// grid's slowest axis.
class HaloExchange {
public:
	enum class Of { nodes, cells, cellsByNode };
	struct Array {
		char*                   begin;
		std::size_t             number; ///< bytes of a node or cell
		Of                      of;
		const std::vector<int>* rowStarts; ///< of the numbers of each row of nodes, where only some nodes have any; null: all have
		int                     summed;    ///< numbers at the beginning of a record of a node that points add to
		const int*              slots;     ///< where only some nodes have a record: which one a node has, -1 for none
	};

	/// summed: numbers at the beginning of a record that points add to.
	template <int Size> void nodes(NodeField<Size>& field, int summed = Size)
	{
		if (field.ownsRecords()) add(field[0], Size, Of::nodes, nullptr, summed);
	}
	template <class T> void cells(T* ofCellZero) { add(ofCellZero, 1, Of::cells); }
	/// Of cells, each at the place of the node at its lower corner.
	template <class T> void cellsByNode(T* ofNodeZero) { add(ofNodeZero, 1, Of::cellsByNode); }
	void                    someNodes(double* begin, int numbers, const std::vector<int>& rowStarts, const int* slots)
	{
		add(begin, numbers, Of::nodes, &rowStarts, numbers, slots);
	}

	/// After all points have added: nodes that periodic sides repeat have the sums of all that they are.
	void fold(const std::vector<NodeImage>& images)
	{
		for (const Array& a : arrays) {
			const auto record = [&](int node) {
				const int place = a.slots ? a.slots[node] : node;
				return place < 0 ? nullptr : reinterpret_cast<double*>(a.begin + place * a.number);
			};
			if (a.of == Of::nodes) foldImages(images, a.summed, record);
		}
		arrays.clear();
	}

	std::vector<Array> arrays;
	bool               beyond = false; ///< the rows beyond those that both slabs touch are to be known, too

private:
	template <class T> void add(T* begin, int count, Of of, const std::vector<int>* rowStarts = nullptr, int summed = 0, const int* slots = nullptr)
	{
		arrays.push_back({ reinterpret_cast<char*>(begin), count * sizeof(T), of, rowStarts, summed, slots });
	}
};

/// Strips of the ground shared out among ranks: each has a slab of consecutive strips and does what is to be done for the points in them, and
/// at the nodes and cells that these reach. Numbers of nodes, cells and points are those of the whole ground. Only the slab's own points are
/// current until they are gathered.
///
/// A sum at a node has the order that it has on one rank, even strips first, then odd ones: where two slabs meet, the rank of the even strip
/// hands the rows over that both strips touch, the rank of the odd strip goes on adding to them and gives them back.
class SlabDecomposition final : public Communicator::Answerer {
public:
	/// Strips of how many rows of cells; a point adds to its cell, and to this many nodes from the row of its cell on, strayed points included.
	struct Rows {
		int ofStrip = 0, nodes = 0, cells = 0, nodesOfRow = 0, cellsOfRow = 0;
	};
	/// Rows of nodes and of cells.
	struct Part {
		int firstNode, endNode, firstCell, endCell;
	};
	/// A slab has as many strips at least: the rows that its neighbours want to know are then its own.
	static constexpr int leastStrips = 2;

	SlabDecomposition(std::shared_ptr<Communicator> communicator, std::function<std::string(const std::string&)> answer);
	~SlabDecomposition() override;

	int    count() const { return communicator_->count(); }
	int    rank() const { return communicator_->rank(); }
	Ranks& ranks() const { return communicator_->ranks(); }

	/// What each strip has cost, to be shared out from the next cut on; empty: points cost alike.
	void weigh(std::vector<double> costs) { costs_ = std::move(costs); }
	/// Cuts the strips anew, unless they are shared out well enough; firstPoints: place of the first point of each strip, and the end. What is
	/// computed does not depend on the cut.
	void cut(const std::vector<int>& firstPoints, const Rows& rows);
	int  firstStrip() const { return strips_[rank()]; }
	int  endStrip() const { return strips_[rank() + 1]; }
	int  firstPoint() const { return points_[rank()]; }
	int  endPoint() const { return points_[rank() + 1]; }
	/// Rows that the points of the slab touch; beyond: and as many more as are needed to solve there.
	Part touched(bool beyond) const;

	/// To be filled before handOver(), complete() empties it.
	HaloExchange& shared() { return shared_; }
	/// Between even and odd strips.
	void handOver();
	/// After the odd strips.
	void complete();

	/// Values by strip, of which every rank has those of its own strips, become known to all.
	template <class T> void shareByStrip(T* values) { gatherParts(values, sizeof(T), strips_); }
	/// The same by point.
	template <class T> void shareByPoint(T* values) { gatherParts(values, sizeof(T), points_); }
	/// The same by cell, of which every rank has those of its own strips; 0 or 1.
	void shareByCell(std::vector<unsigned char>& flags);
	/// What each rank has.
	template <class T> std::vector<T> byRank(const T& own)
	{
		auto all = std::vector<T>(std::size_t(count()));
		lengths_.assign(all.size(), sizeof(T));
		ranks().allGather(&own, lengths_, all.data());
		return all;
	}
	/// Sums over all ranks, in their order, number by number.
	template <class T> std::vector<T> sums(const std::vector<T>& own)
	{
		const std::size_t n = own.size();
		std::vector<T>    all(n * std::size_t(count())), sums(n, T(0));
		lengths_.assign(std::size_t(count()), n * sizeof(T));
		ranks().allGather(own.data(), lengths_, all.data());
		for (std::size_t k = 0; k < all.size(); ++k)
			sums[k % n] += all[k];
		return sums;
	}
	/// What all ranks have, in their order.
	template <class T> std::vector<T> ofAll(const std::vector<T>& own)
	{
		std::size_t              n = 0;
		std::vector<std::size_t> lengths;
		for (const std::size_t size : byRank(own.size()))
			lengths.push_back(size * sizeof(T)), n += size;
		std::vector<T> all(n);
		if (n > 0) ranks().allGather(own.data(), lengths, all.data());
		return all;
	}
	/// The rank whose slab has a strip.
	int rankOf(int strip) const;
	/// Combined bits of all ranks.
	unsigned anyOf(unsigned bits);
	/// What every rank says, by rank.
	std::vector<std::string> say(const std::string& own);
	/// Waits for the others, and answers what they ask.
	void meet(long step);
	/// Asks all ranks; may be called by some of them only.
	std::vector<std::string> ask(const std::string& question) const { return communicator_->ask(number_, question); }

	std::string answerTo(const std::string& question) const override { return answer_(question); }

	/// Lets every rank write its part of a file, at its own place behind this one; may be called by one of them only. Returns the sum of all
	/// parts. Throws std::runtime_error with the rank and the reason.
	std::uint64_t write(const FilePlace& place) const { return sumOfParts(*communicator_, number_, place.text()); }
	std::string   carryOut(const std::string& place) const override
	{
		return partWritten([&](PartSum& sum) { writes(FilePlace::from(place), sum); });
	}
	std::function<void(const FilePlace&, PartSum&)> writes;

	/// Whether the numbers of the point at a place are current here.
	bool has(int place) const { return allCurrent || (place >= firstPoint() && place < endPoint()); }
	/// The points of other slabs are current too.
	bool allCurrent = true;
	/// Points of the slab of a rank.
	std::pair<int, int> pointsOf(int rank) const { return { points_[rank], points_[rank + 1] }; }

private:
	/// Where the slab of this rank meets the next one.
	struct Interface {
		int  neighbour, row; ///< rank of the other slab, and the first row of cells of the upper one
		bool upper, even;    ///< this slab is the upper one; its strip here is an even one
	};
	template <class Work> void overInterfaces(Work&& work) const;
	/// First strip of each slab, and the end, of slabs that cost alike as far as whole strips allow; before: cost of the strips before each.
	std::vector<int> fairly(const std::vector<double>& before) const;
	/// Numbers of an array before a row.
	std::size_t before(const HaloExchange::Array& array, int row) const;
	void        gatherParts(void* values, std::size_t size, const std::vector<int>& begins);
	void        pass(const HaloExchange::Array& array, int neighbour, int first, int end, bool going);
	void        exchange(bool completed);

	std::shared_ptr<Communicator>                  communicator_;
	std::function<std::string(const std::string&)> answer_;
	int                                            number_;
	std::vector<int>                               strips_, points_; ///< first of each rank, and the end
	std::vector<double>                            costs_;           ///< of each strip; empty: that of its points
	Rows                                           rows_;
	HaloExchange                                   shared_;
	std::vector<Parcel>                            going_, coming_;
	std::vector<std::size_t>                       lengths_;
	std::vector<unsigned char>                     packed_;
};

} // namespace talik
