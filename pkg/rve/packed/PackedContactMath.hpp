// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/rve/packed/PackedStepView.hpp>

/// Geometry and force of one pair in stock YADE's conventions.
namespace talik {

/// Where the two grains and the periodic shift of a pair are.
template <int Dim> struct PackedPairRows {
	std::uint32_t first, second; ///< grains
	const double* shift;         ///< row (H c, L H_prev c), or nullptr inside the cell
};

template <int Dim> inline PackedPairRows<Dim> pairRows(const PackedStepView<Dim>& view, const PackedPairs<Dim>& pairs, std::size_t lane)
{
	const PackedBlock<Dim>& block = pairs.block[lane / 4];
	constexpr std::uint32_t row   = PackedLayout<Dim>::row;
	return { block.first[lane % 4] / row, block.second[lane % 4] / row, pairs.shift ? view.shiftMotion + pairs.shift[lane] : nullptr };
}

/// Branch from first to second and its square.
template <int Dim> inline double pairBranch(const PackedStepView<Dim>& view, const PackedPairRows<Dim>& rows, double* branch)
{
	const double *a = view.position(rows.first), *b = view.position(rows.second);
	double        square = 0;
	for (int d = 0; d < Dim; ++d) {
		branch[d] = b[d] - a[d];
		if (rows.shift) branch[d] += rows.shift[d];
		square += branch[d] * branch[d];
	}
	return square;
}

/// Shear force in a lane of a block.
template <int Dim> inline typename PackedTypes<Dim>::Shear laneShear(const double (&rows)[PackedLayout<Dim>::shear][4], std::size_t lane)
{
	if constexpr (Dim == 2) return rows[0][lane];
	else return { rows[0][lane], rows[1][lane], rows[2][lane] };
}

template <int Dim> inline void setLaneShear(double (&rows)[PackedLayout<Dim>::shear][4], std::size_t lane, const typename PackedTypes<Dim>::Shear& shear)
{
	if constexpr (Dim == 2) rows[0][lane] = shear;
	else
		for (int d = 0; d < 3; ++d)
			rows[d][lane] = shear[d];
}

/// Force on second, F_n n + shear.
template <int Dim> inline void pairForce(const double* n, double normalForce, const typename PackedTypes<Dim>::Shear& shear, double* force)
{
	if constexpr (Dim == 2) {
		force[0] = normalForce * n[0] - shear * n[1];
		force[1] = normalForce * n[1] + shear * n[0];
	} else {
		for (int d = 0; d < 3; ++d)
			force[d] = normalForce * n[d] + shear[d];
	}
}

} // namespace talik
