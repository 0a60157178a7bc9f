// SPDX-License-Identifier: GPL-2.0-or-later
#include "packedReference.hpp"
#include <algorithm>
#include <cstdio>
#include <Eigen/LU>
#include <gtest/gtest.h>
#include <pkg/rve/packed/PackedSamplePool.hpp>
#include <pkg/rve/packed/PackedWorkspace.hpp>
#include <random>

using namespace talik;
using packedReference::frozen;
using packedReference::matrix;
using packedReference::Matrix;
using packedReference::State;

namespace {

double relative(const Matrix& a, const Matrix& b) { return (a - b).norm() / b.norm(); }

std::shared_ptr<const CompactSample<2>> compact(const State& state) { return std::make_shared<const CompactSample<2>>(state); }

/// Bytes of a state whose parts may stand in another order after an update: all of them count.
std::string bytes(const PackedSample<2>& sample) { return sample.state().toBytes(); }

} // namespace

TEST(PackedSample, rootOfTheIncrementReproducesTheDeformationGradientTo1e12)
{
	for (const Matrix& increment :
	     { matrix(1e-6, 3e-6, -2e-6, 1e-6), matrix(0.01, 0.02, -0.03, -0.01), matrix(-0.3, 0.9, -1.2, 0.4), matrix(-1, -1, 1, -1) })
		for (const long steps : { 1l, 10l, 137l, 5000l }) {
			const Matrix x = Matrix::Identity() + matrixRootIncrement<2>(increment, steps);
			Matrix       f = Matrix::Identity();
			for (long k = 0; k < steps; ++k)
				f = (x * f).eval();
			const double error = (f - Matrix::Identity() - increment).norm();
			std::printf("increment of size %.1e in %ld steps: error %.1e\n", increment.norm(), steps, error);
			EXPECT_LT(error, 1e-12);
		}
	EXPECT_THROW(matrixRootIncrement<2>(matrix(-2, 0, 0, 0), 10), std::invalid_argument);
	EXPECT_THROW(matrixRootIncrement<2>(matrix(-2, 0, 0, -2), 10), std::invalid_argument);
}

TEST(PackedSample, updateReachesTheDeformationGradientTo1e12)
{
	for (const bool follows : { false, true }) {
		PackedSample<2> sample(packedReference::sample().state());
		sample.advance(packedReference::sample().velGrad, 7); // a velocity gradient left in force must not count twice
		PackedUpdateOptions options;
		options.timeStepFollowsIce = follows;
		const Matrix increment     = matrix(2e-4, 3e-4, -1e-4, -4e-4);
		const Matrix wanted        = (Matrix::Identity() + increment) * sample.state().trsf;
		const auto   result        = sample.apply(increment, 0, options);
		const double error         = (sample.state().trsf - wanted).norm();
		std::printf("%ld steps%s, trsf off by %.1e\n", result.steps, follows ? " as long as the sample bears without ice" : "", error);
		EXPECT_LT(error, 1e-12);
		EXPECT_EQ(sample.state().velGrad.norm(), 0);
		EXPECT_EQ(sample.state().dt, packedReference::sample().dt);
		if (follows) EXPECT_LT(result.steps, 41);
		else EXPECT_GE(result.steps, 41);
	}
}

TEST(PackedSample, movingStepsFollowTheInertialNumber)
{
	// eq. (13.1) for t_z = 0.1 m, r = 5 mm, P = 100 kPa, E = 0.6 GPa, I = 1e-3: 1.5e-5 strain per step at c = 0.3
	State state  = packedReference::sample().state();
	auto  grains = std::make_shared<PackedGrains>(*state.grains);
	for (double& r : grains->radius)
		r = 5e-3;
	state.grains      = grains;
	state.stress      = Matrix::Identity() * -1e5;
	const double mass = 2650 * M_PI * 25e-6 * 0.1;
	state.dt          = 0.3 * std::sqrt(mass / (0.6e9 * 5e-3));
	PackedUpdateOptions options;
	options.maxInertialNumber = 1e-3;
	options.maxStrainPerStep  = 1;
	const double perStep      = 1e-3 * 0.3 / 2 * std::sqrt(M_PI * 1e5 * 0.1 / (0.6e9 * 5e-3));
	const long   steps        = movingSteps<2>(state, state.dt, 5e-3, matrix(0, 0.01, 0, 0), options);
	std::printf("strain per step %.3e (closed form %.3e)\n", 0.01 / double(steps), perStep);
	EXPECT_NEAR(perStep, 1.535e-5, 1e-8);
	EXPECT_EQ(steps, long(std::ceil(0.01 / perStep)));
	EXPECT_EQ(movingSteps<2>(state, state.dt, 5e-3, matrix(0, 1e-7, 0, 0), options), 10);
}

