// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>
#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/grid/NodeColumns.hpp>
#include <pkg/mpm/grid/NodeLoops.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/CellMeans.hpp>

#include <algorithm>
#include <type_traits>

namespace talik {

/// The moving solid: velocity, displacement, effective stress and strain of the points; mass, momentum and force on the nodes.
template <int D> class SolidMotion {
public:
	static constexpr int S = stressSize<D>;
	/// Record of a node: mass that moves with the solid, its momentum, force on the mixture.
	using Record                = typename NodeColumns<D>::Moving;
	using Solved                = typename NodeColumns<D>::Solved;
	static constexpr int massAt = Record::mass, momentumAt = Record::momentum, forceAt = Record::force, velocityAt = Solved::velocity;

	/// addsStress: a stress other than the effective one enters the momentum balance; turned: the plane turns about an axis.
	SolidMotion(PointFields& fields, const MotionSettings<D>& motion, bool addsStress = true, bool turned = false)
	        : settings(&motion)
	{
		fields.declare("velocity", "motion", "m/s", velocity);
		fields.declare("displacement", "motion", "m", displacement);
		fields.declare("mass", "motion", "kg", mass);
		fields.declare("stress", "motion", "Pa", stress);
		fields.declare("initialVolume", "motion", D == 2 ? "m^2" : "m^3", initialVolume);
		fields.declare("gradient", "motion", "-", gradient, false);
		if (addsStress) fields.declare("addedStress", "motion", "Pa", addedStress, false);
		if (turned) fields.declare("hoopStrain", "motion", "-", hoop, false);
	}
	void bind(MaterialPoints<D>& points, const Grid<D>& grid)
	{
		volume    = points.volume();
		direct[2] = hoop;
		for (int a = 0; a < D; ++a) {
			position[a] = points.position(a);
			direct[a]   = gradient[a * D + a];
		}
		traceShare = traceShares(grid);
		nodes.allocate(grid.nodeCount());
		solved.allocate(grid.nodeCount());
	}

	/// Adds mass, momentum and internal force of a block, with addedStress. Maps capacity and capacity times (carried - carriedFrom) along, if
	/// not null, where records Moving have columns for them.
	void map(const WeightBlock<D>& w, const double* capacity = nullptr, const double* carried = nullptr, double carriedFrom = 0.0)
	{
		typename NodeLoops<D>::MotionMap of { mass, volume, addedStress, {}, {}, capacity, carried, carriedFrom, nodes[0] };
		std::copy(velocity.begin(), velocity.end(), of.velocity.begin());
		std::copy(stress.begin(), stress.end(), of.stress.begin());
		nodeLoops<D>().mapMotion(w, of);
	}
	/// Moves the weight of points that fill a cell from their middle to their upper and lower face, half to each, as far as stress carries it,
	/// eq. (8.2b). liquidMass(place) [kg]; push(k, node, force): the same force on a side of the thaw front; measure: see Grid::measured.
	template <class LiquidMass, class Push, class Measure>
	void mapWeight(const WeightBlock<D>& w, const Grid<D>& grid, LiquidMass&& liquidMass, Push&& push, Measure&& measure)
	{
		const Vec<D>& b       = settings->gravity;
		const int     n       = layerNormal<D>(b);
		const double  spacing = grid.spacing(), ofCells = grid.cellVolume();
		for (int k = 0; k < w.count; ++k) {
			const double curvature = -0.5 * spacing * spacing * w.slope[n][0][k] * w.slope[n][2][k];
			if (!(curvature > 0.0)) continue; // in the middle of its cell
			const int    p    = w.first + k;
			const double cell = ofCells * measure(position[0][p]);
			if (!(2.0 * volume[p] > cell)) continue; // several points of a cell share its weight
			const double m = mass[p] + liquidMass(p), thickness = std::min(spacing, spacing * volume[p] / cell);
			Vec<D>       moved;
			for (int a = 0; a < D; ++a)
				moved[a] = curvature * m * b[a] * carriedPart(p, a, n, m / volume[p], thickness);
			for (int at = 0; at < supportCount<D>; ++at) {
				double weight = 1.0;
				for (int a = 0, rest = at; a < D; ++a, rest /= supportNodes)
					weight *= a == n ? (rest % supportNodes == 1 ? -2.0 : 1.0) : w.value[a][rest % supportNodes][k];
				const int    node  = w.base[k] + w.offset[at];
				const Vec<D> force = weight * moved;
				addTo<D>(nodes[node] + forceAt, force);
				push(k, node, force);
			}
		}
	}
	/// Velocity, displacement, position and displacement gradient of a block from the solved nodes. increment, unless null: what the points gather
	/// of column increment, where records Solved have one.
	void gather(const WeightBlock<D>& w, double dt, double* increment = nullptr)
	{
		nodeLoops<D>().gatherMotion(w, { solved[0], velocity, position, displacement, gradient, kept, dt, increment });
	}
	/// In the plane about an axis, with the mean of the faces of points: adds the force of the hoop stress of a block, eq. (29.2), and finds its hoop
	/// strain before points move, eq. (29.3).
	/// With the weights of eq. (29.1), as in gatherHoop().
	void mapHoop(const WeightBlock<D>& w)
	{
		for (int k = 0; k < w.count; ++k) {
			const int    p     = w.first + k;
			const double force = -volume[p] / position[0][p] * (stress[2][p] + (addedStress ? addedStress[p] : 0.0));
			overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) { nodes[node][forceAt] += s * force; });
		}
	}
	void gatherHoop(const WeightBlock<D>& w, double dt)
	{
		for (int k = 0; k < w.count; ++k) {
			const int p     = w.first + k;
			double    speed = 0.0;
			overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) { speed += s * solved[node][velocityAt]; });
			hoop[p] = dt * speed / position[0][p];
		}
	}

	/// work(number) with the number of direct strains, which the compiler knows: D, and three about an axis.
	template <class Work> decltype(auto) overDirect(Work&& work) const
	{
		if constexpr (D == 2)
			if (hoop) return work(std::integral_constant<int, 3>());
		return work(std::integral_constant<int, D>());
	}

	const MotionSettings<D>* settings;
	double                   kept = 1.0; ///< chi of this step, see keptFraction()

	std::array<double*, D>     velocity, displacement, position;
	std::array<double*, S>     stress;
	std::array<double*, D * D> gradient;                ///< Delta t dv_i/dx_j
	double*                    mass          = nullptr; ///< that moves with the solid [kg]
	double*                    volume        = nullptr;
	double*                    initialVolume = nullptr;
	double*                    addedStress   = nullptr; ///< by the momentum balance to each normal stress: cell means and -p [Pa]; null: nothing
	double*                    hoop          = nullptr; ///< direct strain of the step around the axis [-]; null: there is no axis
	std::array<double*, 3>     direct {};               ///< direct strains of the step: on the diagonal of gradient, and hoop
	Vec<3>                     traceShare;              ///< of the strains in what B-bar adds to their sum, see traceShares()

	NodeField<Record::size> nodes;
	NodeField<Solved::size> solved; ///< chi dt a + (1 - chi) v, and v

private:
	/// The part of its own weight that stress carries through a point as thick as given, along axis a [-], 0 to 1.
	double carriedPart(int p, int a, int normal, double density, double thickness) const
	{
		// at the surface stress carries half of the weight of a point, and swings about that
		const double weight  = 0.25 * density * settings->gravity[a] * thickness * (settings->gravity[normal] < 0.0 ? 1.0 : -1.0);
		const double carried = stress[stressIndex<D>(a, normal)][p] + (a == normal && addedStress ? addedStress[p] : 0.0);
		return weight == 0.0 ? 0.0 : std::clamp(carried / weight, 0.0, 1.0);
	}
};

} // namespace talik
