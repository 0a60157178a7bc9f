// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/PointsInMotion.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <vector>

namespace talik {

template <int D> class ThawStrain;

/// Ground that has thawed is softer than its skeleton law: it follows a measured curve of strain over stress (CompressionCurve). What the
/// curve asks for beyond the strain of the law is lost for good along gravity, as thaw strain is, eqs (24.4) to (24.6). The law is
/// given the strain of the soil without it, so that any law takes it.
template <int D> class ThawedCompression {
public:
	ThawedCompression(PointFields& fields, const GroundSettings<D>& settings);
	/// porosity, iceSaturation: of the points, which it reads, as thaw strain.
	void bind(MaterialPoints<D>& points, const ThawStrain<D>& thawStrain, const double* porosity, const double* iceSaturation);
	/// Takes the present stress as that without strain. Ground that has no ice has settled under it already.
	void start(int first, int end, const PointsInMotion<D>& moving);

	/// Those of these points that are thawed in part and have a curve; valid until the next call.
	const std::vector<int>& thawedAmong(const std::vector<int>& places);
	/// Ice saturation of thawed ground, by place.
	const double* noIce() const { return noIce_.data(); }
	/// For the oedometer moduli of thawed ground [Pa], by place.
	double* thawedModulus() { return thawedModulus_.data(); }
	/// Adds to the displacement gradient of all points what is lost in this step, eq. (24.6); modulus [Pa]: of the oedometer, by place.
	void compress(const StepContext<D>& step, const PointsInMotion<D>& moving, const double* modulus, const Gradients<D>& gradient);
	/// Gives all points back the displacement gradient that they had.
	void restoreGradients(const Gradients<D>& gradient) { lost_.takeOut(gradient); }
	/// Of points only these take memory.
	void keepOnly(int firstPoint, int endPoint);
	/// What is wrong where the law alone, of thawedModulus(), gives as much strain as the curve at the start, or
	/// the curve more than there are pores; empty: nothing.
	std::string fault(const std::string& law, int place) const;

private:
	double melted(int place) const;
	bool   isThawed(int place) const { return settings_->materials[points_->material(place)].compression.given() && melted(place) > 0.0; }
	/// present: volume of the point over that at the start [-].
	double lossOf(int place, double present, double pressure, double modulus) const;

	const GroundSettings<D>* settings_;
	MaterialPoints<D>*       points_     = nullptr;
	const ThawStrain<D>*     thawStrain_ = nullptr;
	const double *           porosity_ = nullptr, *iceSaturation_ = nullptr;
	PointFields::Handle      compressionField_, meanPressureField_, stressAtStartField_;
	double *                 compression_ = nullptr, *meanPressure_ = nullptr, *stressAtStart_ = nullptr;
	Vec<D>                   down_ {}; ///< normal of the layers
	PagedArray<double>       noIce_, thawedModulus_, losses_;
	/// In which the stress that counts follows that of the point [s]: sound that runs through the ground as it settles presses nothing together.
	double           smoothingTime_ = 0.0;
	std::vector<int> ofSkeleton_;
	AddedStrain<D>   lost_;
};

} // namespace talik
