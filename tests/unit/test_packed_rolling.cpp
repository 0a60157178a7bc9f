// SPDX-License-Identifier: GPL-2.0-or-later
// Resistance of grains to rolling in packed samples; against stock YADE see tests/yade/test_rolling.py.
#include "packedPair.hpp"
#include "packedReference.hpp"
#include "packedRoundTrip.hpp"
#include <gtest/gtest.h>

using namespace talik;
using packedReference::matrix;
using State = PackedState<2>;

namespace {

constexpr PackedRolling rough { 1.5, 0.2 };

/// The same sample of grains that resist rolling, or do so in another way.
State withRolling(State s, const PackedRolling& rolling)
{
	auto grains     = std::make_shared<PackedGrains>(*s.grains);
	grains->rolling = rolling;
	s.grains        = grains;
	s.contacts.moment.assign(rolling.acts() ? s.contacts.size() : 0, 0.);
	return s;
}

State sheared(bool bonded, const PackedRolling& rolling = rough)
{
	PackedSample<2> sample(withRolling(packedReference::sample().state(), rolling));
	if (bonded) sample.setIceSaturation(0.3);
	sample.advance(matrix(0.1, 0.4, -0.2, -0.1), 300);
	return sample.state();
}

double momentAfter(State s, double spin, long steps, bool portable)
{
	s.angularVelocity = { -0.5 * spin, 0.5 * spin };
	PackedSample<2>::forcePortable(portable);
	PackedSample<2> sample(s);
	PackedSample<2>::forcePortable(false);
	sample.advance(steps);
	return sample.state().contacts.moment.at(0);
}

} // namespace

TEST(PackedRolling, momentOfOneContactIsItsStiffnessTimesTheAngleUpToItsShareOfTheNormalForceOnBothPaths)
{
	const double overlap = 1e-5, r = packedPair::radius;
	const State  pair      = withRolling(packedPair::make(overlap, 0), rough);
	const double normal    = pair.ice.young * r * overlap;
	const double stiffness = rough.alphaKr * pair.stiffnessRatio * pair.ice.young * r * r * r, largest = rough.etaRoll * r * normal;
	const double spin = 0.01 * largest / (stiffness * pair.dt);
	for (const bool portable : { false, true }) {
		const double elastic = momentAfter(pair, spin, 50, portable), backwards = momentAfter(pair, -spin, 50, portable);
		const double limited = momentAfter(pair, spin, 200, portable);
		std::printf(
		        "%s: moment %.3e N m, relative error %.1e; limit %.3e N m, relative error %.1e\n", portable ? "portable" : "vectors", elastic,
		        std::fabs(elastic / (-0.5 * largest) - 1), limited, std::fabs(limited / -largest - 1));
		EXPECT_NEAR(elastic, -0.5 * largest, 1e-12 * largest) << "it acts against the spin of the second grain";
		EXPECT_EQ(backwards, -elastic);
		EXPECT_NEAR(limited, -largest, 1e-12 * largest);
	}
}

TEST(PackedRolling, bothPathsAgreeWithAndWithoutBonds)
{
	for (const bool bonded : { false, true }) {
		const State vectors = sheared(bonded);
		PackedSample<2>::forcePortable(true);
		const State portable = sheared(bonded);
		PackedSample<2>::forcePortable(false);
		const double error = (vectors.stress - portable.stress).norm() / vectors.stress.norm();
		std::printf("300 steps %s: stress differs by %.1e\n", bonded ? "bonded" : "frictional", error);
		EXPECT_LT(error, 1e-10);
	}
}

TEST(PackedRolling, samplesComeBackFromBytesAndCompactFormToTheLastBit)
{
	for (const bool bonded : { false, true }) {
		const State state = sheared(bonded);
		packedReference::expectKept(state, state.contacts.moment, std::vector<double>(3, state.iceSaturation));
	}
}

TEST(PackedRolling, takesNoByteOfSamplesWhoseGrainsRollFreely)
{
	const State       free = sheared(true, {}), rolling = withRolling(free, rough);
	const std::size_t expected = sizeof(double) * free.contacts.size();
	std::printf(
	        "%zu bytes without, %zu with; compact %zu and %zu\n", free.toBytes().size(), rolling.toBytes().size(), CompactSample<2>(free).bytes(),
	        CompactSample<2>(rolling).bytes());
	EXPECT_TRUE(free.contacts.moment.empty());
	EXPECT_EQ(rolling.toBytes().size() - free.toBytes().size(), expected);
}

TEST(PackedRolling, impossibleResistanceIsRefusedByName)
{
	for (const PackedRolling wrong : { PackedRolling { -1, 0.2 }, PackedRolling { 1, -0.2 }, PackedRolling { 1, INFINITY }, PackedRolling { NAN, 1 } })
		EXPECT_THROW(withRolling(packedReference::sample().state(), wrong).check(), std::invalid_argument);
	State incomplete = withRolling(packedReference::sample().state(), rough);
	incomplete.contacts.moment.pop_back();
	EXPECT_THROW(incomplete.check(), std::invalid_argument);
}