TEST(PackedSample, stressTurnsWithTheSampleThroughNinetyDegrees)
{
	for (const bool bonds : { false, true }) {
		PackedSample<2> sample(bonds ? frozen(0.5) : packedReference::sample().state());
		sample.apply(matrix(-3e-4, 2e-4, 1e-4, 3e-4), bonds ? 0.5 : 0.); // deviatoric, so that turning shows
		sample.advance(4000);
		const Matrix        before = sample.stress(), turn = matrix(0, -1, 1, 0);
		PackedUpdateOptions options;
		options.steps    = 1000;
		options.flipSkew = 0;
		sample.apply(turn - Matrix::Identity(), bonds ? 0.5 : 0., options);
		const Matrix expected = turn * before * turn.transpose();
		std::printf(
		        "%s: R sigma R^T off by %.1e after 90 degrees in 1000 steps\n", bonds ? "bonded" : "frictional", relative(sample.stress(), expected));
		EXPECT_LT(relative(sample.stress(), expected), 1e-3);
	}
}

TEST(PackedSample, flippedCellCarriesTheSameSample)
{
	for (const bool bonds : { false, true }) {
		PackedSample<2>     sample(bonds ? frozen(0.3) : packedReference::sample().state());
		PackedUpdateOptions options;
		options.steps    = 4000;
		options.flipSkew = 0;
		sample.apply(matrix(0, 0.6, 0, 0), bonds ? 0.3 : 0., options);
		PackedSample<2> flipped(sample.state());
		ASSERT_TRUE(flipped.flip(0.5));
		EXPECT_NEAR(flipped.state().volume(), sample.state().volume(), 1e-12 * sample.state().volume());
		EXPECT_EQ(flipped.state().trsf, sample.state().trsf);
		EXPECT_FALSE(flipped.flip(0.5));
		sample.advance(1);
		flipped.advance(1);
		const double atOnce = relative(flipped.stress(), sample.stress());
		sample.advance(matrix(0, 0.05, 0, 0), 200);
		flipped.advance(matrix(0, 0.05, 0, 0), 200);
		const double later = relative(flipped.stress(), sample.stress());
		std::printf("%s: stress after the flip off by %.1e, 200 shear steps later by %.1e\n", bonds ? "bonded" : "frictional", atOnce, later);
		EXPECT_LT(atOnce, 1e-10);
		EXPECT_LT(later, 1e-8);
	}
}

TEST(PackedSample, shearsToTwentyThroughFlips)
{
	PackedSample<2>     sample(packedReference::sample().state());
	PackedUpdateOptions options;
	options.maxStrainPerStep  = 1e-4;
	options.maxInertialNumber = 1;
	const double volume       = sample.state().volume();
	const Matrix start        = sample.state().trsf;
	long         steps = 0, flips = 0;
	double       mobilised = 0;
	for (int k = 1; k <= 1000; ++k) {
		const auto result = sample.apply(matrix(0, 0.02, 0, 0), 0, options);
		ASSERT_FALSE(result.blewUp) << result.reason;
		steps += result.steps;
		flips += result.flipped;
		if (k > 500) mobilised += std::fabs(result.stress(0, 1)) / (-0.5 * result.stress.trace()) / 500;
		if (k != 500 && k != 1000) continue;
		const State  s        = sample.state();
		const Matrix shear    = s.trsf * start.inverse();
		int          farthest = 0;
		for (const auto& c : s.contacts.cellDist)
			farthest = std::max({ farthest, std::abs(int(c[0])), std::abs(int(c[1])) });
		std::printf(
		        "gamma %g: %ld steps, %ld flips, trsf_xy %.12g, skew %.2f, largest cell distance %d\n", 0.02 * k, steps, flips, shear(0, 1),
		        s.hSize(0, 1) / s.hSize(0, 0), farthest);
		EXPECT_NEAR(shear(0, 1), 0.02 * k, 1e-9);
		EXPECT_LE(std::fabs(s.hSize(0, 1) / s.hSize(0, 0)), 0.53);
		EXPECT_LE(farthest, 2);
		EXPECT_NEAR(s.volume(), volume, 1e-9 * volume);
	}
	std::printf("mean |sigma_xy|/p over gamma 10..20: %.3f\n", mobilised);
	EXPECT_GE(flips, 19);
	EXPECT_GT(mobilised, 0.1); // a sheared granular sample keeps its friction
	EXPECT_LT(mobilised, 0.6);
}

