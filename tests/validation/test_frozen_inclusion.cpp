// SPDX-License-Identifier: GPL-2.0-or-later
// InterFrost TH2: a frozen inclusion in rigid ground, thawed by conduction and by the water that flows around it. The project's own
// curves are not at hand; the reference is a finite volume solution, and what a coarser one differs from it is printed with it.
#include "FrozenInclusion.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

using namespace talik;
using namespace talik::validation;
using reference::FrozenInclusion;
using reference::FrozenInclusionVolumes;

namespace {

constexpr double hour = 3600.0;
/// Conduction and seepage run as many times as fast, so that many hours pass in seconds of waves.
constexpr double accelerated = 2000.0;

/// Ground between its left and right face, without motion unless water flows. Then the skeleton gives way by a thousandth, and
/// storage and inertia of the water stay small against the time of thaw.
GroundSettings<2> channel(const FrozenInclusion& c, double h, double height, double stiffness)
{
	GroundSettings<2> s;
	s.gridSpacing    = h;
	s.upper          = { c.length, height };
	s.mixture        = withoutExpansion();
	s.mixture.solid  = { c.solidDensity, c.solidHeat, c.solidConductivity, 0.0 };
	s.mixture.liquid = { c.waterDensity, c.waterHeat, c.waterConductivity, 0.0 };
	// ice of the volume of its water, so that melting moves none; with the heat that ice of its own density has
	s.mixture.ice        = { c.waterDensity, c.iceHeat * c.iceDensity / c.waterDensity, c.iceConductivity, 0.0 };
	s.mixture.latentHeat = c.latentHeat * c.iceDensity / c.waterDensity;
	s.heat.emplace();
	s.heat->thermalTimeScale = accelerated;
	s.freezing               = makeFreezingCurve("gauss", { { "width", c.width }, { "residualSaturation", c.residual } });
	addBoundary<WallTemperature<2>>(s, Region<2>::side("left"), c.warm);
	if (c.headDifference == 0.0) return s;
	for (const char* side : { "left", "right", "bottom", "top" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
	s.motion.emplace();
	s.skeletons.push_back(elasticOedometer(3.0 * stiffness));
	s.water.emplace();
	s.water->state.liquidBulkModulus            = stiffness;
	s.water->state.iceBulkModulus               = stiffness;
	s.water->state.cavitationPressure           = -1e4;
	s.water->permeability.referenceConductivity = accelerated * c.thawedConductivity();
	s.water->permeability.referencePorosity     = c.porosity;
	s.water->permeability.impedance             = c.impedance * c.porosity;
	s.water->hydraulicTimeScale                 = 1.0;
	s.water->largestConductivity                = INFINITY; // accelerated beyond what pressure at rest needs: water shall carry its heat
	addBoundary<DrainedBoundary<2>>(s, Region<2>::side("left"), c.waterDensity * c.gravity * c.headDifference);
	addBoundary<DrainedBoundary<2>>(s, Region<2>::side("right"), 0.0);
	return s;
}

double darcyFlux(const FrozenInclusion& c) { return c.thawedConductivity() * c.headDifference / c.length; }

/// Ground at the temperatures of the function, water flowing as it would without ice.
Ground<2> started(const FrozenInclusion& c, const GroundSettings<2>& s, const std::function<double(double, double)>& temperature)
{
	Ground<2> ground(s);
	fillBox(ground, s.lower, s.upper, [&](PointInput<2>& p) {
		p.porosity    = c.porosity;
		p.temperature = temperature(p.position[0], p.position[1]);
		p.pressure    = c.waterDensity * c.gravity * c.headDifference * (1.0 - p.position[0] / c.length);
	});
	ground.initialise();
	if (s.water) std::fill_n(ground.points().fields().find("liquidVelocity", 0), ground.points().count(), accelerated * darcyFlux(c) / c.porosity);
	return ground;
}

/// What the project measures, every half hour: part of the channel's pores that is ice, and the lowest temperature [degC].
struct Melting {
	std::vector<double> ice, lowest;
	double              gone(double end) const ///< when the last ice is [h]
	{
		for (std::size_t k = 0; k < lowest.size(); ++k)
			if (lowest[k] > 0.0) return 0.5 * (k + 1);
		return end;
	}
};

/// Lower half of the channel, as many cells over it.
Melting melted(const FrozenInclusion& c, int cells, double end)
{
	const auto s      = channel(c, 0.5 * c.height / cells, 0.5 * c.height, 1.5e5);
	Ground<2>  ground = started(c, s, [&](double x, double y) { return c.frozenAtStart(x, y) ? c.cold : c.warm; });
	Melting    result;
	for (double hours = 0.5; hours <= end; hours += 0.5) {
		marchTo(ground, hours * hour / accelerated);
		const auto ice = valuesOf(ground, "iceSaturation"), volume = valuesOf(ground, "volume"), t = valuesOf(ground, "temperature");
		double     frozen = 0.0;
		for (std::size_t p = 0; p < ice.size(); ++p)
			frozen += ice[p] * volume[p];
		result.ice.push_back(frozen / (0.5 * c.length * c.height));
		result.lowest.push_back(*std::min_element(t.begin(), t.end()));
	}
	if (s.motion)
		expectSmall(
		        "InterFrost TH2, with flow: largest displacement of the skeleton over h", largestSize(valuesOf(ground, "displacement")) / s.gridSpacing,
		        5e-2);
	return result;
}

Melting meltedInVolumes(const FrozenInclusion& c, int cells, double end)
{
	FrozenInclusionVolumes volumes(c, cells);
	Melting                result;
	for (double hours = 0.5; hours <= end; hours += 0.5) {
		volumes.marchTo(hours * hour);
		result.ice.push_back(1.0 - volumes.liquidVolume() / (c.porosity * c.length * c.height));
		result.lowest.push_back(volumes.lowestTemperature());
	}
	return result;
}

double largestDifference(const std::vector<double>& a, const std::vector<double>& b)
{
	double largest = 0.0;
	for (std::size_t k = 0; k < a.size(); ++k)
		largest = std::max(largest, std::abs(a[k] - b[k]));
	return largest;
}

/// Ice at the start over the pores of the channel.
double iceAtStart(const FrozenInclusion& c) { return c.side * c.side * (1.0 - c.saturation(c.cold)) / (c.length * c.height); }

void draw(Drawing& ice, Drawing& lowest, const std::string& series, const Melting& computed)
{
	for (std::size_t k = 0; k < computed.ice.size(); ++k) {
		ice.computed(series, 0.5 * (k + 1), 1e2 * computed.ice[k]);
		lowest.computed(series, 0.5 * (k + 1), computed.lowest[k]);
	}
}

void drawReference(Drawing& ice, Drawing& lowest, const Melting& exact)
{
	for (std::size_t k = 0; k < exact.ice.size(); ++k) {
		ice.reference("finite volumes", 0.5 * (k + 1), 1e2 * exact.ice[k]);
		lowest.reference("finite volumes", 0.5 * (k + 1), exact.lowest[k]);
	}
}

} // namespace

// Ice and ground 10 K warmer stand side by side at the start: what one spacing cannot tell apart is a twentieth of it, for good.
TEST(FrozenInclusion, WithoutFlowIsThawedByConductionInTheTimeOfTheFiniteVolumes)
{
	citing("finite volumes");
	FrozenInclusion c;
	c.headDifference           = 0.0;
	const double      end      = 36.0;
	const Melting     computed = melted(c, 15, end), exact = meltedInVolumes(c, 30, end), coarse = meltedInVolumes(c, 15, end);
	const std::string name = "InterFrost TH2, no flow: ";
	Drawing           ice("interfrost_th2_0", "InterFrost TH2 without flow", "time [h]", "part of the pores with ice [1e-2]");
	Drawing           lowest("interfrost_th2_0_lowest", "InterFrost TH2 without flow", "time [h]", "lowest temperature [degC]");
	draw(ice, lowest, "h = a tenth of the inclusion", computed);
	drawReference(ice, lowest, exact);
	expectSmall(name + "ice off the reference at any time, over that at the start", largestDifference(computed.ice, exact.ice) / iceAtStart(c), 3e-2);
	expectSmall(name + "reference with half the cells off it", largestDifference(coarse.ice, exact.ice) / iceAtStart(c), 2e-2);
	double temperature = 0.0;
	for (std::size_t k = 1; k < exact.lowest.size() && exact.lowest[k] < 0.0; ++k)
		temperature = std::max(temperature, std::abs(computed.lowest[k] - exact.lowest[k]));
	expectSmall(name + "lowest temperature while there is ice, off the reference over 10 K", temperature / (c.warm - c.cold), 2e-2);
	expectRelative(name + "time until the last ice is gone [h]", computed.gone(end), exact.gone(end), 3e-2);
}

// Drags add at a node, so that it lets water pass as its points in series do: right for flow through a front, but flow along ice sees it
// wider, by as much as shape functions reach (with conductivities added instead, six cells across the inclusion miss 5 % after 12 h, not
// 13 %). That error falls with h and is the largest of the validation; two grids tell where it goes to. The water's inertia, accelerated as
// the rest is, holds 1 % of the ice.
TEST(FrozenInclusion, InFlowingWaterIsThawedInTheTimeOfTheFiniteVolumesAsTheGridIsRefined_slow)
{
	citing("finite volumes");
	const FrozenInclusion c;
	const double          end = 28.0;
	const Melting coarse = melted(c, 9, end), fine = melted(c, 15, end), exact = meltedInVolumes(c, 30, end), coarseExact = meltedInVolumes(c, 15, end);
	Melting       limit = fine;
	for (std::size_t k = 0; k < limit.ice.size(); ++k)
		limit.ice[k] = std::max(0.0, fine.ice[k] + 1.5 * (fine.ice[k] - coarse.ice[k]));
	const std::string name = "InterFrost TH2, head gradient 3 %: ";
	Drawing           ice("interfrost_th2_3", "InterFrost TH2, head gradient 3 %", "time [h]", "part of the pores with ice [1e-2]");
	Drawing           lowest("interfrost_th2_3_lowest", "InterFrost TH2, head gradient 3 %", "time [h]", "lowest temperature [degC]");
	draw(ice, lowest, "h = a sixth of the inclusion", coarse);
	draw(ice, lowest, "h = a tenth of the inclusion", fine);
	drawReference(ice, lowest, exact);
	const double start = iceAtStart(c);
	expectSmall(name + "reference with half the cells off it", largestDifference(coarseExact.ice, exact.ice) / start, 2e-2);
	expectSmall(
	        name + "ice off the reference at any time, over that at the start, h = a sixth of the inclusion",
	        largestDifference(coarse.ice, exact.ice) / start, 0.2);
	expectSmall(name + "the same, h = a tenth", largestDifference(fine.ice, exact.ice) / start, 0.15);
	expectSmall(name + "the same, extrapolated to h = 0", largestDifference(limit.ice, exact.ice) / start, 8e-2);
	expectRelative(
	        name + "time until the last ice is gone [h], extrapolated to h = 0", fine.gone(end) + 1.5 * (fine.gone(end) - coarse.gone(end)),
	        exact.gone(end), 0.1);
}

TEST(FrozenInclusion, HeatCarriedAndConductedIntoThawedGroundFollowsOgataAndBanks)
{
	citing("Ogata & Banks 1961");
	FrozenInclusion c;
	c.headDifference      = 0.15 * c.length;
	auto s                = channel(c, 1.0 / 30.0, 1.0 / 30.0, 2e6);
	s.freezing            = nullptr;
	Ground<2>    ground   = started(c, s, [](double, double) { return 0.0; });
	const double capacity = c.enthalpy(0.0)[1], diffusivity = c.conductivity(0.0) / capacity;
	const double speed = darcyFlux(c) * c.waterDensity * c.waterHeat / capacity;
	Drawing      drawing("ogata_banks", "Heat carried into ground by seepage of 0.4 m/h", "distance [m]", "temperature [degC]");
	for (const double hours : { 0.5, 1.0, 2.0 }) {
		const double t = hours * hour;
		marchTo(ground, t / accelerated);
		const auto exact = [&](double x) {
			const double spread = 2.0 * std::sqrt(diffusivity * t);
			return 0.5 * c.warm * (std::erfc((x - speed * t) / spread) + std::exp(speed * x / diffusivity) * std::erfc((x + speed * t) / spread));
		};
		const auto x = valuesOf(ground, "position", 0), temperature = valuesOf(ground, "temperature");
		double     sum = 0.0;
		char       label[32];
		std::snprintf(label, sizeof label, "%.1f h", hours);
		for (std::size_t p = 0; p < x.size(); ++p) {
			sum += std::pow(temperature[p] - exact(x[p]), 2) / x.size();
			if (p % 4 == 0) drawing.computed(label, x[p], temperature[p]);
		}
		drawing.reference(label, 0.0, c.length, exact);
		expectSmall(std::string("heat carried by seepage: rms error over the jump, ") + label, std::sqrt(sum) / c.warm, 1.5e-2);
	}
}
