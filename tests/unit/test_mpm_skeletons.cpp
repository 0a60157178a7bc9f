// SPDX-License-Identifier: GPL-2.0-or-later
#include "lawElement.hpp"
#include <pkg/mpm/skeleton/CreepingSkeleton.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/MohrCoulombReturn.hpp>
#include <pkg/mpm/skeleton/MohrCoulombSkeleton.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

using namespace talik;

namespace {

constexpr double degree = 0.017453292519943295;

MohrCoulombSkeleton<2> soil(double cohesion, double friction, double dilation = 0.0)
{
	MohrCoulombSkeleton<2> m;
	m.young = m.youngFrozen = 1e7;
	m.cohesion              = cohesion;
	m.cohesionFrozen        = 50.0 * cohesion;
	m.frictionAngle         = friction;
	m.dilationAngle         = dilation;
	m.tensileStrength = m.tensileStrengthFrozen = 1e9;
	return m;
}

double yieldOf(const double* s, double cohesion, double friction)
{
	const double centre = 0.5 * (s[0] + s[1]), radius = std::hypot(0.5 * (s[0] - s[1]), s[3]);
	const double high = std::max(centre + radius, s[2]), low = std::min(centre - radius, s[2]);
	return (high - low) + (high + low) * std::sin(friction * degree) - 2.0 * cohesion * std::cos(friction * degree);
}

} // namespace

TEST(MpmElasticSkeleton, RigidRotationTurnsTheStressExactly)
{
	const double       turn = 90.0 * degree / 50.0;
	Element<2>         plane;
	ElasticSkeleton<2> elastic;
	const double       start[4] = { -100e3, -40e3, -30e3, 15e3 };
	std::copy(start, start + 4, plane.stress);
	plane.gradient[0] = plane.gradient[3] = std::cos(turn) - 1.0;
	plane.gradient[1]                     = -std::sin(turn);
	plane.gradient[2]                     = std::sin(turn);
	for (int k = 0; k < 50; ++k)
		plane.step(elastic);
	double worst = std::max({ std::abs(plane.stress[0] - start[1]), std::abs(plane.stress[1] - start[0]), std::abs(plane.stress[3] + start[3]),
	                          std::abs(plane.stress[2] - start[2]) });

	Element<3>         space;
	ElasticSkeleton<3> elastic3;
	const double       first[6] = { -100e3, -40e3, -30e3, 5e3, -8e3, 15e3 };
	std::copy(first, first + 6, space.stress);
	// about the axis (1,1,1): 120 degrees permute x -> y -> z -> x
	const double angle = 120.0 * degree / 60.0, c = std::cos(angle), s = std::sin(angle), n = 1.0 / std::sqrt(3.0);
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) {
			const double sign         = j == (i + 1) % 3 ? -1.0 : 1.0;
			space.gradient[i * 3 + j] = i == j ? c + (1.0 - c) / 3.0 - 1.0 : (1.0 - c) / 3.0 + sign * s * n;
		}
	for (int k = 0; k < 60; ++k)
		space.step(elastic3);
	const double expected[6] = { first[2], first[0], first[1], first[5], first[3], first[4] };
	for (int i = 0; i < 6; ++i)
		worst = std::max(worst, std::abs(space.stress[i] - expected[i]));
	std::printf("after rotations of 90 and 120 degrees: largest deviation %.1e Pa of 1e5 Pa\n", worst);
	EXPECT_LT(worst, 1e-6);
}

TEST(MpmElasticSkeleton, SmallStrainsFollowHookesLaw)
{
	ElasticSkeleton<2> elastic;
	elastic.young   = 10e6;
	elastic.poisson = 0.25;
	Element<2> e;
	e.gradient[3] = 1e-8;
	e.step(elastic);
	EXPECT_NEAR(e.stress[1] / (12e6 * 1e-8), 1.0, 1e-7); // oedometer modulus E (1-nu)/((1+nu)(1-2nu)) = 1.2 E
	EXPECT_NEAR(e.stress[0] / (4e6 * 1e-8), 1.0, 1e-7);
	EXPECT_NEAR(e.stress[2] / (4e6 * 1e-8), 1.0, 1e-7);
	Element<2> shear;
	shear.gradient[1] = 1e-8;
	shear.step(elastic);
	EXPECT_NEAR(shear.stress[3] / (4e6 * 1e-8), 1.0, 1e-7);
}

