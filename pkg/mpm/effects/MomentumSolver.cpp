// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/MomentumSolver.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

namespace {
	// A node with hardly any liquid takes the solid's velocity: the quotient would be round-off.
	constexpr double smallestLiquidShare = 1e-9;

	double dampingOf(double coefficient, double force, double velocity)
	{
		return -coefficient * std::abs(force) * static_cast<double>((velocity > 0.0) - (velocity < 0.0));
	}
} // namespace

template <int D>
MomentumSolver<D>::MomentumSolver(const Grid<D>& grid, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries)
        : constraints_(grid)
        , isWall_(grid.nodeCount(), 0)
{
	std::size_t loaded = 0;
	for (const auto& b : boundaries) {
		b->constrainMotion(grid, constraints_);
		if (b->loads()) loaded += grid.nodeCount();
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
	damping_.allocate(grid.nodeCount());
}

template <int D> void MomentumSolver<D>::addGravity(const ActiveRange& range, SolidMotion<D>& motion, const PoreWater<D>* water) const
{
	const Vec<D> b = motion.settings->gravity;
	range.overNodes([&](int, int first, int last) {
		for (int i = first; i < last; ++i) {
			double*      r = motion.nodes[i];
			const double m = r[motion.massAt] + (water ? water->nodes[i][water->massAt] : 0.0);
			for (int a = 0; a < D; ++a)
				r[motion.forceAt + a] += m * b[a];
		}
	});
}

template <int D> void MomentumSolver<D>::addLoad(const Boundary<D>& boundary, const SurfacePatch<D>& patch, double time, SolidMotion<D>& motion)
{
	for (const SurfaceNode<D>& n : patch.nodes) {
		const double area = lengthOf<D>(n.area);
		if (area == 0.0 || motion.nodes[n.node][motion.massAt] <= 0.0) continue;
		Vec<D> normal;
		for (int a = 0; a < D; ++a)
			normal[a] = n.area[a] / area;
		Load load { n.node, boundary.traction(time, normal) };
		for (int a = 0; a < D; ++a) {
			load.force[a] *= area;
			motion.nodes[n.node][motion.forceAt + a] += load.force[a];
		}
		loads_.push_back(load);
	}
}

template <int D> void MomentumSolver<D>::rememberWalls(const SolidMotion<D>& motion, const PoreWater<D>* water)
{
	const double keep = 1.0 - motion.kept, keepLiquid = water ? 1.0 - water->kept : 0.0;
	for (std::size_t k = 0; k < wallNodes_.size(); ++k) {
		const double* r  = motion.nodes[wallNodes_[k]];
		const double* rl = water ? water->nodes[wallNodes_[k]] : nullptr;
		WallRecord&   w  = walls_[k];
		w.solidMass      = r[motion.massAt];
		w.liquidMass     = rl ? rl[0] : 0.0;
		for (int a = 0; a < D; ++a) {
			w.momentumLeft[a] = keep * r[motion.momentumAt + a] + (rl ? keepLiquid * rl[1 + a] : 0.0);
			w.force[a]        = r[motion.forceAt + a];
		}
	}
}

template <int D> void MomentumSolver<D>::fold(SolidMotion<D>& motion, PoreWater<D>* water, double dt) const
{
	using W = PoreWater<D>;
	for (std::size_t k = 0; k < mirrors_.size(); ++k) {
		const auto& m     = mirrors_[k];
		double*     ghost = motion.nodes[m.ghost];
		double*     inner = motion.nodes[m.inner];
		inner[motion.massAt] += ghost[motion.massAt];
		ghost[motion.massAt] = 0.0;
		for (int a = 0; a < D; ++a)
			for (int at : { motion.momentumAt + a, motion.forceAt + a }) {
				inner[at] += m.sign[a] * ghost[at];
				ghost[at] = 0.0;
			}
		if (!water) continue;
		if (!foldLiquid_[k]) {
			foldSolidOnly(m, motion, *water, dt);
			continue;
		}
		double* ghostLiquid = water->nodes[m.ghost];
		double* innerLiquid = water->nodes[m.inner];
		for (int at : { W::massAt, W::dragAt }) {
			innerLiquid[at] += ghostLiquid[at];
			ghostLiquid[at] = 0.0;
		}
		for (int a = 0; a < D; ++a) {
			innerLiquid[W::momentumAt + a] += m.sign[a] * ghostLiquid[W::momentumAt + a];
			ghostLiquid[W::momentumAt + a] = 0.0;
			water->force[m.inner][a] += m.sign[a] * water->force[m.ghost][a];
			water->force[m.ghost][a] = 0.0;
		}
	}
}

template <int D>
void MomentumSolver<D>::foldSolidOnly(const typename MotionConstraints<D>::Mirror& m, SolidMotion<D>& motion, PoreWater<D>& water, double dt) const
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
		const double vs       = m.sign[a] * inner[motion.momentumAt + a] / inner[motion.massAt];
		const double vl       = ghost[W::momentumAt + a] / ml;
		const double residual = water.force[m.ghost][a] - q * (vl - vs);
		inner[motion.forceAt + a] -= m.sign[a] * ml * residual / (ml + dq);
	}
	for (int a = 0; a < D; ++a)
		inner[motion.momentumAt + a] *= scale;
	inner[motion.massAt] += added;
}

