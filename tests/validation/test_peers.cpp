// SPDX-License-Identifier: GPL-2.0-or-later
// Columns of 1 m on 20 cells in which another public code was measured, see examples/peers.md. References here use no code of pkg/mpm.
#include "FrozenInclusion.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

using namespace talik;
using namespace talik::validation;
using reference::FrozenInclusion;

namespace {

constexpr double height = 1.0, spacing = height / 20.0, porosity = 0.4;

/// Soil of Yu & Zhao, whose ice has the volume of its water.
FrozenInclusion soil()
{
	FrozenInclusion c;
	c.porosity          = porosity;
	c.solidHeat         = 800.0;
	c.solidConductivity = 1.0;
	c.iceConductivity   = 2.2;
	c.waterHeat         = 4200.0;
	c.iceDensity        = 910.0;
	return c;
}

GroundSettings<2> rigidColumn(const FrozenInclusion& c)
{
	auto s               = columnSettings(spacing, height);
	s.mixture.solid      = { c.solidDensity, c.solidHeat, c.solidConductivity, 0.0 };
	s.mixture.liquid     = { c.waterDensity, c.waterHeat, c.waterConductivity, 0.0 };
	s.mixture.ice        = { c.waterDensity, c.iceHeat * c.iceDensity / c.waterDensity, c.iceConductivity, 0.0 };
	s.mixture.latentHeat = c.latentHeat * c.iceDensity / c.waterDensity;
	s.heat.emplace();
	s.freezing = makeFreezingCurve("gauss", { { "width", c.width }, { "residualSaturation", c.residual } });
	return s;
}

/// Conduction along a column, its upper face at `warm`, its lower one insulated: finite volumes, explicit in time.
class Column {
public:
	Column(const FrozenInclusion& c, int cells)
	        : c_(c)
	        , h_(height / cells)
	        , temperature_(cells, c.cold)
	        , enthalpy_(cells, c.enthalpy(c.cold)[0])
	        , flux_(cells + 1, 0.0)
	{
		step_ = 0.4 * h_ * h_ * c.enthalpy(1.0)[1] / std::max(c.conductivity(1.0), c.conductivity(c.cold));
	}
	void marchTo(double instant)
	{
		for (; time_ < instant; time_ += step_) {
			const int n = int(temperature_.size());
			for (int k = 1; k < n; ++k) {
				const double a = c_.conductivity(temperature_[k - 1]), b = c_.conductivity(temperature_[k]);
				flux_[k] = 2.0 * a * b / (a + b) * (temperature_[k - 1] - temperature_[k]) / h_;
			}
			flux_[n] = c_.conductivity(c_.warm) * (temperature_[n - 1] - c_.warm) / (0.5 * h_);
			for (int k = 0; k < n; ++k) {
				enthalpy_[k] += step_ / h_ * (flux_[k] - flux_[k + 1]);
				temperature_[k] = c_.temperature(enthalpy_[k], temperature_[k]);
			}
		}
	}
	/// Depth of ground as rich in water as what has melted [m].
	double thawedDepth() const
	{
		double melted = 0.0;
		for (const double t : temperature_)
			melted += (c_.saturation(t) - c_.saturation(c_.cold)) * h_;
		return melted / (1.0 - c_.saturation(c_.cold));
	}

private:
	FrozenInclusion     c_;
	double              h_, step_ = 0.0, time_ = 0.0;
	std::vector<double> temperature_, enthalpy_, flux_;
};

} // namespace

TEST(Peers, AColumnThatThawsFromItsTopHasTheFrontOfTheFiniteVolumes)
{
	citing("finite volumes on 160 cells");
	auto c = soil();
	c.cold = -5.0, c.warm = 10.0;
	auto s = rigidColumn(c);
	addBoundary<WallTemperature<2>>(s, Region<2>::side("top"), c.warm);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { spacing, height }, [&](PointInput<2>& p) {
		p.porosity    = porosity;
		p.temperature = c.cold;
	});
	ground.initialise();
	Column       exact(c, 160);
	const double iceAtStart = 1.0 - c.saturation(c.cold);
	for (const double days : { 5.0, 15.0 }) {
		marchTo(ground, 86400.0 * days);
		exact.marchTo(86400.0 * days);
		double ice = 0.0;
		for (const double saturation : valuesOf(ground, "iceSaturation"))
			ice += saturation / ground.points().count();
		expectScaled(
		        "thawing column of 20 cells: depth of thaw after " + std::to_string(int(days)) + " days [m]", height * (1.0 - ice / iceAtStart),
		        exact.thawedDepth(), exact.thawedDepth(), 1e-2);
	}
}

TEST(Peers, AFrozenAndAThawedHalfMixToTheTemperatureOfTheirHeat)
{
	citing("calorimetry");
	auto c = soil();
	c.cold = -5.0, c.warm = 10.0;
	Ground<2> ground(rigidColumn(c));
	fillBox(ground, { 0.0, 0.0 }, { spacing, height }, [&](PointInput<2>& p) {
		p.porosity    = porosity;
		p.temperature = p.position[1] < 0.5 * height ? c.cold : c.warm;
	});
	ground.initialise();
	const double before = ground.balance().enthalpy;
	marchTo(ground, 86400.0 * 1000.0);
	const double latent = height * spacing * porosity * c.iceDensity * c.latentHeat;
	expectSmall("halves that mix: heat from nowhere over the latent heat of all water", (ground.balance().enthalpy - before) / latent, 1e-12);
	const double mixed = c.temperature(0.5 * (c.enthalpy(c.cold)[0] + c.enthalpy(c.warm)[0]), -0.1);
	for (const bool low : { true, false }) {
		const auto all = valuesOf(ground, "temperature");
		expectScaled(
		        std::string("halves that mix: ") + (low ? "lowest" : "highest") + " temperature after 1000 days [degC]",
		        low ? *std::min_element(all.begin(), all.end()) : *std::max_element(all.begin(), all.end()), mixed, 15.0, 1e-3);
	}
}

TEST(Peers, ASoftDryColumnBearsItsWeightAtEveryPoint)
{
	citing("weight");
	auto s = columnSettings(spacing, height);
	standOnRollers(s);
	s.motion.emplace();
	s.motion->gravity      = { 0.0, -9.81 };
	s.motion->localDamping = 0.3;
	s.skeletons.push_back(elasticOedometer(1e5));
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { spacing, height }, [](PointInput<2>& p) { p.porosity = porosity; });
	ground.initialise();
	marchTo(ground, 6.0);
	const auto   y = valuesOf(ground, "position", 1), stress = valuesOf(ground, "stress", 1), mass = valuesOf(ground, "mass");
	const double weight = sumOf(ground, "mass") * 9.81 / spacing;
	double       square = 0.0, largest = 0.0;
	for (std::size_t p = 0; p < y.size(); ++p) {
		double above = -0.5 * mass[p];
		for (std::size_t q = 0; q < y.size(); ++q)
			above += y[q] > y[p] - 1e-9 ? mass[q] : 0.0;
		above -= 0.5 * mass[p]; // its neighbour in the row counts by half, too
		const double off = (stress[p] + 9.81 * above / spacing) / weight;
		square += off * off / y.size();
		largest = std::max(largest, std::abs(off));
	}
	std::printf(
	        "soft dry column: the top sinks by %.3f m, stress is off by up to %.4f of the weight\n", height - *std::max_element(y.begin(), y.end()),
	        largest);
	expectSmall("soft dry column that is compressed by a twelfth: rms error of the stress over the weight", std::sqrt(square), 2e-2);
}
