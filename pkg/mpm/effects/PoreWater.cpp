// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/grid/NodeLoops.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talik {

namespace {
	/// Part of its liquid that a cell gives away in a step at most.
	constexpr double largestLoss = 0.5;
	/// Share of its water that a cell may lose in a step before what stays is slowed down, at least.
	constexpr double leastDryingLoss = 1e-3;
	/// Water of a cell per volume of the cell below which it is a trace [kg/m^D].
	constexpr double traceDensity = 1e-9;
	/// The same, below which it sticks to the grains: permeability has fallen by more than ten orders [kg/m^D].
	constexpr double stuckDensity = 0.1;
} // namespace

template <int D>
PoreWater<D>::PoreWater(PointFields& fields, const WaterSettings& water)
        : settings(&water)
{
	fields.declare("liquidVelocity", "water", "m/s", velocity);
	fields.declare("pressure", "water", "Pa", pressure);
	fields.declare("liquidFraction", "water", "-", liquidFraction);
	fields.declare("drag", "water", "kg/s", drag);
}

template <int D>
void PoreWater<D>::bind(MaterialPoints<D>& points, const Grid<D>& grid, const double* iceMass, const double* temperature, const double* waterMass)
{
	volume_ = points.volume();
	for (int a = 0; a < D; ++a)
		position_[a] = points.position(a);
	radius_             = grid.isTurned() ? position_[0] : nullptr;
	waterMass_          = waterMass;
	iceMass_            = iceMass;
	temperature_        = temperature;
	const auto allocate = [&](auto&... fields) { (fields.allocate(grid.nodeCount()), ...); };
	allocate(nodes, nodal, force, solved, flux, start, exchange);
	open_.assign(grid.nodeCount(), 0);
	exchange.shareColumns(solved, Gathered::velocity);
	none_.assign(blockSize, 0.0);
	once_.assign(blockSize, 1.0);
	perHalfCell_ = 2.0 * grid.faceArea() * grid.inverseSpacing();
	if (iceMass_) fills_.reset(points.capacity());
}

template <int D> void PoreWater<D>::allocateCells(int cells, double cellVolume)
{
	traceMass_ = traceDensity * cellVolume;
	stuckMass_ = stuckDensity * cellVolume;
	cells_.reset(cells);
	if (!iceMass_) return;
	freezing_.reset(cells);
	for (auto& faces : faces_)
		faces.reset(cells);
}

template <int D> void PoreWater<D>::keepOnly(const ActiveRange& r, int firstPoint, int endPoint)
{
	const auto keep = [&](auto&... fields) { (fields.keepOnly(r.firstNode, r.lastNode), ...); };
	keep(nodes, nodal, force, flux, start, exchange);
	cells_.keepOnly(r.firstCell, r.lastCell);
	freezing_.keepOnly(r.firstCell, r.lastCell);
	for (auto& faces : faces_)
		faces.keepOnly(r.firstCell, r.lastCell);
	fills_.keepOnly(firstPoint, endPoint);
}

template <int D> void PoreWater<D>::setWeight(const Grid<D>& grid, int axis, double ofVolume)
{
	weight[axis]  = ofVolume;
	along_[axis]  = grid.isPeriodic(axis) ? ofVolume : 0.0;
	lifted_[axis] = ofVolume - along_[axis];
}

template <int D> void PoreWater<D>::clearCells(int first, int last)
{
	if (!cells_.empty()) std::fill(cells_.begin() + first, cells_.begin() + last, Cell {});
	if (!freezing_.empty()) std::fill(freezing_.begin() + first, freezing_.begin() + last, FreezingCell {});
}

template <int D> void PoreWater<D>::addPressure(const CellMeans<D>& cells, int first, int last)
{
	for (int p = first; p < last; ++p) {
		Cell&        cell = cells_[cells.cell(p)];
		const double m    = liquidMass(p);
		cell.liquidMass += m;
		cell.pressure += m * pressure[p];
		cell.height += m * potential(p);
		if (!iceMass_) continue;
		FreezingCell& more = freezing_[cells.cell(p)];
		more.drag += drag[p];
		more.contentMass += waterMass_[p];
		more.warmth += m * temperature_[p];
		more.carried += m * ofPoint<D>(velocity, p);
	}
}

