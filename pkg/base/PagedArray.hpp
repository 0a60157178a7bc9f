// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <utility>

namespace talik {

/// Bytes that are zero, and take memory only where they were written to.
class PagedMemory {
public:
	PagedMemory() = default;
	explicit PagedMemory(std::size_t bytes);
	~PagedMemory() { release(); }
	PagedMemory(PagedMemory&& other) noexcept { swap(other); }
	PagedMemory& operator=(PagedMemory&& other) noexcept
	{
		swap(other);
		return *this;
	}
	char* data() const { return data_; }
	/// The bytes [from, to) are zero again, and whole pages of them take no memory.
	void forget(std::size_t from, std::size_t to);

private:
	void swap(PagedMemory& other)
	{
		std::swap(data_, other.data_);
		std::swap(mapped_, other.mapped_);
	}
	void release();

	char*       data_   = nullptr;
	std::size_t mapped_ = 0; ///< bytes; 0: taken from the heap
};

/// Array of numbers that are zero, and take memory only where they were written to: a rank that computes a part of the ground holds that
/// part of its arrays, under the numbers that points, nodes and cells have in the whole.
template <class T> class PagedArray {
	static_assert(std::is_trivially_copyable_v<T>, "bytes of zero are a value");

public:
	void reset(std::size_t count)
	{
		memory_ = PagedMemory(count * sizeof(T));
		values_ = reinterpret_cast<T*>(memory_.data());
		count_  = count;
	}
	std::size_t size() const { return count_; }
	bool        empty() const { return count_ == 0; }
	T*          data() { return values_; }
	const T*    data() const { return values_; }
	T*          begin() { return values_; }
	T*          end() { return values_ + count_; }
	T&          operator[](std::size_t k) { return values_[k]; }
	const T&    operator[](std::size_t k) const { return values_[k]; }

	/// The numbers [first, end) are zero again and take no memory.
	void forget(std::size_t first, std::size_t end) { memory_.forget(first * sizeof(T), end * sizeof(T)); }
	/// The same of all but the numbers [first, end).
	void keepOnly(std::size_t first, std::size_t end)
	{
		if (empty()) return;
		forget(0, first);
		forget(end, count_);
	}

private:
	PagedMemory memory_;
	T*          values_ = nullptr;
	std::size_t count_  = 0;
};

} // namespace talik
