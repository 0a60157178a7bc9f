// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/front/FrontNodes.hpp>
#include <pkg/mpm/front/FrontRecords.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <vector>

namespace talik {

/// Both sides at a front node: what they would do without each other, and the forces between them. n points from the frozen side to the thawed one.
template <int D> struct ContactNode {
	std::array<double, 2> solid {}, liquid {}; ///< masses of the frozen and the thawed side [kg]
	bool                  meets = false;       ///< both have mass, and there is a direction between them
	Vec<D>                normal {};
	double                area    = 0.0;     ///< [m^(D-1)]
	double                follows = 0.0;     ///< part of a jump of the solid that drag gives to the liquid within the step [-]
	std::array<double, 2> moved {};          ///< mass of a side that jumps: its solid, and its liquid as far as it follows [kg]
	double                reducedMass = 0.0; ///< of these [kg]
	Vec<D>                jump {};           ///< velocity of the thawed side less that of the frozen one [m/s]
	double                pressing = 0.0;    ///< force along n that would give both sides the same acceleration [N]
	double                tension  = 0.0;    ///< that the thawed points carry along n [N], >= 0
	double                friction = 0.0;    ///< of the thawed points [-]
	double                cohesion = 0.0;    ///< of the thawed points [Pa]
	double                buoyancy = 0.0;    ///< part of the normal force that still pore water of the thawed side bears [N]
	bool                  together = false;  ///< the sides have one normal velocity
	double                reaction = 0.0;    ///< normal force between the sides [N], positive in compression
	double                impulse  = 0.0;    ///< along n, on the thawed side [N s]
	double                carried  = 1.0;    ///< part of the normal force that grains carry [-]
	bool                  rests    = false;  ///< the nodes around bear together what would make the sides slip
};

/// Contact of both sides at the front nodes, eqs. (20.1) to (20.2b): multi-field contact after Bardenhagen et al. (2000) with normals of
/// neighbouring nodes together, as Nairn (2013) recommends, Coulomb friction and a tension cut-off. All forces take energy from the motion.
template <int D> class FrontContact {
public:
	/// What a node solves with.
	struct Inputs {
		const FrontNodes<D>&        nodes;
		const SolidMotion<D>&       motion;
		const PoreWater<D>*         water; ///< null in ground without
		const MotionConstraints<D>& constraints;
		const FrontConstants&       constants;
		double                      dt; ///< of the step [s]
	};
	/// Corrections of the velocities of both sides at all front nodes, from the folded sums, and the work [J] that the forces between the sides
	/// take up at each.
	void solve(const StepContext<D>& step, const Inputs& in, FrontRecords<D>& records, std::vector<double>& work);
	/// Part of a jump of the solid that drag gives to the liquid, at a node solved before [-].
	double follows(int slot) const { return contacts_[slot].follows; }

private:
	std::vector<ContactNode<D>> contacts_;
};

} // namespace talik
