// SPDX-License-Identifier: GPL-2.0-or-later
// Thawed ground follows a measured curve of strain over stress: under its own weight and a surcharge, loaded in steps, unloaded and frozen again.
#include "Report.hpp"
#include "Scenes.hpp"

#include "../unit/groundState.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double spacing = 0.1, porosity = 0.6, scale = 5e6, gravity = 9.81;

/// Frozen column between rollers that thaws from its surface.
struct Column {
	double                            height     = 1.0;
	double                            settlement = 0.05; ///< A_0 [-]
	CompressionCurve                  curve;
	std::shared_ptr<SkeletonModel<2>> skeleton;
	TimeTable                         load { { 0.0 }, { 0.0 } }; ///< pressure on the surface over calendar time [Pa]
	TimeTable                         air { { 0.0 }, { 8.0 } };
	double                            weight = gravity, temperature = -1.0;
	bool                              water = false, bBar = true;

	std::unique_ptr<Ground<2>> ground() const
	{
		auto s = columnSettings(spacing, height + 2 * spacing);
		s.materials.resize(1);
		s.materials[0].mixture     = withoutExpansion();
		s.materials[0].thawStrain  = settlement;
		s.materials[0].compression = curve;
		standOnRollers(s);
		s.motion.emplace();
		s.motion->gravity      = { 0.0, -weight };
		s.motion->localDamping = 0.3;
		s.motion->bBar         = bBar;
		s.heat.emplace();
		s.heat->thermalTimeScale = scale;
		s.freezing               = makeFreezingCurve();
		s.energyLedger           = true;
		s.skeletons.push_back(skeleton);
		addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), air);
		addBoundary<Traction<2>>(s, Region<2>::freeSurface(), load);
		if (water) {
			s.water.emplace();
			s.water->state.liquidBulkModulus = 2.2e7;
			s.water->state.iceBulkModulus    = 8.8e7;
			addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
		}
		auto ground = std::make_unique<Ground<2>>(s);
		fillBox(*ground, { 0.0, 0.0 }, { spacing, height }, [&](PointInput<2>& p) {
			p.porosity    = porosity;
			p.temperature = temperature;
		});
		ground->initialise();
		return ground;
	}
};

std::shared_ptr<MohrCoulombSkeleton<2>> silt()
{
	auto soil            = std::make_shared<MohrCoulombSkeleton<2>>();
	soil->young          = 1e7;
	soil->youngFrozen    = 1e8;
	soil->frictionAngle  = 30.0;
	soil->cohesion       = 0.0;
	soil->cohesionFrozen = 2e5;
	return soil;
}

double settlementOf(const Column& c, const Ground<2>& ground) { return c.height - sumOf(ground, "volume") / spacing; }

/// In pieces, because the limit of heat follows the state.
void marchSlowly(Ground<2>& ground, double until)
{
	for (double instant = ground.time() + 0.1; instant < until - 1e-9; instant += 0.1)
		marchTo(ground, instant);
	marchTo(ground, until);
}

/// Weight of a share of the column, per area [Pa]; buoyant where it has water, whose part leaves as the ground settles.
double weightOf(const Column& c, double part)
{
	const MixtureProperties m      = withoutExpansion();
	const double            grains = (1.0 - porosity) * (m.solid.density - (c.water ? m.liquid.density : 0.0));
	return c.weight * c.height * part * (grains + (c.water ? 0.0 : porosity * m.liquid.density));
}

/// Settlement of the column under its weight and a surcharge by its curve.
double byHand(const Column& c, double surcharge)
{
	constexpr int parts = 1000;
	double        sum   = 0.0;
	for (int k = 0; k < parts; ++k)
		sum += c.settlement + c.curve.strain(surcharge + weightOf(c, (k + 0.5) / parts), 1.0 - porosity);
	return c.height * sum / parts;
}

TimeTable inMotion(std::vector<double> times, std::vector<double> values)
{
	for (double& time : times)
		time *= scale;
	return TimeTable(times, values);
}

CompressionCurve linear(double perPascal)
{
	CompressionCurve c;
	c.compressibility = perPascal;
	return c;
}

CompressionCurve logarithmic(double index, double reference)
{
	CompressionCurve c;
	c.compressionIndex = index;
	c.referenceStress  = reference;
	return c;
}

