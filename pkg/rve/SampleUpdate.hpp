// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <Eigen/LU>
#include <pkg/icebond/IceLaws.hpp>
#include <pkg/rve/packed/PackedState.hpp>
#include <stdexcept>
#include <string>

namespace talik {

/// What temperature, rate and time make of the ice bonds in an update.
struct IceOfUpdate {
	BondStrengthFactors strength {};
	double              iceStiffness = 1; ///< over that of the material, > 0 [-]
	BondCreep           creep {};         ///< before the motion
	/// Throws std::invalid_argument on what no ice can have.
	void checkIce() const;
};

/// How a macroscopic increment is applied to a sample.
struct PackedUpdateOptions : IceOfUpdate {
	double maxInertialNumber   = 5e-3;  ///< I_max of eq. (13.1) [-]: 1e-3 careful, 5e-3 production
	double maxStrainPerStep    = 1e-5;  ///< largest strain of one DEM step as long as that of the state [-]
	long   minSteps            = 10;    ///< N_min
	bool   timeStepFollowsIce  = true;  ///< steps of the motion are longer where ice is missing that the time step allows for
	long   steps               = 0;     ///< > 0: exactly this many moving steps, the two limits above are not asked
	double pressureFloor       = 1e3;   ///< P in eq. (13.1) is never taken smaller [Pa]
	double saturationIncrement = 0.02;  ///< largest change of ice saturation at once [-]
	long   stepsPerSaturation  = 2;     ///< steps at zero velocity gradient after each of them
	long   relaxSteps          = 0;     ///< steps at zero velocity gradient after the motion
	double flipSkew            = 0.5;   ///< the cell is flipped when a skew passes this; <= 0: never
	bool   tangent             = false; ///< also return the elastic tangent of the contact network
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
	PackedTangent<Dim>                tangent {};          ///< if asked for, see PackedWorkspace::tangent
	double rateError = 0; ///< of the steps asked for, if rates were compared: norm of the stress less that of infinitely slow motion [Pa]
};

/// Strain of one DEM step at an inertial number, eq. (13.1), with stress and density of the parameters.
template <int Dim> double strainPerStep(const PackedParameters<Dim>& p, double timeStep, double meanRadius, double inertialNumber, double pressureFloor)
{
	const double pressure = std::max(-p.stress.trace() / Dim, pressureFloor);
	return inertialNumber * timeStep / (2 * meanRadius) * std::sqrt(pressure / p.density);
}

/// The number of moving steps N of eq. (13.1) for a displacement gradient; timeStep of the motion [s].
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

/// Cell motion per step: X with (1 + X)^steps = 1 + displacementGradient. Throws std::invalid_argument unless det(1 + dH) > 0 and the
/// principal root exists.
template <int Dim> typename PackedTypes<Dim>::Matrix matrixRootIncrement(const typename PackedTypes<Dim>::Matrix& displacementGradient, long steps);

/// Time step of the motion of a sample that bears `longest` with the ice of now [s]: a step more at the end has to pay.
inline double timeStepOfMotion(double before, double longest)
{
	constexpr double worthwhile = 1.1;
	return longest > worthwhile * before ? longest : before;
}

/// Steps at the end of a motion with that time step: it may change at rest only.
inline long stepsToRest(double before, double ofMotion) { return ofMotion == before ? 1 : 2; }

/// Parts in which the ice saturation changes, and what it is after the k-th of them, k = 1 to parts.
inline long   partsOfIce(double from, double target, double increment) { return long(std::ceil(std::fabs(target - from) / increment - 1e-9)); }
inline double iceAfterPart(double from, double target, long k, long parts) { return k == parts ? target : from + (target - from) * double(k) / double(parts); }

/// One macroscopic increment on a sample, packed or open: ice and its creep at zero velocity gradient, then motion, then relaxation.
/// A sample offers timeStep, setTimeStep, longestTimeStep, velGrad, setNextVelGrad, run, hasIce, iceSaturation,
/// setIceSaturation, leastStepsOfIce, creep, movingSteps and motionPerStep.
template <class Sample> class SampleUpdate {
	using Matrix = typename Sample::Matrix;

public:
	SampleUpdate(Sample& s, const PackedUpdateOptions& chosen)
	        : sample(s)
	        , options(chosen)
	{}

	/// Returns the number of moving steps.
	long perform(const Matrix& displacementGradient, double targetIceSaturation)
	{
		const Matrix remaining = stopMotion(displacementGradient);
		changeIce(targetIceSaturation);
		creep();
		const long moving = move(remaining);
		sample.run(options.relaxSteps);
		return moving;
	}

private:
	/// A velocity gradient left in force moves the cell once more; what it moves is taken from the increment.
	Matrix stopMotion(const Matrix& displacementGradient)
	{
		const Matrix one = Matrix::Identity(), left = sample.timeStep() * sample.velGrad();
		sample.setNextVelGrad(Matrix::Zero());
		if (left.isZero(0)) return displacementGradient;
		sample.run(1);
		return (one + displacementGradient) * (one + left).inverse() - one;
	}

	void changeIce(double target)
	{
		if (!sample.hasIce()) return;
		const double from  = sample.iceSaturation();
		const long   parts = partsOfIce(from, target, options.saturationIncrement);
		for (long k = 1; k <= parts; ++k) {
			sample.setIceSaturation(iceAfterPart(from, target, k, parts));
			sample.run(std::max(Sample::leastStepsOfIce, options.stepsPerSaturation));
		}
	}

	/// Before the motion: what that loads does not relax until the next update.
	void creep()
	{
		if (!sample.hasIce() || !options.creep.acts()) return;
		sample.creep(options.creep);
		sample.run(std::max(1l, options.stepsPerSaturation));
	}

	/// The time step of the motion, until it ends. Contacts take what grains moved in the step before times the time step of now: it may
	/// change at rest only.
	class TimeStepOfMotion {
	public:
		TimeStepOfMotion(Sample& s, const PackedUpdateOptions& options)
		        : sample(s)
		        , before(s.timeStep())
		{
			if (!options.timeStepFollowsIce || !sample.hasIce()) return;
			sample.setTimeStep(timeStepOfMotion(before, sample.longestTimeStep(options.iceStiffness)));
		}
		~TimeStepOfMotion() { sample.setTimeStep(before); }
		TimeStepOfMotion(const TimeStepOfMotion&)            = delete;
		TimeStepOfMotion& operator=(const TimeStepOfMotion&) = delete;
		long              stepsToRest() const { return talik::stepsToRest(before, sample.timeStep()); }
		double            overThatAtRest() const { return sample.timeStep() / before; }

	private:
		Sample&      sample;
		const double before;
	};

	/// The velocity gradient is pending in the first of steps + 1 steps and in force in the others.
	long move(const Matrix& displacementGradient)
	{
		if (displacementGradient.isZero(0)) return 0;
		const TimeStepOfMotion timeStep(sample, options);
		PackedUpdateOptions    ofMotion = options;
		ofMotion.maxStrainPerStep *= timeStep.overThatAtRest();
		const long   steps = sample.movingSteps(displacementGradient, ofMotion);
		const Matrix rate  = sample.motionPerStep(displacementGradient, steps) / sample.timeStep();
		sample.setNextVelGrad(rate);
		sample.run(steps);
		sample.setNextVelGrad(Matrix::Zero());
		sample.run(timeStep.stepsToRest());
		return steps;
	}

	Sample&                    sample;
	const PackedUpdateOptions& options;
};

} // namespace talik

