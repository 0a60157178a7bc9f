// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Vector.hpp>

#include <cstddef>

namespace talik {

/// Strain and rotation of one step at the middle of the step (Hughes and Winget): a rigid rotation gives no strain and turns
/// the stress exactly.
template <int D> struct MidpointIncrement;

/// Place of a component of MidpointIncrement::strain in a stress; the plane has no strain zz.
template <int D> constexpr int stressOfStrain(int c) { return D == 2 && c == 2 ? 3 : c; }

template <> struct MidpointIncrement<2> {
	double strain[3]; ///< xx, yy, xy (tensor component)
	double cosine, sine;

	/// gradient: Delta t dv_i/dx_j at [i*2+j]
	explicit MidpointIncrement(const double* gradient)
	{
		// h = G (1 + G/2)^-1
		const double a = 1.0 + 0.5 * gradient[0], b = 0.5 * gradient[1], c = 0.5 * gradient[2], d = 1.0 + 0.5 * gradient[3];
		const double inverse = 1.0 / (a * d - b * c);
		const double h00 = (gradient[0] * d - gradient[1] * c) * inverse, h01 = (gradient[1] * a - gradient[0] * b) * inverse;
		const double h10 = (gradient[2] * d - gradient[3] * c) * inverse, h11 = (gradient[3] * a - gradient[2] * b) * inverse;
		strain[0]      = h00;
		strain[1]      = h11;
		strain[2]      = 0.5 * (h01 + h10);
		const double t = 0.25 * (h10 - h01), scale = 1.0 / (1.0 + t * t);
		cosine = (1.0 - t * t) * scale;
		sine   = 2.0 * t * scale;
	}
	/// stress xx, yy, zz, xy
	void rotate(double* s) const
	{
		const double c = cosine, z = sine;
		const double xx = c * c * s[0] - 2.0 * c * z * s[3] + z * z * s[1];
		const double yy = z * z * s[0] + 2.0 * c * z * s[3] + c * c * s[1];
		s[3]            = c * z * (s[0] - s[1]) + (c * c - z * z) * s[3];
		s[0]            = xx;
		s[1]            = yy;
	}
	void addElastic(double* s, double lambda, double shear) const
	{
		const double volumetric = lambda * (strain[0] + strain[1]);
		s[0] += volumetric + 2.0 * shear * strain[0];
		s[1] += volumetric + 2.0 * shear * strain[1];
		s[2] += volumetric;
		s[3] += 2.0 * shear * strain[2];
	}
};

template <> struct MidpointIncrement<3> {
	double strain[6]; ///< xx, yy, zz, yz, xz, xy (tensor components)
	double q[3][3];

	explicit MidpointIncrement(const double* g)
	{
		// h = G (1 + G/2)^-1
		double m[3][3], adjugate[3][3], h[3][3];
		fill(m, [&](int i, int j) { return 0.5 * g[i * 3 + j] + (i == j ? 1.0 : 0.0); });
		fill(adjugate, [&](int i, int j) {
			const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
			return m[a][c] * m[b][d] - m[a][d] * m[b][c];
		});
		const double perDeterminant = 1.0 / (m[0][0] * adjugate[0][0] + m[0][1] * adjugate[1][0] + m[0][2] * adjugate[2][0]);
		fill(h, [&](int i, int j) {
			return (g[i * 3] * adjugate[0][j] + g[i * 3 + 1] * adjugate[1][j] + g[i * 3 + 2] * adjugate[2][j]) * perDeterminant;
		});
		fillSymmetric(strain, [&](int i, int j) { return 0.5 * (h[i][j] + h[j][i]); });
		// Cayley transform of the skew part: Q = 1 + 2/(1 + t.t) (T + T^2), T^2 = t t - t.t 1
		const double t[3]    = { 0.25 * (h[2][1] - h[1][2]), 0.25 * (h[0][2] - h[2][0]), 0.25 * (h[1][0] - h[0][1]) };
		const double T[3][3] = { { 0.0, -t[2], t[1] }, { t[2], 0.0, -t[0] }, { -t[1], t[0], 0.0 } };
		const double square = t[0] * t[0] + t[1] * t[1] + t[2] * t[2], scale = 2.0 / (1.0 + square);
		fill(q, [&](int i, int j) { return scale * (T[i][j] + t[i] * t[j]) + (i == j ? 1.0 - scale * square : 0.0); });
	}
	/// stress xx, yy, zz, yz, xz, xy
	void rotate(double* s) const
	{
		double half[3][3];
		fill(half,
		     [&](int i, int j) { return q[i][0] * s[stressIndex<3>(0, j)] + q[i][1] * s[stressIndex<3>(1, j)] + q[i][2] * s[stressIndex<3>(2, j)]; });
		fillSymmetric(s, [&](int i, int j) { return half[i][0] * q[j][0] + half[i][1] * q[j][1] + half[i][2] * q[j][2]; });
	}
	void addElastic(double* s, double lambda, double shear) const
	{
		const double volumetric = lambda * (strain[0] + strain[1] + strain[2]);
		fillSymmetric(
		        s, [&](int i, int j) { return s[stressIndex<3>(i, j)] + ((i == j ? volumetric : 0.0) + 2.0 * shear * strain[stressIndex<3>(i, j)]); });
	}

private:
	// loops over points are vectors only where those over components are unrolled
	template <class Entry> static void fill(double (&m)[3][3], Entry&& entry)
	{
#pragma GCC unroll 3
		for (int i = 0; i < 3; ++i)
#pragma GCC unroll 3
			for (int j = 0; j < 3; ++j)
				m[i][j] = entry(i, j);
	}
	template <class Entry> static void fillSymmetric(double* s, Entry&& entry)
	{
#pragma GCC unroll 3
		for (int i = 0; i < 3; ++i)
#pragma GCC unroll 3
			for (int j = i; j < 3; ++j)
				s[stressIndex<3>(i, j)] = entry(i, j);
	}
};

/// Lame's lambda and shear modulus [Pa].
struct LameModuli {
	double lambda, shear;
	LameModuli(double young, double poisson)
	        : lambda(young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)))
	        , shear(young / (2.0 * (1.0 + poisson)))
	{}
	double oedometer() const { return lambda + 2.0 * shear; }
};

/// Arrays of points from a place on.
template <class T, std::size_t n> std::array<T*, n> from(std::array<T*, n> fields, int place)
{
	for (T*& field : fields)
		field += place;
	return fields;
}

/// Hooke's law for the midpoint increments of count points in sequence: displacement gradient and stress [Pa] begin with the first, order
/// of stressIndex<D>(); Lame's moduli of each [Pa]. hoop: strain zz of the step in the plane about an axis; null: none.
template <int D>
void updateElastic(
        int count, const double* lambda, const double* shear, const std::array<const double*, D * D>& gradient,
        const std::array<double*, stressSize<D>>& stress, const double* hoop = nullptr);

/// The same strain at the middle of the step, as MidpointIncrement has the others.
inline double midpointHoop(double hoop) { return hoop / (1.0 + 0.5 * hoop); }

} // namespace talik
