// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstdint>
#include <pkg/mpm/points/PointFields.hpp>

namespace talik {

/// Sums of squares over points and steps, weighted by volume: of the error in effective stress and of the stress [Pa^2 m^2].
struct ErrorSquares {
	double error = 0, stress = 0;
	void   add(double weight, double squaredError, double squaredStress)
	{
		error += weight * squaredError;
		stress += weight * squaredStress;
	}
};

/// Strain tolerance of a point after an answer, eq. (15.4), within a range. A sample that was asked for its ice after little strain says
/// nothing: where next to nothing was predicted, nothing was wrong, and a tolerance that grew with each such answer would let thawed ground
/// carry stress above its strength.
///  strain           largest component of the displacement gradient since the call before [-]
///  allowed, error   of the prediction, both in the same unit
double steeredStrainTolerance(double tolerance, double strain, double allowed, double error, double smallest, double largest);

/// Error control of the samples behind points: from one tolerance, the relative error of effective stress that is aimed at, it
/// steers the strain tolerance and the inertial number of each point, eqs. (15.4) and (15.5), and sums up the estimated error, eq. (15.6).
/// Two errors are measured, half of the tolerance's square for each:
///  prediction  the stress predicted by the tangent less that of the sample, at every call. It counts for the whole interval before, although
///              it grew from zero there, because the motion that it caused stays.
///  rate        the stress less that of quasi-static motion. Every sixteenth call of a point is computed at two rates to find it.
class SampleAccuracy {
public:
	/// One answer of a sample.
	struct Answer {
		int    place           = 0;
		double stress          = 0; ///< Frobenius norm [Pa]
		double predictionError = 0; ///< [Pa]
		double rateError       = 0; ///< [Pa], if rates were compared
		double strain          = 0; ///< largest component of the accumulated displacement gradient [-]
	};

	void setTolerance(double t) { tolerance = t; }
	void declareFields(PointFields&, const std::string& prefix, const std::string& owner);
	void begin(int place);

	void   passStep(int place) const { steps[place] += 1; }
	bool   comparesRates(int place) const;
	double inertialNumber(int place) const { return inertialNumbers[place]; }
	/// Takes in an answer and steers the point: changes its strain tolerance [-].
	void learn(const Answer& answer, double& strainTolerance);
	/// Of a point since the start, per volume; stress: norm now [Pa].
	ErrorSquares squares(int place, double stress) const;

private:
	double  tolerance        = 0;
	double* inertialNumbers  = nullptr; ///< by place, as the others
	double *predictionErrors = nullptr, *rateErrors = nullptr, *calls = nullptr;
	/// Sums over steps of the squares of error and stress [Pa^2], and the steps since the last answer, whose error that answer will tell.
	double *errors = nullptr, *stresses = nullptr, *steps = nullptr;
};

} // namespace talik