TEST(PackedSample, withoutContactsTheStressIsExactlyZero)
{
	PackedSample<2>     sample(packedReference::sample().state());
	PackedUpdateOptions options;
	options.maxStrainPerStep  = 1e-4;
	options.maxInertialNumber = 1;
	options.relaxSteps        = 200;
	const auto result         = sample.apply(matrix(0.3, 0, 0, 0.3), 0, options);
	EXPECT_EQ(sample.statistics().contacts, 0u);
	EXPECT_EQ(result.stress, Matrix(Matrix::Zero()));
	EXPECT_FALSE(result.blewUp);
}

TEST(PackedSample, resultsDoNotDependOnSavesLoadsAndWhenListsWereBuilt)
{
	for (const bool portable : { true, false })
		for (const bool bonds : { false, true }) {
			PackedSample<2>::forcePortable(portable);
			const State     start   = bonds ? frozen(0.12) : packedReference::sample().state();
			const Matrix    velGrad = matrix(1.5, 2.5, -2, -1);
			PackedSample<2> through(start), interrupted(start);
			through.advance(velGrad, 1500);
			std::mt19937 random(3);
			for (long done = 0; done < 1500;) {
				const long steps = std::min(1500 - done, 1 + long(random() % 60));
				interrupted.advance(velGrad, steps);
				interrupted.setState(State::fromBytes(bytes(interrupted)));
				done += steps;
			}
			PackedSample<2>::forcePortable(false);
			const State s = through.state();
			std::printf(
			        "%s, %s: 1500 steps through and in pieces, %lu bonds broken in tension and %lu in shear on the way: %s\n", through.path(),
			        bonds ? "bonded" : "frictional", (unsigned long)s.bondsBrokenInTension, (unsigned long)s.bondsBrokenInShear,
			        bytes(through) == bytes(interrupted) ? "bit-equal" : "different");
			EXPECT_TRUE(bytes(through) == bytes(interrupted));
			EXPECT_GE(s.bondsBrokenInTension + s.bondsBrokenInShear, bonds ? 20u : 0u);
		}
}

TEST(PackedSample, bothPathsAgreeThroughBreakage)
{
	const State     start = frozen(0.12);
	PackedSample<2> fast(start);
	PackedSample<2>::forcePortable(true);
	PackedSample<2> portable(start);
	PackedSample<2>::forcePortable(false);
	const Matrix velGrad = matrix(0.8, 0.5, -0.5, -0.6);
	fast.advance(velGrad, 600);
	portable.advance(velGrad, 600);
	const State  a = fast.state(), b = portable.state();
	const double difference = relative(fast.stress(), portable.stress());
	std::printf(
	        "%s against %s, 600 steps, %lu and %lu bonds broken: stress differs by %.1e\n", fast.path(), portable.path(),
	        (unsigned long)(a.bondsBrokenInTension + a.bondsBrokenInShear), (unsigned long)(b.bondsBrokenInTension + b.bondsBrokenInShear), difference);
	EXPECT_GT(a.bondsBrokenInTension + a.bondsBrokenInShear, 5u);
	EXPECT_EQ(a.bondsBrokenInTension, b.bondsBrokenInTension);
	EXPECT_EQ(a.bondsBrokenInShear, b.bondsBrokenInShear);
	EXPECT_LT(difference, 1e-7);
}

