// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace talik {

/// Points are worked on in blocks of this length, so that the weights of a block stay in the first-level cache.
constexpr int blockSize = 32;

/// Nodes per axis that a point touches.
constexpr int supportNodes = 3;

/// Nodes that a point touches.
template <int D> constexpr int supportCount = D == 2 ? supportNodes* supportNodes : supportNodes* supportNodes* supportNodes;

/// Rows of nodes along the first axis that a point touches.
template <int D> constexpr int supportRows = supportCount<D> / supportNodes;

/// Shape functions of consecutive points as factors along the axes; loops form the products themselves (see overNodes).
template <int D> struct WeightFactors {
	int    first = 0;                         ///< place of the first point
	int    count = 0;                         ///< <= blockSize
	int    base[blockSize];                   ///< index of the node with the lowest coordinates in the support
	int    offset[supportCount<D>];           ///< from the base to each node of the support
	double value[D][supportNodes][blockSize]; ///< one-dimensional factors [-]
	double slope[D][supportNodes][blockSize]; ///< and their derivatives [1/m]
};

template <int D> struct WeightBlock;

template <> struct WeightBlock<2> : WeightFactors<2> {
	/// What the nodes of a row have in common: the factor along y (a = 0), and its slope (a = 1).
	const double* row(int a, int row) const { return a == 0 ? value[1][row] : slope[1][row]; }
};

template <> struct WeightBlock<3> : WeightFactors<3> {
	double product[3][supportRows<3>][blockSize];
	/// What the nodes of a row have in common: the product of the factors along y and z (a = 0), the same with the slope along axis a.
	const double* row(int a, int row) const { return product[a][row]; }
};

} // namespace talik
