// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/PagedArray.hpp>
#include <pkg/mpm/grid/Vector.hpp>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace talik {

/// A node that periodic sides repeat, and the node between them whose values it has.
struct NodeImage {
	int node, original;
};

/// Uniform grid of nodes over the box [lower, upper], extended by one ghost layer on every side.
/// Node coordinates count from the ghost layer: along each axis node 0 is the ghost, node 1 lies on the lower wall, node
/// cells+1 on the upper wall and node cells+2 is the upper ghost. Nodes and cells are numbered so that the longest axis varies
/// slowest, because the strips that threads work on are stacked along it.
template <int D> class Grid {
public:
	Grid() = default;
	/// spacing [m] > 0; upper - lower must be a whole number (>= 1) of spacings along each axis.
	/// Throws std::invalid_argument naming attribute, value and remedy.
	Grid(const Vec<D>& lower, const Vec<D>& upper, double spacing);

	double        spacing() const { return spacing_; }
	double        inverseSpacing() const { return inverseSpacing_; }
	const Vec<D>& lower() const { return lower_; }
	const Vec<D>& upper() const { return upper_; }

	int cells(int axis) const { return cells_[axis]; }
	int nodes(int axis) const { return cells_[axis] + 3; }
	int nodeStride(int axis) const { return nodeStride_[axis]; }
	int cellStride(int axis) const { return cellStride_[axis]; }
	int nodeCount() const { return nodeCount_; }
	int cellCount() const { return cellCount_; }
	int slowAxis() const { return slowAxis_; }
	/// Whether this is a slice of space: one cell thick in one direction, and in one only.
	bool isSlice() const { return D == 3 && std::count(cells_.begin(), cells_.end(), 1) == 1; }

	/// The plane turns about x = 0: x is the radius, and volumes and areas are those of a radian.
	void turn() { turned_ = true; }
	bool isTurned() const { return turned_; }
	/// work(measure) with what measure(x) multiplies areas of the plane by: the radius x, or the compiler's constant 1 where nothing turns.
	template <class Work> decltype(auto) measured(Work&& work) const
	{
		if constexpr (D == 2)
			if (turned_) return work([](double x) { return x; });
		return work([](double) { return 1.0; });
	}
	double measureAt(double x) const { return turned_ ? x : 1.0; }
	/// The same at the middle of a cell, and at the face between a cell and the next one along an axis.
	double measureOfCell(int cell) const { return turned_ ? middle(cell) : 1.0; }
	double measureOfFace(int cell, int axis) const { return turned_ && axis == 0 ? middle(cell) + 0.5 * spacing_ : measureOfCell(cell); }
	/// Middle of a cell along the first axis [m].
	double middle(int cell) const { return lower_[0] + (place(cell, 0) + 0.5) * spacing_; }

	/// Joins both sides of an axis: the ground goes on behind one of them as it begins at the other.
	void joinSides(int axis);
	bool isPeriodic(int axis) const { return periodic_[axis]; }
	/// Width of the box along an axis [m].
	double width(int axis) const { return cells_[axis] * spacing_; }
	/// All nodes that periodic sides repeat; empty without such sides.
	const std::vector<NodeImage>& images() const { return images_; }
	/// The node between periodic sides whose values a node has: itself, if it lies there.
	int original(int node) const { return originals_.empty() ? node : originals_[node]; }

	/// Which cell along an axis a cell is, from 0 on.
	int place(int cell, int axis) const { return cell / cellStride_[axis] % cells_[axis]; }
	/// The next cell along an axis on one side (-1, 1); -1 behind a side of the box that is not periodic.
	int neighbour(int cell, int axis, int side) const
	{
		const int at = place(cell, axis) + side;
		if (at >= 0 && at < cells_[axis]) return cell + side * cellStride_[axis];
		return periodic_[axis] ? cell - side * (cells_[axis] - 1) * cellStride_[axis] : -1;
	}
	/// Which cell along an axis a place in the box lies in; the upper side belongs to the last.
	int placeOf(int axis, double x) const { return std::min(int((x - lower_[axis]) * inverseSpacing_), cells_[axis] - 1); }
	/// The cell in which a place in the box lies.
	int cellOf(const Vec<D>& x) const
	{
		int cell = 0;
		for (int a = 0; a < D; ++a)
			cell += placeOf(a, x[a]) * cellStride_[a];
		return cell;
	}
	/// The cell at these places; behind periodic sides that which is repeated there, behind others -1.
	int cellAt(const std::array<int, D>& places) const;

	/// Volume (area per metre of thickness in 2-D) of a cell [m^D].
	double cellVolume() const;
	/// Area (length per metre of thickness in 2-D) of a cell's face [m^(D-1)].
	double faceArea() const { return cellVolume() * inverseSpacing_; }

	/// Position in node coordinates: 1 on the lower wall, cells+1 on the upper wall.
	double nodeCoordinate(int axis, double x) const { return (x - lower_[axis]) * inverseSpacing_ + 1.0; }
	double nodePosition(int axis, int node) const { return lower_[axis] + (node - 1) * spacing_; }

	int                nodeIndex(const std::array<int, D>& node) const;
	std::array<int, D> nodeOf(int index) const;

	bool contains(const Vec<D>& x) const;

private:
	Vec<D>             lower_ {}, upper_ {};
	double             spacing_ = 0.0, inverseSpacing_ = 0.0;
	std::array<int, D> cells_ {}, nodeStride_ {}, cellStride_ {};
	int                nodeCount_ = 0, cellCount_ = 0, slowAxis_ = D - 1;

	bool                   turned_ = false;
	std::array<bool, D>    periodic_ {};
	std::vector<NodeImage> images_;
	std::vector<int>       originals_; ///< empty without periodic sides
};