TEST(MpmMohrCoulombSkeleton, ActivePressureFailsAtRankinesStress)
{
	// vertical stress held, sides extended: sigma_h = K_a sigma_v - 2 c sqrt(K_a), signs of tension
	const double c = 5e3, phi = 30.0, sigmaV = -100e3;
	auto         m = soil(c, phi);
	Element<2>   e;
	e.stress[0] = e.stress[1] = e.stress[2] = sigmaV;
	for (int k = 0; k < 4000; ++k) {
		e.gradient[0] = 1e-5;
		// servo of the vertical stress by an elastic guess
		e.gradient[3] = (sigmaV - e.stress[1]) / 1.35e7;
		e.step(m);
	}
	const double ka        = (1.0 - std::sin(phi * degree)) / (1.0 + std::sin(phi * degree));
	const double reference = ka * e.stress[1] + 2.0 * c * std::sqrt(ka);
	std::printf("active stress %.2f Pa, Rankine %.2f Pa (vertical %.2f)\n", e.stress[0], reference, e.stress[1]);
	EXPECT_NEAR(e.stress[1] / sigmaV, 1.0, 5e-3) << "servo";
	EXPECT_NEAR(e.stress[0] / reference, 1.0, 1e-9);
}

TEST(MpmMohrCoulombSkeleton, SimpleShearIsBoundedByTheCohesionWithoutFriction)
{
	auto       m = soil(20e3, 0.0);
	Element<2> e;
	e.stress[0] = e.stress[1] = e.stress[2] = -50e3;
	for (int k = 0; k < 2000; ++k) {
		e.gradient[1] = 1e-5;
		e.step(m);
	}
	std::printf("largest shear stress %.3f Pa, cohesion 20000\n", std::hypot(0.5 * (e.stress[0] - e.stress[1]), e.stress[3]));
	EXPECT_NEAR(std::hypot(0.5 * (e.stress[0] - e.stress[1]), e.stress[3]) / 20e3, 1.0, 1e-9);
}

TEST(MpmMohrCoulombSkeleton, AnyTrialStateReturnsToTheSurfaceOnce)
{
	std::mt19937                           random(2);
	std::uniform_real_distribution<double> uniform(-1.0, 1.0);
	double                                 worst = -1e300, again = 0.0, order = 0.0, cut = -1e300;
	for (int k = 0; k < 20000; ++k) {
		MohrCoulombState m;
		m.lambda          = 5e6 * (1.2 + uniform(random));
		m.shear           = 4e6 * (1.2 + uniform(random));
		m.cohesion        = 2e4 * (1.0 + uniform(random));
		const double phi  = 22.0 * (1.0 + uniform(random)) * degree;
		m.sinFriction     = std::sin(phi);
		m.cosFriction     = std::cos(phi);
		m.sinDilation     = std::sin(0.5 * (1.0 + uniform(random)) * phi);
		m.tensileStrength = phi > 0.0 ? std::min(1e5, m.cohesion * m.cosFriction / m.sinFriction) * 0.5 * (1.0 + uniform(random)) : 1e5;
		double s[3];
		for (double& v : s)
			v = 2e5 * uniform(random);
		std::sort(s, s + 3, std::greater<double>());
		returnToMohrCoulomb(m, s);
		const double scale = 2e5;
		worst              = std::max(worst, ((s[0] - s[2]) + (s[0] + s[2]) * m.sinFriction - 2.0 * m.cohesion * m.cosFriction) / scale);
		order              = std::max({ order, (s[1] - s[0]) / scale, (s[2] - s[1]) / scale });
		cut                = std::max(cut, (s[0] - m.tensileStrength) / scale);
		double twice[3]    = { s[0], s[1], s[2] };
		returnToMohrCoulomb(m, twice);
		for (int i = 0; i < 3; ++i)
			again = std::max(again, std::abs(twice[i] - s[i]) / scale);
	}
	std::printf(
	        "20000 random trials: yield function <= %.1e, order violated by %.1e, above cut-off %.1e, second return moves %.1e (of 2e5 Pa)\n", worst, order,
	        cut, again);
	EXPECT_LT(worst, 1e-12);
	EXPECT_LT(order, 1e-12);
	EXPECT_LT(cut, 1e-15);
	EXPECT_LT(again, 1e-12);
}

