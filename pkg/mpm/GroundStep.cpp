// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/mpm/GroundParts.hpp>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace talik {

namespace {
	// Sorting now and then keeps neighbours together also where points only slide along their strip.
	constexpr long stepsBetweenSorts = 200;
} // namespace

// ---- the step -------------------------------------------------------------------------------------------------------

template <int D> void Ground<D>::beginStep(double dt)
{
	Parts& g = *parts_;
	if (!g.ready) throw std::logic_error("step: the ground is not initialised");
	requireSetting(std::isfinite(dt) && dt > 0.0, "dt", dt, "must be a positive time in s; stableTimeStep() proposes one");
	if (g.clock.halfDone)
		throw std::runtime_error(
		        "the last step of the ground ended half way, its points do not fit together: go on from a checkpoint, or from the start");
	g.cost.start();
	g.cost.time(CostMeter::sorting, [&] { g.openStep(dt); });
	if (g.heat) g.cost.time(CostMeter::heat, [&] { g.setReferenceOfHeat(); });
}

template <int D> void Ground<D>::p2g()
{
	Parts&               g    = *parts_;
	const StepContext<D> step = g.context();
	g.cost.time(g.base(), [&] { g.clearNodes(); });
	if (g.front) g.cost.time(CostMeter::front, [&] { g.findFront(step); });
	if (g.cells) g.cost.time(CostMeter::cells, [&] { g.locateInCells(); });
	if (g.surface) g.surface->findNeeded(g.grid, *g.cells);
	if (g.mappedBack) g.cost.time(CostMeter::cells, [&] { g.mappedBack->find(g.grid, *g.cells, g.points->strips()); });
	g.mapToGrid(step);
	if (g.implicit) g.cost.time(CostMeter::water, [&] { g.implicit->findLinks(step, *g.cells, *g.shape, *g.water); });
	if (g.surface) g.cost.time(CostMeter::surface, [&] { g.collectSurfaces(step); });
}

template <int D> void Ground<D>::solveNodes()
{
	Parts&               g    = *parts_;
	const StepContext<D> step = g.context();
	if (g.heat || g.water) g.findFlows(step);
	if (!g.stateDependent.empty()) g.cost.time(CostMeter::boundaries, [&] { g.evaluateBoundaries(step); });
	if (g.heat) g.cost.time(CostMeter::boundaries, [&] { g.exchangeHeat(step); });
	if (g.heat) g.cost.time(CostMeter::heat, [&] { g.finishTemperature(step); });
	if (g.motion) g.solveMomentum(step);
	if (g.water) g.cost.time(CostMeter::water, [&] { g.seep(step); });
}

template <int D> void Ground<D>::g2p()
{
	Parts&               g    = *parts_;
	const StepContext<D> step = g.context();
	g.clock.halfDone          = 1;
	g.gatherFromGrid(step);
	if (g.motion) g.cost.time(CostMeter::motion, [&] { g.checkPositions(step); });
}

template <int D> void Ground<D>::updateStrainAndPressure()
{
	Parts&               g    = *parts_;
	const StepContext<D> step = g.context();
	if (g.booksEnergy()) g.cost.time(CostMeter::ledger, [&] { g.strainWork.bookStart(step, *g.points, *g.motion, g.water.get(), g.averagingCells()); });
	if (g.segregation) g.cost.time(CostMeter::segregation, [&] { g.segregate(step); });
	if (g.exchangingCells()) g.cost.time(CostMeter::water, [&] { g.stabiliseCells(step); });
	g.updatePoints(step);
	if (g.cellPressure()) g.cost.time(CostMeter::water, [&] { g.findCellPressure(step); });
	if (g.content) g.refuseImpossibleStates(step);
}

template <int D> void Ground<D>::updateEffectiveStress()
{
	Parts&               g    = *parts_;
	const StepContext<D> step = g.context();
	std::exception_ptr   stop;
	if (g.thawStrain) g.findStrainOfSoil(step);
	if (g.motion) stop = g.updateSkeletons(step);
	if (g.thawStrain) g.restoreStrainOfGround();
	if (g.booksEnergy()) g.cost.time(CostMeter::ledger, [&] { g.strainWork.bookEnd(step, *g.points, *g.motion, g.water.get()); });
	g.bookStep();
	g.advanceClock();
	if (g.calendar) g.cost.time(CostMeter::calendar, [&] { g.measureMotion(step); });
	g.clock.halfDone = 0;
	if (stop) std::rethrow_exception(stop);
}

