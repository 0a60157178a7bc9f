// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <optional>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>
#include <pkg/multiscale/samples/SampleRecord.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>

namespace talik {

/// When a sample is asked and how, eq. (15.2): increments accumulate until one of the tolerances is passed.
struct SampleScheduling {
	double              strainTolerance     = 2e-5; ///< largest accumulated component of the displacement gradient [-]; 0: ask in every step
	double              saturationTolerance = 0.01; ///< largest accumulated change of ice saturation [-]; 0: ask in every step
	bool                prediction          = true; ///< a tangent stands in between two calls; false: the last stress is held
	double              stressTolerance = 0.05; ///< relative error of the prediction that the strain tolerance of a point is steered to; 0: fixed tolerance
	bool                steersTolerance() const { return stressTolerance > 0 && strainTolerance > 0; }
	bool                stopOnBlowUp = true; ///< the run stops when the step has ended; false: the point keeps its last stress from then on
	int                 threads      = 0;    ///< 0: OpenMP's default
	PackedUpdateOptions update;
	/// How the strength of ice bonds follows temperature and strain rate; absent: it is that of the samples.
	std::optional<IceStrengthLaw> iceStrength;
	/// How ice bonds creep in calendar time; absent: they do not.
	std::optional<IceCreepLaw> iceCreep;
	bool                       followsTime() const { return iceStrength || iceCreep; }
	/// Strength with which points slip at the thaw front; absent: it is measured, see PointSamples::measureSlip.
	std::optional<ShearStrength> slipStrength;
};

/// Added to the stress of a point before errors are related to it [Pa].
constexpr double stressFloor = 1e3;

/// Says when the sample of a point is updated, and with which conditions of its ice. Where one tolerance steers all points by their errors
/// (SampleAccuracy) it only follows the tolerances that they have got.
template <int Dim> class SampleScheduler {
public:
	using Matrix = typename PackedTypes<Dim>::Matrix;
	SampleScheduler(const SampleScheduling& scheduling, bool toleranceIsSteeredByErrors)
	        : schedule(scheduling)
	        , byErrors(toleranceIsSteeredByErrors)
	{}

	/// h: accumulated motion, change: of the stress that is predicted with it.
	bool isDue(const SampleRecord<Dim>&, int place, const Matrix& h, const Matrix& change, double iceSaturation) const;
	/// Whether the bonds of a point's sample have had time to creep.
	bool hasCrept(const SampleRecord<Dim>&, const SkeletonBatch<Dim>&, int place) const;
	/// Calendar time passes since the samples were updated.
	void passTime(const SampleRecord<Dim>&, const SkeletonBatch<Dim>&) const;
	/// The update of a sample by what its point has gone through since the last one.
	PackedRequest<Dim> request(const SampleRecord<Dim>&, const SkeletonBatch<Dim>&, int place, std::size_t sample) const;
	/// After an update, where the tolerance of each point follows its own prediction error [Pa]. failing: the point deforms plastically.
	void steer(const SampleRecord<Dim>&, int place, const Matrix& h, const Matrix& after, double error, bool failing) const;

private:
	BondStrengthFactors strengthFactors(const SampleRecord<Dim>&, const SkeletonBatch<Dim>&, int place, const Matrix& gradient) const;

	const SampleScheduling& schedule;
	bool                    byErrors;
};

} // namespace talik