// indices are held in as many bits as the number of grains needs
TEST(PackedSample, compactContactsComeBackWhateverTheNumberOfGrains)
{
	for (const std::size_t grains : { 200u, 256u, 257u, 700u, 4000u, 5000u, 65000u }) {
		State s  = frozen(0.2);
		s.grains = std::make_shared<PackedGrains>(PackedGrains { std::vector<double>(grains, 1), std::vector<double>(grains, 1),
		                                                         std::vector<double>(grains, 1), std::vector<std::int32_t>(grains, 0) });
		s.position.resize(grains, State::Vector::Zero());
		s.velocity.resize(grains, State::Vector::Zero());
		s.angularVelocity.resize(grains, 0);
		s.orientation.resize(grains, 0);
		for (std::size_t k = 0; k < s.contacts.size(); ++k) {
			s.contacts.second[k] = std::uint16_t(grains - 1 - k % 3);
			s.contacts.first[k]  = std::uint16_t(k * 7919 % (grains - 4));
		}
		State back;
		CompactSample<2>(s).expand(back);
		EXPECT_TRUE(s.toBytes() == back.toBytes()) << grains << " grains";
	}
	std::printf("contacts of 200 to 65000 grains, made compact and expanded: the same bytes\n");
}

TEST(PackedSample, compactFormIsSmall)
{
	// the reference has 200 grains; the figures are for 400
	const State plain = PackedSample<2>(packedReference::sample().state()).state(), bonded = frozen(0.5);
	const auto  kilobytes = [](const State& s) {
                const double fixed = sizeof(CompactSample<2>);
                return (fixed + (double(CompactSample<2>(s).bytes()) - fixed) * 400 / double(s.size())) / 1000;
	};
	std::printf(
	        "compact form of 400 discs: %.1f kB frictional (%zu contacts), %.1f kB bonded (%zu contacts)\n", kilobytes(plain), plain.contacts.size() * 2,
	        kilobytes(bonded), bonded.contacts.size() * 2);
	EXPECT_LT(kilobytes(plain), 30);
	EXPECT_LT(kilobytes(bonded), 60);
}

TEST(PackedSample, freezingCreatesNoForceAndMeltingReturnsToTheGrains)
{
	PackedSample<2>     sample(packedReference::sample().state());
	PackedUpdateOptions options;
	const Matrix        none = Matrix::Zero();
	sample.advance(Matrix::Zero(), 4000);
	const Matrix before = sample.stress();
	const auto   cold   = sample.apply(none, 1, options);
	const auto   bonds  = sample.statistics();
	std::printf("freezing at rest: stress changes by %.1e, %zu bonds\n", relative(cold.stress, before), bonds.bondsIntact);
	EXPECT_LT(relative(cold.stress, before), 1e-5);
	EXPECT_GT(bonds.bondsIntact, sample.state().size() * 3 / 2);
	const auto warm = sample.apply(none, 0, options);
	std::printf("melting again without motion: stress changes by %.1e\n", relative(warm.stress, before));
	EXPECT_LT(relative(warm.stress, before), 1e-5);
	EXPECT_FALSE(sample.state().bonded());
	EXPECT_EQ(sample.state().bondsMelted, bonds.bondsIntact);
	// ice grown in a deformed sample, loaded and melted: what the ice carried is gone, the grains' share stays
	sample.apply(none, 1, options);
	const Matrix atRest = sample.stress();
	const auto   loaded = sample.apply(matrix(0, 0, 0, -2e-5), 1, options);
	sample.advance(2000);
	const double frozenRise = atRest(1, 1) - sample.stress()(1, 1);
	sample.apply(none, 0.01, options);
	sample.advance(2000);
	const double thawedRise = atRest(1, 1) - sample.stress()(1, 1);
	std::printf("2e-5 of vertical strain: %.0f Pa frozen, %.0f Pa left after thaw (stiffness ratio 6)\n", frozenRise, thawedRise);
	EXPECT_FALSE(loaded.blewUp);
	EXPECT_GT(frozenRise / thawedRise, 4);
	EXPECT_LT(frozenRise / thawedRise, 12);
}

