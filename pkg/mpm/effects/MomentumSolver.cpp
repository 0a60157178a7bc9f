// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/MomentumSolver.hpp>
#include <pkg/mpm/front/ThawFront.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace talik {

namespace {
	// A node with hardly any liquid takes the solid's velocity: the quotient would be round-off.
	constexpr double smallestLiquidShare = 1e-9;

	double dampingOf(double coefficient, double force, double velocity)
	{
		return -coefficient * std::abs(force) * double((velocity > 0.0) - (velocity < 0.0));
	}

	/// What points gather of a velocity that was another one before the step, chi the part of their own that they keep.
	double gathered(double chi, double before, double now) { return chi * (now - before) + (1.0 - chi) * now; }

	/// The liquid of a node, of velocity vl, where the motion of its grains is given, that of the end vs: its own row of the drag equations.
	template <int D> void followGrains(PoreWater<D>& water, int node, int axis, double vl, double vs, double dt)
	{
		const double mass = water.nodes[node][PoreWater<D>::massAt], drag = water.nodes[node][PoreWater<D>::dragAt];
		const double change      = dt * (water.force[node][axis] - drag * (vl - vs)) / (mass + dt * drag);
		water.flux[node][axis]   = vl + change;
		water.solved[node][axis] = water.kept * change + (1.0 - water.kept) * (vl + change);
	}
} // namespace

template <int D>
MomentumSolver<D>::MomentumSolver(const Grid<D>& grid, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries)
        : images_(grid.images())
        , constraints_(grid)
        , isWall_(grid.nodeCount(), 0)
{
	std::size_t loaded = 0;
	for (const auto& b : boundaries) {
		constraints_.beginWall(b->moves() ? int(moving_.size()) : -1);
		if (b->moves()) {
			moving_.emplace_back();
			moving_.back().boundary = b;
			wallPaths_.push_back(b->pathBefore());
		}
		b->constrainMotion(grid, constraints_);
		if (b->loads() || b->accelerates()) loaded += grid.nodeCount();
	}
	loads_.reserve(loaded);
	constraints_.close();
	const auto held = [&](const auto& m) {
		for (int a = 0; a < D; ++a)
			if (constraints_.solidFixed(m.wall(), a) && !constraints_.liquidTied(m.wall(), a)) return false;
		return true;
	};
	// at edges a ghost is folded twice: what is folded with its liquid must come first
	for (const bool wanted : { true, false })
		for (const auto& m : constraints_.mirrors())
			if (held(m) == wanted) {
				mirrors_.push_back(m);
				foldLiquid_.push_back(wanted);
				if (!wanted) freeLiquid_.insert(freeLiquid_.end(), { m.ghost, m.inner });
				isWall_[m.ghost] = isWall_[m.inner] = 1;
			}
	for (int n : constraints_.constrainedNodes())
		isWall_[n] = 1;
	heldAxes_.assign(grid.nodeCount(), 0);
	const auto fixedAxes = [&](int node) {
		unsigned char axes = 0;
		for (int a = 0; a < D; ++a)
			axes |= constraints_.solidFixed(node, a) << a;
		return axes;
	};
	for (int n : constraints_.constrainedNodes())
		heldAxes_[n] |= fixedAxes(n);
	for (const auto& m : constraints_.mirrors())
		for (const int n : { m.ghost, m.inner })
			heldAxes_[n] |= fixedAxes(m.wall());
	for (int n = 0; n < grid.nodeCount(); ++n)
		if (isWall_[n]) wallNodes_.push_back(n);
	walls_.resize(wallNodes_.size());
	folded_.reserve(std::count_if(mirrors_.begin(), mirrors_.end(), [](const auto& m) { return m.moving >= 0; }));
	damping_.allocate(grid.nodeCount());
}

template <int D> void MomentumSolver<D>::addGravity(const ActiveRange& range, SolidMotion<D>& motion, const PoreWater<D>* water) const
{
	const Vec<D> b = motion.settings->gravity;
	range.eachNode([&](int i) {
		double* r = motion.nodes[i];
		addTo<D>(r + motion.forceAt, (r[motion.massAt] + (water ? water->nodes[i][water->massAt] : 0.0)) * b);
	});
}

