// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/thm/Enthalpy.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <vector>

using namespace talik;

namespace {

MixtureProperties withoutExpansion()
{
	MixtureProperties m;
	m.solid.expansivity = m.ice.expansivity = m.liquid.expansivity = 0.0;
	return m;
}

/// One cubic metre of soil of porosity 0.4 whose water fills the pores at -5 degC.
SoilContent cubicMetre(double liquidSaturationAtMinusFive)
{
	const double n = 0.4;
	return { (1.0 - n) * 2650.0, n * ((1.0 - liquidSaturationAtMinusFive) * 910.0 + liquidSaturationAtMinusFive * 1000.0), n };
}

FreezingCurvePtr sharpWithoutResidual() { return makeFreezingCurve("sharp", { { "residualSaturation", 0.0 } }); }

std::vector<FreezingCurvePtr> allCurves()
{
	std::vector<FreezingCurvePtr> curves;
	for (const std::string& name : freezingCurveNames())
		curves.push_back(makeFreezingCurve(name));
	curves.push_back(makeFreezingCurve("gauss", { { "freezingTemperature", -0.3 }, { "residualSaturation", 0.0 } }));
	curves.push_back(makeFreezingCurve("linear", { { "frozenTemperature", -1e-6 } }));
	curves.push_back(makeFreezingCurve("sharp", { { "freezingTemperature", 0.4 }, { "residualSaturation", 0.0 } }));
	curves.push_back(makeFreezingCurve(std::vector<CurvePoint> { { -6.0, 0.08 }, { -1.2, 0.2 }, { -0.3, 0.2 }, { -0.08, 0.9 }, { 0.0, 1.0 } }));
	curves.push_back(unfrozenCurve());
	return curves;
}

} // namespace

// Energies by hand from densities 2650/910/1000 kg/m^3, specific heats 800/2060/4200 J/(kg K), L_f = 334 kJ/kg
TEST(Enthalpy, ThawFromMinusFiveToPlusTenTakesTheEnergyOfTheMassBalance)
{
	struct Case {
		FreezingCurvePtr curve;
		double           liquidSaturation, energy;
	};
	const double residual = 0.05 + 0.95 * std::exp(-100.0);
	for (const Case& c :
	     { Case { sharpWithoutResidual(), 1e-3 * 910.0 / (1000.0 * 0.999 + 910.0 * 1e-3), 0.0 }, Case { makeFreezingCurve(), residual, 1.5392254e8 } }) {
		const EnthalpyModel model(withoutExpansion(), c.curve);
		const SoilContent   soil   = cubicMetre(c.liquidSaturation);
		const double        energy = model.enthalpy(soil, 10.0) - model.enthalpy(soil, -5.0);
		const double        mi = model.stateAt(soil, -5.0).iceMass, ml = soil.waterMass - mi;
		const double        byHand = (soil.solidMass * 800.0 + soil.waterMass * 4200.0) * 10.0 + mi * 334e3
		        + 5.0 * (soil.solidMass * 800.0 + mi * 2060.0 + ml * 4200.0);
		std::printf("%s: %.9e J/m^3, by hand %.9e, difference %.1e (tolerance 1e-9)\n", c.curve->name().c_str(), energy, byHand, energy / byHand - 1.0);
		EXPECT_NEAR(energy / byHand, 1.0, 1e-9);
		if (c.energy > 0.0) {
			EXPECT_NEAR(energy / c.energy, 1.0, 1e-9);
		}
	}
}

TEST(Enthalpy, InversionReturnsTheTemperatureForEveryCurve)
{
	double worst = 0.0;
	for (const auto& curve : allCurves()) {
		const EnthalpyModel model({}, curve);
		const SoilContent   soil = cubicMetre(0.05);
		for (double t : { 25.0, 0.5, 1e-6, -1e-6, -0.02, -0.1, -0.25, -0.5, -1.0, -1.5, -5.0, -40.0, -120.0 })
			for (double guess : { t, 3.0, -0.01, -60.0 }) {
				if (curve->isSharp() && t >= curve->freezingTemperature() - 1e-5 && t <= curve->freezingTemperature() + 1e-5) continue;
				const ThermalState state = model.solve(soil, model.enthalpy(soil, t), guess);
				worst                    = std::max(worst, std::abs(state.temperature - t));
				EXPECT_NEAR(state.temperature, t, 1e-10) << curve->name() << " guess " << guess;
				EXPECT_NEAR(state.iceMass, model.stateAt(soil, t).iceMass, 1e-6) << curve->name() << " at " << t;
				EXPECT_NEAR(state.heatCapacity / model.stateAt(soil, t).heatCapacity, 1.0, 1e-9) << curve->name() << " at " << t;
			}
	}
	std::printf("largest |T(H(T)) - T| %.1e K (tolerance 1e-10 K)\n", worst);
}

