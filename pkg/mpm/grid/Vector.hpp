// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <pkg/base/Dimensions.hpp>

namespace talik {

/// Point or vector of D components [2-D: x, y; 3-D: x, y, z].
template <int D> using Vec = std::array<double, D>;

// Vectors add up, and numbers multiply and divide them, component by component.
template <std::size_t n> std::array<double, n>& operator+=(std::array<double, n>& a, const std::array<double, n>& b)
{
	for (std::size_t i = 0; i < n; ++i)
		a[i] += b[i];
	return a;
}
template <std::size_t n> std::array<double, n> operator+(std::array<double, n> a, const std::array<double, n>& b) { return a += b; }
template <std::size_t n> std::array<double, n> operator*(double factor, std::array<double, n> v)
{
	for (double& component : v)
		component *= factor;
	return v;
}
template <std::size_t n> std::array<double, n> operator-(const std::array<double, n>& a, const std::array<double, n>& b) { return a + -1.0 * b; }
template <std::size_t n> std::array<double, n> operator/(std::array<double, n> v, double divisor)
{
	for (double& component : v)
		component /= divisor;
	return v;
}
/// Of a point, from an array for each component.
template <int D, class Number> Vec<D> ofPoint(const std::array<Number*, D>& arrays, int place)
{
	Vec<D> v;
	for (int a = 0; a < D; ++a)
		v[a] = arrays[a][place];
	return v;
}
/// D numbers that follow each other.
template <int D> Vec<D> vectorAt(const double* numbers)
{
	Vec<D> v;
	for (int a = 0; a < D; ++a)
		v[a] = numbers[a];
	return v;
}
/// Adds a vector to numbers that follow each other.
template <int D> void addTo(double* numbers, const Vec<D>& v)
{
	for (int a = 0; a < D; ++a)
		numbers[a] += v[a];
}

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
