// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/Calendar.hpp>
#include <pkg/mpm/effects/HeatTransfer.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

template <int D>
Calendar<D>::Calendar(PointFields& fields, const HeatSettings& settings)
        : settings_(&settings)
        , handle_(fields.declare("displacementBefore", "calendar", "m", D))
{}

template <int D> void Calendar<D>::bind(MaterialPoints<D>& points, const SolidMotion<D>& motion, const HeatTransfer<D>& heat)
{
	for (int a = 0; a < D; ++a)
		before_[a] = points.fields().component(handle_, a);
	displacement_ = motion.displacement;
	velocity_     = motion.velocity;
	volume_       = points.volume();
	mass_         = motion.mass;
	capacity_     = heat.heatCapacity;
	conductivity_ = heat.conductivity;
}

template <int D> double Calendar<D>::scale(const CalendarState& state, double dt) const
{
	const double slow = settings_->movingTimeScale, fast = settings_->thermalTimeScale;
	const double ratio  = state.speed / settings_->motionTolerance;
	const double wanted = slow + (fast - slow) / (1.0 + ratio * ratio);
	return std::max(slow, std::min(wanted, state.reach / dt));
}

/// Least heat capacity over volume and conductivity [s/m^2].
template <int D> double Calendar<D>::leastInertia(int first, int last) const
{
	double              least = std::numeric_limits<double>::infinity();
	const double* const v     = volume_;
	const double* const c     = capacity_;
	const double* const kappa = conductivity_;
	for (int p = first; p < last; ++p) {
		const double own = c[p] / (v[p] * kappa[p]);
		least            = own < least ? own : least;
	}
	return least;
}

/// Square of the largest speed of a point [m^2/s^2].
template <int D> double Calendar<D>::fastestPoint(int first, int last) const
{
	double fastest = 0.0;
	for (int p = first; p < last; ++p) {
		double square = 0.0;
		for (int a = 0; a < D; ++a)
			square += velocity_[a][p] * velocity_[a][p];
		fastest = square > fastest ? square : fastest;
	}
	return fastest;
}

/// Sums mass and momentum of the points of each cell.
template <int D> void Calendar<D>::sumInCells(const Strips& strips, const CellMeans<D>& cells, const ActiveRange& range)
{
	if (cellMotion_.empty()) cellMotion_.reset(cells.count());
	std::fill(cellMotion_.begin() + range.firstCell, cellMotion_.begin() + range.lastCell, std::array<double, D + 1> {});
	strips.scatter(
	        [&](int, int first, int last) {
		        for (int p = first; p < last; ++p) {
			        auto& sum = cellMotion_[cells.cell(p)];
			        for (int a = 0; a < D; ++a)
				        sum[a] += mass_[p] * velocity_[a][p];
			        sum[D] += mass_[p];
		        }
	        },
	        [&](SharedRows& rows) { rows.cells(cellMotion_.data()); });
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
        CalendarState& state, const Strips& strips, const CellMeans<D>* cells, const ActiveRange& range, const Grid<D>& grid, double heatFraction)
{
	const int    cellsOfStrip = Strips::rows * grid.cellStride(strips.axis);
	const double spacing      = grid.spacing();
	measured_.assign(strips.count(), {});
	if (cells) sumInCells(strips, *cells, range);
	strips.gather([&](int s, int first, int last) {
		const int firstCell = std::max(range.firstCell, s * cellsOfStrip), lastCell = std::min(range.lastCell, (s + 1) * cellsOfStrip);
		measured_[s] = { leastInertia(first, last), cells ? fastestCell(firstCell, lastCell) : fastestPoint(first, last) };
	});
	if (strips.bands) strips.bands->shareByStrip(measured_.data());
	Measured all;
	for (const Measured& strip : measured_) {
		all.inertia = std::min(all.inertia, strip.inertia);
		all.square  = std::max(all.square, strip.square);
	}
	state.reach = all.inertia * heatFraction * spacing * spacing / (2.0 * D); // eq. (21.2)
	state.speed = std::sqrt(all.square);
}

template <int D> void Calendar<D>::keepEvents(CalendarState& state, double dt, double time, const Strips& strips)
{
	const double tolerance = std::max(settings_->motionTolerance, settings_->eventSpeed * state.scale);
	if (!state.moving) {
		if (!(state.speed > tolerance)) return;
		state.moving = 1;
		state.quiet = state.quietCalendar = 0.0;
		state.event                       = { state.time, 0.0, time, 0.0, 0.0, 0.0 };
		for (int a = 0; a < D; ++a)
			std::copy(displacement_[a] + strips.firstPoint(), displacement_[a] + strips.endPoint(), before_[a] + strips.firstPoint());
		return;
	}
	const bool slow     = state.speed < 0.5 * tolerance;
	state.quiet         = slow ? state.quiet + dt : 0.0;
	state.quietCalendar = slow ? state.quietCalendar + state.scale * dt : 0.0;
	if (state.quiet < MotionEvent::quietTime) return;
	const MotionEvent ended = present(state, time, strips, strips.bands);
	if (ended.largest > settings_->eventDisplacement) events.push_back(ended);
	state.moving = 0;
}

template <int D> MotionEvent Calendar<D>::present(const CalendarState& state, double time, const Strips& strips, Bands* bands) const
{
	MotionEvent event = state.event;
	event.duration    = time - event.start - state.quiet;
	event.passed      = state.time - event.begin - state.quietCalendar;
	measureEvent(event, strips, bands);
	return event;
}

template <int D> void Calendar<D>::measureEvent(MotionEvent& event, const Strips& strips, Bands* bands) const
{
	struct Moved {
		double largest = 0.0, volume = 0.0;
	};
	const double       least = settings_->eventDisplacement * settings_->eventDisplacement;
	std::vector<Moved> byStrip(strips.count());
	for (int s = bands ? strips.begin() : 0; s < (bands ? strips.end() : strips.count()); ++s)
		for (int p = strips.first[s]; p < strips.first[s + 1]; ++p) {
			double square = 0.0;
			for (int a = 0; a < D; ++a) {
				const double moved = displacement_[a][p] - before_[a][p];
				square += moved * moved;
			}
			byStrip[s].largest = std::max(byStrip[s].largest, square);
			if (square > least) byStrip[s].volume += volume_[p];
		}
	if (bands) bands->shareByStrip(byStrip.data());
	double largest = 0.0;
	for (const Moved& moved : byStrip) {
		largest = std::max(largest, moved.largest);
		event.volume += moved.volume;
	}
	event.largest = std::sqrt(largest);
}

template class Calendar<2>;
template class Calendar<3>;

} // namespace talik
