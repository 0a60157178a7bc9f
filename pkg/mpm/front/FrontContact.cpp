// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/ThreadPool.hpp>
#include <pkg/mpm/front/FrontContact.hpp>

#include <algorithm>

namespace talik {

namespace {
	template <int D> using In = typename FrontContact<D>::Inputs;
	template <int D> using R  = FrontRecords<D>;

	/// Direction of the front at a node, from frozen to thawed, eq. (20.0): minus the gradient of the frozen part of the volume. It points from any frozen
	/// point to any thawed one, whatever free surface is near, because the logarithm of a shape function is concave.
	template <int D> Vec<D> directionOf(const double* sums)
	{
		const double frozen = sums[R<D>::volumeAt], thawed = sums[R<D>::thawedVolumeAt];
		Vec<D>       direction {};
		for (int a = 0; a < D && frozen + thawed > 0.0; ++a)
			direction[a] = (thawed * sums[R<D>::areaAt + a] - frozen * sums[R<D>::thawedAreaAt + a]) / (frozen + thawed);
		return direction;
	}

	/// Sum of the directions around a node that face as its own does. Those of single nodes follow the steps between rows of points, and sides that
	/// slide along such steps catch on them.
	template <int D> Vec<D> directionAround(const In<D>& in, const FrontRecords<D>& records, int node, const Vec<D>& own)
	{
		Vec<D> sum {};
		in.nodes.overBeside(node, [&](int slot) {
			Vec<D> free = directionOf<D>(records.sums(slot));
			for (int a = 0; a < D; ++a)
				if (in.constraints.solidFixed(node, a) || in.constraints.solidFixed(in.nodes.node(slot), a)) free[a] = 0.0;
			if (dot<D>(own, free) > 0.0) sum += free;
		});
		return sum;
	}

	/// Area of the front along its normal, of the side that has no free surface there: the larger one.
	template <int D> double areaOf(const In<D>& in, const double* sums, int node, const Vec<D>& normal)
	{
		double frozen = 0.0, thawed = 0.0;
		for (int a = 0; a < D; ++a) {
			if (in.constraints.solidFixed(node, a)) continue;
			frozen += sums[R<D>::areaAt + a] * normal[a];
			thawed -= sums[R<D>::thawedAreaAt + a] * normal[a];
		}
		return std::max(0.0, std::max(frozen, thawed));
	}

	/// Masses, area and normal of a node; false where the sides do not meet.
	template <int D> bool findFront(const In<D>& in, const FrontRecords<D>& records, int slot, ContactNode<D>& c)
	{
		const int     node = in.nodes.node(slot);
		const double  mass = in.motion.nodes[node][SolidMotion<D>::massAt];
		const double* sums = records.sums(slot);
		if (!(mass > 0.0)) return false; // a ghost, folded into its image
		c.solid  = { sums[R<D>::massAt], sums[R<D>::thawedMassAt] };
		c.liquid = { sums[R<D>::liquidMassAt], sums[R<D>::thawedLiquidMassAt] };
		for (const double solid : c.solid)
			if (!(solid > FrontConstants::smallestMassShare * mass)) return false;
		Vec<D> own = directionOf<D>(sums);
		for (int a = 0; a < D; ++a)
			if (in.constraints.solidFixed(node, a)) own[a] = 0.0;
		c.normal            = directionAround<D>(in, records, node, own);
		const double length = lengthOf<D>(c.normal);
		if (!(length > 0.0)) return false;
		c.normal = c.normal / length;
		c.area   = areaOf<D>(in, sums, node, c.normal);
		return true;
	}

	/// Part of a change of the solid's velocity that implicit drag gives to the liquid of a node within the step. Liquid that drag does not hold
	/// flows on: if it jumped with the solid, its flow along the front would do work on the jump that nobody gave.
	template <int D> double followingLiquid(const In<D>& in, int node)
	{
		if (!in.water) return 0.0;
		const double drag = in.dt * in.water->nodes[node][PoreWater<D>::dragAt], sum = drag + in.water->nodes[node][PoreWater<D>::massAt];
		return sum > 0.0 ? drag / sum : 0.0;
	}

