// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <atomic>
#include <cmath>
#include <Eigen/LU>
#include <pkg/rve/packed/CellSlip.hpp>
#include <pkg/rve/packed/PackedSample.hpp>

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

template <int Dim> long PackedSample<Dim>::movingSteps(const Matrix& displacementGradient, const PackedUpdateOptions& options) const
{
	return talik::movingSteps<Dim>(this->parameters(), this->timeStep(), this->meanRadius(), displacementGradient, options);
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
	o.checkIce();
}

void IceOfUpdate::checkIce() const
{
	for (const double factor : { strength.tensile, strength.shear })
		if (!(factor > 0) || !std::isfinite(factor))
			throw std::invalid_argument(
			        "packed sample: the factor " + std::to_string(factor) + " on the strength of bonds must be positive and finite");
	if (!(iceStiffness > 0 && iceStiffness <= mostIceStiffness))
		throw std::invalid_argument(
		        "packed sample: the factor " + std::to_string(iceStiffness)
		        + " on the stiffness of ice must be positive and at most 2, which the time step bears; give a larger IceBondMat.iceYoung");
	if (!creep.isPossible())
		throw std::invalid_argument(
		        "packed sample: creep has the rate factor times its time " + std::to_string(creep.fluidity) + " Pa^-n and the exponent "
		        + std::to_string(creep.exponent) + "; both must be finite, the first one 0 or more, the exponent 1 or more");
}

template <int Dim> PackedUpdateResult<Dim> PackedSample<Dim>::conclude(const PackedUpdateOptions& options, long movingSteps, std::uint64_t before)
{
	this->checkHealth();
	PackedUpdateResult<Dim> result;
	result.movingSteps = movingSteps;
	result.flipped     = options.flipSkew > 0 && this->flip(options.flipSkew);
	result.stress      = stress();
	result.steps       = long(this->parameters().step - before);
	if (options.tangent) result.tangent = this->tangent();
	this->setIceStiffness(1);
	return result;
}

template <int Dim>
PackedUpdateResult<Dim> PackedSample<Dim>::update(
        const PackedState<Dim>& before, const Matrix& displacementGradient, double targetIceSaturation, const PackedUpdateOptions& options)
{
	try {
		const auto start = this->parameters().step;
		this->setStrengthFactors(options.strength);
		this->setIceStiffness(options.iceStiffness);
		const long moving = SampleUpdate<PackedSample>(*this, options).perform(displacementGradient, targetIceSaturation);
		return conclude(options, moving, start);
	} catch (const std::runtime_error& problem) {
		const std::string ofCell = ofThinCell(this->cellThickness());
		this->load(before);
		PackedUpdateResult<Dim> result;
		result.stress = symmetric<Matrix>(before.stress);
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
		Servo(PackedSample<Dim>& driven, const PackedServoOptions<Dim>& chosen)
		        : sample(driven)
		        , options(chosen)
		{
			scale = std::max(options.stress.cwiseAbs().maxCoeff(), options.pressureFloor);
		}

		bool perform()
		{
			bool converged = false;
			long done      = 0;
			for (; done < options.maxSteps && !converged; done += options.interval) {
				sample.setNextVelGrad(correction(done));
				sample.run(options.interval, options.interval);
				if (done / options.interval % 20 == 0) stiffness = sample.largestModulus();
				if (withinTolerance()) converged = atRest();
			}
			sample.setNextVelGrad(Matrix::Zero());
			sample.run(2);
			sample.checkHealth();
			return converged;
		}

	private:
		Matrix error() const { return options.stress - sample.stress(); }
		bool   withinTolerance() const { return error().cwiseAbs().maxCoeff() < options.stressTolerance * scale; }
		bool   atRest() const { return sample.statistics().unbalancedForce < options.unbalancedLimit; }

		/// Strain rate that would remove a share of the stress error during one interval, within the inertial limit.
		Matrix correction(long done)
		{
			// Loose spheres near failure are softer than their contacts: what removes a fifth at the stiffness of these takes too long. Discs
			// reach their stress with it, and collapse near failure with more.
			constexpr long patience = 100000; // steps
			const double   share    = Dim == 3 && done >= patience ? 0.6 : 0.2;
			if (stiffness == 0) stiffness = sample.largestModulus();
			PackedParameters<Dim> p = sample.parameters();
			p.stress                = Matrix::Identity() * -scale;
			const double limit      = strainPerStep<Dim>(p, p.dt, sample.meanRadius(), options.maxInertialNumber, options.pressureFloor) / p.dt;
			const double gain       = share / (stiffness * double(options.interval) * p.dt);
			const auto   bounded    = [limit](double rate) { return std::max(-limit, std::min(limit, rate)); };
			return Matrix(gain * error()).unaryExpr(bounded);
		}

		PackedSample<Dim>&             sample;
		const PackedServoOptions<Dim>& options;
		double                         scale = 0, stiffness = 0;
	};

} // namespace

