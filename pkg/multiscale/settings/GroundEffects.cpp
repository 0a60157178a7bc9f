// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/base/Errors.hpp>
#include <pkg/multiscale/settings/GroundEffects.hpp>
#include <pkg/python/ScriptValues.hpp>

#include <tuple>

namespace yade {
YADE_PLUGIN((GroundMaterial)(HeatTransfer)(FreezingCurve)(ThawFront)(PoreWater)(IceSegregation));

talik::MixtureProperties GroundMaterial::build() const
{
	talik::MixtureProperties m;
	m.solid            = { solidDensity, solidSpecificHeat, solidConductivity, solidExpansivity };
	m.ice              = { iceDensity, m.ice.specificHeat, iceConductivity, iceExpansivity };
	m.liquid           = { liquidDensity, m.liquid.specificHeat, liquidConductivity, liquidExpansivity };
	m.latentHeat       = latentHeat;
	m.conductivityMean = talik::conductivityMeanFromName(conductivityMean);
	m.validate();
	return m;
}

bool GroundMaterial::isOwnSoil() const
{
	const bool settles = thawStrain != 0 || compressibility != 0 || compressionIndex != 0;
	return freezing || segregation || settles || hasOwnSeepage();
}

bool GroundMaterial::hasOwnSeepage() const
{
	return permeabilityIndex != 0 || !std::isnan(hydraulicConductivity) || !std::isnan(referencePorosity) || !std::isnan(impedance);
}

talik::SoilMaterial GroundMaterial::soil(const FreezingCurve* ofScene, const PoreWater* water) const
{
	const auto require = [](bool valid, const char* attribute, Real value, const char* remedy) {
		talik::requireSetting(valid, string("GroundMaterial.") + attribute, value, remedy);
	};
	talik::SoilMaterial s;
	s.mixture    = build();
	s.thawStrain = thawStrain;
	require(thawStrain >= 0 && thawStrain < 1, "thawStrain", thawStrain, "must lie between 0 and below 1");
	s.compression = { compressibility, compressionIndex, referenceStress };
	s.compression.validate("GroundMaterial.");
	if (freezing && !ofScene)
		throw std::invalid_argument("GroundMaterial.freezing is set but MpmEngine.freezing is None: add freezing=FreezingCurve() or leave it out.");
	if (freezing) s.freezing = freezing->build();
	if (segregation) s.segregation = segregation->build();
	if (hasOwnSeepage() && !water)
		throw std::invalid_argument(
		        "GroundMaterial.hydraulicConductivity, referencePorosity, permeabilityIndex or impedance is set but MpmEngine.water is "
		        "None: add water=PoreWater() or leave it out.");
	if (!water) return s;
	talik::Permeability& k = s.permeability.emplace(water->build().permeability);
	if (!std::isnan(hydraulicConductivity)) k.referenceConductivity = hydraulicConductivity;
	if (!std::isnan(referencePorosity)) k.referencePorosity = referencePorosity;
	if (!std::isnan(impedance)) k.impedance = impedance;
	k.index = permeabilityIndex;
	k.validate("GroundMaterial.", "hydraulicConductivity");
	return s;
}

talik::SegregationSettings IceSegregation::build() const
{
	talik::SegregationSettings s;
	TALIK_TAKE(s, *this, TALIK_ICE_SEGREGATION)
	s.validate("IceSegregation.");
	return s;
}

talik::HeatSettings HeatTransfer::build() const
{
	talik::HeatSettings heat;
	TALIK_TAKE(heat, *this, TALIK_HEAT_TRANSFER)
	return heat;
}

Real FreezingCurve::residual() const { return curve == "table" && !liquidSaturations.empty() ? liquidSaturations.front() : residualSaturation; }

void FreezingCurve::requireLiquid(const string& whose) const
{
	if (residual() >= 0.01) return;
	throw std::invalid_argument(
	        string("FreezingCurve.") + (curve == "table" ? "liquidSaturations[0]" : "residualSaturation") + whose + " is " + std::to_string(residual())
	        + ": give 0.01 to below 1 in a scene with water, whose ground is never quite solid.");
}

/// The curve through measured points.
talik::FreezingCurvePtr FreezingCurve::ofTable() const
{
	if (temperatures.size() != liquidSaturations.size())
		throw std::invalid_argument(
		        "FreezingCurve.temperatures has " + std::to_string(temperatures.size()) + " values and FreezingCurve.liquidSaturations "
		        + std::to_string(liquidSaturations.size()) + ": give as many of each");
	for (const auto& [attribute, value, byDefault] : { std::tuple("width", width, NaN),
	                                                   { "exponent", exponent, NaN },
	                                                   { "airEntryPressure", airEntryPressure, NaN },
	                                                   { "freezingTemperature", freezingTemperature, 0. },
	                                                   { "residualSaturation", residualSaturation, 0.05 } })
		if (value != byDefault && !std::isnan(value))
			throw std::invalid_argument(
			        string("FreezingCurve.") + attribute + " = " + talik::asText(value) + ": the points of the curve table say it; leave it out");
	std::vector<talik::CurvePoint> points;
	for (std::size_t k = 0; k < temperatures.size(); ++k)
		points.push_back({ temperatures[k], liquidSaturations[k] });
	return talik::makeFreezingCurve(points);
}

talik::FreezingCurvePtr FreezingCurve::build() const
{
	if (curve == "table") return ofTable();
	if (!temperatures.empty() || !liquidSaturations.empty())
		throw std::invalid_argument(
		        "FreezingCurve.temperatures and liquidSaturations are those of the curve table, but FreezingCurve.curve = '" + curve
		        + "': write curve='table', or leave them out");
	talik::CurveParameters given { { "freezingTemperature", freezingTemperature }, { "residualSaturation", residualSaturation } };
	const auto             pass = [&](const string& attribute, Real value) {
                if (std::isnan(value)) return;
                if (attribute == "width" && curve == "linear") { // whose parameter is the end of that width
                        if (!(value >= 1e-9 && value < 100))
                                throw std::invalid_argument(
				                    "FreezingCurve.width = " + talik::asText(value)
				                    + ": must be positive and below 100, in K (for a jump choose the curve sharp)");
                        given["frozenTemperature"] = freezingTemperature - value;
                        return;
                }
                if (!talik::freezingCurveParameters(curve).count(attribute))
                        throw std::invalid_argument(
			                    "FreezingCurve." + attribute + " = " + talik::asText(value) + ": the curve " + curve + " has none; leave it out");
                given[attribute] = value;
	};
	pass("width", width);
	pass("exponent", exponent);
	pass("airEntryPressure", airEntryPressure);
	return talik::makeFreezingCurve(curve, given);
}

talik::WaterSettings PoreWater::build() const
{
	talik::WaterSettings water;
	water.implicit = pressure == "implicit";
	if (!water.implicit && pressure != "explicit") throw std::invalid_argument("PoreWater.pressure is '" + pressure + "': choose explicit or implicit.");
	constexpr Real numerical = 2.2e7, natural = 2.2e9; // of water [Pa]
	water.state.liquidBulkModulus  = std::isnan(bulkModulus) ? (water.implicit ? natural : numerical) : bulkModulus;
	water.state.iceBulkModulus     = std::isnan(iceBulkModulus) ? 4 * water.state.liquidBulkModulus : iceBulkModulus;
	water.state.cavitationPressure = cavitationPressure;
	water.state.densityChange      = zetaActive;
	if (massCoefficient == "printed") water.state.massCoefficient = talik::MassCoefficient::printed;
	else if (massCoefficient != "exact") throw std::invalid_argument("PoreWater.massCoefficient is '" + massCoefficient + "': choose exact or printed.");
	water.permeability.referenceConductivity = conductivity;
	water.permeability.referencePorosity     = referencePorosity;
	water.permeability.impedance             = impedance;
	water.hydraulicTimeScale                 = hydraulicTimeScale;
	if (!std::isnan(hydraulicTimeScale)) water.permeability.hydraulicTimeScale = hydraulicTimeScale; // for its check
	water.picTime = picTime;
	talik::requireSetting(!(picTime < 0), "PoreWater.picTime", picTime, "must not be negative, in s; inf: none dies out, nan: chosen");
	water.state.validate();
	water.permeability.validate();
	water.permeability.hydraulicTimeScale = 1;
	return water;
}

} // namespace yade
