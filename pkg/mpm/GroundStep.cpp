// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundParts.hpp>
#include <pkg/thm/Errors.hpp>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace talik {

namespace {
	// Sorting now and then keeps neighbours together also where points only slide along their strip.
	constexpr long stepsBetweenSorts = 200;
} // namespace

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
	if (g.heat) g.cost.time(CostMeter::heat, [&] { g.settleHeat(); });
}

template <int D> void Ground<D>::p2g()
{
	Parts& g = *parts_;
	if (g.allRests()) return;
	g.cost.time(g.base(), [&] { g.clearNodes(); });
	if (g.front) g.cost.time(CostMeter::front, [&] { g.findFront(); });
	if (g.cells) g.cost.time(CostMeter::cells, [&] { g.locateInCells(); });
	if (g.surface) g.surface->findNeeded(g.grid, *g.cells);
	g.mapToGrid();
	if (g.surface) g.cost.time(CostMeter::surface, [&] { g.collectSurfaces(); });
}

template <int D> void Ground<D>::solveNodes()
{
	Parts& g = *parts_;
	if (g.allRests()) return;
	if (g.heat || g.water) g.findFlows();
	if (!g.stateDependent.empty()) g.cost.time(CostMeter::boundaries, [&] { g.evaluateBoundaries(); });
	if (g.heat && !g.heatRests) g.updateTemperature();
	if (g.motion) g.solveMomentum();
}

template <int D> void Ground<D>::g2p()
{
	Parts& g = *parts_;
	if (g.motion) g.cost.time(CostMeter::motion, [&] { g.requirePathsInside(); });
	g.clock.halfDone = 1;
	if (g.allRests()) return;
	if (g.averaging()) g.cells->clearSums(g.around);
	g.gatherFromGrid();
	if (g.motion) g.cost.time(CostMeter::motion, [&] { g.finishPaths(); });
}

template <int D> void Ground<D>::updateStrainAndPressure()
{
	Parts& g = *parts_;
	if (g.allRests() && g.contentSettled) return;
	if (g.motion && g.settings.energyLedger)
		g.cost.time(CostMeter::ledger, [&] { g.strainWork.bookStart(g.context(), *g.points, *g.motion, g.water.get(), g.averagingCells()); });
	const CellMeans<D>* const        cells = g.water ? g.averagingCells() : nullptr;
	std::function<void(SharedRows&)> share;
	if (cells) {
		if (g.segregation) g.cost.time(CostMeter::segregation, [&] { g.segregate(); });
		g.cost.time(CostMeter::water, [&] { g.levelCells(); });
		share = [&g](SharedRows& rows) { g.water->shareCells(rows); };
	}
	using Sample = CostMeter::Sample;
	g.inStrips(
	        share,
	        PassPart { cells != nullptr, CostMeter::water,
	                   [&](int strip, int first, int last, Sample&) {
		                   const Vec<D> lost = g.water->receive(
		                           *cells, first, last, g.content->waterMass, g.heat ? g.heat->enthalpy : nullptr, g.motion->velocity);
		                   for (int a = 0; a < D; ++a)
			                   g.ledger.ofStrip(strip).momentumOut[a] += lost[a];
	                   } },
	        PassPart { bool(g.segregation), CostMeter::segregation,
	                   [&](int, int first, int last, Sample&) {
		                   g.segregation->receive(*cells, first, last, *g.heat, g.content->waterMass, g.heat->enthalpy, *g.water);
	                   } },
	        PassPart { bool(g.motion), CostMeter::motion,
	                   [&](int, int first, int last, Sample&) { BBar<D>::strain(g.averagingCells(), *g.points, *g.motion, first, last); } },
	        PassPart { bool(g.segregation), CostMeter::segregation,
	                   [&](int, int first, int last, Sample&) { g.segregation->shareVolume(*cells, first, last); } },
	        PassPart { !g.effects.empty(), CostMeter::motion,
	                   [&](int strip, int first, int last, Sample& sample) { g.followStrain(strip, first, last, sample); } },
	        PassPart { bool(g.content), CostMeter::freezing, [&](int strip, int first, int last, Sample& sample) {
		                  const int failed = g.updateContent(first, last, cells, sample);
		                  if (failed < last) g.impossible[strip] = failed;
	                  } });
	if (g.cellPressure()) g.cost.time(CostMeter::water, [&] { g.findCellPressure(); });
	g.contentSettled = g.allRests();
	if (g.content) g.refuseImpossibleStates();
}

