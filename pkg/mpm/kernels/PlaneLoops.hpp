// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/WeightBlock.hpp>

#include <vector>

namespace talik {

/// The inner loops of two-dimensional ground, in versions for several processors; the best one that the processor knows is chosen
/// once. All versions do the same operations in the same order. Those for processors that multiply and add in one rounding (all
/// since 2013) give the same bits, and so do those that round twice. Arrays of points are whole arrays, indexed by place; arrays of
/// nodes begin at node 0.
struct PlaneLoops {
	const char* name;
	bool        roundsOnce; ///< multiplies and adds in one rounding

	/// Factors and slopes along one axis, in the plane or in space.
	using AxisWeights = double[supportNodes][blockSize];
	/// Quadratic B-spline along one axis of `count` points; adds node * stride to base.
	void (*spline)(int count, const double* x, double lower, double inverseSpacing, int stride, int* base, AxisWeights& value, AxisWeights& slope);
	/// Node record [mass, momentum x, y, unused, force x, y, capacity, capacity times carried].
	static constexpr int motionSize = 8;
	struct MotionMap {
		const double *mass, *volume;
		const double* meanStress; ///< replaces that of the stress; may be null
		const double* velocity[2];
		const double* stress[4];          ///< xx, yy, zz, xy
		const double *capacity, *carried; ///< of a quantity mapped along; may be null
		double        carriedFrom;        ///< carried counts from here
		double*       nodes;
	};
	void (*mapMotion)(const WeightBlock<2>& w, const MotionMap& a);

	/// Node record [change x, y, velocity x, y].
	struct MotionGather {
		const double* nodes;
		double *      velocity[2], *position[2], *displacement[2];
		double*       gradient[4];
		double        kept, dt;
	};
	void (*gatherMotion)(const WeightBlock<2>& w, const MotionGather& a);

	/// Adds S value to a record of 8 numbers; values[i][k] of point k of the block.
	void (*mapEight)(const WeightBlock<2>& w, const double (&values)[8][blockSize], double* nodes);
	/// Adds S values to a record of 2 numbers.
	void (*mapTwo)(const WeightBlock<2>& w, const double (&values)[2][blockSize], double* nodes);
	/// Sums S record of 8 numbers.
	void (*gatherEight)(const WeightBlock<2>& w, const double* nodes, double (&sums)[8][blockSize]);
	/// Sums S number.
	void (*gatherScalar)(const WeightBlock<2>& w, const double* nodes, double (&sums)[blockSize]);

	/// Conduction in a step, temperatures of nodes relative to that of reference: heat -V kappa duration grad T . grad S + V produced S, and what the grid does
	/// not see, C (T_grid - T) S.
	struct HeatFlow {
		const double *volume, *conductivity, *capacity, *temperature;
		double        duration, produced, reference;
	};
	/// Nodal T; receives [heat, unseen].
	void (*flowHeat)(const WeightBlock<2>& w, const HeatFlow& h, const double* potential, double* received);
	/// Node record [p, -, -, T]; receives [sum V S grad p (x, y), heat, unseen].
	static constexpr int potentialSize = 4;
	void (*flowPressure)(const WeightBlock<2>& w, const double* volume, const double* potential, double* received);
	void (*flowHeatAndPressure)(const WeightBlock<2>& w, const HeatFlow& h, const double* potential, double* received);

	/// Flux record of 2 numbers; adds mass, its enthalpy and its momentum to the first 4 numbers of a record of 8.
	struct Seepage {
		const double* flux;
		const double* volume;
		const double* velocity[2]; ///< of the liquid
		const double* temperature; ///< null: the water carries no enthalpy
		double        massPerFlux, specificHeat, enthalpyAtZero;
		double*       exchange;
	};
	void (*seep)(const WeightBlock<2>& w, const Seepage& s);

	/// Hooke's law with the midpoint rotation, count points in sequence: stress xx, yy, zz, xy and gradient at the first; Lame's
	/// moduli of each.
	void (*elastic)(int count, const double* lambda, const double* shear, const double* const (&gradient)[4], double* const (&stress)[4]);

	/// Of points in sequence with stress xx, yy, zz, xy: 1 where some principal stress passes tensileStrength or some pair of them the
	/// cone of Mohr and Coulomb, (high - low) + (high + low) sinFriction > 2 c cosFriction; else 0.
	struct Strength {
		const double *cohesion, *tensileStrength;
		double        sinFriction, cosFriction;
	};
	void (*findYielding)(int count, const Strength& strength, const double* const (&stress)[4], long long* yielding);

	/// The smallest and the largest of some numbers, count >= 1.
	struct Extent {
		double low, high;
		bool   numbers; ///< false: one of them is not finite
	};
	Extent (*extent)(int count, const double* x);
};

/// The loops for this processor.
const PlaneLoops& planeLoops();

/// All versions that this processor can run.
std::vector<const PlaneLoops*> planeLoopVersions();

} // namespace talik
