// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/points/ObjectiveUpdate.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>

#include <cmath>

namespace talik {

/// Shear stress tau = sqrt(s:s/2) of the deviator s of one point of a batch, in simple shear the shear stress, for laws that change nothing else.
template <int D> class ShearStress {
public:
	ShearStress(const SkeletonBatch<D>& batch, int place)
	        : stress_(from(batch.stress, place))
	        , mean_((*stress_[0] + *stress_[1] + *stress_[2]) / 3.0)
	{
		for (int c = 0; c < stressSize<D>; ++c) {
			const double part = *stress_[c] - (c < 3 ? mean_ : 0.0);
			square_ += (c < 3 ? 0.5 : 1.0) * part * part;
		}
	}
	double value() const { return std::sqrt(square_); } ///< tau [Pa]
	double mean() const { return mean_; }               ///< tension positive [Pa]

	/// Gives the deviator the shear stress tau; its directions and the mean stress stay. Not where value() is zero.
	void become(double tau)
	{
		const double scale = tau / value();
		for (int c = 0; c < stressSize<D>; ++c) {
			const double volumetric = c < 3 ? mean_ : 0.0;
			*stress_[c]             = volumetric + (*stress_[c] - volumetric) * scale;
		}
	}

private:
	std::array<double*, stressSize<D>> stress_;
	double                             mean_, square_ = 0.0;
};

/// Rate of strain of a point of a batch [1/s of motion], of the middle of the step; tensor components in the order of stressIndex<D>().
template <int D> std::array<double, stressSize<D>> strainRate(const SkeletonBatch<D>& batch, int place)
{
	double gradient[D * D];
	for (int c = 0; c < D * D; ++c)
		gradient[c] = batch.gradient[c][place];
	const MidpointIncrement<D>        increment(gradient);
	std::array<double, stressSize<D>> rate {};
	for (int c = 0; c < D * (D + 1) / 2; ++c)
		rate[stressOfStrain<D>(c)] = increment.strain[c] / batch.time.motion;
	if (batch.hoop) rate[2] = midpointHoop(batch.hoop[place]) / batch.time.motion;
	return rate;
}

/// Shear rate of a point of a batch [1/s of motion], twice the root of the second invariant of the rate's deviator: in simple shear dv/dn.
template <int D> double shearRate(const SkeletonBatch<D>& batch, int place)
{
	const auto   rate   = strainRate(batch, place);
	const double mean   = (rate[0] + rate[1] + rate[2]) / 3.0;
	double       square = 0.0;
	for (int c = 0; c < stressSize<D>; ++c)
		square += c < 3 ? 0.5 * (rate[c] - mean) * (rate[c] - mean) : rate[c] * rate[c];
	return 2.0 * std::sqrt(square);
}

} // namespace talik
