// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <pkg/rve/packed/PackedState.hpp>

/// The running form of a sample, as seen by the fused step.
namespace talik {

/// Layout of the running form, in numbers. Discs have rows of motion (x, v) and rows of force (sum of G, sum of s, sum of s u_n/2), spheres
/// one row for both: x, w_x r, v, w_y r, w, w_z r, sum of G, 0, sum of moments, 0. G is minus the force on the grain.
template <int Dim> struct PackedLayout;
template <> struct PackedLayout<2> {
	static constexpr int row = 4, velocity = 2, shear = 1, angular = 1;
};
template <> struct PackedLayout<3> {
	static constexpr int row = 20, velocity = 4, spin = 8, force = 12, moment = 16, shear = 3, angular = 3;
};

/// Turning of four grains: angular velocity [rad/s], and of discs the angle [rad].
template <int Dim> struct alignas(32) PackedTurning {
	double spin[PackedLayout<Dim>::angular][4];
};
template <> struct alignas(32) PackedTurning<2> {
	double spin[1][4];
	double angle[4];
};

/// What spheres need of a pair beyond what discs do.
template <int Dim> struct PackedSpherePair {};
template <> struct PackedSpherePair<3> {
	double halfDifference[4]; ///< (r_1 - r_2)/2 [m]
};

/// Four pairs. `first` and `second` are where the rows of the grains begin. Pairs that do not touch carry zero shear and give zero force.
template <int Dim> struct alignas(32) PackedBlock : PackedSpherePair<Dim> {
	double        shear[PackedLayout<Dim>::shear][4];
	double        sumRadius[4];
	double        stiffness[4];
	std::uint32_t first[4], second[4];
};
/// What ice adds to four pairs, see ContactResponse.
template <int Dim> struct alignas(32) PackedIceBlock {
	double iceShear[PackedLayout<Dim>::shear][4];
	double offset[4];
	double floor[4];
	double cohesion[4];
	double iceShare[4];
};

/// What resistance to rolling adds to four pairs.
template <int Dim> struct alignas(32) PackedRollingBlock {
	double moment[PackedLayout<Dim>::angular][4]; ///< on the second grain [N m]
	double stiffness[4];                          ///< k_r [N m]
	double lever[4];                              ///< largest moment over normal force [m]
	double inverseFirst[4], inverseSecond[4];     ///< of the radii [1/m]
};

/// What moments of bonds add to four pairs; stiffness and moment are zero where no bond is intact.
template <int Dim> struct alignas(32) PackedMomentBlock {
	double moment[PackedLayout<Dim>::angular][4]; ///< on the second grain [N m]
	double bending[4], twisting[4];               ///< stiffness [N m]
	double edgeOverMoment[4];                     ///< see BondSection [1/m]
	double inverseFirst[4], inverseSecond[4];     ///< of the radii [1/m]
};

/// Pairs of one kind: inside the cell, or across its boundary (then `shift` gives where four rows of the shift table begin per block).
template <int Dim> struct PackedPairs {
	PackedBlock<Dim>*        block;
	PackedIceBlock<Dim>*     ice;
	const std::uint32_t*     shift;
	std::size_t              blocks;
	PackedRollingBlock<Dim>* rolling;
	PackedMomentBlock<Dim>*  moments;
};

/// A bond that reached its limit, or a broken one whose force fell below its floor: in come the trial forces, out go those of this step.
template <int Dim> struct PackedBondEvent {
	int                                                     periodic;
	std::size_t                                             lane;
	ContactForces<double, typename PackedTypes<Dim>::Shear> forces;
};

template <int Dim> struct PackedStepView {
	double*             motion;
	double*             rim; ///< discs only: w r
	double*             force;
	PackedTurning<Dim>* turning;
	const double*       minusInverseMass;
	const double*       inverseInertia; ///< spheres: with a minus, as their moments are summed up
	const double*       radius;
	const double*       inverseSlackSquare; ///< see PackedLists
	std::size_t         grains;             ///< rows that are integrated; a multiple of four

	PackedPairs<Dim> inner, periodic;

	double*            shiftMotion; ///< rows (H c, L H_prev c)
	double*            shiftForce;  ///< rows: sum of G over the pairs with this shift, in steps that form the virial
	const std::int8_t* shiftCell;   ///< Dim entries per shift: c
	std::size_t        shifts;

	double hSize[Dim * Dim], prevHSize[Dim * Dim], trsf[Dim * Dim]; ///< row-major, cell vectors in columns
	double velGrad[Dim * Dim], prevVelGrad[Dim * Dim], nextVelGrad[Dim * Dim];

	double dt, damping, friction, stiffnessRatio;
	double bondFriction; ///< friction of an intact bond

	void* owner;
	void (*bondEvent)(void* owner, PackedBondEvent<Dim>* event);

	int    sampleStress;         ///< 1: this step forms the virial and the sums of shiftForce
	double virial[Dim * Dim];    ///< sum G (x) x over grains
	double maxFluctuationSquare; ///< of the step, (|v - L x| / slack)^2

	/// Whether the velocity gradient changes in this step.
	bool    jumps() const { return !std::equal(nextVelGrad, nextVelGrad + Dim * Dim, prevVelGrad); }
	double* position(std::size_t row) const { return motion + row * PackedLayout<Dim>::row; }
	double* velocity(std::size_t row) const { return position(row) + PackedLayout<Dim>::velocity; }
	double& spin(std::size_t grain, int component) const { return turning[grain / 4].spin[component][grain % 4]; }
};

/// The two halves of a step.
template <int Dim> struct PackedKernel {
	void (*contacts)(PackedStepView<Dim>*);
	void (*integrate)(PackedStepView<Dim>*);
	const char*  name;
	PackedKernel portable() const { return { contacts, integrate, "portable" }; }
};

/// What contacts of a sample carry beyond friction.
struct PackedContactKind {
	bool bonded, rolling, moments; ///< moments: of bonds
};

/// The fastest step that the processor at hand knows, or the one that all processors know.
template <int Dim> PackedKernel<Dim> stepKernel(PackedContactKind kind, bool portable);
template <> PackedKernel<2>          stepKernel<2>(PackedContactKind kind, bool portable);
template <> PackedKernel<3>          stepKernel<3>(PackedContactKind kind, bool portable);

} // namespace talik

