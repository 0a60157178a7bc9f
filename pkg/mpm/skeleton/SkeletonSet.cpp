// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/skeleton/SkeletonSet.hpp>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace talik {

template <int D> void SkeletonSet<D>::bind(const Laws& laws, const MaterialPoints<D>& points, const SkeletonBatch<D>& arrays)
{
	laws_   = &laws;
	points_ = &points;
	arrays_ = arrays;
}

template <int D> void SkeletonSet<D>::list()
{
	arrays_.id = points_->ids();
	places_.resize(count());
	for (auto& places : places_) {
		places.clear();
		places.reserve(points_->count());
	}
	const int* const of = points_->skeletons();
	for (int p = points_->strips().firstPoint(); p < points_->strips().endPoint(); ++p)
		places_[of[p]].push_back(p);
	used_.assign(count(), 0);
	for (int p = 0; p < points_->count(); ++p)
		used_[of[p]] = 1;
}

template <int D> const std::vector<int>& SkeletonSet<D>::placesOfAll(int k)
{
	placesOfAll_.clear();
	for (int p = 0; p < points_->count(); ++p)
		if (points_->skeletons()[p] == k) placesOfAll_.push_back(p);
	return placesOfAll_;
}

template <int D> SkeletonBatch<D> SkeletonSet<D>::batch(const std::vector<int>& places, const StepTime& time) const
{
	SkeletonBatch<D> b = arrays_;
	b.count            = int(places.size());
	b.place            = places.data();
	b.time             = time;
	return b;
}

template <int D> void SkeletonSet<D>::tangentModulus(const StepTime& time, double* modulus) const
{
	for (int k = 0; k < count(); ++k)
		law(k).tangentModulus(batch(k, time), modulus);
}

template <int D> void SkeletonSet<D>::update(const StepContext<D>& step, int k) const
{
	if (!used_[k]) return;
	if (law(k).seesStrips()) updateByStrips(step, k);
	else law(k).updateStress(batch(k, step.time()));
}

/// One strip after the other, so that what the law sees at once does not depend on the ranks. One that fails ends the step on all of them.
template <int D> void SkeletonSet<D>::updateByStrips(const StepContext<D>& step, int k) const
{
	const std::vector<int>& places = places_[k];
	std::string             words;
	try {
		auto from = places.begin();
		for (int s = step.strips.begin(); s < step.strips.end(); ++s) {
			const auto to = std::lower_bound(from, places.end(), step.strips.first[s + 1]);
			if (from == to) continue;
			SkeletonBatch<D> ofStrip = batch(k, step.time());
			ofStrip.place            = places.data() + (from - places.begin());
			ofStrip.count            = int(to - from);
			ofStrip.strip            = s;
			law(k).updateStress(ofStrip);
			from = to;
		}
	} catch (const std::exception& problem) {
		words = problem.what();
	}
	words = step.firstWords(words);
	if (!words.empty()) throw std::runtime_error(words);
}

TALIK_IN_PLANE_AND_SPACE(SkeletonSet);

} // namespace talik
