// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace talik {

/// Points are worked on in blocks of this length, so that the weights of a block stay in the first-level cache.
constexpr int blockSize = 32;

/// Nodes per axis that a point touches.
constexpr int supportNodes = 3;

/// Nodes that a point touches.
template <int D> constexpr int supportCount = D == 2 ? supportNodes* supportNodes : supportNodes* supportNodes* supportNodes;

/// Shape functions of consecutive points as factors along the axes; loops form the products themselves (see overNodes).
template <int D> struct WeightBlock {
	int    first = 0;                         ///< place of the first point
	int    count = 0;                         ///< <= blockSize
	int    base[blockSize];                   ///< index of the node with the lowest coordinates in the support
	int    offset[supportCount<D>];           ///< from the base to each node of the support
	double value[D][supportNodes][blockSize]; ///< one-dimensional factors [-]
	double slope[D][supportNodes][blockSize]; ///< and their derivatives [1/m]
};

} // namespace talik