template <int D> void PoreWater<D>::finishPressure(const ActiveRange& range)
{
	range.eachCell([&](int c) {
		Cell& cell = cells_[c];
		if (!(cell.liquidMass > 0.0)) return;
		cell.pressure /= cell.liquidMass;
		cell.driving = cell.pressure;
		cell.height /= cell.liquidMass;
	});
}

/// V n_l^2/Q
template <int D> double PoreWater<D>::mobility(int cell, double volume) const
{
	const double held = cells_[cell].liquidMass / liquid.density, resistance = freezing_[cell].drag;
	return resistance > 0.0 ? held * held / (volume * resistance) : 0.0;
}

/// u of eq. (7.6): what the liquid of a cell feels that thaws from one side.
template <int D> double PoreWater<D>::thawedPressure(const Grid<D>& grid, const ActiveRange& range, int cell) const
{
	const auto   liquidPart = [&](int c) { return cells_[c].liquidMass / freezing_[c].contentMass; };
	const double thawed = liquidPart(cell), mean = cells_[cell].pressure;
	const double conducts = tight * freezing_[cell].mobility;
	double       frozen = thawed, frozenPressure = mean, lowest = mean;
	for (int a = 0; a < D; ++a)
		for (const int side : { -1, 1 }) {
			const int next = grid.neighbour(cell, a, side);
			if (next < range.firstCell || next >= range.lastCell || !(cells_[next].liquidMass > 0.0)) continue;
			const double pressure = cells_[next].pressure - side * weight[a] * grid.spacing(), part = liquidPart(next);
			lowest = std::min(lowest, pressure);
			if (part >= frozen || freezing_[next].mobility > conducts) continue;
			frozen         = part;
			frozenPressure = pressure;
		}
	// less than the mean: only what flows out is held back, so that nothing is driven that the mean would not drive
	if (frozenPressure <= mean) return mean;
	const double phi = (thawed - frozen) / (1.0 - frozen);
	return std::max(lowest, (mean - (1.0 - phi) * frozenPressure) / phi);
}

template <int D> void PoreWater<D>::findDrivingPressure(const Grid<D>& grid, const ActiveRange& range, const CellMeans<D>& cells)
{
	if (!iceMass_) return;
	range.eachCell([&](int c) { freezing_[c].mobility = mobility(c, cells.cellVolume(c)); });
	range.eachCell([&](int c) {
		if (cells_[c].liquidMass > 0.0) cells_[c].driving = thawedPressure(grid, range, c);
	});
}

template <int D>
void PoreWater<D>::fillRecords(
        const WeightBlock<D>& w, const double (&driving)[blockSize], const double (&potential)[blockSize], double (&values)[Liquid::size][blockSize]) const
{
	const double* const ice    = iceMass_ ? iceMass_ + w.first : none_.data();
	const double* const water  = waterMass_ + w.first;
	const double* const volume = volume_ + w.first;
	const double* const part   = liquidFraction + w.first;
	const double* const drags  = drag + w.first;
	const int           count  = w.count;
#pragma GCC ivdep
	for (int k = 0; k < count; ++k) {
		const double m            = water[k] - ice[k];
		values[massAt][k]         = m;
		values[volumeAt][k]       = volume[k];
		values[liquidVolumeAt][k] = volume[k] * part[k];
		values[pressureAt][k]     = m * driving[k];
		values[dragAt][k]         = drags[k];
		values[potentialAt][k]    = m * potential[k];
	}
	for (int i = 0; i < D; ++i) {
		const double* const v = velocity[i] + w.first;
#pragma GCC ivdep
		for (int k = 0; k < count; ++k)
			values[momentumAt + i][k] = values[massAt][k] * v[k];
	}
}

/// v = chi v + change
template <int D> void PoreWater<D>::accelerate(int axis, int first, int count, const double* change)
{
	const double  chi = kept;
	double* const v   = velocity[axis] + first;
#pragma GCC ivdep
	for (int k = 0; k < count; ++k)
		v[k] = chi * v[k] + change[k];
}

