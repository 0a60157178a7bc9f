// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/ShapeFunctions.hpp>

#include <array>
#include <cstddef>
#include <vector>

namespace talik {

/// Arrays of the points that a pass reads block by block. They are fetched into the first-level cache a block ahead: a block holds too little of
/// an array for the processor to see by itself where it goes on.
class Prefetch {
public:
	/// Null for a field that the scene does not have.
	template <class Number> void add(const Number* array)
	{
		if (array) arrays_.push_back({ reinterpret_cast<const char*>(array), sizeof(Number) });
	}
	template <class Number, std::size_t n> void add(const std::array<Number*, n>& arrays)
	{
		for (const Number* array : arrays)
			add(array);
	}
	/// Those of the points first .. first + blockSize - 1, which need not exist.
	void fetch(int first) const
	{
		constexpr std::size_t line = 64;
		for (const Array& array : arrays_) {
			const char* const from = array.first + first * array.size;
			for (std::size_t byte = 0; byte < blockSize * array.size; byte += line)
				__builtin_prefetch(from + byte);
		}
	}

private:
	struct Array {
		const char* first;
		std::size_t size; ///< of a number [bytes]
	};
	std::vector<Array> arrays_;
};

} // namespace talik