template <int D> void MomentumSolver<D>::addLoad(const Boundary<D>& boundary, const SurfacePatch<D>& patch, double time, SolidMotion<D>& motion)
{
	for (std::size_t k = 0; k < patch.nodes.size(); ++k) {
		const SurfaceNode<D>& n    = patch.nodes[k];
		const double          area = lengthOf<D>(n.area);
		if (area == 0.0 || motion.nodes[n.node][motion.massAt] <= 0.0) continue;
		loads_.push_back({ n.node, area * boundary.tractionAt(time, n.area / area, k) });
		addTo<D>(motion.nodes[n.node] + motion.forceAt, loads_.back().force);
	}
}

template <int D> void MomentumSolver<D>::accelerate(const Boundary<D>& boundary, const std::vector<NodeShare>& shares, SolidMotion<D>& motion)
{
	for (std::size_t k = 0; k < shares.size(); ++k) {
		double* const r    = motion.nodes[shares[k].node];
		const double  mass = shares[k].share * r[motion.massAt];
		if (mass <= 0.0) continue;
		loads_.push_back({ shares[k].node, mass * boundary.accelerationAt(k) });
		addTo<D>(r + motion.forceAt, loads_.back().force);
	}
}

/// What a node has before walls change it.
template <int D> typename MomentumSolver<D>::WallRecord MomentumSolver<D>::recordOf(int node, const SolidMotion<D>& motion, const PoreWater<D>* water) const
{
	const double* r      = motion.nodes[node];
	const double* liquid = water ? water->nodes[node] : nullptr;
	WallRecord    w { r[motion.massAt], liquid ? liquid[PoreWater<D>::massAt] : 0.0, {}, {} };
	for (int a = 0; a < D; ++a) {
		w.momentumLeft[a] = (1.0 - motion.kept) * r[motion.momentumAt + a]
		        + (liquid ? (1.0 - water->kept) * liquid[PoreWater<D>::momentumAt + a] : 0.0);
		w.force[a] = r[motion.forceAt + a];
	}
	return w;
}

namespace {
	/// lambda of eq. (8.5): weights of a point on a wall that is so far [m] ahead of its side.
	template <int D> double leadOf(const Grid<D>& grid, const ShapeFunction<D>& shape, const Side& side, double ahead)
	{
		if (ahead == 0.0) return 0.0;
		const Vec<D>& from = side.upper ? grid.upper() : grid.lower();
		Vec<D>        at   = grid.lower();
		at[side.axis]      = from[side.axis] + (side.upper ? -ahead : ahead);
		std::array<const double*, D> x;
		for (int a = 0; a < D; ++a)
			x[a] = &at[a];
		WeightBlock<D> w;
		shape.evaluate(grid, x, 0, 1, w);
		const int  first = grid.nodeOf(w.base[0])[side.axis], wall = side.upper ? grid.cells(side.axis) + 1 : 1, inward = side.upper ? -1 : 1;
		const auto weight = [&](int node) { return node < first || node >= first + supportNodes ? 0.0 : w.value[side.axis][node - first][0]; };
		return (weight(wall + inward) - weight(wall - inward)) / weight(wall);
	}
} // namespace

template <int D> void MomentumSolver<D>::beginStep(const Grid<D>& grid, const ShapeFunction<D>& shape, double from, double to, double dt)
{
	constexpr double farthest = 0.5; // cells; beyond it the ground in front of a wall loses its nodes
	for (std::size_t k = 0; k < moving_.size(); ++k) {
		MovingWall&  w    = moving_[k];
		const Vec<D> end  = w.boundary->velocity(to);
		w.velocity        = w.boundary->velocity(from);
		w.change          = end - w.velocity;
		const double away = w.boundary->away(wallPaths_[k] + dt * end);
		w.lead            = leadOf(grid, shape, w.boundary->region().on, w.boundary->ahead(wallPaths_[k]));
		if (away <= farthest * grid.spacing()) continue;
		std::ostringstream text;
		text << w.boundary->name() << " on " << w.boundary->region().describe() << " would have moved by " << away
		     << " m across its nodes, more than half of gridSpacing = " << grid.spacing()
		     << "; the ground is as it was before this step: let it stop in time (times, values), use larger cells, or a body of the scene for longer "
		        "paths";
		throw std::runtime_error(text.str());
	}
	for (auto& m : mirrors_) {
		if (m.moving < 0) continue;
		m.velocity = moving_[m.moving].velocity;
		m.change   = moving_[m.moving].change;
		m.lead     = moving_[m.moving].lead;
	}
}

