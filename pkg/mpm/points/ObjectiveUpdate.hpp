// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Vector.hpp>

namespace talik {

/// Strain and rotation of one step at the middle of the step (Hughes and Winget): a rigid rotation gives no strain and turns
/// the stress exactly.
template <int D> struct MidpointIncrement;

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
		double m[3][3], h[3][3];
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j)
				m[i][j] = 0.5 * g[i * 3 + j] + (i == j ? 1.0 : 0.0);
		double inverse[3][3];
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) {
				const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
				inverse[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
			}
		const double det = m[0][0] * inverse[0][0] + m[0][1] * inverse[1][0] + m[0][2] * inverse[2][0];
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) {
				h[i][j] = 0.0;
				for (int k = 0; k < 3; ++k)
					h[i][j] += g[i * 3 + k] * inverse[k][j];
				h[i][j] /= det;
			}
		for (int i = 0; i < 3; ++i)
			for (int j = i; j < 3; ++j)
				strain[stressIndex<3>(i, j)] = 0.5 * (h[i][j] + h[j][i]);
		// Cayley transform of the skew part: Q = 1 + 2/(1 + t.t) (T + T^2)
		const double t[3]    = { 0.25 * (h[2][1] - h[1][2]), 0.25 * (h[0][2] - h[2][0]), 0.25 * (h[1][0] - h[0][1]) };
		const double T[3][3] = { { 0.0, -t[2], t[1] }, { t[2], 0.0, -t[0] }, { -t[1], t[0], 0.0 } };
		const double scale   = 2.0 / (1.0 + t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) {
				double square = 0.0;
				for (int k = 0; k < 3; ++k)
					square += T[i][k] * T[k][j];
				q[i][j] = (i == j ? 1.0 : 0.0) + scale * (T[i][j] + square);
			}
	}
	/// stress xx, yy, zz, yz, xz, xy
	void rotate(double* s) const
	{
		double half[3][3], turned[6];
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) {
				half[i][j] = 0.0;
				for (int k = 0; k < 3; ++k)
					half[i][j] += q[i][k] * s[stressIndex<3>(k, j)];
			}
		for (int i = 0; i < 3; ++i)
			for (int j = i; j < 3; ++j) {
				double sum = 0.0;
				for (int k = 0; k < 3; ++k)
					sum += half[i][k] * q[j][k];
				turned[stressIndex<3>(i, j)] = sum;
			}
		for (int c = 0; c < 6; ++c)
			s[c] = turned[c];
	}
	void addElastic(double* s, double lambda, double shear) const
	{
		const double volumetric = lambda * (strain[0] + strain[1] + strain[2]);
		for (int i = 0; i < 3; ++i)
			s[i] += volumetric;
		for (int c = 0; c < 6; ++c)
			s[c] += 2.0 * shear * strain[c];
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

} // namespace talik