/// Thaws the column under its load and compares its settlement with the curve, summed over depth.
void expectSettlement(const std::string& name, const Column& column, double surcharge, double tolerance)
{
	const auto   ground   = column.ground();
	const double enthalpy = ground->balance().enthalpy;
	marchSlowly(*ground, 5.0);
	const auto b = ground->balance();
	expectSmall(name + ": ice left", largestSize(valuesOf(*ground, "iceSaturation")), 1e-12);
	expectRelative(name + ": settlement [m]", settlementOf(column, *ground), byHand(column, surcharge), tolerance);
	expectSmall(
	        name + ": gain of heat less what crossed the surface, over that", std::abs(b.enthalpy + b.enthalpyOut - enthalpy - b.heatIn) / b.heatIn, 1e-10);
}

constexpr double lawModulus = 1e7; ///< of the oedometer [Pa]

/// A short column with next to no weight: an oedometer.
Column oedometer(const CompressionCurve& curve, double settlement)
{
	Column c;
	c.curve      = curve;
	c.settlement = settlement;
	c.height     = 0.4;
	c.skeleton   = elasticOedometer(lawModulus);
	c.weight     = 1e-3;
	return c;
}

double strainOf(const Column& c, const Ground<2>& ground) { return settlementOf(c, ground) / c.height; }

} // namespace

TEST(ThawedCompression, ColumnThatThawsUnderItsWeightAndASurchargeSettlesByTheMeasuredLine)
{
	citing("strain A_0 + a_0 stress, summed over depth");
	Column column;
	column.curve    = linear(7.6e-7); // the mean of fine-grained soils
	column.skeleton = silt();
	expectSettlement("thaw strain A_0 + a_0 stress: Mohr-Coulomb, own weight", column, 0.0, 4e-2);
	column.load = inMotion({ 0.0, 1.0 }, { 0.0, 5e4 });
	expectSettlement("thaw strain A_0 + a_0 stress: Mohr-Coulomb, surcharge of 50 kPa", column, 5e4, 5e-2);
	column.skeleton = elasticOedometer(1.35e7);
	expectSettlement("thaw strain A_0 + a_0 stress: elastic, surcharge of 50 kPa", column, 5e4, 3e-2);
}

TEST(ThawedCompression, SaturatedColumnThatDrainsSettlesByTheMeasuredLineOfItsEffectiveStress_slow)
{
	citing("strain A_0 + a_0 effective stress, summed over depth");
	Column column;
	column.curve    = linear(7.6e-7);
	column.skeleton = silt();
	column.water    = true;
	column.load     = inMotion({ 0.0, 1.0 }, { 0.0, 5e4 });
	expectSettlement("thaw strain A_0 + a_0 stress: saturated, surcharge of 50 kPa", column, 5e4, 6e-2);
}

// What is lost at a depth follows the stress there
TEST(ThawedCompression, StrainAtEachDepthFollowsTheStressThere)
{
	citing("strain a_0 stress at a depth");
	Column column;
	column.settlement = 0.0;
	column.curve      = linear(7.6e-7);
	column.skeleton   = elasticOedometer(1.35e7);
	const auto ground = column.ground();
	marchSlowly(*ground, 5.0);
	const auto start = valuesOf(*ground, "initialVolume"), volume = valuesOf(*ground, "volume");
	const auto y = valuesOf(*ground, "position", 1), rise = valuesOf(*ground, "displacement", 1);
	Drawing    drawing("thawed_compression", "Strain of a thawed column under its own weight", "strain [%]", "height frozen [m]");
	double     square = 0.0;
	for (int cell = 0; cell < 10; ++cell) {
		double lost = 0.0, before = 0.0;
		for (std::size_t p = 0; p < y.size(); ++p) {
			if (int((y[p] - rise[p]) / spacing) != cell) continue;
			lost += start[p] - volume[p];
			before += start[p];
		}
		const double middle = (cell + 0.5) * spacing, hand = column.curve.strain(weightOf(column, 1.0 - middle), 1.0 - porosity);
		square += std::pow(lost / before - hand, 2) / 10.0;
		drawing.computed("cells", 100.0 * lost / before, middle);
		drawing.reference("a_0 times the weight above", 100.0 * hand, middle);
	}
	expectScaled("thaw strain at a depth: root mean square off a_0 times the weight above", std::sqrt(square), 0.0, byHand(column, 0.0), 1e-1);
}

