// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/front/FrontContact.hpp>
#include <pkg/mpm/front/FrontNodes.hpp>
#include <pkg/mpm/front/FrontTransfer.hpp>
#include <pkg/mpm/front/FrontWalls.hpp>

#include <optional>
#include <vector>

namespace talik {

/// Effect: ground that ice holds (F) and ground that it does not (T) have velocities of their own on the nodes that both reach, the
/// front nodes. With one velocity a thawed layer thinner than the reach of the shape functions moves with its frozen base.
///
/// The solved velocity of a node is that of both sides together. Here each side's balance without the other gives the velocity at
/// which it would move, eq. (20.1), and the force between the sides changes it: mass times correction adds up to zero over both sides; points of
/// each side see its correction. One rule holds at all front nodes, with the normal n from F to T and the area A of eq. (20.0):
///   normal:     the sides share their normal velocity unless the thawed points would have to carry more tension than they do; thawed ground that
///               lies on frozen ground and does not slide shares it always;
///   tangential: Coulomb friction and cohesion of the thawed ground in simple shear at the effective part of the reaction, eq. (20.2), and no
///               more than what makes the tangential velocities equal.
/// Sides whose thawed law states no strength stay together. The liquid of a side jumps as far as drag takes it along within the step; temperature,
/// pressure and the velocity of the water through the grains have one value on a node.
template <int D> class ThawFront {
public:
	using Mirrors = typename FrontNodes<D>::Mirrors;

	/// The points as their effects have them.
	using Points = typename FrontTransfer<D>::Points;

	ThawFront(PointFields& fields, const ThawFrontSettings& settings)
	        : transfer_(settings.constants)
	        , constants_(settings.constants)
	{
		fields.declare("frozenSide", "thaw front", "-", side_);
		fields.declare("slip", "thaw front", "m", slip_);
	}
	void bind(MaterialPoints<D>& points, const Grid<D>& grid, bool water)
	{
		nodes_.bind(grid, points, side_);
		transfer_.bind(nodes_, records_, slip_, points.capacity(), water);
	}
	/// Sides of all points at the start of the scene, from their ice saturation, by place [-].
	void start(int first, int end, const double* iceSaturation) { nodes_.start(first, end, iceSaturation); }
	/// Only points of this part are used from now on; all others are zero and take no memory.
	void keepOnly(int firstPoint, int endPoint)
	{
		nodes_.keepOnly(firstPoint, endPoint);
		transfer_.keepOnly(firstPoint, endPoint);
	}

	/// Detection: sides of the points and the front nodes of the step, see FrontNodes::find.
	void find(const StepContext<D>& step, const double* iceSaturation, const Mirrors& mirrors, const std::vector<int>& freeLiquid)
	{
		nodes_.find(step, iceSaturation, mirrors, freeLiquid);
		records_.clear(nodes_.count());
	}
	void exceptFromMeans(CellMeans<D>& cells, int first, int last) const { nodes_.exceptFromMeans(cells, first, last); }
	/// True if the sides have velocities of their own at a node.
	bool parts(int node) const { return nodes_.slot(node) >= 0; }
	/// True if there are front nodes in this step.
	bool present() const { return !nodes_.empty(); }

	/// Thawed points near the front among some places, ascending.
	const std::vector<int>& thawedNear(const std::vector<int>& places) { return nodes_.thawedNear(places); }
	void                    setStrength(int place, const std::optional<ShearStrength>& strength) { transfer_.setStrength(place, strength); }

	/// Transfer to the front nodes: what the points of a block bring; affine may be null.
	void map(const StepContext<D>& step, const WeightBlock<D>& w, const Points& points, const AffineVelocity<D>* affine)
	{
		transfer_.map(step, w, points, affine);
	}
	/// Adds a force [N] on point k of a block to the front nodes: one that the mapped stress does not contain.
	void push(const WeightBlock<D>& w, int k, const Vec<D>& force) { transfer_.push(w, k, force); }
	void pushNode(int place, int node, const Vec<D>& force) { transfer_.pushNode(place, node, force); }
	void addGravity(const Vec<D>& gravity) { transfer_.addGravity(gravity); }
	/// Gives the frozen side its part of a surface load [N] on a node of this mass [kg]; call before mirrors are folded.
	void addLoad(int node, double mass, const Vec<D>& force)
	{
		if (present() && nodes_.slot(node) >= 0) transfer_.addLoad(nodes_.slot(node), mass, force);
	}
	/// What map() and push() add to.
	void shareMapped(const Grid<D>& grid, HaloExchange& rows) { transfer_.shareMapped(nodes_.rowStarts(grid), rows); }
	/// Contact and walls: corrections of the velocities that motion and water (null in ground without) have on the nodes. Call when mirrors are folded
	/// and before they are unfolded. Books what the force between the sides takes from their slip, and what walls give to the sides apart.
	void solve(
	        const StepContext<D>& step, const SolidMotion<D>& motion, const PoreWater<D>* water, const MotionConstraints<D>& constraints,
	        const Mirrors& mirrors)
	{
		if (!present()) return;
		walls_.applySymmetry(step, nodes_, mirrors, records_);
		walls_.pushAhead(step, nodes_, mirrors, motion, records_);
		contact_.solve(step, { nodes_, motion, water, constraints, constants_, step.dt }, records_, work_);
		walls_.leadWalls(step, nodes_, mirrors, motion, contact_, water != nullptr, records_);
		walls_.unfold(step, nodes_, mirrors, records_);
		for (int slot = 0; slot < nodes_.count(); ++slot)
			step.ledger.ofNode(nodes_.node(slot)).slipWork += work_[slot];
	}
	/// Transfer to the points: corrects velocity, displacement, position and displacement gradient of a block; affine may be null.
	void gather(const StepContext<D>& step, const WeightBlock<D>& w, const Points& points, const AffineVelocity<D>* affine)
	{
		transfer_.gather(step, w, points, affine);
	}
	/// Correction of the velocity [m/s] with which a point of the given place moves at a node; null for none.
	const double* correction(int node, int place) const { return transfer_.correction(node, place); }

private:
	double *            side_ = nullptr, *slip_ = nullptr;
	FrontNodes<D>       nodes_;
	FrontRecords<D>     records_;
	FrontTransfer<D>    transfer_;
	FrontContact<D>     contact_;
	FrontWalls<D>       walls_;
	std::vector<double> work_; ///< by slot, taken up by the force between the sides in the step [J]
	FrontConstants      constants_;
};

} // namespace talik