template <int D> void MomentumSolver<D>::pushAhead(SolidMotion<D>& motion, PoreWater<D>* water, double dt)
{
	using W = PoreWater<D>;
	for (Folded& f : folded_) {
		const auto&   m  = mirrors_[f.mirror];
		double*       r  = motion.nodes[m.inner];
		const double* on = motion.nodes[m.wall()];
		if (m.lead == 0.0 || !(r[motion.massAt] > 0.0) || !(on[motion.massAt] > 0.0)) continue;
		const double liquid = water ? water->nodes[m.wall()][W::massAt] : 0.0;
		for (int a = 0; a < D; ++a) {
			if (m.sign[a] > 0.0) continue;
			f.pushed[a] = m.lead * ((on[motion.massAt] + liquid) * m.change[a] / dt - on[motion.forceAt + a]);
			r[motion.forceAt + a] += f.pushed[a];
			if (water) water->force[m.inner][a] += m.lead * (liquid * m.change[a] / dt - water->force[m.wall()][a]);
		}
	}
}

template <int D> void MomentumSolver<D>::endStep(double dt)
{
	for (std::size_t k = 0; k < moving_.size(); ++k)
		wallPaths_[k] += dt * (moving_[k].velocity + moving_[k].change);
}

template <int D> void MomentumSolver<D>::applySymmetry(const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>* water, double dt)
{
	using W = PoreWater<D>;
	folded_.clear();
	for (std::size_t k = 0; k < mirrors_.size(); ++k) {
		const auto& m = mirrors_[k];
		if (!range.holds(m.inner)) continue;
		double* ghost = motion.nodes[m.ghost];
		double* inner = motion.nodes[m.inner];
		if (m.moving >= 0) folded_.push_back({ recordOf(m.ghost, motion, water), int(k), {} });
		const double mass = ghost[motion.massAt], moving = mass + (water && foldLiquid_[k] ? water->nodes[m.ghost][W::massAt] : 0.0);
		inner[motion.massAt] += mass;
		ghost[motion.massAt] = 0.0;
		for (int a = 0; a < D; ++a) {
			inner[motion.momentumAt + a] += m.sign[a] * ghost[motion.momentumAt + a] + m.added(a, mass * m.velocity[a]);
			inner[motion.forceAt + a] += m.sign[a] * ghost[motion.forceAt + a] + m.added(a, moving * m.change[a] / dt);
			ghost[motion.momentumAt + a] = ghost[motion.forceAt + a] = 0.0;
		}
		if (!water) continue;
		if (!foldLiquid_[k]) {
			applySymmetryToSolid(m, motion, *water, dt);
			continue;
		}
		double*      ghostLiquid = water->nodes[m.ghost];
		double*      innerLiquid = water->nodes[m.inner];
		const double liquidMass  = ghostLiquid[W::massAt];
		for (int at : { W::massAt, W::dragAt }) {
			innerLiquid[at] += ghostLiquid[at];
			ghostLiquid[at] = 0.0;
		}
		for (int a = 0; a < D; ++a) {
			innerLiquid[W::momentumAt + a] += m.sign[a] * ghostLiquid[W::momentumAt + a] + m.added(a, liquidMass * m.velocity[a]);
			ghostLiquid[W::momentumAt + a] = 0.0;
			water->force[m.inner][a] += m.sign[a] * water->force[m.ghost][a] + m.added(a, liquidMass * m.change[a] / dt);
			water->force[m.ghost][a] = 0.0;
		}
	}
}

