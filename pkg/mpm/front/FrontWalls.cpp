// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/front/FrontWalls.hpp>

#include <algorithm>

namespace talik {

namespace {
	template <int D> using R      = FrontRecords<D>;
	template <int D> using Mirror = typename FrontWalls<D>::Mirrors::value_type;

	/// Both ends of a mirror are front nodes.
	template <int D> bool folds(const FrontNodes<D>& nodes, const Mirror<D>& m) { return nodes.slot(m.ghost) >= 0 && nodes.slot(m.inner) >= 0; }

	/// The wall of the mirror has left its nodes, and the sides have velocities of their own in front of it.
	template <int D> bool leads(const FrontNodes<D>& nodes, const SolidMotion<D>& motion, const Mirror<D>& m)
	{
		constexpr int mass = SolidMotion<D>::massAt;
		return m.lead != 0.0 && nodes.slot(m.inner) >= 0 && nodes.slot(m.wall()) >= 0 && motion.nodes[m.inner][mass] > 0.0
		        && motion.nodes[m.wall()][mass] > 0.0;
	}

	template <int D> void foldNumbers(const Mirror<D>& m, double dt, const double* ghost, double* inner)
	{
		for (const int at : { R<D>::massAt, R<D>::liquidMassAt, R<D>::volumeAt, R<D>::thawedVolumeAt, R<D>::thawedMassAt, R<D>::thawedLiquidMassAt,
		                      R<D>::frictionAt, R<D>::cohesionAt, R<D>::fullMassAt })
			inner[at] += ghost[at];
		for (int a = 0; a < D; ++a) {
			for (const int at : { R<D>::momentumAt, R<D>::liquidMomentumAt, R<D>::thawedMomentumAt, R<D>::forceAt, R<D>::areaAt, R<D>::thawedAreaAt,
			                      R<D>::poreForceAt })
				inner[at + a] += m.sign[a] * ghost[at + a];
			inner[R<D>::momentumAt + a] += m.added(a, ghost[R<D>::massAt] * m.velocity[a]);
			inner[R<D>::thawedMomentumAt + a] += m.added(a, ghost[R<D>::thawedMassAt] * m.velocity[a]);
			inner[R<D>::liquidMomentumAt + a] += m.added(a, ghost[R<D>::liquidMassAt] * m.velocity[a]);
			inner[R<D>::forceAt + a] += m.added(a, (ghost[R<D>::massAt] + ghost[R<D>::liquidMassAt]) * m.change[a] / dt);
			for (int b = a; b < D; ++b)
				inner[R<D>::stressAt + stressIndex<D>(a, b)] += m.sign[a] * m.sign[b] * ghost[R<D>::stressAt + stressIndex<D>(a, b)];
		}
	}
} // namespace

template <int D> void FrontWalls<D>::applySymmetry(const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, FrontRecords<D>& records)
{
	folded_.assign(mirrors.size(), {});
	for (std::size_t k = 0; k < mirrors.size(); ++k) {
		const auto& m = mirrors[k];
		if (!folds<D>(nodes, m)) continue;
		double* ghost = records.sums(nodes.slot(m.ghost));
		folded_[k]    = { ghost[R<D>::massAt], ghost[R<D>::thawedMassAt], ghost[R<D>::liquidMassAt], ghost[R<D>::thawedLiquidMassAt] };
		foldNumbers<D>(m, step.dt, ghost, records.sums(nodes.slot(m.inner)));
		std::fill(ghost, ghost + R<D>::sumsSize, 0.0);
	}
}

template <int D> void FrontWalls<D>::unfold(const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, FrontRecords<D>& records) const
{
	for (std::size_t k = mirrors.size(); k-- > 0;) {
		const auto& m = mirrors[k];
		if (!folds<D>(nodes, m)) continue;
		const std::array<double, 4>& mass    = folded_[k];
		const double*                inner   = records.answer(nodes.slot(m.inner));
		double*                      ghost   = records.answer(nodes.slot(m.ghost));
		StepAccount<D>&              account = step.ledger.ofNode(m.inner);
		for (int a = 0; a < D; ++a) {
			// what the sides gain cancels out on a node and its image together; a wall turns the part of the image round
			const double turned = (m.sign[a] - 1.0)
			        * (mass[0] * inner[R<D>::gainAt + a] + mass[1] * inner[R<D>::sideSize + R<D>::gainAt + a]
			           + mass[2] * inner[R<D>::liquidGainAt + a] + mass[3] * inner[R<D>::sideSize + R<D>::liquidGainAt + a]);
			account.impulse[a] += turned;
			account.wallWork += turned * (m.velocity[a] + m.change[a]);
			for (const int at : { R<D>::velocityAt, R<D>::gainAt, R<D>::liquidGainAt })
				for (const int side : { 0, R<D>::sideSize })
					ghost[side + at + a] = m.sign[a] * inner[side + at + a];
			const int slip = R<D>::Slip::at + R<D>::Slip::velocity + a;
			ghost[slip]    = m.sign[a] * inner[slip];
		}
	}
}

/// Eq. (8.5). The face of frozen ground on the wall is no front.
template <int D>
void FrontWalls<D>::pushAhead(
        const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, const SolidMotion<D>& motion, FrontRecords<D>& records) const
{
	for (const auto& m : mirrors) {
		if (!leads<D>(nodes, motion, m)) continue;
		const double* on    = records.sums(nodes.slot(m.wall()));
		double*       inner = records.sums(nodes.slot(m.inner));
		for (int a = 0; a < D; ++a) {
			if (m.sign[a] > 0.0) continue;
			inner[R<D>::forceAt + a] += m.lead * ((on[R<D>::massAt] + on[R<D>::liquidMassAt]) * m.change[a] / step.dt - on[R<D>::forceAt + a]);
			for (const int at : { R<D>::areaAt, R<D>::thawedAreaAt })
				inner[at + a] -= m.lead * on[at + a];
		}
	}
}

/// As v_0 of eq. (8.5) has it for the common velocity of both sides.
template <int D>
void FrontWalls<D>::leadWalls(
        const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, const SolidMotion<D>& motion, const FrontContact<D>& contact,
        bool liquid, FrontRecords<D>& records) const
{
	for (const auto& m : mirrors) {
		if (!leads<D>(nodes, motion, m)) continue;
		const double*   on      = records.sums(nodes.slot(m.wall()));
		const double*   inner   = records.answer(nodes.slot(m.inner));
		double*         wall    = records.answer(nodes.slot(m.wall()));
		StepAccount<D>& account = step.ledger.ofNode(m.wall());
		const double    follows = contact.follows(nodes.slot(m.inner));
		const double mass[2] = { on[R<D>::massAt] + follows * on[R<D>::liquidMassAt], on[R<D>::thawedMassAt] + follows * on[R<D>::thawedLiquidMassAt] };
		for (int side = 0; side < 2; ++side)
			for (int a = 0; a < D; ++a) {
				if (m.sign[a] > 0.0) continue;
				const int    at = side * R<D>::sideSize + a;
				const double v  = -m.lead * inner[at + R<D>::velocityAt];
				wall[at + R<D>::velocityAt] += v;
				wall[at + R<D>::gainAt] += v;
				if (liquid) wall[at + R<D>::liquidGainAt] += follows * v;
				account.impulse[a] += mass[side] * v;
				account.wallWork += mass[side] * v * (m.velocity[a] + m.change[a]);
			}
	}
}

TALIK_IN_PLANE_AND_SPACE(FrontWalls);

} // namespace talik
