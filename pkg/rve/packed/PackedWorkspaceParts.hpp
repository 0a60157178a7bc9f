// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cmath>
#include <pkg/rve/packed/PackedWorkspace.hpp>

// What the files that implement PackedWorkspace share.

namespace talik {

template <int Dim> inline void copyMatrix(const Eigen::Matrix<double, Dim, Dim>& from, double* to)
{
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j)
			to[i * Dim + j] = from(i, j);
}

template <int Dim> inline void copyMatrix(const double* from, Eigen::Matrix<double, Dim, Dim>& to)
{
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j)
			to(i, j) = from[i * Dim + j];
}

template <int Dim> inline void multiply(const double* a, const double* b, double* c)
{
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j) {
			double sum = 0;
			for (int k = 0; k < Dim; ++k)
				sum += a[i * Dim + k] * b[k * Dim + j];
			c[i * Dim + j] = sum;
		}
}

template <int Dim> inline double frobenius(const double* a)
{
	double square = 0;
	for (int k = 0; k < Dim * Dim; ++k)
		square += a[k] * a[k];
	return std::sqrt(square);
}

/// Largest rate of shortening of any length, bounded from above.
template <int Dim> inline double strainRate(const double* a)
{
	double square = 0;
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j) {
			const double s = 0.5 * (a[i * Dim + j] + a[j * Dim + i]);
			square += s * s;
		}
	return std::sqrt(square);
}

} // namespace talik