TEST(PackedSample, refreezingBondsOnceAndOnlyThroughItsThreshold)
{
	PackedSample<2> sample(frozen(0.5));
	const auto      formed = sample.state().bondsFormed;
	sample.setIceSaturation(0.03);
	EXPECT_EQ(sample.statistics().bondsIntact, formed) << "above the melt threshold bonds stay";
	sample.setIceSaturation(0.02);
	EXPECT_EQ(sample.statistics().bondsIntact, 0u);
	sample.setIceSaturation(0.04);
	EXPECT_EQ(sample.statistics().bondsIntact, 0u) << "hysteresis";
	sample.setIceSaturation(0.06);
	EXPECT_GT(sample.statistics().bondsIntact, formed * 9 / 10);
	const auto again = sample.statistics().bondsIntact;
	sample.setIceSaturation(0.04);
	sample.setIceSaturation(0.06);
	EXPECT_EQ(sample.statistics().bondsIntact, again);
	EXPECT_EQ(sample.state().bondsFormed, formed + again);
}

TEST(PackedSample, stretchedApartEveryBondBreaksAndNothingIsLeft)
{
	State weak               = frozen(0.1);
	weak.ice.tensileStrength = weak.ice.shearStrength = 1e3;
	weak.ice.iceTensileStrength = weak.ice.iceShearStrength = 0;
	PackedSample<2>     sample(weak);
	const auto          formed = sample.state().bondsFormed;
	PackedUpdateOptions options;
	options.maxStrainPerStep  = 2e-5;
	options.maxInertialNumber = 1;
	for (int k = 0; k < 15; ++k)
		sample.apply(matrix(0.02, 0, 0, 0.02), 0.1, options);
	const State s = sample.state();
	std::printf(
	        "%lu bonds: %lu broken in tension, %lu in shear\n", (unsigned long)formed, (unsigned long)s.bondsBrokenInTension,
	        (unsigned long)s.bondsBrokenInShear);
	EXPECT_EQ(sample.statistics().bondsIntact + s.bondsBrokenInTension + s.bondsBrokenInShear, formed);
	EXPECT_EQ(sample.statistics().bondsIntact, 0u);
	EXPECT_LT(sample.stress().norm(), 2e4);
	EXPECT_GT(s.bondsBrokenInTension, 0u);
}

TEST(PackedSample, servoReachesADepthBand)
{
	PackedSample<2>       sample(packedReference::sample().state());
	PackedServoOptions<2> options;
	options.stress = Eigen::Vector2d(-20e3, -40e3).asDiagonal();
	ASSERT_TRUE(sample.servo(options));
	sample.advance(1000);
	const Matrix s = sample.stress();
	std::printf(
	        "servo to (-20, -40) kPa: %.3f %.3f kPa, shear %.3f kPa, unbalanced %.1e\n", s(0, 0) / 1e3, s(1, 1) / 1e3, s(0, 1) / 1e3,
	        sample.statistics().unbalancedForce);
	EXPECT_NEAR(s(0, 0), -20e3, 80);
	EXPECT_NEAR(s(1, 1), -40e3, 80);
	EXPECT_NEAR(s(0, 1), 0, 80);
	options.stress = Eigen::Vector2d(1e3, -1e3).asDiagonal();
	EXPECT_THROW(sample.servo(options), std::invalid_argument);
}

TEST(PackedSample, tangentBoundsTheElasticAnswer)
{
	PackedSample<2> sample(packedReference::sample().state());
	sample.advance(Matrix::Zero(), 5000);
	const auto   c      = sample.tangent();
	const Matrix before = sample.stress();
	const double strain = -1e-6;
	sample.apply(matrix(0, 0, 0, strain), 0);
	sample.advance(5000);
	const double measured = (sample.stress()(1, 1) - before(1, 1)) / strain;
	std::printf("C_yyyy: %.3g Pa from the contacts, %.3g Pa measured over 1e-6\n", c[15], measured);
	EXPECT_GT(measured, 0.3 * c[15]);
	EXPECT_LT(measured, 1.05 * c[15]);
}

