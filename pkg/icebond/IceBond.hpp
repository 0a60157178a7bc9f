// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <limits>
#include <pkg/icebond/BondParameters.hpp>
#include <type_traits>

namespace talik {

/// State of one contact with respect to ice. NONE: purely frictional; BONDED: an intact ice bond; BROKEN: the bond failed
/// mechanically, the contact is frictional until a melt resets it to NONE.
enum class BondState : int { NONE = 0, BONDED = 1, BROKEN = 2 };

/// Ice-dependent stiffness and strength of a grain contact, Yu & Zhao eqs (5)-(7). Its parameters are listed in BondParameters.hpp.
struct IceBondModel {
	double young = 0.6e9; ///< E_c0, contact modulus without ice [Pa], > 0
#define TALIK_MEMBER(name, initial, unit, range, mixing, help, note) double name = initial;
	TALIK_BOND_PARAMETERS(TALIK_MEMBER)
#undef TALIK_MEMBER

	/// Of grains that no ice bonds or stiffens, whatever the ice saturation.
	static IceBondModel none()
	{
		IceBondModel m;
		m.iceYoung = m.tensileStrength = m.iceTensileStrength = m.shearStrength = m.iceShearStrength = 0;
		m.bondSaturation                                                                             = std::numeric_limits<double>::infinity();
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
	double youngAt(double iceSaturation) const { return young + iceYoung * phi(iceSaturation); }
	/// Stiffness of the ice spring in units of the grain spring: E_c(S_i)/E_c0 - 1 [-].
	double iceStiffnessRatio(double iceSaturation) const { return iceYoung * phi(iceSaturation) / young; }
	/// eq. (5): tensile strength of a bond [Pa]; thawedStrength once melted.
	double tensileStrengthAt(double iceSaturation) const
	{
		return iceSaturation <= meltSaturation ? thawedStrength : tensileStrength + iceTensileStrength * phi(iceSaturation);
	}
	/// eq. (5): cohesive shear strength of a bond [Pa]; thawedStrength once melted.
	double shearStrengthAt(double iceSaturation) const
	{
		return iceSaturation <= meltSaturation ? thawedStrength : shearStrength + iceShearStrength * phi(iceSaturation);
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

/// Stiffness against rotation of one bond [N m].
struct MomentStiffness {
	double bending, twisting;
};

/// Section of the bonds that carry moments: of the area A_b, its edge at R_b = radiusFactor sqrt(A_b/pi), I = A_b R_b^2/4 and J = A_b R_b^2/2;
/// with the factor 1 a circle, eq. (14.11). Moments add to the stress at the edge, eq. (14.13) (parallel bond, Potyondy & Cundall 2004).
struct BondSection {
	double radiusFactor = 0; ///< R_b over the radius of a circle of the bond's area [-], >= 0; 0: bonds carry no moments
	double contribution = 1; ///< beta, share of the moments in the stress at the edge [-], 0 to 1 (Potyondy 2011)

	bool   acts() const { return radiusFactor > 0; }
	double radius(double area) const { return radiusFactor * std::sqrt(area / M_PI); }
	/// Of a bond whose ice has the normal stiffness k_ice [N/m].
	MomentStiffness stiffness(double area, double iceStiffness, double shearRatio) const
	{
		const double square = radius(area) * radius(area);
		return { 0.25 * iceStiffness * square, 0.5 * shearRatio * iceStiffness * square };
	}
	/// Force over the area that has the stress of a bending moment at the edge, over that moment [1/m]; half of it for a twisting moment.
	double edgeOverMoment(double area) const { return 4 * contribution / radius(area); }
	bool   operator==(const BondSection& other) const { return radiusFactor == other.radiusFactor && contribution == other.contribution; }
};

/// Stress that moments add at the edge of a bond's section, times the area of the bond [N].
template <class Number> struct EdgeForces {
	Number tension, shear;
};

/// Bonds that carry no moments.
struct NoMoments {};

} // namespace talik

/// The law of a contact that ice may bond, eqs (14.3), (14.4). Overlap u_n and normal force F_n are positive in compression; k_g is the stiffness of the
/// grains, k_ice that of the ice, mu the friction, A_b the area of the bond.
///  NONE     F_n = k_g u_n, |s| <= mu F_n; gone when u_n < 0.
///  BONDED   F_n = k_g (u_n - u_grain) + k_ice (u_n - u_ice); fails when F_n < -C_eta A_b, else when |s| > C_tau A_b + mu max(F_n, 0).
///           In tension: no force in that step, the ice spring is cut. In shear: u_grain = 0, F_n = k_g max(u_n, 0) + k_ice max(u_n - u_ice, 0),
///           |s| <= mu F_n; the ice spring is cut if it does not push.
///  BROKEN   as NONE once the ice spring is cut; until then F_n = k_g u_n + k_ice (u_n - u_ice), and it is cut when u_n <= u_ice.
/// Without an intact bond nothing is carried across a gap (u_n < 0). Whenever s is limited, the part s_ice carried by ice shrinks in
/// proportion. The limits of a step are in ContactForces.hpp; what a failure, a change of ice saturation, a melt and new ice do is here.
namespace talik {

/// Grains pressed together as elastic spheres: Hertz's normal force, Mindlin's shear stiffness without slip, of two materials as stock YADE mixes them.
struct HertzMindlin {
	double modulus    = 0; ///< 4/3 E* [Pa]; 0: the grains have linear springs
	double shearRatio = 0; ///< k_s/k_n, both at the same overlap [-]

	bool                acts() const { return modulus > 0; }
	static HertzMindlin of(double young1, double poisson1, double young2, double poisson2)
	{
		const double effective = young1 * young2 / ((1 - poisson1 * poisson1) * young2 + (1 - poisson2 * poisson2) * young1);
		const double shear     = 0.5 / ((2 - poisson1) * (1 + poisson1) / young1 + (2 - poisson2) * (1 + poisson2) / young2); // G*
		return { 4. / 3. * effective, 4 * shear / effective };
	}
	/// H of grains with such radii, F_n = H u^1.5, eq. (14.15) [N/m^1.5]; 0 of linear springs.
	double stiffness(double a, double b) const { return acts() ? modulus * std::sqrt(a * b / (a + b)) : 0; }
	/// Stiffness of the most loaded contacts under a pressure, at least 1 kPa, over that of the linear spring [-]; thickness: of discs, in radii, 1 of
	/// spheres. Their force is about ten times pressure, radius and thickness.
	double overLinear(double young, double pressure, double thickness) const
	{
		return acts() ? 1.5 * std::cbrt(5 * modulus * modulus * std::max(pressure, 1e3) * thickness) / young : 1;
	}
	bool operator==(const HertzMindlin& other) const { return modulus == other.modulus; }
};

/// Tangent of the normal force at an overlap, and the force before any limit.
struct NormalSpring {
	double tangent, force; ///< [N/m], [N]
};

/// A contact as one step sees it, F_n = stiffness u_n - offset. Number is double, or a vector with one contact in every lane.
/// Of Hertz's grains, F_n = stiffness u_n^1.5 + iceShare u_n - offset, until hertzResponse() of ContactForces.hpp.
template <class Number> struct ContactResponse {
	Number stiffness; ///< of the springs in force [N/m]; H [N/m^1.5]
	Number offset;    ///< [N]
	Number floor;     ///< < 0: an intact bond, which fails below this force; > 0: a broken one, to be settled below it; 0: no bond [N]
	Number cohesion;  ///< limit of the shear force of an intact bond without friction [N]
	Number iceShare;  ///< part of every shear increment that the ice carries [-]; k_ice [N/m]
};

/// Stiffness of one contact without ice and what ice saturation makes of it.
struct ContactStiffness {
	double grain;      ///< k_g, normal stiffness of the grains alone [N/m]
	double shearRatio; ///< k_s/k_n [-]
	double iceRatio;   ///< stiffness of the ice spring over k_g, IceBondModel::iceStiffnessRatio [-]
	double hertz = 0;  ///< H [N/m^1.5], or 0: the grains have linear springs, which bonds hold in tension, too

	bool   isHertz() const { return hertz > 0; }
	double ice() const { return grain * iceRatio; }
	double total() const { return isHertz() ? hertz : grain + ice(); }
	double withoutIce() const { return isHertz() ? hertz : grain; }
	double iceShare() const { return isHertz() ? ice() : iceRatio / (1 + iceRatio); }
	/// Of the ice in a shear increment at an overlap [-].
	double iceShareAt(double un) const { return isHertz() ? ice() / (ice() + grainSpring(un).tangent) : iceShare(); }
	/// The grains alone; no force across a gap.
	NormalSpring grainSpring(double un) const { return spring({ withoutIce(), 0, 0, 0, 0 }, std::max(un, 0.)); }
	/// Of a response that stems from this stiffness.
	NormalSpring spring(const ContactResponse<double>& c, double un) const
	{
		if (!isHertz()) return { c.stiffness, c.stiffness * un - c.offset };
		const double secant = c.stiffness * std::sqrt(std::max(un, 0.));
		return { 1.5 * secant + c.iceShare, (secant + c.iceShare) * un - c.offset };
	}
};

/// Stiffness of a grain on its contacts, of its motion and its rotation together, in units of the grain spring [-].
struct GrainStiffening {
	double ofRolling = 0; ///< what rolling adds
	double ofMoments = 0; ///< what moments of a bond add to the stiffness of its ice, in units of that
	double ofGrains  = 1; ///< HertzMindlin::overLinear
	double total(double iceStiffnessRatio) const { return ofGrains * (1 + ofRolling) + (1 + ofMoments) * iceStiffnessRatio; }
	/// The stiffer one of bending and twisting; shearRatio: k_s/k_n.
	static double momentsOf(const BondSection& section, double bondAreaFactor, double shearRatio)
	{
		return section.radiusFactor * section.radiusFactor * bondAreaFactor / (4 * M_PI) * std::max(1 / shearRatio, 2.);
	}
};

/// Time step that samples are prepared with, over sqrt(m/k) of the grain where that is smallest; k is its stiffness on a contact [-].
constexpr double timeStepOverPeriod = 0.3;

/// Forces at which an intact bond fails, eq. (5) times the area of the bond [N].
struct BondStrength {
	double tensile, shear;
};

/// Forces of one step. Shear is a scalar for discs, a vector for spheres.
template <class Number, class Shear> struct ContactForces {
	Number overlap, trialNormal; ///< [m], [N]: before any limit; of a bond that carries moments at the edge that is stretched most
	Shear  trialShear;           ///< before any limit [N]
	Shear  increment;            ///< what the trial shear has been reduced by in this step [N]
	Number normal;               ///< [N]
	Shear  shear, iceShear;      ///< [N]
};

enum class BondFailure { none, tension, shear };

inline double shearNorm(double shear) { return std::fabs(shear); }
inline double shearNorm(const Eigen::Matrix<double, 3, 1>& s) { return std::sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]); }

template <class Shear> void clearShear(Shear& shear)
{
	if constexpr (std::is_arithmetic<Shear>::value) shear = 0;
	else shear.setZero();
}

/// Memory of one contact: a grain spring beside an ice spring. The shear forces `shear`, and `iceShear` of which the ice carries, are kept by
/// who owns the contact [N].
struct IceBond {
	BondState state  = BondState::NONE;
	bool      iceCut = false; ///< the ice spring of a broken bond has opened and carries nothing any more
	double    uGrain = 0;     ///< overlap at which the grain spring of an intact bond is free [m]
	double    uIce   = 0;     ///< overlap at which the ice spring is free [m]

