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
void ThawedCompression<D>::bind(MaterialPoints<D>& points, const ThawStrain<D>& thawStrain, const double* porosity, const double* iceSaturation, int cells)
{
	const Vec<D>& gravity          = settings_->motion->gravity;
	points_                        = &points;
	thawStrain_                    = &thawStrain;
	porosity_                      = porosity;
	iceSaturation_                 = iceSaturation;
	compression_                   = points.fields().component(compressionField_);
	meanPressure_                  = points.fields().component(meanPressureField_);
	stressAtStart_                 = points.fields().component(stressAtStartField_);
	ofThawed_                      = bool(settings_->water);
	smoothingTime_                 = gravityTime(settings_->gridSpacing, lengthOf<D>(gravity));
	down_[layerNormal<D>(gravity)] = 1.0;
	sharing_.bind(settings_->motion->bBar, cells, points.capacity());
	for (PagedArray<double>* byPlace : { &noIce_, &thawedModulus_ })
		byPlace->reset(points.capacity());
	wishes_.reset(points.capacity());
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

/// Eq. (24.5) at one point by bracketing: the stress cannot fall below zero.
template <int D> typename ThawedCompression<D>::Wish ThawedCompression<D>::wishOf(int p, double present, double bearing, double modulus, double taken) const
{
	const double pressure = meanPressure_[p];
	if (!(pressure > 0.0 && bearing > 0.0) || thawStrain_->isOpen(p) || !isThawed(p)) return {};
	const CompressionCurve& curve      = settings_->materials[points_->material(p)].compression;
	const double            share      = melted(p);
	const double            solidShare = (1.0 - porosity_[p]) * present, lawModulus = thawedModulus_[p];
	// what is still to be lost if the point now loses the strain r, its stress falls by that, and the mean of its stress follows
	const auto missing = [&](double r) {
		const double left = pressure - taken * modulus * r;
		return share * (curve.strain(left, solidShare) - present * (left - stressAtStart_[p]) / lawModulus) - compression_[p] - present * r;
	};
	const double wanted = missing(0.0);
	if (!(wanted > 0.0)) return {};
	double low = 0.0, atLow = wanted, high = std::min(pressure / taken, bearing) / modulus, atHigh = missing(high);
	if (atHigh > 0.0) return { wanted / present, std::max(0.0, wanted / (present * high) - 1.0) };
	for (int side = 0, k = 0; k < 40 && high - low > 1e-12 * high; ++k) { // regula falsi of Illinois
		const double r = low + (high - low) * atLow / (atLow - atHigh), at = missing(r);
		if (at > 0.0) {
			low   = r;
			atLow = at;
			if (side > 0) atHigh *= 0.5;
			side = 1;
		} else {
			high   = r;
			atHigh = at;
			if (side < 0) atLow *= 0.5;
			side = -1;
			if (at == 0.0) break;
		}
	}
	return { wanted / present, high > 0.0 ? std::max(0.0, wanted / (present * high) - 1.0) : 0.0 };
}

template <int D>
void ThawedCompression<D>::compress(
        const StepContext<D>& step, const PointsInMotion<D>& moving, const double* modulus, const CellMeans<D>* cells, const Gradients<D>& gradient)
{
	const double* const volume = moving.volume;
	sharing_.clear(step, cells);
	sharing_.add(step, [&](int p, Sharing& s) {
		const double counts = volume[p] * (ofThawed_ ? melted(p) : 1.0);
		s.volume += volume[p];
		s.bearing += counts;
		s.pressure += counts * moving.pressureAlong(p, down_);
	});
	const double taken = -std::expm1(-step.dt / smoothingTime_);
	step.strips.gather([&](int, int first, int last) {
		for (int p = first; p < last; ++p) {
			const Sharing& s = sharing_[p];
			wishes_[p]       = {};
			if (s.bearing == 0.0) continue;
			meanPressure_[p] += taken * (s.pressure / s.bearing - meanPressure_[p]);
			wishes_[p] = wishOf(p, volume[p] / moving.initialVolume[p], s.pressure / s.bearing, modulus[p], taken);
		}
	});
	sharing_.add(step, [&](int p, Sharing& s) {
		s.wanted += volume[p] * wishes_[p].strain;
		s.stiffened += volume[p] * (1.0 + wishes_[p].excess);
	});
	for (int p = step.strips.firstPoint(); p < step.strips.endPoint(); ++p) {
		const Sharing& s = sharing_[p];
		if (s.wanted == 0.0) continue;
		lost_.add(gradient, p, s.wanted / s.stiffened, down_);
		if (wishes_[p].strain > 0.0) meanPressure_[p] -= taken * modulus[p] * s.wanted / s.stiffened;
		compression_[p] += wishes_[p].strain * s.volume / s.stiffened * volume[p] / moving.initialVolume[p];
	}
}

template <int D> void ThawedCompression<D>::keepOnly(const ActiveRange& range, int firstPoint, int endPoint)
{
	sharing_.keepOnly(range, firstPoint, endPoint);
	for (PagedArray<double>* byPlace : { &noIce_, &thawedModulus_ })
		byPlace->keepOnly(firstPoint, endPoint);
	wishes_.keepOnly(firstPoint, endPoint);
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
