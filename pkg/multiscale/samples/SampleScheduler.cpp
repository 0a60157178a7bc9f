// SPDX-License-Identifier: GPL-2.0-or-later
#include <cmath>
#include <Eigen/Eigenvalues>
#include <pkg/multiscale/samples/SampleAccuracy.hpp>
#include <pkg/multiscale/samples/SampleScheduler.hpp>

namespace talik {
namespace {
	constexpr double failingTightness = 0.25; ///< largest tolerance of a point that deforms plastically, over that of others
	constexpr double toleranceRange   = 10.;  ///< the steered tolerance stays within this factor of the given one
	constexpr double changeOverError  = 2.;   ///< change of stress that is predicted at most, over stressTolerance
} // namespace

template <int Dim> bool SampleScheduler<Dim>::isDue(const SampleRecord<Dim>& r, int place, const Matrix& h, const Matrix& change, double iceSaturation) const
{
	const double most = h.cwiseAbs().maxCoeff();
	if (schedule.strainTolerance <= 0 ? most > 0 : most > r.tolerance[place]) return true;
	if (schedule.steersTolerance() && !byErrors && change.norm() > changeOverError * schedule.stressTolerance * (r.lastStress(place).norm() + stressFloor))
		return true;
	const double ofIce = std::fabs(iceSaturation - r.saturation[place]);
	if (ofIce == 0) return false;
	// ice that vanishes or appears altogether makes or breaks bonds: never wait for it
	return ofIce > schedule.saturationTolerance || iceSaturation == 0 || r.saturation[place] == 0;
}

template <int Dim> void SampleScheduler<Dim>::passTime(const SampleRecord<Dim>& r, const SkeletonBatch<Dim>& batch) const
{
	for (int k = 0; k < batch.count; ++k)
		r.time[batch.place[k]] += batch.time.calendar;
}

template <int Dim> bool SampleScheduler<Dim>::hasCrept(const SampleRecord<Dim>& r, const SkeletonBatch<Dim>& batch, int place) const
{
	return r.time[place] > 0 && !(batch.iceSaturation && batch.iceSaturation[place] == 0);
}

/// At the temperature of a point and the largest principal strain rate since its sample was last updated, eq. (15.7).
template <int Dim>
BondStrengthFactors SampleScheduler<Dim>::strengthFactors(const SampleRecord<Dim>& r, const SkeletonBatch<Dim>& batch, int place, const Matrix& gradient) const
{
	const IceStrengthLaw& law    = *schedule.iceStrength;
	const Matrix          strain = 0.5 * (gradient + gradient.transpose());
	const double          size   = Eigen::SelfAdjointEigenSolver<Matrix>(strain, Eigen::EigenvaluesOnly).eigenvalues().cwiseAbs().maxCoeff();
	const double          time   = r.time[place];
	return law.factors(batch.temperature ? batch.temperature[place] : law.referenceTemperature, time > 0 ? size / time : 0.);
}

template <int Dim>
PackedRequest<Dim> SampleScheduler<Dim>::request(const SampleRecord<Dim>& r, const SkeletonBatch<Dim>& batch, int place, std::size_t sample) const
{
	PackedRequest<Dim> request { sample, r.accumulated(place), batch.iceSaturation ? batch.iceSaturation[place] : r.saturation[place] };
	if (schedule.iceStrength) {
		request.strength = strengthFactors(r, batch, place, request.displacementGradient);
		if (batch.temperature) request.iceStiffness = schedule.iceStrength->stiffness(batch.temperature[place]);
	}
	if (schedule.iceCreep) { // at the temperature of the point, over the time since the last update
		const IceCreepLaw& law = *schedule.iceCreep;
		request.creep          = law.over(batch.temperature ? batch.temperature[place] : law.referenceTemperature, r.time[place]);
	}
	return request;
}

template <int Dim>
void SampleScheduler<Dim>::steer(const SampleRecord<Dim>& r, int place, const Matrix& h, const Matrix& after, double error, bool failing) const
{
	if (byErrors || !schedule.steersTolerance()) return;
	const double tight = failing ? failingTightness : 1., given = schedule.strainTolerance;
	r.tolerance[place] = steeredStrainTolerance(
	        r.tolerance[place], h.cwiseAbs().maxCoeff(), schedule.stressTolerance * (after.norm() + stressFloor), error, given / toleranceRange,
	        toleranceRange * given * tight);
}

TALIK_IN_PLANE_AND_SPACE(SampleScheduler);

} // namespace talik
