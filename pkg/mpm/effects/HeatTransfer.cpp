// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/HeatTransfer.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

namespace {
	// A node takes the temperature of a wall or heated region at this rate over h^2 C/kappa, times the share of it that lies there. The edge
	// is then where it is: held faster, what lies outside would be held with it, and more slowly, ground inside would not follow. Ground of one
	// temperature at a wall meets the resistance h/(4 kappa) of eq. (9.6): its node expects 0.58 of the difference to the wall.
	constexpr double holding = 12.0;

	/// Integral of the shape function of a node over the side of the box on which it lies: a half beside another side.
	template <int D> double areaOfWall(const Grid<D>& grid, const TemperatureNode& n)
	{
		const auto at   = grid.nodeOf(n.node);
		double     area = grid.faceArea();
		for (int a = 0; a < D; ++a)
			if (a != n.axis && !grid.isPeriodic(a) && (at[a] <= 1 || at[a] > grid.cells(a))) area *= 0.5;
		return area;
	}
} // namespace

template <int D>
HeatTransfer<D>::HeatTransfer(PointFields& fields, const HeatSettings& heat, bool freezing)
        : settings(&heat)
{
	fields.declare("enthalpy", "heat", "J", enthalpy);
	fields.declare("temperature", "heat", "degC", temperature);
	fields.declare("heatCapacity", "heat", "J/K", heatCapacity);
	fields.declare("conductivity", "heat", "W/(m K)", conductivity);
	if (freezing) fields.declare("heatShare", "freezing", "J/K", capacityWeight);
}

template <int D> void HeatTransfer<D>::bind(MaterialPoints<D>& points, const Grid<D>& grid)
{
	if (!capacityWeight) capacityWeight = heatCapacity;
	volume = points.volume();
	for (int a = 0; a < D; ++a)
		position_[a] = points.position(a);
	nodes.allocate(grid.nodeCount());
	for (NodeField<1>* field : { &capacity, &mapped, &nodal, &energy, &nullSpaceResidual, &increment })
		field->allocate(grid.nodeCount());
}

template <int D> void HeatTransfer<D>::receiveInOneRecord(const Grid<D>& grid)
{
	using Conducted = typename NodeColumns<D>::Conducted;
	received_.allocate(grid.nodeCount());
	received_.shareColumns(energy, Conducted::heat);
	received_.shareColumns(nullSpaceResidual, Conducted::nullSpace);
}

template <int D> void HeatTransfer<D>::chooseSmoothing(const Grid<D>& grid, int points)
{
	smoothingTime = settings->smoothingTime;
	if (!std::isnan(smoothingTime) && held_.empty()) return;
	double capacitySum = 0.0, conductance = 0.0;
	for (int p = 0; p < points; ++p) {
		capacitySum += heatCapacity[p];
		conductance += volume[p] * conductivity[p];
	}
	diffusionTime_ = grid.spacing() * grid.spacing() * capacitySum / conductance;
	if (std::isnan(smoothingTime)) smoothingTime = diffusionTime_;
}

