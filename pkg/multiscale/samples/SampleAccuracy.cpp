// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/samples/SampleAccuracy.hpp>
#include <pkg/multiscale/samples/SampleScheduler.hpp>

#include <algorithm>
#include <cmath>

namespace talik {
namespace {
	constexpr double comparisonInterval    = 16; ///< calls of a point from one comparison of rates to the next
	constexpr double firstInertialNumber   = 2e-3;
	constexpr double largestInertialNumber = 2e-2;
	/// Smallest inertial number over the tolerance: slower, quasi-static stress is off by less than the tolerance at 10 to 200 kPa (measured: by
	/// 10 to 50 times the inertial number), and what is left between two rates is the scatter of grains that find other places.
	constexpr double slowestPerTolerance     = 1. / 60;
	constexpr double smallestStrainTolerance = 1e-6, largestStrainTolerance = 1e-3;
	constexpr double strainShare = 0.3; ///< of the strain tolerance: calls below it were made for the ice

	double steered(double value, double factor, double smallest, double largest)
	{
		return std::min(largest, std::max(smallest, value * std::min(2., std::max(0.3, factor))));
	}

	double square(double x) { return x * x; }
} // namespace

double steeredStrainTolerance(double tolerance, double strain, double allowed, double error, double smallest, double largest)
{
	if (strain < strainShare * tolerance) return tolerance;
	return steered(tolerance, error > 0 ? std::sqrt(allowed / error) : 2., smallest, largest);
}

void SampleAccuracy::declareFields(PointFields& f, const std::string& prefix, const std::string& owner)
{
	f.declare(prefix + "inertialNumber", owner, "-", inertialNumbers);
	f.declare(prefix + "predictionError", owner, "Pa", predictionErrors);
	f.declare(prefix + "rateError", owner, "Pa", rateErrors);
	f.declare(prefix + "stepsSinceCall", owner, "-", steps);
	f.declare(prefix + "errorSquares", owner, "Pa^2", errors);
	f.declare(prefix + "stressSquares", owner, "Pa^2", stresses);
	f.declare(prefix + "callsOfSample", owner, "-", calls);
}

void SampleAccuracy::begin(int place)
{
	inertialNumbers[place] = firstInertialNumber;
	for (double* const of : { predictionErrors, rateErrors, calls, steps, errors, stresses })
		of[place] = 0;
}

bool SampleAccuracy::comparesRates(int place) const { return std::fmod(calls[place], comparisonInterval) == 0; }

void SampleAccuracy::learn(const Answer& a, double& strainTolerance)
{
	const double scale = a.stress + stressFloor, part = tolerance * std::sqrt(0.5) * scale;
	if (comparesRates(a.place)) {
		double& inertial    = inertialNumbers[a.place];
		rateErrors[a.place] = a.rateError;
		inertial            = steered(inertial, a.rateError > 0 ? part / a.rateError : 2., slowestPerTolerance * tolerance, largestInertialNumber);
	}
	predictionErrors[a.place] = a.predictionError;
	const ErrorSquares sums   = squares(a.place, a.stress);
	errors[a.place]           = sums.error;
	stresses[a.place]         = sums.stress;
	steps[a.place]            = 0;
	calls[a.place] += 1;
	strainTolerance = steeredStrainTolerance(strainTolerance, a.strain, part, a.predictionError, smallestStrainTolerance, largestStrainTolerance);
}

ErrorSquares SampleAccuracy::squares(int place, double stress) const
{
	return { errors[place] + steps[place] * (square(predictionErrors[place]) + square(rateErrors[place])),
		 stresses[place] + steps[place] * square(stress) };
}

} // namespace talik