template <int D> void PoreWater<D>::map(const WeightBlock<D>& w, const CellMeans<D>* cells, const double* capacity, double carriedFrom)
{
	double driving[blockSize], height[blockSize];
	for (int k = 0; k < w.count; ++k) {
		// what seeps is handed out evenly within a cell, and rises or sinks by the middle of the cell's liquid
		const int   p    = w.first + k;
		const Cell* cell = cells ? &cells_[cells->cell(p)] : nullptr;
		driving[k]       = cell ? cell->driving : pressure[p];
		height[k]        = cell ? cell->height : potential(p);
	}
	double values[Liquid::size][blockSize];
	for (int i = Liquid::numbers; i < Liquid::size; ++i)
		std::fill_n(values[i], w.count, 0.0);
	fillRecords(w, driving, height, values);
	if constexpr (Liquid::carriesHeat)
		for (int k = 0; k < w.count; ++k) {
			values[Liquid::capacity][k] = capacity ? capacity[w.first + k] : 0.0;
			values[Liquid::heat][k]     = capacity ? capacity[w.first + k] * (temperature_[w.first + k] - carriedFrom) : 0.0;
		}
	nodeLoops<D>().mapLiquid(w, values, nodes[0]);
}

template <int D> void PoreWater<D>::nodalPressure(const ActiveRange& range)
{
	range.eachNode([&](int i) {
		const double* r = nodes[i];
		double*       n = nodal[i];

		n[Driving::perLiquidMass]  = r[massAt] > 0.0 ? 1.0 / r[massAt] : 0.0;
		n[Driving::pressure]       = r[massAt] > 0.0 ? r[pressureAt] / r[massAt] : 0.0;
		n[Driving::liquidFraction] = r[volumeAt] > 0.0 ? r[liquidVolumeAt] / r[volumeAt] : 0.0;
		std::fill_n(force[i], D, 0.0);
		std::fill_n(exchange[i], exchangeSize, 0.0);
	});
}

template <int D> void PoreWater<D>::open(const SurfacePatch<D>& patch)
{
	for (const SurfaceNode<D>& n : patch.nodes)
		open_[n.node] = 1;
}

template <int D>
void PoreWater<D>::addPotential(const Grid<D>& grid, const ActiveRange& range, const SolidMotion<D>& motion, const std::vector<unsigned char>& heldAxes)
{
	const Vec<D> gravity = motion.settings->gravity;
	const double square = dot<D>(gravity, gravity), falling = 1.0 - motion.settings->localDamping;
	if (square == 0.0) return;
	range.eachNode([&](int i) {
		double*    r    = nodes[i];
		const bool open = open_[i];
		open_[i]        = 0;
		if (!(r[massAt] > 0.0)) return;
		const double*            solid  = motion.nodes[i];
		const double             mass   = solid[motion.massAt] + r[massAt];
		const std::array<int, D> node   = grid.nodeOf(i);
		double                   atNode = 0.0, held = 0.0;
		for (int a = 0; a < D; ++a) {
			atNode -= lifted_[a] * grid.nodePosition(a, node[a]);
			held += heldAxes[i] >> a & 1 ? mass * gravity[a] * gravity[a] : -solid[motion.forceAt + a] * gravity[a];
		}
		atNode *= r[massAt];
		const double carried = open ? 0.0 : 1.0 - falling * (1.0 - std::clamp(held / (mass * square), 0.0, 1.0));
		r[potentialAt]       = atNode + carried * (r[potentialAt] - atNode);
		nodal[i][Driving::pressure] += r[potentialAt] * nodal[i][Driving::perLiquidMass];
	});
}

template <int D> void PoreWater<D>::pressureForce(const WeightBlock<D>& w) { nodeLoops<D>().flowPressure(w, volume_, nodal[0], force[0]); }

template <int D> void PoreWater<D>::liquidForce(const ActiveRange& range)
{
	range.eachNode([&](int i) {
		for (int a = 0; a < D; ++a)
			force[i][a] = (force[i][a] - along_[a] * nodes[i][volumeAt]) * -nodal[i][Driving::liquidFraction];
	});
}

template <int D> void PoreWater<D>::drainedForce(const SurfacePatch<D>& patch, double outside)
{
	for (const SurfaceNode<D>& n : patch.nodes)
		addTo<D>(force[n.node], nodal[n.node][Driving::liquidFraction] * (pressureAtNode(n.node) - outside) * n.area);
}

template <int D> void PoreWater<D>::seep(const WeightBlock<D>& w, double dt)
{
	typename NodeLoops<D>::Seepage s { flux[0], volume_, {}, nullptr, dt * liquid.density, 0.0, 0.0, exchange[0] };
	std::copy(velocity.begin(), velocity.end(), s.velocity.begin());
	if (liquid.enthalpy) {
		s.temperature    = temperature_;
		s.specificHeat   = liquid.enthalpy->properties().liquid.specificHeat;
		s.enthalpyAtZero = liquid.enthalpy->liquidEnthalpy(0.0);
	}
	nodeLoops<D>().seep(w, s);
}

