// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/AffineVelocity.hpp>

namespace talik {

namespace {
	/// Distances from a point to the nodes of its support along one axis, and their second moment.
	struct Arm {
		double distance[supportNodes]; ///< x_I - x_p [m]
		double moment;                 ///< sum S (x_I - x_p)^2 [m^2]
	};

	/// From the factors alone: shape functions reproduce the coordinate, so the mean of the node numbers is the point's place.
	template <int D> Arm armOf(const WeightBlock<D>& w, int axis, int k, double spacing)
	{
		const auto&  value = w.value[axis];
		const double place = value[1][k] + 2.0 * value[2][k];
		Arm          arm { {}, 0.0 };
		for (int i = 0; i < supportNodes; ++i) {
			arm.distance[i] = spacing * (i - place);
			arm.moment += value[i][k] * arm.distance[i] * arm.distance[i];
		}
		return arm;
	}

	/// work(node, S, grad S, index along each axis) for the nodes of the support of point k of the block.
	template <int D, class Work> void overSupport(const Grid<D>& grid, const WeightBlock<D>& w, int k, Work&& work)
	{
		int n = 0;
		overNodes<D>(grid, w, k, [&](int node, double s, const Vec<D>& g) {
			std::array<int, D> index;
			for (int a = 0, rest = n; a < D; ++a, rest /= supportNodes)
				index[a] = rest % supportNodes;
			work(node, s, g, index);
			++n;
		});
	}

	template <int D> std::array<Arm, D> armsOf(const WeightBlock<D>& w, int k, double spacing)
	{
		std::array<Arm, D> arms;
		for (int a = 0; a < D; ++a)
			arms[a] = armOf(w, a, k, spacing);
		return arms;
	}
} // namespace

template <int D>
AffineVelocity<D>::AffineVelocity(PointFields& fields, VelocityTransfer transfer)
        : transfer_(transfer)
        , gradient_(fields.declare("affineVelocity", "transfer", "1/s", D * D))
{
}

template <int D> void AffineVelocity<D>::bind(MaterialPoints<D>& points)
{
	for (int c = 0; c < D * D; ++c)
		gradient[c] = points.fields().component(gradient_, c);
}

template <int D> void AffineVelocity<D>::map(const Grid<D>& grid, const WeightBlock<D>& w, SolidMotion<D>& motion) const
{
	for (int k = 0; k < w.count; ++k) {
		const int  p    = w.first + k;
		const auto arms = armsOf(w, k, grid.spacing());
		double     momentum[D][D];
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D; ++j)
				momentum[i][j] = motion.mass[p] * gradient[i * D + j][p];
		overSupport<D>(grid, w, k, [&](int node, double s, const Vec<D>&, const std::array<int, D>& index) {
			double* r = motion.nodes[node] + motion.momentumAt;
			for (int i = 0; i < D; ++i) {
				double sum = 0.0;
				for (int j = 0; j < D; ++j)
					sum += momentum[i][j] * arms[j].distance[index[j]];
				r[i] += s * sum;
			}
		});
	}
}

template <int D> void AffineVelocity<D>::gather(const Grid<D>& grid, const WeightBlock<D>& w, const SolidMotion<D>& motion) const
{
	transfer_ == VelocityTransfer::apic ? gatherBlock<true>(grid, w, motion) : gatherBlock<false>(grid, w, motion);
}

template <int D>
template <bool Apic>
void AffineVelocity<D>::gatherBlock(const Grid<D>& grid, const WeightBlock<D>& w, const SolidMotion<D>& motion) const
{
	for (int k = 0; k < w.count; ++k) {
		const auto arms    = armsOf(w, k, grid.spacing());
		double     c[D][D] = {};
		overSupport<D>(grid, w, k, [&](int node, double s, const Vec<D>& g, const std::array<int, D>& index) {
			const double* v = motion.solved[node] + D;
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

template class AffineVelocity<2>;
template class AffineVelocity<3>;

} // namespace talik
