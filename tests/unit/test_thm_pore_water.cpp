// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/thm/Enthalpy.hpp>
#include <pkg/thm/PoreWaterState.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

using namespace talik;

namespace {

constexpr double porosity = 0.4;

PressureCoefficients coefficientsAt(const PoreWaterState& water, double iceSaturation)
{
	return water.coefficients(MixtureProperties(), { porosity, 1.0 - iceSaturation, 0.0, 0.0 });
}

/// Pressure per unit reference volume as a function of volume ratio, temperature and water mass, for numerical derivatives.
double pressureOf(const PoreWaterState& water, const FreezingCurve& curve, double volumeRatio, double temperature, double waterMass)
{
	const MixtureProperties m;
	const double            poreVolume = volumeRatio - (1.0 - porosity) * m.solid.density / m.densityAt(m.solid, temperature);
	const double            iceMass    = m.densityAt(m.ice, temperature) * (1.0 - curve.liquidSaturation(temperature)) * poreVolume;
	return water.pressure(m, waterMass - iceMass, iceMass, poreVolume, temperature);
}

} // namespace

TEST(PoreWater, SkemptonCoefficientAndUndrainedModulusMatchClosedForms)
{
	struct Case {
		double iceSaturation, modulus, b;
	};
	const PoreWaterState water;
	for (const Case& c : { Case { 0.0, 1e8, 0.9821428571428571 }, Case { 0.0, 1e9, 0.8461538461538461 } }) {
		const auto k = coefficientsAt(water, c.iceSaturation);
		std::printf("S_i %.2f K %.0e: B %.9f, reference %.9f (tolerance 1e-9)\n", c.iceSaturation, c.modulus, skemptonB(k, c.modulus), c.b);
		EXPECT_NEAR(skemptonB(k, c.modulus), c.b, 1e-9);
	}
	// six digits are tabulated for partly frozen ground with ice storage
	EXPECT_NEAR(skemptonB(coefficientsAt(water, 0.5), 1e8), 0.988241, 1e-6);
	EXPECT_NEAR(skemptonB(coefficientsAt(water, 0.95), 1e9), 0.945931, 1e-6);
	EXPECT_NEAR(undrainedModulus(coefficientsAt(water, 0.0), 1e8) / 5.6e9, 1.0, 1e-12);
	PoreWaterState printed;
	printed.massCoefficient = MassCoefficient::printed;
	EXPECT_NEAR(coefficientsAt(printed, 0.2).undrained(), 0.9928, 1e-12);
	EXPECT_NEAR(coefficientsAt(water, 0.2).undrained(), 0.982, 1e-12);
}

TEST(PoreWater, WaveSpeedsMatchTheEigenvaluesOfTheTwoVelocityProblem)
{
	struct Case {
		double liquidSaturation, modulus, bulkModulus;
		bool   iceStorage;
		double largest, undrained;
	};
	const MixtureProperties m;
	for (const Case& c : { Case { 1.0, 1e8, 2.2e9, true, 1862.332347, 1677.519106 }, Case { 1.0, 1e8, 2.2e7, true, 282.9561422, 279.0868095 },
	                       Case { 0.5, 5e8, 2.2e9, true, 2222.883503, 2124.903052 }, Case { 0.05, 1e9, 2.2e9, true, 3088.935979, 3075.122313 },
	                       Case { 0.05, 1e9, 2.2e9, false, 7246.203861, 7207.322349 }, Case { 0.001, 1e9, 2.2e9, false, 50623.15691, 50617.49085 } }) {
		PoreWaterState water;
		water.liquidBulkModulus = c.bulkModulus;
		if (!c.iceStorage) water.iceBulkModulus = std::numeric_limits<double>::infinity();
		const auto n = VolumeFractions::of(porosity, c.liquidSaturation);
		const auto k = coefficientsAt(water, 1.0 - c.liquidSaturation);
		EXPECT_NEAR(largestWaveSpeed(m, n, k, c.modulus) / c.largest, 1.0, 1e-9);
		EXPECT_NEAR(std::sqrt(undrainedModulus(k, c.modulus) / m.density(n)) / c.undrained, 1.0, 1e-9);
	}
	const auto allFrozen = VolumeFractions::of(porosity, 0.0);
	EXPECT_NEAR(largestWaveSpeed(m, allFrozen, coefficientsAt({}, 1.0), 1e9), std::sqrt(1e9 / (0.6 * 2650 + 0.4 * 910)), 1e-9);
}

TEST(PoreWater, CoefficientsAreTheDerivativesOfTheMassForm)
{
	const MixtureProperties m;
	const auto              curve = makeFreezingCurve();
	double                  worst = 0.0;
	for (const bool densityChange : { true, false })
		for (double t : { 2.0, -0.1, -0.3, -0.6, -1.0 }) {
			PoreWaterState water;
			water.cavitationPressure = -1e300;
			water.densityChange      = densityChange;
			const double poreVolume  = 1.0 - (1.0 - porosity) * m.solid.density / m.densityAt(m.solid, t);
			const double iceMass     = m.densityAt(m.ice, t) * (1.0 - curve->liquidSaturation(t)) * poreVolume;
			const double liquidMass  = m.densityAt(m.liquid, t) * (poreVolume - iceMass / water.poreIceDensity(m, t));
			const double mass        = liquidMass + iceMass;
			const auto   k           = water.coefficients(m, { poreVolume, curve->liquidSaturation(t), curve->derivative(t), t });
			const double h           = 1e-6;
			const auto   p           = [&](double j, double temperature) { return pressureOf(water, *curve, j, temperature, mass); };
			const double byStrain    = (p(1.0 + h, t) - p(1.0 - h, t)) / (2.0 * h);
			const double byHeat      = (p(1.0, t + h) - p(1.0, t - h)) / (2.0 * h);
			const double es = -k.undrained() / k.storage / byStrain - 1.0, et = (-k.temperature / k.storage - byHeat) / byHeat;
			worst = std::max({ worst, std::abs(es), std::abs(t > 0.0 || !densityChange ? 0.0 : et) });
			EXPECT_NEAR(es, 0.0, 1e-5);
			// thawed, the closed form leaves out beta^2 T, and without density change only such terms remain in frozen ground
			EXPECT_NEAR(et, 0.0, t > 0.0 || !densityChange ? 2e-3 : 1e-5) << t << " " << densityChange;
		}
	std::printf("largest relative difference of coefficients to central differences %.1e (tolerance 1e-5)\n", worst);
}