template <int D> void Ground<D>::updateEffectiveStress()
{
	Parts&             g = *parts_;
	std::exception_ptr stop;
	if (g.segregation) g.cost.time(CostMeter::segregation, [&] { g.segregation->release(*g.thawStrain); });
	if (g.thawStrain) g.cost.time(CostMeter::thawStrain, [&] { g.closeThawStrain(); });
	if (g.segregation) g.cost.time(CostMeter::segregation, [&] { g.segregation->part(*g.cells, *g.motion); });
	if (g.motion) stop = g.updateSkeletons();
	if (g.segregation) g.segregation->restoreGradients(*g.motion);
	if (g.compression) g.compression->restoreGradients();
	if (g.thawStrain) g.thawStrain->restoreGradients();
	if (g.motion && g.settings.energyLedger)
		g.cost.time(CostMeter::ledger, [&] { g.strainWork.bookEnd(g.context(), *g.points, *g.motion, g.water.get(), g.liquidDensity()); });
	g.bookStep();
	if (g.momentum) g.momentum->endStep(g.clock.dt);
	g.clock.calendar.time = g.calendarEnd();
	g.clock.time += g.clock.dt;
	++g.clock.steps;
	if (g.calendar) g.cost.time(CostMeter::calendar, [&] { g.measureMotion(); });
	g.clock.halfDone = 0;
	if (stop) std::rethrow_exception(stop);
}

// ---- beginStep: length and scale of the step, sorting ---------------------------------------------------------------

template <int D> void Ground<D>::Parts::openStep(double dt)
{
	if (bands) meetRanks();
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
	if (heat) heat->scale = state.scale;
	if (water) content->useScale(*water, state.scale);
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
		water->weight[a] = liquidDensity() * settings.motion->gravity[a];
	const double given = settings.water->picTime, used = std::isnan(given) ? gravityTime(h, lengthOf<D>(settings.motion->gravity)) : given;
	water->kept = keptFraction(water->fastest > 1.0 ? std::min(used, water->longestRest) : used, clock.dt);
}

template <int D> void Ground<D>::Parts::settleHeat()
{
	const double before = heat->reference;
	heatRests           = heatMayRest();
	// an update that left all temperatures as they were would do so again
	contentSettled = contentSettled && heatRests && heat->reference == before;
}

// ---- p2g: points to nodes and cells ---------------------------------------------------------------------------------