TEST(PackedSample, thawStrainTakesLoadOffTheGrainsAndIsNotUndone)
{
	State state                 = packedReference::sample().state();
	state.thawStrain.thawStrain = 0.004;
	PackedSample<2> sample(state);
	sample.apply(Matrix::Zero(), 0.95);
	sample.advance(4000);
	state = sample.state();
	EXPECT_EQ(state.radiusFactor, 1) << "freezing changes no radius";
	sample.apply(Matrix::Zero(), 0);
	sample.advance(4000);
	const double expected = std::sqrt(1 - 0.004);
	std::printf(
	        "radius factor %.9f (%.9f), mean stress from %.0f to %.0f Pa\n", sample.state().radiusFactor, expected, state.stress.trace() / 2,
	        sample.stress().trace() / 2);
	EXPECT_NEAR(sample.state().radiusFactor, expected, 1e-12);
	EXPECT_GT(sample.stress().trace(), 0.7 * state.stress.trace());
	sample.apply(Matrix::Zero(), 1);
	EXPECT_NEAR(sample.state().radiusFactor, expected, 1e-12);
}

TEST(PackedSample, thawStrainGivenToAFrozenSampleActsFromItsIceSaturation)
{
	State state                 = frozen(0.8);
	state.thawStrain.thawStrain = 0.004;
	PackedSample<2> sample(state);
	sample.setIceSaturation(0.6);
	EXPECT_NEAR(sample.state().radiusFactor, std::sqrt(1 - 0.004 * 0.25), 1e-15);
	PackedSample<2> atOnce(state);
	atOnce.setIceSaturation(0);
	EXPECT_NEAR(atOnce.state().radiusFactor, std::sqrt(1 - 0.004), 1e-15);
}

TEST(PackedSample, blowUpIsContainedAndNamed)
{
	State state = packedReference::sample().state();
	state.dt *= 40; // far beyond the critical time step
	PackedSample<2>     sample(state);
	const std::string   before = bytes(sample);
	PackedUpdateOptions options;
	options.steps     = 3000;
	const auto result = sample.apply(matrix(0, 1e-3, 0, -1e-3), 0, options);
	std::printf("%s\n", result.reason.c_str());
	EXPECT_TRUE(result.blewUp);
	EXPECT_FALSE(result.reason.empty());
	EXPECT_TRUE(bytes(sample) == before);
	EXPECT_THROW(sample.advance(packedReference::sample().velGrad, 5000), std::runtime_error);
	EXPECT_TRUE(bytes(sample) == before);
}

TEST(PackedSample, badStatesAreRefusedByName)
{
	const State good      = packedReference::sample().state();
	const auto  complaint = [](const State& state) {
                try {
                        PackedSample<2> sample(state);
                } catch (const std::invalid_argument& e) {
                        return std::string(e.what());
                }
                return std::string();
	};
	State bad = good;
	bad.dt    = -1;
	EXPECT_NE(complaint(bad).find("dt"), std::string::npos);
	bad = good;
	bad.position.pop_back();
	EXPECT_NE(complaint(bad).find("position"), std::string::npos);
	bad             = good;
	bad.hSize(0, 0) = std::nan("");
	EXPECT_NE(complaint(bad).find("hSize"), std::string::npos);
	bad                    = good;
	bad.contacts.second[0] = 60000;
	EXPECT_NE(complaint(bad).find("contacts"), std::string::npos);
	std::string cut = good.toBytes();
	cut.resize(cut.size() / 2);
	EXPECT_THROW(State::fromBytes(cut), std::runtime_error);
	EXPECT_THROW(State::fromBytes("nonsense"), std::runtime_error);
	PackedSample<2> sample(good);
	EXPECT_THROW(sample.setIceSaturation(1.5), std::invalid_argument);
	EXPECT_THROW(sample.apply(matrix(-2, 0, 0, 0), 0), std::invalid_argument);
}

