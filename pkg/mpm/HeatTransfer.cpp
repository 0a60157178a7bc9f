// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/HeatTransfer.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

template <int D>
HeatTransfer<D>::HeatTransfer(PointFields& fields, const HeatSettings& heat)
        : settings(&heat)
{
	enthalpy_     = fields.declare("enthalpy", "heat", "J", 1);
	temperature_  = fields.declare("temperature", "heat", "degC", 1);
	heatCapacity_ = fields.declare("heatCapacity", "heat", "J/K", 1);
	conductivity_ = fields.declare("conductivity", "heat", "W/(m K)", 1);
}

template <int D> void HeatTransfer<D>::bind(MaterialPoints<D>& points, const Grid<D>& grid)
{
	PointFields& f = points.fields();
	enthalpy       = f.component(enthalpy_);
	temperature    = f.component(temperature_);
	heatCapacity   = f.component(heatCapacity_);
	conductivity   = f.component(conductivity_);
	volume         = points.volume();
	nodes.allocate(grid.nodeCount());
	mapped.allocate(grid.nodeCount());
	nodal.allocate(grid.nodeCount());
	energy.allocate(grid.nodeCount());
	rise.allocate(grid.nodeCount());
}

template <int D> void HeatTransfer<D>::constrain(const Grid<D>& grid, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries)
{
	prescribed_.clear();
	std::vector<char> taken(grid.nodeCount(), 0);
	for (std::size_t b = 0; b < boundaries.size(); ++b) {
		if (!boundaries[b]->prescribesTemperature()) continue;
		const Region<D>& region = boundaries[b]->region();
		const bool       wall   = region.kind == Region<D>::Kind::side;
		const int        inward = region.on.upper ? -grid.nodeStride(region.on.axis) : grid.nodeStride(region.on.axis);
		for (int node : wallNodes(grid, region)) {
			if (taken[node]) continue;
			taken[node] = 1;
			prescribed_.push_back({ node, wall ? node - inward : -1, wall ? node + inward : -1, static_cast<int>(b) });
		}
	}
	wanted_.assign(prescribed_.size(), 0.0);
}

template <int D> void HeatTransfer<D>::map(const Grid<D>& grid, const WeightBlock<D>& w)
{
	for (int k = 0; k < w.count; ++k) {
		const double c  = heatCapacity[w.first + k];
		const double ct = c * temperature[w.first + k];
		overNodes<D>(grid, w, k, [&](int node, double s, const Vec<D>&) {
			double* r = nodes[node];
			r[0] += s * c;
			r[1] += s * ct;
		});
	}
}

template <int D>
void HeatTransfer<D>::nodalTemperature(const ActiveRange& range, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries, double time)
{
	// Behind a wall temperature continues linearly, T_ghost = 2 T_wall - T_inner; the ghost's share goes to these two.
	for (const TemperatureNode& n : prescribed_) {
		if (n.ghost < 0) continue;
		for (int i = 0; i < 2; ++i) {
			nodes[n.node][i] += 2.0 * nodes[n.ghost][i];
			nodes[n.inner][i] -= nodes[n.ghost][i];
			nodes[n.ghost][i] = 0.0;
		}
	}
	range.overNodes([&](int, int first, int last) {
		for (int i = first; i < last; ++i) {
			const double* r = nodes[i];
			const double  t = r[0] > 0.0 ? r[1] / r[0] : 0.0;
			mapped[i][0]    = t;
			nodal[i][0]     = t;
			energy[i][0]    = 0.0;
		}
	});
	for (std::size_t k = 0; k < prescribed_.size(); ++k) {
		wanted_[k] = boundaries[prescribed_[k].boundary]->temperature(time);
		if (nodes[prescribed_[k].node][0] > 0.0) nodal[prescribed_[k].node][0] = wanted_[k];
	}
	for (auto n = prescribed_.rbegin(); n != prescribed_.rend(); ++n)
		if (n->ghost >= 0) nodal[n->ghost][0] = 2.0 * nodal[n->node][0] - nodal[n->inner][0];
}