// ---- beginStep: length and scale of the step, sorting ---------------------------------------------------------------

template <int D> void Ground<D>::Parts::openStep(double dt)
{
	if (ranks) ranks.meet(clock.steps);
	clock.dt = dt;
	if (clock.sortWanted || clock.steps - clock.lastSort >= stepsBetweenSorts) sort();
	clockBefore = clock;
	ledger.clear();
	useScale();
	if (momentum) moveWalls();
	findKeptFractions();
}

/// What slow processes run at in this step.
template <int D> void Ground<D>::Parts::useScale()
{
	CalendarState& state = clock.calendar;
	if (calendar) state.scale = calendar->scale(state, clock.dt);
	else if (heat) state.scale = settings.heat->thermalTimeScale;
	if (water) water->scales = content->useScale(state.scale, *water);
}

template <int D> void Ground<D>::Parts::moveWalls()
{
	try {
		momentum->beginStep(grid, *shape, clock.calendar.time, calendarEnd(), clock.dt);
	} catch (...) {
		clock = clockBefore;
		throw;
	}
}

template <int D> void Ground<D>::Parts::findKeptFractions()
{
	if (!motion) return;
	const double h = grid.spacing();
	motion->kept   = keptFraction(settings.motion->usedPicTime(h), clock.dt);
	if (!water) return;
	for (int a = 0; a < D; ++a)
		water->setWeight(grid, a, water->liquid.density * settings.motion->gravity[a]);
	const double given = settings.water->picTime, used = std::isnan(given) ? gravityTime(h, lengthOf<D>(settings.motion->gravity)) : given;
	water->kept = keptFraction(water->scales.largest > 1.0 ? std::min(used, water->longestRest) : used, clock.dt);
}

/// Nodes count temperatures from that of one point, so that ground of one temperature conducts exactly nothing.
template <int D> void Ground<D>::Parts::setReferenceOfHeat()
{
	struct Own {
		double reference;
		int    holdsReference;
	};
	const int  place = points->place(0);
	const bool holds = place >= points->strips().firstPoint() && place < points->strips().endPoint();
	const Own  own { holds ? heat->temperature[place] : 0.0, holds };
	heat->reference = own.reference;
	if (!ranks) return;
	for (const Own& rank : ranks.slabs()->byRank(own))
		if (rank.holdsReference) heat->reference = rank.reference;
}

// ---- p2g: points to nodes and cells ---------------------------------------------------------------------------------

template <int D> void Ground<D>::Parts::findFront(const StepContext<D>& step)
{
	front->find(step, content->iceSaturation, momentum->mirrors(), momentum->freeLiquid());
	findFrontStrength();
}

/// Of the thawed points that may slip, from their skeletons.
template <int D> void Ground<D>::Parts::findFrontStrength()
{
	if (!front->present()) return;
	for (int k = 0; k < skeletons.count(); ++k)
		for (const int p : front->thawedNear(skeletons.places(k)))
			front->setStrength(p, skeletons.law(k).shearStrength(content->iceSaturation[p]));
}

