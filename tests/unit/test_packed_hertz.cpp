// SPDX-License-Identifier: GPL-2.0-or-later
// Grains of Hertz and Mindlin in packed samples, against closed forms; against stock YADE see tests/yade/test_hertz.py.
#include "packedPair.hpp"
#include "packedRoundTrip.hpp"
#include "packedStarts.hpp"
#include <gtest/gtest.h>
#include <pkg/rve/packed/PackedWorkspace.hpp>

using namespace talik;
using packedStarts::hertzian;

namespace {

constexpr double young = packedStarts::youngOfGrains, poisson = packedStarts::poissonOfGrains;

/// 4/3 E* sqrt(R*) and 8 G* sqrt(R*) of two equal grains, from the textbook (Johnson, Contact Mechanics, 4.22 and 7.43).
const double ofNormal = 4. / 3. * young / (2 * (1 - poisson * poisson)) * std::sqrt(packedPair::radius / 2);
const double ofShear  = 8 * young / (2 * (1 + poisson)) / (2 * (2 - poisson)) * std::sqrt(packedPair::radius / 2);

template <int Dim> PackedState<Dim> sheared(bool bonded, bool portable, double rollingFriction)
{
	PackedState<Dim> start  = hertzian<Dim>(packedStarts::thawed<Dim>());
	auto             grains = std::make_shared<PackedGrains>(*start.grains);
	if (rollingFriction > 0) {
		grains->rolling = { 1.5, rollingFriction };
		start.contacts.moment.resize(start.contacts.size());
		for (auto& moment : start.contacts.moment)
			clearShear(moment);
	}
	start.grains = grains;
	PackedSample<Dim>::forcePortable(portable);
	PackedSample<Dim> sample(start);
	PackedSample<Dim>::forcePortable(false);
	if (bonded) sample.setIceSaturation(0.3);
	typename PackedTypes<Dim>::Matrix rate = PackedTypes<Dim>::Matrix::Zero();
	rate(0, 0)                             = 0.1;
	rate(0, 1)                             = 0.4;
	rate(1, 1)                             = -0.2;
	sample.advance(rate, 200);
	return sample.state();
}

template <int Dim> void expectBothPathsAgree()
{
	for (const bool bonded : { false, true })
		for (const double rolling : { 0., 0.2 }) {
			const PackedState<Dim> vectors = sheared<Dim>(bonded, false, rolling), portable = sheared<Dim>(bonded, true, rolling);
			const double           error = (vectors.stress - portable.stress).norm() / vectors.stress.norm();
			std::printf(
			        "%d-D, 200 steps %s%s: stress differs by %.1e (1e-10 allowed)\n", Dim, bonded ? "bonded" : "frictional",
			        rolling > 0 ? ", rolling" : "", error);
			EXPECT_LT(error, 1e-10);
			EXPECT_GT(vectors.stress.norm(), 0);
		}
}

} // namespace

TEST(PackedHertz, normalForceOfAPairIsHertzsAndItsShearFollowsMindlinUpToFriction)
{
	const double friction = 0.5, slip = 1e-9;
	for (const double overlap : { 1e-7, 1e-6, 1e-5 }) {
		auto pair           = hertzian<2>(packedPair::make(overlap, 0));
		pair.friction       = friction;
		auto         now    = packedPair::step(pair, overlap, slip);
		const double normal = packedPair::normalForce(now), shear = packedPair::shearForce(now);
		const double hertz = ofNormal * std::pow(overlap, 1.5), mindlin = ofShear * std::sqrt(overlap) * slip;
		std::printf(
		        "overlap %.0e m: F_n %.6e N, 4/3 E* sqrt(R*) u^1.5 is %.6e; s %.6e N, 8 G* sqrt(R* u) du_s is %.6e\n", overlap, normal, hertz, shear,
		        mindlin);
		EXPECT_NEAR(normal / hertz, 1, 1e-9) << "of differences of positions of 10 mm";
		EXPECT_NEAR(shear / mindlin, 1, 1e-6);
		now = packedPair::step(now, overlap, 1e-3);
		EXPECT_NEAR(packedPair::shearForce(now) / (friction * hertz), 1, 1e-9) << "Coulomb's limit";
		EXPECT_EQ(packedPair::normalForce(packedPair::step(now, -1e-9, 0)), 0) << "no force across a gap";
	}
}

