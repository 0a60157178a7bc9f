// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/ThawStrain.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

namespace {
	template <int D> double expansionOfIce(const GroundSettings<D>& settings)
	{
		if (!settings.iceExpands()) return 0.0;
		const MixtureProperties& m = settings.mixtureOf(0);
		return std::max(0.0, 1.0 / m.ice.density - 1.0 / m.liquid.density);
	}
} // namespace

template <int D>
ThawStrain<D>::ThawStrain(PointFields& fields, const GroundSettings<D>& settings)
        : settings_(&settings)
{
	frozenSaturationField_ = fields.declare("frozenSaturation", "thawStrain", "-", 1);
	releasedField_         = fields.declare("thawStrainReleased", "thawStrain", "-", 1);
	openField_             = fields.declare("thawStrainOpen", "thawStrain", "-", 1);
	lastVolumeField_       = fields.declare("volumeBefore", "thawStrain", "m^D", 1);
	expansion_             = expansionOfIce(settings);
	if (expansion_ == 0.0) return;
	widenedField_  = fields.declare("widenedByIce", "thawStrain", "m^D", 1);
	dilationField_ = fields.declare("dilationLately", "thawStrain", "m^D", 1);
	iceField_      = fields.declare("iceBefore", "thawStrain", "kg", 1);
}

template <int D> void ThawStrain<D>::bind(MaterialPoints<D>& points, int cells)
{
	PointFields& fields                               = points.fields();
	points_                                           = &points;
	down_[layerNormal<D>(settings_->motion->gravity)] = 1.0;
	frozenSaturation_                                 = fields.component(frozenSaturationField_);
	released_                                         = fields.component(releasedField_);
	open_                                             = fields.component(openField_);
	lastVolume_                                       = fields.component(lastVolumeField_);
	sharing_.bind(settings_->motion->bBar, cells, points.capacity());
	ofSkeleton_.reserve(points.capacity());
	closed_.reserve(2 * points.capacity());
	if (expansion_ == 0.0) return;
	widened_  = fields.component(widenedField_);
	dilation_ = fields.component(dilationField_);
	lastIce_  = fields.component(iceField_);
	freezing_.reset(points.capacity());
}

template <int D> void ThawStrain<D>::keepOnly(const ActiveRange& range, int firstPoint, int endPoint)
{
	sharing_.keepOnly(range, firstPoint, endPoint);
	if (expansion_ > 0.0) freezing_.keepOnly(firstPoint, endPoint);
}

template <int D> void ThawStrain<D>::start(int first, int end, const double* iceSaturation, const double* iceMass)
{
	if (expansion_ > 0.0) std::copy(iceMass + first, iceMass + end, lastIce_ + first);
	std::copy(iceSaturation + first, iceSaturation + end, frozenSaturation_ + first);
	std::copy(points_->volume() + first, points_->volume() + end, lastVolume_ + first);
}

template <int D>
void ThawStrain<D>::release(
        const StepContext<D>& step, const PointsInMotion<D>& points, const double* iceSaturation, const double* iceMass, const CellMeans<D>* cells)
{
	const double kept = std::exp(-step.dt / gravityTime(settings_->gridSpacing, lengthOf<D>(settings_->motion->gravity)));
	sharing_.clear(step, cells);
	sharing_.add(step, [&](int p, Sharing& s) {
		const double volume = points.volume[p];
		releaseAt(p, iceSaturation[p], points.initialVolume[p]);
		if (expansion_ > 0.0) followIce(p, lastVolume_[p] * points.trace(p), iceMass[p], kept, s);
		s.volume += volume;
		s.room += lastVolume_[p] * open_[p];
		s.contraction += lastVolume_[p] - volume;
		lastVolume_[p] = volume;
	});
}

template <int D> void ThawStrain<D>::releaseAt(int p, double iceSaturation, double initialVolume)
{
	const double most = settings_->materials.empty() ? 0.0 : settings_->materials[points_->material(p)].thawStrain;
	if (most == 0.0 || iceSaturation >= frozenSaturation_[p]) return;
	const double melted = most * (1.0 - iceSaturation / frozenSaturation_[p]);
	const double more   = std::max(0.0, melted - released_[p]); // ice that forms again fills pores only
	released_[p] += more;
	open_[p] += more * initialVolume / lastVolume_[p];
}

/// What pore ice does that grows or melts in the step, before cells share it. dilation: of the ground in the step [m^D].
template <int D> void ThawStrain<D>::followIce(int p, double dilation, double iceMass, double kept, Sharing& s)
{
	const double more = expansion_ * (iceMass - lastIce_[p]), leaves = std::min(widened_[p], std::max(0.0, -more));
	lastIce_[p] = iceMass;
	widened_[p] -= leaves;
	open_[p] += leaves / lastVolume_[p];
	freezing_[p] = std::max(0.0, more);
	dilation_[p] = kept * dilation_[p] + dilation;
	s.freezing += freezing_[p];
	s.dilation += dilation_[p];
}

template <int D> const std::vector<int>& ThawStrain<D>::openAmong(const std::vector<int>& places)
{
	ofSkeleton_.clear();
	for (const int p : places)
		if (sharing_[p].room > 0.0) ofSkeleton_.push_back(p);
	return ofSkeleton_;
}

template <int D> void ThawStrain<D>::close(const StepContext<D>& step, const PointsInMotion<D>& points, const double* modulus, const Gradients<D>& gradient)
{
	if (lengthOf<D>(settings_->motion->gravity) == 0.0) return;
	// by which a point expands along gravity when it loses its load
	sharing_.add(step, [&](int p, Sharing& s) {
		if (s.room > 0.0) s.elastic += points.volume[p] * (std::max(0.0, points.pressureAlong(p, down_)) / modulus[p]);
	});
	if (expansion_ > 0.0) widen(step, points, gradient);
	for (int p = step.strips.firstPoint(); p < step.strips.endPoint(); ++p) {
		const Sharing& s = sharing_[p];
		if (!(s.room > 0.0)) continue;
		const double settled = std::min(s.room, std::max(0.0, s.contraction)), left = s.room - settled;
		const double unloaded = std::min(s.elastic, left), closes = (settled + unloaded) / s.volume;
		open_[p] = (left - unloaded) / s.volume;
		closed_.add(gradient, p, closes, down_); // gradient of the soil, eq. (24.2)
	}
}

/// Water that freezes and cannot leave parts the grains, eq. (24.7).
template <int D> void ThawStrain<D>::widen(const StepContext<D>& step, const PointsInMotion<D>& points, const Gradients<D>& gradient)
{
	step.bookByStrip([&](StepAccount<D>& account, int first, int last) {
		for (int p = first; p < last; ++p) {
			const Sharing& s      = sharing_[p];
			const double   widens = std::clamp(s.dilation, 0.0, s.freezing), strain = widens / s.volume;
			if (!(strain > 0.0)) continue;
			dilation_[p] -= strain * points.volume[p];
			widened_[p] += widens * freezing_[p] / s.freezing;
			account.segregationWork += strain * points.volume[p] * points.pressureAlong(p, down_);
		}
	});
	for (int p = step.strips.firstPoint(); p < step.strips.endPoint(); ++p)
		if (const Sharing& s = sharing_[p]; s.dilation > 0.0 && s.freezing > 0.0)
			closed_.add(gradient, p, -std::min(s.dilation, s.freezing) / s.volume, down_);
}

TALIK_IN_PLANE_AND_SPACE(ThawStrain);

} // namespace talik
