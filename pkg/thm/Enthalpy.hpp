// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/thm/FreezingCurve.hpp>
#include <pkg/thm/Mixture.hpp>

#include <algorithm>
#include <cstddef>
#include <string>

namespace talik {

/// What does not depend on temperature in the enthalpy of one material point.
struct SoilContent {
	double solidMass;  ///< m_s [kg], > 0
	double waterMass;  ///< m_w = ice + liquid [kg], >= 0
	double poreVolume; ///< [m^3], > 0: of pores that bound the ice, where no water flows
};

/// H of saturated ground where temperature and liquid saturation are known, with its slope. A plain value, so that loops over
/// points can hold a copy that no store to a field may change.
struct EnthalpyFormula {
	/// Fraction f_r of the water mass that never becomes ice [-].
	static constexpr double residualWaterFraction = 1e-3;

	MixtureProperties properties;
	Phase             iceInPores {}; ///< ice with the density by which it fills pores, see EnthalpyModel::letWaterFillPores; 0: it does not

	struct Value {
		double enthalpy;     ///< H [J]
		double slope;        ///< dH/dT [J/K], eq. (9.2)
		double iceMass;      ///< [kg]
		double heatCapacity; ///< at fixed phase masses [J/K]
	};

	/// sl, dsl: S_l and dS_l/dT at temperature.
	Value at(const SoilContent& soil, double temperature, double sl, double dsl) const
	{
		const double theta = temperature - properties.referenceTemperature, latentHeat = properties.latentHeat;
		const Ice    frozen     = iceAt(soil, temperature, sl, dsl);
		const double difference = properties.liquid.specificHeat - properties.ice.specificHeat;
		const double capacity   = thawedCapacity(soil) - difference * frozen.mass;
		const double enthalpy   = capacity * theta + (soil.waterMass - frozen.mass) * latentHeat;
		return { enthalpy, capacity - frozen.slope * (latentHeat + difference * theta), frozen.mass, capacity };
	}
	double thawedCapacity(const SoilContent& soil) const
	{
		return soil.solidMass * properties.solid.specificHeat + soil.waterMass * properties.liquid.specificHeat;
	}
	/// Enthalpy of thawed ground extrapolated to T_0.
	double thawedOffset(const SoilContent& soil) const { return soil.waterMass * properties.latentHeat; }
	double smallestCapacity(const SoilContent& soil) const
	{
		return soil.solidMass * properties.solid.specificHeat + soil.waterMass * properties.ice.specificHeat;
	}

	/// What residuals of the enthalpy are measured against, m_s c_s 1 K + m_w L_f [J].
	double residualScale(const SoilContent& soil) const { return soil.solidMass * properties.solid.specificHeat + soil.waterMass * properties.latentHeat; }

