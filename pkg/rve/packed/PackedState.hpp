// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <Eigen/Core>
#include <memory>
#include <pkg/base/Dimensions.hpp>
#include <pkg/icebond/IceBond.hpp>
#include <pkg/icebond/IceLaws.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace talik {

/// Resistance of grains to rolling on each other, with the names of YADE's CohFrictMat. A sample without friction of rolling carries none.
struct PackedRolling {
	double alphaKr = 0; ///< rolling stiffness over k_s R_1 R_2 [-], >= 0
	double etaRoll = 0; ///< largest moment over normal force and smaller radius [-], >= 0
	bool   acts() const { return alphaKr > 0 && etaRoll > 0; }
	/// k_r of a contact with the shear stiffness k_s [N m]
	double stiffness(double shearStiffness, double r1, double r2) const { return alphaKr * shearStiffness * r1 * r2; }
	/// Largest moment over normal force [m]
	double lever(double r1, double r2) const { return etaRoll * std::min(r1, r2); }
	bool   operator==(const PackedRolling& other) const { return alphaKr == other.alphaKr && etaRoll == other.etaRoll; }
};

/// What never changes in the life of a sample; shared by every sample that comes from the same preparation.
struct PackedGrains {
	std::vector<double>       radius;  ///< r_0 [m], > 0
	std::vector<double>       mass;    ///< [kg], > 0
	std::vector<double>       inertia; ///< about the axis of rotation [kg m^2], > 0
	std::vector<std::int32_t> id;      ///< body id in the scene the sample comes from
	PackedRolling             rolling {};
	BondSection               section {}; ///< of bonds that carry moments
	HertzMindlin              hertz {};   ///< of grains without linear springs
	std::size_t               size() const { return radius.size(); }
	bool                      sameButRadii(const PackedGrains& other) const
	{
		return mass == other.mass && inertia == other.inertia && id == other.id && rolling == other.rolling && section == other.section
		        && hertz == other.hertz;
	}
	bool operator==(const PackedGrains& other) const { return radius == other.radius && sameButRadii(other); }
};

/// Types that differ between discs (Dim 2) and spheres (Dim 3).
template <int Dim> struct PackedTypes {
	static_assert(Dim == 2 || Dim == 3, "discs or spheres");
	using Vector   = Eigen::Matrix<double, Dim, 1>;
	using Matrix   = Eigen::Matrix<double, Dim, Dim>;
	using Spin     = std::conditional_t<Dim == 2, double, Eigen::Matrix<double, 3, 1>>; ///< angular velocity [rad/s]
	using Shear    = std::conditional_t<Dim == 2, double, Eigen::Matrix<double, 3, 1>>; ///< shear force [N], see PackedContacts
	using CellDist = std::array<std::int8_t, Dim>;
};

/// Contacts that carry history, arrays of equal length. In two dimensions the shear force is the scalar s along
/// t = z x n, n from grain `first` to grain `second`: the force on `second` is F_n n + s t. In three dimensions it is the vector
/// that acts on `second`. Compression is positive in F_n.
template <int Dim> struct PackedContacts {
	std::vector<std::uint16_t>                       first, second; ///< grain indices, first < second
	std::vector<typename PackedTypes<Dim>::CellDist> cellDist;      ///< c of branch x_2 + H c - x_1
	std::vector<typename PackedTypes<Dim>::Shear>    shear;         ///< [N]

	std::vector<typename PackedTypes<Dim>::Spin> moment; ///< of rolling, on `second` [N m]; empty in a sample whose grains roll freely

	/// Bond data, all empty in a sample that carries no bond.
	std::vector<typename PackedTypes<Dim>::Shear> iceShear;       ///< the part of `shear` carried by ice [N]
	std::vector<double>                           iceReference;   ///< u_ice: overlap at which the ice spring is free [m]
	std::vector<double>                           grainReference; ///< u_grain: the same of the cemented grain spring [m]
	std::vector<typename PackedTypes<Dim>::Spin>  bondMoment;     ///< on `second` [N m]; empty in a sample whose bonds carry no moments
	std::vector<std::uint8_t>                     bond;           ///< a BondState, plus iceSpringUncut for a broken bond that still pushes

	static constexpr std::uint8_t iceSpringUncut = 4;
	static std::uint8_t           encode(const IceBond& bond)
	{
		return std::uint8_t(std::uint8_t(bond.state) | (!bond.intact() && bond.hasIceSpring() ? iceSpringUncut : 0));
	}
	IceBond iceBond(std::size_t k) const
	{
		const BondState state = BondState(bond[k] & 3);
		return { state, state == BondState::BROKEN && !(bond[k] & iceSpringUncut), grainReference[k], iceReference[k] };
	}
	std::size_t size() const { return first.size(); }
};

/// Shrinkage of ice-rich grains on thawing (eq. (8), "mechanical" radius), for grains prepared frozen with the radii r_0:
/// (r/r_0)^Dim = 1 - thawStrain (1 - S_i/S_frozen), which is eq. (8) for thawStrain = n_0. 0 is the bookkeeping rule.
/// Shrinkage is not undone by refreezing.
struct PackedThawStrain {
	double thawStrain       = 0; ///< area (spheres: volume) of the grains lost on complete thaw over that prepared [-], 0 to below 1
	double frozenSaturation = 0; ///< S_frozen, largest ice saturation so far [-]
};