template <int D>
void MomentumSolver<D>::applySymmetryToSolid(const typename MotionConstraints<D>::Mirror& m, SolidMotion<D>& motion, PoreWater<D>& water, double dt) const
{
	// The ghost's liquid stays free. Eliminating its acceleration leaves inertia and force on the solid that it is mirrored to:
	// a_l = (f_f + dt Q a_s)/(M_l + dt Q) enters M_s a_s + M_l a_l = f_m.
	using W             = PoreWater<D>;
	const double* ghost = water.nodes[m.ghost];
	double*       inner = motion.nodes[m.inner];
	const double  ml = ghost[W::massAt], q = ghost[W::dragAt], dq = dt * q;
	if (!(ml > 0.0) || !(inner[motion.massAt] > 0.0)) return;
	const double added = ml * dq / (ml + dq);
	const double scale = 1.0 + added / inner[motion.massAt];
	for (int a = 0; a < D; ++a) {
		const double vs       = m.sign[a] * inner[motion.momentumAt + a] / inner[motion.massAt] + m.added(a, m.velocity[a]);
		const double vl       = ghost[W::momentumAt + a] / ml;
		const double residual = water.force[m.ghost][a] - q * (vl - vs) + q * m.added(a, m.change[a]);
		inner[motion.forceAt + a] -= m.sign[a] * ml * residual / (ml + dq);
	}
	for (int a = 0; a < D; ++a)
		inner[motion.momentumAt + a] *= scale;
	inner[motion.massAt] += added;
}

template <int D> template <bool Damped> void MomentumSolver<D>::solveDry(const ActiveRange& range, SolidMotion<D>& motion, double dt)
{
	const double chi = motion.kept, alpha = motion.settings->localDamping;
	range.eachNode([&](int i) {
		const double* r       = motion.nodes[i];
		const double  inverse = r[motion.massAt] > 0.0 ? 1.0 / r[motion.massAt] : 0.0;
		double*       out     = motion.solved[i];
		for (int a = 0; a < D; ++a) {
			const double v = r[motion.momentumAt + a] * inverse;
			double       f = r[motion.forceAt + a];
			if constexpr (Damped) {
				damping_[i][a] = dampingOf(alpha, f, v);
				f += damping_[i][a];
			}
			const double change        = dt * f * inverse;
			out[motion.velocityAt + a] = v + change;
			out[a]                     = chi * change + (1.0 - chi) * (v + change);
		}
	});
}

template <int D> template <bool Damped> void MomentumSolver<D>::solveTwoPhase(const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>& water, double dt)
{
	using W          = PoreWater<D>;
	const double chi = motion.kept, chiLiquid = water.kept, alpha = motion.settings->localDamping;
	range.eachNode([&](int i) {
		const double* r  = motion.nodes[i];
		const double* rl = water.nodes[i];
		const double  ms = r[motion.massAt], ml = rl[W::massAt];
		const bool    wet = ml > smallestLiquidShare * ms;
		if (!(ms > 0.0)) {
			for (int a = 0; a < D; ++a) {
				motion.solved[i][a] = motion.solved[i][motion.velocityAt + a] = water.solved[i][a] = water.flux[i][a] = water.start[i][a] = 0.0;
				if constexpr (Damped) damping_[i][a] = 0.0; // not that of the ground which was here before
			}
			return;
		}
		const NodeDrag coupled(ms, wet ? ml : ms, rl[W::dragAt], dt);
		const double   perSolid = 1.0 / ms, perLiquid = wet ? 1.0 / ml : 0.0, perBoth = 1.0 / (ms + ml);
		for (int a = 0; a < D; ++a) {
			const double vs = r[motion.momentumAt + a] * perSolid;
			const double vl = wet ? rl[W::momentumAt + a] * perLiquid : vs;
			double       f  = r[motion.forceAt + a];
			if constexpr (Damped) {
				damping_[i][a] = dampingOf(alpha, f, vs);
				f += damping_[i][a];
			}
			const PhaseAccelerations acc = wet ? coupled(vs, vl, f, water.force[i][a]) : PhaseAccelerations { f * perBoth, f * perBoth };
			const double             vs1 = vs + dt * acc.solid, vl1 = vl + dt * acc.liquid;
			motion.solved[i][motion.velocityAt + a] = vs1;
			motion.solved[i][a]                     = chi * dt * acc.solid + (1.0 - chi) * vs1;
			water.solved[i][a]                      = chiLiquid * dt * acc.liquid + (1.0 - chiLiquid) * vl1;
			water.flux[i][a]                        = vl1;
			water.start[i][a]                       = vl;
		}
	});
}

