// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <atomic>
#include <cmath>
#include <Eigen/LU>
#include <pkg/rve/packed/CellSlip.hpp>
#include <pkg/rve/packed/PackedSample.hpp>
#include <pkg/rve/packed/PackedWorkspace.hpp>
#include <pkg/rve/SampleUpdate.hpp>

namespace talik {

namespace {

	std::atomic<bool> portableForced { false };

	template <class M> M symmetric(const M& m)
	{
		const M transposed = m.transpose();
		return 0.5 * (m + transposed);
	}

	/// Square root of a matrix by the product form of Denman and Beavers; false when it does not exist or is not principal.
	template <class M> bool squareRoot(const M& a, M& root)
	{
		M y = a, z = M::Identity();
		for (int k = 0; k < 60; ++k) {
			const M      nextY = 0.5 * (y + z.inverse()), nextZ = 0.5 * (z + y.inverse());
			const double change = (nextY - y).norm();
			y                   = nextY;
			z                   = nextZ;
			if (!std::isfinite(change)) return false;
			if (change < 1e-15 * y.norm()) break;
		}
		root = y;
		return (y * y - a).norm() < 1e-12 * a.norm();
	}

} // namespace

bool portablePathForced() { return portableForced; }

/// (1 + dH)^(1/N) - 1, eq. (13.2).
template <int Dim> typename PackedTypes<Dim>::Matrix matrixRootIncrement(const typename PackedTypes<Dim>::Matrix& displacementGradient, long steps)
{
	using Matrix     = typename PackedTypes<Dim>::Matrix;
	const Matrix one = Matrix::Identity();
	if (!displacementGradient.allFinite() || !((one + displacementGradient).determinant() > 0))
		throw std::invalid_argument("packed sample: displacementGradient turns the sample inside out or is not finite; reduce the macroscopic step");
	if (steps < 1) throw std::invalid_argument("packed sample: steps = " + std::to_string(steps) + " must be positive");
	// log(1 + dH) = 2^k log((1 + dH)^(1/2^k)), the latter by its series
	Matrix a     = displacementGradient;
	double scale = 1;
	while (a.norm() > 0.1) {
		Matrix root;
		if (scale > 1024 || !squareRoot<Matrix>(one + a, root))
			throw std::invalid_argument(
			        "packed sample: displacementGradient has no principal root (a turn by 180 degrees); reduce the macroscopic step");
		a = root - one;
		scale *= 2;
	}
	Matrix logarithm = Matrix::Zero(), power = a;
	for (int k = 1; k <= 20; ++k) {
		logarithm += (k % 2 ? 1. : -1.) / k * power;
		power = (power * a).eval();
	}
	const Matrix generator = logarithm * (scale / double(steps));
	// exp(generator) - 1; halved until its series converges at once
	int    halvings = 0;
	Matrix g        = generator;
	for (; g.norm() > 0.1; ++halvings)
		g *= 0.5;
	Matrix increment = Matrix::Zero();
	for (int k = 14; k >= 1; --k)
		increment = (g * (one + increment) / double(k)).eval();
	for (; halvings > 0; --halvings)
		increment = (2 * increment + increment * increment).eval();
	return increment;
}

/// The strain of one DEM step of eq. (13.1).
template <int Dim> double strainPerStep(const PackedParameters<Dim>& p, double timeStep, double meanRadius, double inertialNumber, double pressureFloor)
{
	const double pressure = std::max(-p.stress.trace() / Dim, pressureFloor);
	return inertialNumber * timeStep / (2 * meanRadius) * std::sqrt(pressure / p.density);
}

/// The number of moving steps N of eq. (13.1).
template <int Dim>
long movingSteps(
        const PackedParameters<Dim>& p, double timeStep, double meanRadius, const typename PackedTypes<Dim>::Matrix& displacementGradient,
        const PackedUpdateOptions& options)
{
	if (options.steps > 0) return options.steps;
	const double perStep = std::min(options.maxStrainPerStep, strainPerStep(p, timeStep, meanRadius, options.maxInertialNumber, options.pressureFloor));
	const double wanted  = std::ceil(displacementGradient.cwiseAbs().maxCoeff() / perStep);
	if (!(wanted < 1e9))
		throw std::invalid_argument("packed sample: displacementGradient needs " + std::to_string(wanted) + " DEM steps; reduce the macroscopic step");
	return std::max(options.minSteps, long(wanted));
}

template <int Dim> long PackedWorkspace<Dim>::movingSteps(const Matrix& displacementGradient, const PackedUpdateOptions& options) const
{
	return talik::movingSteps<Dim>(parameters(), view.dt, averageRadius, displacementGradient, options);
}

// ---------------------------------------------------------------------------------------------- one update

void checkOptions(const PackedUpdateOptions& o)
{
	const auto positive = [](const char* name, double value) {
		if (!(value > 0))
			throw std::invalid_argument(std::string("packed sample: option ") + name + " = " + std::to_string(value) + " must be positive");
	};
	positive("maxInertialNumber", o.maxInertialNumber);
	positive("maxStrainPerStep", o.maxStrainPerStep);
	positive("minSteps", double(o.minSteps));
	positive("pressureFloor", o.pressureFloor);
	positive("saturationIncrement", o.saturationIncrement);
	checkStrength(o.strength, o.iceStiffness);
	checkCreep(o.creep);
}

void checkCreep(const BondCreep& creep)
{
	if (creep.isPossible()) return;
	throw std::invalid_argument(
	        "packed sample: creep has the rate factor times its time " + std::to_string(creep.fluidity) + " Pa^-n and the exponent "
	        + std::to_string(creep.exponent) + "; both must be finite, the first one 0 or more, the exponent 1 or more");
}

void checkStrength(const BondStrengthFactors& strength, double iceStiffness)
{
	for (const double factor : { strength.tensile, strength.shear })
		if (!(factor > 0) || !std::isfinite(factor))
			throw std::invalid_argument(
			        "packed sample: the factor " + std::to_string(factor) + " on the strength of bonds must be positive and finite");
	if (!(iceStiffness > 0 && iceStiffness <= mostIceStiffness))
		throw std::invalid_argument(
		        "packed sample: the factor " + std::to_string(iceStiffness)
		        + " on the stiffness of ice must be positive and at most 2, which the time step bears; give a larger IceBondMat.iceYoung");
}

template <int Dim>
PackedUpdateResult<Dim> concludeUpdate(PackedWorkspace<Dim>& workspace, const PackedUpdateOptions& options, long movingSteps, std::uint64_t before)
{
	workspace.checkHealth();
	PackedUpdateResult<Dim> result;
	result.movingSteps = movingSteps;
	result.flipped     = options.flipSkew > 0 && workspace.flip(options.flipSkew);
	result.stress      = symmetric<typename PackedTypes<Dim>::Matrix>(workspace.lastStress());
	result.steps       = long(workspace.parameters().step - before);
	if (options.tangent) result.tangent = workspace.tangent();
	workspace.setIceStiffness(1);
	return result;
}

template <int Dim> bool flipIsDue(const typename PackedTypes<Dim>::Matrix& hSize, const PackedUpdateOptions& options)
{
	return options.flipSkew > 0 && cellReduction<Dim>(hSize, std::max(options.flipSkew, 0.5)) != Eigen::Matrix<int, Dim, Dim>::Identity();
}

template <int Dim>
PackedUpdateResult<Dim> updateWorkspace(
        PackedWorkspace<Dim>& workspace, const PackedState<Dim>& before, const typename PackedTypes<Dim>::Matrix& displacementGradient,
        double targetIceSaturation, const PackedUpdateOptions& options)
{
	try {
		const auto start = workspace.parameters().step;
		workspace.setStrengthFactors(options.strength);
		workspace.setIceStiffness(options.iceStiffness);
		const long moving = SampleUpdate<PackedWorkspace<Dim>>(workspace, options).perform(displacementGradient, targetIceSaturation);
		return concludeUpdate<Dim>(workspace, options, moving, start);
	} catch (const std::runtime_error& problem) {
		const std::string ofCell = ofThinCell(workspace.cellThickness());
		workspace.load(before);
		PackedUpdateResult<Dim> result;
		result.stress = symmetric<typename PackedTypes<Dim>::Matrix>(before.stress);
		result.blewUp = true;
		result.reason = problem.what() + ofCell;
		return result;
	}
}

// ---------------------------------------------------------------------------------------------- servo

namespace {

