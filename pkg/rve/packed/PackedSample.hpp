// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/rve/packed/PackedWorkspace.hpp>

namespace talik {

/// Drives the cell until the sample carries given stresses.
template <int Dim> struct PackedServoOptions {
	typename PackedTypes<Dim>::Matrix stress = -1e5 * PackedTypes<Dim>::Matrix::Identity(); ///< symmetric, tension positive [Pa]

	double pressureFloor     = 1;    ///< the largest component is never taken smaller [Pa]
	double stressTolerance   = 1e-3; ///< of it [-]
	double unbalancedLimit   = 1e-3; ///< [-]
	double maxInertialNumber = 2e-3; ///< bounds the strain rate, eq. (13.1) [-]
	long   maxSteps          = 400000;
	long   interval          = 10; ///< steps between two corrections of the strain rate
};

/// One periodic sample of discs (Dim 2) or spheres (Dim 3), advanced by the fused step. Follows stock YADE 2023.02a
/// (ScGeom, Cundall-Strack, NewtonIntegrator with homoDeform 2) step by step, plus the ice bonds of IceBond.hpp.
/// Not thread-safe; different samples may be used by different threads.
template <int Dim> class PackedSample : public PackedWorkspace<Dim> {
public:
	using Vector = typename PackedTypes<Dim>::Vector;
	using Matrix = typename PackedTypes<Dim>::Matrix;

	/// Without a state; on the path that forcePortable() last said.
	PackedSample();
	/// Throws std::invalid_argument when the state is unusable.
	explicit PackedSample(const PackedState<Dim>& state);

	PackedState<Dim> state() const;
	void             setState(const PackedState<Dim>& state);

	/// `steps` steps; velGrad [1/s, per DEM time] is pending in the first of them exactly as in YADE: the cell follows one step later.
	/// Throws std::runtime_error when the sample blows up; the state is then the one before the call.
	void advance(const Matrix& velGrad, long steps);
	/// As before with the velocity gradient in force.
	void advance(long steps);

	/// F_new = (1 + displacementGradient) F_old, and ice saturation to its target, in this order: ice at zero velocity gradient,
	/// then motion, then relaxation, then a flip of the cell where due, then a slip. Never throws on blow-up: see the result.
	PackedUpdateResult<Dim> apply(const Matrix& displacementGradient, double targetIceSaturation, const PackedUpdateOptions& options = {});
	/// The same of a sample that has the state `before`, without a slip. On blow-up it has that state again. Throws std::invalid_argument for
	/// arguments that no sample could follow; the sample is then undefined.
	PackedUpdateResult<Dim> update(
	        const PackedState<Dim>& before, const Matrix& displacementGradient, double targetIceSaturation, const PackedUpdateOptions& options);
	/// What ends an update whose steps are done: the sample is sound, its cell is flipped where that is due; `before`: the count of steps then.
	/// Throws std::runtime_error where it has blown up.
	PackedUpdateResult<Dim> conclude(const PackedUpdateOptions& options, long movingSteps, std::uint64_t before);

	long   movingSteps(const Matrix& displacementGradient, const PackedUpdateOptions& options) const;
	Matrix motionPerStep(const Matrix& displacementGradient, long steps) const { return matrixRootIncrement<Dim>(displacementGradient, steps); }

	/// True when converged; the velocity gradient is zero afterwards. Throws std::invalid_argument on targets in tension.
	bool servo(const PackedServoOptions<Dim>& options);
	/// The same for any target; what is left of a sample that blows up is of no use.
	bool strainTowards(const PackedServoOptions<Dim>& options);

	/// Symmetrised Love-Weber stress of the last step, tension positive [Pa].
	Matrix stress() const;

	/// Takes the portable path from now on, for all samples made afterwards (tests, comparisons).
	static void forcePortable(bool portable);
	/// Whether a sample made now would run on another path.
	bool onOtherPath() const;
};

/// Throws std::invalid_argument naming the option.
void checkOptions(const PackedUpdateOptions& options);

} // namespace talik
