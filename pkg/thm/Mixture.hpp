// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/Errors.hpp>

#include <string>
#include <vector>

namespace talik {

/// How the conductivities of the phases combine to that of the mixture.
enum class ConductivityMean { arithmetic, geometric, harmonic };

/// Name of a mean as scripts write it; throws std::invalid_argument listing the valid names.
ConductivityMean conductivityMeanFromName(const std::string& name);

/// Intrinsic properties of one phase (soil grains, ice or liquid water) at the reference temperature.
struct Phase {
	double density;      ///< intrinsic density [kg/m^3], > 0
	double specificHeat; ///< [J/(kg K)], > 0
	double conductivity; ///< thermal conductivity [W/(m K)], > 0
	double expansivity;  ///< volumetric thermal expansivity [1/K], |value| < 1e-2
};

/// Volume fractions of a mixture; they add up to one.
struct VolumeFractions {
	double solid, ice, liquid, air;
	/// porosity in (0,1), liquidSaturation in [0,1] of what fills the part poreFill of the pores
	static VolumeFractions of(double porosity, double liquidSaturation, double poreFill = 1.0)
	{
		return { 1.0 - porosity, poreFill * porosity * (1.0 - liquidSaturation), poreFill * porosity * liquidSaturation, (1.0 - poreFill) * porosity };
	}
};

/// Properties of saturated freezing ground: grains, ice and liquid water.
/// Densities, specific heats and conductivities are those of Yu & Zhao, section 3; expansivities of grains and ice are handbook values. Water has none
/// on average between 0 and 8 degC, as it is densest at 4 degC (Kell 1975).
struct MixtureProperties {
	Phase            solid { 2650.0, 800.0, 1.0, 2.4e-5 };
	Phase            ice { 910.0, 2060.0, 2.2, 1.6e-4 };
	Phase            liquid { 1000.0, 4200.0, 0.6, 0.0 };
	double           latentHeat           = 334.0e3; ///< of fusion at the reference temperature [J/kg], > 0
	double           referenceTemperature = 0.0;     ///< T_0 of enthalpy and density [degC]
	ConductivityMean conductivityMean     = ConductivityMean::arithmetic;

	static constexpr double airConductivity = 0.024; ///< [W/(m K)]

	/// rho(T) = rho_0 (1 - beta (T - T_0)) [kg/m^3]
	double densityAt(const Phase& phase, double temperature) const
	{
		return phase.density * (1.0 - phase.expansivity * (temperature - referenceTemperature));
	}

	/// Density deficit of ice, zeta = 1 - rho_i/rho_l at the given temperature [-] (0.09 with the default data at T_0).
	double densityDeficit(double temperature) const { return 1.0 - densityAt(ice, temperature) / densityAt(liquid, temperature); }

	/// rho_m = sum n_pi rho_pi [kg/m^3], eq. (3.1)
	double density(const VolumeFractions& n) const { return n.solid * solid.density + n.ice * ice.density + n.liquid * liquid.density; }

	/// C_m = sum n_pi rho_pi c_pi, sensible heat capacity per volume [J/(m^3 K)]
	double heatCapacity(const VolumeFractions& n) const
	{
		return n.solid * solid.density * solid.specificHeat + n.ice * ice.density * ice.specificHeat + n.liquid * liquid.density * liquid.specificHeat;
	}

	/// kappa_m by the chosen mean [W/(m K)]
	double conductivity(const VolumeFractions& n) const;
	/// The same by the arithmetic mean, whatever is chosen.
	double arithmeticConductivity(const VolumeFractions& n) const
	{
		return n.solid * solid.conductivity + n.ice * ice.conductivity + n.liquid * liquid.conductivity + n.air * airConductivity;
	}

	/// Volumetric expansivity of the mixture as it drives pressure at constant mass,
	/// beta_m = n_l beta_l + (1-zeta) n_i beta_i + (1-n)(1-zeta S_i) beta_s [1/K].
	double expansivity(double porosity, double liquidSaturation, double temperature) const;

	/// Throws std::invalid_argument naming the attribute, its value and the valid range.
	void validate() const;
};

} // namespace talik