template <int D> template <bool Damped> void MomentumSolver<D>::solveDry(const ActiveRange& range, SolidMotion<D>& motion, double dt)
{
	const double chi = motion.kept, alpha = motion.settings->localDamping;
	range.overNodes([&](int, int first, int last) {
		for (int i = first; i < last; ++i) {
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
				const double change = dt * f * inverse;
				out[D + a]          = v + change;
				out[a]              = chi * change + (1.0 - chi) * (v + change);
			}
		}
	});
}

template <int D> template <bool Damped> void MomentumSolver<D>::solveTwoPhase(const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>& water, double dt)
{
	using W          = PoreWater<D>;
	const double chi = motion.kept, chiLiquid = water.kept, alpha = motion.settings->localDamping;
	range.overNodes([&](int, int first, int last) {
		for (int i = first; i < last; ++i) {
			const double* r  = motion.nodes[i];
			const double* rl = water.nodes[i];
			const double  ms = r[motion.massAt], ml = rl[W::massAt];
			const bool    wet = ml > smallestLiquidShare * ms;
			if (!(ms > 0.0)) {
				for (int a = 0; a < D; ++a) {
					motion.solved[i][a] = motion.solved[i][D + a] = water.solved[i][a] = water.flux[i][a] = water.start[i][a] = 0.0;
					if constexpr (Damped) damping_[i][a] = 0.0; // not that of the ground which was here before
				}
				continue;
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
				motion.solved[i][D + a] = vs1;
				motion.solved[i][a]     = chi * dt * acc.solid + (1.0 - chi) * vs1;
				water.solved[i][a]      = chiLiquid * dt * acc.liquid + (1.0 - chiLiquid) * vl1;
				water.flux[i][a]        = vl1;
				water.start[i][a]       = vl;
			}
		}
	});
}

template <int D> void MomentumSolver<D>::constrainDry(SolidMotion<D>& motion) const
{
	const double chi = motion.kept;
	for (int i : constraints_.constrainedNodes()) {
		const double* r = motion.nodes[i];
		if (!(r[motion.massAt] > 0.0)) continue;
		for (int a = 0; a < D; ++a) {
			if (!constraints_.solidFixed(i, a)) continue;
			motion.solved[i][D + a] = 0.0;
			motion.solved[i][a]     = -chi * r[motion.momentumAt + a] / r[motion.massAt];
		}
	}
}