template <int D> void HeatTransfer<D>::conduct(const Grid<D>& grid, const WeightBlock<D>& w, double dt)
{
	const double scaled = dt * settings->thermalTimeScale;
	const double source = scaled * settings->source;
	for (int k = 0; k < w.count; ++k) {
		const int p = w.first + k;
		Vec<D>    slope {};
		overNodes<D>(grid, w, k, [&](int node, double, const Vec<D>& g) {
			const double t = nodal[node][0];
			for (int i = 0; i < D; ++i)
				slope[i] += g[i] * t;
		});
		const double conductance = -volume[p] * conductivity[p] * scaled;
		const double produced    = volume[p] * source;
		for (int i = 0; i < D; ++i)
			slope[i] *= conductance;
		overNodes<D>(grid, w, k, [&](int node, double s, const Vec<D>& g) {
			double e = s * produced;
			for (int i = 0; i < D; ++i)
				e += g[i] * slope[i];
			energy[node][0] += e;
		});
	}
}

template <int D>
void HeatTransfer<D>::exchange(const SurfaceHeat& heat, const SurfacePatch<D>& patch, const FreeSurface<D>& surface, double spacing, double dt)
{
	const double scale = settings->thermalTimeScale;
	for (const SurfaceNode<D>& n : patch.nodes) {
		const double capacity = nodes[n.node][0];
		if (capacity <= 0.0) continue;
		double area = 0.0;
		for (int i = 0; i < D; ++i)
			area += n.area[i] * n.area[i];
		area = std::sqrt(area);
		// resistance of a quarter of a cell between the surface and the node that stands for it
		const double coefficient = scale * (heat.atSurface ? 4.0 * surface.conductivity(n.node) / spacing : heat.coefficient);
		const double predicted   = mapped[n.node][0] + energy[n.node][0] / capacity;
		const double conductance = dt * coefficient * area;
		const double gained      = conductance * (heat.ambient - predicted) / (1.0 + conductance / capacity) + dt * scale * heat.flux * area;
		energy[n.node][0] += gained;
		heatIn += gained;
	}
}

template <int D> void HeatTransfer<D>::finishNodes(const ActiveRange& range, double dt)
{
	// Galerkin: the ghost's residual belongs to the two nodes that it depends on.
	for (const TemperatureNode& n : prescribed_) {
		if (n.ghost < 0) continue;
		energy[n.node][0] += 2.0 * energy[n.ghost][0];
		energy[n.inner][0] -= energy[n.ghost][0];
		energy[n.ghost][0] = 0.0;
	}
	for (std::size_t k = 0; k < prescribed_.size(); ++k) {
		const int    node     = prescribed_[k].node;
		const double capacity = nodes[node][0];
		if (capacity <= 0.0) continue;
		const double supplied = capacity * (wanted_[k] - mapped[node][0]);
		heatIn += supplied - energy[node][0];
		energy[node][0] = supplied;
	}
	const double smoothing = -std::expm1(-dt / settings->smoothingTime);
	range.overNodes([&](int, int first, int last) {
		for (int i = first; i < last; ++i)
			rise[i][0] = nodes[i][0] > 0.0 ? energy[i][0] / nodes[i][0] + smoothing * mapped[i][0] : 0.0;
	});
	for (auto n = prescribed_.rbegin(); n != prescribed_.rend(); ++n)
		if (n->ghost >= 0) rise[n->ghost][0] = 2.0 * rise[n->node][0] - rise[n->inner][0];
}

template <int D> void HeatTransfer<D>::gather(const Grid<D>& grid, const WeightBlock<D>& w, double dt)
{
	const double smoothing = -std::expm1(-dt / settings->smoothingTime);
	for (int k = 0; k < w.count; ++k) {
		const int p      = w.first + k;
		double    gained = 0.0;
		overNodes<D>(grid, w, k, [&](int node, double s, const Vec<D>&) { gained += s * rise[node][0]; });
		enthalpy[p] += heatCapacity[p] * (gained - smoothing * temperature[p]);
	}
}

template class HeatTransfer<2>;
template class HeatTransfer<3>;

} // namespace talik
