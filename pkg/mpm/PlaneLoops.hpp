// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/WeightBlock.hpp>

namespace talik {

/// The inner loops of two-dimensional ground, in versions for several processors. All versions do the same operations in the same
/// order and give the same bits; the best one that the processor knows is chosen once. Arrays of points are whole arrays,
/// indexed by place; arrays of nodes begin at node 0.
struct PlaneLoops {
	const char* name;

	/// Quadratic B-spline along one axis: factors, slopes; adds node * stride to base.
	void (*spline)(WeightBlock<2>& w, int axis, const double* x, double lower, double inverseSpacing, int stride);
	/// Products of factors and slopes.
	void (*multiply)(WeightBlock<2>& w);

	/// Node record [mass, momentum x, y, unused, force x, y].
	static constexpr int motionSize = 6;
	struct MotionMap {
		const double *mass, *volume, *meanStress;
		const double* velocity[2];
		const double* stress[4]; ///< xx, yy, zz, xy
		double*       nodes;
	};
	void (*mapMotion)(const WeightBlock<2>& w, const MotionMap& a);

	/// Node record [change x, y, velocity x, y].
	struct MotionGather {
		const double* nodes;
		double *      velocity[2], *position[2], *displacement[2];
		double*       gradient[4];
		double        flipFraction, dt;
	};
	void (*gatherMotion)(const WeightBlock<2>& w, const MotionGather& a);

	/// Adds S value to a record of 8 numbers; values[i][k] of point k of the block.
	void (*mapEight)(const WeightBlock<2>& w, const double (&values)[8][blockSize], double* nodes);
	/// Adds S values to a record of 2 numbers.
	void (*mapTwo)(const WeightBlock<2>& w, const double (&values)[2][blockSize], double* nodes);
	/// Sums S record of 2 and of 4 numbers.
	void (*gatherTwo)(const WeightBlock<2>& w, const double* nodes, double (&sums)[2][blockSize]);
	void (*gatherFour)(const WeightBlock<2>& w, const double* nodes, double (&sums)[4][blockSize]);
	/// Sums S and grad S times one number of a record of the given stride.
	void (*gatherScalar)(const WeightBlock<2>& w, const double* nodes, int stride, double (&value)[blockSize], double (&slope)[2][blockSize]);
	/// Adds (flux . grad S) values to a record of 4 numbers.
	void (*mapFluxFour)(const WeightBlock<2>& w, const double (&flux)[2][blockSize], const double (&values)[4][blockSize], double* nodes);
	/// Adds flux . grad S + S source.
	void (*mapFlux)(const WeightBlock<2>& w, const double (&flux)[2][blockSize], const double (&source)[blockSize], double* nodes);
	/// Adds S value.
	void (*mapScalar)(const WeightBlock<2>& w, const double (&value)[blockSize], double* nodes);

	/// Hooke's law with the midpoint rotation, count points in sequence: stress xx, yy, zz, xy and gradient at the first; Lame's
	/// moduli of each.
	void (*elastic)(int count, const double* lambda, const double* shear, const double* const (&gradient)[4], double* const (&stress)[4]);

	/// y = exp(x) to two units in the last place, for -700 < x < 700.
	void (*exponential)(int count, const double* x, double* y);
};

/// The loops for this processor.
const PlaneLoops& planeLoops();

/// All versions that this processor can run, the plain one first.
int planeLoopVersions(const PlaneLoops* (&versions)[3]);

} // namespace talik
