// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/CalendarState.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/thm/ProcessorVersions.hpp>

#include <array>
#include <vector>

namespace talik {

template <int D> class HeatTransfer;
template <int D> class SolidMotion;

/// The calendar whose scale follows the motion: heat, weather and seepage run at thermalTimeScale while the ground rests and at
/// movingTimeScale while it moves. One decision per step, from the state at its start alone.
///
/// The scale is a smooth function of the largest speed v: f = f_m + (f_T - f_m)/(1 + (v/v_0)^2), v_0 the tolerance. A switch would
/// chatter in ground that thaw itself sets in motion, whose speed is in proportion to f. Between rest and an acceleration a some
/// (pi/2) f_T v_0/a of calendar time pass.
template <int D> class Calendar {
public:
	Calendar(PointFields& fields, const HeatSettings& settings);
	void bind(MaterialPoints<D>& points, const SolidMotion<D>& motion, const HeatTransfer<D>& heat);

	/// Scale of a step of length dt [s].
	double scale(const CalendarState& state, double dt) const;
	/// Speed and reach of the ground as it is. heatFraction: of the explicit limit of conduction.
	void measure(CalendarState& state, const Strips& strips, double spacing, double heatFraction);
	/// At the end of a step of length dt [s] that ended at time [s of motion], calendar included: keeps account of events.
	void keepEvents(CalendarState& state, double dt, double time, int points);
	/// The event that goes on, as if it ended now.
	MotionEvent present(const CalendarState& state, double time, int points) const;

	std::vector<MotionEvent> events; ///< that have ended, in order; those that moved nothing by eventDisplacement are left out

private:
	struct Extremes {
		double speedSquare, reach;
	};
	TALIK_PROCESSOR_VERSIONS Extremes extremesOf(int first, int last) const;
	void                     measureEvent(MotionEvent& event, int points) const;

	const HeatSettings*   settings_;
	PointFields::Handle   handle_;
	std::array<double*, D> before_ {}, displacement_ {}, velocity_ {};
	const double *        volume_ = nullptr, *capacity_ = nullptr, *conductivity_ = nullptr;
	std::vector<Extremes> partial_;
};

extern template class Calendar<2>;
extern template class Calendar<3>;

} // namespace talik