	bool intact() const { return state == BondState::BONDED; }
	bool hasIceSpring() const { return intact() || (state == BondState::BROKEN && !iceCut); }

	ContactResponse<double> response(const ContactStiffness& k, const BondStrength& strength) const
	{
		const double limit = -std::max(watched, strength.tensile);
		if (intact()) return { k.total(), (k.isHertz() ? 0 : k.grain * uGrain) + k.ice() * uIce, limit, strength.shear, k.iceShare() };
		if (!hasIceSpring()) return { k.withoutIce(), 0., state == BondState::NONE ? 0. : watched, 0., 0. };
		// the ice spring is relaxed, or the contact opens, where the force is this
		const double release = uIce > 0 ? k.grainSpring(uIce).force : -k.ice() * uIce;
		return { k.total(), k.ice() * uIce, std::max(watched, release), 0., k.iceShare() };
	}

	/// The bond without an ice spring that is relaxed at this overlap.
	IceBond relaxed(double un) const
	{
		IceBond now = *this;
		if (!intact() && hasIceSpring() && un <= uIce) now = { state, true, 0, 0 };
		return now;
	}

	/// New ice at overlap un is free of stress: no force appears. Reference of a bond across a gap is the gap. A broken bond whose
	/// ice still carries keeps what it carries.
	template <class Shear> void form(double un, Shear& iceShear)
	{
		if (!hasIceSpring()) {
			uIce = un;
			clearShear(iceShear);
		}
		state  = BondState::BONDED;
		iceCut = false;
		uGrain = std::min(un, 0.);
	}