template <int D> void HeatTransfer<D>::constrain(const Grid<D>& grid, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries)
{
	prescribed_.clear();
	isPrescribed_.assign(grid.nodeCount(), 0);
	std::vector<char> touched(grid.nodeCount(), 0);
	for (std::size_t b = 0; b < boundaries.size(); ++b) {
		if (boundaries[b]->producesHeat()) {
			int number = 0;
			for (const NodeShare& s : nodeShares(grid, boundaries[b]->region()))
				produced_.push_back({ s.node, s.share, int(b), number++ });
		}
		if (!boundaries[b]->prescribesTemperature()) continue;
		const Region<D>&             region = boundaries[b]->region();
		const bool                   wall   = region.kind == Region<D>::Kind::side;
		const int                    inward = region.on.upper ? -grid.nodeStride(region.on.axis) : grid.nodeStride(region.on.axis);
		const std::vector<NodeShare> shares = nodeShares(grid, region);
		int                          number = 0;
		for (const NodeShare& s : shares)
			held_.push_back({ s.node, holding * s.share, int(b), number++ });
		if (!shares.empty()) continue;
		for (int node : wallNodes(grid, region)) {
			++isPrescribed_[node];
			touched[node] = 1;
			if (wall) touched[node - inward] = touched[node + inward] = 1;
			prescribed_.push_back({ node, wall ? node - inward : -1, wall ? node + inward : -1, region.on.axis, int(b) });
		}
	}
	// what lies behind another wall is the image of the ground there
	std::vector<char> behind(grid.nodeCount(), 0);
	for (const TemperatureNode& n : prescribed_)
		if (n.ghost >= 0) behind[n.ghost] = 1;
	for (const TemperatureNode& n : prescribed_)
		if (behind[n.node]) --isPrescribed_[n.node];
	prescribed_.erase(std::remove_if(prescribed_.begin(), prescribed_.end(), [&](const TemperatureNode& n) { return behind[n.node]; }), prescribed_.end());
	for (int n = 0; n < grid.nodeCount(); ++n)
		if (touched[n]) affected_.push_back(n);
	wanted_.assign(prescribed_.size(), 0.0);
	expected_.assign(prescribed_.size(), 0.0);
	gradient_.assign(prescribed_.size(), 0.0);
	walls_ = !prescribed_.empty();
	if (walls_) moments.allocate(grid.nodeCount());
	if (!produced_.empty()) volumes.allocate(grid.nodeCount());
}

template <int D> void HeatTransfer<D>::map(const WeightBlock<D>& w)
{
	if (walls_) mapMoments(w);
	if (!produced_.empty()) mapVolumes(w);
	if (carried_) return;
	double values[2][blockSize];
	for (int k = 0; k < w.count; ++k) {
		values[0][k] = capacityWeight[w.first + k];
		values[1][k] = capacityWeight[w.first + k] * (temperature[w.first + k] - reference);
	}
	nodeLoops<D>().mapPair(w, values, nodes[0]);
}

template <int D> void HeatTransfer<D>::mapMoments(const WeightBlock<D>& w)
{
	for (int k = 0; k < w.count; ++k) {
		const int                 p = w.first + k;
		std::array<double, D + 1> sums;
		for (int a = 0; a < D; ++a)
			sums[a] = capacityWeight[p] * position_[a][p];
		sums[D] = volume[p] * conductivity[p];
		overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) {
			for (int a = 0; a <= D; ++a)
				moments[node][a] += s * sums[a];
		});
	}
}

template <int D> void HeatTransfer<D>::mapVolumes(const WeightBlock<D>& w)
{
	for (int k = 0; k < w.count; ++k)
		overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) { volumes[node][0] += s * volume[w.first + k]; });
}

template <int D> void HeatTransfer<D>::mirrorWalls(const Grid<D>& grid, const ActiveRange& range)
{
	// The ground continues behind the wall as its mirror image with temperature 2 T_wall - T: the node in front of the wall
	// then averages over both, and the mean sits where the node is.
	for (std::size_t k = 0; k < prescribed_.size(); ++k) {
		const TemperatureNode& n = prescribed_[k];
		if (n.ghost < 0 || !range.holds(n.node)) continue;
		const double wall  = grid.nodePosition(n.axis, grid.nodeOf(n.node)[n.axis]);
		double*      ghost = nodes[n.ghost];
		double*      inner = nodes[n.inner];
		for (int a = 0; a < D; ++a) {
			double& moment = moments[n.ghost][a];
			moments[n.inner][a] += a == n.axis ? 2.0 * wall * ghost[0] - moment : moment;
			moment = 0.0;
		}
		inner[0] += ghost[0];
		inner[1] += 2.0 * wanted_[k] * ghost[0] - ghost[1];
		ghost[0] = ghost[1] = 0.0;
	}
}

