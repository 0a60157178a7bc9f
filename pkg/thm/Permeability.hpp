// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/thm/Exponential.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace talik {

/// How ice reduces the hydraulic conductivity.
/// impedance: 10^(-Omega S_i); vanGenuchtenMualem: S_e^(1/2) [1 - (1 - S_e^(1/lambda))^lambda]^2; power: S_e^a;
/// iceAsGrain: ice counts as solid in Kozeny-Carman, no further reduction.
enum class RelativeConductivity { impedance, vanGenuchtenMualem, power, iceAsGrain };

RelativeConductivity relativeConductivityFromName(const std::string& name);
const char*          nameOf(RelativeConductivity law);

/// Hydraulic conductivity k = f_H k_ref KC(n)/KC(n_ref) max(k_r(S_l), floor) [m/s], KC(n) = n^3/(1-n)^2 (Kozeny-Carman).
struct Permeability {
	double referenceConductivity = 1e-4; ///< k_ref of thawed ground at referencePorosity [m/s], > 0 (Yu & Zhao: 1e-4)
	double referencePorosity     = 0.4;  ///< n_ref [-], in (0,1)
	RelativeConductivity law     = RelativeConductivity::impedance;
	double impedance             = 6.0;  ///< Omega [-], >= 0, usually 4 to 10
	double exponent              = 3.0;  ///< a of the power law [-], > 0, usually 3 to 9
	double lambda                = 0.4;  ///< of van Genuchten-Mualem [-], in (0,1)
	double residualSaturation    = 0.05; ///< S_r in S_e = (S_l - S_r)/(1 - S_r) [-], in [0,1)
	double floor                 = 1e-6; ///< smallest k_r [-], in (0,1]; keeps the drag bounded
	double hydraulicTimeScale    = 1.0;  ///< f_H multiplies k, as the thermal time scale multiplies conduction [-], 1e-12 to 1e12

	/// Throws std::invalid_argument naming the attribute, its value and the valid range.
	void validate() const;

	/// KC(n)/KC(n_ref) [-], porosity in (0,1)
	double porosityFactor(double porosity) const { return kozenyCarman(porosity) / kozenyCarman(referencePorosity); }

	/// 10^(-Omega S_i) [-]
	double impeded(double liquidSaturation) const
	{
		constexpr double ln10 = 2.302585092994045684;
		return exponential(-impedance * ln10 * (1.0 - liquidSaturation));
	}

	/// k_r [-] in [floor, 1], liquidSaturation in [0,1]
	double relative(double liquidSaturation) const
	{
		const double effective = std::min(1.0, std::max(0.0, (liquidSaturation - residualSaturation) / (1.0 - residualSaturation)));
		double       kr        = 1.0;
		switch (law) {
			case RelativeConductivity::impedance: kr = impeded(liquidSaturation); break;
			case RelativeConductivity::vanGenuchtenMualem: {
				const double bracket = 1.0 - std::pow(1.0 - std::pow(effective, 1.0 / lambda), lambda);
				kr                   = std::sqrt(effective) * bracket * bracket;
				break;
			}
			case RelativeConductivity::power: kr = std::pow(effective, exponent); break;
			case RelativeConductivity::iceAsGrain: break;
		}
		return std::min(1.0, std::max(floor, kr));
	}

	/// k [m/s] at the porosity and liquid saturation
	double conductivity(double porosity, double liquidSaturation) const
	{
		const double k = hydraulicTimeScale * referenceConductivity;
		if (law == RelativeConductivity::iceAsGrain) return k * std::max(floor, porosityFactor(porosity * liquidSaturation));
		return k * porosityFactor(porosity) * relative(liquidSaturation);
	}

	/// The same by the impedance law, whatever is chosen; without branches, for loops over points.
	double impededConductivity(double porosity, double liquidSaturation) const
	{
		return hydraulicTimeScale * referenceConductivity * porosityFactor(porosity) * std::min(1.0, std::max(floor, impeded(liquidSaturation)));
	}

	/// Acceleration of gravity in the definition of hydraulic conductivity: a material constant, independent of body forces [m/s^2].
	static constexpr double gravity = 9.81;

	/// Drag of one material point between liquid and solid, V n_l^2 rho_l g/k = m_l n_l g/k [kg/s].
	double drag(double liquidMass, double porosity, double liquidSaturation) const
	{
		return dragAt(liquidMass, porosity * liquidSaturation, conductivity(porosity, liquidSaturation));
	}
	/// The same from the liquid fraction n_l and the conductivity [m/s].
	static double dragAt(double liquidMass, double liquidFraction, double conductivity)
	{
		return liquidMass * liquidFraction * gravity / conductivity;
	}

private:
	static double kozenyCarman(double n) { return n * n * n / ((1.0 - n) * (1.0 - n)); }
};

} // namespace talik
