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

/// Points of a silt, as unfrozen water is measured: irregular, with a plateau, the last one above the freezing point.
std::vector<CurvePoint> measuredPoints(double freezingTemperature)
{
	const std::pair<double, double> undercooled[] = { { 9.0, 0.06 },  { 3.0, 0.09 }, { 1.5, 0.16 }, { 0.65, 0.3 }, { 0.5, 0.3 },
		                                          { 0.15, 0.62 }, { 0.05, 0.9 }, { 0.0, 1.0 },  { -2.0, 1.0 } };
	std::vector<CurvePoint>         points;
	for (const auto& [undercooling, saturation] : undercooled)
		points.push_back({ freezingTemperature - undercooling, saturation });
	return points;
}

/// All that have a name, and a table.
std::vector<FreezingCurvePtr> allCurves(double freezingTemperature = 0.0)
{
	std::vector<FreezingCurvePtr> curves { makeFreezingCurve(measuredPoints(freezingTemperature)) };
	for (const std::string& name : freezingCurveNames())
		curves.push_back(makeFreezingCurve(name, { { "freezingTemperature", freezingTemperature } }));
	return curves;
}

/// Samples of another curve.
FreezingCurvePtr sampled(const FreezingCurve& curve, double coldest, int intervals)
{
	std::vector<CurvePoint> points;
	for (int k = 0; k <= intervals; ++k) {
		const double t = coldest * (1.0 - double(k) / intervals);
		points.push_back({ t, curve.liquidSaturation(t) });
	}
	return makeFreezingCurve(points);
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
	EXPECT_NEAR(curve->liquidSaturation(-0.5), 0.05 + 0.95 * std::exp(-1.0), 1e-15);
	EXPECT_EQ(curve->residualSaturation(), 0.05);
	EXPECT_EQ(curve->freezingTemperature(), 0.0);
}

TEST(FreezingCurve, SlopeIsTheNumericalDerivativeOfEveryCurve)
{
	double worst = 0.0;
	for (const auto& curve : allCurves(-0.1)) {
		const std::string name = curve->name();
		for (double t : { 0.3, -0.13, -0.2, -0.35, -0.7, -2.0, -7.0 }) {
			const double h       = 1e-5;
			const double numeric = (curve->liquidSaturation(t + h) - curve->liquidSaturation(t - h)) / (2.0 * h);
			worst                = std::max(worst, std::abs(numeric - curve->derivative(t)));
			EXPECT_NEAR(numeric, curve->derivative(t), 2e-7) << name << " at " << t;
		}
	}
	std::printf("largest |slope - central difference| %.1e 1/K (tolerance 2e-7, truncation of the difference)\n", worst);
}