/// Equivalent cells of one lattice, for the flip of a sheared periodic cell.
namespace talik {

/// Integer combinations that shorten the cell vectors (columns of h): columns of the result are combinations of those of h, determinant
/// +-1; the identity if no vector leans over another by more than `skew` of its length.
template <int Dim> Eigen::Matrix<int, Dim, Dim> cellReduction(Eigen::Matrix<double, Dim, Dim> h, double skew)
{
	Eigen::Matrix<int, Dim, Dim> combination = Eigen::Matrix<int, Dim, Dim>::Identity();
	for (bool changed = true; changed;) {
		changed = false;
		for (int a = 0; a < Dim; ++a)
			for (int b = 0; b < Dim; ++b) {
				if (a == b) continue;
				const double ratio = h.col(a).dot(h.col(b)) / h.col(a).squaredNorm();
				const int    turns = int(std::lround(ratio));
				if (std::fabs(ratio) <= skew + 1e-9 || turns == 0) continue;
				h.col(b) -= turns * h.col(a);
				combination.col(b) -= turns * combination.col(a);
				changed = true;
			}
	}
	return combination;
}

/// Whether a cell is to be flipped, see PackedUpdateOptions::flipSkew.
template <int Dim> bool flipIsDue(const Eigen::Matrix<double, Dim, Dim>& hSize, double skew)
{
	return skew > 0 && cellReduction<Dim>(hSize, std::max(skew, 0.5)) != Eigen::Matrix<int, Dim, Dim>::Identity();
}

/// Inverse of an integer matrix of determinant +-1, exact by rounding.
template <int Dim> Eigen::Matrix<int, Dim, Dim> integerInverse(const Eigen::Matrix<int, Dim, Dim>& m)
{
	const Eigen::Matrix<double, Dim, Dim> inverse = m.template cast<double>().inverse();
	Eigen::Matrix<int, Dim, Dim>          rounded;
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j)
			rounded(i, j) = int(std::lround(inverse(i, j)));
	return rounded;
}

/// Length of the shortest lattice vector: the distance of a grain from its next image.
template <int Dim> double shortestImage(const Eigen::Matrix<double, Dim, Dim>& hSize)
{
	const Eigen::Matrix<double, Dim, Dim> h      = hSize * cellReduction<Dim>(hSize, 0.5).template cast<double>();
	double                                square = h.colwise().squaredNorm().minCoeff();
	for (int a = 0; a < Dim; ++a)
		for (int b = a + 1; b < Dim; ++b)
			for (const int sign : { -1, 1 }) {
				const Eigen::Matrix<double, Dim, 1> sum = h.col(a) + sign * h.col(b);
				square                                  = std::min(square, sum.squaredNorm());
				for (const int third : { -1, 1 })
					if (Dim == 3 && b == 1) square = std::min(square, (sum + third * h.col(Dim - 1)).squaredNorm());
			}
	return std::sqrt(square);
}

} // namespace talik