template <int D> void Ground<D>::Parts::findFront()
{
	front->find(grid, around, momentum->mirrors(), momentum->freeLiquid());
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

template <int D> void Ground<D>::Parts::mapToGrid()
{
	using Columns                        = NodeColumns<D>;
	const bool          conducts         = heat && !heatRests;
	const double* const share            = conducts ? heat->carriedShare() : nullptr;
	const double* const sharedWithMotion = Columns::Moving::carriesHeat ? share : nullptr;
	inBlocks(
	        read.toGrid,
	        [&](SharedRows& rows) {
		        rows.beyond = true;
		        if (motion) rows.nodes(motion->nodes);
		        if (front) front->shareMapped(grid, rows);
		        if (water) rows.nodes(water->nodes);
		        if (conducts) heat->shareMapped(rows);
		        if (surface) rows.nodes(surface->nodes);
	        },
	        [](int, int, int) {},
	        PassPart { motion && motion->addedStress, CostMeter::motion,
	                   [&](const WeightBlock<D>& w, double*) {
		                   bBar.findAddedStress(averagingCells(), *points, *motion, water.get(), w.first, w.first + w.count);
	                   } },
	        PassPart { !stressingEffects.empty(), CostMeter::motion,
	                   [&](const WeightBlock<D>& w, double*, CostMeter::Sample& sample) { addStress(w, sample); } },
	        PassPart { bool(motion), CostMeter::motion,
	                   [&](const WeightBlock<D>& w, double*) {
		                   motion->map(w, sharedWithMotion, share ? heat->temperature : nullptr, share ? heat->reference : 0.0);
	                   } },
	        PassPart { bool(affine), CostMeter::transfer, [&](const WeightBlock<D>& w, double*) { affine->map(grid, w, *motion); } },
	        PassPart { bool(front), CostMeter::front, [&](const WeightBlock<D>& w, double*) { front->map(grid, w, affine.get()); } },
	        PassPart { bool(water), CostMeter::water,
	                   [&](const WeightBlock<D>& w, double*) { water->map(w, averagingCells(), share, share ? heat->reference : 0.0); } },
	        PassPart { conducts, CostMeter::heat, [&](const WeightBlock<D>& w, double*) { heat->map(w); } },
	        PassPart { bool(implicit), CostMeter::water, [&](const WeightBlock<D>& w, double*) { implicit->map(w, *cells, *points, *content); } },
	        PassPart { bool(surface), CostMeter::surface, [&](const WeightBlock<D>& w, double*) { surface->map(w); } });
}

/// Effects in files of their own add to the stress of a block.
template <int D> void Ground<D>::Parts::addStress(const WeightBlock<D>& w, CostMeter::Sample& sample)
{
	for (const int k : stressingEffects) {
		effects[k]->addStress(context(), inMotion, w.first, w.first + w.count);
		sample.lap(CostMeter::ofEffect(k));
	}
}

template <int D> void Ground<D>::Parts::collectSurfaces()
{
	if (bodies) bodies->cover(*shape, grid, *surface);
	surface->collect(grid, *cells, around);
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b) {
		const Region<D>& region = settings.boundaries[b]->region();
		if (region.kind == Region<D>::Kind::bodies) bodies->collectFaces(*shape, grid, around, region.ids, surface->patch(b));
	}
}

// ---- solveNodes: heat and pore pressure -----------------------------------------------------------------------------

/// Heat that conduction brings to the nodes and force of the pore pressure on them, in one pass where both exist.
template <int D> void Ground<D>::Parts::findFlows()
{
	const bool conducts = heat && !heatRests;
	if (conducts) cost.time(CostMeter::heat, [&] { heat->nodalTemperature(context(), settings.boundaries); });
	else if (heat && water) cost.time(CostMeter::heat, [&] { heat->rest(around); });
	if (water) cost.time(CostMeter::water, [&] { findNodalPressure(); });
	const auto pass = [&](CostMeter::Entry pays, auto&& work) {
		const auto share = [&](SharedRows& rows) {
			rows.beyond = water && front; // sides meet there with the force on their liquid
			if (water) rows.nodes(water->force);
			if (conducts) heat->shareConducted(rows);
		};
		cost.time(pays, [&] { scatter(read.flows, work, share); });
	};
	if (conducts && water) {
		const typename NodeLoops<D>::HeatFlow flow = heat->flow(clock.dt);
		pass(CostMeter::flows, [&](const WeightBlock<D>& w) { nodeLoops<D>().flowHeatAndPressure(w, flow, water->nodal[0], water->force[0]); });
	} else if (conducts) pass(CostMeter::heat, [&](const WeightBlock<D>& w) { heat->conduct(w, clock.dt); });
	else if (water) pass(CostMeter::water, [&](const WeightBlock<D>& w) { water->pressureForce(w); });
}

template <int D> void Ground<D>::Parts::findNodalPressure()
{
	water->nodalPressure(around);
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b)
		if (settings.boundaries[b]->drains() || settings.boundaries[b]->feeds()) water->open(surface->patch(b));
	water->addPotential(grid, around, *motion, momentum->heldAxes());
}

/// Fluxes and forces of boundaries that follow the state of their nodes.
template <int D> void Ground<D>::Parts::evaluateBoundaries()
{
	stateDependent.evaluate(context(), { motion.get(), heat.get(), heatRests, water.get() }, surface.get());
}

template <int D> void Ground<D>::Parts::updateTemperature()
{
	cost.time(CostMeter::boundaries, [&] { exchangeHeat(); });
	cost.time(CostMeter::heat, [&] { finishTemperature(); });
}

template <int D> void Ground<D>::Parts::exchangeHeat()
{
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b)
		if (settings.boundaries[b]->heats()) heat->exchange(context(), *settings.boundaries[b], surface->patch(b), *surface);
}

