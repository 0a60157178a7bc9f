// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace talik {

/// Components of the strain that a deformation gradient stands for: in the plane xx, yy, xy; in space xx, yy, zz, yz, xz, xy.
template <int D> using StrainComponents = std::array<double, D == 2 ? 3 : 6>;

/// Logarithmic strain 1/2 ln(F F^T) [-] of the deformation gradient F_ij at f[i * D + j].
inline StrainComponents<2> logarithmicStrain(const std::array<double, 4>& f)
{
	Eigen::Matrix2d F;
	F << f[0], f[1], f[2], f[3];
	const Eigen::Matrix2d b    = F * F.transpose();
	const double          mean = 0.5 * b.trace(), radius = std::sqrt(std::max(0., mean * mean - b.determinant()));
	const double          e1 = 0.5 * std::log(mean + radius), e2 = 0.5 * std::log(std::max(mean - radius, 1e-300));
	const double          half = radius > 0 ? 0.5 * (e1 - e2) / radius : 0;
	return { 0.5 * (e1 + e2) + 0.5 * half * (b(0, 0) - b(1, 1)), 0.5 * (e1 + e2) - 0.5 * half * (b(0, 0) - b(1, 1)), half * b(0, 1) };
}

inline StrainComponents<3> logarithmicStrain(const std::array<double, 9>& f)
{
	const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> F(f.data());
	if (!F.allFinite()) {
		StrainComponents<3> none;
		none.fill(std::numeric_limits<double>::quiet_NaN());
		return none;
	}
	const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> b(Eigen::Matrix3d(F * F.transpose()));
	const Eigen::Vector3d                                half = 0.5 * b.eigenvalues().array().max(1e-300).log();
	const Eigen::Matrix3d                                e    = b.eigenvectors() * half.asDiagonal() * b.eigenvectors().transpose();
	return { e(0, 0), e(1, 1), e(2, 2), e(1, 2), e(0, 2), e(0, 1) };
}

/// sqrt(2/3 e:e) of the deviator; in the plane that of plane strain.
inline double deviatoricStrain(const StrainComponents<2>& e)
{
	const double third = (e[0] + e[1]) / 3;
	return std::sqrt(2. / 3 * ((e[0] - third) * (e[0] - third) + (e[1] - third) * (e[1] - third) + third * third + 2 * e[2] * e[2]));
}

inline double deviatoricStrain(const StrainComponents<3>& e)
{
	const double third = (e[0] + e[1] + e[2]) / 3;
	double       sum   = 0.0;
	for (int i = 0; i < 3; ++i)
		sum += (e[i] - third) * (e[i] - third) + 2 * e[3 + i] * e[3 + i];
	return std::sqrt(2. / 3 * sum);
}

} // namespace talik