	/// What the liquid of the sides does to the jump of their solids, eq. (20.1). The force that drives the liquid of the node is divided by mass.
	template <int D> double jumpByDrag(const In<D>& in, const double* sums, int node, int axis, const ContactNode<D>& c)
	{
		const double frozen = sums[R<D>::liquidMomentumAt + axis], thawed = in.water->nodes[node][PoreWater<D>::momentumAt + axis] - frozen;
		const double mass = c.liquid[0] + c.liquid[1], flowing = mass > 0.0 ? (1.0 - c.follows) * in.dt * in.water->force[node][axis] / mass : 0.0;
		return (c.follows * thawed - c.liquid[1] * flowing) / c.moved[1] - (c.follows * frozen - c.liquid[0] * flowing) / c.moved[0];
	}

	/// Jump between the sides, eq. (20.1), and the force with which they press, eq. (20.1a), if neither felt the other.
	template <int D> void moveApart(const In<D>& in, const double* sums, int node, ContactNode<D>& c)
	{
		const double* all     = in.motion.nodes[node];
		const double  mass[2] = { c.solid[0] + c.liquid[0], c.solid[1] + c.liquid[1] }, together = mass[0] * mass[1] / (mass[0] + mass[1]);
		c.follows = followingLiquid<D>(in, node);
		for (int side = 0; side < 2; ++side)
			c.moved[side] = c.solid[side] + c.follows * c.liquid[side];
		c.reducedMass = c.moved[0] * c.moved[1] / (c.moved[0] + c.moved[1]);
		for (int a = 0; a < D; ++a) {
			if (in.constraints.solidFixed(node, a)) continue;
			const double force[2] = { sums[R<D>::forceAt + a], all[SolidMotion<D>::forceAt + a] - sums[R<D>::forceAt + a] };
			c.jump[a]             = (sums[R<D>::thawedMomentumAt + a] + in.dt * force[1]) / c.moved[1]
			        - (sums[R<D>::momentumAt + a] + in.dt * force[0]) / c.moved[0];
			if (in.water) c.jump[a] += jumpByDrag<D>(in, sums, node, a, c);
			c.pressing -= together * (force[1] / mass[1] - force[0] / mass[0]) * c.normal[a];
		}
	}

	/// Part of the reaction that pore water of the thawed side bears if it does not flow along the normal [N], eq. (20.2b): what keeps it from
	/// moving through the frozen side, by the balance of its own forces, as R is by those of all.
	template <int D> double buoyancyOf(const In<D>& in, const double* sums, int node, const ContactNode<D>& c)
	{
		const double* all   = in.motion.nodes[node];
		const double  mass  = c.solid[0] + c.solid[1] + c.liquid[0] + c.liquid[1];
		double        force = 0.0;
		for (int a = 0; a < D; ++a)
			force -= c.normal[a]
			        * (sums[R<D>::fullMassAt] * (in.motion.settings->gravity[a] - all[SolidMotion<D>::forceAt + a] / mass)
			           + sums[R<D>::poreForceAt + a]);
		return force;
	}

	/// What the thawed points bring to the contact, by their volume.
	template <int D> void takeThawedMeans(const In<D>& in, const double* sums, int node, ContactNode<D>& c)
	{
		const double volume = sums[R<D>::thawedVolumeAt];
		c.friction          = sums[R<D>::frictionAt] / volume;
		c.cohesion          = sums[R<D>::cohesionAt] / volume;
		if (in.water) c.buoyancy = buoyancyOf<D>(in, sums, node, c);
		double carried = 0.0;
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D && !in.constraints.solidFixed(node, i); ++j) // a wall takes the rest
				carried += c.normal[i] * sums[R<D>::stressAt + stressIndex<D>(i, j)] * c.normal[j] / volume;
		c.tension = c.area * std::max(0.0, carried);
	}