template <int D> void Ground<D>::Parts::mapToGrid(const StepContext<D>& step)
{
	using Block                          = const WeightBlock<D>&;
	const double* const weight           = heat ? heat->carriedWeight() : nullptr;
	const double* const weightWithMotion = NodeColumns<D>::Moving::carriesHeat ? weight : nullptr;
	passes.inBlocks(
	        passes.toGrid,
	        [&](HaloExchange& rows) {
		        rows.beyond = true;
		        if (motion) rows.nodes(motion->nodes);
		        if (front) front->shareMapped(grid, rows);
		        if (water) rows.nodes(water->nodes);
		        if (heat) heat->shareMapped(rows);
		        if (implicit && implicit->isFed()) implicit->shareLiquids(rows);
		        if (surface) rows.nodes(surface->nodes);
	        },
	        [](int, int, int) {},
	        PassPart { motion && motion->addedStress, CostMeter::motion,
	                   [&](Block w, double*) { bBar.findAddedStress(averagingCells(), *points, *motion, water.get(), w.first, w.first + w.count); } },
	        PassPart { !stressingEffects.empty(), CostMeter::motion, [&](Block w, double*, CostMeter::Sample& sample) { addStress(step, w, sample); } },
	        PassPart { bool(motion), CostMeter::motion,
	                   [&](Block w, double*) { motion->map(w, weightWithMotion, weight ? heat->temperature : nullptr, weight ? heat->reference : 0.0); } },
	        PassPart { settings.axisymmetric && motion, CostMeter::motion, [&](Block w, double*) { motion->mapHoop(meanOfFaces(w)); } },
	        PassPart { bool(affine), CostMeter::transfer, [&](Block w, double*) { affine->map(grid, w, *motion); } },
	        PassPart { bool(front), CostMeter::front, [&](Block w, double*) { front->map(step, w, pointsOfFront(), affine.get()); } },
	        PassPart { motion && weighs() && fillsCells, CostMeter::motion, [&](Block w, double*) { mapWeight(w); } },
	        PassPart { bool(water), CostMeter::water, [&](Block w, double*) { water->map(w, averagingCells(), weight, weight ? heat->reference : 0.0); } },
	        PassPart { bool(heat), CostMeter::heat, [&](Block w, double*) { heat->map(w); } },
	        PassPart { implicit && implicit->isFed(), CostMeter::water, [&](Block w, double*) { implicit->map(w, *cells, *content); } },
	        PassPart { bool(surface), CostMeter::surface, [&](Block w, double*) { mapSurface(w); } });
}

template <int D> void Ground<D>::Parts::mapWeight(const WeightBlock<D>& w)
{
	grid.measured([&](auto&& measure) {
		motion->mapWeight(
		        w, grid, [&](int p) { return water ? content->liquidMass(p) : 0.0; },
		        [&](int k, int node, const Vec<D>& force) {
			        if (front) front->pushNode(w.first + k, node, force);
		        },
		        measure);
	});
}

/// Effects in files of their own add to the stress of a block.
template <int D> void Ground<D>::Parts::addStress(const StepContext<D>& step, const WeightBlock<D>& w, CostMeter::Sample& sample)
{
	for (const int k : stressingEffects) {
		effects[k]->addStress(step, inMotion, w.first, w.first + w.count);
		sample.lap(CostMeter::ofEffect(k));
	}
}

template <int D> void Ground<D>::Parts::collectSurfaces(const StepContext<D>& step)
{
	if (bodies) bodies->cover(step, *shape, *surface);
	surface->collect(grid, *cells, step.halo);
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b) {
		const Region<D>& region = settings.boundaries[b]->region();
		if (region.kind == Region<D>::Kind::bodies) bodies->collectFaces(step, *shape, region.ids, surface->patch(b));
	}
}

// ---- solveNodes: heat and pore pressure -----------------------------------------------------------------------------

/// Heat that conduction brings to the nodes and force of the pore pressure on them, in one pass where both exist.
template <int D> void Ground<D>::Parts::findFlows(const StepContext<D>& step)
{
	if (heat) cost.time(CostMeter::heat, [&] { heat->nodalTemperature(step, settings.boundaries); });
	if (water) cost.time(CostMeter::water, [&] { findNodalPressure(step); });
	const auto pass = [&](CostMeter::Entry pays, auto&& work) {
		const auto share = [&](HaloExchange& rows) {
			rows.beyond = water && front; // sides meet there with the force on their liquid
			if (water) rows.nodes(water->force);
			if (heat) heat->shareConducted(rows);
		};
		cost.time(pays, [&] { passes.scatter(passes.flows, work, share); });
	};
	if (heat && water) {
		const typename NodeLoops<D>::HeatFlow flow = heat->flow(step);
		pass(CostMeter::flows, [&](const WeightBlock<D>& w) { nodeLoops<D>().flowHeatAndPressure(w, flow, water->nodal[0], water->force[0]); });
	} else if (heat) pass(CostMeter::heat, [&](const WeightBlock<D>& w) { heat->conduct(step, w); });
	else if (water && !implicit) pass(CostMeter::water, [&](const WeightBlock<D>& w) { water->pressureForce(w); });
}

