// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <memory>
#include <pkg/icebond/IceLaws.hpp>
#include <pkg/rve/packed/PackedState.hpp>
#include <string>

namespace talik {

template <int Dim> class PackedWorkspace;

/// How a macroscopic increment is applied to a sample.
struct PackedUpdateOptions {
	double              maxInertialNumber   = 5e-3;  ///< I_max of eq. (13.1) [-]: 1e-3 careful, 5e-3 production
	double              maxStrainPerStep    = 1e-5;  ///< largest strain of one DEM step as long as that of the state [-]
	long                minSteps            = 10;    ///< N_min
	bool                timeStepFollowsIce  = true;  ///< steps of the motion are longer where ice is missing that the time step allows for
	long                steps               = 0;     ///< > 0: exactly this many moving steps, the two limits above are not asked
	double              pressureFloor       = 1e3;   ///< P in eq. (13.1) is never taken smaller [Pa]
	double              saturationIncrement = 0.02;  ///< largest change of ice saturation at once [-]
	long                stepsPerSaturation  = 2;     ///< steps at zero velocity gradient after each of them
	long                relaxSteps          = 0;     ///< steps at zero velocity gradient after the motion
	double              flipSkew            = 0.5;   ///< the cell is flipped when a skew passes this; <= 0: never
	bool                tangent             = false; ///< also return the elastic tangent of the contact network
	BondStrengthFactors strength {};                 ///< of the ice bonds in this update
	double              iceStiffness = 1;            ///< stiffness of ice in this update over that of the material, > 0 [-]
	BondCreep           creep {};                    ///< of the ice bonds in this update, before the motion
};

/// What an update did.
template <int Dim> struct PackedUpdateResult {
	typename PackedTypes<Dim>::Matrix stress      = PackedTypes<Dim>::Matrix::Zero(); ///< symmetrised, tension positive [Pa]
	long                              steps       = 0;
	long                              movingSteps = 0; ///< of them
	bool                              flipped     = false;
	bool                              slipped     = false; ///< a thin cell has slipped, see CellSlip.hpp; the stress is that after it
	bool                              blewUp      = false; ///< the state is the last good one, the stress is that state's
	std::string                       reason;              ///< why it blew up, empty otherwise
	PackedTangent<Dim>                tangent {};          ///< if asked for, see PackedSample::tangent
	double rateError = 0; ///< of the steps asked for, if rates were compared: norm of the stress less that of infinitely slow motion [Pa]
};

/// Drives the cell until the sample carries given stresses.
template <int Dim> struct PackedServoOptions {
	typename PackedTypes<Dim>::Vector principalStress = PackedTypes<Dim>::Vector::Constant(
	        -1e5);                   ///< sigma_xx, sigma_yy(, sigma_zz), tension positive [Pa], < 0
	double stressTolerance   = 1e-3; ///< of the largest target [-]
	double unbalancedLimit   = 1e-3; ///< [-]
	double maxInertialNumber = 2e-3; ///< bounds the strain rate, eq. (13.1) [-]
	long   maxSteps          = 400000;
	long   interval          = 10; ///< steps between two corrections of the strain rate
};

/// One periodic sample of discs (Dim 2) or spheres (Dim 3), advanced by the fused step. Follows stock YADE 2023.02a
/// (ScGeom, Cundall-Strack, NewtonIntegrator with homoDeform 2) step by step, plus the ice bonds of IceBond.hpp.
/// Not thread-safe; different samples may be used by different threads.
template <int Dim> class PackedSample {
public:
	using Vector = typename PackedTypes<Dim>::Vector;
	using Matrix = typename PackedTypes<Dim>::Matrix;

	/// Throws std::invalid_argument when the state is unusable.
	explicit PackedSample(const PackedState<Dim>& state);
	~PackedSample();
	PackedSample(PackedSample&&) noexcept;
	PackedSample& operator=(PackedSample&&) noexcept;

	PackedState<Dim> state() const;
	void             setState(const PackedState<Dim>& state);

	/// `steps` steps; velGrad [1/s, per DEM time] is pending in the first of them exactly as in YADE: the cell follows one step later.
	/// Throws std::runtime_error when the sample blows up; the state is then the one before the call.
	void advance(const Matrix& velGrad, long steps);
	/// As before with the velocity gradient in force.
	void advance(long steps);

	/// F_new = (1 + displacementGradient) F_old, and ice saturation to its target, in this order: ice at zero velocity gradient,
	/// then motion, then relaxation, then a flip of the cell where due. Never throws on blow-up: see the result.
	PackedUpdateResult<Dim> apply(const Matrix& displacementGradient, double targetIceSaturation, const PackedUpdateOptions& options = {});

	/// Changes ice saturation at once and at fixed geometry: bonds, strengths, stiffness, radii. Limits are checked in the next step.
	void setIceSaturation(double iceSaturation);
	/// Bonds every frictional pair with gap <= ice.bondRange R_min, stress-free, whatever the history of ice saturation. Returns their number.
	std::size_t bondAll();
	void        setFriction(double tangent);

	/// True when converged; the velocity gradient is zero afterwards. Throws std::invalid_argument on targets in tension.
	bool servo(const PackedServoOptions<Dim>& options);

	/// Flips the cell to its shortest equivalent vectors if a skew exceeds `skew`; physics unchanged. True if it flipped.
	bool flip(double skew = 0.5);

	/// Symmetrised Love-Weber stress of the last step, tension positive [Pa].
	Matrix                stress() const;
	PackedStatistics<Dim> statistics() const;
	PackedTangent<Dim>    tangent() const;

	/// What this sample's steps run on: the vectors in use as Highway names them, such as "AVX2", "AVX3" or "AVX3_DL" (AVX-512) or "NEON", or "portable".
	const char* path() const;
	/// Takes the portable path from now on, for all samples made afterwards (tests, comparisons).
	static void forcePortable(bool portable);

private:
	std::unique_ptr<PackedWorkspace<Dim>> workspace;
};

/// Cell motion per step: X with (1 + X)^steps = 1 + displacementGradient. Throws std::invalid_argument unless det(1 + dH) > 0 and the
/// principal root exists.
template <int Dim> typename PackedTypes<Dim>::Matrix matrixRootIncrement(const typename PackedTypes<Dim>::Matrix& displacementGradient, long steps);

} // namespace talik

