// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <pkg/base/Dimensions.hpp>

namespace talik {

/// Point or vector of D components [2-D: x, y; 3-D: x, y, z].
template <int D> using Vec = std::array<double, D>;

template <int D> double dot(const Vec<D>& a, const Vec<D>& b)
{
	double sum = 0.0;
	for (int i = 0; i < D; ++i)
		sum += a[i] * b[i];
	return sum;
}

template <int D> double lengthOf(const Vec<D>& v)
{
	double sum = 0.0;
	for (double c : v)
		sum += c * c;
	return std::sqrt(sum);
}

/// The axis nearest to gravity: layers of ground lie across it. Of equal components the last.
template <int D> int layerNormal(const Vec<D>& gravity)
{
	int normal = 0;
	for (int a = 1; a < D; ++a)
		if (std::abs(gravity[a]) >= std::abs(gravity[normal])) normal = a;
	return normal;
}

/// Number of stored stress components: plane strain keeps xx, yy, zz, xy; 3-D keeps xx, yy, zz, yz, xz, xy.
template <int D> constexpr int stressSize = D == 2 ? 4 : 6;

/// Place of sigma_ij (i, j < D) among the stored stress components.
template <int D> constexpr int stressIndex(int i, int j)
{
	if (i == j) return i;
	if (D == 2) return 3;
	return 6 - i - j; // yz = 3, xz = 4, xy = 5
}

} // namespace talik
