// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <memory>
#include <vector>

namespace talik {

/// The skeleton laws of a ground, and the points that each of them has.
template <int D> class SkeletonSet {
public:
	using Laws = std::vector<std::shared_ptr<SkeletonModel<D>>>;

	/// laws: those of the settings, which may be exchanged between two steps. arrays: of all points, by place; they stay where they are.
	void bind(const Laws& laws, const MaterialPoints<D>& points, const SkeletonBatch<D>& arrays);
	/// Finds the points of each law, after points were sorted or given other laws.
	void list();

	int               count() const { return int(laws_->size()); }
	SkeletonModel<D>& law(int k) const { return *(*laws_)[k]; }
	/// Of the points of a law, those of this rank, ascending.
	const std::vector<int>& places(int k) const { return places_[k]; }
	/// Those of all ranks; valid until the next call.
	const std::vector<int>& placesOfAll(int k);

	SkeletonBatch<D> batch(int k, const StepTime& time) const { return batch(places_[k], time); }
	/// Of some points of a law; places have to live as long.
	SkeletonBatch<D> batch(const std::vector<int>& places, const StepTime& time) const;

	/// Tangent oedometer modulus of this rank's points [Pa], by place.
	void tangentModulus(const StepTime& time, double* modulus) const;
	/// Stress of the points of a law, from the strain of the step and their ice.
	void update(const StepContext<D>& step, int k) const;

private:
	void updateByStrips(const StepContext<D>& step, int k) const;

	const Laws*                   laws_   = nullptr;
	const MaterialPoints<D>*      points_ = nullptr;
	SkeletonBatch<D>              arrays_;
	std::vector<std::vector<int>> places_;
	std::vector<int>              placesOfAll_;
	std::vector<char>             used_; ///< the law has points, on any rank
};

} // namespace talik