template <int D> void HeatTransfer<D>::prescribe(const StepContext<D>& step)
{
	const Grid<D>&     grid    = step.grid;
	const ActiveRange& range   = step.halo;
	const double       h       = grid.spacing();
	const auto         isThere = [&](const TemperatureNode& n) { return range.holds(n.node) && nodes[n.node][0] > 0.0; };
	for (const TemperatureNode& n : prescribed_)
		if (isThere(n)) nodal[n.node][0] = 0.0;
	// where walls meet, the node has the mean of their temperatures
	for (std::size_t k = 0; k < prescribed_.size(); ++k)
		if (const TemperatureNode& n = prescribed_[k]; isThere(n)) nodal[n.node][0] += wanted_[k] / isPrescribed_[n.node];
	for (std::size_t k = 0; k < prescribed_.size(); ++k) {
		const TemperatureNode& n = prescribed_[k];
		gradient_[k]             = 0.0;
		if (!isThere(n)) continue;
		expected_[k]      = nodal[n.node][0];
		mapped[n.node][0] = reference + nodal[n.node][0]; // of water that comes in there
		if (n.ghost < 0 || isPrescribed_[n.inner] || !(nodes[n.inner][0] > 0.0)) continue;
		// points lie in front of the wall, not on it: their mean is off the wall temperature by the gradient
		const double wall     = grid.nodePosition(n.axis, grid.nodeOf(n.node)[n.axis]);
		const double distance = std::abs(moments[n.inner][n.axis] / nodes[n.inner][0] - wall);
		const double ahead    = std::abs(moments[n.node][n.axis] / nodes[n.node][0] - wall);
		if (distance < 0.5 * h || ahead > h) continue;
		gradient_[k] = (nodal[n.inner][0] - wanted_[k]) / distance;
		// away from the wall's temperature no faster than what the grid does not see dies out: irregular points would drive each
		// other up, step by step, however short the steps
		const double mean     = nodes[n.node][1] / nodes[n.node][0];
		const double farthest = mean + (mean - wanted_[k]) * smoothing(step);
		expected_[k]          = std::clamp(wanted_[k] + gradient_[k] * ahead, std::min(wanted_[k], farthest), std::max(wanted_[k], farthest));
		gradient_[k] *= h - distance;
	}
	// from the mean of the points around it to the node itself, along both axes near a corner
	for (std::size_t k = 0; k < prescribed_.size(); ++k)
		if (gradient_[k] != 0.0) nodal[prescribed_[k].inner][0] += gradient_[k];
	for (std::size_t k = prescribed_.size(); k-- > 0;) {
		const TemperatureNode& n = prescribed_[k];
		if (n.ghost >= 0 && range.holds(n.node)) nodal[n.ghost][0] = 2.0 * wanted_[k] - nodal[n.inner][0];
	}
}

template <int D> void HeatTransfer<D>::nodalTemperature(const StepContext<D>& step, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries)
{
	const ActiveRange& range = step.halo;
	range.eachNode([&](int i) {
		const double* r         = nodes[i];
		capacity[i][0]          = r[0];
		nodal[i][0]             = r[0] > 0.0 ? r[1] / r[0] : 0.0;
		mapped[i][0]            = reference + nodal[i][0];
		energy[i][0]            = 0.0;
		nullSpaceResidual[i][0] = 0.0;
	});
	for (std::size_t k = 0; k < prescribed_.size(); ++k)
		wanted_[k] = boundaries[prescribed_[k].boundary]->temperature(step.calendarEnd) - reference;
	mirrorWalls(step.grid, range);
	for (int i : affected_)
		if (range.holds(i)) nodal[i][0] = nodes[i][0] > 0.0 ? nodes[i][1] / nodes[i][0] : 0.0;
	prescribe(step);
	if (!outside.ownsRecords()) return;
	clearOutside(range);
	for (std::size_t k = 0; k < prescribed_.size(); ++k) {
		const TemperatureNode& n = prescribed_[k];
		if (n.ghost < 0 || !range.holds(n.node)) continue;
		Vec<D> area {};
		area[n.axis] = (n.ghost > n.node ? 1.0 : -1.0) * areaOfWall(step.grid, n);
		addOutside(n.node, area, reference + wanted_[k], 0.0);
	}
}

