// SPDX-License-Identifier: GPL-2.0-or-later
// Ground of several materials: thaw through layers of different ice content, seepage across layers, thaw strain of ice-rich ground.
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include "../unit/groundState.hpp"

#include <gtest/gtest.h>

#include <algorithm>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double day = 86400.0;

/// A horizontal layer, from the base up.
struct Layer {
	double thickness;         ///< [m]
	double porosity;          ///< [-]
	double grainConductivity; ///< thermal [W/(m K)]
	double thawStrain = 0.0;  ///< [-]
};

double heightOf(const std::vector<Layer>& layers)
{
	double sum = 0.0;
	for (const Layer& layer : layers)
		sum += layer.thickness;
	return sum;
}

int layerAt(const std::vector<Layer>& layers, double y)
{
	double top = 0.0;
	for (std::size_t k = 0; k < layers.size(); ++k)
		if (y < (top += layers[k].thickness)) return int(k);
	return int(layers.size()) - 1;
}

std::vector<SoilMaterial> materialsOf(const std::vector<Layer>& layers)
{
	std::vector<SoilMaterial> list;
	for (const Layer& layer : layers) {
		SoilMaterial m;
		m.mixture                    = withoutExpansion();
		m.mixture.solid.conductivity = layer.grainConductivity;
		m.thawStrain                 = layer.thawStrain;
		list.push_back(m);
	}
	return list;
}

double thawedConductivity(const Layer& layer)
{
	return (1.0 - layer.porosity) * layer.grainConductivity + layer.porosity * withoutExpansion().liquid.conductivity;
}
double latentPerVolume(const Layer& layer) { return layer.porosity * withoutExpansion().ice.density * withoutExpansion().latentHeat; }

/// Time at which the front has thawed layers up to a depth, all frozen at the melting point: the heat of each slice passes the
/// resistance of what has thawed before it (Stefan 1891, for layers as in Aldrich & Paynter 1953 with lambda = 1).
double stefanTime(const std::vector<Layer>& layers, double depth, double surface)
{
	double time = 0.0, resistance = 0.0;
	for (const Layer& layer : layers) {
		const double x = std::min(layer.thickness, depth), k = thawedConductivity(layer);
		time += latentPerVolume(layer) / surface * (x * resistance + 0.5 * x * x / k);
		resistance += layer.thickness / k;
		depth -= x;
		if (depth <= 0.0) break;
	}
	return time;
}

/// Rigid column in layers, at the melting point and thawed by its base.
Ground<2> thawingLayers(const std::vector<Layer>& layers, double spacing, double surface)
{
	const double height = heightOf(layers);
	auto         s      = columnSettings(spacing, height);
	s.materials         = materialsOf(layers);
	s.heat.emplace();
	s.freezing = makeFreezingCurve("sharp", { { "residualSaturation", 0.0 } });
	addBoundary<WallTemperature<2>>(s, Region<2>::side("bottom"), surface);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { spacing, height }, [&](PointInput<2>& p) {
		p.material    = layerAt(layers, p.position[1]);
		p.porosity    = layers[p.material].porosity;
		p.temperature = -1e-3;
	});
	ground.initialise();
	return ground;
}

double thawedDepth(const Ground<2>& ground)
{
	const auto ice = valuesOf(ground, "iceSaturation"), volume = valuesOf(ground, "volume");
	double     sum = 0.0;
	for (std::size_t p = 0; p < ice.size(); ++p)
		sum += (1.0 - ice[p]) * volume[p];
	return sum / ground.settings().gridSpacing;
}

/// Frozen column in layers under its own weight that thaws from its surface, drained where it has water.
struct SettlingColumn {
	std::vector<Layer>                layers;
	std::shared_ptr<SkeletonModel<2>> skeleton;
	bool                              water = false;
	/// Calendar time over time of motion [-]. Cells that lose their strength have to fall no more slowly than they thaw.
	double scale   = 1e7;
	double spacing = 0.1; ///< h [m]
	double surface = 5.0; ///< temperature [degC]
	/// Points of a cell; one is the default of talik.geometry.fill in ground that freezes.
	int perDirection = 1;

	Ground<2> ground() const
	{
		const double height = heightOf(layers);
		auto         s      = columnSettings(spacing, height + 2 * spacing);
		s.materials         = materialsOf(layers);
		standOnRollers(s);
		s.motion.emplace();
		s.motion->gravity      = { 0.0, -9.81 };
		s.motion->localDamping = 0.3;
		s.heat.emplace();
		s.heat->thermalTimeScale = scale;
		s.freezing               = makeFreezingCurve();
		s.skeletons.push_back(skeleton);
		addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), surface);
		if (water) {
			s.water.emplace();
			s.water->state.liquidBulkModulus = 2.2e7;
			s.water->state.iceBulkModulus    = 8.8e7;
			addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
		}
		Ground<2> ground(s);
		fillBox(
		        ground, { 0.0, 0.0 }, { spacing, height },
		        [&](PointInput<2>& p) {
			        p.material    = layerAt(layers, p.position[1]);
			        p.porosity    = layers[p.material].porosity;
			        p.temperature = -1.0;
		        },
		        perDirection);
		ground.initialise();
		return ground;
	}
};

