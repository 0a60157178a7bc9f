// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/PagedArray.hpp>

#include <cstdlib>
#include <cstring>
#include <new>
#include <sys/mman.h>
#include <unistd.h>

namespace talik {

namespace {
	constexpr std::size_t line = 64, smallest = std::size_t(1) << 18; ///< smaller ones come from the heap [bytes]

	std::size_t pageSize()
	{
		static const auto size = std::size_t(sysconf(_SC_PAGESIZE));
		return size;
	}
} // namespace

PagedMemory::PagedMemory(std::size_t bytes)
{
	if (bytes < smallest) {
		const std::size_t whole = (std::max(bytes, line) + line - 1) / line * line;
		data_                   = static_cast<char*>(std::aligned_alloc(line, whole));
		if (!data_) throw std::bad_alloc();
		std::memset(data_, 0, whole);
		return;
	}
	void* const mapped = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
	if (mapped == MAP_FAILED) throw std::bad_alloc();
	data_   = static_cast<char*>(mapped);
	mapped_ = bytes;
}

void PagedMemory::release()
{
	if (mapped_ > 0) munmap(data_, mapped_);
	else std::free(data_);
	data_   = nullptr;
	mapped_ = 0;
}

void PagedMemory::forget(std::size_t from, std::size_t to)
{
	if (from >= to) return;
	const std::size_t page = pageSize(), first = (from + page - 1) / page * page, end = to / page * page;
	if (mapped_ == 0 || first >= end) {
		std::memset(data_ + from, 0, to - from);
		return;
	}
	std::memset(data_ + from, 0, first - from);
	std::memset(data_ + end, 0, to - end);
	madvise(data_ + first, end - first, MADV_DONTNEED);
}

} // namespace talik