template <int D> void HeatTransfer<D>::addOutside(int node, const Vec<D>& area, double temperature, double heatOut)
{
	const double size = lengthOf<D>(area);
	addTo<D>(outside[node], area);
	outside[node][D] += size;
	outside[node][D + 1] += size * temperature;
	outside[node][D + 2] += heatOut;
}

template <int D> void HeatTransfer<D>::clearOutside(const ActiveRange& range)
{
	range.overNodes([&](int, int first, int last) { outside.clear(first, last); });
}

template <int D> typename NodeLoops<D>::HeatFlow HeatTransfer<D>::flow(const StepContext<D>& step) const
{
	return { volume, conductivity, capacityWeight, temperature, step.calendarDt, step.calendarDt * settings->source, reference };
}

template <int D> void HeatTransfer<D>::conduct(const StepContext<D>& step, const WeightBlock<D>& w)
{
	nodeLoops<D>().flowHeat(w, flow(step), nodal[0], energy[0]);
}

template <int D> void HeatTransfer<D>::produce(const StepContext<D>& step, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries)
{
	for (const ProducingNode& n : produced_) {
		if (!step.halo.holds(n.node)) continue;
		const double gained = step.calendarDt * boundaries[n.boundary]->powerAt(step.calendarEnd, n.number) * n.share * volumes[n.node][0];
		energy[n.node][0] += gained;
		step.ledger.ofNode(n.node).heatIn += gained;
	}
}

template <int D>
void HeatTransfer<D>::exchange(const StepContext<D>& step, const Boundary<D>& boundary, const SurfacePatch<D>& patch, const FreeSurface<D>& surface)
{
	const double dt = step.dt;
	for (std::size_t k = 0; k < patch.nodes.size(); ++k) {
		const SurfaceNode<D>& n        = patch.nodes[k];
		const double          capacity = nodes[n.node][0];
		if (capacity <= 0.0) continue;
		const SurfaceHeat heat = boundary.heatAt(step.calendarEnd, k);
		const double      area = lengthOf<D>(n.area);
		// resistance of a quarter of a cell between the surface and the node that stands for it, that of the air in series
		const double ground      = 4.0 * surface.conductivity(n.node) / step.grid.spacing();
		const double coefficient = step.calendarScale * (heat.atSurface ? ground : ground * heat.coefficient / (ground + heat.coefficient));
		const double predicted   = mapped[n.node][0] + energy[n.node][0] / capacity;
		const double conductance = dt * coefficient * area;
		const double gained      = conductance * (heat.ambient - predicted) / (1.0 + conductance / capacity) + step.calendarDt * heat.flux * area;
		energy[n.node][0] += gained;
		step.ledger.ofNode(n.node).heatIn += gained;
		if (outside.ownsRecords() && area > 0.0)
			addOutside(
			        n.node, n.area, mapped[n.node][0] + energy[n.node][0] / capacity + gained / (step.calendarDt * ground * area),
			        -gained / (step.calendarDt));
	}
}

template <int D> void HeatTransfer<D>::hold(const StepContext<D>& step, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries)
{
	for (const HeldNode& n : held_) {
		if (!step.halo.holds(n.node) || !(nodes[n.node][0] > 0.0) || isPrescribed_[n.node]) continue;
		const double predicted = (nodes[n.node][1] + energy[n.node][0]) / nodes[n.node][0];
		const double taken     = n.rate * step.calendarScale * step.dt / diffusionTime_;
		const double wanted    = boundaries[n.boundary]->temperatureAt(step.calendarEnd, n.number) - reference;
		const double gained    = nodes[n.node][0] * (wanted - predicted) * taken / (1.0 + taken);
		energy[n.node][0] += gained;
		step.ledger.ofNode(n.node).heatIn += gained;
	}
}

