// SPDX-License-Identifier: GPL-2.0-or-later
// Ice bonds that carry moments in packed samples; against stock YADE and in YADE's scenes see tests/yade/test_moments.py.
#include "packedPair.hpp"
#include "packedReference.hpp"
#include "packedRoundTrip.hpp"
#include <gtest/gtest.h>

using namespace talik;
using packedReference::matrix;
using State = PackedState<2>;

namespace {

constexpr BondSection beam { 1.2, 1 };

/// The same sample with bonds that carry moments.
State withMoments(State s, const BondSection& section = beam)
{
	auto grains     = std::make_shared<PackedGrains>(*s.grains);
	grains->section = section;
	s.grains        = grains;
	s.contacts.bondMoment.assign(s.bonded() && section.acts() ? s.contacts.size() : 0, 0.);
	return s;
}

State bent(const BondSection& section = beam, bool rolling = false)
{
	State start = withMoments(packedReference::sample().state(), section);
	if (rolling) {
		auto grains     = std::make_shared<PackedGrains>(*start.grains);
		grains->rolling = { 1.5, 0.2 };
		start.grains    = grains;
		start.contacts.moment.assign(start.contacts.size(), 0.);
	}
	PackedSample<2> sample(start);
	sample.setIceSaturation(0.3);
	sample.advance(matrix(0.1, 0.4, -0.2, -0.1), 300);
	return sample.state();
}

/// The state after two discs have turned against each other, without slip, by an angle in so many steps.
State turned(State s, double angle, long steps, bool portable)
{
	s.angularVelocity = { -0.5 * angle / (double(steps) * s.dt), 0.5 * angle / (double(steps) * s.dt) };
	PackedSample<2>::forcePortable(portable);
	PackedSample<2> sample(s);
	PackedSample<2>::forcePortable(false);
	sample.advance(steps);
	return sample.state();
}

} // namespace

TEST(PackedMoments, momentOfOneBondIsThatOfABeamAndBreaksItAtItsTensileStrengthOnBothPaths)
{
	const State  pair = withMoments(packedPair::bonded(0, 1));
	const double r = packedPair::radius, area = r * r, bondRadius = 1.2 * std::sqrt(area / M_PI), inertia = area * bondRadius * bondRadius / 4;
	const double ice = pair.ice.iceYoung * r, stiffness = ice * bondRadius * bondRadius / 4;
	const double limit = (pair.ice.tensileStrength + pair.ice.iceTensileStrength) * inertia / bondRadius, angle = limit / stiffness;
	for (const bool portable : { false, true }) {
		const double moment = turned(pair, 0.5 * angle, 100, portable).contacts.bondMoment.at(0);
		const State  before = turned(pair, 0.999 * angle, 1000, portable), after = turned(pair, 1.001 * angle, 1000, portable);
		std::printf("%s: moment at half the angle of failure %.6e of %.6e N m\n", portable ? "portable" : "vectors", moment, -0.5 * limit);
		EXPECT_NEAR(moment, -0.5 * limit, 1e-12 * limit) << "it acts against the spin of the second grain";
		EXPECT_TRUE(packedPair::intact(before));
		EXPECT_FALSE(packedPair::intact(after));
		EXPECT_EQ(after.bondsBrokenInTension, 1u);
	}
}

TEST(PackedMoments, bothPathsAgreeWithAndWithoutRolling)
{
	for (const bool rolling : { false, true }) {
		const State vectors = bent(beam, rolling);
		PackedSample<2>::forcePortable(true);
		const State portable = bent(beam, rolling);
		PackedSample<2>::forcePortable(false);
		const double error = (vectors.stress - portable.stress).norm() / vectors.stress.norm();
		std::printf("300 steps%s: stress differs by %.1e\n", rolling ? " of grains that resist rolling" : "", error);
		EXPECT_LT(error, 1e-10);
	}
}

TEST(PackedMoments, samplesComeBackFromBytesAndCompactFormToTheLastBit)
{
	for (const bool rolling : { false, true }) {
		const State state = bent(beam, rolling);
		packedReference::expectKept(state, state.contacts.bondMoment, { 0.3, 0.25, 0., 0.4 });
	}
}

TEST(PackedMoments, takeNoByteOfSamplesWhoseBondsCarryNone)
{
	const State       free = bent({}), carrying = withMoments(free);
	const std::size_t expected = sizeof(double) * free.contacts.size();
	std::printf(
	        "%zu bytes without, %zu with; compact %zu and %zu\n", free.toBytes().size(), carrying.toBytes().size(), CompactSample<2>(free).bytes(),
	        CompactSample<2>(carrying).bytes());
	EXPECT_TRUE(free.contacts.bondMoment.empty());
	EXPECT_EQ(carrying.toBytes().size() - free.toBytes().size(), expected);
}

TEST(PackedMoments, thawTakesThemAndNewIceBeginsWithout)
{
	PackedSample<2> sample(bent());
	sample.setIceSaturation(0);
	EXPECT_TRUE(sample.state().contacts.bondMoment.empty());
	sample.setIceSaturation(0.3);
	const State refrozen = sample.state();
	EXPECT_GT(refrozen.contacts.bondMoment.size(), 0u);
	for (const double moment : refrozen.contacts.bondMoment)
		EXPECT_EQ(moment, 0);
}

TEST(PackedMoments, impossibleSectionsAndCreepAreRefused)
{
	for (const BondSection wrong : { BondSection { -1, 1 }, BondSection { INFINITY, 1 }, BondSection { 1, -0.1 }, BondSection { 1, 1.1 } })
		EXPECT_THROW(withMoments(packedReference::sample().state(), wrong).check(), std::invalid_argument);
	PackedSample<2>     sample(bent());
	PackedUpdateOptions options;
	options.creep = { 1e-9, 3 };
	EXPECT_THROW(sample.apply(matrix(0, 0, 0, 0), 0.3, options), std::invalid_argument);
}