	template <int Dim> class Servo {
		using Matrix = typename PackedTypes<Dim>::Matrix;

	public:
		Servo(PackedWorkspace<Dim>& sample, const PackedServoOptions<Dim>& chosen)
		        : workspace(sample)
		        , options(chosen)
		{
			scale = options.principalStress.cwiseAbs().maxCoeff();
		}

		bool perform()
		{
			bool converged = false;
			long done      = 0;
			for (; done < options.maxSteps && !converged; done += options.interval) {
				workspace.setNextVelGrad(correction(done));
				workspace.run(options.interval, options.interval);
				if (done / options.interval % 20 == 0) stiffness = workspace.largestModulus();
				if (withinTolerance()) converged = atRest();
			}
			workspace.setNextVelGrad(Matrix::Zero());
			workspace.run(2);
			workspace.checkHealth();
			return converged;
		}

	private:
		Matrix error() const
		{
			Matrix target = Matrix::Zero();
			for (int d = 0; d < Dim; ++d)
				target(d, d) = options.principalStress[d];
			return target - symmetric<Matrix>(workspace.lastStress());
		}

		bool withinTolerance() const { return error().cwiseAbs().maxCoeff() < options.stressTolerance * scale; }
		bool atRest() const { return workspace.statistics().unbalancedForce < options.unbalancedLimit; }

		/// Strain rate that would remove a share of the stress error during one interval, within the inertial limit.
		Matrix correction(long done)
		{
			// Loose spheres near failure are softer than their contacts: what removes a fifth at the stiffness of these takes too long. Discs
			// reach their stress with it, and collapse near failure with more.
			constexpr long patience = 100000; // steps
			const double   share    = Dim == 3 && done >= patience ? 0.6 : 0.2;
			if (stiffness == 0) stiffness = workspace.largestModulus();
			PackedParameters<Dim> p = workspace.parameters();
			p.stress                = Matrix::Identity() * -scale;
			const double limit      = strainPerStep<Dim>(p, p.dt, workspace.meanRadius(), options.maxInertialNumber, 1.) / p.dt;
			const double gain       = share / (stiffness * double(options.interval) * p.dt);
			const auto   bounded    = [limit](double rate) { return std::max(-limit, std::min(limit, rate)); };
			return Matrix(gain * error()).unaryExpr(bounded);
		}

		PackedWorkspace<Dim>&          workspace;
		const PackedServoOptions<Dim>& options;
		double                         scale = 0, stiffness = 0;
	};

} // namespace

// ---------------------------------------------------------------------------------------------- the sample

template <int Dim>
PackedSample<Dim>::PackedSample(const PackedState<Dim>& state)
        : workspace(std::make_unique<PackedWorkspace<Dim>>(portablePathForced()))
{
	setState(state);
}
template <int Dim> PackedSample<Dim>::~PackedSample()                                       = default;
template <int Dim> PackedSample<Dim>::PackedSample(PackedSample&&) noexcept                 = default;
template <int Dim> PackedSample<Dim>& PackedSample<Dim>::operator=(PackedSample&&) noexcept = default;

template <int Dim> PackedState<Dim> PackedSample<Dim>::state() const
{
	PackedState<Dim> state;
	workspace->store(state);
	return state;
}

template <int Dim> void PackedSample<Dim>::setState(const PackedState<Dim>& state)
{
	state.check();
	workspace->load(state);
}

template <int Dim> void PackedSample<Dim>::advance(const Matrix& velGrad, long steps)
{
	if (!velGrad.allFinite()) throw std::invalid_argument("packed sample: velGrad is not finite; give a velocity gradient in 1/s");
	const Matrix before = workspace->parameters().nextVelGrad;
	workspace->setNextVelGrad(velGrad);
	try {
		advance(steps);
	} catch (...) {
		workspace->setNextVelGrad(before);
		throw;
	}
}

template <int Dim> void PackedSample<Dim>::advance(long steps)
{
	if (steps < 0) throw std::invalid_argument("packed sample: steps = " + std::to_string(steps) + " must not be negative");
	const PackedState<Dim> before = state();
	try {
		workspace->run(steps);
		workspace->checkHealth();
	} catch (const std::runtime_error&) {
		workspace->load(before);
		throw;
	}
}

template <int Dim>
PackedUpdateResult<Dim> PackedSample<Dim>::apply(const Matrix& displacementGradient, double targetIceSaturation, const PackedUpdateOptions& options)
{
	checkOptions(options);
	if (!(targetIceSaturation >= 0 && targetIceSaturation <= 1))
		throw std::invalid_argument("packed sample: ice saturation " + std::to_string(targetIceSaturation) + " must lie in 0..1");
	PackedUpdateResult<Dim> result = updateWorkspace<Dim>(*workspace, state(), displacementGradient, targetIceSaturation, options);
	if (!result.blewUp) slipWhereThin<Dim>(*workspace, displacementGradient, options, result);
	return result;
}

template <int Dim> void        PackedSample<Dim>::setIceSaturation(double iceSaturation) { workspace->setIceSaturation(iceSaturation); }
template <int Dim> std::size_t PackedSample<Dim>::bondAll() { return workspace->bondAll(); }

template <int Dim> void PackedSample<Dim>::setFriction(double tangent)
{
	if (!(tangent >= 0)) throw std::invalid_argument("packed sample: friction = " + std::to_string(tangent) + " must not be negative");
	workspace->setFriction(tangent);
}

template <int Dim> bool PackedSample<Dim>::servo(const PackedServoOptions<Dim>& options)
{
	if (!options.principalStress.allFinite() || !(options.principalStress.maxCoeff() < 0))
		throw std::invalid_argument(
		        "packed sample: principalStress = " + std::to_string(options.principalStress.maxCoeff()) + " Pa must be compressive (negative)");
	const PackedState<Dim> before = state();
	try {
		return Servo<Dim>(*workspace, options).perform();
	} catch (const std::runtime_error&) {
		workspace->load(before);
		throw;
	}
}

template <int Dim> bool PackedSample<Dim>::flip(double skew) { return workspace->flip(skew); }

template <int Dim> typename PackedTypes<Dim>::Matrix PackedSample<Dim>::stress() const { return symmetric<Matrix>(workspace->lastStress()); }
template <int Dim> PackedStatistics<Dim>             PackedSample<Dim>::statistics() const { return workspace->statistics(); }
template <int Dim> PackedTangent<Dim>                PackedSample<Dim>::tangent() const { return workspace->tangent(); }
template <int Dim> const char*                       PackedSample<Dim>::path() const { return workspace->path(); }
template <int Dim> void                              PackedSample<Dim>::forcePortable(bool portable) { portableForced = portable; }

template PackedTypes<2>::Matrix matrixRootIncrement<2>(const PackedTypes<2>::Matrix&, long);
template PackedTypes<3>::Matrix matrixRootIncrement<3>(const PackedTypes<3>::Matrix&, long);
template long                   PackedWorkspace<2>::movingSteps(const Matrix&, const PackedUpdateOptions&) const;
template long                   PackedWorkspace<3>::movingSteps(const Matrix&, const PackedUpdateOptions&) const;
template long                   movingSteps<2>(const PackedParameters<2>&, double, double, const PackedTypes<2>::Matrix&, const PackedUpdateOptions&);
template long                   movingSteps<3>(const PackedParameters<3>&, double, double, const PackedTypes<3>::Matrix&, const PackedUpdateOptions&);
template double                 strainPerStep<2>(const PackedParameters<2>&, double, double, double, double);
template double                 strainPerStep<3>(const PackedParameters<3>&, double, double, double, double);
template PackedUpdateResult<2>  concludeUpdate<2>(PackedWorkspace<2>&, const PackedUpdateOptions&, long, std::uint64_t);
template PackedUpdateResult<3>  concludeUpdate<3>(PackedWorkspace<3>&, const PackedUpdateOptions&, long, std::uint64_t);
template bool                   flipIsDue<2>(const PackedTypes<2>::Matrix&, const PackedUpdateOptions&);
template bool                   flipIsDue<3>(const PackedTypes<3>::Matrix&, const PackedUpdateOptions&);
template PackedUpdateResult<2>  updateWorkspace<2>(
        PackedWorkspace<2>&, const PackedState<2>&, const PackedTypes<2>::Matrix&, double, const PackedUpdateOptions&);
template PackedUpdateResult<3> updateWorkspace<3>(
        PackedWorkspace<3>&, const PackedState<3>&, const PackedTypes<3>::Matrix&, double, const PackedUpdateOptions&);
TALIK_IN_PLANE_AND_SPACE(PackedSample);

} // namespace talik