	/// Ice at a liquid saturation, eq. (2.4), without the water that never freezes.
	struct Ice {
		double mass, slope; ///< [kg], its derivative [kg/K]
	};
	Ice iceAt(const SoilContent& soil, double temperature, double sl, double dsl) const
	{
		const Phase &ice = properties.ice, &liquid = properties.liquid;
		const double si = 1.0 - sl, density = properties.densityAt(ice, temperature);
		const double inPores = properties.densityAt(iceInPores, temperature), ofLiquid = properties.densityAt(liquid, temperature);
		const bool   fills    = iceInPores.density > 0.0;
		const double perPores = inPores * si + ofLiquid * sl; // water of full pores, eq. (2.5), and its derivative
		const double change   = (ofLiquid - inPores) * dsl - iceInPores.density * ice.expansivity * si - liquid.density * liquid.expansivity * sl;
		const double volume   = fills ? soil.waterMass / perPores : soil.poreVolume;
		const double uncapped = density * si * volume;
		const double cap      = (1.0 - residualWaterFraction) * soil.waterMass;
		const double slope    = -volume * (density * dsl + ice.density * ice.expansivity * si) - (fills ? uncapped * change / perPores : 0.0);
		return { uncapped >= cap ? cap : uncapped, uncapped >= cap ? 0.0 : slope };
	}
};

/// Thermal state of one material point.
struct ThermalState {
	double temperature;      ///< T [degC]
	double liquidSaturation; ///< S_l [-]
	double iceMass;          ///< m_i [kg]
	double heatCapacity;     ///< sensible capacity at fixed phase masses [J/K]
	bool   valid;            ///< false: the enthalpy is not finite or belongs to a temperature below -150 degC
	double apparentCapacity; ///< dH/dT, latent heat included [J/K]; infinite where a sharp curve changes phase
};

/// Many material points as parallel arrays of length count. temperature holds the guess on entry (the previous value).
struct EnthalpyBatch {
	std::size_t   count;
	const double* enthalpy;         ///< H [J]
	const double* solidMass;        ///< [kg]
	const double* waterMass;        ///< [kg]
	const double* poreVolume;       ///< [m^3]
	double*       temperature;      ///< in: guess, out: T [degC]
	double*       liquidSaturation; ///< out [-]
	double*       iceMass;          ///< out [kg]
	double*       heatCapacity;     ///< out: sensible capacity [J/K]
	double*       apparentCapacity; ///< out: dH/dT [J/K]; may be null
};

/// Enthalpy of saturated freezing ground as a function of temperature and the inverse.
///
/// Zero at T_0 for grains and ice, eq. (9.1):
///   H(T) = [m_s c_s + m_i c_i + m_l c_l](T - T_0) + m_l L_f,
///   m_i(T) = min(rho_i(T) S_i(T) V, (1 - f_r) m_w),  m_l = m_w - m_i,
/// with the volume V that the water fills at these saturations, see letWaterFillPores, or that of the pores.
/// H rises strictly with T above -150 degC, so the inverse is unique; it is found by Newton's method inside a bracket that
/// always holds the root, and in closed form for thawed ground, the sharp curve and (without ice expansion) the linear one.
class EnthalpyModel {
public:
	/// Throws std::invalid_argument for bad properties. Without a curve the ground never freezes.
	explicit EnthalpyModel(const MixtureProperties& properties = {}, FreezingCurvePtr curve = nullptr);

	const MixtureProperties& properties() const { return formula_.properties; }
	const FreezingCurve&     curve() const { return *curve_; }

	/// From now on ice is a function of T and the mass of water, whatever volume the pores have: that of pores that the water fills, with ice of
	/// this density [kg/m^3]. Ground then exchanges no heat with its strain.
	void letWaterFillPores(double densityOfIce)
	{
		formula_.iceInPores         = formula_.properties.ice;
		formula_.iceInPores.density = densityOfIce;
	}

	/// Fraction f_r of the water mass that never becomes ice [-].
	static constexpr double residualWaterFraction = EnthalpyFormula::residualWaterFraction;
	/// Lowest temperature for which H(T) is inverted [degC].
	static constexpr double lowestTemperature = -150.0;

	/// Stop of the inversion: |H(T) - H| <= tolerance (m_s c_s 1 K + m_w L_f).
	static constexpr double tolerance = 1e-12;

	/// State at a given temperature (at T_f of a sharp curve: thawed).
	ThermalState stateAt(const SoilContent& soil, double temperature) const;
	/// H(T) [J]
	double enthalpy(const SoilContent& soil, double temperature) const;

	/// T(H) of one point from the guess. Throws std::runtime_error if H is not finite or below that of -150 degC.
	ThermalState solve(const SoilContent& soil, double enthalpy, double guess = 0.0) const;

	/// T(H) for every entry; nothing is allocated. Returns the index of the first entry without a valid temperature (its
	/// temperature is NaN; the others are solved all the same), or batch.count if all are valid.
	std::size_t temperatures(const EnthalpyBatch& batch) const { return curve_->solveTemperatures(*this, batch); }

	/// Specific enthalpy of liquid water, h_l = c_l (T - T_0) + L_f [J/kg]: what moving water carries.
	double liquidEnthalpy(double temperature) const
	{
		const MixtureProperties& m = formula_.properties;
		return m.liquid.specificHeat * (temperature - m.referenceTemperature) + m.latentHeat;
	}

	const EnthalpyFormula& formula() const { return formula_; }

private:
	EnthalpyFormula  formula_;
	FreezingCurvePtr curve_;
};

} // namespace talik
