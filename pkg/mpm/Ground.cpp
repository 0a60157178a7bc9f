// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundParts.hpp>

namespace talik {

template <int D>
Ground<D>::Ground()
        : parts_(std::make_unique<Parts>())
{}

template <int D>
Ground<D>::Ground(const GroundSettings<D>& settings)
        : Ground()
{
	parts_->settings = settings;
}

template <int D> Ground<D>::~Ground()                               = default;
template <int D> Ground<D>::Ground(Ground&&) noexcept               = default;
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
template <int D> long   Ground<D>::steps() const { return parts_->clock.steps; }
template <int D> double Ground<D>::dt() const { return parts_->clock.dt; }

template <int D> const CalendarState& Ground<D>::calendar() const { return parts_->clock.calendar; }
template <int D> double               Ground<D>::seepageScale() const { return parts_->water ? parts_->water->scales.smallest : 1.0; }
template <int D> double               Ground<D>::largestConductivity() const
{
	return parts_->water ? parts_->water->largestConductivity : std::numeric_limits<double>::infinity();
}

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
	g.ranks.bringPoints();
	const MotionEvent present = g.calendar->present(g.clock.calendar, g.inMotion, g.clock.time, g.points->strips(), nullptr);
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

template <int D> const std::vector<int>& Ground<D>::divisions() const { return parts_->parents; }

template <int D> void Ground<D>::repeatDivisions(const std::vector<int>& parents)
{
	parts_->points->resize(parts_->points->count() + int(parents.size()));
	parts_->followDivision(parents);
}

template <int D> RigidContact<D>* Ground<D>::bodies() { return parts_->bodies.get(); }

template <int D> SkeletonBatch<D> Ground<D>::skeletonBatch(int skeleton) const
{
	Parts& g = *parts_;
	if (!g.ranks) return g.skeletons.batch(skeleton, g.stepTime());
	g.ranks.bringPoints();
	return g.skeletons.batch(g.skeletons.placesOfAll(skeleton), g.stepTime());
}

template <int D> void Ground<D>::startSkeleton(int skeleton)
{
	settings().skeletons[skeleton]->initialise(skeletonBatch(skeleton));
	if (parts_->ranks) parts_->followSlabs(false);
}

template <int D> PointFields& Ground<D>::pointFields()
{
	parts_->ranks.bringPoints();
	return points().fields();
}

// ---- fields and state ---------------------------------------------------------------------------------------------------

template <int D> std::vector<FieldInfo> Ground<D>::fields() const
{
	const Parts&           g    = *parts_;
	std::vector<FieldInfo> list = g.points->fields().list();
	const auto             node = [&](const char* name, const char* owner, const char* unit, int components, std::size_t bytes) {
                list.push_back({ name, owner, unit, "nodes", components, bytes, false });
	};
	if (g.motion) {
		node("massMomentumForce", "motion", "kg, kg m/s, N", 2 * D + 1, g.motion->nodes.bytes());
		node("solvedVelocity", "motion", "m/s", 2 * D, g.motion->solved.bytes());
	}
	if (g.heat) {
		node("heatCapacitySum", "heat", "J/K, J", 2, g.heat->nodes.bytes());
		node("nodalTemperature", "heat", "J/K, degC", 3, g.heat->capacity.bytes() + g.heat->mapped.bytes() + g.heat->nodal.bytes());
		node("nodalHeat", "heat", "J, K", 3, g.heat->energy.bytes() + g.heat->nullSpaceResidual.bytes() + g.heat->increment.bytes());
		if (g.heat->moments.bytes() > 0) node("heatMoments", "heated walls", "J m/K", D, g.heat->moments.bytes());
	}
	if (g.water) {
		node("liquidMassMomentumDrag", "water", "kg, kg m/s, m^D, J, kg/s", 5 + D, g.water->nodes.bytes());
		node("nodalPressure", "water", "Pa, -, 1/kg", 3, g.water->nodal.bytes());
		node("liquidForce", "water", "N", D, g.water->force.bytes());
		node("solvedLiquidVelocity", "water", "m/s", 2 * D, g.water->solved.bytes() + g.water->start.bytes());
		node("seepageFlux", "water", "m/s", D, g.water->flux.bytes());
		node("seepageExchange", "water", "kg, J, kg m/s", 2 + D, g.water->exchange.bytes());
	}
	if (g.surface) node("surfaceArea", "surface boundaries", "m^(D-1), m^D, W m^(D-1)/K", D + 2, g.surface->nodes.bytes());
	return list;
}

template <int D> void Ground<D>::copyById(const std::string& field, int component, double* out) const
{
	const Parts& g = *parts_;
	g.ranks.bringPoints();
	const double* values = g.points->fields().find(field, component);
	if (!values) {
		std::string known;
		for (const FieldInfo& f : g.points->fields().list())
			known += (known.empty() ? "" : ", ") + f.name + "[" + std::to_string(f.components) + "]";
		throw std::invalid_argument("field '" + field + "' component " + std::to_string(component) + " does not exist; there are " + known);
	}
	for (int p = 0; p < g.points->count(); ++p)
		out[g.points->id(p)] = values[p];
	if (field != "volume" || !g.settings.axisymmetric) return;
	for (int p = 0; p < g.points->count(); ++p) // as it was given
		out[g.points->id(p)] /= g.points->position(0)[p];
}

template <int D> void Ground<D>::setThermalState(int id, double temperature, double pressure)
{
	Parts& g = *parts_;
	g.ranks.bringPoints();
	const int p = g.points->place(id);
	if (!g.content) throw std::logic_error("setThermalState: the scene has neither heat nor water");
	g.content->fill(p, g.content->porosity[p], temperature, pressure, g.fillOf(id), g.contentOf());
	if (g.content->update(p, p + 1, g.contentOf()) != p + 1)
		throw std::invalid_argument(whereabouts(*g.points, p, g.clock.steps) + " cannot exist: " + g.whyImpossible(p));
}

template <int D> std::vector<StateArray> Ground<D>::state()
{
	parts_->ranks.bringPoints();
	std::vector<StateArray>       list = pointState();
	const std::vector<StateArray> rest = commonState();
	list.insert(list.end(), rest.begin(), rest.end());
	return list;
}

template <int D> std::vector<StateArray> Ground<D>::pointState()
{
	std::vector<StateArray> list;
	PointFields&            f = parts_->points->fields();
	for (std::size_t k = 0; k < f.list().size(); ++k)
		if (f.list()[k].persistent)
			for (int c = 0; c < f.list()[k].components; ++c)
				list.push_back({ f.list()[k].name + "." + std::to_string(c), f.component(int(k), c), f.count() * sizeof(double) });
	return list;
}

template <int D> std::vector<StateArray> Ground<D>::commonState()
{
	Parts&                  g = *parts_;
	std::vector<StateArray> list;
	const std::size_t       n = g.points->count();
	list.push_back({ "id", g.points->idArray().data(), n * sizeof(int) });
	list.push_back({ "skeleton", g.points->skeletons(), n * sizeof(int) });
	if (auto* const materials = g.points->materials()) list.push_back({ "material", materials, n * sizeof(*materials) });
	std::vector<int>& first = g.points->strips().first;
	list.push_back({ "strips", first.data(), first.size() * sizeof(int) });
	list.push_back({ "clock", &g.clock, sizeof(g.clock) });
	if (g.momentum && !g.momentum->wallPaths().empty())
		list.push_back({ "wallPaths", g.momentum->wallPaths().data(), g.momentum->wallPaths().size() * sizeof(Vec<D>) });
	if (g.heat) list.push_back({ "smoothingTime", &g.heat->smoothingTime, sizeof(double) });
	if (g.water) list.push_back({ "largestConductivity", &g.water->largestConductivity, sizeof(double) });
	return list;
}

template <int D> void Ground<D>::stateRestored()
{
	Parts& g = *parts_;
	if (g.ranks) g.ranks.slabs()->weigh({});
	g.points->idsRestored();
	g.afterReordering();
}

template <int D> std::uint64_t Ground<D>::writePoints(const FilePlace& place)
{
	const Parts& g = *parts_;
	if (g.ranks) return g.ranks.slabs()->write(place);
	PartSum sum;
	g.ranks.writeOwnPoints(place, sum);
	return sum.value();
}

template <int D> void Ground<D>::readPoints(const PartedFile& file, std::uint64_t at)
{
	Parts& g = *parts_;
	if (g.ranks) g.ranks.readAgain();
	const std::size_t first = g.points->strips().firstPoint(), end = g.points->strips().endPoint();
	for (const StateArray& array : pointState()) {
		file.read(static_cast<double*>(array.data) + first, (end - first) * sizeof(double), at + first * sizeof(double));
		at += array.bytes;
	}
	stateRestored();
}

// ---- balance ------------------------------------------------------------------------------------------------------------

template <int D> Balance<D> Ground<D>::balance() const
{
	const Parts& g = *parts_;
	if (!g.ready) throw std::logic_error("balance: the ground is not initialised");
	g.ranks.bringPoints();
	Balance<D> b;
	static_cast<StepAccount<D>&>(b) = g.clock.account;
	for (int a = 0; a < D; ++a)
		b.impulse[a] -= b.momentumOut[a];
	b.time      = g.clock.time;
	const int n = g.points->count();
	for (int p = 0; p < n; ++p) {
		double moving = 0.0, liquid = 0.0;
		if (g.content) {
			const double ice = g.content->iceMass ? g.content->iceMass[p] : 0.0;
			b.solidMass += g.content->solidMass[p];
			b.waterMass += g.content->waterMass[p];
			b.iceMass += ice;
			if (g.water) liquid = g.content->waterMass[p] - ice;
		}
		if (g.motion) {
			moving = g.motion->mass[p];
			if (!g.content) b.solidMass += moving;
			const Vec<D>& gravity = g.motion->settings->gravity;
			for (int a = 0; a < D; ++a) {
				const double v = g.motion->velocity[a][p], vl = g.water ? g.water->velocity[a][p] : 0.0;
				b.momentum[a] += moving * v + liquid * vl;
				b.kineticEnergy += 0.5 * (moving * v * v + liquid * vl * vl);
				b.gravityEnergy -= (moving + liquid) * gravity[a] * (g.grid.isPeriodic(a) ? g.motion->displacement : g.motion->position)[a][p];
			}
		}
		if (g.heat) b.enthalpy += g.heat->enthalpy[p];
	}
	return b;
}

TALIK_IN_PLANE_AND_SPACE(Ground);

} // namespace talik
