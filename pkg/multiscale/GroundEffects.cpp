// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/GroundEffects.hpp>

namespace yade {
YADE_PLUGIN((GroundMaterial)(HeatTransfer)(FreezingCurve)(PoreWater));

talik::MixtureProperties GroundMaterial::build() const
{
	talik::MixtureProperties m;
	m.solid            = { solidDensity, solidSpecificHeat, solidConductivity, solidExpansivity };
	m.ice              = { iceDensity, iceSpecificHeat, iceConductivity, iceExpansivity };
	m.liquid           = { liquidDensity, liquidSpecificHeat, liquidConductivity, liquidExpansivity };
	m.latentHeat       = latentHeat;
	m.conductivityMean = talik::conductivityMeanFromName(conductivityMean);
	m.validate();
	return m;
}

talik::HeatSettings HeatTransfer::build() const
{
	talik::HeatSettings heat;
	heat.thermalTimeScale = thermalTimeScale;
	heat.source           = source;
	heat.smoothingTime    = smoothingTime;
	heat.enthalpyForm     = talik::enthalpyFormFromName(enthalpyForm);
	heat.latentDensity    = talik::latentDensityFromName(latentDensity);
	return heat;
}

talik::FreezingCurvePtr FreezingCurve::build() const
{
	talik::CurveParameters given;
	const auto             pass = [&](const char* name, Real value) {
                for (const auto& parameter : talik::freezingCurveParameters(curve))
                        if (parameter.name == name && !std::isnan(value)) given[name] = value;
	};
	pass("freezingTemperature", freezingTemperature);
	pass("residualSaturation", residualSaturation);
	pass("width", width);
	pass("lambda", exponent);
	pass("exponent", exponent);
	pass("airEntryPressure", airEntryPressure);
	return talik::makeFreezingCurve(curve, given);
}

talik::WaterSettings PoreWater::build(Real residualSaturation) const
{
	talik::WaterSettings water;
	water.state.liquidBulkModulus           = bulkModulus;
	water.state.iceBulkModulus              = std::isnan(iceBulkModulus) ? 4 * bulkModulus : iceBulkModulus;
	water.state.cavitationPressure          = cavitationPressure;
	water.state.densityChange               = zetaActive;
	if (massCoefficient == "printed") water.state.massCoefficient = talik::MassCoefficient::printed;
	else if (massCoefficient != "exact")
		throw std::invalid_argument("PoreWater.massCoefficient is '" + massCoefficient + "': choose exact or printed.");
	water.permeability.referenceConductivity = conductivity;
	water.permeability.referencePorosity     = referencePorosity;
	water.permeability.law                   = talik::relativeConductivityFromName(relativeConductivity);
	water.permeability.impedance             = impedance;
	water.permeability.residualSaturation    = residualSaturation;
	water.permeability.floor                 = relativeConductivityFloor;
	water.permeability.hydraulicTimeScale    = hydraulicTimeScale;
	water.flipFraction                       = flip;
	return water;
}

} // namespace yade