// Virgin loading follows the curve, unloading and reloading the law alone
TEST(ThawedCompression, ColumnLoadedInStepsAfterThawFollowsTheCurveAndKeepsItsStrainWhenUnloaded)
{
	citing("strain A_0 + a_0 stress; Hooke");
	Column column     = oedometer(linear(5e-7), 0.1);
	column.load       = inMotion({ 0.0, 0.3, 2.0, 2.3, 3.0, 3.3, 4.0, 4.3, 5.0, 5.3 }, { 0.0, 2e4, 2e4, 5e4, 5e4, 1e5, 1e5, 0.0, 0.0, 1e5 });
	const auto ground = column.ground();
	for (const auto& [until, stress] : { std::pair { 2.0, 2e4 }, { 3.0, 5e4 }, { 4.0, 1e5 } }) {
		marchSlowly(*ground, until);
		const std::string name = "thawed column loaded in steps: strain at " + std::to_string(int(1e-3 * stress)) + " kPa";
		expectRelative(name, strainOf(column, *ground), 0.1 + 5e-7 * stress, 2e-2);
	}
	const double loaded = strainOf(column, *ground);
	marchSlowly(*ground, 5.0);
	expectScaled("thawed column unloaded: swelling over that of the law", (loaded - strainOf(column, *ground)) / (1e5 / lawModulus), 1.0, 1.0, 0.2);
	marchSlowly(*ground, 6.0);
	expectRelative("thawed column loaded again: strain over that before", strainOf(column, *ground), loaded, 1e-2);
}

namespace {

/// A thaw settlement test: strain of the height frozen at each load.
struct Measured {
	const char *        name, *file;
	std::vector<double> stress; ///< [Pa]
	std::vector<double> strain;
};

/// The semilogarithmic line of the test itself, by least squares: (strain at 1 kPa, a decade).
std::pair<double, double> lineThrough(const Measured& test)
{
	const double n = double(test.stress.size());
	double       x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
	for (std::size_t k = 0; k < test.stress.size(); ++k) {
		const double at = std::log10(test.stress[k] / 1e3);
		x += at / n;
		y += test.strain[k] / n;
		xx += at * at / n;
		xy += at * test.strain[k] / n;
	}
	const double slope = (xy - x * y) / (xx - x * x);
	return { y - slope * x, slope };
}

} // namespace

// Each test has an A and a C_c of its own; what is shown is that the column of the program does what the sample of the laboratory did
TEST(ThawedCompression, ColumnLoadedInStepsReproducesSingleTestsOfFrozenSoils)
{
	citing("Mohammadi & Hayley 2025, tests NESCL-133, -153, -069 (CC BY 4.0)");
	const Measured tests[] = {
		{ "fine soil (NESCL-133)", "NESCL-133", { 4790, 17140, 29300, 66120 }, { 0.110, 0.182, 0.206, 0.255 } },
		{ "fine soil (NESCL-153)", "NESCL-153", { 2480, 21010, 39670, 77050 }, { 0.074, 0.135, 0.151, 0.170 } },
		{ "coarse soil (NESCL-069)", "NESCL-069", { 5360, 17620, 29880, 66890 }, { 0.126, 0.142, 0.148, 0.159 } },
	};
	for (const Measured& test : tests) {
		const auto [start, decade] = lineThrough(test);
		Column              column = oedometer(logarithmic(decade / (1.0 - porosity), 1e3), start); // strain, not void ratio: any porosity does
		std::vector<double> times { 0.0 }, loads { 0.0 };
		for (std::size_t k = 0; k < test.stress.size(); ++k)
			for (const double time : { k == 0 ? 0.3 : 1.3 + double(k), 2.0 + double(k) }) {
				times.push_back(time);
				loads.push_back(test.stress[k]);
			}
		column.load       = inMotion(times, loads);
		const auto ground = column.ground();
		Drawing    drawing(std::string("thaw_test_") + test.file, std::string("Thaw settlement test, ") + test.name, "stress [kPa]", "strain [%]");
		for (std::size_t k = 0; k < test.stress.size(); ++k) {
			marchSlowly(*ground, 2.0 + double(k));
			char label[32];
			std::snprintf(label, sizeof label, " at %.1f kPa", 1e-3 * test.stress[k]);
			expectScaled(
			        std::string("thaw test, ") + test.name + ": strain" + label, strainOf(column, *ground), test.strain[k], test.strain.back(),
			        5e-2);
			drawing.computed("column", 1e-3 * test.stress[k], 100.0 * strainOf(column, *ground));
			drawing.reference("test", 1e-3 * test.stress[k], 100.0 * test.strain[k]);
		}
	}
}