template <int D> void MomentumSolver<D>::constrainDry(const ActiveRange& range, SolidMotion<D>& motion) const
{
	const double chi = motion.kept;
	for (int i : constraints_.constrainedNodes()) {
		if (!range.holds(i)) continue;
		const double* r = motion.nodes[i];
		if (!(r[motion.massAt] > 0.0)) continue;
		for (int a = 0; a < D; ++a) {
			if (!constraints_.solidFixed(i, a)) continue;
			motion.solved[i][motion.velocityAt + a] = 0.0;
			motion.solved[i][a]                     = -chi * r[motion.momentumAt + a] / r[motion.massAt];
		}
	}
}

template <int D> void MomentumSolver<D>::constrainLiquid(SolidMotion<D>& motion, PoreWater<D>& water, int i, double dt) const
{
	const double* r = motion.nodes[i];
	if (!(water.nodes[i][PoreWater<D>::massAt] > 0.0)) return;
	for (int a = 0; a < D; ++a) {
		if (!constraints_.solidFixed(i, a) || constraints_.liquidTied(i, a)) continue;
		const double before = r[motion.massAt] > 0.0 ? r[motion.momentumAt + a] / r[motion.massAt] : 0.0;
		const double now    = motion.solved[i][motion.velocityAt + a];
		followGrains(water, i, a, water.start[i][a], now, dt);
		motion.solved[i][a] = gathered(motion.kept, before, now);
	}
}

template <int D> void MomentumSolver<D>::constrainTwoPhase(const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>& water, double dt) const
{
	for (int i : constraints_.constrainedNodes()) {
		if (!range.holds(i)) continue;
		const double* r = motion.nodes[i];
		if (!(r[motion.massAt] > 0.0)) continue;
		for (int a = 0; a < D; ++a) {
			const bool fixed = constraints_.solidFixed(i, a), tied = constraints_.liquidTied(i, a);
			if (!fixed && !tied) continue;
			const double ms = r[motion.massAt], ml = water.nodes[i][water.massAt];
			const double vs = r[motion.momentumAt + a] / ms, vl = water.start[i][a];
			const double common                     = fixed ? 0.0 : vs + dt * r[motion.forceAt + a] / (ms + ml);
			motion.solved[i][motion.velocityAt + a] = common;
			motion.solved[i][a]                     = gathered(motion.kept, vs, common);
			if (!tied) continue;
			water.flux[i][a]   = common;
			water.solved[i][a] = gathered(water.kept, vl, common);
		}
		constrainLiquid(motion, water, i, dt);
	}
}

template <int D> void MomentumSolver<D>::carry(const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>* water, double dt)
{
	for (const auto& c : constraints_.carried()) {
		if (!range.holds(c.node)) continue;
		const double* r = motion.nodes[c.node];
		if (!(r[motion.massAt] > 0.0)) continue;
		const double w                                    = moving_[c.moving].endOf(c.axis);
		const double ahead                                = c.inner >= 0 && motion.nodes[c.inner][motion.massAt] > 0.0 ? moving_[c.moving].lead : 0.0;
		const double before                               = r[motion.momentumAt + c.axis] / r[motion.massAt],
		             v                                    = ahead == 0.0 ? w : w - ahead * (motion.solved[c.inner][motion.velocityAt + c.axis] - w);
		motion.solved[c.node][motion.velocityAt + c.axis] = v;
		motion.solved[c.node][c.axis]                     = gathered(motion.kept, before, v);
		damping_[c.node][c.axis]                          = 0.0;
		if (!water || !constraints_.liquidTied(c.node, c.axis)) continue;
		water->flux[c.node][c.axis]   = v;
		water->solved[c.node][c.axis] = gathered(water->kept, water->start[c.node][c.axis], v);
	}
	if (!water) return;
	for (const auto& c : constraints_.carried())
		if (range.holds(c.node) && motion.nodes[c.node][motion.massAt] > 0.0) constrainLiquid(motion, *water, c.node, dt);
}