template <int D> void PoreWater<D>::drain(const StepContext<D>& step, const SurfacePatch<D>& patch, bool recharges, const NodeField<1>* temperature)
{
	for (const SurfaceNode<D>& n : patch.nodes) {
		if (nodal[n.node][Driving::perLiquidMass] == 0.0) continue;
		const double m = dot<D>(vectorAt<D>(flux[n.node]), n.area) * (step.dt * liquid.density);
		if (m < 0.0 && !recharges) continue;
		const double heat = liquid.enthalpy ? m * liquid.enthalpy->liquidEnthalpy((*temperature)[n.node][0]) : 0.0;
		leave(n.node, m, heat, step.ledger);
	}
}

template <int D>
void PoreWater<D>::feed(const StepContext<D>& step, const SurfacePatch<D>& patch, double inflow, double inflowTemperature, const NodeField<1>* temperature)
{
	const double scaled = inflow * scales.smallest * step.dt * liquid.density;
	for (const SurfaceNode<D>& n : patch.nodes) {
		if (nodal[n.node][Driving::perLiquidMass] == 0.0) continue;
		const double m    = scaled * lengthOf<D>(n.area);
		const bool   own  = m > 0.0 && !std::isnan(inflowTemperature);
		const double heat = liquid.enthalpy ? m * liquid.enthalpy->liquidEnthalpy(own ? inflowTemperature : (*temperature)[n.node][0]) : 0.0;
		leave(n.node, -m, -heat, step.ledger);
	}
}

template <int D> void PoreWater<D>::chooseLargestConductivity(double smallestReferencePorosity)
{
	const double given  = settings->largestConductivity;
	largestConductivity = std::isnan(given) ? longestRest * smallestReferencePorosity * Permeability::gravity : given;
}

template <int D> void PoreWater<D>::leave(int node, double mass, double heat, StepLedger<D>& ledger)
{
	double*         r       = exchange[node];
	StepAccount<D>& account = ledger.ofNode(node);
	r[Gathered::water] -= mass;
	r[Gathered::enthalpy] -= heat;
	account.waterOut += mass;
	account.enthalpyOut += heat;
	account.waterEnergyOut += mass / liquid.density * nodes[node][potentialAt] * nodal[node][Driving::perLiquidMass];
	const Vec<D> momentum = mass * vectorAt<D>(start[node]);
	addTo<D>(r + Gathered::momentum, -1.0 * momentum);
	account.momentumOut += momentum;
}

template <int D> void PoreWater<D>::finishExchange(const ActiveRange& range)
{
	range.eachNode([&](int i) {
		for (int a = 0; a < exchangeSize; ++a)
			exchange[i][a] *= nodal[i][Driving::perLiquidMass];
	});
}

/// What seeps to a point, eq. (2.3), with its momentum and enthalpy.
template <int D> void PoreWater<D>::take(int p, const double* share, double dilution, double* waterMass, double* enthalpy)
{
	// momentum comes with the water
	for (int i = 0; i < D; ++i)
		velocity[i][p] = (velocity[i][p] + share[Gathered::momentum + i]) * dilution;
	const double liquid = liquidMass(p);
	waterMass[p] += liquid * share[Gathered::water];
	if (enthalpy) enthalpy[p] += liquid * share[Gathered::enthalpy];
}

template <int D>
void PoreWater<D>::gather(const WeightBlock<D>& w, double* waterMass, double* enthalpy, const CellMeans<D>* cells, [[maybe_unused]] double* increment)
{
	double got[Gathered::size][blockSize];
	nodeLoops<D>().gatherExchange(w, exchange[0], got);
	if constexpr (Gathered::carriesIncrement)
		if (increment) std::copy_n(got[Gathered::increment], w.count, increment);
	for (int i = 0; i < D; ++i)
		accelerate(i, w.first, w.count, got[Gathered::velocity + i]);
	for (int k = 0; k < w.count; ++k) {
		const int p = w.first + k;
		double    share[exchangeSize];
		for (int i = 0; i < exchangeSize; ++i)
			share[i] = got[i][k];
		if (!cells) {
			take(p, share, 1.0 / (1.0 + share[Gathered::water]), waterMass, enthalpy);
			continue;
		}
		double* const received = cells_[cells->cell(p)].exchange;
		const double  liquid   = liquidMass(p);
		for (int i = 0; i < exchangeSize; ++i)
			received[i] += liquid * share[i];
	}
}