template <int D> void Ground<D>::Parts::finishTemperature()
{
	heat->produce(context(), settings.boundaries);
	heat->finishNodes(context(), settings.boundaries);
	if (settings.heat->source == 0.0) return;
	const double* volume = points->volume();
	context().bookByStrip([&](StepAccount<D>& account, int first, int last) {
		double v = 0.0;
		for (int p = first; p < last; ++p)
			v += volume[p];
		account.heatIn += settings.heat->source * heat->scale * v * clock.dt;
	});
}

// ---- solveNodes: momentum and seepage -------------------------------------------------------------------------------

template <int D> void Ground<D>::Parts::solveMomentum()
{
	if (water) cost.time(CostMeter::water, [&] { water->liquidForce(around); });
	cost.time(CostMeter::motion, [&] { momentum->addGravity(around, *motion, water.get()); });
	cost.time(CostMeter::boundaries, [&] { pushByBoundaries(); });
	if (bodies) cost.time(CostMeter::bodies, [&] { bodies->push(*shape, grid, clock.dt, *motion, front.get(), clock.steps == 0, clock.account.impulse); });
	cost.time(CostMeter::motion, [&] {
		const auto correct = [this] {
			cost.time(CostMeter::motion, [] {}); // so far
			cost.time(CostMeter::water, [this] { findImplicitPressure(); });
		};
		const std::function<void()> change = implicit ? correct : std::function<void()>();
		momentum->solve(context(), *motion, water.get(), front.get(), settings.energyLedger && !implicit, change);
		const double mass = clock.initialMass - clock.account.waterOut;
		for (int a = 0; a < D; ++a)
			clock.account.impulse[a] += clock.dt * mass * motion->settings->gravity[a];
	});
	if (water) cost.time(CostMeter::water, [&] { seep(); });
}

template <int D> void Ground<D>::Parts::pushByBoundaries()
{
	const double time = calendarEnd();
	stateDependent.accelerate(*momentum, *motion);
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b) {
		const Boundary<D>& boundary = *settings.boundaries[b];
		if (boundary.loads()) momentum->addLoad(boundary, surface->patch(b), time, *motion);
		if (boundary.drains()) water->drainedForce(surface->patch(b), boundary.pressure(time));
	}
}

template <int D> void Ground<D>::Parts::seep()
{
	if (implicit) return water->finishExchange(reached);
	waterRests = false;
	if (settings.resting) {
		const bool flows = water->flows(reached);
		waterRests       = !context().onAnyRank(flows);
	}
	if (!waterRests)
		scatter(
		        read.seepage, [&](const WeightBlock<D>& w) { water->seep(w, clock.dt, liquidDensity(), enthalpyModel()); },
		        [&](SharedRows& rows) { rows.nodes(water->exchange); });
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b) {
		const Boundary<D>& boundary = *settings.boundaries[b];
		if (boundary.drains()) water->drain(context(), surface->patch(b), boundary.recharges(), liquid(), heat ? &heat->mapped : nullptr);
	}
	feedWater();
	if (settings.energyLedger)
		reached.overNodes([&](int, int first, int last) {
			double work = 0.0;
			for (int i = first; i < last; ++i)
				work += water->pressureAtNode(i) * water->exchange[i][PoreWater<D>::Gathered::water];
			ledger.ofNode(first).porePressureWork += strainWork.pressureAtStart * work / liquidDensity();
		});
	water->finishExchange(reached);
}

template <int D> void Ground<D>::Parts::feedWater()
{
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b) {
		const Boundary<D>& boundary = *settings.boundaries[b];
		if (boundary.feeds())
			water->feed(
			        context(), surface->patch(b), boundary.inflow(calendarEnd()), boundary.inflowTemperature(), liquid(),
			        heat ? &heat->mapped : nullptr);
	}
}

/// In place of the flow of the nodes water flows between cells, by the pressure that they have at the end of the step.
template <int D> void Ground<D>::Parts::findImplicitPressure()
{
	waterRests = false;
	feedWater();
	implicit->beginFlow(context(), *cells, *motion, *water, liquidDensity());
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b)
		if (settings.boundaries[b]->drains())
			implicit->drain(
			        context(), surface->patch(b), settings.boundaries[b]->pressure(calendarEnd()), settings.boundaries[b]->recharges(), *water);
	implicit->solve(context(), *momentum, *motion, *water, liquidDensity());
	if (settings.energyLedger) implicit->bookDissipation(context());
}