template <int D> void Ground<D>::Parts::findNodalPressure(const StepContext<D>& step)
{
	water->nodalPressure(step.halo);
	const auto open = [&](const Boundary<D>&, SurfacePatch<D>& patch) { water->open(patch); };
	overSurfaces(&Boundary<D>::drains, open);
	overSurfaces(&Boundary<D>::feeds, open);
	water->addPotential(grid, step.halo, *motion, momentum->heldAxes());
}

/// Fluxes and forces of boundaries that follow the state of their nodes.
template <int D> void Ground<D>::Parts::evaluateBoundaries(const StepContext<D>& step)
{
	stateDependent.evaluate(step, { motion.get(), heat.get(), water.get() }, surface.get());
}

template <int D> void Ground<D>::Parts::exchangeHeat(const StepContext<D>& step)
{
	overSurfaces(&Boundary<D>::heats, [&](const Boundary<D>& boundary, SurfacePatch<D>& patch) { heat->exchange(step, boundary, patch, *surface); });
}

template <int D> void Ground<D>::Parts::finishTemperature(const StepContext<D>& step)
{
	heat->produce(step, settings.boundaries);
	heat->finishNodes(step, settings.boundaries);
	if (settings.heat->source == 0.0) return;
	const double* volume = points->volume();
	step.bookByStrip([&](StepAccount<D>& account, int first, int last) {
		double v = 0.0;
		for (int p = first; p < last; ++p)
			v += volume[p];
		account.heatIn += settings.heat->source * step.calendarScale * v * step.dt;
	});
}

// ---- solveNodes: momentum and seepage -------------------------------------------------------------------------------

template <int D> void Ground<D>::Parts::solveMomentum(const StepContext<D>& step)
{
	if (implicit) cost.time(CostMeter::water, [&] { ImplicitPressure<D>::tieLiquid(step, *water); });
	else if (water) cost.time(CostMeter::water, [&] { water->liquidForce(step.halo); });
	cost.time(CostMeter::motion, [&] { momentum->addGravity(step.halo, *motion, water.get()); });
	cost.time(CostMeter::boundaries, [&] { pushByBoundaries(step); });
	if (bodies) cost.time(CostMeter::bodies, [&] { bodies->push(step, *shape, clock.steps == 0, motion->nodes, front.get(), clock.account.impulse); });
	cost.time(CostMeter::motion, [&] {
		momentum->solve(step, *motion, water.get(), front.get(), settings.energyLedger && !implicit, [&] {
			if (mappedBack) mapBack(step);
			cost.time(CostMeter::motion, [] {}); // so far
			if (implicit) cost.time(CostMeter::water, [&] { findImplicitPressure(step); });
		});
		const double mass = clock.initialMass - clock.account.waterOut;
		clock.account.impulse += step.dt * mass * motion->settings->gravity;
	});
}

/// Before the pressure at the end of the step, which sees the strain that points get.
template <int D> void Ground<D>::Parts::mapBack(const StepContext<D>& step)
{
	passes.scatter(
	        passes.back, [&](const WeightBlock<D>& w) { mappedBack->map(*cells, *motion, w); },
	        [&](HaloExchange& rows) {
		        rows.beyond = bool(implicit); // whose cells see nodes of the next slab
		        rows.nodes(mappedBack->missing);
	        });
	momentum->addMissing(step.halo, *motion, mappedBack->missing, [&](int node) { return mappedBack->isBeside(node) && !(front && front->parts(node)); });
}

