// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace talik {

/// Values on the nodes of the grid, a record of Size doubles per node.
template <int Size> class NodeField {
public:
	static constexpr int size = Size;

	void allocate(int nodes) { values_.assign(static_cast<std::size_t>(nodes) * Size, 0.0); }
	void clear(int first, int last) { std::fill(values_.begin() + static_cast<std::ptrdiff_t>(first) * Size, values_.begin() + static_cast<std::ptrdiff_t>(last) * Size, 0.0); }

	double*       operator[](int node) { return values_.data() + static_cast<std::size_t>(node) * Size; }
	const double* operator[](int node) const { return values_.data() + static_cast<std::size_t>(node) * Size; }

	std::size_t bytes() const { return values_.size() * sizeof(double); }

private:
	std::vector<double> values_;
};

} // namespace talik