	/// Ice grows free of stress (forces stay) or melts (melted ice drops its share), Yu & Zhao eqs (5)-(7).
	template <class Shear> void changeStiffness(const ContactStiffness& before, const ContactStiffness& after, double un, Shear& shear, Shear& iceShear)
	{
		if (hasIceSpring() && after.iceRatio < before.iceRatio) {
			const double kept = after.iceRatio / before.iceRatio;
			shear -= iceShear * (1 - kept);
			iceShear *= kept;
		} else if (hasIceSpring() && after.iceRatio > 0) {
			uIce = un - before.iceRatio / after.iceRatio * (un - uIce);
		}
	}

	/// The ice has become stiffer by a factor at overlap un; forces stay.
	void stiffenIce(double factor, double un)
	{
		if (hasIceSpring()) uIce = un - (un - uIce) / factor;
	}

	/// Complete melt: back to friction, the ice share of the shear force is gone.
	template <class Shear> void melt(Shear& shear, Shear& iceShear)
	{
		if (state == BondState::NONE) return;
		shear -= iceShear;
		clearShear(iceShear);
		*this = IceBond();
	}

	/// A bond at its limit fails, in tension first; a broken one below its floor opens, or its ice spring is relaxed. From the trial
	/// forces those of this step. thawed: the bond has outlasted its ice and leaves a frictional contact, which new ice bonds again.
	template <class Shear>
	BondFailure settle(const ContactStiffness& k, const BondStrength& strength, double friction, bool thawed, ContactForces<double, Shear>& f)
	{
		BondFailure failure = BondFailure::none;
		f.shear             = f.trialShear;
		if (!intact()) {
			relax(k, f);
		} else if (f.trialNormal < response(k, strength).floor) {
			const bool bent = f.normal > response(k, strength).floor; // the edge of the section has failed before the section
			failure         = BondFailure::tension;
			*this           = broken(thawed);
			f.normal        = bent ? k.grainSpring(f.overlap).force : 0;
		} else {
			failure = BondFailure::shear;
			breakInShear(k, thawed, f);
		}
		if (f.overlap < 0) { // nothing holds or pushes across a gap any more
			f.normal = 0;
			iceCut   = state == BondState::BROKEN;
		}
		if (!hasIceSpring()) clearShear(f.iceShear);
		slide(friction * f.normal, f);
		return failure;
	}

private:
	/// Force that is different from zero and far too small to matter: marks a contact to be watched.
	static constexpr double watched = 1e-300;