// ---------------------------------------------------------------------------------------------- the sample

template <int Dim>
PackedSample<Dim>::PackedSample()
        : PackedWorkspace<Dim>(portableForced)
{}

template <int Dim>
PackedSample<Dim>::PackedSample(const PackedState<Dim>& state)
        : PackedSample()
{
	setState(state);
}

template <int Dim> PackedState<Dim> PackedSample<Dim>::state() const
{
	PackedState<Dim> state;
	this->store(state);
	return state;
}

template <int Dim> void PackedSample<Dim>::setState(const PackedState<Dim>& state)
{
	state.check();
	this->load(state);
}

template <int Dim> void PackedSample<Dim>::advance(const Matrix& velGrad, long steps)
{
	if (!velGrad.allFinite()) throw std::invalid_argument("packed sample: velGrad is not finite; give a velocity gradient in 1/s");
	const Matrix before = this->parameters().nextVelGrad;
	this->setNextVelGrad(velGrad);
	try {
		advance(steps);
	} catch (...) {
		this->setNextVelGrad(before);
		throw;
	}
}

template <int Dim> void PackedSample<Dim>::advance(long steps)
{
	if (steps < 0) throw std::invalid_argument("packed sample: steps = " + std::to_string(steps) + " must not be negative");
	const PackedState<Dim> before = state();
	try {
		this->run(steps);
		this->checkHealth();
	} catch (const std::runtime_error&) {
		this->load(before);
		throw;
	}
}

template <int Dim>
PackedUpdateResult<Dim> PackedSample<Dim>::apply(const Matrix& displacementGradient, double targetIceSaturation, const PackedUpdateOptions& options)
{
	checkOptions(options);
	if (!(targetIceSaturation >= 0 && targetIceSaturation <= 1))
		throw std::invalid_argument("packed sample: ice saturation " + std::to_string(targetIceSaturation) + " must lie in 0..1");
	PackedUpdateResult<Dim> result = update(state(), displacementGradient, targetIceSaturation, options);
	if (!result.blewUp) slipWhereThin<Dim>(*this, displacementGradient, options, result);
	return result;
}

template <int Dim> bool PackedSample<Dim>::servo(const PackedServoOptions<Dim>& options)
{
	const double largest = options.stress.diagonal().maxCoeff();
	if (!options.stress.allFinite() || !(largest < 0))
		throw std::invalid_argument("packed sample: stress = " + std::to_string(largest) + " Pa must be compressive (negative)");
	const PackedState<Dim> before = state();
	try {
		return strainTowards(options);
	} catch (const std::runtime_error&) {
		this->load(before);
		throw;
	}
}

template <int Dim> bool PackedSample<Dim>::strainTowards(const PackedServoOptions<Dim>& options) { return Servo<Dim>(*this, options).perform(); }

template <int Dim> typename PackedTypes<Dim>::Matrix PackedSample<Dim>::stress() const { return symmetric<Matrix>(this->lastStress()); }
template <int Dim> void                              PackedSample<Dim>::forcePortable(bool portable) { portableForced = portable; }
template <int Dim> bool                              PackedSample<Dim>::onOtherPath() const { return this->portableOnly() != portableForced; }

template PackedTypes<2>::Matrix matrixRootIncrement<2>(const PackedTypes<2>::Matrix&, long);
template PackedTypes<3>::Matrix matrixRootIncrement<3>(const PackedTypes<3>::Matrix&, long);
TALIK_IN_PLANE_AND_SPACE(PackedSample);

} // namespace talik
