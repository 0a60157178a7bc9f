// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/thm/EnthalpyFormula.hpp>
#include <pkg/thm/FreezingCurve.hpp>

#include <cstddef>
#include <string>

namespace talik {

/// Density that multiplies the latent heat of the melting volume: that of ice (the mass that melts) or, as printed in
/// Yu & Zhao eq. (4), that of the liquid (9.9 % more heat).
enum class LatentDensity { ice, liquid };

EnthalpyForm  enthalpyFormFromName(const std::string& name);  ///< "stateFunction" | "capacityIntegral"
LatentDensity latentDensityFromName(const std::string& name); ///< "ice" | "liquid"

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
/// State-function form, zero at T_0 for grains and ice:
///   H(T) = [m_s c_s + m_i c_i + m_l c_l](T - T_0) + m_l L_f,
///   m_i(T) = min(rho_i(T) S_i(T) V_pore, (1 - f_r) m_w),  m_l = m_w - m_i.
/// H rises strictly with T above -150 degC, so the inverse is unique; it is found by Newton's method inside a bracket that
/// always holds the root, and in closed form for thawed ground, the sharp curve and (without ice expansion) the linear one.
class EnthalpyModel {
public:
	/// Throws std::invalid_argument for bad properties. Without a curve the ground never freezes.
	explicit EnthalpyModel(
	        const MixtureProperties& properties    = {},
	        FreezingCurvePtr         curve         = nullptr,
	        EnthalpyForm             form          = EnthalpyForm::stateFunction,
	        LatentDensity            latentDensity = LatentDensity::ice);

	const MixtureProperties& properties() const { return formula_.properties; }
	const FreezingCurve&     curve() const { return *curve_; }
	FreezingCurvePtr         curvePointer() const { return curve_; }
	EnthalpyForm             form() const { return formula_.form; }
	LatentDensity            latentDensity() const { return latentDensity_; }
	/// L_f of the state-function form [J/kg]; 9.9 % above the material's with LatentDensity::liquid.
	double latentHeat() const { return formula_.latentHeat; }

	/// Fraction f_r of the water mass that never becomes ice [-].
	static constexpr double residualWaterFraction = EnthalpyFormula::residualWaterFraction;
	/// Lowest temperature for which H(T) is inverted [degC].
	static constexpr double lowestTemperature = -150.0;

	/// Stop of the inversion: |H(T) - H| <= tolerance (m_s c_s 1 K + m_w L_f). In (0, 1e-6], default 1e-12.
	double tolerance() const { return tolerance_; }
	void   setTolerance(double tolerance);

	/// State at a given temperature (at T_f of a sharp curve: thawed).
	ThermalState stateAt(const SoilContent& soil, double temperature) const;
	/// H(T) [J]
	double enthalpy(const SoilContent& soil, double temperature) const;
	/// dH/dT [J/K], latent heat included: the apparent capacity.
	double apparentCapacity(const SoilContent& soil, double temperature) const;

	/// T(H) of one point from the guess. Throws std::runtime_error if H is not finite or below that of -150 degC.
	ThermalState solve(const SoilContent& soil, double enthalpy, double guess = 0.0) const;

	/// T(H) for every entry; nothing is allocated. Returns the index of the first entry without a valid temperature (its
	/// temperature is NaN; the others are solved all the same), or batch.count if all are valid.
	std::size_t temperatures(const EnthalpyBatch& batch) const { return curve_->solveTemperatures(*this, batch); }

	/// Specific enthalpy of liquid water, h_l = c_l (T - T_0) + L_f [J/kg]: what moving water carries.
	double liquidEnthalpy(double temperature) const
	{
		const MixtureProperties& m = formula_.properties;
		return m.liquid.specificHeat * (temperature - m.referenceTemperature) + formula_.latentHeat;
	}

	const EnthalpyFormula& formula() const { return formula_; }

private:
	EnthalpyFormula  formula_;
	FreezingCurvePtr curve_;
	LatentDensity    latentDensity_;
	double           tolerance_ = 1e-12;
};

} // namespace talik
