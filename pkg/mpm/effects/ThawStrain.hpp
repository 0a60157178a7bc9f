// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/PointsInMotion.hpp>
#include <pkg/mpm/points/SharedSums.hpp>

#include <vector>

namespace talik {

/// Ice-rich ground holds more ice than the pores of its soil. When it thaws, the soil closes the room of that ice, along gravity: ice
/// lenses lie flat, and thaw strain is measured as settlement without strain aside. A skeleton law knows the soil alone, so it is given
/// the strain of the soil, which is that of the ground and what closes, eqs (24.1) to (24.3). Room that is open carries no stress:
/// soil unloads into it or the ground settles until it is closed. With B-bar the points of a cell share their room, as they share their
/// volumetric strain: else those without room would carry the load of the others, which then would never close. Pore ice that has parted the grains,
/// eq. (24.7), leaves such room, too.
template <int D> class ThawStrain {
public:
	ThawStrain(PointFields& fields, const GroundSettings<D>& settings);
	void bind(MaterialPoints<D>& points, int cells);
	/// Takes the ice that the points have now as that of the frozen ground. iceSaturation: by place [-].
	void start(int first, int end, const double* iceSaturation, const double* iceMass);

	/// Room that excess ice leaves where it melts, which is not part of the ground's thawStrain [m^D]; before release().
	void addRoom(int place, double room) { open_[place] += room / lastVolume_[place]; }
	/// Adds the room that ice has left, eqs (24.1) and (24.7), and the change of volume since the last step. iceSaturation [-] and iceMass, that of
	/// the pores [kg]: by place; cells null: every point by itself.
	void release(
	        const StepContext<D>& step, const PointsInMotion<D>& points, const double* iceSaturation, const double* iceMass, const CellMeans<D>* cells);
	/// Those of these points with room to close; valid until the next call.
	const std::vector<int>& openAmong(const std::vector<int>& places);
	/// Adds to the displacement gradient of all points with room what closes in this step, eq. (24.3); modulus [Pa]: of the oedometer, by place.
	void close(const StepContext<D>& step, const PointsInMotion<D>& points, const double* modulus, const Gradients<D>& gradient);
	/// Ice saturation of the frozen ground at the start [-].
	double frozenSaturation(int place) const { return frozenSaturation_[place]; }
	/// Gives all points back the displacement gradient of the ground.
	void restoreGradients(const Gradients<D>& gradient) { closed_.takeOut(gradient); }
	/// Of cells or points only these take memory.
	void keepOnly(const ActiveRange& range, int firstPoint, int endPoint);

private:
	struct Sharing {
		double volume, room; ///< [m^D]; what ice has left open [m^D]
		double contraction;  ///< of the step [m^D]
		double elastic;      ///< what the soil would expand by without its load [m^D]
		double dilation;     ///< of the ground lately, that is not of widened pores [m^D]
		double freezing;     ///< by which ice that has formed in the step exceeds its water [m^D]
	};
	void releaseAt(int place, double iceSaturation, double initialVolume);
	void followIce(int place, double dilation, double iceMass, double kept, Sharing& s);
	void widen(const StepContext<D>& step, const PointsInMotion<D>& points, const Gradients<D>& gradient);

	const GroundSettings<D>* settings_;
	MaterialPoints<D>*       points_ = nullptr;
	PointFields::Handle      frozenSaturationField_, releasedField_, openField_, lastVolumeField_;
	PointFields::Handle      widenedField_ = -1, dilationField_ = -1, iceField_ = -1;
	double *                 frozenSaturation_ = nullptr, *released_ = nullptr, *open_ = nullptr, *lastVolume_ = nullptr;
	/// Of pore ice that widens its pores: the volume by which it has done so [m^D], what the ground has dilated by lately [m^D], ice before [kg].
	double *               widened_ = nullptr, *dilation_ = nullptr, *lastIce_ = nullptr;
	double                 expansion_ = 0.0; ///< volume by which ice exceeds its water over its mass [m^D/kg]; 0: ice widens nothing
	PagedArray<double>     freezing_;        ///< of the step by place: see Sharing::freezing [m^D]
	Vec<D>                 down_ {};         ///< normal of the layers
	SharedSums<D, Sharing> sharing_;
	std::vector<int>       ofSkeleton_;
	AddedStrain<D>         closed_;
};

} // namespace talik
