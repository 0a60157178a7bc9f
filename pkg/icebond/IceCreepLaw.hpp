// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cmath>

namespace talik {

/// Creep of ice bonds over some time of nature at one temperature.
struct BondCreep {
	double fluidity = 0; ///< rate factor times time, A(T) t [Pa^-n], >= 0; 0: no creep
	double exponent = 3; ///< n of Glen's law [-], >= 1
	bool   acts() const { return fluidity > 0; }

	/// eq. (14.10): part of a stress [Pa] that is left at constant strain in a body of a Young's modulus [Pa].
	double kept(double young, double stress) const
	{
		const double excess = exponent - 1, flown = young * fluidity * std::pow(stress, excess);
		return excess > 0 ? std::exp(-std::log1p(excess * flown) / excess) : std::exp(-flown);
	}
};

/// Glen's law with an Arrhenius factor, eq. (14.8). The numbers are those that Cuffey & Paterson 2010 recommend, section 3.4.6.
struct IceCreepLaw {
	static constexpr double gasConstant = 8.314, celsius = 273.15; ///< [J/(mol K)], [K]

	double rateFactor           = 3.5e-25; ///< A_0 at the reference temperature [Pa^-n/s], >= 0
	double exponent             = 3;       ///< n [-], >= 1
	double referenceTemperature = -10;     ///< T_0, also where the activation energy changes [degC], <= 0
	double coldActivationEnergy = 60e3;    ///< Q below T_0 [J/mol], >= 0
	double warmActivationEnergy = 115e3;   ///< Q above T_0 [J/mol], >= 0

	/// A(T) [Pa^-n/s of nature]; ground above 0 degC counts as 0.
	double rateFactorAt(double temperature) const
	{
		const double t = std::min(temperature, 0.), energy = t < referenceTemperature ? coldActivationEnergy : warmActivationEnergy;
		return rateFactor * std::exp(energy / gasConstant * (1 / (celsius + referenceTemperature) - 1 / (celsius + t)));
	}
	/// Over a time of nature [s].
	BondCreep over(double temperature, double time) const { return { rateFactorAt(temperature) * time, exponent }; }
};

} // namespace talik