	/// Thawed ground that lies on frozen ground and does not slide settles with it: ground loses volume as it thaws, and a tie that holds one way only
	/// would leave gaps. It slides where its slip is faster than what it moves along the normal and than gravity moves it in a step.
	template <int D> bool settles(const In<D>& in, const ContactNode<D>& c)
	{
		const Vec<D>& gravity = in.motion.settings->gravity;
		const double  weight = lengthOf<D>(gravity), along = dot<D>(c.jump, c.normal), slipping = dot<D>(c.jump, c.jump) - along * along;
		return -dot<D>(gravity, c.normal) > in.constants.restingWeight * weight && slipping <= std::max(along * along, weight * weight * in.dt * in.dt);
	}

	/// The sides share their normal velocity unless the thawed ground would have to carry more tension than it does. The reaction is that of forces
	/// alone: what a side's velocity differs from the other's is mostly the slope of one velocity field.
	template <int D> void press(const In<D>& in, ContactNode<D>& c)
	{
		const double tie = -c.reducedMass * dot<D>(c.jump, c.normal);
		c.together       = tie >= -in.dt * c.tension || c.cohesion > R<D>::mostStated || settles<D>(in, c);
		c.reaction       = c.together ? std::max(c.pressing, -c.tension) : -c.tension;
		c.impulse        = c.together ? tie : -in.dt * c.tension;
	}

	/// The jump along the front [m/s].
	template <int D> Vec<D> slipOf(const ContactNode<D>& c) { return c.jump - dot<D>(c.jump, c.normal) * c.normal; }

	/// What the nodes around bear together, eqs. (20.2a) and (20.2b): one node alone tells little of what water bears, and on a front that is inclined to
	/// the grid it has the traction of a step of the front.
	template <int D> void lookAround(const In<D>& in, std::vector<ContactNode<D>>& contacts, int slot)
	{
		double cohesion = 0.0, friction = 0.0, reaction = 0.0, buoyancy = 0.0;
		Vec<D> asked {};
		in.nodes.overBeside(in.nodes.node(slot), [&](int other) {
			const ContactNode<D>& c = contacts[other];
			if (!c.meets) return;
			reaction += c.reaction;
			buoyancy += c.buoyancy;
			if (!c.together || c.cohesion > R<D>::mostStated) return;
			cohesion += c.cohesion * c.area;
			friction += c.friction * c.reaction;
			asked += c.reducedMass * slipOf<D>(c);
		});
		ContactNode<D>& c = contacts[slot];
		if (reaction > 0.0) c.carried = 1.0 - std::clamp(buoyancy / reaction, 0.0, 1.0);
		c.rests = c.together && lengthOf<D>(asked) <= (cohesion + friction * c.carried) * in.dt;
	}

	/// The jump that friction and cohesion leave, eq. (20.2). Returns the work that the force between the sides takes up.
	template <int D> double slide(const In<D>& in, ContactNode<D>& c)
	{
		const Vec<D> slip     = slipOf<D>(c);
		const double speed    = lengthOf<D>(slip);
		const double strength = c.together ? std::max(0.0, c.cohesion * c.area + c.friction * c.carried * c.reaction) * in.dt : 0.0;
		const double held     = speed > 0.0 && !c.rests ? std::min(1.0, strength / (c.reducedMass * speed)) : 1.0;
		double       work     = 0.0;
		for (int i = 0; i < D; ++i) {
			const double impulse = c.impulse * c.normal[i] - held * c.reducedMass * slip[i];
			c.jump[i] += impulse / c.reducedMass;
			work -= impulse * c.jump[i];
		}
		return work;
	}

	/// Velocity at the start of a step by which each side, and its liquid, differs from the node.
	template <int D> struct Departures {
		Vec<D> solid[2], liquid[2];
	};

