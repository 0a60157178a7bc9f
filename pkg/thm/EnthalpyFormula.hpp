// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/thm/Mixture.hpp>

#include <algorithm>

namespace talik {

/// Form of H(T). stateFunction: masses times specific enthalpies, conserves energy under strain, seepage and phase change.
/// capacityIntegral: integral of the volumetric capacity plus n V rho L_f S_l, which is Yu & Zhao eq. (4) read literally; it
/// knows no enthalpy of moving water and is meant for rigid ground and comparison.
enum class EnthalpyForm { stateFunction, capacityIntegral };

/// What does not depend on temperature in the enthalpy of one material point.
struct SoilContent {
	double solidMass;  ///< m_s [kg], > 0
	double waterMass;  ///< m_w = ice + liquid [kg], >= 0
	double poreVolume; ///< V_pore [m^3], > 0
};

/// H of saturated ground where temperature and liquid saturation are known, with its slope. A plain value, so that loops over
/// points can hold a copy that no store to a field may change.
struct EnthalpyFormula {
	/// Fraction f_r of the water mass that never becomes ice [-].
	static constexpr double residualWaterFraction = 1e-3;

	MixtureProperties properties;
	EnthalpyForm      form;
	double            latentHeat;          ///< L_f of the state-function form [J/kg]
	double            latentPerPoreVolume; ///< rho L_f of the capacity-integral form [J/m^3]
	double            freezingTemperature; ///< T_f [degC]
	double            integralAtReference; ///< integral of S_l from T_f to T_0 [K]

	struct Value {
		double enthalpy;     ///< H [J]
		double slope;        ///< dH/dT [J/K]
		double iceMass;      ///< [kg]
		double heatCapacity; ///< at fixed phase masses [J/K]
	};

	/// sl, dsl: S_l and dS_l/dT at temperature; integralOfSl: from T_0 to temperature, for the capacity-integral form only.
	template <EnthalpyForm Form> Value at(const SoilContent& soil, double temperature, double sl, double dsl, double integralOfSl) const
	{
		const Phase &ice = properties.ice, &liquid = properties.liquid;
		const double theta         = temperature - properties.referenceTemperature;
		const Ice    frozen        = iceAt(soil, temperature, sl, dsl);
		const double solidCapacity = soil.solidMass * properties.solid.specificHeat;
		if constexpr (Form == EnthalpyForm::stateFunction) {
			const double difference = liquid.specificHeat - ice.specificHeat;
			const double capacity   = solidCapacity + soil.waterMass * liquid.specificHeat - difference * frozen.mass;
			const double enthalpy   = capacity * theta + (soil.waterMass - frozen.mass) * latentHeat;
			return { enthalpy, capacity - frozen.slope * (latentHeat + difference * theta), frozen.mass, capacity };
		}
		const double iceCapacity    = ice.density * ice.specificHeat;
		const double liquidCapacity = liquid.density * liquid.specificHeat;
		const double capacity       = solidCapacity + soil.poreVolume * ((1.0 - sl) * iceCapacity + sl * liquidCapacity);
		const double enthalpy       = solidCapacity * theta
		        + soil.poreVolume * (iceCapacity * (theta - integralOfSl) + liquidCapacity * integralOfSl + latentPerPoreVolume * sl);
		return { enthalpy, capacity + soil.poreVolume * latentPerPoreVolume * dsl, frozen.mass, capacity };
	}
	Value at(const SoilContent& soil, double temperature, double sl, double dsl, double integralOfSl) const
	{
		return form == EnthalpyForm::stateFunction ? at<EnthalpyForm::stateFunction>(soil, temperature, sl, dsl, integralOfSl)
		                                           : at<EnthalpyForm::capacityIntegral>(soil, temperature, sl, dsl, integralOfSl);
	}

	double thawedCapacity(const SoilContent& soil) const
	{
		const double water = form == EnthalpyForm::stateFunction ? soil.waterMass : soil.poreVolume * properties.liquid.density;
		return soil.solidMass * properties.solid.specificHeat + water * properties.liquid.specificHeat;
	}

	/// Enthalpy of thawed ground extrapolated to T_0.
	double thawedOffset(const SoilContent& soil) const
	{
		// between T_0 and T_f the capacity was that of the curve, not of thawed ground
		const double missing        = freezingTemperature - properties.referenceTemperature + integralAtReference;
		const double iceCapacity    = properties.ice.density * properties.ice.specificHeat;
		const double liquidCapacity = properties.liquid.density * properties.liquid.specificHeat;
		return form == EnthalpyForm::stateFunction ? soil.waterMass * latentHeat
		                                           : soil.poreVolume * (latentPerPoreVolume + (iceCapacity - liquidCapacity) * missing);
	}

	double smallestCapacity(const SoilContent& soil) const
	{
		const double iceCapacity    = properties.ice.density * properties.ice.specificHeat;
		const double liquidCapacity = properties.liquid.density * properties.liquid.specificHeat;
		const double water = form == EnthalpyForm::stateFunction ? soil.waterMass * properties.ice.specificHeat
		                                                         : soil.poreVolume * std::min(iceCapacity, liquidCapacity);
		return soil.solidMass * properties.solid.specificHeat + water;
	}

	/// What residuals of the enthalpy are measured against, m_s c_s 1 K + m_w L_f [J].
	double residualScale(const SoilContent& soil) const
	{
		return soil.solidMass * properties.solid.specificHeat + soil.waterMass * latentHeat;
	}

	/// Ice that S_l stands for, short of the water that never freezes.
	struct Ice {
		double mass, slope; ///< [kg], its derivative [kg/K]
	};
	Ice iceAt(const SoilContent& soil, double temperature, double sl, double dsl) const
	{
		const double density  = properties.densityAt(properties.ice, temperature);
		const double uncapped = density * (1.0 - sl) * soil.poreVolume;
		const double cap      = (1.0 - residualWaterFraction) * soil.waterMass;
		const double slope    = -soil.poreVolume * (density * dsl + properties.ice.density * properties.ice.expansivity * (1.0 - sl));
		return { uncapped >= cap ? cap : uncapped, uncapped >= cap ? 0.0 : slope };
	}
};

} // namespace talik
