// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <pkg/rve/packed/PackedState.hpp>

/// The running form of a sample, as seen by the fused step.
namespace talik {

/// Pairs in a block: as many as the longest vectors have lanes. No result depends on it.
constexpr std::size_t packedWidth     = 8;
constexpr std::size_t packedAlignment = packedWidth * sizeof(double);

/// Layout of the running form, in numbers. The motion of discs are rows x, v, their forces rows sum of G, sum of s, sum of s u_n/2. Spheres
/// have rows of place x, w_x r, of speed v, w_y r, w, w_z r, and of force sum of G, 0, sum of moments, 0. G is minus the force on the grain.
template <int Dim> struct PackedLayout;
template <> struct PackedLayout<2> {
	static constexpr int row = 4, shear = 1, angular = 1; ///< row: the longest
};
template <> struct PackedLayout<3> {
	static constexpr int row = 8, shear = 3, angular = 3;
};

/// What spheres need of a pair beyond what discs do.
template <int Dim> struct PackedSpherePair {};
template <> struct PackedSpherePair<3> {
	double halfDifference[packedWidth]; ///< (r_1 - r_2)/2 [m]
};

/// Some pairs. `first` and `second` are where the longest rows of the grains begin. Pairs that do not touch carry zero shear and give zero force.
template <int Dim> struct alignas(packedAlignment) PackedBlock : PackedSpherePair<Dim> {
	double        shear[PackedLayout<Dim>::shear][packedWidth];
	double        sumRadius[packedWidth];
	double        stiffness[packedWidth];
	std::uint32_t first[packedWidth], second[packedWidth];
};
/// What ice adds to some pairs, see ContactResponse.
template <int Dim> struct alignas(packedAlignment) PackedIceBlock {
	double iceShear[PackedLayout<Dim>::shear][packedWidth];
	double offset[packedWidth];
	double floor[packedWidth];
	double cohesion[packedWidth];
	double iceShare[packedWidth];
};

/// What resistance to rolling adds to some pairs.
template <int Dim> struct alignas(packedAlignment) PackedRollingBlock {
	double moment[PackedLayout<Dim>::angular][packedWidth];       ///< on the second grain [N m]
	double stiffness[packedWidth];                                ///< k_r [N m]; with H in place of k_n [N m^0.5]
	double lever[packedWidth];                                    ///< largest moment over normal force [m]
	double inverseFirst[packedWidth], inverseSecond[packedWidth]; ///< of the radii [1/m]
};

/// What moments of bonds add to some pairs; stiffness and moment are zero where no bond is intact.
template <int Dim> struct alignas(packedAlignment) PackedMomentBlock {
	double moment[PackedLayout<Dim>::angular][packedWidth];       ///< on the second grain [N m]
	double bending[packedWidth], twisting[packedWidth];           ///< stiffness [N m]
	double edgeOverMoment[packedWidth];                           ///< see BondSection [1/m]
	double inverseFirst[packedWidth], inverseSecond[packedWidth]; ///< of the radii [1/m]
};

/// Pairs of one kind: inside the cell, or across its boundary (then `shift` gives where the rows of the shift table begin, for each pair).
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
	double*       place; ///< discs: x, v
	double*       speed; ///< spheres only
	double*       force;
	double *      turning, *rim, *angle; ///< discs only: w, w r, angle [rad]
	const double* minusInverseMass;
	const double* inverseInertia; ///< spheres: with a minus, as their moments are summed up
	const double* radius;
	const double* inverseSlackSquare; ///< see PackedLists
	std::size_t   grains;             ///< rows that are integrated; a multiple of packedWidth

	PackedPairs<Dim> inner, periodic;

	double*            shiftPlace; ///< rows H c, of discs with L H_prev c
	double*            shiftSpeed; ///< spheres only: rows L H_prev c
	double*            shiftForce; ///< rows: sum of G over the pairs with this shift, in steps that form the virial
	const std::int8_t* shiftCell;  ///< Dim entries per shift: c
	std::size_t        shifts;

	double hSize[Dim * Dim], prevHSize[Dim * Dim], trsf[Dim * Dim]; ///< row-major, cell vectors in columns
	double velGrad[Dim * Dim], prevVelGrad[Dim * Dim], nextVelGrad[Dim * Dim];

	double dt, damping, friction, stiffnessRatio;

	void* owner;
	void (*bondEvent)(void* owner, PackedBondEvent<Dim>* event);

	int    sampleStress;         ///< 1: this step forms the virial and the sums of shiftForce
	double virial[Dim * Dim];    ///< sum G (x) x over grains
	double maxFluctuationSquare; ///< of the step, (|v - L x| / slack)^2

	/// Whether the velocity gradient changes in this step.
	bool    jumps() const { return !std::equal(nextVelGrad, nextVelGrad + Dim * Dim, prevVelGrad); }
	double* position(std::size_t grain) const { return place + 4 * grain; }
	double* velocity(std::size_t grain) const { return Dim == 2 ? place + 4 * grain + 2 : speed + 8 * grain; }
	double& spin(std::size_t grain, int component) const { return Dim == 2 ? turning[grain] : speed[8 * grain + 4 + component]; }
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
	bool bonded, rolling, moments, hertz; ///< moments: of bonds; hertz: grains of Hertz and Mindlin
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
	const double* shift;         ///< row that begins with H c, or nullptr inside the cell
};

template <int Dim> inline PackedPairRows<Dim> pairRows(const PackedStepView<Dim>& view, const PackedPairs<Dim>& pairs, std::size_t lane)
{
	const PackedBlock<Dim>& block = pairs.block[lane / packedWidth];
	constexpr std::uint32_t row   = PackedLayout<Dim>::row;
	const std::size_t       l     = lane % packedWidth;
	return { block.first[l] / row, block.second[l] / row, pairs.shift ? view.shiftPlace + pairs.shift[lane] / row * 4 : nullptr };
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
template <int Dim> inline typename PackedTypes<Dim>::Shear laneShear(const double (&rows)[PackedLayout<Dim>::shear][packedWidth], std::size_t lane)
{
	if constexpr (Dim == 2) return rows[0][lane];
	else return { rows[0][lane], rows[1][lane], rows[2][lane] };
}

template <int Dim>
inline void setLaneShear(double (&rows)[PackedLayout<Dim>::shear][packedWidth], std::size_t lane, const typename PackedTypes<Dim>::Shear& shear)
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