// ---- g2p: nodes to points -------------------------------------------------------------------------------------------

template <int D> void Ground<D>::Parts::gatherFromGrid()
{
	const bool average = averaging(), conducts = heat && !heatRests, inRecordOfWater = conducts && water && NodeColumns<D>::Gathered::carriesRise,
	           inRecordOfMotion = conducts && motion && NodeColumns<D>::Solved::carriesRise;
	inBlocks(
	        read.toPoints,
	        [&](SharedRows& rows) {
		        if (!average) return;
		        cells->shareSums(rows);
		        if (water) water->shareCells(rows);
	        },
	        [&](int strip, int first, int last) {
		        if (motion) positions.bound(*points, strip, first, last);
	        },
	        PassPart { bool(water), CostMeter::water,
	                   [&](const WeightBlock<D>& w, double* gained) {
		                   water->gather(w, content->waterMass, heat ? heat->enthalpy : nullptr, averagingCells(), inRecordOfWater ? gained : nullptr);
	                   } },
	        PassPart { bool(motion), CostMeter::motion,
	                   [&](const WeightBlock<D>& w, double* gained) { motion->gather(w, clock.dt, inRecordOfMotion ? gained : nullptr); } },
	        PassPart { conducts, CostMeter::heat,
	                   [&](const WeightBlock<D>& w, double* gained) { heat->gather(w, inRecordOfWater || inRecordOfMotion ? gained : nullptr); } },
	        PassPart { bool(affine), CostMeter::transfer, [&](const WeightBlock<D>& w, double*) { affine->gather(grid, w, *motion); } },
	        PassPart { bool(front), CostMeter::front, [&](const WeightBlock<D>& w, double*) { front->gather(grid, w, clock.dt, affine.get()); } },
	        PassPart { average, CostMeter::cells, [&](const WeightBlock<D>& w, double*) { BBar<D>::addDivergence(*cells, *points, *motion, w); } });
}

template <int D> void Ground<D>::Parts::finishPaths()
{
	if (averaging()) cells->finish(reached);
	checkPositions();
}

/// Points outside the box end the run; points far from their strip are sorted before the next step.
template <int D> void Ground<D>::Parts::checkPositions()
{
	constexpr unsigned sort = 1, leave = 2;
	const auto         found = positions.checkPositions(context(), *points, clock.range);
	const unsigned     onAny = context().onAnyRank((found.strayed || clock.sortWanted ? sort : 0) | (found.outside.empty() ? 0 : leave));
	clock.sortWanted         = (onAny & sort) != 0;
	if (!(onAny & leave)) return;
	const ConcernedPoints all    = concernedPoints(*points, found.outside, clock.steps, bands.get());
	const bool            number = all.finite;
	throw std::runtime_error(
	        all.first + (number ? " left the grid's box" : " is not a number: the run became unstable") + " (points concerned: " + all.names + ", ...); "
	        + (number ? "enlarge the box or hold the ground with a boundary there" : "use a smaller time step"));
}

// ---- updateStrainAndPressure: exchange of cells, content of the pores -----------------------------------------------

/// Water goes to freezing fronts, before cells know all that they receive.
template <int D> void Ground<D>::Parts::segregate()
{
	segregation->collect(*cells, *motion, *heat, *content, around);
	segregation->draw(grid, around, *water, *enthalpyModel(), motion->settings->gravity, clock.calendar.scale * clock.dt);
	segregation->book(reached, *water, ledger);
}

template <int D> void Ground<D>::Parts::levelCells()
{
	if (implicit) implicit->exchange(context(), *water, liquid());
	else if (content->iceMass) water->levelCells(context(), *cells, motion->settings->gravity, liquid());
	water->finishCells(context());
}

/// They follow the strain of a strip.
template <int D> void Ground<D>::Parts::followStrain(int strip, int first, int last, CostMeter::Sample& sample)
{
	for (std::size_t k = 0; k < effects.size(); ++k) {
		effects[k]->followStrain(context(), inMotion, first, last, ledger.ofStrip(strip));
		sample.lap(CostMeter::ofEffect(int(k)));
	}
}

