// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <limits>

namespace talik {

/// A time in which the ground moved: from the first step in which a point was faster than HeatSettings::motionTolerance, and in calendar
/// time than eventSpeed, until all of it was slower
/// than half of that for MotionEvent::quietTime.
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
	/// Speed of the fastest point at the end of the last step [m/s], and how much calendar time one step may take for the sake of heat [s].
	double      speed  = 0.0, reach = std::numeric_limits<double>::infinity();
	long        moving = 0;   ///< an event goes on
	double      quiet  = 0.0, quietCalendar = 0.0; ///< how long the ground has been slow in it [s of motion, of calendar time]
	MotionEvent event;        ///< the one that goes on
};

} // namespace talik