template <int D> void MomentumSolver<D>::unfold(const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>* water, double dt) const
{
	using W = PoreWater<D>;
	for (int k = int(mirrors_.size()) - 1; k >= 0; --k) {
		const auto& m = mirrors_[k];
		if (!range.holds(m.inner)) continue;
		const auto takenBy = [&](double kept, int a) { return kept * m.change[a] + (1.0 - kept) * (m.velocity[a] + m.change[a]); };
		for (int a = 0; a < D; ++a) {
			motion.solved[m.ghost][a]                     = m.sign[a] * motion.solved[m.inner][a] + m.added(a, takenBy(motion.kept, a));
			motion.solved[m.ghost][motion.velocityAt + a] = m.sign[a] * motion.solved[m.inner][motion.velocityAt + a]
			        + m.added(a, m.velocity[a] + m.change[a]);
		}
		if (!water) continue;
		for (int a = 0; a < D; ++a) {
			if (foldLiquid_[k]) {
				water->solved[m.ghost][a] = m.sign[a] * water->solved[m.inner][a] + m.added(a, takenBy(water->kept, a));
				water->flux[m.ghost][a]   = m.sign[a] * water->flux[m.inner][a] + m.added(a, m.velocity[a] + m.change[a]);
				water->start[m.ghost][a]  = m.sign[a] * water->start[m.inner][a] + m.added(a, m.velocity[a]);
				continue;
			}
			const double* rl = water->nodes[m.ghost];
			if (!(rl[W::massAt] > 0.0)) continue;
			water->start[m.ghost][a] = rl[W::momentumAt + a] / rl[W::massAt];
			followGrains(*water, m.ghost, a, water->start[m.ghost][a], motion.solved[m.ghost][motion.velocityAt + a], dt);
		}
	}
}

template <int D> void MomentumSolver<D>::findFlux(const ActiveRange& range, const SolidMotion<D>& motion, PoreWater<D>& water) const
{
	range.eachNode([&](int i) {
		for (int a = 0; a < D; ++a)
			water.flux[i][a] = water.nodal[i][PoreWater<D>::Driving::liquidFraction] * (water.flux[i][a] - motion.solved[i][motion.velocityAt + a]);
	});
}

template <int D>
void MomentumSolver<D>::keepAccount(
        const ActiveRange& range, const SolidMotion<D>& motion, const PoreWater<D>* water, double dt, bool keepWorks, StepLedger<D>& ledger)
{
	for (std::size_t k = 0; k < wallNodes_.size(); ++k) {
		const int i = wallNodes_[k];
		if (!range.holds(i)) continue;
		const WallRecord& w       = walls_[k];
		Vec<D>&           impulse = ledger.ofNode(i).impulse;
		for (int a = 0; a < D; ++a)
			impulse[a] += w.solidMass * motion.solved[i][a] + (water ? w.liquidMass * water->solved[i][a] : 0.0) - w.momentumLeft[a]
			        - dt * w.force[a];
	}
	keepWallWork(range, motion, water, dt, ledger);
	for (const Load& load : loads_) {
		StepAccount<D>& account = ledger.ofNode(load.node);
		for (int a = 0; a < D; ++a) {
			account.impulse[a] += dt * load.force[a];
			account.loadWork += dt * load.force[a] * motion.solved[load.node][motion.velocityAt + a];
		}
	}
	const bool damped = motion.settings->localDamping > 0.0;
	if (!damped && !(keepWorks && water)) return;

	range.overNodes([&](int, int first, int last) {
		StepAccount<D> sum;
		for (int i = first; i < last; ++i)
			for (int a = 0; a < D && ledger.counts(i); ++a) {
				if (damped) {
					if (!isWall_[i]) sum.impulse[a] += dt * damping_[i][a];
					sum.dampingDissipation -= dt * damping_[i][a] * motion.solved[i][motion.velocityAt + a];
				}
				if (keepWorks && water && water->nodal[i][PoreWater<D>::Driving::liquidFraction] > 0.0) {
					const double w = water->flux[i][a] / water->nodal[i][PoreWater<D>::Driving::liquidFraction];
					sum.dragDissipation += dt * water->nodes[i][PoreWater<D>::dragAt] * w * w;
				}
			}
		ledger.ofRows(first) += sum;
	});
}