/// Geometry and force of one pair in stock YADE's conventions.
namespace talik {

/// Where the two grains and the periodic shift of a pair are.
template <int Dim> struct PackedPairRows {
	std::uint32_t first, second; ///< grains
	const double* shift;         ///< row (H c, L H_prev c), or nullptr inside the cell
};

template <int Dim> inline PackedPairRows<Dim> pairRows(const PackedStepView<Dim>& view, const PackedPairs<Dim>& pairs, std::size_t lane)
{
	const PackedBlock<Dim>& block = pairs.block[lane / 4];
	constexpr std::uint32_t row   = PackedLayout<Dim>::row;
	return { block.first[lane % 4] / row, block.second[lane % 4] / row, pairs.shift ? view.shiftMotion + pairs.shift[lane] : nullptr };
}

/// Branch from first to second and its square.
template <int Dim> inline double pairBranch(const PackedStepView<Dim>& view, const PackedPairRows<Dim>& rows, double* branch)
{
	const double *a = view.position(rows.first), *b = view.position(rows.second);
	double        square = 0;
	for (int d = 0; d < Dim; ++d) {
		branch[d] = b[d] - a[d];
		if (rows.shift) branch[d] += rows.shift[d];
		square += branch[d] * branch[d];
	}
	return square;
}

/// Shear force in a lane of a block.
template <int Dim> inline typename PackedTypes<Dim>::Shear laneShear(const double (&rows)[PackedLayout<Dim>::shear][4], std::size_t lane)
{
	if constexpr (Dim == 2) return rows[0][lane];
	else return { rows[0][lane], rows[1][lane], rows[2][lane] };
}

template <int Dim> inline void setLaneShear(double (&rows)[PackedLayout<Dim>::shear][4], std::size_t lane, const typename PackedTypes<Dim>::Shear& shear)
{
	if constexpr (Dim == 2) rows[0][lane] = shear;
	else
		for (int d = 0; d < 3; ++d)
			rows[d][lane] = shear[d];
}

/// Force on second, F_n n + shear.
template <int Dim> inline void pairForce(const double* n, double normalForce, const typename PackedTypes<Dim>::Shear& shear, double* force)
{
	if constexpr (Dim == 2) {
		force[0] = normalForce * n[0] - shear * n[1];
		force[1] = normalForce * n[1] + shear * n[0];
	} else {
		for (int d = 0; d < 3; ++d)
			force[d] = normalForce * n[d] + shear[d];
	}
}

} // namespace talik
