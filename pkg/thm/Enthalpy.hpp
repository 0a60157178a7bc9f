// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/thm/FreezingCurve.hpp>
#include <pkg/thm/Mixture.hpp>

#include <cstddef>
#include <string>

namespace talik {

/// Form of H(T). stateFunction: masses times specific enthalpies, conserves energy under strain, seepage and phase change.
/// capacityIntegral: integral of the volumetric capacity plus n V rho L_f S_l, which is Yu & Zhao eq. (4) read literally; it
/// knows no enthalpy of moving water and is meant for rigid ground and comparison.
enum class EnthalpyForm { stateFunction, capacityIntegral };

/// Density that multiplies the latent heat of the melting volume: that of ice (the mass that melts) or, as printed in
/// Yu & Zhao eq. (4), that of the liquid (9.9 % more heat).
enum class LatentDensity { ice, liquid };

EnthalpyForm  enthalpyFormFromName(const std::string& name);  ///< "stateFunction" | "capacityIntegral"
LatentDensity latentDensityFromName(const std::string& name); ///< "ice" | "liquid"

/// What does not depend on temperature in the enthalpy of one material point.
struct SoilContent {
	double solidMass;  ///< m_s [kg], > 0
	double waterMass;  ///< m_w = ice + liquid [kg], >= 0
	double poreVolume; ///< V_pore [m^3], > 0
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

	const MixtureProperties& properties() const { return properties_; }
	const FreezingCurve&     curve() const { return *curve_; }
	FreezingCurvePtr         curvePointer() const { return curve_; }
	EnthalpyForm             form() const { return form_; }
	LatentDensity            latentDensity() const { return latentDensity_; }
	/// L_f of the state-function form [J/kg]; 9.9 % above the material's with LatentDensity::liquid.
	double latentHeat() const { return latentHeat_; }

	/// Fraction f_r of the water mass that never becomes ice [-].
	static constexpr double residualWaterFraction = 1e-3;
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
		return properties_.liquid.specificHeat * (temperature - properties_.referenceTemperature) + latentHeat_;
	}

	/// T(H) with the code of one curve inlined.
	template <class Curve> ThermalState solveWith(const Curve& curve, const SoilContent& soil, double enthalpy, double guess) const;

private:
	struct Evaluation {
		double enthalpy, slope, liquidSaturation, iceMass, heatCapacity;
	};
	template <class Curve> Evaluation   evaluateAt(const Curve& curve, const SoilContent& soil, double temperature) const;
	template <class Curve> ThermalState solveFrozen(const Curve& curve, const SoilContent& soil, double enthalpy, double guess) const;
	template <class Curve> ThermalState plateauState(const Curve& curve, const SoilContent& soil, double fractionThawed) const;
	template <class Curve> double       closedFormGuess(const Curve& curve, const SoilContent& soil, double enthalpy, double guess) const;

	double iceMassAt(const SoilContent& soil, double temperature, double liquidSaturation, double curveSlope, double& slope) const;
	Evaluation evaluation(const SoilContent& soil, double temperature, double sl, double dsl, double integralOfSl) const;
	double thawedCapacity(const SoilContent& soil) const;
	double thawedOffset(const SoilContent& soil) const;
	double smallestCapacity(const SoilContent& soil) const;
	double residualScale(const SoilContent& soil) const
	{
		return soil.solidMass * properties_.solid.specificHeat + soil.waterMass * latentHeat_;
	}

	MixtureProperties properties_;
	FreezingCurvePtr  curve_;
	EnthalpyForm      form_;
	LatentDensity     latentDensity_;
	double            latentHeat_;
	double            latentPerPoreVolume_; // rho L_f of the capacity-integral form [J/m^3]
	double            integralAtReference_; // integral of S_l from T_f to T_0 [K]
	double            tolerance_ = 1e-12;
};

} // namespace talik