TEST(MpmMohrCoulombSkeleton, MeltingIceLowersStrengthAndStiffness)
{
	auto m        = soil(1e3, 0.0);
	m.youngFrozen = 1e8;
	Element<2> e;
	e.ice       = 1.0;
	e.stress[1] = -60e3;
	e.step(m);
	EXPECT_NEAR(e.stress[1], -60e3, 1e-9) << "frozen ground (c = 50 kPa) carries 60 kPa";
	// phi(0.5) = 0.4375: c = 1e3 + 49e3 0.4375
	e.ice = 0.5;
	e.step(m);
	EXPECT_LT(yieldOf(e.stress, 1e3 + 49e3 * 0.4375, 0.0), 1e-6);
	e.ice = 0.0;
	e.step(m);
	std::printf("thawed: %.3f kPa stress difference, twice the cohesion is 2 kPa\n", 1e-3 * std::abs(e.stress[0] - e.stress[1]));
	EXPECT_NEAR(yieldOf(e.stress, 1e3, 0.0), 0.0, 1e-6);
	double modulus = 0.0;
	e.ice          = 0.5;
	SkeletonBatch<2> b;
	b.count         = 1;
	b.place         = &e.place;
	b.iceSaturation = &e.ice;
	m.tangentModulus(b, &modulus);
	EXPECT_NEAR(modulus / ((1e7 + 9e7 * 0.4375) * 0.7 / (1.3 * 0.4)), 1.0, 1e-12);
}

