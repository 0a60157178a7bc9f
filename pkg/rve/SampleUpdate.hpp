// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <Eigen/LU>
#include <pkg/rve/packed/PackedSample.hpp>

namespace talik {

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
