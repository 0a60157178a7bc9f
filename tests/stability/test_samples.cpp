// SPDX-License-Identifier: GPL-2.0-or-later
// Cases 5, 7 and 8 of a sample: long paths, ice that comes and goes, no stress, no contacts, strain rates of an explosion.
#include "packedReference.hpp"
#include "Report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

using namespace talik;
using namespace talik::validation;
using packedReference::frozen;
using packedReference::matrix;
using packedReference::Matrix;
using packedReference::State;

namespace {

double pressureOf(const Matrix& stress) { return -0.5 * stress.trace(); }

bool finite(const State& s)
{
	double sum = s.stress.sum() + s.hSize.sum() + s.trsf.sum();
	for (std::size_t g = 0; g < s.size(); ++g)
		sum += s.position[g].sum() + s.velocity[g].sum() + s.angularVelocity[g];
	return std::isfinite(sum);
}

/// Follows a path of equal increments, each to its share of the steps; true if no update blew up.
bool follow(PackedSample<2>& sample, const Matrix& increment, int updates, double iceSaturation, long steps)
{
	PackedUpdateOptions options;
	options.steps = steps;
	for (int k = 0; k < updates; ++k) {
		const auto result = sample.apply(increment, iceSaturation, options);
		if (result.blewUp) {
			std::printf("update %d: %s\n", k, result.reason.c_str());
			return false;
		}
	}
	return true;
}

} // namespace

TEST(Sample, ShearsToTwentyThroughFlipsWithoutDriftOfVolumeAndWithStressThatStaysOnItsLine)
{
	citing("Coulomb friction bounds the stress ratio");
	for (const double ice : { 0.0, 0.3 }) {
		PackedSample<2> sample(ice > 0.0 ? frozen(ice) : packedReference::sample().state());
		const double    volume = sample.state().volume();
		const Matrix    wanted = matrix(1.0, 20.0, 0.0, 1.0) * sample.state().trsf;
		ASSERT_TRUE(follow(sample, matrix(0.0, 0.02, 0.0, 0.0), 1000, ice, 250));
		const std::string name = std::string(ice > 0.0 ? "bonded" : "frictional") + " sample sheared to 20";
		const Matrix      s    = sample.stress();
		EXPECT_TRUE(finite(sample.state()));
		expectSmall(name + ": deformation gradient less that given", (sample.state().trsf - wanted).norm() / wanted.norm(), 1e-9);
		expectSmall(name + ": change of volume", sample.state().volume() / volume - 1.0, 1e-9);
		const double shear = std::hypot(0.5 * (s(0, 0) - s(1, 1)), 0.5 * (s(0, 1) + s(1, 0)));
		expectSmall(name + ": t/s' at the end", shear / pressureOf(s), 0.8);
		EXPECT_GT(pressureOf(s), 0.0);
	}
}

TEST(Sample, StretchedByHalfAndBackCarriesNothingBetweenAndItsLoadAgain)
{
	PackedSample<2> sample(packedReference::sample().state());
	const double    volume = sample.state().volume(), before = pressureOf(sample.stress());
	const double    root = std::pow(1.5, 0.5 / 50.0) - 1.0;
	ASSERT_TRUE(follow(sample, matrix(root, 0.0, 0.0, root), 50, 0.0, 400));
	PackedUpdateOptions rest;
	rest.relaxSteps = 2000;
	sample.apply(Matrix::Zero(), 0.0, rest);
	expectRelative("sample stretched by half: volume", sample.state().volume() / volume, 1.5, 1e-9);
	expectSmall("sample stretched by half: pressure over that before", pressureOf(sample.stress()) / before, 0.0);
	ASSERT_TRUE(follow(sample, matrix(1.0 / (1.0 + root) - 1.0, 0.0, 0.0, 1.0 / (1.0 + root) - 1.0), 50, 0.0, 400));
	sample.apply(Matrix::Zero(), 0.0, rest);
	EXPECT_TRUE(finite(sample.state()));
	expectRelative("sample stretched by half and back: volume", sample.state().volume() / volume, 1.0, 1e-9);
	// the packing is another one, its density the same
	const double again = pressureOf(sample.stress()) / before;
	std::printf("pressure again %.3f of that before\n", again);
	EXPECT_GE(again, 0.0);
	expectSmall("sample stretched by half and back: pressure over that before", again, 10.0);
}

TEST(Sample, LosesAllItsIceInOneStepWithoutGainingEnergyOrLeavingABond)
{
	citing("energy of the springs");
	PackedSample<2> sample(frozen(1.0));
	ASSERT_TRUE(follow(sample, matrix(2e-4, 0.0, 0.0, -4e-4), 4, 1.0, 100));
	const Matrix before = sample.stress();
	const double young = 3.6e9, stored = 0.5 * before.squaredNorm() / (young * 0.05) * sample.state().volume();
	const auto   bonds = sample.statistics().bondsIntact;
	sample.setIceSaturation(0.0);
	double kinetic = 0.0;
	for (int k = 0; k < 400; ++k) {
		sample.advance(10);
		kinetic = std::max(kinetic, sample.statistics().kineticEnergy);
	}
	const auto after = sample.statistics();
	std::printf(
	        "%zu bonds before, %zu after; pressure %.0f -> %.0f Pa; kinetic energy at most %.3g J\n", bonds, after.bondsIntact, pressureOf(before),
	        pressureOf(sample.stress()), kinetic);
	EXPECT_TRUE(finite(sample.state()));
	EXPECT_GT(bonds, 100u);
	expectSmall("S_i from 1 to 0 at once: bonds left", double(after.bondsIntact), 0.0);
	expectSmall("S_i from 1 to 0 at once: kinetic energy over what the springs can have held", kinetic / stored, 1.0);
	expectSmall("S_i from 1 to 0 at once: kinetic energy at rest again over its largest", after.kineticEnergy / kinetic, 1e-2);
}

