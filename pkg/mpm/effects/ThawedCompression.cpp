// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/ThawedCompression.hpp>
#include <pkg/mpm/effects/ThawStrain.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace talik {

template <int D>
ThawedCompression<D>::ThawedCompression(PointFields& fields, const GroundSettings<D>& settings)
        : settings_(&settings)
{
	compressionField_   = fields.declare("thawedCompression", "thawedCompression", "-", 1);
	meanPressureField_  = fields.declare("pressureMean", "thawedCompression", "Pa", 1);
	stressAtStartField_ = fields.declare("pressureAtStart", "thawedCompression", "Pa", 1);
}

template <int D>
void ThawedCompression<D>::bind(MaterialPoints<D>& points, const ThawStrain<D>& thawStrain, const double* porosity, const double* iceSaturation)
{
	const Vec<D>& gravity          = settings_->motion->gravity;
	points_                        = &points;
	thawStrain_                    = &thawStrain;
	porosity_                      = porosity;
	iceSaturation_                 = iceSaturation;
	compression_                   = points.fields().component(compressionField_);
	meanPressure_                  = points.fields().component(meanPressureField_);
	stressAtStart_                 = points.fields().component(stressAtStartField_);
	smoothingTime_                 = gravityTime(settings_->gridSpacing, lengthOf<D>(gravity));
	down_[layerNormal<D>(gravity)] = 1.0;
	for (PagedArray<double>* byPlace : { &noIce_, &thawedModulus_, &losses_ })
		byPlace->reset(points.capacity());
	ofSkeleton_.reserve(points.capacity());
	lost_.reserve(points.capacity());
}

template <int D> void ThawedCompression<D>::start(int first, int end, const PointsInMotion<D>& moving)
{
	for (int p = first; p < end; ++p) {
		stressAtStart_[p] = meanPressure_[p] = std::max(0.0, moving.pressureAlong(p, down_));
		if (iceSaturation_[p] == 0.0)
			compression_[p] = settings_->materials[points_->material(p)].compression.strain(stressAtStart_[p], 1.0 - porosity_[p]);
	}
}

/// Ice that forms again holds the soil.
template <int D> double ThawedCompression<D>::melted(int p) const
{
	const double frozen = thawStrain_->frozenSaturation(p);
	return frozen > 0.0 ? std::max(0.0, 1.0 - iceSaturation_[p] / frozen) : 1.0 - iceSaturation_[p];
}

template <int D> const std::vector<int>& ThawedCompression<D>::thawedAmong(const std::vector<int>& places)
{
	ofSkeleton_.clear();
	for (const int p : places)
		if (isThawed(p)) ofSkeleton_.push_back(p);
	return ofSkeleton_;
}

/// What a point loses in a step of its volume, eqs (24.5) and (24.6).
template <int D> double ThawedCompression<D>::lossOf(int p, double present, double pressure, double modulus) const
{
	const double mean = meanPressure_[p];
	if (!(mean > 0.0 && pressure > 0.0) || !isThawed(p)) return 0.0;
	const double strain = settings_->materials[points_->material(p)].compression.strain(mean, (1.0 - porosity_[p]) * present);
	const double wanted = melted(p) * (strain - present * (mean - stressAtStart_[p]) / thawedModulus_[p]) - compression_[p];
	return std::clamp(wanted / present, 0.0, pressure / modulus);
}

template <int D>
void ThawedCompression<D>::compress(const StepContext<D>& step, const PointsInMotion<D>& moving, const double* modulus, const Gradients<D>& gradient)
{
	const double taken   = -std::expm1(-step.dt / smoothingTime_);
	const auto   present = [&](int p) { return moving.volume[p] / moving.initialVolume[p]; };
	step.strips.gather([&](int, int first, int last) {
		for (int p = first; p < last; ++p) {
			const double pressure = moving.pressureAlong(p, down_);
			meanPressure_[p] += taken * (pressure - meanPressure_[p]);
			losses_[p] = lossOf(p, present(p), pressure, modulus[p]);
		}
	});
	for (int p = step.strips.firstPoint(); p < step.strips.endPoint(); ++p) {
		if (losses_[p] == 0.0) continue;
		lost_.add(gradient, p, losses_[p], down_);
		compression_[p] += losses_[p] * present(p);
	}
}

template <int D> void ThawedCompression<D>::keepOnly(int firstPoint, int endPoint)
{
	for (PagedArray<double>* byPlace : { &noIce_, &thawedModulus_, &losses_ })
		byPlace->keepOnly(firstPoint, endPoint);
}

template <int D> std::string ThawedCompression<D>::fault(const std::string& law, int p) const
{
	const SoilMaterial& soil = settings_->materials[points_->material(p)];
	std::ostringstream  text;
	text.precision(4);
	text << "MpmEngine.materials[" << points_->material(p) << "].";
	if (soil.compression.compressibility > 0.0 && soil.compression.compressibility * thawedModulus_[p] <= 1.0) {
		text << "compressibility = " << soil.compression.compressibility << ": " << law << ", the law of these points, alone strains by "
		     << 1.0 / thawedModulus_[p] << " per Pa when it is thawed; give a stiffer law, which the compressibility makes softer, or leave it 0";
		return text.str();
	}
	const double strain = soil.thawStrain + soil.compression.strain(stressAtStart_[p], 1.0 - porosity_[p]);
	if (iceSaturation_[p] == 0.0 || strain < porosity_[p]) return {};
	text << "thawStrain and compression make " << strain << " at the stress of a point at the start, " << 1e-3 * stressAtStart_[p]
	     << " kPa, and its porosity is " << porosity_[p] << ": give more porosity or less strain";
	return text.str();
}

TALIK_IN_PLANE_AND_SPACE(ThawedCompression);

} // namespace talik