TEST(SamplePool, resultsAreBitEqualForAnyNumberOfThreads)
{
	const auto    plain = compact(packedReference::sample().state()), ice = compact(frozen(0.2));
	SamplePool<2> one, many;
	for (int k = 0; k < 12; ++k)
		for (SamplePool<2>* pool : { &one, &many })
			pool->add(k % 2 ? ice : plain);
	EXPECT_EQ(one.distinctStates(), 2u);
	PackedUpdateOptions options;
	for (int round = 0; round < 3; ++round) {
		std::vector<PackedRequest<2>> requests;
		for (std::size_t k = 0; k < 12; ++k)
			if (k != 5) requests.push_back({ k, matrix(1e-4 * double(k / 2), 2e-4, 0, -1e-4), k % 2 ? 0.2 - 0.05 * round : 0. });
		const auto a = one.update(requests, options, 1), b = many.update(requests, options, 2);
		for (std::size_t k = 0; k < requests.size(); ++k) {
			EXPECT_EQ(a[k].stress, b[k].stress);
			EXPECT_TRUE(one.state(requests[k].sample).toBytes() == many.state(requests[k].sample).toBytes());
		}
	}
	EXPECT_EQ(one.compact(5), ice) << "never asked: still shared";
	EXPECT_EQ(one.distinctStates(), 12u);
}

TEST(SamplePool, comparedRatesKeepTheFinerStateAndSayHowFarTheCoarserIsFromSlowMotion)
{
	for (const bool follows : { false, true }) {
		const State         start     = packedReference::sample().state();
		const Matrix        increment = matrix(-4e-4, 3e-4, 0, -2e-4);
		PackedUpdateOptions options;
		options.timeStepFollowsIce = follows;
		options.maxInertialNumber  = 1e-2;
		options.maxStrainPerStep   = 1e-4;
		options.minSteps           = 1;
		PackedSample<2> coarse(start), fine(start), slow(start);
		const auto      fast  = coarse.apply(increment, 0, options);
		auto            four  = options;
		four.steps            = 4 * fast.movingSteps;
		const auto    refined = fine.apply(increment, 0, four);
		SamplePool<2> pool;
		pool.add(start);
		options.maxInertialNumber = 1; // the request's own counts
		PackedRequest<2> request { 0, increment, 0. };
		request.inertialNumber = 1e-2;
		request.compareRates   = true;
		const auto result      = pool.update({ request }, options, 1).front();
		EXPECT_EQ(result.stress, refined.stress);
		EXPECT_TRUE(pool.state(0).toBytes() == bytes(fine));
		EXPECT_EQ(result.steps, fast.steps + refined.steps);
		options.steps         = 100 * four.steps;
		const double measured = (fast.stress - slow.apply(increment, 0, options).stress).norm();
		std::printf(
		        "%ld steps%s: estimated error of stress %.0f Pa, measured against 100 times slower motion %.0f Pa\n", fast.steps,
		        follows ? " as long as the sample bears" : "", result.rateError, measured);
		EXPECT_GT(result.rateError, measured / 3);
		EXPECT_LT(result.rateError, measured * 3);
	}
}

TEST(SamplePool, whatItRemembersBetweenUpdatesChangesNoBit)
{
	for (const bool bonds : { false, true }) {
		const State         start = bonds ? frozen(0.1) : packedReference::sample().state();
		SamplePool<2>       pool;
		PackedUpdateOptions options;
		options.maxStrainPerStep  = 1e-4;
		options.maxInertialNumber = 1;
		pool.add(start);
		State alone = start;
		for (int round = 0; round < 60; ++round) {
			const Matrix increment = matrix(1e-3 * std::sin(round), 2e-2, 0, -2e-3 * std::cos(round));
			const double ice       = bonds ? 0.1 - 0.001 * round : 0.;
			pool.update({ { 0, increment, ice } }, options, 1);
			PackedSample<2> fresh(alone);
			fresh.apply(increment, ice, options);
			alone = fresh.state();
			ASSERT_TRUE(pool.state(0).toBytes() == alone.toBytes()) << "round " << round;
		}
		std::printf(
		        "%s: 60 updates to gamma 1.2 in a pool and one by one from saved states: bit-equal, %lu bonds broken\n",
		        bonds ? "bonded" : "frictional", (unsigned long)(alone.bondsBrokenInTension + alone.bondsBrokenInShear));
	}
}