template <int D> void MomentumSolver<D>::constrainLiquid(SolidMotion<D>& motion, PoreWater<D>& water, int i, double dt) const
{
	// the solid's motion is given; its own row of the drag equations then yields the liquid's
	using W           = PoreWater<D>;
	const double  chi = motion.kept, chiLiquid = water.kept;
	const double* r  = motion.nodes[i];
	const double* rl = water.nodes[i];
	const double  dq = dt * rl[W::dragAt];
	if (!(rl[W::massAt] > 0.0)) return;
	for (int a = 0; a < D; ++a) {
		if (!constraints_.solidFixed(i, a) || constraints_.liquidTied(i, a)) continue;
		const double vs     = r[motion.massAt] > 0.0 ? r[motion.momentumAt + a] / r[motion.massAt] : 0.0;
		const double vl     = water.start[i][a];
		const double vs1    = motion.solved[i][D + a];
		const double change = dt * (water.force[i][a] - rl[W::dragAt] * (vl - vs1)) / (rl[W::massAt] + dq);
		water.flux[i][a]    = vl + change;
		water.solved[i][a]  = chiLiquid * change + (1.0 - chiLiquid) * (vl + change);
		motion.solved[i][a] = chi * (vs1 - vs) + (1.0 - chi) * vs1;
	}
}

template <int D> void MomentumSolver<D>::constrainTwoPhase(SolidMotion<D>& motion, PoreWater<D>& water, double dt) const
{
	const double chi = motion.kept, chiLiquid = water.kept;
	for (int i : constraints_.constrainedNodes()) {
		const double* r = motion.nodes[i];
		if (!(r[motion.massAt] > 0.0)) continue;
		for (int a = 0; a < D; ++a) {
			const bool fixed = constraints_.solidFixed(i, a), tied = constraints_.liquidTied(i, a);
			if (!fixed && !tied) continue;
			const double ms = r[motion.massAt], ml = water.nodes[i][water.massAt];
			const double vs = r[motion.momentumAt + a] / ms, vl = water.start[i][a];
			const double common     = fixed ? 0.0 : vs + dt * r[motion.forceAt + a] / (ms + ml);
			motion.solved[i][D + a] = common;
			motion.solved[i][a]     = chi * (common - vs) + (1.0 - chi) * common;
			if (!tied) continue;
			water.flux[i][a]   = common;
			water.solved[i][a] = chiLiquid * (common - vl) + (1.0 - chiLiquid) * common;
		}
		constrainLiquid(motion, water, i, dt);
	}
}

template <int D> void MomentumSolver<D>::unfold(SolidMotion<D>& motion, PoreWater<D>* water, double dt) const
{
	using W = PoreWater<D>;
	for (int k = static_cast<int>(mirrors_.size()) - 1; k >= 0; --k) {
		const auto& m = mirrors_[k];
		for (int a = 0; a < D; ++a)
			for (int at : { a, D + a })
				motion.solved[m.ghost][at] = m.sign[a] * motion.solved[m.inner][at];
		if (!water) continue;
		for (int a = 0; a < D; ++a) {
			if (foldLiquid_[k]) {
				water->solved[m.ghost][a] = m.sign[a] * water->solved[m.inner][a];
				water->flux[m.ghost][a]   = m.sign[a] * water->flux[m.inner][a];
				water->start[m.ghost][a]  = m.sign[a] * water->start[m.inner][a];
				continue;
			}
			const double* rl = water->nodes[m.ghost];
			if (!(rl[W::massAt] > 0.0)) continue;
			const double chiLiquid    = water->kept;
			const double vl           = rl[W::momentumAt + a] / rl[W::massAt];
			const double vs1          = motion.solved[m.ghost][D + a];
			const double change       = dt * (water->force[m.ghost][a] - rl[W::dragAt] * (vl - vs1)) / (rl[W::massAt] + dt * rl[W::dragAt]);
			water->start[m.ghost][a]  = vl;
			water->flux[m.ghost][a]   = vl + change;
			water->solved[m.ghost][a] = chiLiquid * change + (1.0 - chiLiquid) * (vl + change);
		}
	}
}