TEST(Enthalpy, ApparentCapacityIsTheSlopeOfTheEnthalpy)
{
	for (const auto& curve : allCurves()) {
		const EnthalpyModel model({}, curve);
		const SoilContent   soil = cubicMetre(0.2);
		for (double t : { 2.0, -0.05, -0.31, -0.7, -9.0 }) {
			const double h       = 1e-5;
			const double numeric = (model.enthalpy(soil, t + h) - model.enthalpy(soil, t - h)) / (2.0 * h);
			EXPECT_NEAR(model.stateAt(soil, t).apparentCapacity / numeric, 1.0, 1e-6) << curve->name() << " at " << t;
			EXPECT_GT(numeric, 0.0);
		}
	}
}

TEST(Enthalpy, SharpCurveMeltsAtConstantTemperatureInProportionToTheHeat)
{
	{
		const EnthalpyModel model(withoutExpansion(), sharpWithoutResidual());
		const SoilContent   soil   = cubicMetre(0.0);
		const double        frozen = model.enthalpy(soil, -1e-12), thawed = model.enthalpy(soil, 0.0);
		const double        allIce = model.stateAt(soil, -1.0).iceMass;
		for (double fraction : { 0.01, 0.25, 0.5, 0.99 }) {
			const ThermalState state = model.solve(soil, frozen + fraction * (thawed - frozen));
			EXPECT_EQ(state.temperature, 0.0);
			EXPECT_NEAR(state.liquidSaturation, fraction, 1e-9);
			EXPECT_NEAR(state.iceMass, (1.0 - fraction) * allIce, 1e-6);
		}
	}
}

TEST(Enthalpy, SomeWaterStaysLiquidHoweverCold)
{
	const EnthalpyModel model({}, sharpWithoutResidual());
	const SoilContent   soil { 1590.0, 300.0, 0.4 }; // less water than the pores would hold as ice
	EXPECT_DOUBLE_EQ(model.stateAt(soil, -20.0).iceMass, 0.999 * 300.0);
	const ThermalState state = model.solve(soil, model.enthalpy(soil, -20.0), -1.0);
	EXPECT_NEAR(state.temperature, -20.0, 1e-10);
	EXPECT_DOUBLE_EQ(state.iceMass, 0.999 * 300.0);
}

TEST(Enthalpy, BatchGivesTheSameBitsAsSingleCallsAndNamesTheFirstInvalidPoint)
{
	const EnthalpyModel model({}, makeFreezingCurve());
	const SoilContent   soil  = cubicMetre(0.05);
	const std::size_t   count = 5;
	std::vector<double> h, ms(count, soil.solidMass), mw(count, soil.waterMass), v(count, soil.poreVolume), t(count, -0.5), sl(count), mi(count), c(count);
	for (double temperature : { 3.0, -0.1, -0.4, -2.0, -20.0 })
		h.push_back(model.enthalpy(soil, temperature));
	const EnthalpyBatch batch { count, h.data(), ms.data(), mw.data(), v.data(), t.data(), sl.data(), mi.data(), c.data(), nullptr };
	EXPECT_EQ(model.temperatures(batch), count);
	for (std::size_t p = 0; p < count; ++p) {
		const ThermalState one = model.solve(soil, h[p], -0.5);
		EXPECT_EQ(t[p], one.temperature);
		EXPECT_EQ(sl[p], one.liquidSaturation);
		EXPECT_EQ(mi[p], one.iceMass);
		EXPECT_EQ(c[p], one.heatCapacity);
	}
	h[3] = std::numeric_limits<double>::quiet_NaN();
	h[4] = -1e12;
	EXPECT_EQ(model.temperatures(batch), 3u);
	EXPECT_TRUE(std::isnan(t[3]) && std::isnan(t[4]));
	EXPECT_NEAR(t[2], -0.4, 1e-10);
	EXPECT_THROW(model.solve(soil, -1e12), std::runtime_error);
	EXPECT_THROW(model.solve(soil, h[3]), std::runtime_error);
}

TEST(Enthalpy, BadPropertiesAreRefusedByName)
{
	MixtureProperties m;
	m.ice.specificHeat = -1.0;
	try {
		EnthalpyModel model(m, makeFreezingCurve());
		FAIL() << "a negative specific heat was accepted";
	} catch (const std::invalid_argument& error) {
		EXPECT_NE(std::string(error.what()).find("GroundMaterial.iceSpecificHeat = -1"), std::string::npos) << error.what();
	}
}
