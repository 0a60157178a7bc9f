// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <pkg/icebond/IceBond.hpp>

namespace talik {

/// Strength of ice bonds over the one that their material gives them [-], > 0.
struct BondStrengthFactors {
	double tensile = 1, shear = 1;
	bool   operator==(const BondStrengthFactors& other) const { return tensile == other.tensile && shear == other.shear; }
};

/// The time step of a sample bears ice that is stiffer than its material says by this factor [-].
constexpr double mostIceStiffness = 2;

/// How strength and stiffness of ice bonds follow temperature and strain rate, eq. (14.7) and (14.14). The numbers are those of frozen silt: rate by Haynes,
/// Karalius & Kalafut 1975, temperature by Haynes & Karalius 1977; compression is taken for the shear strength of bonds, tension for tensile.
struct IceStrengthLaw {
	/// Exponential growth with cold b [1/K] and exponent of the rate n [-] of one strength.
	struct Dependence {
		double cold, rate;
	};
	Dependence tensile { 0.0203, 0. }, shear { 0.0406, 0.228 };
	double     referenceTemperature = -10;  ///< at which the material's strengths hold [degC], <= 0
	double     referenceRate        = 1e-4; ///< the same [1/s of nature], > 0
	double     leastRate            = 1e-7; ///< slower strain counts as this [1/s], > 0
	double     stiffnessCold        = 0;    ///< exponential growth of the stiffness of ice with cold b_E [1/K], >= 0; 0: it does not follow

	BondStrengthFactors factors(double temperature, double strainRate) const
	{
		const double colder = colderBy(temperature), faster = std::max(strainRate, leastRate) / referenceRate;
		const auto   factor = [&](const Dependence& of) { return std::exp(of.cold * colder) * std::pow(faster, of.rate); };
		return { factor(tensile), factor(shear) };
	}
	/// Stiffness of the ice over the one that the material gives it [-].
	double stiffness(double temperature) const { return std::min(std::exp(stiffnessCold * colderBy(temperature)), mostIceStiffness); }

private:
	double colderBy(double temperature) const { return referenceTemperature - std::min(temperature, 0.); }
};

/// Creep of ice bonds over some calendar time at one temperature.
struct BondCreep {
	double fluidity = 0; ///< rate factor times time, A(T) t [Pa^-n], >= 0; 0: no creep
	double exponent = 3; ///< n of Glen's law [-], >= 1
	bool   acts() const { return fluidity > 0; }
	bool   isPossible() const { return fluidity >= 0 && exponent >= 1 && std::isfinite(fluidity) && std::isfinite(exponent); }

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
	/// Over a calendar time [s].
	BondCreep over(double temperature, double time) const { return { rateFactorAt(temperature) * time, exponent }; }
};

/// Why options of a sample or scene do not fit together.
constexpr const char* momentsDoNotCreep
        = "Bonds that carry moments do not creep: leave the creep out, or give the grains an IceBondMat or RollingIceBondMat in place of MomentIceBondMat.";

/// A contact whose ice creeps.
struct CreepingContact {
	ContactStiffness stiffness;
	double           young;    ///< E_c of the contact with its ice, eq. (6) [Pa]
	double           area;     ///< A_b [m^2]
	double           friction; ///< tangent of the friction angle [-]
	double           overlap;  ///< u_n, which does not change [m]
};

/// What grains without ice could not hold is the ice's, eq. (14.9); no force changes.
template <class Shear> void giveIceItsForce(IceBond& bond, const CreepingContact& c, const Shear& shear, Shear& iceShear)
{
	const double apart = std::min(c.overlap, 0.);
	if (!c.stiffness.isHertz()) bond.uIce -= c.stiffness.grain * (apart - bond.uGrain) / c.stiffness.ice();
	bond.uGrain           = apart;
	const Shear  ofGrains = shear - iceShear;
	const double norm = shearNorm(ofGrains), limit = c.friction * c.stiffness.grainSpring(c.overlap).force;
	if (norm > limit) iceShear = shear - ofGrains * (limit / norm);
}

/// The force of the ice relaxes at constant overlap and slip, eq. (14.10). Stiffness rule parallel.
template <class Shear> void relaxIce(IceBond& bond, const BondCreep& creep, const CreepingContact& c, Shear& shear, Shear& iceShear)
{
	if (!bond.hasIceSpring() || !(c.stiffness.iceRatio > 0)) return;
	if (bond.intact()) giveIceItsForce(bond, c, shear, iceShear);
	else if (c.overlap <= bond.uIce) return; // broken ice that no longer pushes
	const double normal = c.stiffness.ice() * (c.overlap - bond.uIce), kept = creep.kept(c.young, std::hypot(normal, shearNorm(iceShear)) / c.area);
	bond.uIce = c.overlap - kept * (c.overlap - bond.uIce);
	shear -= iceShear * (1 - kept);
	iceShear *= kept;
}

} // namespace talik