/// Of the forces that keep nodes on moving walls at the velocity of their wall, and ghosts behind them mirrored.
template <int D>
void MomentumSolver<D>::keepWallWork(const ActiveRange& range, const SolidMotion<D>& motion, const PoreWater<D>* water, double dt, StepLedger<D>& ledger) const
{
	const double keep = 1.0 - motion.kept, keepLiquid = water ? 1.0 - water->kept : 0.0;
	for (const auto& c : constraints_.carried()) {
		if (!range.holds(c.node)) continue;
		const double* r  = motion.nodes[c.node];
		const double* rl = water ? water->nodes[c.node] : nullptr;
		if (!(r[motion.massAt] > 0.0)) continue;
		double impulse = r[motion.massAt] * motion.solved[c.node][c.axis] - keep * r[motion.momentumAt + c.axis] - dt * r[motion.forceAt + c.axis];
		if (rl) impulse += rl[PoreWater<D>::massAt] * water->solved[c.node][c.axis] - keepLiquid * rl[PoreWater<D>::momentumAt + c.axis];
		ledger.ofNode(c.node).wallWork += impulse * motion.solved[c.node][motion.velocityAt + c.axis];
	}
	for (const Folded& f : folded_) {
		const auto& m    = mirrors_[f.mirror];
		double&     work = ledger.ofNode(m.inner).wallWork;
		for (int a = 0; a < D; ++a) {
			const double impulse = f.solidMass * motion.solved[m.ghost][a] + (water ? f.liquidMass * water->solved[m.ghost][a] : 0.0)
			        - f.momentumLeft[a] - dt * f.force[a];
			work += m.added(a, impulse * moving_[m.moving].endOf(a)) + dt * f.pushed[a] * motion.solved[m.inner][motion.velocityAt + a];
		}
	}
}

template <int D>
void MomentumSolver<D>::solve(
        const StepContext<D>& step, SolidMotion<D>& motion, PoreWater<D>* water, ThawFront<D>* front, bool keepWorks, const std::function<void()>& change)
{
	const ActiveRange& range  = step.halo;
	const double       dt     = step.dt;
	StepLedger<D>&     ledger = step.ledger;
	const bool         damped = motion.settings->localDamping > 0.0;
	for (std::size_t k = 0; k < wallNodes_.size(); ++k)
		if (range.holds(wallNodes_[k])) walls_[k] = recordOf(wallNodes_[k], motion, water);
	if (front) {
		front->addGravity(motion.settings->gravity);
		for (const Load& load : loads_)
			front->addLoad(load.node, motion.nodes[load.node][motion.massAt], load.force);
	}
	applySymmetry(range, motion, water, dt);
	pushAhead(motion, water, dt);
	if (water) {
		damped ? solveTwoPhase<true>(range, motion, *water, dt) : solveTwoPhase<false>(range, motion, *water, dt);
		constrainTwoPhase(range, motion, *water, dt);
	} else {
		damped ? solveDry<true>(range, motion, dt) : solveDry<false>(range, motion, dt);
		constrainDry(range, motion);
	}
	if (!moving_.empty()) carry(range, motion, water, dt);
	if (front) front->solve(step, motion, water, constraints_, mirrors_);
	unfold(range, motion, water, dt);
	if (water) findFlux(range, motion, *water);
	change();
	keepAccount(range, motion, water, dt, keepWorks, ledger);
	loads_.clear();
}

template <int D>
void MomentumSolver<D>::addMissing(const ActiveRange& range, SolidMotion<D>& motion, NodeField<D>& missing, const std::function<bool(int)>& takes) const
{
	foldForces(range, missing);
	range.eachNode([&](int i) {
		const double mass = takes(i) ? motion.nodes[i][motion.massAt] : 0.0;
		for (int a = 0; a < D; ++a)
			missing[i][a] = mass > 0.0 && !constraints_.solidFixed(i, a) ? missing[i][a] / mass : 0.0;
	});
	unfoldChanges(range, missing);
	range.eachNode([&](int i) { addTo<D>(motion.solved[i] + motion.velocityAt, vectorAt<D>(missing[i])); });
}