namespace {

/// One point of freezing ground, with the fields that the law keeps there.
template <int D> struct FreezingElement : Element<D> {
	MohrCoulombSkeleton<D> law;
	PointFields            fields;
	FreezingElement()
	{
		law.young                 = 1e7;
		law.youngFrozen           = 1e8;
		law.poisson               = 0.25;
		law.cohesion              = 0.0;
		law.cohesionFrozen        = 1e6;
		law.frictionAngle         = 35.0;
		law.tensileStrengthFrozen = 5e5;
		fields.declare("iceSaturation", "freezing", "-", 1);
		law.declareFields(fields, "");
		fields.allocate(1);
	}
	/// Logarithmic strain of all directions [-], in equal steps, at an ice saturation.
	void strain(double e, double saturation, int steps = 1)
	{
		this->ice = saturation;
		for (int k = 0; k < steps; ++k) {
			for (int i = 0; i < D; ++i)
				this->gradient[i * D + i] = std::expm1(e / steps);
			this->step(law);
		}
	}
	/// Mean stress in the plane or in space that a strain of all directions gives [Pa per unit].
	double modulus(double young) const { return young / ((1.0 + law.poisson) * (1.0 - 2.0 * law.poisson)) * (D == 2 ? 1.0 : 1.0 + law.poisson); }
};

template <int D> void expectIceBornAndGoneWithoutStress()
{
	const double       strain = 1e-5;
	FreezingElement<D> loadedFrozen;
	loadedFrozen.strain(0.0, 1.0);
	loadedFrozen.strain(-strain, 1.0);
	EXPECT_NEAR(loadedFrozen.stress[1] / (-loadedFrozen.modulus(1e8) * strain), 1.0, 1e-4);
	loadedFrozen.strain(0.0, 0.5); // phi = 0.4375
	EXPECT_NEAR(loadedFrozen.stress[1] / (-loadedFrozen.modulus(1e7 + 0.4375 * 9e7) * strain), 1.0, 1e-4);
	loadedFrozen.strain(0.0, 1.0);
	EXPECT_NEAR(loadedFrozen.stress[1] / (-loadedFrozen.modulus(1e7 + 0.4375 * 9e7) * strain), 1.0, 1e-4) << "new ice is free of stress";
	loadedFrozen.strain(0.0, 0.0);
	EXPECT_NEAR(loadedFrozen.stress[1] / (-loadedFrozen.modulus(1e7) * strain), 1.0, 1e-4);

	FreezingElement<D> loadedThawed;
	loadedThawed.strain(-strain, 0.0);
	loadedThawed.strain(0.0, 1.0);
	EXPECT_NEAR(loadedThawed.stress[1] / (-loadedThawed.modulus(1e7) * strain), 1.0, 1e-4) << "freezing makes no stress";
	loadedThawed.strain(strain, 1.0);
	EXPECT_NEAR(loadedThawed.stress[1] / (loadedThawed.modulus(9e7) * strain), 1.0, 1e-4) << "the ice holds the grains";
	loadedThawed.strain(0.0, 0.0);
	EXPECT_NEAR(loadedThawed.stress[1] / (loadedThawed.modulus(1e7) * strain), 0.0, 1e-4);
	std::printf(
	        "%d-D: frozen, loaded, thawed: %.2f Pa; loaded, frozen, unloaded, thawed: %.2e Pa; grains alone %.2f Pa\n", D, loadedFrozen.stress[1],
	        loadedThawed.stress[1], -loadedFrozen.modulus(1e7) * strain);
}

template <int D> void expectOpeningToClose()
{
	FreezingElement<D> e;
	const double       strain = 2e-2;
	e.strain(0.0, 1.0);
	e.strain(strain, 1.0, 200);
	EXPECT_NEAR(e.stress[1], 5e5, 1e3) << "frozen ground bears its tensile strength";
	e.strain(0.0, 0.0);
	EXPECT_NEAR(e.stress[1], 0.0, 1e-6) << "thawed ground bears none";
	e.strain(-0.99 * strain, 0.0, 100);
	EXPECT_NEAR(e.stress[1], 0.0, 1e-6) << "grains are still apart";
	e.strain(-3e-4, 0.0, 10);
	std::printf("%d-D: parted by %.1e frozen, thawed and pressed together: %.1f Pa where 1 %% of it closes the rest\n", D, strain, e.stress[1]);
	EXPECT_NEAR(e.stress[1] / (-e.modulus(1e7) * (3e-4 - 0.01 * strain)), 1.0, D == 2 ? 0.02 : 1e-4)
	        << "the memory is of volume; plane strain closes in two directions";
}

} // namespace

TEST(MpmMohrCoulombSkeleton, IceIsBornFreeOfStressAndTakesItsShareAlongWhenItMelts)
{
	expectIceBornAndGoneWithoutStress<2>();
	expectIceBornAndGoneWithoutStress<3>();
}

TEST(MpmMohrCoulombSkeleton, GrainsThatWerePartedWhileFrozenArePressedOnlyWhenTheyHaveComeBack)
{
	expectOpeningToClose<2>();
	expectOpeningToClose<3>();
}

TEST(MpmMohrCoulombSkeleton, GroundThatDoesNotFreezeKeepsNoFieldsOfIce)
{
	MohrCoulombSkeleton<2> law;
	PointFields            dry;
	law.declareFields(dry, "");
	EXPECT_EQ(dry.list().size(), 1u);
}

