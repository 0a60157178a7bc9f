// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

namespace talik {

/// Values on the nodes of the grid, a record of Size doubles per node. Fields that one pass over the points writes or reads
/// together may lie in one record: the owner of the record gives columns of it to other fields, which are cleared with it.
template <int Size> class NodeField {
public:
	static constexpr int size = Size;

	void allocate(int nodes)
	{
		constexpr std::size_t line = 64; // no record of 8 numbers lies across two lines of the cache
		count_                     = nodes;
		stride_                    = Size;
		shared_                    = 0;
		const std::size_t total    = static_cast<std::size_t>(nodes) * Size;
		storage_.reset(static_cast<double*>(std::aligned_alloc(line, (total * sizeof(double) + line - 1) / line * line)));
		if (!storage_) throw std::bad_alloc();
		values_ = storage_.get();
		std::fill(values_, values_ + total, 0.0);
	}
	/// The columns first .. first + Other - 1 of every record belong to another field from now on.
	template <int Other> void shareColumns(NodeField<Other>& other, int first)
	{
		static_assert(Other < Size, "a field keeps a part of its record");
		other.storage_.reset();
		other.values_ = values_ + first;
		other.stride_ = stride_;
		other.count_  = count_;
		shared_ += Other;
	}
	void clear(int first, int last)
	{
		if (storage_) std::fill((*this)[first], (*this)[last], 0.0);
	}

	double*       operator[](int node) { return values_ + static_cast<std::ptrdiff_t>(node) * stride_; }
	const double* operator[](int node) const { return values_ + static_cast<std::ptrdiff_t>(node) * stride_; }
	int           stride() const { return stride_; }
	/// False for columns in the records of another field, or if there are no values.
	bool ownsRecords() const { return bool(storage_); }

	std::size_t bytes() const { return static_cast<std::size_t>(count_) * (Size - shared_) * sizeof(double); }

private:
	template <int> friend class NodeField;
	struct Release {
		void operator()(double* p) const { std::free(p); }
	};

	std::unique_ptr<double, Release> storage_;
	double*                          values_ = nullptr;
	int                              count_ = 0, stride_ = Size, shared_ = 0;
};

} // namespace talik
