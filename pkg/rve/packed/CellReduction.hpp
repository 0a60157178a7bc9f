// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cmath>
#include <Eigen/Core>
#include <Eigen/LU>

/// Equivalent cells of one lattice, for the flip of a sheared periodic cell.
namespace talik {

/// Integer combinations that shorten the cell vectors (columns of h): columns of the result are combinations of those of h, determinant
/// +-1; the identity if no vector leans over another by more than `skew` of its length.
template <int Dim> Eigen::Matrix<int, Dim, Dim> cellReduction(Eigen::Matrix<double, Dim, Dim> h, double skew)
{
	Eigen::Matrix<int, Dim, Dim> combination = Eigen::Matrix<int, Dim, Dim>::Identity();
	for (bool changed = true; changed;) {
		changed = false;
		for (int a = 0; a < Dim; ++a)
			for (int b = 0; b < Dim; ++b) {
				if (a == b) continue;
				const double ratio = h.col(a).dot(h.col(b)) / h.col(a).squaredNorm();
				const int    turns = int(std::lround(ratio));
				if (std::fabs(ratio) <= skew + 1e-9 || turns == 0) continue;
				h.col(b) -= turns * h.col(a);
				combination.col(b) -= turns * combination.col(a);
				changed = true;
			}
	}
	return combination;
}

/// Inverse of an integer matrix of determinant +-1, exact by rounding.
template <int Dim> Eigen::Matrix<int, Dim, Dim> integerInverse(const Eigen::Matrix<int, Dim, Dim>& m)
{
	const Eigen::Matrix<double, Dim, Dim> inverse = m.template cast<double>().inverse();
	Eigen::Matrix<int, Dim, Dim>          rounded;
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j)
			rounded(i, j) = int(std::lround(inverse(i, j)));
	return rounded;
}

} // namespace talik
