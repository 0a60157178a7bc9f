// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
// The state of a ground kept and compared byte by byte.

#include <pkg/mpm/Ground.hpp>

#include <vector>

namespace talik {

inline std::vector<std::vector<char>> copyOf(const std::vector<StateArray>& state)
{
	std::vector<std::vector<char>> copy;
	for (const StateArray& a : state)
		copy.emplace_back(static_cast<char*>(a.data), static_cast<char*>(a.data) + a.bytes);
	return copy;
}

inline long differingBytes(const std::vector<std::vector<char>>& a, const std::vector<StateArray>& b)
{
	long different = 0;
	for (std::size_t k = 0; k < a.size(); ++k)
		for (std::size_t i = 0; i < a[k].size(); ++i)
			different += a[k][i] != static_cast<char*>(b[k].data)[i];
	return different;
}

} // namespace talik
