// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/thm/Enthalpy.hpp>

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace talik {

EnthalpyForm enthalpyFormFromName(const std::string& name)
{
	return static_cast<EnthalpyForm>(placeOfName("HeatTransfer.enthalpyForm", name, { "stateFunction", "capacityIntegral" }));
}

LatentDensity latentDensityFromName(const std::string& name)
{
	return static_cast<LatentDensity>(placeOfName("HeatTransfer.latentDensity", name, { "ice", "liquid" }));
}

EnthalpyModel::EnthalpyModel(const MixtureProperties& properties, FreezingCurvePtr curve, EnthalpyForm form, LatentDensity latentDensity)
        : curve_(curve ? std::move(curve) : unfrozenCurve())
        , latentDensity_(latentDensity)
{
	properties.validate();
	const bool   asPrinted = latentDensity == LatentDensity::liquid;
	const double excess    = asPrinted ? properties.liquid.density / properties.ice.density : 1.0;
	const double latent    = properties.latentHeat * excess;
	formula_               = {
		              properties, form, latent, properties.ice.density * latent, curve_->freezingTemperature(), curve_->integral(properties.referenceTemperature), {}
	};
}

void EnthalpyModel::setTolerance(double tolerance)
{
	requireSetting(tolerance > 0.0 && tolerance <= 1e-6, "enthalpyTolerance", tolerance, "must lie in (0, 1e-6]; 1e-12 is the default");
	tolerance_ = tolerance;
}

ThermalState EnthalpyModel::stateAt(const SoilContent& soil, double temperature) const
{
	const double sl = curve_->liquidSaturation(temperature);
	const auto   at = formula_.at(soil, temperature, sl, curve_->derivative(temperature), 0.0);
	return { temperature, sl, at.iceMass, at.heatCapacity, std::isfinite(at.heatCapacity) && temperature > lowestTemperature, at.slope };
}

double EnthalpyModel::enthalpy(const SoilContent& soil, double temperature) const
{
	const double integral = curve_->integral(temperature) - formula_.integralAtReference;
	return formula_.at(soil, temperature, curve_->liquidSaturation(temperature), curve_->derivative(temperature), integral).enthalpy;
}

double EnthalpyModel::apparentCapacity(const SoilContent& soil, double temperature) const
{
	return formula_.at(soil, temperature, curve_->liquidSaturation(temperature), curve_->derivative(temperature), 0.0).slope;
}

ThermalState EnthalpyModel::solve(const SoilContent& soil, double enthalpy, double guess) const
{
	ThermalState        state { guess, 1.0, 0.0, 0.0, true, 0.0 };
	const EnthalpyBatch one { 1,
		                  &enthalpy,
		                  &soil.solidMass,
		                  &soil.waterMass,
		                  &soil.poreVolume,
		                  &state.temperature,
		                  &state.liquidSaturation,
		                  &state.iceMass,
		                  &state.heatCapacity,
		                  &state.apparentCapacity };
	if (temperatures(one) == 1) return state;
	std::ostringstream text;
	text << "enthalpy = " << enthalpy << " J of a point with " << soil.solidMass << " kg of grains and " << soil.waterMass
	     << " kg of water: no temperature above " << lowestTemperature << " degC belongs to it; reduce the time step or check the heat sources";
	throw std::runtime_error(text.str());
}

} // namespace talik