template <int D> void Ground<D>::Parts::pushByBoundaries(const StepContext<D>& step)
{
	stateDependent.accelerate(*momentum, *motion);
	overSurfaces(&Boundary<D>::loads, [&](const Boundary<D>& boundary, SurfacePatch<D>& patch) {
		momentum->addLoad(boundary, patch, step.calendarEnd, *motion);
	});
	if (!implicit)
		overSurfaces(&Boundary<D>::drains, [&](const Boundary<D>& boundary, SurfacePatch<D>& patch) {
			water->drainedForce(patch, boundary.pressure(step.calendarEnd));
		});
}

template <int D> void Ground<D>::Parts::seep(const StepContext<D>& step)
{
	if (implicit) return water->finishExchange(step.owned);
	passes.scatter(
	        passes.seepage, [&](const WeightBlock<D>& w) { water->seep(w, step.dt); },
	        [&](HaloExchange& rows) { rows.nodes(water->exchange, PoreWater<D>::exchangeSize); });
	overSurfaces(&Boundary<D>::drains, [&](const Boundary<D>& boundary, SurfacePatch<D>& patch) {
		water->drain(step, patch, boundary.recharges(), heat ? &heat->mapped : nullptr);
	});
	feedWater(step);
	if (settings.energyLedger)
		step.owned.overNodes([&](int, int first, int last) {
			double work = 0.0;
			for (int i = first; i < last; ++i)
				if (ledger.counts(i)) work += water->pressureAtNode(i) * water->exchange[i][PoreWater<D>::Gathered::water];
			ledger.ofRows(first).porePressureWork += strainWork.pressureAtStart * work / water->liquid.density;
		});
	water->finishExchange(step.owned);
}

template <int D> void Ground<D>::Parts::feedWater(const StepContext<D>& step)
{
	overSurfaces(&Boundary<D>::feeds, [&](const Boundary<D>& boundary, SurfacePatch<D>& patch) {
		water->feed(step, patch, boundary.inflow(step.calendarEnd), boundary.inflowTemperature(), heat ? &heat->mapped : nullptr);
	});
}

/// In place of the flow of the nodes water flows between cells, by the pressure that they have at the end of the step.
template <int D> void Ground<D>::Parts::findImplicitPressure(const StepContext<D>& step)
{
	feedWater(step);
	implicit->beginFlow(step, *water);
	overSurfaces(&Boundary<D>::drains, [&](const Boundary<D>& boundary, SurfacePatch<D>& patch) {
		implicit->drain(step, patch, boundary.pressure(step.calendarEnd), boundary.recharges());
	});
	implicit->solve(step, *momentum, *motion, *water);
	if (settings.energyLedger) implicit->bookDissipation(step);
}

// ---- g2p: nodes to points -------------------------------------------------------------------------------------------

template <int D> void Ground<D>::Parts::gatherFromGrid(const StepContext<D>& step)
{
	using Block        = const WeightBlock<D>&;
	const bool average = averaging(), inRecordOfWater = heat && water && NodeColumns<D>::Gathered::carriesIncrement,
	           inRecordOfMotion = heat && motion && NodeColumns<D>::Solved::carriesIncrement;
	if (average) cells->clearSums(step.halo);
	passes.inBlocks(
	        passes.toPoints,
	        [&](HaloExchange& rows) {
		        if (!average) return;
		        cells->shareSums(rows);
		        if (water) water->shareCells(rows);
	        },
	        [&](int strip, int first, int last) {
		        if (!grid.images().empty()) points->wrap(grid, first, last);
		        if (motion) positions.bound(*points, strip, first, last);
	        },
	        PassPart { bool(water), CostMeter::water,
	                   [&](Block w, double* gained) {
		                   water->gather(w, content->waterMass, heat ? heat->enthalpy : nullptr, averagingCells(), inRecordOfWater ? gained : nullptr);
	                   } },
	        PassPart { settings.axisymmetric && motion, CostMeter::motion, [&](Block w, double*) { motion->gatherHoop(meanOfFaces(w), step.dt); } },
	        PassPart { bool(motion), CostMeter::motion, [&](Block w, double* gained) { motion->gather(w, step.dt, inRecordOfMotion ? gained : nullptr); } },
	        PassPart { bool(heat), CostMeter::heat,
	                   [&](Block w, double* gained) { heat->gather(w, inRecordOfWater || inRecordOfMotion ? gained : nullptr); } },
	        PassPart { bool(affine), CostMeter::transfer, [&](Block w, double*) { affine->gather(grid, w, *motion); } },
	        PassPart { bool(front), CostMeter::front, [&](Block w, double*) { front->gather(step, w, pointsOfFront(), affine.get()); } },
	        PassPart { average, CostMeter::cells, [&](Block w, double*) { BBar<D>::addDivergence(*cells, *points, *motion, w); } });
	if (average) cost.time(CostMeter::motion, [&] { cells->finish(step.owned); });
}