/// Returns the place of the first point in an impossible state, or last.
template <int D> int Ground<D>::Parts::updateContent(int first, int last, const CellMeans<D>* cells, CostMeter::Sample& sample)
{
	using Block                 = typename PoreContent<D>::Block;
	const auto             of   = contentOf();
	const CostMeter::Entry pays = content->iceMass ? CostMeter::freezing : heat ? CostMeter::heat : CostMeter::water;

	const auto findState = [&](Block& b, int& reached) { reached = content->findTemperature(b, of); };
	const auto findRest  = [&](Block& b, int reached) {
                if (reached == b.end()) content->findCoefficientsAndPressure(b, of, cells, clock.dt);
	};
	const PassPart state { true, pays, findState }, rest { true, water ? CostMeter::water : CostMeter::heat, findRest };
	return content->inBlocks(first, last, [&](Block& b) {
		int reached = 0;
		sample.beginBlock();
		state.run(sample, b, reached);
		rest.run(sample, b, reached);
		return reached;
	});
}

template <int D> void Ground<D>::Parts::findCellPressure()
{
	water->findCellPressure(reached, enthalpyModel());
	if (implicit) implicit->givePressure(reached, *water);
	points->strips().gather([&](int, int first, int last) {
		water->shareCellPressure(*cells, first, last);
		if (content->iceMass) water->levelPoints(*cells, first, last, content->waterMass, heat ? heat->enthalpy : nullptr, liquidDensity());
	});
}

template <int D> void Ground<D>::Parts::refuseImpossibleStates()
{
	const auto first  = std::find_if(impossible.begin(), impossible.end(), [](int p) { return p >= 0; });
	const bool failed = first != impossible.end();
	if (!context().onAnyRank(failed)) return;
	std::string words;
	if (failed)
		words = whereabouts(*points, *first, clock.steps) + " is in an impossible state: " + content->whyImpossible(*first, heat.get())
		        + "; the step has ended half way: go on from a checkpoint with other settings";
	std::fill(impossible.begin(), impossible.end(), -1);
	throw std::runtime_error(context().firstWords(words));
}

// ---- updateEffectiveStress: thaw strain, laws, accounts -------------------------------------------------------------

/// The skeleton laws get the strain of the soil in place of that of the ground, until restoreGradients().
template <int D> void Ground<D>::Parts::closeThawStrain()
{
	thawStrain->release(averagingCells(), around);
	for (int k = 0; k < skeletons.count(); ++k) {
		const std::vector<int>& places = thawStrain->openAmong(skeletons.places(k));
		if (!places.empty()) skeletons.law(k).tangentModulus(skeletons.batch(places, stepTime()), scratch.data());
	}
	thawStrain->close(scratch.data());
	if (compression) compressThawed();
}

/// After the room of ice has closed: soil in open room carries nothing.
template <int D> void Ground<D>::Parts::compressThawed()
{
	compression->open(*thawStrain);
	for (int k = 0; k < skeletons.count(); ++k) {
		const std::vector<int>& places = compression->thawedAmong(skeletons.places(k));
		if (places.empty()) continue;
		SkeletonBatch<D> thawed = skeletons.batch(places, stepTime());
		skeletons.law(k).tangentModulus(thawed, scratch.data());
		thawed.iceSaturation = compression->noIce();
		skeletons.law(k).tangentModulus(thawed, compression->thawedModulus());
	}
	compression->compress(scratch.data(), clock.dt, averagingCells(), around);
}

template <int D> std::exception_ptr Ground<D>::Parts::updateSkeletons()
{
	std::exception_ptr stop;
	for (int k = 0; k < skeletons.count(); ++k)
		cost.timeSkeleton(k, [&] {
			try {
				skeletons.update(context(), k);
			} catch (const StopAfterStep&) {
				stop = std::current_exception();
			}
		});
	return stop;
}

template <int D> void Ground<D>::Parts::bookStep() { clock.account.add(ledger.sum(bands.get())); }

