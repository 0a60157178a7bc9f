// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/ActiveRange.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/PagedArray.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>

#include <vector>

namespace talik {

template <int D> class CellMeans;
template <int D> class SolidMotion;

/// Ice-rich ground holds more ice than the pores of its soil. When it thaws, the soil closes the room of that ice, along gravity: ice
/// lenses lie flat, and thaw strain is measured as settlement without strain aside. A skeleton law knows the soil alone, so it is given
/// the strain of the soil, which is that of the ground and what closes, eqs (24.1) to (24.3). Room that is open carries no stress:
/// soil unloads into it or the ground settles until it is closed. With B-bar the points of a cell share their room, as they share their
/// volumetric strain: else those without room would carry the load of the others, which then would never close. Ground that swells with
/// its room open, as it does when it falls and springs back, has to contract by as much before the room closes further.
template <int D> class ThawStrain {
public:
	ThawStrain(PointFields& fields, const GroundSettings<D>& settings);
	void bind(MaterialPoints<D>& points, SolidMotion<D>& motion, const double* iceSaturation, int cells);
	/// Takes the ice that the points have now as that of the frozen ground.
	void start(int first, int end);

	/// Adds the room that ice has left and the change of volume since the last step; cells null: every point by itself. range: of the cells.
	void release(const CellMeans<D>* cells, const ActiveRange& range);
	/// Points of a skeleton with room to close, in the order of places; valid until the next call.
	const std::vector<int>& openAmong(const std::vector<int>& places);
	/// Adds to the displacement gradient of all points that were asked for what closes in this step, eq. (24.3); modulus [Pa]: of the
	/// oedometer, by place.
	void close(const double* modulus);
	/// Ice saturation of the frozen ground at the start [-].
	double frozenSaturation(int place) const { return frozenSaturation_[place]; }
	/// Room that ice has left there is not closed yet.
	bool isOpen(int place) const { return open_[place] > 0.0; }
	/// Gives all points back the displacement gradient of the ground.
	void restoreGradients();
	/// Of cells or points only these take memory.
	void keepOnly(const ActiveRange& range, int firstPoint, int endPoint);

private:
	/// Sums over the points of a cell, or one point.
	struct Sharing {
		double volume, room; ///< [m^D]; what ice has left open [m^D]
		double contraction;  ///< of the step, less what the ground has swollen by with its room open [m^D]
		double elastic;      ///< what the soil would expand by without its load [m^D]
	};
	/// Gradient of a point as the grid has it.
	struct OfGrid {
		int                       place;
		std::array<double, D * D> gradient;
	};
	Sharing& sharing(int place);
	void     releaseAt(int place);
	void     shareCells(SharedRows& rows);
	/// Strain along gravity by which a point expands when it loses its load [-], >= 0.
	double unloadingAt(int place, const Vec<D>& down, const double* modulus) const;

	const GroundSettings<D>* settings_;
	MaterialPoints<D>*       points_        = nullptr;
	SolidMotion<D>*          motion_        = nullptr;
	const CellMeans<D>*      cells_         = nullptr;
	const double*            iceSaturation_ = nullptr;
	PointFields::Handle      frozenSaturationField_, releasedField_, openField_, swollenField_, lastVolumeField_;
	double *                 frozenSaturation_ = nullptr, *released_ = nullptr, *open_ = nullptr, *swollen_ = nullptr, *lastVolume_ = nullptr;
	/// Each point of a cell unloads by its own load, not by the mean of the cell. With pore water frozen points stand in tension beside thawed
	/// ones, and the mean would open soil that has no load: a column then settles by 16 % too little. Without water the mean is nearer.
	bool                ownUnloading_ = false;
	PagedArray<Sharing> sharing_;
	PagedArray<char>    asked_; ///< by place: the point is one of all_
	std::vector<int>    ofSkeleton_, all_;
	std::vector<OfGrid> changed_;
};

extern template class ThawStrain<2>;
extern template class ThawStrain<3>;

} // namespace talik
