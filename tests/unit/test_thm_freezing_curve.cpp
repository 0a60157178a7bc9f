// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/thm/FreezingCurve.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

using namespace talik;

namespace {

/// Values of the formulas in the literature, evaluated once with independent Python code (residual saturation 0.05; van
/// Genuchten without residual, P_0 = 0.1 MPa, lambda = 0.4; power D = 1 K, a = 5; linear on [-1, 0] degC; W = 0.5 K).
struct Reference {
	const char* curve;
	double      temperature, saturation, derivative;
};
constexpr Reference references[] = {
	{ "vanGenuchten", -0.02, 0.9690635676, 2.44070427 },
	{ "vanGenuchten", -0.1, 0.7301459898, 2.650732035 },
	{ "vanGenuchten", -0.5, 0.3112966383, 0.3929807152 },
	{ "vanGenuchten", -5.0, 0.06816284238, 0.009161723434 },
	{ "gauss", -0.02, 0.9984812154, 0.1517569945 },
	{ "gauss", -0.25, 0.7898607439, 1.479721488 },
	{ "gauss", -0.5, 0.3994854691, 1.397941876 },
	{ "gauss", -1.5, 0.05011723931, 0.001406871767 },
	{ "exponential", -0.1, 0.8277942154, 1.555588431 },
	{ "exponential", -1.5, 0.09729771495, 0.0945954299 },
	{ "power", -0.25, 0.361296, 1.245184 },
	{ "power", -5.0, 0.05012217078, 0.0001018089849 },
	{ "linear", -0.25, 0.7625, 0.95 },
	{ "linear", -1.5, 0.05, 0.0 },
};

CurveParameters referenceParameters(const std::string& curve)
{
	return curve == "vanGenuchten" ? CurveParameters { { "residualSaturation", 0.0 } } : CurveParameters {};
}

double simpson(const FreezingCurve& curve, double from, double to, int intervals)
{
	const double step = (to - from) / intervals;
	double       sum  = 0.0;
	for (int k = 0; k < intervals; ++k) {
		const double a = from + k * step;
		sum += curve.liquidSaturation(a) + 4.0 * curve.liquidSaturation(a + 0.5 * step) + curve.liquidSaturation(a + step);
	}
	return sum * step / 6.0;
}

} // namespace

TEST(FreezingCurve, EveryCurveReproducesTabulatedSaturationAndSlope)
{
	double worst = 0.0;
	for (const Reference& r : references) {
		const auto   curve = makeFreezingCurve(r.curve, referenceParameters(r.curve));
		const double es    = std::abs(curve->liquidSaturation(r.temperature) / r.saturation - 1.0);
		const double ed    = r.derivative == 0.0 ? std::abs(curve->derivative(r.temperature))
		                                         : std::abs(curve->derivative(r.temperature) / r.derivative - 1.0);
		EXPECT_LT(es, 1e-9) << r.curve << " at " << r.temperature; // the table has ten digits
		EXPECT_LT(ed, 1e-9) << r.curve << " at " << r.temperature;
		worst = std::max({ worst, es, ed });
	}
	std::printf("largest relative difference to the table %.1e (tolerance 1e-9, table of ten digits)\n", worst);
}

TEST(FreezingCurve, GaussAndPowerReproduceClosedFormsToRoundOff)
{
	const auto gauss = makeFreezingCurve("gauss");
	const auto power = makeFreezingCurve("power");
	EXPECT_NEAR(gauss->liquidSaturation(-0.25), 0.05 + 0.95 * std::exp(-0.25), 1e-15);
	EXPECT_NEAR(gauss->derivative(-0.25), 0.95 * 2.0 * std::exp(-0.25), 1e-14);
	EXPECT_NEAR(power->liquidSaturation(-0.25), 0.05 + 0.95 * std::pow(0.8, 5), 1e-15);
	EXPECT_NEAR(power->derivative(-0.25), 0.95 * 5.0 * std::pow(0.8, 6), 1e-14);
}

TEST(FreezingCurve, DefaultIsGaussOfHalfKelvinWithFivePercentResidual)
{
	const auto curve = makeFreezingCurve();
	EXPECT_EQ(curve->name(), "gauss");
	EXPECT_EQ(curve->parameters().at("width"), 0.5);
	EXPECT_EQ(curve->residualSaturation(), 0.05);
	EXPECT_EQ(curve->freezingTemperature(), 0.0);
}

