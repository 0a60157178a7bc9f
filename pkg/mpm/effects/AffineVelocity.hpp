// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/effects/SolidMotion.hpp>

namespace talik {

/// Effect of the transfers apic and tpic: every point carries, beside the velocity of the solid, its gradient C [1/s], so that it
/// gives the nodes m S_I (v + C (x_I - x_p)). C = B D^-1 with B = sum S_I v_I (x_I - x_p)^T and D = sum S_I (x_I - x_p)(x_I - x_p)^T
/// (apic; Jiang et al. 2015, "The affine particle-in-cell method"), or C = sum v_I grad S_I^T (tpic). D is diagonal, as shape
/// functions are products over the axes. With apic both directions are adjoint in the mass-weighted product v.v + C D : C.
template <int D> class AffineVelocity {
public:
	/// transfer: apic or tpic.
	AffineVelocity(PointFields& fields, VelocityTransfer transfer)
	        : transfer_(transfer)
	{
		fields.declare("affineVelocity", "transfer", "1/s", gradient);
	}

	/// Adds the momentum of the gradients of a block to the nodes.
	void map(const Grid<D>& grid, const WeightBlock<D>& w, SolidMotion<D>& motion) const
	{
		for (int k = 0; k < w.count; ++k)
			overMomenta(grid, w, k, motion.mass[w.first + k], [&](int node, const Vec<D>& momentum) {
				addTo<D>(motion.nodes[node] + motion.momentumAt, momentum);
			});
	}
	/// work(node, momentum) for every node of point k of a block: what its gradient adds to the momentum of mass [kg].
	template <class Work> void overMomenta(const Grid<D>& grid, const WeightBlock<D>& w, int k, double mass, Work&& work) const
	{
		const int  p    = w.first + k;
		const auto arms = armsOf(w, k, grid.spacing());
		overSupport(w, k, [&](int node, double s, const Vec<D>&, const std::array<int, D>& index) {
			Vec<D> momentum {};
			for (int i = 0; i < D; ++i) {
				for (int j = 0; j < D; ++j)
					momentum[i] += mass * gradient[i * D + j][p] * arms[j].distance[index[j]];
				momentum[i] *= s;
			}
			work(node, momentum);
		});
	}
	/// Adds to the gradient of point k of a block that of a nodal velocity: velocityAt(node) gives it, or null for none.
	template <class Velocity> void addGradient(const Grid<D>& grid, const WeightBlock<D>& w, int k, Velocity&& velocityAt) const
	{
		const auto arms = armsOf(w, k, grid.spacing());
		overSupport(w, k, [&](int node, double s, const Vec<D>& g, const std::array<int, D>& index) {
			const double* v = velocityAt(node);
			if (!v) return;
			for (int j = 0; j < D; ++j) {
				const double factor = transfer_ == VelocityTransfer::apic ? s * arms[j].distance[index[j]] / arms[j].moment : g[j];
				for (int i = 0; i < D; ++i)
					gradient[i * D + j][w.first + k] += v[i] * factor;
			}
		});
	}
	/// Gradients of a block from the solved velocities of the nodes.
	void gather(const Grid<D>& grid, const WeightBlock<D>& w, const SolidMotion<D>& motion) const
	{
		transfer_ == VelocityTransfer::apic ? gatherBlock<true>(grid, w, motion) : gatherBlock<false>(grid, w, motion);
	}

	std::array<double*, D * D> gradient; ///< C_ij = dv_i/dx_j, row by row; zero at the start: a given velocity is that of the whole point

private:
	/// Distances from a point to the nodes of its support along one axis, and their second moment.
	struct Arm {
		double distance[supportNodes]; ///< x_I - x_p [m]
		double moment;                 ///< sum S (x_I - x_p)^2 [m^2]
	};
	/// From the factors alone: shape functions reproduce the coordinate, so the mean of the node numbers is the point's place.
	static std::array<Arm, D> armsOf(const WeightBlock<D>& w, int k, double spacing)
	{
		std::array<Arm, D> arms {};
		for (int a = 0; a < D; ++a) {
			const auto&  value = w.value[a];
			const double place = value[1][k] + 2.0 * value[2][k];
			for (int i = 0; i < supportNodes; ++i) {
				arms[a].distance[i] = spacing * (i - place);
				arms[a].moment += value[i][k] * arms[a].distance[i] * arms[a].distance[i];
			}
		}
		return arms;
	}
	/// work(node, S, grad S, index along each axis) for the nodes of the support of point k of the block.
	template <class Work> static void overSupport(const WeightBlock<D>& w, int k, Work&& work)
	{
		int n = 0;
		overNodes<D>(w, k, [&](int node, double s, const Vec<D>& g) {
			std::array<int, D> index;
			for (int a = 0, rest = n; a < D; ++a, rest /= supportNodes)
				index[a] = rest % supportNodes;
			work(node, s, g, index);
			++n;
		});
	}
	template <bool Apic> void gatherBlock(const Grid<D>& grid, const WeightBlock<D>& w, const SolidMotion<D>& motion) const
	{
		for (int k = 0; k < w.count; ++k) {
			const auto arms    = armsOf(w, k, grid.spacing());
			double     c[D][D] = {};
			overSupport(w, k, [&](int node, double s, const Vec<D>& g, const std::array<int, D>& index) {
				const double* v = motion.solved[node] + motion.velocityAt;
				for (int j = 0; j < D; ++j) {
					const double factor = Apic ? s * arms[j].distance[index[j]] / arms[j].moment : g[j];
					for (int i = 0; i < D; ++i)
						c[i][j] += v[i] * factor;
				}
			});
			for (int i = 0; i < D; ++i)
				for (int j = 0; j < D; ++j)
					gradient[i * D + j][w.first + k] = c[i][j];
		}
	}

	VelocityTransfer transfer_;
};

} // namespace talik