template <int D> double PoreWater<D>::reachedMobility(int cell, double volume, double dt) const
{
	const double steady = freezing_[cell].mobility;
	return steady > 0.0 ? 1.0 / (1.0 / steady + liquid.density * liquid.density * volume / (cells_[cell].liquidMass * dt)) : 0.0;
}

template <int D> void PoreWater<D>::findFaces(const Grid<D>& grid, const ActiveRange& range, const CellMeans<D>& cells, double dt)
{
	const double perSpacing = grid.faceArea() * grid.inverseSpacing();
	range.eachCell([&](int c) { freezing_[c].reached = reachedMobility(c, cells.cellVolume(c), dt); });
	for (int a = 0; a < D; ++a)
		range.eachCell([&](int c) {
			Face& face     = faces_[a][c];
			face           = {};
			const int next = grid.neighbour(c, a, 1);
			if (next < 0 || next >= range.lastCell) return;
			const double here = freezing_[c].reached, there = freezing_[next].reached;
			if (!(here > 0.0 && there > 0.0)) return;
			face.conductance = perSpacing * 2.0 * here * there / (here + there) * grid.measureOfFace(c, a);
			face.flow        = face.conductance * (cells_[c].driving - cells_[next].driving + weight[a] * grid.spacing());
		});
}

template <int D> double PoreWater<D>::checkerboardFlux(const Face* faces, int face, int before, int after) const
{
	const Face& f = faces[face];
	if (!(f.conductance > 0.0)) return 0.0;
	// beyond ice, a wall or the surface the flow goes on as it is
	const auto beside = [&](int at) { return at < 0 || faces[at].conductance < tight * f.conductance ? f.flow : faces[at].flow; };
	return 0.5 * f.flow - 0.25 * (beside(before) + beside(after));
}

template <int D> void PoreWater<D>::stabiliseCells(const StepContext<D>& step, const CellMeans<D>& cells)
{
	const Grid<D>&     grid  = step.grid;
	const ActiveRange& range = step.halo;
	const double       dt    = step.dt;
	findFaces(grid, range, cells, dt);
	const double sides      = 2.0 * (grid.isSlice() ? 2 : D);
	const auto   inRange    = [&](int c) { return c >= range.firstCell && c < range.lastCell; };
	const auto   compliance = [&](int c) { return cells_[c].liquidMass / (liquid.density * settings->state.liquidBulkModulus); };
	range.eachCell([&](int c) {
		Cell& cell = cells_[c];
		if (!(cell.liquidMass > 0.0)) return;
		for (int a = 0; a < D; ++a)
			for (const bool ahead : { false, true }) {
				const int from = ahead ? c : grid.neighbour(c, a, -1), to = ahead ? grid.neighbour(c, a, 1) : c;
				if (!inRange(from) || !inRange(to)) continue;
				const int    before = grid.neighbour(from, a, -1), beyond = grid.neighbour(to, a, 1);
				const double checkerboard = checkerboardFlux(faces_[a].data(), from, inRange(before) ? before : -1, inRange(beyond) ? to : -1);
				if (checkerboard == 0.0) continue;
				const double least  = std::min(compliance(from), compliance(to));
				const double mass   = liquid.density * dt * checkerboard / (1.0 + 2.0 * sides * dt * faces_[a][from].conductance / least);
				const int    donor  = mass > 0.0 ? from : to;
				const double gained = ahead ? -mass : mass, share = gained / cells_[donor].liquidMass;
				cell.exchange[Gathered::water] += gained;
				if (liquid.enthalpy) cell.exchange[Gathered::enthalpy] += gained * enthalpyOfCell(donor, *liquid.enthalpy);
				addTo<D>(cell.exchange + Gathered::momentum, share * freezing_[donor].carried);
			}
	});
}

template <int D> void PoreWater<D>::give(int cell, double mass, const EnthalpyModel& enthalpy)
{
	double* const exchange = cells_[cell].exchange;
	exchange[Gathered::water] -= mass;
	exchange[Gathered::enthalpy] -= mass * enthalpyOfCell(cell, enthalpy);
	addTo<D>(exchange + Gathered::momentum, -mass * velocityOfCell(cell));
}