// Frozen ground does not follow the curve, whatever is laid on it
TEST(ThawedCompression, GroundThatStaysFrozenHasTheBitsOfGroundWithoutCompression)
{
	Column column;
	column.skeleton    = silt();
	column.air         = TimeTable({ 0.0 }, { -5.0 });
	column.temperature = -5.0;
	column.load        = inMotion({ 0.0, 0.2 }, { 0.0, 5e4 });
	const auto without = column.ground();
	column.curve       = linear(7.6e-7);
	column.skeleton    = silt();
	const auto with    = column.ground();
	for (const auto* ground : { without.get(), with.get() })
		marchTo(const_cast<Ground<2>&>(*ground), 0.5);
	double differing = 0.0;
	for (const FieldInfo& info : without->fields()) {
		if (info.place != "points") continue;
		for (int c = 0; c < info.components; ++c) {
			const auto a = valuesOf(*without, info.name, c), b = valuesOf(*with, info.name, c);
			for (std::size_t p = 0; p < a.size(); ++p)
				differing += a[p] != b[p];
		}
	}
	expectSmall("frozen column with a compression curve under load: values that differ in any bit from those without", differing, 0.0);
	expectSmall("frozen column with a compression curve under load: strain lost", largestSize(valuesOf(*with, "thawedCompression")), 0.0);
	const auto fields = without->fields();
	EXPECT_FALSE(std::any_of(fields.begin(), fields.end(), [](const FieldInfo& f) { return f.owner == "thawedCompression"; }));
}

// Ice that forms again holds the soil, and what was lost stays lost
TEST(ThawedCompression, GroundThatFreezesAgainKeepsItsStrainAndBearsMoreLoadByTheLawAlone)
{
	citing("Hooke");
	Column column     = oedometer(linear(5e-7), 0.1);
	column.load       = inMotion({ 0.0, 0.3, 4.0, 4.3 }, { 0.0, 2e4, 2e4, 6e4 });
	column.air        = inMotion({ 0.0, 2.0, 2.2 }, { 8.0, 8.0, -15.0 });
	const auto ground = column.ground();
	marchSlowly(*ground, 2.0);
	const double thawed = strainOf(column, *ground);
	marchSlowly(*ground, 4.0);
	expectRelative("thawed column frozen again: strain over that before", strainOf(column, *ground), thawed, 1e-2);
	const double frozen = strainOf(column, *ground), ice = largestSize(valuesOf(*ground, "iceSaturation"));
	std::printf("ice saturation %.2f\n", ice);
	marchSlowly(*ground, 5.0);
	expectSmall("frozen again, 40 kPa more: strain", strainOf(column, *ground) - frozen, 1.5 * 4e4 / lawModulus + 0.1 * 5e-7 * 4e4);
}

TEST(ThawedCompression, SoilThatCannotFollowItsCurveIsRefusedWithARemedy)
{
	const auto fault = [](const Column& column) -> std::string {
		try {
			column.ground();
		} catch (const std::invalid_argument& e) {
			return e.what();
		}
		return {};
	};
	Column soft   = oedometer(linear(5e-7), 0.1);
	soft.skeleton = elasticOedometer(1e6);
	EXPECT_NE(fault(soft).find("compressibility = 5e-07: ElasticSkeleton, the law of these points, alone strains by 1e-06 per Pa"), std::string::npos)
	        << fault(soft);
	EXPECT_NE(fault(oedometer(linear(0.05), 0.1)).find("1 % per kPa is 1e-5"), std::string::npos);
	CompressionCurve both = linear(5e-7);
	both.compressionIndex = 0.2;
	EXPECT_NE(fault(oedometer(both, 0.1)).find("leave one of them 0"), std::string::npos);
	EXPECT_NE(fault(oedometer(logarithmic(0.2, -1.0), 0.1)).find("referenceStress = -1: must be positive"), std::string::npos);
	EXPECT_NE(fault(oedometer(logarithmic(-0.2, 1e3), 0.1)).find("compressionIndex = -0.2"), std::string::npos);
}