std::shared_ptr<MohrCoulombSkeleton<2>> silt()
{
	auto soil            = std::make_shared<MohrCoulombSkeleton<2>>();
	soil->young          = 1e7;
	soil->youngFrozen    = 1e8;
	soil->poisson        = 0.3;
	soil->frictionAngle  = 30.0;
	soil->cohesion       = 0.0;
	soil->cohesionFrozen = 2e5;
	return soil;
}

double settlementOf(const Ground<2>& ground, double before) { return before - sumOf(ground, "volume") / ground.settings().gridSpacing; }

/// H (1 - (1 - thawStrain)(1 - n_0)/(1 - n_1)) of each layer, with n_1 = n_0: the soil itself keeps its porosity.
double handSettlement(const std::vector<Layer>& layers)
{
	double sum = 0.0;
	for (const Layer& layer : layers)
		sum += layer.thickness * layer.thawStrain;
	return sum;
}

struct Settled {
	double settlement, heatError, iceLeft;
};

Settled settle(const SettlingColumn& column, double seconds)
{
	Ground<2>    ground = column.ground();
	const double height = heightOf(column.layers), enthalpy = ground.balance().enthalpy;
	for (double instant = 0.1; instant < seconds + 1e-9; instant += 0.1) // the limit of heat follows the state
		marchTo(ground, instant);
	const auto b = ground.balance();
	Settled    r {};
	r.settlement = settlementOf(ground, height);
	r.heatError  = std::abs(b.enthalpy + b.enthalpyOut - enthalpy - b.heatIn) / std::abs(b.heatIn);
	r.iceLeft    = largestSize(valuesOf(ground, "iceSaturation"));
	return r;
}

/// Path of the surface, the mean of its upper half cell, over the volume that is lost per area once the column has come to rest [-].
double pathOverLoss(const SettlingColumn& column)
{
	Ground<2>    ground = column.ground();
	const double bottom = heightOf(column.layers) - 0.5 * column.spacing;
	const auto   start  = valuesOf(ground, "position", 1);
	const auto   path   = [&] {
                const auto rise  = valuesOf(ground, "displacement", 1);
                double     sum   = 0.0;
                int        count = 0;
                for (std::size_t p = 0; p < rise.size(); ++p)
                        if (start[p] > bottom) sum -= rise[p], ++count;
                return sum / count;
	};
	marchTo(ground, 0.2);
	const double before = path(), volume = sumOf(ground, "volume");
	marchTo(ground, 2.5);
	return (path() - before) * column.spacing / (volume - sumOf(ground, "volume"));
}

void expectSettlement(const std::string& name, const SettlingColumn& column, double seconds, double tolerance = 2e-2)
{
	const Settled r = settle(column, seconds);
	expectRelative(name + ": settlement [m]", r.settlement, handSettlement(column.layers), tolerance);
	expectSmall(name + ": ice left", r.iceLeft, 1e-12);
	expectSmall(name + ": gain of heat less what crossed the surface, over that", r.heatError, 1e-10);
}

/// Thaws two layers one after the other, the one with more ice below or above.
void thawTwoLayers(bool iceRichBelow, double spacing)
{
	citing("Stefan 1891; Aldrich & Paynter 1953");
	std::vector<Layer> layers { { 0.4, 0.3, 2.0 }, { 0.6, 0.7, 3.0 } };
	if (!iceRichBelow) layers = { { 0.4, 0.7, 3.0 }, { 0.6, 0.3, 2.0 } };
	const std::string name   = std::string("V30 Stefan, ice-rich layer ") + (iceRichBelow ? "second" : "first");
	Ground<2>         ground = thawingLayers(layers, spacing, 1.0);
	const double      before = ground.balance().enthalpy;
	for (const double depth : { 0.3, 0.5, 0.8 }) {
		marchTo(ground, stefanTime(layers, depth, 1.0));
		expectRelative(
		        name + ": depth thawed when the front should be at " + std::to_string(depth).substr(0, 3) + " m [m]", thawedDepth(ground), depth, 3e-2);
	}
	const auto b = ground.balance();
	expectSmall(name + ": gain of heat less what crossed the wall, over that", std::abs(b.enthalpy - before - b.heatIn) / b.heatIn, 1e-12);
	const auto water = valuesOf(ground, "waterMass"), ice = valuesOf(ground, "iceMass");
	double     error = 0.0;
	for (const Layer& layer : layers) {
		double liquid = 0.0, expected = 0.0;
		for (std::size_t p = 0; p < water.size(); ++p) {
			if (layers[layerAt(layers, valuesOf(ground, "position", 1)[p])].porosity != layer.porosity) continue;
			liquid += water[p];
			expected += valuesOf(ground, "volume")[p] * layer.porosity * withoutExpansion().ice.density;
		}
		error = std::max(error, std::abs(liquid / expected - 1.0));
	}
	expectSmall(name + ": water of each layer, over its volume of ice, less one (a thousandth never freezes)", error, 2e-4);
}

} // namespace

