// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/PagedArray.hpp>
#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/mpm/points/PointsInMotion.hpp>
#include <pkg/mpm/StepLedger.hpp>
#include <pkg/thm/SegregationPotential.hpp>

#include <vector>

namespace talik {

template <int D> class CellMeans;
template <int D> class HeatTransfer;
template <int D> class PoreContent;
template <int D> class PoreWater;
template <int D> class SolidMotion;
template <int D> class ThawStrain;

/// Freezing ground draws water to its front, where it freezes as excess ice and parts the ground. The fringe through which it is drawn is
/// thinner than a cell or as thick as a few, so that the flux out of the last unfrozen cell comes from the closed form of the fringe, eqs (26.1) to
/// (26.3b), or from a measured segregation potential. It arrives in the cell that has the temperature of the lens. The ice that forms there is no ice
/// of the pores: it melts at T_f whatever the freezing curve. Its volume is strain of the ground along the gradient of temperature, and no strain of the
/// soil, eq. (26.5). Where it melts, the room that it leaves closes as that of thaw strain.
template <int D> class IceSegregation {
public:
	IceSegregation(PointFields& fields, const GroundSettings<D>& settings);
	void bind(MaterialPoints<D>& points, int cells);
	/// Of cells or points only these take memory.
	void keepOnly(const ActiveRange& range, int firstPoint, int endPoint)
	{
		cells_.keepOnly(range.firstCell, range.lastCell);
		taken_.keepOnly(firstPoint, endPoint);
	}

	/// The ground as it is at the start of the step, by cells.
	void collect(
	        const Grid<D>& grid, const CellMeans<D>& cells, const SolidMotion<D>& motion, const HeatTransfer<D>& heat, const PoreContent<D>& content,
	        const ActiveRange& range);
	/// Water that flows from cells to lenses through frozen fringes in the step: leaves the exchange of the one, and waits at the other for receive().
	/// dt: of calendar time.
	void draw(const Grid<D>& grid, const ActiveRange& range, PoreWater<D>& water, const EnthalpyModel& enthalpy, const Vec<D>& gravity, double dt);
	/// What that does to the works.
	void book(const ActiveRange& range, const PoreWater<D>& water, StepLedger<D>& ledger) const;
	/// Hands what cells were given to their frozen points: mass, enthalpy, momentum, and the volume that it takes as ice.
	void receive(const CellMeans<D>& cells, int first, int last, double* waterMass, double* enthalpy, PoreWater<D>& water);
	/// The volume of the new ice belongs to the points that have it, after the strain of the step was averaged over each cell.
	void shareVolume(const CellMeans<D>& cells, int first, int last);
	/// Room that melting ice leaves is handed to the thaw strain.
	void release(ThawStrain<D>& thawStrain);
	/// Takes the new ice out of the displacement gradient that laws see, until restoreGradients().
	void part(const CellMeans<D>& cells, SolidMotion<D>& motion);
	void restoreGradients(const Gradients<D>& gradient) { opened_.takeOut(gradient); }

	double *volume = nullptr, *iceMass = nullptr; ///< of excess ice when all of it is frozen [m^D]; what is frozen now [kg]

private:
	/// Water that goes to a lens [kg].
	struct Flux {
		double mass;
		int    to;
	};
	/// Sums over the points of a cell, and what it is given in the step.
	struct Cell {
		double volume;                     ///< [m^D]
		double depth;                      ///< volume times (T - T_f) [m^D K]; later their mean [K]
		double conductivity;               ///< volume times the number; later the mean [W/(m K)]
		double middle[D];                  ///< volume times the position; later the mean [m]
		double ice;                        ///< volume times the ice saturation
		double lenses;                     ///< volume of segregated ice, less what of it ice counts [m^D]
		double pores, fill;                ///< volume of the pores and of what is in them [m^D]
		double stress[stressSize<D>];      ///< effective, as the pressure [Pa]
		double added;                      ///< volume times what the momentum balance adds to each normal stress [Pa m^D]
		double leaning[D][2];              ///< volume times total stress along an axis that neighbours on a side transmit [Pa m^D]
		double soil;                       ///< the largest number of its materials
		bool   frozen;                     ///< so that it gives no water
		double lost;                       ///< given away in the step [kg]
		Flux   fluxes[2 * D];              ///< from its side of fronts, by axis and side
		double mass, enthalpy, carried[D]; ///< given to it [kg, J, N s]
		double opened;                     ///< by what is given to it, over its volume [-]
		double across[D];                  ///< given along the axes [kg]
		double normal[D];                  ///< along the gradient of temperature
	};
	/// What a point adds to the stress of its cell.
	void addLeaning(Cell& c, const Vec<D>& middle, double inverseSpacing, const SolidMotion<D>& motion, int place);
	struct Row;
	/// What cells give to others arrives there.
	void handOver(const Grid<D>& grid, const ActiveRange& range, const PoreWater<D>& water, const EnthalpyModel& enthalpy);

	static bool frozen(const Cell& c) { return c.frozen; }
	/// What freezes less than this below T_f is noise of the temperature [K].
	static constexpr double barely = 1e-6;
	/// What lies farther from the last unfrozen cell than so many cells is not looked at, and the lens lies nearer: ranks know seven rows, up to those two
	/// cells before the front whose heat comes to it. With 3 the heaving pressure is 29 % low.
	static constexpr int farthestBehind = 6;
	/// Cells behind the last unfrozen one whose surface is looked at: of nodes ranks know fewer rows.
	static constexpr int farthestSurface = 2;
	/// With a measured potential ground of a smaller ice saturation gives its water away as if it were not frozen: where ice forms over a range of
	/// temperatures, all of it may have cooled to a little below T_f. The closed form counts from T_f.
	static constexpr double littleIce = 0.05;

	const GroundSettings<D>*          settings_;
	const HeatTransfer<D>*            heat_   = nullptr; ///< as collect() had it
	const double*                     ice_    = nullptr; ///< saturation, by place
	MaterialPoints<D>*                points_ = nullptr;
	std::vector<SegregationPotential> soils_;
	std::vector<const FreezingCurve*> curves_;              ///< by material
	std::vector<double>               freezingTemperature_; ///< the same
	std::vector<double>               leastIce_;            ///< the same: saturation of cells that count as frozen
	double                            liquidDensity_, iceDensity_;
	PointFields::Handle               volumeField_, iceField_;
	PagedArray<Cell>                  cells_;
	PagedArray<double>                taken_; ///< by place: volume of the ice that a point got in the step [m^D]
	AddedStrain<D>                    opened_;
};

} // namespace talik
