// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/PointsInMotion.hpp>
#include <pkg/mpm/points/SharedSums.hpp>

#include <vector>

namespace talik {

template <int D> class ThawStrain;

/// Ground that has thawed is softer than its skeleton law: it follows a measured curve of strain over stress (CompressionCurve). What the
/// curve asks for beyond the strain of the law is lost for good along gravity, as thaw strain is, eqs (24.4) to (24.6). The law is
/// given the strain of the soil without it, so that any law takes it. With B-bar the points of a cell share it, as they share thaw strain.
template <int D> class ThawedCompression {
public:
	ThawedCompression(PointFields& fields, const GroundSettings<D>& settings);
	/// porosity, iceSaturation: of the points, which it reads, as thaw strain.
	void bind(MaterialPoints<D>& points, const ThawStrain<D>& thawStrain, const double* porosity, const double* iceSaturation, int cells);
	/// Takes the present stress as that without strain. Ground that has no ice has settled under it already.
	void start(int first, int end, const PointsInMotion<D>& moving);

	/// Those of these points that are thawed in part and have a curve; valid until the next call.
	const std::vector<int>& thawedAmong(const std::vector<int>& places);
	/// Ice saturation of thawed ground, by place.
	const double* noIce() const { return noIce_.data(); }
	/// For the oedometer moduli of thawed ground [Pa], by place.
	double* thawedModulus() { return thawedModulus_.data(); }
	/// Adds to the displacement gradient of all points around what is lost in this step, eq. (24.6); modulus [Pa]: of the oedometer, by place; cells
	/// null: every point by itself.
	void compress(
	        const StepContext<D>& step, const PointsInMotion<D>& moving, const double* modulus, const CellMeans<D>* cells, const Gradients<D>& gradient);
	/// Gives all points back the displacement gradient that they had.
	void restoreGradients(const Gradients<D>& gradient) { lost_.takeOut(gradient); }
	/// Of cells or points only these take memory.
	void keepOnly(const ActiveRange& range, int firstPoint, int endPoint);
	/// What is wrong where the law alone, of thawedModulus(), gives as much strain as the curve at the start, or
	/// the curve more than there are pores; empty: nothing.
	std::string fault(const std::string& law, int place) const;

private:
	struct Sharing {
		double volume;    ///< [m^D]
		double bearing;   ///< volume whose stress counts [m^D]
		double pressure;  ///< of that volume, times it [Pa m^D]
		double wanted;    ///< volume that the curves ask for if the stress stays [m^D]
		double stiffened; ///< volume, weighted by how much less is lost because stress falls with it [m^D]
	};
	/// What a point wants to lose.
	struct Wish {
		double strain; ///< of its volume, if its stress stays [-]
		double excess; ///< factor on the volume in Sharing::stiffened, less 1
	};
	double melted(int place) const;
	bool   isThawed(int place) const { return settings_->materials[points_->material(place)].compression.given() && melted(place) > 0.0; }
	/// present: volume of the point over that at the start [-].
	Wish wishOf(int place, double present, double bearing, double modulus, double taken) const;

	const GroundSettings<D>* settings_;
	MaterialPoints<D>*       points_     = nullptr;
	const ThawStrain<D>*     thawStrain_ = nullptr;
	const double *           porosity_ = nullptr, *iceSaturation_ = nullptr;
	PointFields::Handle      compressionField_, meanPressureField_, stressAtStartField_;
	double *                 compression_ = nullptr, *meanPressure_ = nullptr, *stressAtStart_ = nullptr;
	Vec<D>                   down_ {}; ///< normal of the layers
	PagedArray<double>       noIce_, thawedModulus_;
	PagedArray<Wish>         wishes_; ///< by place
	SharedSums<D, Sharing>   sharing_;
	/// The stress of a cell is the mean of its points: their own scatters about it, and what the peaks press together does not come back. With pore
	/// water that of its thawed part: frozen points stand in tension beside it.
	bool ofThawed_ = false;
	/// In which the stress that counts follows that of the cell [s]: sound that runs through the ground as it settles presses nothing together.
	double           smoothingTime_ = 0.0;
	std::vector<int> ofSkeleton_;
	AddedStrain<D>   lost_;
};

} // namespace talik