TEST(PoreWater, CoefficientsAtMinusThreeTenthsMatchTheTable)
{
	MixtureProperties m;
	m.liquid.expansivity = 2.1e-4;
	const auto   curve   = makeFreezingCurve();
	const double t = -0.3, n = 1.0 - 0.6 * (1.0 + 2.4e-5 * t);
	const auto   k = PoreWaterState().coefficients(m, { n, curve->liquidSaturation(t), curve->derivative(t), t });
	EXPECT_NEAR(k.storage / 1.426550647e-10, 1.0, 1e-8);
	EXPECT_NEAR(k.temperature / 0.05718394636, 1.0, 1e-7);
	EXPECT_NEAR(k.undrained() / 0.9741474057, 1.0, 1e-9);
	EXPECT_NEAR(-k.undrained() / k.storage / -6828691345.0, 1.0, 1e-8);
	EXPECT_NEAR(-k.temperature / k.storage / -400854652.2, 1.0, 1e-7);
}

TEST(PoreWater, InitialMassGivesBackThePressure)
{
	double worst = 0.0;
	for (const bool densityChange : { true, false })
		for (double sl : { 1.0, 0.7, 0.05, 0.0 })
			for (double p0 : { 0.0, 5e3, 2e6 }) {
				PoreWaterState water;
				water.densityChange = densityChange;
				const MixtureProperties m;
				const double            v = 0.37, t = sl < 1.0 ? -2.0 : 3.0;
				const double            mw = water.waterMass(m, p0, sl, v, t);
				// eqs (2.4) and (2.5)
				const double ice = m.densityAt(m.ice, t), liquid = m.densityAt(m.liquid, t), inPores = water.poreIceDensity(m, t);
				const double mi = std::min(
				        ice * (1.0 - sl) * mw / (inPores * (1.0 - sl) + liquid * sl), (1.0 - EnthalpyModel::residualWaterFraction) * mw);
				const auto p = water.pressure(m, mw - mi, mi, v, t);
				worst        = std::max(worst, std::abs(p - p0));
				EXPECT_NEAR(p, p0, 1e-5) << sl << " " << p0; // round-off of a volume of 1e-16 times K_w
			}
	std::printf("largest |p(m_w(p0)) - p0| %.1e Pa (tolerance 1e-5 Pa)\n", worst);
}

TEST(PoreWater, CavitationGapIsRememberedAndHasToCloseBeforePressureReturns)
{
	const MixtureProperties m;
	const PoreWaterState    water;
	const double            v0 = 0.4, mw = water.waterMass(m, 0.0, 1.0, v0, 0.0);
	const auto              opened = water.pressure(m, mw, 0.0, 1.01 * v0, 0.0);
	EXPECT_EQ(opened, 0.0);
	const auto halfClosed = water.pressure(m, mw, 0.0, 1.005 * v0, 0.0);
	EXPECT_EQ(halfClosed, 0.0);
	const auto closed = water.pressure(m, mw, 0.0, 0.999 * v0, 0.0);
	EXPECT_NEAR(closed / (0.001 * 2.2e9), 1.0, 1e-12);
}

// ice fills 1/0.91 of the liquid's volume: 9.89 % expansion squeezed into the same pores
TEST(PoreWater, FreezingInSealedPoresRaisesPressureByTheExpansionOverTheCompliance)
{
	MixtureProperties m;
	m.ice.expansivity = m.liquid.expansivity = 0.0;
	const PoreWaterState water;
	const double         v = 0.4, mw = 1000.0 * v, frozenShare = 0.01;
	const double         mi         = 910.0 * frozenShare * v;
	const double         extra      = mi / 910.0 - mi / 1000.0;
	const double         compliance = (mw - mi) / 1000.0 / 2.2e9 + mi / 910.0 / 8.8e9;
	EXPECT_NEAR(water.pressure(m, mw - mi, mi, v, -1.0) / (extra / compliance), 1.0, 1e-10);
	PoreWaterState without;
	without.densityChange = false;
	EXPECT_NEAR(without.pressure(m, mw - mi, mi, v, -1.0), 0.0, 1e-4);
}

TEST(PoreWater, ImpossibleValuesAreRefused)
{
	PoreWaterState water;
	EXPECT_NO_THROW(water.validate());
	water.liquidBulkModulus = 0.0;
	EXPECT_THROW(water.validate(), std::invalid_argument);
	water                    = {};
	water.cavitationPressure = 1e3;
	EXPECT_THROW(water.validate(), std::invalid_argument);
	EXPECT_THROW(PoreWaterState().waterMass({}, -1.0, 1.0, 0.4, 1.0), std::invalid_argument);
	EXPECT_THROW(PoreWaterState().waterMass({}, 0.0, 1.5, 0.4, 1.0), std::invalid_argument);
	EXPECT_THROW(PoreWaterState().waterMass({}, 0.0, 1.0, 0.0, 1.0), std::invalid_argument);
}