template <int D> void PoreWater<D>::mixIn(int p, double mass, const Vec<D>& momentum)
{
	const double before = liquidMass(p);
	for (int i = 0; i < D; ++i)
		velocity[i][p] = (before * velocity[i][p] + momentum[i]) / (before + mass);
}

/// A cell that has all but run dry cannot give what its wet neighbours' nodes ask of it, and a trace of water gives nothing: it would
/// shrink to nothing that can be divided by. What a cell keeps counts as having come in.
template <int D> void PoreWater<D>::limitOutflow(const ActiveRange& range, StepLedger<D>& ledger)
{
	for (int c = range.firstCell; c < range.lastCell; ++c) {
		Cell&        cell = cells_[c];
		const double loss = -cell.exchange[Gathered::water], most = cell.liquidMass > traceMass_ ? largestLoss : 0.0;
		if (!(cell.liquidMass > 0.0) || !(loss > most)) continue;
		const double    given   = most / loss;
		StepAccount<D>& account = ledger.ofCell(c);
		const double    held    = cell.liquidMass * (1.0 - given);
		account.waterOut += held * cell.exchange[Gathered::water];
		account.enthalpyOut += held * cell.exchange[Gathered::enthalpy];
		account.waterEnergyOut += held * cell.exchange[Gathered::water] * cell.height / liquid.density;
		account.momentumOut += held * vectorAt<D>(cell.exchange + Gathered::momentum);
		for (double& share : cell.exchange)
			share *= given;
		cell.dilution = 1.0 / (1.0 + cell.exchange[Gathered::water]);
	}
}

template <int D> void PoreWater<D>::finishCells(const StepContext<D>& step)
{
	step.owned.eachCell([&](int c) {
		Cell& cell = cells_[c];
		if (!(cell.liquidMass > 0.0)) return;
		const double perMass = 1.0 / cell.liquidMass;
		for (int i = 0; i < exchangeSize; ++i)
			cell.exchange[i] *= perMass;
		cell.dilution = 1.0 / (1.0 + cell.exchange[Gathered::water]);
	});
	limitOutflow(step.owned, step.ledger);
}

template <int D> Vec<D> PoreWater<D>::remainingVelocity(int p, const Cell& cell, double most, const std::array<double*, D>& solidVelocity) const
{
	if (isStuck(cell, p)) return ofPoint<D>(solidVelocity, p);
	const double part = -most / cell.exchange[Gathered::water];
	return (ofPoint<D>(velocity, p) + part * vectorAt<D>(cell.exchange + Gathered::momentum)) / (1.0 - most);
}

template <int D>
Vec<D> PoreWater<D>::receive(const CellMeans<D>& cells, int first, int last, double* waterMass, double* enthalpy, const std::array<double*, D>& solidVelocity)
{
	const double most = std::max(0.5 * (1.0 - kept), leastDryingLoss);
	Vec<D>       lost {};
	for (int p = first; p < last; ++p) {
		const Cell&  cell      = cells_[cells.cell(p)];
		const bool   runsDry   = isStuck(cell, p) || cell.exchange[Gathered::water] < -most;
		const Vec<D> remaining = runsDry ? remainingVelocity(p, cell, most, solidVelocity) : Vec<D>();
		take(p, cell.exchange, cell.dilution, waterMass, enthalpy);
		if (!runsDry) continue;
		for (int i = 0; i < D; ++i) {
			lost[i] += liquidMass(p) * (velocity[i][p] - remaining[i]);
			velocity[i][p] = remaining[i];
		}
	}
	return lost;
}

/// Pressure of a cell, eq. (7.5).
template <int D> void PoreWater<D>::findCellPressure(const ActiveRange& range)
{
	range.eachCell([&](int c) {
		Cell& cell = cells_[c];
		if (cell.compliance > 0.0) cell.fillPressure = std::max(cell.excess / cell.compliance, settings->state.cavitationPressure);
		if (freezing_.empty() || !(freezing_[c].compliance > 0.0)) return;
		FreezingCell& more         = freezing_[c];
		const double  perMass      = cell.liquidMass > 0.0 ? 1.0 / cell.liquidMass : 0.0;
		const double  atCavitation = more.excess - more.compliance * settings->state.cavitationPressure;
		more.level                 = atCavitation >= 0.0 ? more.excess / more.compliance : settings->state.cavitationPressure;
		more.filled                = atCavitation >= 0.0 ? 1.0 : more.surplus / (more.surplus - atCavitation);
		more.handed                = liquid.enthalpy ? liquid.enthalpy->liquidEnthalpy(more.warmth * perMass) : 0.0;
		more.velocity              = perMass * more.carried;
	});
}