TEST(MpmMohrCoulombSkeleton, TablesGiveStrengthAndStiffnessOverIceSaturation)
{
	auto m             = soil(1e3, 0.0);
	m.iceSaturations   = { 0.1, 0.5, 0.9 };
	m.youngs           = { 1e7, 3e7, 4e7 };
	m.cohesions        = { 2e3, 10e3, 50e3 };
	m.tensileStrengths = { 0.0, 1e3, 9e3 };
	m.validate();
	const double expected[][3] = {
		{ 0.0, 1e7, 2e3 }, { 0.1, 1e7, 2e3 }, { 0.4, 2.5e7, 8e3 }, { 0.7, 3.5e7, 30e3 }, { 0.9, 4e7, 50e3 }, { 1.0, 4e7, 50e3 }
	};
	for (const auto& [ice, young, cohesion] : expected) {
		Element<2> e;
		e.ice       = ice;
		e.stress[1] = -200e3;
		e.step(m);
		double           modulus = 0.0;
		SkeletonBatch<2> b;
		b.count         = 1;
		b.place         = &e.place;
		b.iceSaturation = &e.ice;
		m.tangentModulus(b, &modulus);
		std::printf("S_i = %.1f: oedometer modulus %.4g Pa, stress difference %.4g Pa\n", ice, modulus, std::abs(e.stress[0] - e.stress[1]));
		EXPECT_NEAR(modulus / (young * 0.7 / (1.3 * 0.4)), 1.0, 1e-12);
		EXPECT_NEAR(yieldOf(e.stress, cohesion, 0.0), 0.0, 1e-6);
	}
	m.cohesions.pop_back();
	EXPECT_THROW(m.validate(), std::invalid_argument);
	m.cohesions = { 2e3, 10e3, -1.0 };
	EXPECT_THROW(m.validate(), std::invalid_argument);
}

TEST(MpmMohrCoulombSkeleton, BadParametersAreNamed)
{
	auto m          = soil(1e3, 30.0);
	m.frictionAngle = 95.0;
	try {
		m.validate();
		FAIL() << "accepted";
	} catch (const std::invalid_argument& e) {
		EXPECT_NE(std::string(e.what()).find("frictionAngle = 95"), std::string::npos);
	}
	m               = soil(1e3, 30.0);
	m.dilationAngle = 31.0;
	EXPECT_THROW(m.validate(), std::invalid_argument);
	ElasticSkeleton<3> elastic;
	elastic.poisson = 0.5;
	EXPECT_THROW(elastic.validate(), std::invalid_argument);
}

namespace {

/// Rate factor of 2e-24 Pa^-3/s, doubled by every kelvin above -10 degC; another exponent keeps the rate at 100 kPa.
template <int D> CreepingSkeleton<D> ice(double exponent)
{
	CreepingSkeleton<D> m;
	m.exponent   = exponent;
	m.rateFactor = [exponent](double temperature) { return 2e-24 * std::pow(1e5, 3.0 - exponent) * std::exp2(temperature + 10.0); };
	return m;
}

double invariant(const double* s)
{
	const double mean = (s[0] + s[1] + s[2]) / 3.0;
	return std::sqrt(0.5 * (std::pow(s[0] - mean, 2) + std::pow(s[1] - mean, 2) + std::pow(s[2] - mean, 2)) + s[3] * s[3]);
}

} // namespace

