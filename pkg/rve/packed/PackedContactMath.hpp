// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cmath>
#include <pkg/rve/packed/PackedStepView.hpp>

/// Geometry, kinematics and force of one pair in stock YADE's conventions (ScGeom with avoidGranularRatcheting), for the units compiled
/// without special instruction sets.
namespace talik {

/// Where the two grains and the periodic shift of a pair are.
template <int Dim> struct PackedPairRows {
	std::uint32_t first, second; ///< row number times four
	const double* shift;         ///< row (H c, L H_prev c), or nullptr inside the cell
};

template <int Dim> inline PackedPairRows<Dim> pairRows(const PackedStepView<Dim>& view, const PackedPairs<Dim>& pairs, std::size_t lane)
{
	const PackedBlock<Dim>& block = pairs.block[lane / 4];
	return { block.first[lane % 4], block.second[lane % 4],
		     pairs.shift ? view.shiftMotion + pairs.shift[lane] * (PackedLayout<Dim>::motion / 4) : nullptr };
}

/// Branch from first to second and its square.
template <int Dim> inline double pairBranch(const PackedStepView<Dim>& view, const PackedPairRows<Dim>& rows, double* branch)
{
	constexpr int stride = PackedLayout<Dim>::motion / 4;
	const double* a      = view.motion + rows.first * stride;
	const double* b      = view.motion + rows.second * stride;
	double        square = 0;
	for (int d = 0; d < Dim; ++d) {
		branch[d] = b[d] - a[d];
		if (rows.shift) branch[d] += rows.shift[d];
		square += branch[d] * branch[d];
	}
	return square;
}

inline void cross(const double* a, const double* b, double* c)
{
	c[0] = a[1] * b[2] - a[2] * b[1];
	c[1] = a[2] * b[0] - a[0] * b[2];
	c[2] = a[0] * b[1] - a[1] * b[0];
}

/// Tangential velocity of second against first at the contact: a scalar along t = z x n for discs, a vector for spheres.
template <int Dim>
inline void slipVelocity(const PackedStepView<Dim>& view, const PackedPairRows<Dim>& rows, const double* n, double stretch, double* slip)
{
	constexpr int stride = PackedLayout<Dim>::motion / 4;
	const double* a      = view.motion + rows.first * stride + Dim;
	const double* b      = view.motion + rows.second * stride + Dim;
	double        v[Dim];
	for (int d = 0; d < Dim; ++d) {
		v[d] = b[d] - a[d];
		if (rows.shift) v[d] += rows.shift[Dim + d];
	}
	if constexpr (Dim == 2) {
		const double* wr = view.spin;
		slip[0]          = stretch * (v[1] * n[0] - v[0] * n[1]) - (wr[rows.first / 4] + wr[rows.second / 4]);
	} else {
		const double* wa = view.spin + rows.first;
		const double* wb = view.spin + rows.second;
		double        w[3], rotation[3], normalPart = 0;
		for (int d = 0; d < 3; ++d)
			w[d] = wa[d] * wa[3] + wb[d] * wb[3];
		cross(w, n, rotation);
		for (int d = 0; d < 3; ++d) {
			slip[d] = stretch * v[d] - rotation[d];
			normalPart += slip[d] * n[d];
		}
		for (int d = 0; d < 3; ++d)
			slip[d] -= normalPart * n[d];
	}
}

/// Carries a shear force of spheres along with the normal and the mean spin, as ScGeom::rotate does.
inline void rotateShear(const PackedStepView<3>& view, const PackedPairRows<3>& rows, const double* oldNormal, const double* n, double* shear)
{
	const double* wa = view.spin + rows.first;
	const double* wb = view.spin + rows.second;
	double        axis[3], turn[3], twist = 0;
	cross(oldNormal, n, axis);
	cross(shear, axis, turn);
	for (int d = 0; d < 3; ++d) {
		shear[d] -= turn[d];
		twist += n[d] * (wa[d] + wb[d]);
	}
	twist *= 0.5 * view.dt;
	for (int d = 0; d < 3; ++d)
		axis[d] = twist * n[d];
	cross(shear, axis, turn);
	for (int d = 0; d < 3; ++d)
		shear[d] -= turn[d];
}

template <int Dim> inline double shearNorm(const double* shear)
{
	if constexpr (Dim == 2) return std::fabs(shear[0]);
	else return std::sqrt(shear[0] * shear[0] + shear[1] * shear[1] + shear[2] * shear[2]);
}

/// Force on second, F_n n + shear.
template <int Dim> inline void pairForce(const double* n, double normalForce, const double* shear, double* force)
{
	if constexpr (Dim == 2) {
		force[0] = normalForce * n[0] - shear[0] * n[1];
		force[1] = normalForce * n[1] + shear[0] * n[0];
	} else {
		for (int d = 0; d < 3; ++d)
			force[d] = normalForce * n[d] + shear[d];
	}
}

/// Adds a pair's force and moments to the grains' sums, and to its shift's.
template <int Dim>
inline void addPairForce(
        const PackedStepView<Dim>& view, const PackedPairRows<Dim>& rows, const double* n, double overlap, double normalForce, const double* shear)
{
	constexpr int stride = PackedLayout<Dim>::force / 4;
	double*       a      = view.force + rows.first * stride;
	double*       b      = view.force + rows.second * stride;
	double        force[Dim];
	pairForce<Dim>(n, normalForce, shear, force);
	for (int d = 0; d < Dim; ++d) {
		a[d] += force[d];
		b[d] -= force[d];
	}
	if constexpr (Dim == 2) {
		const double moment = 0.5 * overlap * shear[0];
		a[2] += shear[0];
		b[2] += shear[0];
		a[3] += moment;
		b[3] += moment;
	} else {
		double moment[3];
		cross(n, shear, moment);
		const double armA = view.spin[rows.first + 3] - 0.5 * overlap;
		const double armB = view.spin[rows.second + 3] - 0.5 * overlap;
		for (int d = 0; d < 3; ++d) {
			a[4 + d] -= armA * moment[d];
			b[4 + d] -= armB * moment[d];
		}
	}
	if (rows.shift) {
		double* sum = view.shiftForce + (rows.shift - view.shiftMotion) / (PackedLayout<Dim>::motion / 4) * stride;
		for (int d = 0; d < Dim; ++d)
			sum[d] += force[d];
	}
}

} // namespace talik
