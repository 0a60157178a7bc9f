// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/grid/NodeLoops.hpp>

namespace talik {

template <int D>
SolidMotion<D>::SolidMotion(PointFields& fields, const MotionSettings<D>& motion, bool addsStress, bool turned)
        : settings(&motion)
{
	const char* area = D == 2 ? "m^2" : "m^3";
	velocity_        = fields.declare("velocity", "motion", "m/s", D);
	displacement_    = fields.declare("displacement", "motion", "m", D);
	mass_            = fields.declare("mass", "motion", "kg", 1);
	stress_          = fields.declare("stress", "motion", "Pa", S);
	initialVolume_   = fields.declare("initialVolume", "motion", area, 1);
	gradient_        = fields.declare("gradient", "motion", "-", D * D, false);
	if (addsStress) addedStress_ = fields.declare("addedStress", "motion", "Pa", 1, false);
	if (turned) hoop_ = fields.declare("hoopStrain", "motion", "-", 1, false);
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
	addedStress   = f.component(addedStress_);
	hoop          = f.component(hoop_);
	direct[2]     = hoop;
	for (int a = 0; a < D; ++a)
		direct[a] = gradient[a * D + a];
	traceShare = traceShares(grid);
	nodes.allocate(grid.nodeCount());
	solved.allocate(grid.nodeCount());
}

template <int D> void SolidMotion<D>::map(const WeightBlock<D>& w, const double* capacity, const double* carried, double carriedFrom)
{
	typename NodeLoops<D>::MotionMap of { mass, volume, addedStress, {}, {}, capacity, carried, carriedFrom, nodes[0] };
	std::copy(velocity.begin(), velocity.end(), of.velocity.begin());
	std::copy(stress.begin(), stress.end(), of.stress.begin());
	nodeLoops<D>().mapMotion(w, of);
}

template <int D> double SolidMotion<D>::carriedPart(int p, int a, int normal, double density, double thickness) const
{
	// at the surface stress carries half of the weight of a point, and swings about that
	const double weight  = 0.25 * density * settings->gravity[a] * thickness * (settings->gravity[normal] < 0.0 ? 1.0 : -1.0);
	const double carried = stress[stressIndex<D>(a, normal)][p] + (a == normal && addedStress ? addedStress[p] : 0.0);
	return weight == 0.0 ? 0.0 : std::clamp(carried / weight, 0.0, 1.0);
}

template <int D> void SolidMotion<D>::gather(const WeightBlock<D>& w, double dt, double* increment)
{
	nodeLoops<D>().gatherMotion(w, { solved[0], velocity, position, displacement, gradient, kept, dt, increment });
}

/// With the weights of eq. (29.1), as in gatherHoop().
template <int D> void SolidMotion<D>::mapHoop(const WeightBlock<D>& w)
{
	for (int k = 0; k < w.count; ++k) {
		const int    p     = w.first + k;
		const double force = -volume[p] / position[0][p] * (stress[2][p] + (addedStress ? addedStress[p] : 0.0));
		overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) { nodes[node][forceAt] += s * force; });
	}
}

template <int D> void SolidMotion<D>::gatherHoop(const WeightBlock<D>& w, double dt)
{
	for (int k = 0; k < w.count; ++k) {
		const int p     = w.first + k;
		double    speed = 0.0;
		overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) { speed += s * solved[node][velocityAt]; });
		hoop[p] = dt * speed / position[0][p];
	}
}

TALIK_IN_PLANE_AND_SPACE(SolidMotion);

} // namespace talik