template <int D> void HeatTransfer<D>::finishNodes(const StepContext<D>& step, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries)
{
	const ActiveRange& range  = step.halo;
	StepLedger<D>&     ledger = step.ledger;
	hold(step, boundaries);
	for (int i : affected_)
		if (range.holds(i)) ledger.ofNode(i).heatIn -= energy[i][0];
	bookWalls(step, [&](int i) { return energy[i][0]; });
	for (const TemperatureNode& n : prescribed_) {
		if (n.ghost < 0 || !range.holds(n.node)) continue;
		energy[n.inner][0] -= energy[n.ghost][0];
		energy[n.ghost][0] = 0.0;
	}
	range.eachNode([&](int i) { increment[i][0] = nodes[i][0] > 0.0 ? energy[i][0] / nodes[i][0] : 0.0; });
	for (std::size_t k = 0; k < prescribed_.size(); ++k) {
		const int    node     = prescribed_[k].node;
		const double capacity = nodes[node][0];
		if (!range.holds(node) || !(capacity > 0.0)) continue;
		const double taken = holding * step.calendarDt * moments[node][D] / (step.grid.spacing() * step.grid.spacing() * capacity);
		increment[node][0] = (expected_[k] - nodes[node][1] / capacity) * taken / (1.0 + taken);
	}
	for (auto n = prescribed_.rbegin(); n != prescribed_.rend(); ++n)
		if (n->ghost >= 0 && range.holds(n->node)) increment[n->ghost][0] = 2.0 * increment[n->node][0] - increment[n->inner][0];
	for (int i : affected_)
		if (range.holds(i)) ledger.ofNode(i).heatIn += capacity[i][0] * increment[i][0];
	bookWalls(step, [&](int i) { return -capacity[i][0] * increment[i][0]; });

	// T + chi (1 - A)(B - 1) T, A = to the grid and back, B = A with wall temperatures kept: what the grid does not see decays,
	// the gradient at a wall and the sum of C T stay
	smoothed_        = smoothing(step);
	const double chi = smoothed_;
	range.eachNode([&](int i) {
		if (capacity[i][0] > 0.0) increment[i][0] += chi * (nodal[i][0] - nullSpaceResidual[i][0] / capacity[i][0]);
	});
}

/// Part of the heat that leaves at walls: of their nodes and those before and behind them.
template <int D> template <class Heat> void HeatTransfer<D>::bookWalls(const StepContext<D>& step, const Heat& heat)
{
	if (!outside.ownsRecords()) return;
	for (const TemperatureNode& n : prescribed_) {
		if (n.ghost < 0 || !step.halo.holds(n.node)) continue;
		double sum = heat(n.node) + heat(n.ghost);
		if (!isPrescribed_[n.inner]) sum += heat(n.inner);
		outside[n.node][D + 2] += sum / step.calendarDt;
	}
}

template <int D> void HeatTransfer<D>::gather(const WeightBlock<D>& w, const double* gained)
{
	double sums[blockSize];
	if (!gained) nodeLoops<D>().gatherNumber(w, increment[0], sums);
	warm(w.first, w.count, gained ? gained : sums);
}

/// Enthalpy of points from the heat of their nodes, eq. (9.5).
template <int D> void HeatTransfer<D>::warm(int first, int count, const double* gained)
{
	const double        smoothed = smoothed_, from = reference;
	double* const       h      = enthalpy + first;
	const double* const weight = capacityWeight + first;
	const double* const t      = temperature + first;
#pragma GCC ivdep
	for (int k = 0; k < count; ++k)
		h[k] += weight[k] * (gained[k] - smoothed * (t[k] - from));
}

TALIK_IN_PLANE_AND_SPACE(HeatTransfer);

} // namespace talik
