// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundParts.hpp>

namespace talik {

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
		node("nodalHeat", "heat", "J, K", 3, g.heat->energy.bytes() + g.heat->noise.bytes() + g.heat->rise.bytes());
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
	const Parts&  g      = *parts_;
	const double* values = g.points->fields().find(field, component);
	if (!values) {
		std::string known;
		for (const FieldInfo& f : g.points->fields().list())
			known += (known.empty() ? "" : ", ") + f.name + "[" + std::to_string(f.components) + "]";
		throw std::invalid_argument("field '" + field + "' component " + std::to_string(component) + " does not exist; there are " + known);
	}
	for (int p = 0; p < g.points->count(); ++p)
		out[g.points->id(p)] = values[p];
}

template <int D> void Ground<D>::setThermalState(int id, double temperature, double pressure)
{
	Parts&    g = *parts_;
	const int p = g.points->place(id);
	if (!g.content) throw std::logic_error("setThermalState: the scene has neither heat nor water");
	g.contentSettled = false;
	g.content->fill(p, g.content->porosity[p], temperature, pressure, g.fillOf(id));
	if (g.content->update(p, p + 1) != p + 1) throw std::invalid_argument(g.whereabouts(p) + " cannot exist: " + g.content->whyImpossible(p));
}

template <int D> std::vector<StateArray> Ground<D>::state()
{
	Parts&                  g = *parts_;
	std::vector<StateArray> list;
	const std::size_t       n = g.points->count();
	PointFields&            f = g.points->fields();
	for (std::size_t k = 0; k < f.list().size(); ++k)
		if (f.list()[k].persistent)
			for (int c = 0; c < f.list()[k].components; ++c)
				list.push_back({ f.list()[k].name + "." + std::to_string(c), f.component(static_cast<int>(k), c), n * sizeof(double) });
	list.push_back({ "id", g.points->idArray().data(), n * sizeof(int) });
	list.push_back({ "skeleton", g.points->skeletons(), n * sizeof(int) });
	std::vector<int>& first = g.points->strips().first;
	list.push_back({ "strips", first.data(), first.size() * sizeof(int) });
	list.push_back({ "clock", &g.clock, sizeof(g.clock) });
	if (g.heat) {
		list.push_back({ "heatIn", &g.heat->heatIn, sizeof(double) });
		list.push_back({ "smoothingTime", &g.heat->smoothingTime, sizeof(double) });
	}
	if (g.water) {
		list.push_back({ "largestConductivity", &g.water->largestConductivity, sizeof(double) });
		list.push_back({ "waterOut", &g.water->waterOut, sizeof(double) });
		list.push_back({ "enthalpyOut", &g.water->enthalpyOut, sizeof(double) });
		list.push_back({ "momentumOut", &g.water->momentumOut, sizeof(Vec<D>) });
	}
	return list;
}

template <int D> void Ground<D>::stateRestored()
{
	Parts& g = *parts_;
	g.contentSettled = false;
	g.points->idsRestored();
	g.afterReordering();
}

template std::vector<FieldInfo> Ground<2>::fields() const;
template void Ground<2>::copyById(const std::string&, int, double*) const;
template void Ground<2>::setThermalState(int, double, double);
template std::vector<StateArray> Ground<2>::state();
template void Ground<2>::stateRestored();
template std::vector<FieldInfo> Ground<3>::fields() const;
template void Ground<3>::copyById(const std::string&, int, double*) const;
template void Ground<3>::setThermalState(int, double, double);
template std::vector<StateArray> Ground<3>::state();
template void Ground<3>::stateRestored();

} // namespace talik