TEST(FreezingCurve, SaturationNeverDecreasesWithTemperatureAndStaysBetweenResidualAndOne)
{
	for (const auto& curve : allCurves()) {
		const std::string name     = curve->name();
		double            previous = 0.0;
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

TEST(FreezingCurve, TableOfTwoPointsIsTheLinearCurve)
{
	const auto linear = makeFreezingCurve("linear", { { "frozenTemperature", -1.4 }, { "freezingTemperature", -0.2 } });
	const auto table  = makeFreezingCurve(std::vector<CurvePoint> { { -1.4, 0.05 }, { -0.2, 1.0 } });
	double     worst  = 0.0;
	for (double t = -3.03; t < 1.0; t += 0.01)
		for (const double difference : { table->liquidSaturation(t) - linear->liquidSaturation(t), table->derivative(t) - linear->derivative(t) })
			worst = std::max(worst, std::abs(difference));
	std::printf("largest difference of S_l and slope %.1e (tolerance 1e-14)\n", worst);
	EXPECT_LT(worst, 1e-14);
	EXPECT_EQ(table->freezingTemperature(), -0.2);
	EXPECT_EQ(table->residualSaturation(), 0.05);
}

TEST(FreezingCurve, TableHasTheMeasuredValuesAtItsPoints)
{
	const auto curve = makeFreezingCurve(measuredPoints(-0.1));
	for (const CurvePoint& point : measuredPoints(-0.1))
		EXPECT_NEAR(curve->liquidSaturation(point.temperature), point.liquidSaturation, 1e-15) << point.temperature;
	EXPECT_EQ(curve->freezingTemperature(), -0.1); // of the first point without ice, not of the last
	EXPECT_EQ(curve->liquidSaturation(-60.0), 0.06);
}

// Linear interpolation is off by h^2/8 times the largest curvature, which is 4 (1 - S_r)/W^2 exp(-3/2) of exp(-(theta/W)^2), or 2 (1 - S_r)/W^2 at T_f.
TEST(FreezingCurve, TableOfManyPointsIsTheCurveThatTheyWereTakenFrom)
{
	const auto   gauss   = makeFreezingCurve("gauss", { { "width", 0.5 } });
	const double coldest = -4.0;
	double       former  = 0.0;
	for (const int intervals : { 40, 80, 160, 320 }) {
		const auto   table = sampled(*gauss, coldest, intervals);
		const double h = -coldest / intervals, bound = h * h / 8.0 * 2.0 * 0.95 / 0.25;
		double       saturation = 0.0;
		for (double t = coldest; t < 0.1; t += 0.000737)
			saturation = std::max(saturation, std::abs(table->liquidSaturation(t) - gauss->liquidSaturation(t)));
		std::printf(
		        "%3d points: S_l off by %.2e (bound %.2e); error of S_l over that of half as many points %.3f (1/4, tolerance 0.02)\n", intervals + 1,
		        saturation, bound, saturation / former);
		EXPECT_LE(saturation, bound);
		if (former > 0.0) {
			EXPECT_NEAR(saturation / former, 0.25, 0.02);
		}
		former = saturation;
	}
}

TEST(FreezingCurve, TablesThatAreNoMonotoneCurveAreRefusedInASentence)
{
	const auto message = [](const std::vector<CurvePoint>& points) -> std::string {
		try {
			makeFreezingCurve(points);
		} catch (const std::invalid_argument& error) {
			return error.what();
		}
		return "no exception";
	};
	const std::pair<std::vector<CurvePoint>, const char*> wrong[] = {
		{ {}, "number of points = 0: must be 2 or more" },
		{ { { 0.0, 1.0 } }, "number of points = 1: must be 2 or more" },
		{ { { -1.0, 0.1 }, { -1.0, 0.3 }, { 0.0, 1.0 } }, "temperatures[1] = -1: must exceed the one before" },
		{ { { 0.0, 1.0 }, { -1.0, 0.1 } }, "temperatures[1] = -1: must exceed the one before by 1e-9 K or more: give the points in ascending order" },
		{ { { -2.0, 0.3 }, { -1.0, 0.1 }, { 0.0, 1.0 } }, "liquidSaturations[1] = 0.1: must not be less than the one before" },
		{ { { -1.0, 0.1 }, { -0.1, 0.8 } }, "last value = 0.8: must be 1, at the temperature at which freezing begins" },
		{ { { -1.0, 1.0 }, { 0.0, 1.0 } }, "first value = 1: must be less than 1" },
		{ { { -1.0, -0.1 }, { 0.0, 1.0 } }, "liquidSaturations[0] = -0.1: must lie in [0, 1]" },
		{ { { -1.0, 0.1 }, { 0.0, 1.1 } }, "liquidSaturations[1] = 1.1: must lie in [0, 1]" },
		{ { { std::nan(""), 0.1 }, { 0.0, 1.0 } }, "temperatures[0] = nan: must be a temperature" },
		{ { { -1.0, std::nan("") }, { 0.0, 1.0 } }, "liquidSaturations[0] = nan: must lie in [0, 1]" },
		{ { { -300.0, 0.1 }, { 0.0, 1.0 } }, "temperatures[0] = -300: must be a temperature in degC between -100 and 50" },
	};
	for (const auto& [points, sentence] : wrong)
		EXPECT_NE(message(points).find(sentence), std::string::npos) << sentence << " is missing in: " << message(points);
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
	expect(message("gaus", {}), { "FreezingCurve.curve", "gaus", "gauss", "vanGenuchten" });
	expect(message("gauss", { { "wdth", 1.0 } }), { "wdth", "width", "residualSaturation" });
	expect(message("gauss", { { "width", -0.5 } }), { "width", "-0.5", "positive" });
	expect(message("gauss", { { "width", std::nan("") } }), { "width", "nan", "positive" });
	expect(message("gauss", { { "residualSaturation", 1.0 } }), { "residualSaturation", "1", "[0, 1)" });
	expect(message("linear", { { "frozenTemperature", 0.5 } }), { "frozenTemperature", "0.5", "sharp" });
	expect(message("vanGenuchten", { { "exponent", 1.2 } }), { "exponent", "1.2", "(0, 1)" });
	expect(message("power", { { "exponent", 0.5 } }), { "exponent", "0.5", "exceed 1" });
}
