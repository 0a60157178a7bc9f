// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/ThawStrain.hpp>
#include <pkg/mpm/points/CellMeans.hpp>

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
	points_                                           = &points;
	down_[layerNormal<D>(settings_->motion->gravity)] = 1.0;
	frozenSaturation_                                 = points.fields().component(frozenSaturationField_);
	released_                                         = points.fields().component(releasedField_);
	open_                                             = points.fields().component(openField_);
	lastVolume_                                       = points.fields().component(lastVolumeField_);
	if (expansion_ > 0.0) {
		widened_  = points.fields().component(widenedField_);
		dilation_ = points.fields().component(dilationField_);
		lastIce_  = points.fields().component(iceField_);
		freezing_.reset(points.capacity());
		widening_.reset(points.capacity());
	}
	sharing_.reset(averages() ? cells : points.capacity());
	asked_.reset(points.capacity());
	ofSkeleton_.reserve(points.capacity());
	all_.reserve(points.capacity());
	closed_.reserve(2 * points.capacity());
}

template <int D> void ThawStrain<D>::start(int first, int end, const double* iceSaturation, const double* iceMass)
{
	if (expansion_ > 0.0) std::copy(iceMass + first, iceMass + end, lastIce_ + first);
	std::copy(iceSaturation + first, iceSaturation + end, frozenSaturation_ + first);
	std::copy(points_->volume() + first, points_->volume() + end, lastVolume_ + first);
}

template <int D> typename ThawStrain<D>::Sharing& ThawStrain<D>::sharing(int place) { return sharing_[cells_ ? cells_->cell(place) : place]; }

template <int D> void ThawStrain<D>::releaseAt(int p, const double* iceSaturation, const double* initialVolume)
{
	const double most = settings_->materials.empty() ? 0.0 : settings_->materials[points_->material(p)].thawStrain;
	if (most == 0.0 || iceSaturation[p] >= frozenSaturation_[p]) return;
	const double melted = most * (1.0 - iceSaturation[p] / frozenSaturation_[p]);
	const double more   = std::max(0.0, melted - released_[p]); // ice that forms again fills pores only
	released_[p] += more;
	open_[p] += more * initialVolume[p] / lastVolume_[p];
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

/// Water that freezes and cannot leave parts the grains, eq. (24.7).
template <int D> void ThawStrain<D>::widen(const StepContext<D>& step, const PointsInMotion<D>& points)
{
	step.strips.gather([&](int strip, int first, int last) {
		double work = 0.0;
		for (int p = first; p < last; ++p) {
			const Sharing& s      = sharing(p);
			const double   widens = std::clamp(s.dilation, 0.0, s.freezing), strain = widens / s.volume;
			widening_[p] = strain;
			if (!(strain > 0.0)) continue;
			dilation_[p] -= strain * points.volume[p];
			widened_[p] += widens * freezing_[p] / s.freezing;
			work += strain * points.volume[p] * points.pressureAlong(p, down_);
		}
		step.ledger.ofStrip(strip).segregationWork += work;
	});
}

template <int D> void ThawStrain<D>::keepOnly(const ActiveRange& range, int firstPoint, int endPoint)
{
	if (averages()) sharing_.keepOnly(range.firstCell, range.lastCell);
	else sharing_.keepOnly(firstPoint, endPoint);
	asked_.keepOnly(firstPoint, endPoint);
	if (expansion_ == 0.0) return;
	freezing_.keepOnly(firstPoint, endPoint);
	widening_.keepOnly(firstPoint, endPoint);
}

/// Points of neighbouring strips may lie in one cell.
template <int D> void ThawStrain<D>::shareCells(HaloExchange& rows)
{
	if (cells_) rows.cells(sharing_.data());
}

template <int D>
void ThawStrain<D>::release(
        const StepContext<D>& step, const PointsInMotion<D>& points, const double* iceSaturation, const double* iceMass, const CellMeans<D>* cells)
{
	cells_ = cells;
	for (const int p : all_)
		asked_[p] = 0;
	all_.clear();
	if (cells) std::fill(sharing_.begin() + step.halo.firstCell, sharing_.begin() + step.halo.lastCell, Sharing {});
	else std::fill(sharing_.begin() + step.strips.firstPoint(), sharing_.begin() + step.strips.endPoint(), Sharing {});
	const double* const volume = points.volume;
	const double        kept   = std::exp(-step.dt / gravityTime(settings_->gridSpacing, lengthOf<D>(settings_->motion->gravity)));
	step.strips.scatter(
	        [&](int, int first, int last) {
		        for (int p = first; p < last; ++p) {
			        releaseAt(p, iceSaturation, points.initialVolume);
			        Sharing& s = sharing(p);
			        if (expansion_ > 0.0) followIce(p, lastVolume_[p] * points.trace(p), iceMass[p], kept, s);
			        s.volume += volume[p];
			        s.room += lastVolume_[p] * open_[p];
			        s.contraction += lastVolume_[p] - volume[p];
			        lastVolume_[p] = volume[p];
		        }
	        },
	        [&](HaloExchange& rows) { shareCells(rows); });
}

template <int D> const std::vector<int>& ThawStrain<D>::openAmong(const std::vector<int>& places)
{
	ofSkeleton_.clear();
	for (const int p : places)
		if (sharing(p).room > 0.0) ofSkeleton_.push_back(p);
	all_.insert(all_.end(), ofSkeleton_.begin(), ofSkeleton_.end());
	for (const int p : ofSkeleton_)
		asked_[p] = 1;
	return ofSkeleton_;
}

template <int D> void ThawStrain<D>::close(const StepContext<D>& step, const PointsInMotion<D>& points, const double* modulus, const Gradients<D>& gradient)
{
	if (lengthOf<D>(settings_->motion->gravity) == 0.0) return;
	// strain along gravity by which a point expands when it loses its load
	const auto unloadingAt = [&](int p) { return std::max(0.0, points.pressureAlong(p, down_)) / modulus[p]; };
	step.strips.scatter(
	        [&](int, int first, int last) {
		        for (int p = first; p < last; ++p)
			        if (asked_[p]) sharing(p).elastic += points.volume[p] * unloadingAt(p);
	        },
	        [&](HaloExchange& rows) { shareCells(rows); });
	if (expansion_ > 0.0) widen(step, points);
	for (int p = step.strips.firstPoint(); expansion_ > 0.0 && p < step.strips.endPoint(); ++p)
		if (widening_[p] > 0.0) closed_.add(gradient, p, -widening_[p], down_);
	for (const int p : all_) {
		const Sharing& s       = sharing(p);
		const double   settled = std::min(s.room, std::max(0.0, s.contraction)), left = s.room - settled;
		const double   unloaded = std::min(s.elastic, left), closes = (settled + unloaded) / s.volume;
		open_[p] = (left - unloaded) / s.volume;
		closed_.add(gradient, p, closes, down_); // gradient of the soil, eq. (24.2)
	}
}

TALIK_IN_PLANE_AND_SPACE(ThawStrain);

} // namespace talik
