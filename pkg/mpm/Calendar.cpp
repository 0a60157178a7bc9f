// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/Calendar.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

template <int D>
Calendar<D>::Calendar(PointFields& fields, const HeatSettings& settings)
        : settings_(&settings)
{
	fields.declare("displacementBefore", "calendar", "m", before_);
}

template <int D> double Calendar<D>::scale(const CalendarState& state, double dt) const
{
	const double slow = settings_->movingTimeScale, fast = settings_->thermalTimeScale;
	const double ratio  = state.speed / settings_->motionTolerance;
	const double wanted = slow + (fast - slow) / (1.0 + ratio * ratio);
	return std::max(slow, std::min(wanted, state.reach / dt));
}

/// Least heat capacity over volume and conductivity [s/m^2].
template <int D> double Calendar<D>::leastInertia(const double* volume, const ConductingPoints& heat, int first, int last) const
{
	double              least = std::numeric_limits<double>::infinity();
	const double* const v     = volume;
	const double* const c     = heat.heatCapacity;
	const double* const kappa = heat.conductivity;
	for (int p = first; p < last; ++p) {
		const double own = c[p] / (v[p] * kappa[p]);
		least            = own < least ? own : least;
	}
	return least;
}

/// Square of the largest speed of a point [m^2/s^2].
template <int D> double Calendar<D>::fastestPoint(const PointsInMotion<D>& points, int first, int last) const
{
	double fastest = 0.0;
	for (int p = first; p < last; ++p) {
		double square = 0.0;
		for (int a = 0; a < D; ++a)
			square += points.velocity[a][p] * points.velocity[a][p];
		fastest = square > fastest ? square : fastest;
	}
	return fastest;
}

/// Sums mass and momentum of the points of each cell.
template <int D> void Calendar<D>::sumInCells(const StepContext<D>& step, const PointsInMotion<D>& points, const CellMeans<D>& cells)
{
	if (cellMotion_.empty()) cellMotion_.reset(cells.count());
	std::fill(cellMotion_.begin() + step.owned.firstCell, cellMotion_.begin() + step.owned.lastCell, std::array<double, D + 1> {});
	step.strips.scatter(
	        [&](int, int first, int last) {
		        for (int p = first; p < last; ++p) {
			        auto& sum = cellMotion_[cells.cell(p)];
			        for (int a = 0; a < D; ++a)
				        sum[a] += points.mass[p] * points.velocity[a][p];
			        sum[D] += points.mass[p];
		        }
	        },
	        [&](HaloExchange& rows) { rows.cells(cellMotion_.data()); });
}

/// Square of the largest mean velocity in the cells first .. last [m^2/s^2].
template <int D> double Calendar<D>::fastestCell(int first, int last) const
{
	double fastest = 0.0;
	for (int c = first; c < last; ++c) {
		const auto& sum = cellMotion_[c];
		if (!(sum[D] > 0.0)) continue;
		double square = 0.0;
		for (int a = 0; a < D; ++a)
			square += sum[a] * sum[a];
		fastest = std::max(fastest, square / (sum[D] * sum[D]));
	}
	return fastest;
}

template <int D>
void Calendar<D>::measure(
        const StepContext<D>& step, const PointsInMotion<D>& points, const ConductingPoints& heat, const CellMeans<D>* cells, double heatFraction,
        CalendarState& state)
{
	const Strips& strips       = step.strips;
	const int     cellsOfStrip = Strips::rows * step.grid.cellStride(strips.axis);
	const double  spacing      = step.grid.spacing();
	measured_.assign(strips.count(), {});
	if (cells) sumInCells(step, points, *cells);
	strips.gather([&](int s, int first, int last) {
		const int firstCell = std::max(step.owned.firstCell, s * cellsOfStrip), lastCell = std::min(step.owned.lastCell, (s + 1) * cellsOfStrip);
		measured_[s] = { leastInertia(points.volume, heat, first, last), cells ? fastestCell(firstCell, lastCell) : fastestPoint(points, first, last) };
	});
	if (strips.slabs) strips.slabs->shareByStrip(measured_.data());
	Measured all;
	for (const Measured& strip : measured_) {
		all.inertia = std::min(all.inertia, strip.inertia);
		all.square  = std::max(all.square, strip.square);
	}
	state.reach = all.inertia * heatFraction * spacing * spacing / (2.0 * D); // eq. (21.2)
	state.speed = std::sqrt(all.square);
}

template <int D> void Calendar<D>::keepEvents(const StepContext<D>& step, const PointsInMotion<D>& points, double time, CalendarState& state)
{
	const Strips& strips    = step.strips;
	const double  tolerance = std::max(settings_->motionTolerance, settings_->eventSpeed * state.scale);
	if (!state.moving) {
		if (!(state.speed > tolerance)) return;
		state.moving = 1;
		state.quiet = state.quietCalendar = 0.0;
		state.event                       = { state.time, 0.0, time, 0.0, 0.0, 0.0 };
		for (int a = 0; a < D; ++a)
			std::copy(points.displacement[a] + strips.firstPoint(), points.displacement[a] + strips.endPoint(), before_[a] + strips.firstPoint());
		return;
	}
	const bool slow     = state.speed < 0.5 * tolerance;
	state.quiet         = slow ? state.quiet + step.dt : 0.0;
	state.quietCalendar = slow ? state.quietCalendar + step.calendarDt : 0.0;
	if (state.quiet < MotionEvent::quietTime) return;
	const MotionEvent ended = present(state, points, time, strips, strips.slabs);
	if (ended.largest > settings_->eventDisplacement) events.push_back(ended);
	state.moving = 0;
}

template <int D>
MotionEvent Calendar<D>::present(const CalendarState& state, const PointsInMotion<D>& points, double time, const Strips& strips, SlabDecomposition* slabs) const
{
	MotionEvent event = state.event;
	event.duration    = time - event.start - state.quiet;
	event.passed      = state.time - event.begin - state.quietCalendar;
	measureEvent(event, points, strips, slabs);
	return event;
}

template <int D> void Calendar<D>::measureEvent(MotionEvent& event, const PointsInMotion<D>& points, const Strips& strips, SlabDecomposition* slabs) const
{
	struct Moved {
		double largest = 0.0, volume = 0.0;
	};
	const double       least = settings_->eventDisplacement * settings_->eventDisplacement;
	std::vector<Moved> byStrip(strips.count());
	for (int s = slabs ? strips.begin() : 0; s < (slabs ? strips.end() : strips.count()); ++s)
		for (int p = strips.first[s]; p < strips.first[s + 1]; ++p) {
			double square = 0.0;
			for (int a = 0; a < D; ++a) {
				const double moved = points.displacement[a][p] - before_[a][p];
				square += moved * moved;
			}
			byStrip[s].largest = std::max(byStrip[s].largest, square);
			if (square > least) byStrip[s].volume += points.volume[p];
		}
	if (slabs) slabs->shareByStrip(byStrip.data());
	double largest = 0.0;
	for (const Moved& moved : byStrip) {
		largest = std::max(largest, moved.largest);
		event.volume += moved.volume;
	}
	event.largest = std::sqrt(largest);
}

TALIK_IN_PLANE_AND_SPACE(Calendar);

} // namespace talik
