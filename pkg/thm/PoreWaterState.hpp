// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <limits>
#include <pkg/thm/Exponential.hpp>
#include <pkg/thm/Mixture.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace talik {

/// Coefficient of the skeleton's volumetric strain rate in the water balance: 1 - zeta S_i as follows from the phase
/// balances, or 1 - zeta n_i as printed in Yu & Zhao eq. (3).
enum class MassCoefficient { exact, printed };

/// Unstressed volume of pore content and how it yields to pressure.
struct PoreFill {
	double volume;     ///< of liquid and ice [m^3]
	double compliance; ///< [m^3/Pa]
};

/// Eq. (7.2): coefficients of K_p dp/dt + K_T dT/dt + K_S div v_s + K_l div v_l = 0 (div of the Darcy flux taken as n_l div(v_l - v_s)).
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

/// Equation of state of the pore content: liquid water and ice compressed into the available pore volume, eq. (7.1),
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
	double pressure(const MixtureProperties& m, double liquidMass, double iceMass, double poreVolume, double temperature) const
	{
		const PoreFill content = fill(m, liquidMass, iceMass, temperature);
		const double   p       = (content.volume - poreVolume) / content.compliance;
		return p >= cavitationPressure ? p : cavitationPressure;
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

/// Largest wave speed when solid and liquid move without drag [m/s]: the bound that the explicit time step obeys, eq. (10.1). It is the
/// root of the largest eigenvalue of
///   [ (M + (1-n_l) K_S/K_p)/m_s   (1-n_l) K_l/(K_p m_s) ;  n_l K_S/(K_p m_l)   n_l K_l/(K_p m_l) ],
/// m_s = n_s rho_s + n_i rho_i, m_l = n_l rho_l. Without liquid, sqrt(M/m_s).
double largestWaveSpeed(const MixtureProperties& m, const VolumeFractions& n, const PressureCoefficients& c, double oedometerModulus);

/// Eq. (5.1): hydraulic conductivity k = f_H k_ref [KC(n)/KC(n_ref) or 10^((e - e_ref)/C_k)] max(k_r(S_l), floor) [m/s], KC(n) = n^3/(1-n)^2
/// (Kozeny-Carman), e the void ratio.
struct Permeability {
	double referenceConductivity = 1e-4; ///< k_ref of thawed ground at referencePorosity [m/s], > 0 (Yu & Zhao: 1e-4)
	double referencePorosity     = 0.4;  ///< n_ref [-], in (0,1)
	double index                 = 0.0;  ///< C_k: void ratio over which k grows tenfold [-], >= 0; 0: Kozeny-Carman
	double impedance             = 6.0;  ///< Omega [-], >= 0, usually 4 to 10
	double hydraulicTimeScale    = 1.0;  ///< f_H multiplies k, as the thermal time scale multiplies conduction [-], 1e-12 to 1e12

	static constexpr double floor = 1e-6; ///< smallest k_r [-]; keeps the drag bounded

	/// Throws std::invalid_argument naming the attribute as its class in scripts calls it, its value and the valid range.
	void validate(const std::string& owner = "PoreWater.", const std::string& nameOfConductivity = "conductivity") const;

	/// k over that at n_ref [-], porosity in (0,1)
	double porosityFactor(double porosity) const
	{
		if (index > 0.0) return exponential(ln10 / index * (1.0 / (1.0 - porosity) - 1.0 / (1.0 - referencePorosity)));
		return kozenyCarman(porosity) / kozenyCarman(referencePorosity);
	}

	/// k_r [-] in [floor, 1], eq. (5.2), liquidSaturation in [0,1]
	double relative(double liquidSaturation) const { return std::min(1.0, std::max(floor, exponential(-impedance * ln10 * (1.0 - liquidSaturation)))); }

	/// k [m/s] at the porosity and liquid saturation; without branches, for loops over points.
	double conductivity(double porosity, double liquidSaturation) const
	{
		return hydraulicTimeScale * referenceConductivity * porosityFactor(porosity) * relative(liquidSaturation);
	}

	/// Acceleration of gravity in the definition of hydraulic conductivity: a material constant, independent of body forces [m/s^2].
	static constexpr double gravity = 9.81;

	/// Drag of one material point between liquid and solid, eq. (5.3): V n_l^2 rho_l g/k = m_l n_l g/k [kg/s], with the conductivity k [m/s].
	static double dragAt(double liquidMass, double liquidFraction, double conductivity) { return liquidMass * liquidFraction * gravity / conductivity; }

private:
	static constexpr double ln10 = 2.302585092994045684;
	static double           kozenyCarman(double n) { return n * n * n / ((1.0 - n) * (1.0 - n)); }
};

} // namespace talik