TEST(Sample, WithoutContactsHasNoStressAndItsGrainsComeToRest)
{
	PackedSample<2> sample(packedReference::sample().state());
	ASSERT_TRUE(follow(sample, matrix(0.02, 0.01, 0.0, 0.02), 20, 0.0, 20)); // fast, so that grains fly
	PackedUpdateOptions rest;
	rest.relaxSteps     = 1000;
	const double flying = sample.statistics().kineticEnergy;
	sample.apply(Matrix::Zero(), 0.0, rest);
	const double later = sample.statistics().kineticEnergy;
	for (int k = 0; k < 10; ++k)
		sample.apply(Matrix::Zero(), 0.0, rest);
	std::printf("kinetic energy of the grains %.3g, %.3g, %.3g J\n", flying, later, sample.statistics().kineticEnergy);
	EXPECT_TRUE(finite(sample.state()));
	expectSmall("sample torn apart: stress [Pa]", sample.stress().norm(), 0.0);
	// the integrator damps forces, as YADE's does: a grain that flies is braked by impacts alone
	expectSmall("sample torn apart: kinetic energy after 1000 steps over that of the flying grains", later / flying, 1.0);
	expectSmall("sample torn apart: kinetic energy after 11000 steps over that of the flying grains", sample.statistics().kineticEnergy / flying, 0.5);
	// ice that comes back finds no pairs to bond, and takes no harm
	sample.apply(matrix(-1e-3, 0.0, 0.0, -1e-3), 0.8, rest);
	EXPECT_TRUE(finite(sample.state()));
}

TEST(Sample, StrainRatesFarAboveQuasiStaticAreEnduredOrContained)
{
	for (const double strain : { 1e-3, 1e-2, 0.1, 0.3 })
		for (const double ice : { 0.0, 1.0 })
			for (const Matrix& direction : { matrix(0.0, 1.0, 0.0, 0.0), matrix(-1.0, 0.0, 0.0, -1.0), matrix(1.0, 0.0, 0.0, -1.0) }) {
				const State         start = ice > 0.0 ? frozen(ice) : packedReference::sample().state();
				PackedSample<2>     sample(start);
				PackedUpdateOptions options;
				options.steps     = 10;
				const auto result = sample.apply(direction * strain, ice, options);
				EXPECT_TRUE(finite(sample.state()));
				if (result.blewUp) {
					EXPECT_FALSE(result.reason.empty());
					EXPECT_EQ(sample.state().toBytes(), PackedSample<2>(start).state().toBytes()) << "what blew up is not as it was before";
					continue;
				}
				PackedUpdateOptions rest;
				rest.relaxSteps   = 4000;
				const double fast = sample.statistics().kineticEnergy;
				sample.apply(Matrix::Zero(), ice, rest);
				EXPECT_TRUE(finite(sample.state()));
				char name[160];
				std::snprintf(
				        name, sizeof name, "strain %g in ten steps, S_i = %g, direction (%g %g %g): kinetic energy after rest over before",
				        strain, ice, direction(0, 0), direction(0, 1), direction(1, 1));
				expectSmall(name, sample.statistics().kineticEnergy / fast, 1e-2);
			}
}

TEST(Sample, TwentyCyclesOfFreezingUnderLoadWithHealingKeepItsLoadAndCompactByLess)
{
	PackedServoOptions<2> load;
	PackedSample<2>       sample(packedReference::sample().state());
	ASSERT_TRUE(sample.servo(load));
	const double        volume = sample.state().volume();
	PackedUpdateOptions options;
	std::vector<double> strain;
	for (int cycle = 1; cycle <= 20; ++cycle) {
		for (const double ice : { 1.0, 0.0 }) {
			ASSERT_FALSE(sample.apply(Matrix::Zero(), ice, options).blewUp);
			// the load goes on acting on frozen and on thawed grains
			ASSERT_TRUE(sample.servo(load));
			if (ice > 0.0) {
				EXPECT_GT(sample.statistics().bondsIntact, 100u);
			}
		}
		strain.push_back(1.0 - sample.state().volume() / volume);
	}
	std::printf("compaction after 1, 10, 20 cycles: %.3e, %.3e, %.3e\n", strain[0], strain[9], strain[19]);
	const std::string name = "twenty freeze-thaw cycles of a sample under 100 kPa";
	EXPECT_TRUE(finite(sample.state()));
	expectRelative(name + ": pressure at the end [Pa]", pressureOf(sample.stress()), 100e3, 2e-2);
	expectSmall(name + ": bonds left when thawed", double(sample.statistics().bondsIntact), 0.0);
	expectSmall(name + ": compaction in all", strain[19], 5e-3);
	// the ratchet: each thaw releases what the frozen network held and lets a few contacts slide; it must die out, not run on
	expectSmall(
	        name + ": compaction of the last ten over that of the first ten cycles and 1e-5",
	        std::max(0.0, strain[19] - strain[9]) / (std::abs(strain[9]) + 1e-5), 1.5);
}
