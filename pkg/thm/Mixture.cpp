// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/thm/Mixture.hpp>

#include <cmath>

namespace talik {

namespace {

	/// name: as the attributes of GroundMaterial begin.
	void validatePhase(const Phase& phase, const std::string& name)
	{
		const auto positive = [&](double value, const char* attribute, const char* unit) {
			requireSetting(
			        std::isfinite(value) && value > 0.0, "GroundMaterial." + name + attribute, value, std::string("must be positive, in ") + unit);
		};
		positive(phase.density, "Density", "kg/m^3");
		positive(phase.specificHeat, "SpecificHeat", "J/(kg K)");
		positive(phase.conductivity, "Conductivity", "W/(m K)");
		requireSetting(
		        std::abs(phase.expansivity) < 1e-2, "GroundMaterial." + name + "Expansivity", phase.expansivity,
		        "must be a volumetric expansivity below 1e-2 in size, in 1/K");
	}

} // namespace

ConductivityMean conductivityMeanFromName(const std::string& name)
{
	return static_cast<ConductivityMean>(placeOfName("GroundMaterial.conductivityMean", name, { "arithmetic", "geometric", "harmonic" }));
}

/// Eq. (3.2).
double MixtureProperties::conductivity(const VolumeFractions& n) const
{
	switch (conductivityMean) {
		case ConductivityMean::geometric:
			return std::exp(
			        n.solid * std::log(solid.conductivity) + n.ice * std::log(ice.conductivity) + n.liquid * std::log(liquid.conductivity)
			        + n.air * std::log(airConductivity));
		case ConductivityMean::harmonic:
			return 1.0 / (n.solid / solid.conductivity + n.ice / ice.conductivity + n.liquid / liquid.conductivity + n.air / airConductivity);
		case ConductivityMean::arithmetic: break;
	}
	return arithmeticConductivity(n);
}

/// Eq. (3.3).
double MixtureProperties::expansivity(double porosity, double liquidSaturation, double temperature) const
{
	const VolumeFractions n    = VolumeFractions::of(porosity, liquidSaturation);
	const double          zeta = densityDeficit(temperature);
	return n.liquid * liquid.expansivity + (1.0 - zeta) * n.ice * ice.expansivity + n.solid * (1.0 - zeta * (1.0 - liquidSaturation)) * solid.expansivity;
}

void MixtureProperties::validate() const
{
	validatePhase(solid, "solid");
	validatePhase(ice, "ice");
	validatePhase(liquid, "liquid");
	requireSetting(ice.density <= liquid.density, "GroundMaterial.iceDensity", ice.density, "must not exceed liquidDensity");
	requireSetting(
	        ice.specificHeat <= liquid.specificHeat, "GroundMaterial.iceSpecificHeat", ice.specificHeat,
	        "must not exceed liquidSpecificHeat, or H(T) is not monotone");
	requireSetting(std::isfinite(latentHeat) && latentHeat > 0.0, "GroundMaterial.latentHeat", latentHeat, "must be positive, in J/kg (water: 334e3)");
	requireSetting(
	        std::isfinite(referenceTemperature) && std::abs(referenceTemperature) < 100.0, "referenceTemperature", referenceTemperature,
	        "must be a temperature in degC near the melting point (0)");
}

} // namespace talik
