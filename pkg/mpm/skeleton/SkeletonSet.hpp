// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace talik {

/// The skeleton laws of a ground, and the points that each of them has.
template <int D> class SkeletonSet {
public:
	using Laws = std::vector<std::shared_ptr<SkeletonModel<D>>>;

	/// laws: those of the settings, which may be exchanged between two steps. arrays: of all points, by place; they stay where they are.
	void bind(const Laws& laws, const MaterialPoints<D>& points, const SkeletonBatch<D>& arrays)
	{
		laws_   = &laws;
		points_ = &points;
		arrays_ = arrays;
	}
	/// Finds the points of each law, after points were sorted or given other laws.
	void list()
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

	int               count() const { return int(laws_->size()); }
	SkeletonModel<D>& law(int k) const { return *(*laws_)[k]; }
	/// Of the points of a law, those of this rank, ascending.
	const std::vector<int>& places(int k) const { return places_[k]; }
	/// Those of all ranks; valid until the next call.
	const std::vector<int>& placesOfAll(int k)
	{
		placesOfAll_.clear();
		for (int p = 0; p < points_->count(); ++p)
			if (points_->skeletons()[p] == k) placesOfAll_.push_back(p);
		return placesOfAll_;
	}

	SkeletonBatch<D> batch(int k, const StepTime& time) const { return batch(places_[k], time); }
	/// Of some points of a law; places have to live as long.
	SkeletonBatch<D> batch(const std::vector<int>& places, const StepTime& time) const
	{
		SkeletonBatch<D> b = arrays_;
		b.count            = int(places.size());
		b.place            = places.data();
		b.time             = time;
		return b;
	}

	/// Tangent oedometer modulus of this rank's points [Pa], by place.
	void tangentModulus(const StepTime& time, double* modulus) const
	{
		for (int k = 0; k < count(); ++k)
			law(k).tangentModulus(batch(k, time), modulus);
	}
	/// Stress of the points of a law, from the strain of the step and their ice.
	void update(const StepContext<D>& step, int k) const
	{
		if (!used_[k]) return;
		if (law(k).seesStrips()) updateByStrips(step, k);
		else law(k).updateStress(batch(k, step.time()));
	}

private:
	/// One strip after the other, so that what the law sees at once does not depend on the ranks. One that fails ends the step on all of them.
	void updateByStrips(const StepContext<D>& step, int k) const
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

	const Laws*                   laws_   = nullptr;
	const MaterialPoints<D>*      points_ = nullptr;
	SkeletonBatch<D>              arrays_;
	std::vector<std::vector<int>> places_;
	std::vector<int>              placesOfAll_;
	std::vector<char>             used_; ///< the law has points, on any rank
};

} // namespace talik
