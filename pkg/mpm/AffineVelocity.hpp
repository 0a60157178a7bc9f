// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/SolidMotion.hpp>

namespace talik {

/// Effect of the transfers apic and tpic: every point carries, beside the velocity of the solid, its gradient C [1/s], so that it
/// gives the nodes m S_I (v + C (x_I - x_p)). C = B D^-1 with B = sum S_I v_I (x_I - x_p)^T and D = sum S_I (x_I - x_p)(x_I - x_p)^T
/// (apic; Jiang et al. 2015, "The affine particle-in-cell method"), or C = sum v_I grad S_I^T (tpic). D is diagonal, as shape
/// functions are products over the axes. With apic both directions are adjoint in the mass-weighted product v.v + C D : C.
template <int D> class AffineVelocity {
public:
	/// transfer: apic or tpic.
	AffineVelocity(PointFields& fields, VelocityTransfer transfer);
	void bind(MaterialPoints<D>& points);

	/// Adds the momentum of the gradients of a block to the nodes.
	void map(const Grid<D>& grid, const WeightBlock<D>& w, SolidMotion<D>& motion) const;
	/// Gradients of a block from the solved velocities of the nodes.
	void gather(const Grid<D>& grid, const WeightBlock<D>& w, const SolidMotion<D>& motion) const;

	std::array<double*, D * D> gradient; ///< C_ij = dv_i/dx_j, row by row; zero at the start: a given velocity is that of the whole point

private:
	template <bool Apic> void gatherBlock(const Grid<D>& grid, const WeightBlock<D>& w, const SolidMotion<D>& motion) const;

	VelocityTransfer    transfer_;
	PointFields::Handle gradient_;
};

extern template class AffineVelocity<2>;
extern template class AffineVelocity<3>;

} // namespace talik
