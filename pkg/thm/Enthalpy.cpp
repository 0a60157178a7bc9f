// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/thm/Enthalpy.hpp>

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace talik {

EnthalpyModel::EnthalpyModel(const MixtureProperties& properties, FreezingCurvePtr curve)
        : formula_ { properties }
        , curve_(curve ? std::move(curve) : unfrozenCurve())
{
	properties.validate();
}

ThermalState EnthalpyModel::stateAt(const SoilContent& soil, double temperature) const
{
	const double sl = curve_->liquidSaturation(temperature);
	const auto   at = formula_.at(soil, temperature, sl, curve_->derivative(temperature));
	return { temperature, sl, at.iceMass, at.heatCapacity, std::isfinite(at.heatCapacity) && temperature > lowestTemperature, at.slope };
}

double EnthalpyModel::enthalpy(const SoilContent& soil, double temperature) const
{
	return formula_.at(soil, temperature, curve_->liquidSaturation(temperature), curve_->derivative(temperature)).enthalpy;
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
