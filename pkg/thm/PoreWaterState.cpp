// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/thm/Enthalpy.hpp>
#include <pkg/thm/PoreWaterState.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talik {

void PoreWaterState::validate() const
{
	requireSetting(
	        std::isfinite(liquidBulkModulus) && liquidBulkModulus > 0.0, "PoreWater.bulkModulus", liquidBulkModulus,
	        "must be positive, in Pa (water: 2.2e9)");
	requireSetting(
	        iceBulkModulus > 0.0, "PoreWater.iceBulkModulus", iceBulkModulus, "must be positive, in Pa (ice: 8.8e9; infinity leaves ice storage out)");
	requireSetting(
	        std::isfinite(cavitationPressure) && cavitationPressure <= 0.0 && cavitationPressure > -0.1 * liquidBulkModulus, "PoreWater.cavitationPressure",
	        cavitationPressure, "must be zero or negative and small against bulkModulus, in Pa");
}

double PoreWaterState::waterMass(const MixtureProperties& m, double pressure, double liquidSaturation, double poreVolume, double temperature) const
{
	requireSetting(
	        pressure >= cavitationPressure && pressure < 0.1 * liquidBulkModulus, "initial pore pressure", pressure,
	        "must lie between cavitationPressure and a tenth of bulkModulus, in Pa");
	requireSetting(liquidSaturation >= 0.0 && liquidSaturation <= 1.0, "liquidSaturation", liquidSaturation, "must lie in [0, 1]");
	requireSetting(std::isfinite(poreVolume) && poreVolume > 0.0, "poreVolume", poreVolume, "must be positive, in m^3");
	// each phase takes its unstressed volume, less what the pressure compresses
	const double     liquidPerMass = (1.0 - pressure / liquidBulkModulus) / m.densityAt(m.liquid, temperature);
	const double     icePerMass    = (1.0 - pressure / iceBulkModulus) / poreIceDensity(m, temperature);
	const double     perPores      = poreIceDensity(m, temperature) * (1.0 - liquidSaturation) + m.densityAt(m.liquid, temperature) * liquidSaturation;
	constexpr double fr            = EnthalpyModel::residualWaterFraction;
	const double     ice           = std::min(m.densityAt(m.ice, temperature) * (1.0 - liquidSaturation), (1.0 - fr) * perPores);
	return poreVolume * perPores / ((perPores - ice) * liquidPerMass + ice * icePerMass);
}

PressureCoefficients PoreWaterState::coefficients(const MixtureProperties& m, const PoreState& state) const
{
	const VolumeFractions n             = VolumeFractions::of(state.porosity, state.liquidSaturation);
	const double          iceSaturation = 1.0 - state.liquidSaturation;
	const double          density       = m.densityAt(m.ice, state.temperature);
	const double          perLiquid     = density / m.densityAt(m.liquid, state.temperature);
	// share of its nominal volume that ice occupies, and what that volume gains when the ice melts
	const double fill         = density / poreIceDensity(m, state.temperature);
	const double deficit      = fill - perLiquid;
	const double iceVolume    = fill * n.ice;
	const double liquidVolume = state.porosity - iceVolume;
	const double exact        = 1.0 - deficit * iceSaturation;
	const double undrained    = massCoefficient == MassCoefficient::exact ? exact : 1.0 - deficit * n.ice;
	const double expansivity  = liquidVolume * m.liquid.expansivity + perLiquid * n.ice * m.ice.expansivity + n.solid * exact * m.solid.expansivity;
	return { liquidVolume / liquidBulkModulus + iceVolume / iceBulkModulus, deficit * state.porosity * state.saturationDerivative - expansivity,
		 undrained - liquidVolume, liquidVolume };
}

/// Eq. (7.4), as undrainedModulus().
double skemptonB(const PressureCoefficients& c, double skeletonModulus) { return 1.0 / (1.0 + skeletonModulus * c.storage / c.undrained()); }

double undrainedModulus(const PressureCoefficients& c, double skeletonModulus) { return skeletonModulus + c.undrained() / c.storage; }

double largestWaveSpeed(const MixtureProperties& m, const VolumeFractions& n, const PressureCoefficients& c, double oedometerModulus)
{
	const double solidMass  = n.solid * m.solid.density + n.ice * m.ice.density;
	const double liquidMass = c.liquid * m.liquid.density;
	if (c.liquid <= 0.0) return std::sqrt(oedometerModulus / solidMass);
	const double a     = (oedometerModulus + (1.0 - c.liquid) * c.skeleton / c.storage) / solidMass;
	const double d     = c.liquid * c.liquid / (c.storage * liquidMass);
	const double cross = (1.0 - c.liquid) * c.liquid / (c.storage * solidMass) * (c.liquid * c.skeleton / (c.storage * liquidMass));
	const double half  = 0.5 * (a - d);
	return std::sqrt(0.5 * (a + d) + std::sqrt(half * half + cross));
}

// ---- permeability -------------------------------------------------------------------------------------------------------

void Permeability::validate(const std::string& owner, const std::string& nameOfConductivity) const
{
	const auto inside = [](double value, double low, double high) { return value > low && value < high; };
	requireSetting(inside(referenceConductivity, 0.0, 1e3), owner + nameOfConductivity, referenceConductivity, "must be positive, in m/s (sand: 1e-4)");
	requireSetting(inside(referencePorosity, 0.0, 1.0), owner + "referencePorosity", referencePorosity, "must lie in (0, 1)");
	requireSetting(index == 0.0 || inside(index, 0.01, 100.0), owner + "permeabilityIndex", index, "must be 0 (Kozeny-Carman) or lie between 0.01 and 100");
	requireSetting(impedance >= 0.0 && impedance < 100.0, owner + "impedance", impedance, "must lie in [0, 100), usually 4 to 10");
	requireSetting(
	        inside(hydraulicTimeScale, 1e-12, 1e12), "PoreWater.hydraulicTimeScale", hydraulicTimeScale, "must lie between 1e-12 and 1e12 (1: no scaling)");
}

} // namespace talik
