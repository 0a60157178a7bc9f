// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/boundary/Boundary.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <functional>
#include <vector>

namespace talik {

template <int D> class ThawFront;

struct PhaseAccelerations {
	double solid, liquid; ///< [m/s^2]
};

/// Accelerations of one node with the drag between the phases implicit, in any direction, eq. (8.2):
///   M_s a_s + M_l a_l = f_m,   (M_l + dt Q) a_l - dt Q a_s = f_l - Q (v_l - v_s)
/// Permeability then does not limit the step.
class NodeDrag {
public:
	/// solidMass > 0, liquidMass >= 0 [kg], drag Q >= 0 [kg/s] (not both zero with liquidMass)
	NodeDrag(double solidMass, double liquidMass, double drag, double dt)
	        : liquidMass_(liquidMass)
	        , drag_(drag)
	        , dq_(dt * drag)
	        , perSolid_(1.0 / solidMass)
	        // dividing by M_s first keeps the digits when drag is many orders larger than inertia
	        , perInertia_(1.0 / (liquidMass + dq_ * (1.0 + liquidMass * perSolid_)))
	{}
	/// Forces [N] on mixture and liquid (without drag), velocities [m/s] at the start of the step.
	PhaseAccelerations operator()(double solidVelocity, double liquidVelocity, double mixtureForce, double liquidForce) const
	{
		const double residual = liquidForce - drag_ * (liquidVelocity - solidVelocity);
		const double liquid   = (residual + dq_ * (mixtureForce * perSolid_)) * perInertia_;
		return { (mixtureForce - liquidMass_ * liquid) * perSolid_, liquid };
	}

private:
	double liquidMass_, drag_, dq_, perSolid_, perInertia_;
};

/// Momentum balance of the nodes: gravity, surface loads, mechanical boundaries, damping and, with water, the implicit drag.
template <int D> class MomentumSolver {
	using Mirror = typename MotionConstraints<D>::Mirror;

public:
	MomentumSolver(const Grid<D>& grid, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries);

	void addGravity(const ActiveRange& range, SolidMotion<D>& motion, const PoreWater<D>* water) const;
	/// Only nodes [first, last) are used from now on; all others are zero and take no memory.
	void keepOnly(int first, int last) { damping_.keepOnly(first, last); }
	/// traction of a boundary on its nodes; remembered for the account of work.
	void addLoad(const Boundary<D>& boundary, const SurfacePatch<D>& patch, double time, SolidMotion<D>& motion);
	/// Forces on the masses that lie in the volume of a boundary, given by their acceleration.
	void accelerate(const Boundary<D>& boundary, const std::vector<NodeShare>& shares, SolidMotion<D>& motion);
	/// Velocities of moving walls in a step from one calendar time to another [s] and of length dt. Throws std::runtime_error if a wall would
	/// leave its nodes by more than half a cell.
	void beginStep(const Grid<D>& grid, const ShapeFunction<D>& shape, double from, double to, double dt);
	/// The path of the walls in a step that is done.
	void endStep(double dt);
	/// Leaves the solved values of both phases on the nodes, ready to be gathered. water and front may be null. With keepWorks the works are
	/// summed. Walls outside the range are left out. change: what changes the solved values before they are booked, by correct().
	void solve(
	        const StepContext<D>& step, SolidMotion<D>& motion, PoreWater<D>* water, ThawFront<D>* front, bool keepWorks,
	        const std::function<void()>& change);
	/// What a force on the mixture of a node changes in dt of the velocity of its grains and its liquid, which move together [m/s/N]; 0 where walls
	/// hold them. After solve().
	void findResponse(const ActiveRange& range, const SolidMotion<D>& motion, const PoreWater<D>& water, double dt, NodeField<D>& response) const;
	/// Forces behind walls are folded into the nodes in front of them, and those at walls that are ahead of their nodes act there, too, eq. (8.5).
	/// beforeMoving: called before a ghost of a moving wall is folded.
	void foldForces(const ActiveRange& range, NodeField<D>& force, const std::function<void(const Mirror&)>& beforeMoving = {}) const;
	/// The transpose of folding, for changes of velocities; nodes that periodic sides repeat get what their originals have.
	void unfoldChanges(const ActiveRange& range, NodeField<D>& change) const;
	/// Adds what more force changes of the solved velocities of solid and liquid, and books what walls hold of it. change: what findResponse()
	/// found. Both fields are used up.
	void correct(
	        const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>& water, NodeField<D>& force, NodeField<D>& change, double dt,
	        StepLedger<D>& ledger);
	/// Adds to the solved velocities of the nodes that take it the momentum that they miss [kg m/s], which becomes the velocity added [m/s].
	void addMissing(const ActiveRange& range, SolidMotion<D>& motion, NodeField<D>& missing, const std::function<bool(int)>& takes) const;
	/// Ghost nodes and their images, in the order in which they are folded.
	const std::vector<typename MotionConstraints<D>::Mirror>& mirrors() const { return mirrors_; }
	/// Of these, the nodes whose liquid is not folded with the solid, ghosts and images.
	const std::vector<int>& freeLiquid() const { return freeLiquid_; }
	/// Axes along which a wall holds the ground at a node on it, in front of it or behind, a bit each.
	const std::vector<unsigned char>& heldAxes() const { return heldAxes_; }
	/// Paths of the moving walls since the start [m]; they belong to the state.
	std::vector<Vec<D>>& wallPaths() { return wallPaths_; }

private:
	const std::vector<NodeImage>& images_; ///< nodes that periodic sides repeat
	struct Load {
		int    node;
		Vec<D> force;
	};
	struct WallRecord {
		double solidMass, liquidMass;
		Vec<D> momentumLeft, force;
	};
	/// A wall that moves; its boundary is that of the settings.
	struct MovingWall {
		std::shared_ptr<Boundary<D>> boundary;
		Vec<D>                       velocity {}, change {}; ///< at the start of the step and in it [m/s]
		double                       lead = 0.0;             ///< lambda of eq. (8.5)
		double                       endOf(int axis) const { return velocity[axis] + change[axis]; }
	};
	/// What lies behind a moving wall, as it is folded.
	struct Folded : WallRecord {
		int    mirror;
		Vec<D> pushed; ///< force on the node in front, eq. (8.5) [N]
	};
	WallRecord recordOf(int node, const SolidMotion<D>& motion, const PoreWater<D>* water) const;
	void       applySymmetry(const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>* water, double dt);
	void       applySymmetryToSolid(const typename MotionConstraints<D>::Mirror& m, SolidMotion<D>& motion, PoreWater<D>& water, double dt) const;
	template <bool Damped> void solveDry(const ActiveRange& range, SolidMotion<D>& motion, double dt);
	template <bool Damped> void solveTwoPhase(const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>& water, double dt);
	/// Folds more force, and remembers what moving walls bear of it.
	void foldMore(const ActiveRange& range, SolidMotion<D>& motion, NodeField<D>& force);
	void unfoldMirrors(const ActiveRange& range, NodeField<D>& change) const;
	void constrainDry(const ActiveRange& range, SolidMotion<D>& motion) const;
	/// What a wall that has left its nodes by a part of a cell gives to the nodes in front of it.
	void pushAhead(SolidMotion<D>& motion, PoreWater<D>* water, double dt);
	/// Gives nodes on moving walls their velocity.
	void carry(const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>* water, double dt);
	void keepWallWork(const ActiveRange& range, const SolidMotion<D>& motion, const PoreWater<D>* water, double dt, StepLedger<D>& ledger) const;
	void constrainTwoPhase(const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>& water, double dt) const;
	void constrainLiquid(SolidMotion<D>& motion, PoreWater<D>& water, int node, double dt) const;
	void unfold(const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>* water, double dt) const;
	void findFlux(const ActiveRange& range, const SolidMotion<D>& motion, PoreWater<D>& water) const;
	/// Sums the momenta of the step and, with keepWorks, the works.
	void keepAccount(const ActiveRange& range, const SolidMotion<D>& motion, const PoreWater<D>* water, double dt, bool keepWorks, StepLedger<D>& ledger);

	MotionConstraints<D>                               constraints_;
	std::vector<typename MotionConstraints<D>::Mirror> mirrors_;    ///< those whose liquid is held first
	std::vector<char>                                  foldLiquid_; ///< per mirror: the liquid is held by the wall like the solid
	std::vector<int>                                   freeLiquid_;
	std::vector<unsigned char>                         heldAxes_;
	std::vector<int>                                   wallNodes_; ///< nodes whose motion the walls change
	std::vector<char>                                  isWall_;
	std::vector<WallRecord>                            walls_;
	std::vector<MovingWall>                            moving_;
	std::vector<Vec<D>>                                wallPaths_;
	std::vector<Folded>                                folded_; ///< one per mirror of a moving wall
	std::vector<Load>                                  loads_;
	NodeField<D>                                       damping_; ///< force of local damping; allocated when damping is used
};

} // namespace talik