TEST(SamplePool, incrementThatNoSampleCanFollowBlowsUpThatSampleAloneAndImpossibleIceIsRefusedBeforeAnythingHasChanged)
{
	SamplePool<2> pool;
	for (int k = 0; k < 3; ++k)
		pool.add(packedReference::sample().state());
	const auto before = pool.compact(0);
	EXPECT_THROW(pool.update({ { 0, matrix(0, 1e-4, 0, 0), 0. }, { 2, matrix(0, 1e-4, 0, 0), 1.5 } }, {}), std::invalid_argument);
	EXPECT_EQ(pool.compact(0), before);
	const auto last    = pool.compact(2);
	const auto results = pool.update({ { 0, matrix(0, 1e-4, 0, 0), 0. }, { 2, matrix(-2, 0, 0, 0), 0. } }, {});
	EXPECT_FALSE(results[0].blewUp);
	EXPECT_NE(pool.compact(0), before);
	EXPECT_TRUE(results[1].blewUp);
	EXPECT_FALSE(results[1].reason.empty());
	EXPECT_EQ(pool.compact(2), last);
}

TEST(CompactSample, keepsStateAndNeighbourListsToTheLastBit)
{
	for (const bool bonds : { false, true }) {
		PackedWorkspace<2> workspace(false);
		workspace.load(bonds ? frozen(0.1) : packedReference::sample().state());
		workspace.setNextVelGrad(matrix(0.2, 1, 0, -0.4));
		workspace.run(300);
		State          state, stateAgain = frozen(0.2); // not empty: it is reused
		PackedLists<2> lists, listsAgain;
		workspace.store(state, &lists);
		const CompactSample<2> compact(state, &lists);
		ASSERT_TRUE(compact.expand(stateAgain, listsAgain));
		EXPECT_TRUE(stateAgain.toBytes() == state.toBytes());
		EXPECT_EQ(listsAgain.inside, lists.inside);
		EXPECT_EQ(listsAgain.slack, lists.slack);
		EXPECT_EQ(listsAgain.first, lists.first);
		EXPECT_EQ(listsAgain.second, lists.second);
		EXPECT_EQ(listsAgain.cellDist, lists.cellDist);
		EXPECT_EQ(listsAgain.travel, lists.travel);
		std::printf(
		        "%s: %zu bytes with lists of %zu pairs, %zu of them contacts; %zu without lists\n", bonds ? "bonded" : "frictional", compact.bytes(),
		        lists.size(), state.contacts.size(), CompactSample<2>(state).bytes());
		EXPECT_FALSE(CompactSample<2>(state).expand(stateAgain, listsAgain));
		EXPECT_TRUE(stateAgain.toBytes() == state.toBytes());
	}
}

TEST(SamplePool, equalRequestsOnASharedStateAreComputedOnce)
{
	const State   plain  = packedReference::sample().state();
	const auto    shared = compact(plain);
	SamplePool<2> pool;
	for (int k = 0; k < 6; ++k)
		pool.add(shared);
	std::vector<PackedRequest<2>> requests;
	for (std::size_t k = 0; k < 6; ++k)
		requests.push_back({ k, matrix(0, k < 4 ? 1e-4 : 2e-4, 0, 0), 0. });
	const auto results = pool.update(requests, {}, 2);
	EXPECT_EQ(pool.distinctStates(), 2u);
	EXPECT_EQ(results[0].stress, results[3].stress);
	PackedSample<2> alone(plain);
	EXPECT_EQ(alone.apply(matrix(0, 1e-4, 0, 0), 0).stress, results[0].stress);
	EXPECT_THROW(pool.update({ { 0, Matrix::Zero(), 0. }, { 0, Matrix::Zero(), 0. } }, {}), std::invalid_argument);
	EXPECT_THROW(pool.update({ { 6, Matrix::Zero(), 0. } }, {}), std::invalid_argument);
}

TEST(SamplePool, sampleThatBlowsUpKeepsItsStateAndHarmsNoOther)
{
	State wild = packedReference::sample().state();
	wild.dt *= 40;
	SamplePool<2> pool;
	pool.add(packedReference::sample().state());
	pool.add(wild);
	PackedUpdateOptions options;
	options.steps      = 3000;
	const auto results = pool.update({ { 0, matrix(0, 1e-3, 0, 0), 0. }, { 1, matrix(0, 1e-3, 0, 0), 0. } }, options, 2);
	EXPECT_FALSE(results[0].blewUp);
	EXPECT_TRUE(results[1].blewUp);
	EXPECT_TRUE(pool.state(1).toBytes() == wild.toBytes());
}