/// Heat of ground with one temperature, in which nothing can change it, has nothing to do. That is decided anew in every step, from
/// the state alone.
template <int D> bool Ground<D>::Parts::heatMayRest()
{
	struct Own {
		double reference, first;
		int    holdsReference, points, same;
	};
	const Strips& strips = points->strips();
	const int     first = strips.firstPoint(), end = strips.endPoint(), place = points->place(0);
	const double* temperature = heat->temperature;
	Own           own {};
	own.holdsReference = place >= first && place < end;
	own.points         = end > first;
	if (own.holdsReference) own.reference = temperature[place];
	if (own.points) own.first = temperature[first];
	own.same                   = settings.resting && heat->haveTemperature(own.first, first, end);
	const std::vector<Own> all = bands ? bands->byRank(own) : std::vector<Own> { own };
	for (const Own& rank : all)
		if (rank.holdsReference) heat->setReference(rank.reference);
	const bool same = std::all_of(all.begin(), all.end(), [&](const Own& rank) { return rank.same && (!rank.points || rank.first == heat->reference); });
	return same && heat->receivesNothing(settings.boundaries, calendarEnd());
}

template <int D> void Ground<D>::Parts::measureMotion()
{
	calendar->measure(clock.calendar, points->strips(), cells ? &*cells : nullptr, reached, grid, settings.heatFraction);
	calendar->keepEvents(clock.calendar, clock.dt, clock.time, points->strips());
}

// ---- cost -----------------------------------------------------------------------------------------------------------

template <int D> std::vector<std::pair<std::string, double>> Ground<D>::cost() const
{
	const Parts&                                g = *parts_;
	std::vector<std::pair<std::string, double>> list;
	for (int e = 0; e < CostMeter::entries; ++e)
		if (g.pays(static_cast<CostMeter::Entry>(e)))
			list.emplace_back(CostMeter::nameOf(static_cast<CostMeter::Entry>(e)), g.cost.seconds(static_cast<CostMeter::Entry>(e)));
	for (std::size_t k = 0; k < g.effects.size(); ++k)
		list.emplace_back(g.effects[k]->name(), g.cost.seconds(CostMeter::ofEffect(int(k))));
	for (std::size_t k = 0; g.motion && k < g.settings.skeletons.size(); ++k)
		list.emplace_back(g.settings.skeletons[k]->name() + "[" + std::to_string(k) + "]", g.cost.secondsOfSkeleton(int(k)));
	return list;
}

template <int D> bool Ground<D>::Parts::pays(CostMeter::Entry entry) const
{
	switch (entry) {
		case CostMeter::motion: return bool(motion);
		case CostMeter::transfer: return bool(affine);
		case CostMeter::front: return bool(front);
		case CostMeter::bodies: return bool(bodies);
		case CostMeter::cells: return bool(cells);
		case CostMeter::heat: return bool(heat);
		case CostMeter::freezing: return content && content->iceMass;
		case CostMeter::water: return bool(water);
		case CostMeter::flows: return heat && water;
		case CostMeter::surface: return bool(surface);
		case CostMeter::boundaries: return surface || !stateDependent.empty();
		case CostMeter::thawStrain: return bool(thawStrain);
		case CostMeter::segregation: return bool(segregation);
		case CostMeter::calendar: return bool(calendar);
		case CostMeter::ledger: return motion && settings.energyLedger;
		default: return true;
	}
}

template std::vector<std::pair<std::string, double>> Ground<2>::cost() const;
template std::vector<std::pair<std::string, double>> Ground<3>::cost() const;
template void                                        Ground<2>::Parts::collectSurfaces();
template void                                        Ground<3>::Parts::collectSurfaces();
template void                                        Ground<2>::Parts::useScale();
template void                                        Ground<3>::Parts::useScale();
template void                                        Ground<2>::beginStep(double);
template void                                        Ground<2>::p2g();
template void                                        Ground<2>::solveNodes();
template void                                        Ground<2>::g2p();
template void                                        Ground<2>::updateStrainAndPressure();
template void                                        Ground<2>::updateEffectiveStress();
template void                                        Ground<3>::beginStep(double);
template void                                        Ground<3>::p2g();
template void                                        Ground<3>::solveNodes();
template void                                        Ground<3>::g2p();
template void                                        Ground<3>::updateStrainAndPressure();
template void                                        Ground<3>::updateEffectiveStress();

} // namespace talik
