// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <functional>
#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/CellMeans.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/mpm/points/PointsInMotion.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <array>
#include <limits>
#include <vector>

namespace talik {

/// A time in which the ground moved: from the first step in which the fastest ground passed HeatSettings::motionTolerance, and in
/// calendar time eventSpeed, until it had been slower than half of that for MotionEvent::quietTime.
struct MotionEvent {
	static constexpr double quietTime = 0.2; ///< [s of motion]

	double begin    = 0.0; ///< [s of calendar time]
	double passed   = 0.0; ///< calendar time that passed meanwhile [s]
	double start    = 0.0; ///< [s of motion]
	double duration = 0.0; ///< [s of motion]
	double volume   = 0.0; ///< of the points displaced by more than HeatSettings::eventDisplacement [m^D]
	double largest  = 0.0; ///< displacement of any point [m]
};

/// What the calendar of a ground has in its clock.
struct CalendarState {
	double time  = 0.0; ///< of slow processes and boundary tables [s]
	double scale = 1.0; ///< calendar time that passes per time of motion in this or the last step [-]
	/// Speed of the fastest ground at the end of the last step [m/s], and how much calendar time one step may take for the sake of heat [s].
	double      speed = 0.0, reach = std::numeric_limits<double>::infinity();
	long        moving = 0;                       ///< an event goes on
	double      quiet = 0.0, quietCalendar = 0.0; ///< how long the ground has been slow in it [s of motion, of calendar time]
	MotionEvent event;                            ///< the one that goes on
};

/// What conducts at the points, by place.
struct ConductingPoints {
	const double* heatCapacity; ///< [J/K]
	const double* conductivity; ///< [W/(m K)]
};

/// The calendar whose scale follows the motion: heat, weather and seepage run at thermalTimeScale while the ground rests and at
/// movingTimeScale while it moves. One decision per step, from the state at its start alone.
///
/// The scale is a smooth function of the largest speed v: f = f_m + (f_T - f_m)/(1 + (v/v_0)^2), v_0 the tolerance. A switch
/// between two scales would change in every step where thaw itself moves the ground, because its speed is in proportion to f,
/// eq. (21.1). Between rest and an acceleration a some (pi/2) f_T v_0/a of calendar time pass. v is the largest mean velocity of the
/// points of a cell: points of one cell may swing against each other, which moves no ground.
template <int D> class Calendar {
public:
	Calendar(PointFields& fields, const HeatSettings& settings);

	/// Scale of a step of length dt [s].
	double scale(const CalendarState& state, double dt) const;
	/// Speed and reach of the ground as it is, for the next step. heatFraction: of the explicit limit of conduction. cells: where the points are; null:
	/// the fastest point counts.
	void measure(
	        const StepContext<D>& step, const PointsInMotion<D>& points, const ConductingPoints& heat, const CellMeans<D>* cells, double heatFraction,
	        CalendarState& state);
	/// At the end of a step that ended at time [s of motion], calendar included: keeps account of events.
	void keepEvents(const StepContext<D>& step, const PointsInMotion<D>& points, double time, CalendarState& state);
	/// The event that goes on, as if it ended now. slabs: their ranks ask together; null: the points of all are current here.
	MotionEvent present(const CalendarState& state, const PointsInMotion<D>& points, double time, const Strips& strips, SlabDecomposition* slabs) const;
	/// Only cells of this part are used from now on; all others are zero and take no memory.
	void keepOnly(const ActiveRange& range) { cellMotion_.keepOnly(range.firstCell, range.lastCell); }

	std::vector<MotionEvent> events; ///< that have ended, in order; those that moved nothing by eventDisplacement are left out

private:
	TALIK_PROCESSOR_VERSIONS double leastInertia(const double* volume, const ConductingPoints& heat, int first, int last) const;
	TALIK_PROCESSOR_VERSIONS double fastestPoint(const PointsInMotion<D>& points, int first, int last) const;
	void                            sumInCells(const StepContext<D>& step, const PointsInMotion<D>& points, const CellMeans<D>& cells);
	double                          fastestCell(int first, int last) const;
	void                            measureEvent(MotionEvent& event, const PointsInMotion<D>& points, const Strips& strips, SlabDecomposition* slabs) const;

	const HeatSettings*    settings_;
	std::array<double*, D> before_ {}; ///< displacement of the points when the event began
	/// Least heat capacity over volume and conductivity [s/m^2], and the square of the largest speed [m^2/s^2].
	struct Measured {
		double inertia = std::numeric_limits<double>::infinity(), square = 0.0;
	};
	std::vector<Measured> measured_; ///< by strip
	/// By cell: momentum [kg m/s] and mass [kg] of its points.
	PagedArray<std::array<double, D + 1>> cellMotion_;
};

} // namespace talik
