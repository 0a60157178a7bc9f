// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/NodeColumns.hpp>
#include <pkg/mpm/grid/NodeLoops.hpp>

#include <vector>

namespace talik {

/// Numbers of the front nodes by slot: what the points of both sides bring, and what the sides give back to them.
template <int D> class FrontRecords {
public:
	using Columns = NodeColumns<D>;
	using Frozen  = typename Columns::Frozen;
	using Thawed  = typename Columns::Thawed;
	using Pores   = typename Columns::Pores;
	using Side    = typename Columns::Side;
	using Slip    = typename Columns::Slip;

	/// Columns of the sums. Momenta contain those of affine velocities: the sides would otherwise hand them to each other in every step.
	static constexpr int massAt = Frozen::mass, momentumAt = Frozen::momentum, liquidMassAt = Frozen::liquidMass, liquidMomentumAt = Frozen::liquidMomentum,
	                     forceAt = Frozen::force, volumeAt = Frozen::volume, areaAt = Frozen::area, thawedVolumeAt = Thawed::at + Thawed::volume,
	                     thawedMassAt = Thawed::at + Thawed::mass, thawedMomentumAt = Thawed::at + Thawed::momentum,
	                     thawedLiquidMassAt = Thawed::at + Thawed::liquidMass, frictionAt = Thawed::at + Thawed::friction,
	                     cohesionAt = Thawed::at + Thawed::cohesion, stressAt = Thawed::at + Thawed::stress, thawedAreaAt = Thawed::at + Thawed::area,
	                     fullMassAt = Pores::at + Pores::fullMass, poreForceAt = Pores::at + Pores::force;
	/// Columns of what a side gets; the frozen side comes first.
	static constexpr int velocityAt = Side::velocity, gainAt = Side::gain, liquidGainAt = Side::liquidGain, sideSize = Side::size;

	/// Friction [-] and cohesion [Pa] of points whose law states no strength: no load overcomes them. A node with a trace of such ground has more than
	/// mostStated of both.
	static constexpr double unlimited = 1e30, mostStated = 1e20;

	struct alignas(64) Sums {
		double number[Pores::at + Pores::size];
	};
	struct alignas(64) Answer {
		double number[Slip::at + Slip::size];
	};
	static constexpr int sumsSize = sizeof(Sums) / sizeof(double), answerSize = sizeof(Answer) / sizeof(double);

	void clear(int count)
	{
		sums_.assign(count, {});
		answers_.assign(count, {});
	}
	double*       sums(int slot) { return sums_[slot].number; }
	const double* sums(int slot) const { return sums_[slot].number; }
	double*       answer(int slot) { return answers_[slot].number; }
	const double* answer(int slot) const { return answers_[slot].number; }
	/// Null where there are none.
	double*       firstSums() { return sums_.empty() ? nullptr : sums_[0].number; }
	const double* firstAnswer() const { return answers_.empty() ? nullptr : answers_[0].number; }

private:
	std::vector<Sums>   sums_;
	std::vector<Answer> answers_;
};

} // namespace talik
