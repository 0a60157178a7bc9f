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

constexpr double spacing = 0.1, height = 1.0, porosity = 0.6, scale = 1e7, gravity = 9.81;

/// Frozen column between rollers that thaws from its surface.
struct Column {
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
	auto soil                = std::make_shared<MohrCoulombSkeleton<2>>();
	soil->youngModulus       = 1e7;
	soil->youngModulusFrozen = 1e8;
	soil->frictionAngle      = 30.0;
	soil->cohesion           = 0.0;
	soil->cohesionFrozen     = 2e5;
	return soil;
}

double settlementOf(const Ground<2>& ground) { return height - sumOf(ground, "volume") / spacing; }

/// In pieces, because the limit of heat follows the state.
void marchSlowly(Ground<2>& ground, double until)
{
	for (double instant = ground.time() + 0.1; instant < until - 1e-9; instant += 0.1)
		marchTo(ground, instant);
	marchTo(ground, until);
}

/// Weight of the ground above a share of its mass, per area [Pa]; buoyant where it has water, whose part leaves as the ground settles.
double weightOf(double part, bool water)
{
	const MixtureProperties m = withoutExpansion();
	const double            grains = (1.0 - porosity) * (m.solid.density - (water ? m.liquid.density : 0.0));
	return gravity * height * part * (grains + (water ? 0.0 : porosity * m.liquid.density));
}

/// Settlement of the column under its weight and a surcharge by its curve.
double byHand(const Column& c, double surcharge)
{
	constexpr int parts = 1000;
	double        sum   = 0.0;
	for (int k = 0; k < parts; ++k)
		sum += c.settlement + c.curve.strain(surcharge + weightOf((k + 0.5) / parts, c.water), 1.0 - porosity);
	return height * sum / parts;
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

/// Thaws the column under its load and compares its settlement, and its strain over depth, with the curve.
void expectSettlement(const std::string& name, const Column& column, double surcharge, double seconds, double tolerance)
{
	auto ground = column.ground();
	marchSlowly(*ground, seconds);
	expectSmall(name + ": ice left", largestSize(valuesOf(*ground, "iceSaturation")), 1e-12);
	expectRelative(name + ": settlement [m]", settlementOf(*ground), byHand(column, surcharge), tolerance);
}

} // namespace

TEST(ThawedCompression, ColumnThatThawsUnderItsWeightAndASurchargeSettlesByTheMeasuredLine)
{
	citing("strain A_0 + a_0 stress, integrated over depth");
	Column column;
	column.curve    = linear(7.6e-7); // the mean of fine-grained soils
	column.skeleton = silt();
	expectSettlement("thaw strain A_0 + a_0 stress, own weight", column, 0.0, 2.0, 2e-2);
	column.load = inMotion({ 0.0, 0.2 }, { 0.0, 5e4 });
	expectSettlement("thaw strain A_0 + a_0 stress, surcharge of 50 kPa", column, 5e4, 2.0, 2e-2);
}