TEST(FreezingCurve, SlopeIsTheNumericalDerivativeOfEveryCurve)
{
	double worst = 0.0;
	for (const std::string& name : freezingCurveNames()) {
		const auto curve = makeFreezingCurve(name, { { "freezingTemperature", -0.1 } });
		for (double t : { 0.3, -0.13, -0.2, -0.35, -0.7, -2.0, -7.0 }) {
			const double h       = 1e-5;
			const double numeric = (curve->liquidSaturation(t + h) - curve->liquidSaturation(t - h)) / (2.0 * h);
			worst                = std::max(worst, std::abs(numeric - curve->derivative(t)));
			EXPECT_NEAR(numeric, curve->derivative(t), 2e-7) << name << " at " << t;
		}
	}
	std::printf("largest |slope - central difference| %.1e 1/K (tolerance 2e-7, truncation of the difference)\n", worst);
}

TEST(FreezingCurve, IntegralIsTheQuadratureOfEveryCurve)
{
	double worst = 0.0;
	for (const std::string& name : freezingCurveNames()) {
		const auto curve = makeFreezingCurve(name, { { "freezingTemperature", -0.1 } });
		for (double t : { 0.7, -0.4, -1.1, -6.0 }) {
			// away from the kinks at T_f and T_m Simpson converges; difference two integrals on the smooth side
			const double nearer  = t > -0.1 ? 0.2 : t + 0.25 * (-0.1 - t);
			const bool   kink    = name == "linear" && t < -1.0 && nearer > -1.0;
			const double numeric = simpson(*curve, t, nearer, kink ? 200000 : 2000);
			const double exact   = curve->integral(nearer) - curve->integral(t);
			worst                = std::max(worst, std::abs(numeric - exact));
			EXPECT_NEAR(exact, numeric, 1e-9) << name << " from " << t << " to " << nearer;
		}
	}
	std::printf("largest |integral - Simpson's rule| %.1e K (tolerance 1e-9)\n", worst);
}

TEST(FreezingCurve, SaturationNeverDecreasesWithTemperatureAndStaysBetweenResidualAndOne)
{
	for (const std::string& name : freezingCurveNames()) {
		const auto curve    = makeFreezingCurve(name);
		double     previous = 0.0;
		for (double t = -40.0; t < 2.0; t += 0.01) {
			const double s = curve->liquidSaturation(t);
			ASSERT_GE(s, previous) << name << " at " << t;
			ASSERT_GE(s, curve->residualSaturation()) << name << " at " << t;
			ASSERT_LE(s, 1.0) << name << " at " << t;
			ASSERT_GE(curve->derivative(t), 0.0) << name << " at " << t;
			previous = s;
		}
		EXPECT_EQ(curve->liquidSaturation(curve->freezingTemperature()), 1.0) << name;
	}
}

TEST(FreezingCurve, BatchGivesTheSameBitsAsSingleCalls)
{
	const double temperature[] = { -3.0, -0.4, -0.1, 0.0, 1.0 };
	for (const std::string& name : freezingCurveNames()) {
		const auto curve = makeFreezingCurve(name);
		double     saturation[5], slope[5];
		curve->evaluate(temperature, saturation, slope, 5);
		for (int k = 0; k < 5; ++k) {
			EXPECT_EQ(saturation[k], curve->liquidSaturation(temperature[k]));
			EXPECT_EQ(slope[k], curve->derivative(temperature[k]));
		}
	}
}

TEST(FreezingCurve, WrongNamesAndValuesAreRefusedWithAttributeValueAndRemedy)
{
	const auto message = [](const std::string& name, const CurveParameters& parameters) -> std::string {
		try {
			makeFreezingCurve(name, parameters);
		} catch (const std::invalid_argument& error) {
			return error.what();
		}
		return "no exception";
	};
	const auto expect = [&](const std::string& text, std::initializer_list<const char*> parts) {
		for (const char* part : parts)
			EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is missing in: " << text;
	};
	expect(message("gaus", {}), { "freezingCurve", "gaus", "gauss", "vanGenuchten" });
	expect(message("gauss", { { "wdth", 1.0 } }), { "wdth", "width", "residualSaturation" });
	expect(message("gauss", { { "width", -0.5 } }), { "width", "-0.5", "positive" });
	expect(message("gauss", { { "width", std::nan("") } }), { "width", "nan", "positive" });
	expect(message("gauss", { { "residualSaturation", 1.0 } }), { "residualSaturation", "1", "[0, 1)" });
	expect(message("linear", { { "frozenTemperature", 0.5 } }), { "frozenTemperature", "0.5", "sharp" });
	expect(message("vanGenuchten", { { "lambda", 1.2 } }), { "lambda", "1.2", "(0, 1)" });
	expect(message("power", { { "exponent", 0.5 } }), { "exponent", "0.5", "exceed 1" });
}