/// Points outside the box end the run; points far from their strip are sorted before the next step.
template <int D> void Ground<D>::Parts::checkPositions(const StepContext<D>& step)
{
	constexpr unsigned sort = 1, leave = 2;
	const auto         found = positions.checkPositions(step, *points, clock.range);
	const unsigned     onAny = step.onAnyRank((found.strayed || clock.sortWanted ? sort : 0) | (found.outside.empty() ? 0 : leave));
	clock.sortWanted         = (onAny & sort) != 0;
	if (!(onAny & leave)) return;
	const ConcernedPoints all    = concernedPoints(*points, found.outside, clock.steps, step.slabs);
	const bool            number = all.finite;
	throw std::runtime_error(
	        all.first + (number ? " left the grid's box" : " is not a number: the run became unstable") + " (points concerned: " + all.names + ", ...); "
	        + (number ? "enlarge the box or hold the ground with a boundary there" : "use a smaller time step"));
}

// ---- updateStrainAndPressure: exchange of cells, content of the pores -----------------------------------------------

/// Water goes to freezing fronts, before cells know all that they receive.
template <int D> void Ground<D>::Parts::segregate(const StepContext<D>& step)
{
	segregation->collect(grid, *cells, *motion, *heat, *content, step.halo);
	segregation->draw(grid, step.halo, *water, *water->liquid.enthalpy, motion->settings->gravity, step.calendarDt);
	segregation->book(step.owned, *water, ledger);
}

template <int D> void Ground<D>::Parts::stabiliseCells(const StepContext<D>& step)
{
	if (implicit) implicit->exchange(step, *water);
	else if (content->iceMass) water->stabiliseCells(step, *cells);
	water->finishCells(step);
}

/// Each strip of points receives water, its strain, and what follows from both.
template <int D> void Ground<D>::Parts::updatePoints(const StepContext<D>& step)
{
	using Sample = CostMeter::Sample;
	std::function<void(HaloExchange&)> share;
	if (exchangingCells()) share = [this](HaloExchange& rows) { water->shareCells(rows); };
	passes.inStrips(
	        share,
	        PassPart { exchangingCells() != nullptr, CostMeter::water,
	                   [&](int strip, int first, int last, Sample&) { receiveWater(step, strip, first, last); } },
	        PassPart { bool(segregation), CostMeter::segregation,
	                   [&](int, int first, int last, Sample&) { segregation->receive(*cells, first, last, content->waterMass, heat->enthalpy, *water); } },
	        PassPart { bool(motion), CostMeter::motion,
	                   [&](int, int first, int last, Sample&) { BBar<D>::strain(averagingCells(), *points, *motion, first, last); } },
	        PassPart { bool(segregation), CostMeter::segregation,
	                   [&](int, int first, int last, Sample&) { segregation->shareVolume(*cells, first, last); } },
	        PassPart { !effects.empty(), CostMeter::motion,
	                   [&](int strip, int first, int last, Sample& sample) { followStrain(step, strip, first, last, sample); } },
	        PassPart { bool(content), CostMeter::freezing, [&](int strip, int first, int last, Sample& sample) {
		                  const int failed = updateContent(step, first, last, sample);
		                  if (failed < last) impossible[strip] = failed;
	                  } });
}

/// What cells gathered goes to the points of a strip.
template <int D> void Ground<D>::Parts::receiveWater(const StepContext<D>& step, int strip, int first, int last)
{
	step.ledger.ofStrip(strip).momentumOut += water->receive(*cells, first, last, content->waterMass, heat ? heat->enthalpy : nullptr, motion->velocity);
	if (implicit) implicit->giveToPoints(*cells, step.dt, first, last);
}

