// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

namespace talik {

/// State of one contact with respect to ice. NONE: purely frictional; BONDED: an intact ice bond; BROKEN: the bond failed
/// mechanically, the contact is frictional until a melt resets it to NONE.
enum class BondState : int { NONE = 0, BONDED = 1, BROKEN = 2 };

/// How forces follow a change of contact stiffness with ice saturation.
/// parallel: grain spring beside an ice spring that grows stress-free and drops its share on melting (default);
/// forceContinuous: the force never jumps; secant: F = k(S_i) u, every change of S_i rescales the force.
enum class StiffnessRule : int { parallel = 0, forceContinuous = 1, secant = 2 };

/// Ice-dependent stiffness and strength of a grain contact, Yu & Zhao eqs (5)-(7).
struct IceBondModel {
	double grainYoung               = 0.6e9;  ///< E_c0, contact modulus without ice [Pa], > 0
	double iceYoung                 = 3.0e9;  ///< Delta E, modulus added by full ice saturation [Pa], >= 0
	double tensileStrength0         = 1.0e6;  ///< C_eta0, bond strength at vanishing ice saturation [Pa], >= 0
	double tensileStrengthI         = 50.0e6; ///< Delta C_eta, tensile strength added at full ice saturation [Pa], >= 0
	double shearStrength0           = 1.0e6;  ///< C_tau0 [Pa], >= 0
	double shearStrengthI           = 50.0e6; ///< Delta C_tau [Pa], >= 0
	double exponent                 = 2.0;    ///< m of eq. (7) [-], > 1
	double bondAreaFactor           = 1.0;    ///< a_f: bond area is a_f R_min^2 [-], > 0
	double meltSaturation           = 0.02;   ///< S_melt: at or below it every bond is gone [-]
	double bondSaturation           = 0.05;   ///< S_bond: ice rising through it bonds every frictional contact in range [-], >= S_melt
	double bondRange                = 0.05;   ///< largest gap that is bonded, in units of R_min [-]
	double thawedStrength           = 0.; ///< tensile and cohesive shear strength that a bond keeps when its ice has melted [Pa], >= 0; 0: it is gone then
	bool   cohesionDisablesFriction = false; ///< true: the shear limit of an intact bond has no frictional part

	/// Of grains that no ice bonds or stiffens, whatever the ice saturation.
	static IceBondModel none()
	{
		IceBondModel m;
		m.iceYoung = m.tensileStrength0 = m.tensileStrengthI = m.shearStrength0 = m.shearStrengthI = 0;
		m.bondSaturation                                                                           = std::numeric_limits<double>::infinity();
		return m;
	}
	bool formsBondsEver() const { return bondSaturation <= 1; }
	bool bondsOutlastIce() const { return thawedStrength > 0; }

	/// eq. (7): phi = 1 - (1 - S_i^m)^m, 0 at S_i = 0 and 1 at S_i = 1.
	double phi(double iceSaturation) const
	{
		const double s = std::min(1., std::max(0., iceSaturation));
		return 1. - std::pow(1. - std::pow(s, exponent), exponent);
	}
	/// eq. (6): contact modulus [Pa].
	double young(double iceSaturation) const { return grainYoung + iceYoung * phi(iceSaturation); }
	/// Stiffness of the ice spring in units of the grain spring: E_c(S_i)/E_c0 - 1 [-].
	double iceStiffnessRatio(double iceSaturation) const { return iceYoung * phi(iceSaturation) / grainYoung; }
	/// eq. (5): tensile strength of a bond [Pa]; thawedStrength once melted.
	double tensileStrength(double iceSaturation) const
	{
		return iceSaturation <= meltSaturation ? thawedStrength : tensileStrength0 + tensileStrengthI * phi(iceSaturation);
	}
	/// eq. (5): cohesive shear strength of a bond [Pa]; thawedStrength once melted.
	double shearStrength(double iceSaturation) const
	{
		return iceSaturation <= meltSaturation ? thawedStrength : shearStrength0 + shearStrengthI * phi(iceSaturation);
	}
	double bondArea(double smallerRadius) const { return bondAreaFactor * smallerRadius * smallerRadius; }
	bool   melted(double iceSaturation) const { return iceSaturation <= meltSaturation; }
	/// True when a change of ice saturation forms new bonds.
	bool formsBonds(double before, double after) const { return before < bondSaturation && after >= bondSaturation; }
};

/// eq. (8): equivalent radius over r_0 of a grain with its pore ice; n0 is the porosity of the sample, volumetric strain
/// positive in extension, Dim 2 (discs) or 3 (spheres).
inline double equivalentRadiusRatio(double n0, double volumetricStrain, double iceSaturation, int dim)
{
	return std::pow((1. - n0 + (n0 + volumetricStrain) * iceSaturation) / (1. - n0), 1. / dim);
}

} // namespace talik