template <int D>
void MomentumSolver<D>::findResponse(const ActiveRange& range, const SolidMotion<D>& motion, const PoreWater<D>& water, double dt, NodeField<D>& response) const
{
	range.eachNode([&](int i) {
		const double ms = motion.nodes[i][motion.massAt];
		for (int a = 0; a < D; ++a)
			response[i][a] = ms > 0.0 ? dt / (ms + water.nodes[i][PoreWater<D>::massAt]) : 0.0;
	});
	for (const int i : constraints_.constrainedNodes())
		for (int a = 0; a < D && range.holds(i); ++a)
			if (constraints_.solidFixed(i, a)) response[i][a] = 0.0;
}

template <int D> void MomentumSolver<D>::foldForces(const ActiveRange& range, NodeField<D>& force, const std::function<void(const Mirror&)>& beforeMoving) const
{
	for (const Mirror& m : mirrors_) {
		if (!range.holds(m.inner)) continue;
		if (beforeMoving && m.moving >= 0) beforeMoving(m);
		// no force reaches a ghost outside of the range, and nothing clears it
		for (int a = 0; a < D && range.holds(m.ghost); ++a) {
			force[m.inner][a] += m.sign[a] * force[m.ghost][a];
			force[m.ghost][a] = 0.0;
		}
	}
	for (const Mirror& m : mirrors_)
		for (int a = 0; a < D && m.lead != 0.0 && range.holds(m.inner); ++a)
			if (m.sign[a] < 0.0) force[m.inner][a] -= m.lead * force[m.wall()][a];
}

template <int D> void MomentumSolver<D>::unfoldChanges(const ActiveRange& range, NodeField<D>& change) const
{
	for (const auto& m : mirrors_)
		for (int a = 0; a < D && m.lead != 0.0 && range.holds(m.inner); ++a)
			if (m.sign[a] < 0.0) change[m.wall()][a] = -m.lead * change[m.inner][a];
	unfoldMirrors(range, change);
	for (const NodeImage& image : images_)
		std::copy_n(change[image.original], D, change[image.node]);
}

template <int D> void MomentumSolver<D>::unfoldMirrors(const ActiveRange& range, NodeField<D>& change) const
{
	for (int k = int(mirrors_.size()) - 1; k >= 0; --k) {
		const auto& m = mirrors_[k];
		for (int a = 0; a < D && range.holds(m.inner) && range.holds(m.ghost); ++a)
			change[m.ghost][a] = m.sign[a] * change[m.inner][a];
	}
}

/// The account of work of moving walls takes the forces of folded_ and those of the solid's nodes on walls.
template <int D> void MomentumSolver<D>::foldMore(const ActiveRange& range, SolidMotion<D>& motion, NodeField<D>& force)
{
	std::size_t next = 0;
	foldForces(range, force, [&](const Mirror& m) {
		for (int a = 0; a < D; ++a)
			folded_[next].force[a] += force[m.ghost][a];
		++next;
	});
	for (Folded& f : folded_)
		for (int a = 0; a < D; ++a)
			if (const Mirror& m = mirrors_[f.mirror]; m.sign[a] < 0.0) f.pushed[a] -= m.lead * force[m.wall()][a];
	for (const auto& c : constraints_.carried())
		if (range.holds(c.node)) motion.nodes[c.node][motion.forceAt + c.axis] += force[c.node][c.axis];
}

template <int D>
void MomentumSolver<D>::correct(
        const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>& water, NodeField<D>& force, NodeField<D>& change, double dt, StepLedger<D>& ledger)
{
	for (const int i : wallNodes_)
		for (int a = 0; a < D && range.holds(i); ++a)
			ledger.ofNode(i).impulse[a] -= dt * force[i][a];
	foldMore(range, motion, force);
	range.eachNode([&](int i) {
		for (int a = 0; a < D; ++a)
			change[i][a] *= force[i][a];
	});
	unfoldChanges(range, change);
	range.eachNode([&](int i) {
		for (int a = 0; a < D; ++a) {
			motion.solved[i][a] += change[i][a];
			motion.solved[i][motion.velocityAt + a] += change[i][a];
			water.solved[i][a] += change[i][a];
		}
	});
}

TALIK_IN_PLANE_AND_SPACE(MomentumSolver);

} // namespace talik