/// Effects in files of their own follow the strain of a strip.
template <int D> void Ground<D>::Parts::followStrain(const StepContext<D>& step, int strip, int first, int last, CostMeter::Sample& sample)
{
	for (std::size_t k = 0; k < effects.size(); ++k) {
		effects[k]->followStrain(step, inMotion, first, last, step.ledger.ofStrip(strip));
		sample.lap(CostMeter::ofEffect(int(k)));
	}
}

/// Returns the place of the first point in an impossible state, or last.
template <int D> int Ground<D>::Parts::updateContent(const StepContext<D>& step, int first, int last, CostMeter::Sample& sample)
{
	using Block                 = typename PoreContent<D>::Block;
	const auto             of   = contentOf();
	const CostMeter::Entry pays = content->iceMass ? CostMeter::freezing : heat ? CostMeter::heat : CostMeter::water;

	const auto findState = [&](Block& b, int& found) { found = content->findTemperature(b, of); };
	const auto findRest  = [&](Block& b, int found) {
                if (found < b.end()) return;
                content->findCoefficients(b, of);
                if (!water) return;
                if (!cellPressure()) return content->findPressure(b, of);
                double excess[blockSize], compliance[blockSize];
                content->findFill(b, excess, compliance);
                water->addFills(*cells, b.first, b.count, excess, compliance, step.dt);
	};
	const PassPart state { true, pays, findState }, rest { true, water ? CostMeter::water : CostMeter::heat, findRest };
	return content->inBlocks(first, last, [&](Block& b) {
		int found = 0;
		sample.beginBlock();
		state.run(sample, b, found);
		rest.run(sample, b, found);
		return found;
	});
}

template <int D> void Ground<D>::Parts::findCellPressure(const StepContext<D>& step)
{
	water->findCellPressure(step.owned);
	if (implicit) implicit->givePressure(step.owned, *water);
	step.strips.gather([&](int, int first, int last) {
		water->shareCellPressure(*cells, first, last);
		if (content->iceMass) water->stabilisePoints(*cells, first, last, content->waterMass, heat ? heat->enthalpy : nullptr);
	});
}

template <int D> void Ground<D>::Parts::refuseImpossibleStates(const StepContext<D>& step)
{
	const auto first  = std::find_if(impossible.begin(), impossible.end(), [](int p) { return p >= 0; });
	const bool failed = first != impossible.end();
	if (!step.onAnyRank(failed)) return;
	std::string words;
	if (failed)
		words = whereabouts(*points, *first, clock.steps) + " is in an impossible state: " + whyImpossible(*first)
		        + "; the step has ended half way: go on from a checkpoint with other settings";
	std::fill(impossible.begin(), impossible.end(), -1);
	throw std::runtime_error(step.firstWords(words));
}

// ---- updateEffectiveStress: strain of the soil, laws, accounts ------------------------------------------------------

/// The skeleton laws get the strain of the soil in place of that of the ground, until restoreStrainOfGround().
template <int D> void Ground<D>::Parts::findStrainOfSoil(const StepContext<D>& step)
{
	if (segregation)
		cost.time(CostMeter::segregation, [&] {
			segregation->release(*thawStrain);
			segregation->part(*cells, *motion); // first: what a lens opens is no room that pore ice makes
		});
	cost.time(CostMeter::thawStrain, [&] {
		closeThawStrain(step);
		if (compression) compressThawed(step);
	});
}

template <int D> void Ground<D>::Parts::closeThawStrain(const StepContext<D>& step)
{
	thawStrain->release(step, inMotion, content->iceSaturation, content->iceMass, averagingCells());
	for (int k = 0; k < skeletons.count(); ++k) {
		const std::vector<int>& places = thawStrain->openAmong(skeletons.places(k));
		if (!places.empty()) skeletons.law(k).tangentModulus(skeletons.batch(places, step.time()), scratch.data());
	}
	thawStrain->close(step, inMotion, scratch.data(), motion->gradient);
}

