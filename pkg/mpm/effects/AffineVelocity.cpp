// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/AffineVelocity.hpp>

namespace talik {

template <int D>
AffineVelocity<D>::AffineVelocity(PointFields& fields, VelocityTransfer transfer)
        : transfer_(transfer)
{
	fields.declare("affineVelocity", "transfer", "1/s", gradient);
}

template <int D> void AffineVelocity<D>::map(const Grid<D>& grid, const WeightBlock<D>& w, SolidMotion<D>& motion) const
{
	for (int k = 0; k < w.count; ++k)
		overMomenta(grid, w, k, motion.mass[w.first + k], [&](int node, const Vec<D>& momentum) {
			for (int i = 0; i < D; ++i)
				motion.nodes[node][motion.momentumAt + i] += momentum[i];
		});
}

template <int D> void AffineVelocity<D>::gather(const Grid<D>& grid, const WeightBlock<D>& w, const SolidMotion<D>& motion) const
{
	transfer_ == VelocityTransfer::apic ? gatherBlock<true>(grid, w, motion) : gatherBlock<false>(grid, w, motion);
}

template <int D> template <bool Apic> void AffineVelocity<D>::gatherBlock(const Grid<D>& grid, const WeightBlock<D>& w, const SolidMotion<D>& motion) const
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

TALIK_IN_PLANE_AND_SPACE(AffineVelocity);

} // namespace talik