/// Numbers of nodes, which at(node) points to, null for none: those of each node and its images are added up, and all of them get the sum.
template <class At> void foldImages(const std::vector<NodeImage>& images, int numbers, At&& at)
{
	const auto over = [&](auto&& work) {
		for (const NodeImage& image : images)
			if (double* const repeated = at(image.node))
				for (int k = 0; k < numbers; ++k)
					work(at(image.original)[k], repeated[k]);
	};
	over([](double& original, double& repeated) { original += repeated; });
	over([](double& original, double& repeated) { repeated = original; });
}

/// Values on the nodes of the grid, a record of Size doubles per node. Fields that one pass over the points writes or reads
/// together may lie in one record: the owner of the record gives columns of it to other fields, which are cleared with it.
template <int Size> class NodeField {
public:
	static constexpr int size = Size;

	void allocate(int nodes)
	{
		// its first number begins a line of the cache: no record of 8 numbers lies across two
		count_  = nodes;
		stride_ = Size;
		shared_ = 0;
		storage_.reset(std::size_t(nodes) * Size);
		values_ = storage_.data();
	}
	/// The columns first .. first + Other - 1 of every record belong to another field from now on.
	template <int Other> void shareColumns(NodeField<Other>& other, int first)
	{
		static_assert(Other < Size, "a field keeps a part of its record");
		other.storage_.reset(0);
		other.values_ = values_ + first;
		other.stride_ = stride_;
		other.count_  = count_;
		shared_ += Other;
	}
	void clear(int first, int last)
	{
		if (ownsRecords()) std::fill((*this)[first], (*this)[last], 0.0);
	}
	/// All but the nodes [first, last) are zero and take no memory.
	void keepOnly(int first, int last) { storage_.keepOnly(std::size_t(first) * Size, std::size_t(last) * Size); }

	double*       operator[](int node) { return values_ + std::ptrdiff_t(node) * stride_; }
	const double* operator[](int node) const { return values_ + std::ptrdiff_t(node) * stride_; }
	int           stride() const { return stride_; }
	/// False for columns in the records of another field, or if there are no values.
	bool ownsRecords() const { return !storage_.empty(); }

	std::size_t bytes() const { return std::size_t(count_) * (Size - shared_) * sizeof(double); }

private:
	template <int> friend class NodeField;
	PagedArray<double> storage_;
	double*            values_ = nullptr;
	int                count_ = 0, stride_ = Size, shared_ = 0;
};

} // namespace talik