TEST(Layers, ThawFromRichIntoPoorIceFollowsStefanInLayers) { thawTwoLayers(false, 0.04); }

TEST(Layers, ThawFromRichIntoPoorIceFollowsStefanInLayersOnAFineGrid_slow) { thawTwoLayers(false, 0.025); }

TEST(Layers, ThawFromPoorIntoRichIceFollowsStefanInLayers_slow) { thawTwoLayers(true, 0.025); }

TEST(Layers, EachMaterialFreezesByItsOwnCurve)
{
	auto s      = columnSettings(0.1, 1.0);
	s.materials = materialsOf({ { 0.5, 0.4, 1.0 }, { 0.5, 0.4, 1.0 } });
	s.heat.emplace();
	s.freezing              = makeFreezingCurve();
	s.materials[1].freezing = makeFreezingCurve("exponential", { { "freezingTemperature", -0.5 }, { "width", 1.5 } });
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 0.1, 1.0 }, [](PointInput<2>& p) {
		p.material    = p.position[1] > 0.5;
		p.temperature = -1.0;
	});
	ground.initialise();
	marchTo(ground, 3600.0);
	const auto ice = valuesOf(ground, "iceSaturation"), y = valuesOf(ground, "position", 1);
	for (std::size_t p = 0; p < ice.size(); ++p) {
		const double closed = y[p] > 0.5 ? 0.95 * (1.0 - std::exp(-0.5 / 1.5)) : 0.95 * (1.0 - std::exp(-4.0));
		ASSERT_NEAR(ice[p], closed, 1e-9);
	}
	expectSmall("V31 two curves at -1 degC: change of temperature in an hour [K]", largestSize(valuesOf(ground, "temperature")) - 1.0, 1e-9);
}

// A scene whose materials are all alike is the scene of one material
TEST(Layers, PointsOfEqualMaterialsHaveTheSameBitsAsPointsOfOne)
{
	const auto run = [](int materials) {
		auto s     = columnSettings(0.1, 1.6);
		s.upper[0] = 1.0;
		s.motion.emplace();
		s.motion->gravity = { 0.0, -9.81 };
		s.heat.emplace();
		s.heat->thermalTimeScale = 1e6;
		s.freezing               = makeFreezingCurve();
		s.water.emplace();
		s.skeletons.push_back(silt());
		standOnRollers(s);
		addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), 8.0);
		addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
		SoilMaterial one;
		one.mixture = s.mixture;
		s.materials.assign(materials, one);
		auto ground = std::make_unique<Ground<2>>(s);
		fillBox(*ground, { 0.0, 0.0 }, { 1.0, 1.0 }, [&](PointInput<2>& p) {
			p.temperature = p.position[0] - 0.9;
			if (materials > 1) p.material = int(7919.0 * p.position[0] + 104729.0 * p.position[1]) % materials;
		});
		ground->initialise();
		for (int k = 0; k < 300; ++k)
			ground->step(2e-5);
		return ground;
	};
	const auto none = run(0), one = run(1), three = run(3);
	EXPECT_EQ(differingBytes(copyOf(none->state()), one->state()), 0);
	EXPECT_EQ(none->state().size(), one->state().size());
	EXPECT_EQ(three->state().size(), one->state().size() + 1);
	double differing = 0.0;
	for (const FieldInfo& info : one->fields()) {
		if (info.place != "points") continue;
		for (int c = 0; c < info.components; ++c) {
			const auto a = valuesOf(*one, info.name, c), b = valuesOf(*three, info.name, c);
			for (std::size_t p = 0; p < a.size(); ++p)
				differing += a[p] != b[p];
		}
	}
	expectSmall("V31 three equal materials, dealt at random, 300 steps: values that differ in any bit from those of one", differing, 0.0);
}