	static IceBond broken(bool thawed) { return { thawed ? BondState::NONE : BondState::BROKEN, !thawed, 0, 0 }; }

	template <class Shear> static void slide(double limit, ContactForces<double, Shear>& f)
	{
		const double norm = shearNorm(f.shear);
		if (norm <= limit) return;
		if (limit == 0) clearShear(f.shear);
		f.shear *= limit / norm;
		f.iceShear *= limit / norm;
	}

	template <class Shear> void relax(const ContactStiffness& k, ContactForces<double, Shear>& f)
	{
		f.normal = k.grainSpring(f.overlap).force;
		if (!hasIceSpring()) return;
		if (f.overlap > uIce) {
			f.normal += k.ice() * (f.overlap - uIce);
		} else { // the ice takes no part in this step
			f.shear += f.increment * k.iceShareAt(f.overlap);
			*this = broken(false);
		}
	}

	template <class Shear> void breakInShear(const ContactStiffness& k, bool thawed, ContactForces<double, Shear>& f)
	{
		const double push = thawed ? 0. : k.ice() * std::max(f.overlap - uIce, 0.);
		f.normal          = push + k.grainSpring(f.overlap).force;
		if (push > 0) *this = { BondState::BROKEN, false, 0, uIce };
		else *this = broken(thawed);
	}
};

} // namespace talik
