// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/thm/Mixture.hpp>

#include <limits>

namespace talik {

/// Coefficient of the skeleton's volumetric strain rate in the water balance: 1 - zeta S_i as follows from the phase
/// balances, or 1 - zeta n_i as printed in Yu & Zhao eq. (3).
enum class MassCoefficient { exact, printed };

/// Pressure of the pore liquid and the volume that it leaves empty.
struct PorePressure {
	double pressure; ///< p [Pa], compression positive, >= cavitationPressure
	double gap;      ///< pore volume holding neither ice nor liquid at the cavitation pressure [m^3], >= 0
};

/// Unstressed volume of pore content and how it yields to pressure.
struct PoreFill {
	double volume;     ///< of liquid and ice [m^3]
	double compliance; ///< [m^3/Pa]
};

/// Coefficients of K_p dp/dt + K_T dT/dt + K_S div v_s + K_l div v_l = 0 (div of the Darcy flux taken as n_l div(v_l - v_s)).
struct PressureCoefficients {
	double storage;     ///< K_p = n_l/K_w + n_i/K_i [1/Pa]
	double temperature; ///< K_T = zeta n dS_l/dT - beta_m [1/K]
	double skeleton;    ///< K_S [-]
	double liquid;      ///< K_l = n_l, of what is no ice [-]

	double undrained() const { return skeleton + liquid; } ///< chi = K_S + K_l
};

/// State of one point in pore-water terms.
struct PoreState {
	double porosity;             ///< n [-], in (0,1)
	double liquidSaturation;     ///< S_l [-], in [0,1]
	double saturationDerivative; ///< dS_l/dT [1/K], >= 0
	double temperature;          ///< [degC]
};

/// Equation of state of the pore content: liquid water and ice compressed into the available pore volume,
///   p = [m_l/rho_l(T) + m_i/rho_i(T) - V_pore] / [m_l/(rho_l K_w) + m_i/(rho_i K_i)],  p >= p_cav.
/// Because p follows from masses and volume it cannot drift, and a cavitation gap has to close before pressure returns.
struct PoreWaterState {
	double liquidBulkModulus  = 2.2e9; ///< K_w [Pa], > 0
	double iceBulkModulus     = 8.8e9; ///< K_i [Pa], > 0; infinity: no ice storage
	double cavitationPressure = 0.0;   ///< p_cav [Pa], <= 0
	/// false: ice occupies the volume of the liquid it came from, so phase change drives no flow (ice keeps its density in inertia and heat)
	bool            densityChange   = true;
	MassCoefficient massCoefficient = MassCoefficient::exact; ///< of coefficients(); the pressure itself is always exact

	/// Throws std::invalid_argument naming the attribute, its value and the valid range.
	void validate() const;

	/// Density by which ice fills pores, rho_i(T), or rho_l0 (1 - beta_i (T - T_0)) without density change [kg/m^3].
	double poreIceDensity(const MixtureProperties& m, double temperature) const
	{
		const double reference = densityChange ? m.ice.density : m.liquid.density;
		return reference * (1.0 - m.ice.expansivity * (temperature - m.referenceTemperature));
	}

	/// Volume and compliance of masses [kg].
	PoreFill fill(const MixtureProperties& m, double liquidMass, double iceMass, double temperature) const
	{
		const double liquidVolume = liquidMass / m.densityAt(m.liquid, temperature);
		const double iceVolume    = iceMass / poreIceDensity(m, temperature);
		return { liquidVolume + iceVolume, liquidVolume / liquidBulkModulus + iceVolume / iceBulkModulus };
	}

	/// Pressure of masses [kg] in the pore volume [m^3]; at least one mass must be positive.
	PorePressure pressure(const MixtureProperties& m, double liquidMass, double iceMass, double poreVolume, double temperature) const
	{
		const PoreFill content = fill(m, liquidMass, iceMass, temperature);
		const double   p       = (content.volume - poreVolume) / content.compliance;
		if (p >= cavitationPressure) return { p, 0.0 };
		return { cavitationPressure, (cavitationPressure - p) * content.compliance };
	}

	/// Water mass (ice + liquid) [kg] that fills the pore volume [m^3] at the pressure [Pa]; the inverse of pressure().
	/// Throws std::invalid_argument if the pressure lies below cavitationPressure or above a tenth of K_w.
	double waterMass(const MixtureProperties& m, double pressure, double liquidSaturation, double poreVolume, double temperature) const;

	/// Coefficients of the rate form at a state.
	PressureCoefficients coefficients(const MixtureProperties& m, const PoreState& state) const;
};

/// Skempton's B = dp/(-d sigma_m) of undrained ground with drained skeleton bulk modulus K [Pa]; with the oedometer modulus
/// instead of K, the loading efficiency of uniaxial strain.
double skemptonB(const PressureCoefficients& c, double skeletonModulus);

/// K_u = K + chi/K_p [Pa] (or the undrained oedometer modulus, from the drained one).
double undrainedModulus(const PressureCoefficients& c, double skeletonModulus);

/// Undrained wave speed sqrt(M_u/rho_m) [m/s] from the drained oedometer modulus [Pa].
double undrainedWaveSpeed(const MixtureProperties& m, const VolumeFractions& n, const PressureCoefficients& c, double oedometerModulus);

/// Largest wave speed when solid and liquid move without drag [m/s]: the bound that the explicit time step obeys. It is the
/// root of the largest eigenvalue of
///   [ (M + (1-n_l) K_S/K_p)/m_s   (1-n_l) K_l/(K_p m_s) ;  n_l K_S/(K_p m_l)   n_l K_l/(K_p m_l) ],
/// m_s = n_s rho_s + n_i rho_i, m_l = n_l rho_l. Without liquid, sqrt(M/m_s).
double largestWaveSpeed(const MixtureProperties& m, const VolumeFractions& n, const PressureCoefficients& c, double oedometerModulus);

} // namespace talik
