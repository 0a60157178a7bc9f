// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/kernels/PlaneLoops.hpp>

namespace talik {

static_assert(PlaneLoops::motionSize == NodeColumns<2>::Moving::size, "loops and records agree");

template <int D>
SolidMotion<D>::SolidMotion(PointFields& fields, const MotionSettings<D>& motion, bool replacesMean)
        : settings(&motion)
{
	const char* area = D == 2 ? "m^2" : "m^3";
	velocity_        = fields.declare("velocity", "motion", "m/s", D);
	displacement_    = fields.declare("displacement", "motion", "m", D);
	mass_            = fields.declare("mass", "motion", "kg", 1);
	stress_          = fields.declare("stress", "motion", "Pa", S);
	initialVolume_   = fields.declare("initialVolume", "motion", area, 1);
	gradient_        = fields.declare("gradient", "motion", "-", D * D, false);
	if (replacesMean) meanStress_ = fields.declare("meanStress", "motion", "Pa", 1, false);
}

template <int D> void SolidMotion<D>::bind(MaterialPoints<D>& points, const Grid<D>& grid)
{
	PointFields& f = points.fields();
	for (int i = 0; i < D; ++i) {
		position[i]     = points.position(i);
		velocity[i]     = f.component(velocity_, i);
		displacement[i] = f.component(displacement_, i);
	}
	for (int c = 0; c < S; ++c)
		stress[c] = f.component(stress_, c);
	for (int c = 0; c < D * D; ++c)
		gradient[c] = f.component(gradient_, c);
	mass          = f.component(mass_);
	volume        = points.volume();
	initialVolume = f.component(initialVolume_);
	meanStress    = f.component(meanStress_);
	nodes.allocate(grid.nodeCount());
	solved.allocate(grid.nodeCount());
}

template <int D>
void SolidMotion<D>::map(
        const Grid<D>& grid, const WeightBlock<D>& w, [[maybe_unused]] const double* capacity, [[maybe_unused]] const double* carried,
        [[maybe_unused]] double carriedFrom)
{
	if constexpr (D == 2) {
		planeLoops().mapMotion(
		        w,
		        { mass,
		          volume,
		          meanStress,
		          { velocity[0], velocity[1] },
		          { stress[0], stress[1], stress[2], stress[3] },
		          capacity,
		          carried,
		          carriedFrom,
		          nodes[0] });
		return;
	}
	for (int k = 0; k < w.count; ++k) {
		const int    p = w.first + k;
		const double m = mass[p];
		Vec<D>       momentum;
		double       mean = 0.0;
		for (int i = 0; i < D; ++i) {
			momentum[i] = m * velocity[i][p];
			mean += stress[i][p];
		}
		const double replace = meanStress ? meanStress[p] - mean * (1.0 / D) : 0.0;
		double       t[D][D];
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D; ++j)
				t[i][j] = volume[p] * (stress[stressIndex<D>(i, j)][p] + (i == j ? replace : 0.0));
		overNodes<D>(grid, w, k, [&](int node, double s, const Vec<D>& g) {
			double* r = nodes[node];
			r[massAt] += s * m;
			for (int i = 0; i < D; ++i)
				r[momentumAt + i] += s * momentum[i];
			for (int i = 0; i < D; ++i) {
				double f = t[i][0] * g[0];
				for (int j = 1; j < D; ++j)
					f += t[i][j] * g[j];
				r[forceAt + i] -= f;
			}
		});
	}
}

template <int D> void SolidMotion<D>::gather(const Grid<D>& grid, const WeightBlock<D>& w, double dt)
{
	const double chi = kept;
	if constexpr (D == 2) {
		planeLoops().gatherMotion(
		        w,
		        { solved[0],
		          { velocity[0], velocity[1] },
		          { position[0], position[1] },
		          { displacement[0], displacement[1] },
		          { gradient[0], gradient[1], gradient[2], gradient[3] },
		          chi,
		          dt });
		return;
	}
	for (int k = 0; k < w.count; ++k) {
		const int p = w.first + k;
		Vec<D>    change {}, v {};
		double    l[D][D] = {};
		overNodes<D>(grid, w, k, [&](int node, double s, const Vec<D>& g) {
			const double* r = solved[node];
			for (int i = 0; i < D; ++i) {
				change[i] += s * r[i];
				v[i] += s * r[D + i];
				for (int j = 0; j < D; ++j)
					l[i][j] += g[j] * r[D + i];
			}
		});
		for (int i = 0; i < D; ++i) {
			velocity[i][p] = chi * velocity[i][p] + change[i];
			position[i][p] += dt * v[i];
			displacement[i][p] += dt * v[i];
			for (int j = 0; j < D; ++j)
				gradient[i * D + j][p] = dt * l[i][j];
		}
	}
}

template class SolidMotion<2>;
template class SolidMotion<3>;

} // namespace talik
