// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <pkg/rve/packed/PackedState.hpp>

/// The running form of a sample, as seen by the fused step.
namespace talik {

/// Layout of the running form. Grain rows: motion (x, v), spin (discs: w r; spheres: w, r), force (discs: sum of G, sum of s,
/// sum of s u_n/2; spheres: sum of G, torque), where G is minus the force on the grain.
template <int Dim> struct PackedLayout;
template <> struct PackedLayout<2> {
	static constexpr int motion = 4, spin = 1, force = 4, shear = 1, normal = 0, angular = 1, orientation = 1;
};
template <> struct PackedLayout<3> {
	static constexpr int motion = 8, spin = 4, force = 8, shear = 3, normal = 3, angular = 3, orientation = 4;
};

/// Four pairs. `first` and `second` are row numbers times four. Pairs that do not touch carry zero shear and give zero force.
template <int Dim> struct alignas(32) PackedBlock {
	double        shear[PackedLayout<Dim>::shear][4];
	double        sumRadius[4];
	double        stiffness[4];
	std::uint32_t first[4], second[4];
};
/// Normals of the previous step, which only spheres need.
struct alignas(32) PackedNormals {
	double n[3][4];
};
/// What ice adds to four pairs, see ContactResponse.
template <int Dim> struct alignas(32) PackedIceBlock {
	double iceShear[PackedLayout<Dim>::shear][4];
	double offset[4];
	double floor[4];
	double cohesion[4];
	double iceShare[4];
};

/// Pairs of one kind: inside the cell, or across its boundary (then `shift` gives four rows, times four, of the shift table per block).
template <int Dim> struct PackedPairs {
	PackedBlock<Dim>*    block;
	PackedNormals*       normals;
	PackedIceBlock<Dim>* ice;
	const std::uint32_t* shift;
	std::size_t          blocks;
};

/// A bond that reached its limit, or a broken one whose force fell below its floor: in come the trial forces, out go those of this step.
template <int Dim> struct PackedBondEvent {
	int                                                     periodic;
	std::size_t                                             lane;
	ContactForces<double, typename PackedTypes<Dim>::Shear> forces;
};

template <int Dim> struct PackedStepView {
	double*       motion;
	double*       spin;
	double*       force;
	double*       angular;     ///< angular velocity
	double*       orientation; ///< angle or quaternion
	const double* minusInverseMass;
	const double* inverseInertia;
	const double* radius;
	std::size_t   grains; ///< rows that are integrated; a multiple of four

	PackedPairs<Dim> inner, periodic;

	double*            shiftMotion; ///< rows (H c, L H_prev c)
	double*            shiftForce;  ///< rows: sum of G over the pairs with this shift
	const std::int8_t* shiftCell;   ///< Dim entries per shift: c
	std::size_t        shifts;

	double hSize[Dim * Dim], prevHSize[Dim * Dim], trsf[Dim * Dim]; ///< row-major, cell vectors in columns
	double velGrad[Dim * Dim], prevVelGrad[Dim * Dim], nextVelGrad[Dim * Dim];

	double dt, damping, friction, stiffnessRatio;
	double bondFriction; ///< friction of an intact bond

	void* owner;
	void (*bondEvent)(void* owner, PackedBondEvent<Dim>* event);

	int    sampleStress;         ///< 1: this step forms the virial
	double virial[Dim * Dim];    ///< sum G (x) x over grains
	double maxFluctuationSquare; ///< of the step, |v - L x|^2
};

/// The two halves of a step.
template <int Dim> struct PackedKernel {
	void (*contacts)(PackedStepView<Dim>*);
	void (*integrate)(PackedStepView<Dim>*);
	const char* name;
};

/// The fastest step that the processor at hand knows, or the one that all processors know.
template <int Dim> PackedKernel<Dim> stepKernel(bool bonded, bool portable);
template <> PackedKernel<2>          stepKernel<2>(bool bonded, bool portable);
template <> PackedKernel<3>          stepKernel<3>(bool bonded, bool portable);

} // namespace talik