/// One update of a sample in a workspace: what PackedSample and SamplePool share.
namespace talik {

/// Loads nothing: `workspace` holds `before` already. On blow-up the workspace holds `before` again and the result says so.
/// Throws std::invalid_argument for arguments that no sample could follow; the workspace is then undefined.
template <int Dim>
PackedUpdateResult<Dim> updateWorkspace(
        PackedWorkspace<Dim>& workspace, const PackedState<Dim>& before, const typename PackedTypes<Dim>::Matrix& displacementGradient,
        double targetIceSaturation, const PackedUpdateOptions& options);

/// What ends an update whose steps are done: the sample is sound, its cell is flipped where that is due; `before`: the count of steps then.
/// Throws std::runtime_error where it has blown up.
template <int Dim>
PackedUpdateResult<Dim> concludeUpdate(PackedWorkspace<Dim>& workspace, const PackedUpdateOptions& options, long movingSteps, std::uint64_t before);

/// Whether the cell is to be flipped, see PackedUpdateOptions::flipSkew.
template <int Dim> bool flipIsDue(const typename PackedTypes<Dim>::Matrix& hSize, const PackedUpdateOptions& options);

/// Number of moving steps for a displacement gradient, eq. (13.1), with stress and density of the parameters; timeStep of the motion [s].
template <int Dim>
long movingSteps(
        const PackedParameters<Dim>& parameters, double timeStep, double meanRadius, const typename PackedTypes<Dim>::Matrix& displacementGradient,
        const PackedUpdateOptions& options);

/// Strain of one DEM step at an inertial number, eq. (13.1), with stress and density of the parameters.
template <int Dim> double strainPerStep(const PackedParameters<Dim>&, double timeStep, double meanRadius, double inertialNumber, double pressureFloor);

/// Throws std::invalid_argument on a factor that no strength can have.
void checkStrength(const BondStrengthFactors& strength, double iceStiffness);

/// Throws std::invalid_argument on creep that no ice can have.
void checkCreep(const BondCreep& creep);

/// Throws std::invalid_argument naming the option.
void checkOptions(const PackedUpdateOptions& options);

/// What PackedSample::forcePortable last said.
bool portablePathForced();

} // namespace talik