// Darcy in series: the same flow through both layers, so that the drop of pressure in each goes with its resistance
TEST(Layers, SteadySeepageAcrossLayersLosesItsHeadByTheirConductivities)
{
	citing("Darcy in series");
	const double      h = 0.05, k[2] = { 1e-3, 2e-4 }, flow = 5e-4, out = 5e3;
	GroundSettings<2> s;
	s.gridSpacing = h;
	s.upper       = { 1.0, h };
	s.materials   = materialsOf({ { 0.5, 0.4, 1.0 }, { 0.5, 0.4, 1.0 } });
	for (const char* side : { "left", "right", "bottom", "top" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
	s.motion.emplace();
	s.motion->localDamping = 0.3;
	s.water.emplace();
	s.water->state.liquidBulkModulus  = 2.2e7;
	s.water->state.cavitationPressure = -1e6;
	for (int m : { 0, 1 }) {
		s.materials[m].permeability                        = Permeability {};
		s.materials[m].permeability->referenceConductivity = k[m];
	}
	s.skeletons.push_back(elasticOedometer(1e8));
	addBoundary<WaterFlux<2>>(s, Region<2>::side("left"), TimeTable({ 0.0, 0.1 }, { 0.0, flow }));
	addBoundary<DrainedBoundary<2>>(s, Region<2>::side("right"), out);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 1.0, h }, [&](PointInput<2>& p) {
		p.material = p.position[0] > 0.5;
		p.pressure = out;
	});
	ground.initialise();
	marchTo(ground, 3.0);
	const auto p = valuesOf(ground, "pressure"), x = valuesOf(ground, "position", 0);
	const auto at = [&](double place) { // mean of the cells on both sides
		double sum = 0.0;
		int    n   = 0;
		for (std::size_t i = 0; i < x.size(); ++i)
			if (std::abs(x[i] - place) < h) sum += p[i], ++n;
		return sum / n;
	};
	const double weight = 1000.0 * Permeability::gravity;
	expectRelative("V32 seepage across two layers: gradient of pressure in the first [Pa/m]", (at(0.1) - at(0.4)) / 0.3, weight * flow / k[0], 3e-2);
	expectRelative("V32 seepage across two layers: gradient of pressure in the second [Pa/m]", (at(0.6) - at(0.9)) / 0.3, weight * flow / k[1], 3e-2);
}

TEST(Layers, DrainedColumnOfIceRichGroundSettlesByItsThawStrain)
{
	citing("hand formula of thaw settlement");
	const std::vector<Layer> uniform { { 1.0, 0.6, 2.0, 0.35 } };
	expectSettlement("V33 thaw settlement, elastic law, thaw strain 0.35", { uniform, elasticOedometer(1e7), false, 1e7, 0.1, 5.0, 2 }, 3.0);
	auto confined     = elasticOedometer(1e7);
	confined->poisson = 0.3;
	expectSettlement("V33 thaw settlement, elastic law that presses aside, thaw strain 0.35", { uniform, confined, false, 1e7, 0.1, 5.0, 2 }, 3.0);
	expectSettlement("V33 thaw settlement, Mohr-Coulomb law, thaw strain 0.35", { uniform, silt(), false, 1e6 }, 20.0);
}

TEST(Layers, OnlyTheIceRichLayerBetweenTwoOthersSettles)
{
	citing("hand formula of thaw settlement");
	const std::vector<Layer> layers { { 0.4, 0.4, 2.0 }, { 0.3, 0.7, 2.0, 0.45 }, { 0.3, 0.4, 2.0 } };
	expectSettlement("V33 thaw settlement, ice-rich layer between two others", { layers, silt(), false, 1e6 }, 20.0);
}

TEST(Layers, WaterOfTheExcessIceLeavesAsTheColumnSettles)
{
	citing("hand formula of thaw settlement");
	SettlingColumn column { { { 1.0, 0.6, 2.0, 0.35 } }, silt(), true, 1e6 };
	expectSettlement("V33 thaw settlement with pore water, Mohr-Coulomb law, thaw strain 0.35", column, 20.0, 6e-2);
}

// One dimension: what a column loses in volume, its surface loses in height
TEST(ThawFront, SurfaceOfThawingGroundSinksByTheVolumeThatTheColumnLoses)
{
	citing("conservation of volume");
	for (const double thawStrain : { 0.03, 0.07 })
		for (const bool water : { false, true }) {
			char label[120];
			std::snprintf(
			        label, sizeof label, "column that thaws from its surface, thaw strain %.2f, %s: path of the surface over loss of volume",
			        thawStrain, water ? "saturated" : "dry");
			expectRelative(label, pathOverLoss({ { { 3.0, 0.4, 1.0, thawStrain } }, silt(), water, 1e6, 0.25, 10.0, 2 }), 1.0, 5e-2);
		}
}
