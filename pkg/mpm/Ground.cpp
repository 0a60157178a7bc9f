// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundParts.hpp>

namespace talik {

template <int D>
Ground<D>::Ground()
        : parts_(std::make_unique<Parts>())
{
}

template <int D>
Ground<D>::Ground(const GroundSettings<D>& settings)
        : Ground()
{
	parts_->settings = settings;
}

template <int D> Ground<D>::~Ground()                           = default;
template <int D> Ground<D>::Ground(Ground&&) noexcept            = default;
template <int D> Ground<D>& Ground<D>::operator=(Ground&&) noexcept = default;

template <int D> GroundSettings<D>&       Ground<D>::settings() { return parts_->settings; }
template <int D> const GroundSettings<D>& Ground<D>::settings() const { return parts_->settings; }

template <int D> bool Ground<D>::initialised() const { return parts_->ready; }

template <int D> void Ground<D>::step(double dt)
{
	beginStep(dt);
	p2g();
	solveNodes();
	g2p();
	updateStrainAndPressure();
	updateEffectiveStress();
}

template <int D> double Ground<D>::time() const { return parts_->clock.time; }
template <int D> bool   Ground<D>::heatRests() const { return parts_->heatRests; }
template <int D> bool   Ground<D>::waterRests() const { return parts_->waterRests; }
template <int D> long   Ground<D>::steps() const { return parts_->clock.steps; }
template <int D> double Ground<D>::dt() const { return parts_->clock.dt; }

template <int D> const CalendarState& Ground<D>::calendar() const { return parts_->clock.calendar; }
template <int D> double Ground<D>::seepageScale() const { return parts_->water ? parts_->water->scale : 1.0; }
template <int D> double Ground<D>::largestConductivity() const { return parts_->water ? parts_->water->largestConductivity : std::numeric_limits<double>::infinity(); }

template <int D> void Ground<D>::setCalendar(double time)
{
	Parts& g              = *parts_;
	g.clock.calendar.time = time;
	if (!g.calendar) return;
	g.calendar->events.clear();
	g.clock.calendar.moving = 0;
}

template <int D> std::vector<MotionEvent> Ground<D>::events() const
{
	const Parts& g = *parts_;
	if (!g.calendar) return {};
	std::vector<MotionEvent> list = g.calendar->events;
	if (!g.clock.calendar.moving) return list;
	const MotionEvent present = g.calendar->present(g.clock.calendar, g.clock.time, g.points->count());
	if (present.largest > g.settings.heat->eventDisplacement) list.push_back(present);
	return list;
}

template <int D> const std::vector<MotionEvent>& Ground<D>::endedEvents() const
{
	static const std::vector<MotionEvent> none;
	return parts_->calendar ? parts_->calendar->events : none;
}

template <int D> void Ground<D>::setEndedEvents(const std::vector<MotionEvent>& events)
{
	if (parts_->calendar) parts_->calendar->events = events;
}

template <int D> const Grid<D>&           Ground<D>::grid() const { return parts_->grid; }
template <int D> MaterialPoints<D>&       Ground<D>::points() { return *parts_->points; }
template <int D> const MaterialPoints<D>& Ground<D>::points() const { return *parts_->points; }

template <int D> RigidContact<D>* Ground<D>::bodies() { return parts_->bodies.get(); }

template <int D> SkeletonBatch<D> Ground<D>::skeletonBatch(int skeleton) const { return parts_->batch(skeleton); }

template class Ground<2>;
template class Ground<3>;

} // namespace talik