/// Parameters and cell of a sample: its state without the arrays of grains and contacts.
template <int Dim> struct PackedParameters {
	using Vector = typename PackedTypes<Dim>::Vector;
	using Matrix = typename PackedTypes<Dim>::Matrix;

	Matrix hSize          = Matrix::Identity(); ///< cell vectors in columns [m]
	Matrix prevHSize      = Matrix::Identity(); ///< the same one step ago
	Matrix velGrad        = Matrix::Zero();     ///< L that moves the cell in the next step [1/s]
	Matrix prevVelGrad    = Matrix::Zero();     ///< L that the integrator used last (zero in a fresh YADE integrator)
	Matrix nextVelGrad    = Matrix::Zero();     ///< L that comes into force in the integrator of the next step
	Matrix trsf           = Matrix::Identity(); ///< accumulated deformation gradient
	Matrix stress         = Matrix::Zero();     ///< Love-Weber stress of the last step, tension positive, not symmetrised [Pa]
	double dt             = 1.5e-5;             ///< [s], > 0
	double damping        = 0.2;                ///< numerical damping of the integrator [-], 0 to 1
	double thickness      = 0.1;                ///< of the slice that carries the forces of discs: stress is divided by it [m], > 0
	double friction       = 0.5;                ///< tangent of the contact friction angle [-], >= 0
	double stiffnessRatio = 0.8;                ///< k_s/k_n [-], >= 0; of Hertz's grains at one overlap, that of their ice, too
	double density        = 2650;               ///< of grains, of discs mass over area and thickness; for the inertial number only [kg/m^3], > 0

	IceBondModel     ice;               ///< ice.young is the contact modulus of the grains, with or without bonds
	double           iceSaturation = 0; ///< S_i [-]
	PackedThawStrain thawStrain;
	double           radiusFactor = 1; ///< r/r_0 of every grain at present [-]
	std::uint64_t    step         = 0;

	std::uint64_t bondsFormed = 0, bondsBrokenInTension = 0, bondsBrokenInShear = 0, bondsMelted = 0; ///< since preparation

	std::uint64_t cellSlips      = 0; ///< how often a thin cell slipped, see CellSlip.hpp
	double        cellSlipStrain = 0; ///< that it took to carry the stress again, in all [-]
	double        cellSlipStress = 0; ///< the most that was missing then, norm of a tensor [Pa]

	/// V of the stress: cell area times thickness for discs, cell volume for spheres [m^3].
	double volume() const;
	/// Throws std::invalid_argument naming the attribute, its value and a remedy.
	void checkParameters() const;
};

/// Whole state of a periodic sample: what is kept between updates, saved and loaded. Plain data.
template <int Dim> struct PackedState : PackedParameters<Dim> {
	using Vector = typename PackedTypes<Dim>::Vector;
	using Matrix = typename PackedTypes<Dim>::Matrix;

	std::shared_ptr<const PackedGrains>          grains;
	std::vector<Vector>                          position;        ///< unwrapped [m]
	std::vector<Vector>                          velocity;        ///< contains velGrad * position, as in YADE [m/s]
	std::vector<typename PackedTypes<Dim>::Spin> angularVelocity; ///< [rad/s]
	std::vector<double>                          orientation;     ///< angle of discs [rad]; empty for spheres, whose motion does not depend on it
	PackedContacts<Dim>                          contacts;

	std::size_t size() const { return position.size(); }
	bool        bonded() const { return !contacts.bond.empty(); }
	bool        resistsRolling() const { return grains->rolling.acts(); }
	bool        bondsCarryMoments() const { return grains->section.acts(); }

	/// Everything, grains' constants included; fromBytes(toBytes()) is bit-equal. Throws std::runtime_error on foreign or damaged bytes.
	std::string        toBytes() const;
	static PackedState fromBytes(const std::string& bytes);

	/// Throws std::invalid_argument naming the attribute, its value and a remedy.
	void check() const;
};

/// HertzMindlin::overLinear of a sample under its stress, or under a multiple of it.
template <int Dim> double overLinear(const PackedParameters<Dim>& p, const PackedGrains& grains, double radius, double times = 1)
{
	return grains.hertz.overLinear(p.ice.young, -times * p.stress.trace() / Dim, Dim == 2 ? p.thickness / radius : 1);
}

/// The dimension of a state in bytes: 2 or 3. Throws std::runtime_error on foreign or damaged bytes.
int packedDimension(const std::string& bytes);

/// Measures of a sample, all computed from its state.
template <int Dim> struct PackedStatistics {
	std::size_t                       contacts = 0, bondsIntact = 0, bondsBroken = 0;        ///< broken: contacts in state BROKEN at present
	double                            coordinationNumber = 0;                                ///< 2 contacts/grains [-]
	double                            porosity           = 0;                                ///< 1 - grain area/cell area [-]
	double                            kineticEnergy      = 0;                                ///< of velocity fluctuations and rotation [J]
	double                            unbalancedForce    = 0;                                ///< mean |net force on a grain|/mean |contact force| [-]
	double                            meanOverlapRatio   = 0;                                ///< mean overlap/(r_1 + r_2) of touching pairs [-]
	double                            maxOverlapRatio    = 0;                                ///< largest overlap/min radius [-]
	double                            cellThickness      = 0;                                ///< distance of a grain's next image/mean diameter [-]
	typename PackedTypes<Dim>::Matrix fabric             = PackedTypes<Dim>::Matrix::Zero(); ///< mean n (x) n [-]
};

/// Elastic upper bound of the tangent, eq. (13.4): C_ijkl = 1/V sum (k_n n_i l_j n_k l_l + k_s t_i l_j t_k l_l) [Pa], index ((i Dim+j) Dim+k) Dim+l.
template <int Dim> using PackedTangent = std::array<double, Dim * Dim * Dim * Dim>;

} // namespace talik