template <int D> void MomentumSolver<D>::findFlux(const ActiveRange& range, const SolidMotion<D>& motion, PoreWater<D>& water) const
{
	range.overNodes([&](int, int first, int last) {
		for (int i = first; i < last; ++i)
			for (int a = 0; a < D; ++a)
				water.flux[i][a] = water.nodal[i][PoreWater<D>::Driving::liquidFraction] * (water.flux[i][a] - motion.solved[i][D + a]);
	});
}

template <int D>
void MomentumSolver<D>::keepAccount(
        const ActiveRange& range, const SolidMotion<D>& motion, const PoreWater<D>* water, double dt, bool keepWorks, MomentumAccount<D>& account)
{
	for (std::size_t k = 0; k < wallNodes_.size(); ++k) {
		const int         i = wallNodes_[k];
		const WallRecord& w = walls_[k];
		for (int a = 0; a < D; ++a)
			account.impulse[a] += w.solidMass * motion.solved[i][a] + (water ? w.liquidMass * water->solved[i][a] : 0.0) - w.momentumLeft[a]
			        - dt * w.force[a];
	}
	for (const Load& load : loads_)
		for (int a = 0; a < D; ++a) {
			account.impulse[a] += dt * load.force[a];
			account.loadWork += dt * load.force[a] * motion.solved[load.node][D + a];
		}
	const bool damped = motion.settings->localDamping > 0.0;
	if (!damped && !(keepWorks && water)) return;

	constexpr int sums = D + 2;
	partial_.assign(static_cast<std::size_t>(range.chunks()) * sums, 0.0);
	range.overNodes([&](int piece, int first, int last) {
		double* sum = partial_.data() + static_cast<std::size_t>(piece) * sums;
		for (int i = first; i < last; ++i)
			for (int a = 0; a < D; ++a) {
				if (damped) {
					if (!isWall_[i]) sum[a] += dt * damping_[i][a];
					sum[D] -= dt * damping_[i][a] * motion.solved[i][D + a];
				}
				if (keepWorks && water && water->nodal[i][PoreWater<D>::Driving::liquidFraction] > 0.0) {
					const double w = water->flux[i][a] / water->nodal[i][PoreWater<D>::Driving::liquidFraction];
					sum[D + 1] += dt * water->nodes[i][PoreWater<D>::dragAt] * w * w;
				}
			}
	});
	for (int c = 0; c < range.chunks(); ++c) {
		for (int a = 0; a < D; ++a)
			account.impulse[a] += partial_[c * sums + a];
		account.dampingDissipation += partial_[c * sums + D];
		account.dragDissipation += partial_[c * sums + D + 1];
	}
}

template <int D>
void MomentumSolver<D>::solve(
        const ActiveRange& range, SolidMotion<D>& motion, PoreWater<D>* water, ThawFront<D>* front, double dt, bool keepWorks, MomentumAccount<D>& account)
{
	const bool damped = motion.settings->localDamping > 0.0;
	rememberWalls(motion, water);
	if (front) {
		front->addGravity();
		for (const Load& load : loads_)
			front->addLoad(load.node, load.force);
	}
	fold(motion, water, dt);
	if (water) {
		damped ? solveTwoPhase<true>(range, motion, *water, dt) : solveTwoPhase<false>(range, motion, *water, dt);
		constrainTwoPhase(motion, *water, dt);
	} else {
		damped ? solveDry<true>(range, motion, dt) : solveDry<false>(range, motion, dt);
		constrainDry(motion);
	}
	if (front) account.slipWork += front->solve(constraints_, mirrors_, range, dt, account.impulse);
	unfold(motion, water, dt);
	if (water) findFlux(range, motion, *water);
	keepAccount(range, motion, water, dt, keepWorks, account);
	loads_.clear();
}

template class MomentumSolver<2>;
template class MomentumSolver<3>;

} // namespace talik