	template <int D> Departures<D> departuresOf(const In<D>& in, const double* sums, int node, const ContactNode<D>& c)
	{
		Departures<D> d {};
		for (int a = 0; a < D; ++a) {
			const double momentum[2] = { sums[R<D>::momentumAt + a], sums[R<D>::thawedMomentumAt + a] };
			const double common      = (momentum[0] + momentum[1]) / (c.solid[0] + c.solid[1]);
			for (int side = 0; side < 2; ++side) {
				d.solid[side][a] = momentum[side] / c.solid[side] - common;
				if (!in.water || !(c.liquid[side] > FrontConstants::smallestMassShare * (c.liquid[0] + c.liquid[1]))) continue;
				const double frozen = sums[R<D>::liquidMomentumAt + a], all = in.water->nodes[node][PoreWater<D>::momentumAt + a];
				d.liquid[side][a] = (side == 0 ? frozen : all - frozen) / c.liquid[side] - in.water->start[node][a];
			}
		}
		// along the normal of sides that stay together points take the acceleration of the node, as anywhere else
		for (auto* both : { &d.solid, &d.liquid })
			for (Vec<D>& departure : *both) {
				const double along = c.together ? dot<D>(departure, c.normal) : 0.0;
				for (int a = 0; a < D; ++a)
					departure[a] -= along * c.normal[a];
			}
		return d;
	}

	/// Corrections for both sides from the jump between them. The liquid of a side keeps of its own what drag does not give to it.
	template <int D> void correct(const In<D>& in, const ContactNode<D>& c, int node, const double* sums, double* answer)
	{
		const Departures<D> d    = departuresOf<D>(in, sums, node, c);
		const double        kept = in.motion.kept, keptLiquid = in.water ? in.water->kept : 0.0, moved = c.moved[0] + c.moved[1];
		for (int side = 0; side < 2; ++side) {
			double*      s     = answer + side * R<D>::sideSize;
			const double share = (side == 0 ? -c.moved[1] : c.moved[0]) / moved;
			for (int a = 0; a < D; ++a) {
				const double velocity   = share * c.jump[a];
				s[R<D>::velocityAt + a] = velocity;
				s[R<D>::gainAt + a]     = velocity - kept * d.solid[side][a];
				if (in.water) s[R<D>::liquidGainAt + a] = c.follows * velocity + (1.0 - c.follows - keptLiquid) * d.liquid[side][a];
			}
		}
		const Vec<D> slip = slipOf<D>(c);
		std::copy(slip.begin(), slip.end(), answer + R<D>::Slip::at + R<D>::Slip::velocity);
	}
} // namespace

template <int D> void FrontContact<D>::solve(const StepContext<D>& step, const Inputs& in, FrontRecords<D>& records, std::vector<double>& work)
{
	const int     count     = in.nodes.count();
	constexpr int piece     = 64;
	const auto    overSlots = [&](auto&& task) {
                ThreadPool::run((count + piece - 1) / piece, step.halo.parallel ? ThreadPool::threads() : 1, [&](int i, int) {
                        for (int slot = i * piece; slot < std::min(count, (i + 1) * piece); ++slot)
                                task(slot);
                });
	};
	contacts_.assign(count, {});
	work.assign(count, 0.0);
	overSlots([&](int slot) {
		ContactNode<D>& c    = contacts_[slot];
		const double*   sums = records.sums(slot);
		const int       node = in.nodes.node(slot);
		if (!(c.meets = findFront<D>(in, records, slot, c))) return;
		moveApart<D>(in, sums, node, c);
		takeThawedMeans<D>(in, sums, node, c);
		press<D>(in, c);
	});
	overSlots([&](int slot) {
		if (contacts_[slot].meets) lookAround<D>(in, contacts_, slot);
	});
	overSlots([&](int slot) {
		ContactNode<D>& c = contacts_[slot];
		if (!c.meets) return;
		work[slot] = slide<D>(in, c);
		correct<D>(in, c, in.nodes.node(slot), records.sums(slot), records.answer(slot));
	});
}

TALIK_IN_PLANE_AND_SPACE(FrontContact);

} // namespace talik