TEST(PackedHertz, shearForceOfPartialLoadingFollowsTheOverlapOfEachIncrement)
{
	auto   pair     = hertzian<2>(packedPair::make(1e-6, 0));
	double expected = 0;
	for (int k = 0; k < 40; ++k) {
		const double overlap = 1e-6 * (1 + 0.1 * k), slip = (k < 25 ? 1 : -1) * 2e-9;
		pair = packedPair::step(pair, overlap, slip);
		expected += ofShear * std::sqrt(overlap) * slip;
	}
	std::printf("shear force after loading and unloading %.6e N, sum of 8 G* sqrt(R* u) du_s %.6e N\n", packedPair::shearForce(pair), expected);
	EXPECT_NEAR(packedPair::shearForce(pair) / expected, 1, 1e-6);
}

TEST(PackedHertz, iceOfABondIsALinearSpringBesideTheGrainsAndAloneInTension)
{
	const double saturation = 0.5, phi = 1 - std::pow(1 - saturation * saturation, 2), ice = 3e9 * phi * packedPair::radius;
	for (const double overlap : { 2e-6, -2e-6 }) {
		auto pair             = hertzian<2>(packedPair::bonded(overlap, saturation));
		pair                  = packedPair::step(pair, overlap, 1e-9);
		const double expected = ofNormal * std::pow(std::max(overlap, 0.), 1.5) + ice * overlap;
		const double share    = ice / (1.5 * ofNormal * std::sqrt(std::max(overlap, 0.)) + ice),
		             carried  = pair.contacts.iceShear[0] / pair.contacts.shear[0];
		std::printf(
		        "overlap %+.0e m: F_n %.6e N, expected %.6e; the ice carries %.6f of the shear force, expected %.6f\n", overlap,
		        packedPair::normalForce(pair), expected, carried, share);
		EXPECT_NEAR(packedPair::normalForce(pair) / expected, 1, 1e-9);
		EXPECT_NEAR(carried, share, 1e-9);
		EXPECT_TRUE(packedPair::intact(pair));
	}
}

TEST(PackedHertz, bothPathsAgreeWithAndWithoutBondsAndRolling)
{
	expectBothPathsAgree<2>();
	expectBothPathsAgree<3>();
}

TEST(PackedHertz, samplesComeBackFromBytesAndCompactFormToTheLastBit)
{
	for (const bool bonded : { false, true }) {
		const auto state = sheared<2>(bonded, false, 0.2);
		packedReference::expectKept(state, state.contacts.moment, std::vector<double>(3, state.iceSaturation));
	}
	auto wrong            = hertzian<2>(packedStarts::thawed<2>());
	auto grains           = std::make_shared<PackedGrains>(*wrong.grains);
	grains->hertz.modulus = -1;
	wrong.grains          = grains;
	EXPECT_THROW(wrong.check(), std::invalid_argument);
}

TEST(PackedHertz, tangentIsThatOfTheForcesAtTheOverlapOfNow)
{
	const double    overlap = 1e-6;
	auto            pair    = packedPair::step(hertzian<2>(packedPair::make(overlap, 0)), overlap, 0);
	PackedSample<2> sample(pair);
	const double    length = 2 * packedPair::radius - overlap, wanted = 1.5 * ofNormal * std::sqrt(overlap) * length * length / pair.volume();
	const double    found = sample.tangent()[0];
	std::printf("C_xxxx %.6e Pa, k_n l^2/V with k_n = 2 E* sqrt(R* u) is %.6e Pa\n", found, wanted);
	EXPECT_NEAR(found / wanted, 1, 1e-9);
}

TEST(PackedHertz, timeStepFallsWithTheSixthRootOfThePressure)
{
	auto state = hertzian<3>(packedStarts::thawed<3>());
	state.dt   = 1; // it does not limit
	double steps[2];
	for (int k = 0; k < 2; ++k) {
		state.stress = -PackedState<3>::Matrix::Identity() * (k ? 64e5 : 1e5);
		PackedWorkspace<3> workspace(false);
		workspace.load(state);
		steps[k] = workspace.longestTimeStep(1);
	}
	std::printf("time step %.3e s at 100 kPa, %.4f times as long as at 6.4 MPa; 2 expected\n", steps[0], steps[0] / steps[1]);
	EXPECT_NEAR(steps[0] / steps[1], 2, 1e-9);
}