template <int D>
void PoreWater<D>::findShares(int first, int count, const double* excess, const double* compliance, double dt, double* share, double* surplus) const
{
	const double* const water  = waterMass_ + first;
	const double* const ice    = iceMass_ + first;
	const double* const volume = volume_ + first;
	const double* const drags  = drag + first;
	const double* const radius = radius_ ? radius_ + first : once_.data();
	const double        flow = dt * perHalfCell_, square = liquid.density * liquid.density, perStep = 1.0 / dt, lowest = settings->state.cavitationPressure;
	const double        most    = largestLoss / liquid.density;
	constexpr double    nothing = std::numeric_limits<double>::min();
#pragma GCC ivdep
	for (int k = 0; k < count; ++k) {
		const double mass = water[k] - ice[k], moves = flow * radius[k] * mass * mass;
		// the drag, and the inertia of what has to be moved within the step
		const double resists = compliance[k] * square * volume[k] * (drags[k] + mass * perStep);
		const double over    = excess[k] - compliance[k] * lowest;
		surplus[k]           = over > 0.0 ? over : 0.0;
		const double part = moves / (moves + resists), largest = most * mass / (surplus[k] + nothing);
		share[k] = part < largest ? part : largest;
	}
}

template <int D> void PoreWater<D>::addFills(const CellMeans<D>& cells, int first, int count, const double* excess, const double* compliance, double dt)
{
	double share[blockSize], surplus[blockSize];
	if (!freezing_.empty()) findShares(first, count, excess, compliance, dt, share, surplus);
	for (int k = 0; k < count; ++k) {
		const int c = cells.cell(first + k);
		cells_[c].excess += excess[k];
		cells_[c].compliance += compliance[k];
		if (freezing_.empty()) continue;
		FreezingCell& cell = freezing_[c];
		cell.excess += share[k] * excess[k];
		cell.compliance += share[k] * compliance[k];
		cell.surplus += share[k] * surplus[k];
		fills_[first + k] = { excess[k], compliance[k], share[k] };
	}
}

template <int D> double PoreWater<D>::given(const PointFill& point, const FreezingCell& cell) const
{
	const double difference = point.share * (point.excess - point.compliance * cell.level);
	return difference < 0.0 ? difference * cell.filled : difference;
}

template <int D> void PoreWater<D>::stabilisePoints(const CellMeans<D>& cells, int first, int last, double* waterMass, double* enthalpy)
{
	const double perDensity = 1.0 / liquid.density;
	for (int p = first; p < last; ++p) {
		const FreezingCell& cell = freezing_[cells.cell(p)];
		const double        mass = liquid.density * given(fills_[p], cell);
		if (mass == 0.0) continue;
		const double part = mass / (liquidMass(p) - mass);
		for (int i = 0; i < D; ++i)
			velocity[i][p] += part * (velocity[i][p] - cell.velocity[i]);
		waterMass[p] -= mass;
		liquidFraction[p] -= mass * perDensity / volume_[p];
		if (enthalpy) enthalpy[p] -= mass * cell.handed;
	}
}

template <int D> void PoreWater<D>::shareCellPressure(const CellMeans<D>& cells, int first, int last)
{
	for (int p = first; p < last; ++p)
		pressure[p] = cells_[cells.cell(p)].fillPressure;
}

template <int D> void PoreWater<D>::bookSeepageWork(const ActiveRange& range, double share, StepLedger<D>& ledger) const
{
	for (int c = range.firstCell; c < range.lastCell; ++c)
		if (cells_[c].liquidMass > 0.0) {
			const double work = share / liquid.density * cells_[c].fillPressure * (cells_[c].liquidMass * cells_[c].exchange[Gathered::water]);
			ledger.ofCell(c).porePressureWork += work;
			ledger.ofCell(c).workAhead += work;
		}
}

TALIK_IN_PLANE_AND_SPACE(PoreWater);

} // namespace talik