// dtau/dt = -2 G A tau^n at constant strain; the implicit step is of first order in time
TEST(MpmCreepingSkeleton, StressAtConstantStrainRelaxesByTheClosedFormAndItsMeanStays)
{
	for (const double n : { 1.0, 3.0, 4.0 }) {
		auto         m     = ice<2>(n);
		const double shear = 1e9 / 2.6, rate = m.rateFactor(-5.0), tau0 = 90e3, total = 2.0 / (2.0 * shear * rate * std::pow(tau0, n - 1.0));
		double       error[2], mean = 0.0;
		for (int fine = 0; fine < 2; ++fine) {
			Element<2>   e;
			const int    steps    = fine ? 400 : 200;
			const double start[4] = { -200e3, -100e3, -150e3, std::sqrt(tau0 * tau0 - 50e3 * 50e3) };
			std::copy(start, start + 4, e.stress);
			e.ice         = 1.0;
			e.temperature = -5.0;
			e.time        = total / steps;
			for (int k = 0; k < steps; ++k)
				e.step(m);
			const double flown    = 2.0 * shear * rate * std::pow(tau0, n - 1.0) * total;
			const double expected = tau0 * (n == 1.0 ? std::exp(-flown) : std::pow(1.0 + (n - 1.0) * flown, -1.0 / (n - 1.0)));
			error[fine]           = invariant(e.stress) / expected - 1.0;
			mean                  = (e.stress[0] + e.stress[1] + e.stress[2]) / 3.0;
			EXPECT_NEAR((e.stress[0] - mean) / e.stress[3], -50e3 / start[3], 1e-12) << "direction";
		}
		std::printf("n = %g: %.2e off the closed form in 200 steps, %.2e in 400\n", n, error[0], error[1]);
		EXPECT_LT(std::abs(error[1]), 0.01);
		EXPECT_NEAR(error[0] / error[1], 2.0, 0.05);
		EXPECT_NEAR(mean, -150e3, 1e-6);
	}
}

TEST(MpmCreepingSkeleton, SteadyShearHasTheStressOfGlensLawWhateverTheStep)
{
	for (const double step : { 1e3, 1e6 }) {
		const double rate = 1e-9; // tensor component [1/s]
		auto         m    = ice<2>(3.0);
		auto         m3   = ice<3>(3.0);
		Element<2>   plane;
		Element<3>   space;
		plane.ice = space.ice = 1.0;
		plane.temperature = space.temperature = -3.0;
		plane.time = space.time = step;
		plane.gradient[0]       = rate * step; // pure shear: the axes do not turn
		plane.gradient[3]       = -rate * step / (1.0 + rate * step);
		space.gradient[4]       = plane.gradient[0];
		space.gradient[8]       = plane.gradient[3];
		for (int k = 0; k < int(3e8 / step); ++k) {
			plane.step(m);
			space.step(m3);
		}
		const double expected = std::pow(rate / m.rateFactor(-3.0), 1.0 / 3.0);
		std::printf("steps of %g s: tau %.1f Pa, Glen's law %.1f Pa\n", step, invariant(plane.stress), expected);
		EXPECT_NEAR(0.5 * (plane.stress[0] - plane.stress[1]) / expected, 1.0, 1e-3);
		EXPECT_NEAR(0.5 * (space.stress[1] - space.stress[2]) / expected, 1.0, 1e-3);
	}
}

TEST(MpmCreepingSkeleton, GroundWithoutIceOrTimeIsElasticToTheLastBit)
{
	for (const bool frozen : { false, true }) {
		auto               m = ice<3>(3.0);
		ElasticSkeleton<3> elastic;
		elastic.young = m.young;
		Element<3> creeping, reference;
		for (Element<3>* e : { &creeping, &reference }) {
			for (int c = 0; c < 9; ++c)
				e->gradient[c] = 1e-5 * (c - 3.5);
			e->ice  = frozen ? 1.0 : 0.0;
			e->time = frozen ? 0.0 : 1e9;
		}
		for (int k = 0; k < 20; ++k) {
			creeping.step(m);
			reference.step(elastic);
		}
		for (int c = 0; c < 6; ++c)
			EXPECT_EQ(creeping.stress[c], reference.stress[c]);
	}
}

TEST(MpmCreepingSkeleton, BadParametersAreNamed)
{
	auto m     = ice<2>(3.0);
	m.exponent = 0.5;
	EXPECT_THROW(m.validate(), std::invalid_argument);
	m       = ice<2>(3.0);
	m.young = -1.0;
	EXPECT_THROW(m.validate(), std::invalid_argument);
}