/// After the room of ice has closed: soil in open room carries nothing.
template <int D> void Ground<D>::Parts::compressThawed(const StepContext<D>& step)
{
	for (int k = 0; k < skeletons.count(); ++k) {
		const std::vector<int>& places = compression->thawedAmong(skeletons.places(k));
		if (places.empty()) continue;
		SkeletonBatch<D> thawed = skeletons.batch(places, step.time());
		skeletons.law(k).tangentModulus(thawed, scratch.data());
		thawed.iceSaturation = compression->noIce();
		skeletons.law(k).tangentModulus(thawed, compression->thawedModulus());
	}
	compression->compress(step, inMotion, scratch.data(), motion->gradient);
}

template <int D> std::exception_ptr Ground<D>::Parts::updateSkeletons(const StepContext<D>& step)
{
	std::exception_ptr stop;
	for (int k = 0; k < skeletons.count(); ++k)
		cost.timeSkeleton(k, [&] {
			try {
				skeletons.update(step, k);
			} catch (const StopAfterStep&) {
				stop = std::current_exception();
			}
		});
	return stop;
}

/// In the reverse order of findStrainOfSoil().
template <int D> void Ground<D>::Parts::restoreStrainOfGround()
{
	if (compression) compression->restoreGradients(motion->gradient);
	thawStrain->restoreGradients(motion->gradient);
	if (segregation) segregation->restoreGradients(motion->gradient);
}

template <int D> void Ground<D>::Parts::bookStep()
{
	const StepAccount<D> step = ledger.sum(ranks.slabs());
	clock.account += step;
	clock.account.workAhead = step.workAhead; // of the last step alone
}

template <int D> void Ground<D>::Parts::advanceClock()
{
	if (momentum) momentum->endStep(clock.dt);
	clock.calendar.time = calendarEnd();
	clock.time += clock.dt;
	++clock.steps;
}

template <int D> void Ground<D>::Parts::measureMotion(const StepContext<D>& step)
{
	calendar->measure(step, inMotion, conducting(), cells.get(), settings.heatFraction, clock.calendar);
	calendar->keepEvents(step, inMotion, clock.time, clock.calendar);
}

// ---- cost -----------------------------------------------------------------------------------------------------------

template <int D> std::vector<std::pair<std::string, double>> Ground<D>::cost() const
{
	const Parts& g         = *parts_;
	const bool   exchanges = g.surface || !g.stateDependent.empty();
	// in the order of CostMeter::Entry: what a scene may spend time on, and whether this one does
	const std::pair<const char*, bool> effects[CostMeter::entries] = {
		{ "sorting", true },
		{ "motion", bool(g.motion) },
		{ "transfer", bool(g.affine) },
		{ "thaw front", bool(g.front) },
		{ "bodies", bool(g.bodies) },
		{ "cell averages", bool(g.cells) },
		{ "heat", bool(g.heat) },
		{ "freezing", g.content && g.content->iceMass },
		{ "water", bool(g.water) },
		{ "conduction and pore pressure", g.heat && g.water },
		{ "free surface", bool(g.surface) },
		{ "boundaries", exchanges },
		{ "thaw strain", bool(g.thawStrain) },
		{ "ice segregation", bool(g.segregation) },
		{ "energy ledger", g.booksEnergy() },
		{ "calendar", bool(g.calendar) },
		{ "time step limits", true },
	};
	std::vector<std::pair<std::string, double>> list;
	for (int e = 0; e < CostMeter::entries; ++e)
		if (effects[e].second) list.emplace_back(effects[e].first, g.cost.seconds(static_cast<CostMeter::Entry>(e)));
	for (std::size_t k = 0; k < g.effects.size(); ++k)
		list.emplace_back(g.effects[k]->name(), g.cost.seconds(CostMeter::ofEffect(int(k))));
	for (std::size_t k = 0; g.motion && k < g.settings.skeletons.size(); ++k)
		list.emplace_back(g.settings.skeletons[k]->name() + "[" + std::to_string(k) + "]", g.cost.secondsOfSkeleton(int(k)));
	return list;
}

TALIK_IN_PLANE_AND_SPACE(Ground);

} // namespace talik
