// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/front/FrontContact.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <algorithm>
#include <vector>

namespace talik {

/// Walls at the front: a ghost node is folded into its image before the contact, and unfolded after it, side by side, eqs. (8.4) and (8.5).
template <int D> class FrontWalls {
public:
	using Mirrors = typename FrontNodes<D>::Mirrors;

	void applySymmetry(const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, FrontRecords<D>& records)
	{
		folded_.assign(mirrors.size(), {});
		for (std::size_t k = 0; k < mirrors.size(); ++k) {
			const auto& m = mirrors[k];
			if (!folds(nodes, m)) continue;
			double* ghost = records.sums(nodes.slot(m.ghost));
			folded_[k]    = { ghost[R::massAt], ghost[R::thawedMassAt], ghost[R::liquidMassAt], ghost[R::thawedLiquidMassAt] };
			foldNumbers(m, step.dt, ghost, records.sums(nodes.slot(m.inner)));
			std::fill(ghost, ghost + R::sumsSize, 0.0);
		}
	}
	/// The frozen side's part of what walls that have left their nodes push; call after applySymmetry().
	/// Eq. (8.5). The face of frozen ground on the wall is no front.
	void pushAhead(
	        const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, const SolidMotion<D>& motion, FrontRecords<D>& records) const
	{
		for (const auto& m : mirrors) {
			if (!leads(nodes, motion, m)) continue;
			const double* on    = records.sums(nodes.slot(m.wall()));
			double*       inner = records.sums(nodes.slot(m.inner));
			for (int a = 0; a < D; ++a) {
				if (m.sign[a] > 0.0) continue;
				inner[R::forceAt + a] += m.lead * ((on[R::massAt] + on[R::liquidMassAt]) * m.change[a] / step.dt - on[R::forceAt + a]);
				for (const int at : { R::areaAt, R::thawedAreaAt })
					inner[at + a] -= m.lead * on[at + a];
			}
		}
	}
	/// Both sides move with such a wall where it stands; books what the wall gives.
	/// As v_0 of eq. (8.5) has it for the common velocity of both sides.
	void leadWalls(
	        const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, const SolidMotion<D>& motion, const FrontContact<D>& contact,
	        bool liquid, FrontRecords<D>& records) const
	{
		for (const auto& m : mirrors) {
			if (!leads(nodes, motion, m)) continue;
			const double*   on      = records.sums(nodes.slot(m.wall()));
			const double*   inner   = records.answer(nodes.slot(m.inner));
			double*         wall    = records.answer(nodes.slot(m.wall()));
			StepAccount<D>& account = step.ledger.ofNode(m.wall());
			const double    follows = contact.follows(nodes.slot(m.inner));
			const double    mass[2] = { on[R::massAt] + follows * on[R::liquidMassAt], on[R::thawedMassAt] + follows * on[R::thawedLiquidMassAt] };
			for (int side = 0; side < 2; ++side)
				for (int a = 0; a < D; ++a) {
					if (m.sign[a] > 0.0) continue;
					const int    at = side * R::sideSize + a;
					const double v  = -m.lead * inner[at + R::velocityAt];
					wall[at + R::velocityAt] += v;
					wall[at + R::gainAt] += v;
					if (liquid) wall[at + R::liquidGainAt] += follows * v;
					account.impulse[a] += mass[side] * v;
					account.wallWork += mass[side] * v * (m.velocity[a] + m.change[a]);
				}
		}
	}
	/// Answers of the ghosts; books what walls give to the sides apart.
	void unfold(const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, FrontRecords<D>& records) const
	{
		for (std::size_t k = mirrors.size(); k-- > 0;) {
			const auto& m = mirrors[k];
			if (!folds(nodes, m)) continue;
			const std::array<double, 4>& mass    = folded_[k];
			const double*                inner   = records.answer(nodes.slot(m.inner));
			double*                      ghost   = records.answer(nodes.slot(m.ghost));
			StepAccount<D>&              account = step.ledger.ofNode(m.inner);
			for (int a = 0; a < D; ++a) {
				// what the sides gain cancels out on a node and its image together; a wall turns the part of the image round
				const double turned = (m.sign[a] - 1.0)
				        * (mass[0] * inner[R::gainAt + a] + mass[1] * inner[R::sideSize + R::gainAt + a] + mass[2] * inner[R::liquidGainAt + a]
				           + mass[3] * inner[R::sideSize + R::liquidGainAt + a]);
				account.impulse[a] += turned;
				account.wallWork += turned * (m.velocity[a] + m.change[a]);
				for (const int at : { R::velocityAt, R::gainAt, R::liquidGainAt })
					for (const int side : { 0, R::sideSize })
						ghost[side + at + a] = m.sign[a] * inner[side + at + a];
				const int slip = R::Slip::at + R::Slip::velocity + a;
				ghost[slip]    = m.sign[a] * inner[slip];
			}
		}
	}

private:
	using R      = FrontRecords<D>;
	using Mirror = typename Mirrors::value_type;

	/// Both ends of a mirror are front nodes.
	static bool folds(const FrontNodes<D>& nodes, const Mirror& m) { return nodes.slot(m.ghost) >= 0 && nodes.slot(m.inner) >= 0; }

	/// The wall of the mirror has left its nodes, and the sides have velocities of their own in front of it.
	static bool leads(const FrontNodes<D>& nodes, const SolidMotion<D>& motion, const Mirror& m)
	{
		constexpr int mass = SolidMotion<D>::massAt;
		return m.lead != 0.0 && nodes.slot(m.inner) >= 0 && nodes.slot(m.wall()) >= 0 && motion.nodes[m.inner][mass] > 0.0
		        && motion.nodes[m.wall()][mass] > 0.0;
	}

	static void foldNumbers(const Mirror& m, double dt, const double* ghost, double* inner)
	{
		for (const int at : { R::massAt, R::liquidMassAt, R::volumeAt, R::thawedVolumeAt, R::thawedMassAt, R::thawedLiquidMassAt, R::frictionAt,
		                      R::cohesionAt, R::fullMassAt })
			inner[at] += ghost[at];
		for (int a = 0; a < D; ++a) {
			for (const int at : { R::momentumAt, R::liquidMomentumAt, R::thawedMomentumAt, R::forceAt, R::areaAt, R::thawedAreaAt, R::poreForceAt })
				inner[at + a] += m.sign[a] * ghost[at + a];
			inner[R::momentumAt + a] += m.added(a, ghost[R::massAt] * m.velocity[a]);
			inner[R::thawedMomentumAt + a] += m.added(a, ghost[R::thawedMassAt] * m.velocity[a]);
			inner[R::liquidMomentumAt + a] += m.added(a, ghost[R::liquidMassAt] * m.velocity[a]);
			inner[R::forceAt + a] += m.added(a, (ghost[R::massAt] + ghost[R::liquidMassAt]) * m.change[a] / dt);
			for (int b = a; b < D; ++b)
				inner[R::stressAt + stressIndex<D>(a, b)] += m.sign[a] * m.sign[b] * ghost[R::stressAt + stressIndex<D>(a, b)];
		}
	}
	std::vector<std::array<double, 4>> folded_; ///< by mirror: masses that went from a ghost to its image, frozen, thawed, and their liquids [kg]
};

} // namespace talik
