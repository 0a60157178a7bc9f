// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/Check.hpp>
#include <pkg/mpm/GroundParts.hpp>
#include <pkg/mpm/StopAfterStep.hpp>

#include <algorithm>
#include <cmath>
#include <exception>

namespace talik {

namespace {
	// Sorting now and then keeps neighbours together also where points only slide along their strip.
	constexpr long stepsBetweenSorts = 200;
} // namespace

template <int D> void Ground<D>::Parts::seep()
{
	scatter([&](const WeightBlock<D>& w) { water->seep(grid, w, clock.dt, liquidDensity(), enthalpyModel()); });
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b) {
		const Boundary<D>& boundary = *settings.boundaries[b];
		if (boundary.drains())
			water->drain(
			        surface->patch(b), boundary.recharges(), clock.dt, liquidDensity(), enthalpyModel(), heat ? &heat->mapped : nullptr);
		if (boundary.feeds())
			water->feed(
			        surface->patch(b), boundary.inflow(clock.time + clock.dt), boundary.inflowTemperature(), clock.dt, liquidDensity(),
			        enthalpyModel(), heat ? &heat->mapped : nullptr);
	}
	if (settings.energyLedger) {
		double work = 0.0;
		for (int i = clock.range.firstNode; i < clock.range.lastNode; ++i)
			work += water->nodal[i][0] * water->exchange[i][0];
		clock.porePressureWork += startShare() * work / liquidDensity();
	}
	water->finishExchange(clock.range);
}

template <int D> void Ground<D>::Parts::checkPositions(int strip, int first, int last)
{
	// a point that is not a number fails the comparisons too
	bool inside = true;
	for (int a = 0; a < D; ++a) {
		const double* x     = points->position(a);
		const double  lower = grid.lower()[a], upper = grid.upper()[a];
		int           out   = 0;
		for (int p = first; p < last; ++p)
			out += !(x[p] >= lower) | !(x[p] <= upper);
		inside = inside && out == 0;
	}
	if (!inside) {
		for (int p = last - 1; p >= first; --p) {
			Vec<D> x;
			for (int a = 0; a < D; ++a)
				x[a] = points->position(a)[p];
			if (!grid.contains(x)) bad[strip] = p;
		}
		return;
	}
	const Strips& strips = points->strips();
	const double  low    = grid.lower()[strips.axis] + (strip * Strips::rows - Strips::stray) * grid.spacing();
	const double  high   = grid.lower()[strips.axis] + ((strip + 1) * Strips::rows + Strips::stray) * grid.spacing();
	const double* x      = points->position(strips.axis);
	int           strayed = 0;
	for (int p = first; p < last; ++p)
		strayed += (x[p] < low) | (x[p] >= high);
	if (strayed > 0) {
#pragma omp atomic write
		clock.sortWanted = 1;
	}
}

template <int D> void Ground<D>::Parts::refuseBadPoints()
{
	std::string names;
	int         count = 0, firstBad = -1;
	for (int& p : bad) {
		if (p < 0) continue;
		if (firstBad < 0) firstBad = p;
		if (count++ < 5) names += (names.empty() ? "" : ", ") + std::to_string(points->id(p));
		p = -1;
	}
	if (count == 0) return;
	Vec<D> x;
	for (int a = 0; a < D; ++a)
		x[a] = points->position(a)[firstBad];
	const bool number = std::isfinite(x[0] + x[1] + x[D - 1]);
	throw std::runtime_error(
	        whereabouts(firstBad) + (number ? " left the grid's box" : " is not a number: the run became unstable")
	        + " (points concerned: " + names + ", ...); "
	        + (number ? "enlarge the box or hold the ground with a boundary there" : "use a smaller time step"));
}

template <int D> void Ground<D>::Parts::averageStrain(int first, int last)
{
	auto& g = motion->gradient;
	if (averaging())
		for (int p = first; p < last; ++p) {
			double trace = g[0][p];
			for (int a = 1; a < D; ++a)
				trace += g[a * D + a][p];
			const double replace = (cells->mean(p) - trace) * (1.0 / D);
			for (int a = 0; a < D; ++a)
				g[a * D + a][p] += replace;
		}
	double* volume = points->volume();
	for (int p = first; p < last; ++p) {
		if constexpr (D == 2) {
			volume[p] *= (1.0 + g[0][p]) * (1.0 + g[3][p]) - g[1][p] * g[2][p];
		} else {
			const double a = 1.0 + g[0][p], b = g[1][p], c = g[2][p], d = g[3][p], e = 1.0 + g[4][p], f = g[5][p], h = g[6][p], i = g[7][p],
			             j = 1.0 + g[8][p];
			volume[p] *= a * (e * j - f * i) - b * (d * j - f * h) + c * (d * i - e * h);
		}
	}
}

/// Work of stress and pressure on the strain of the step, half at its start (before cell means replace the divergence) and half at
/// its end: the mean of both is what an elastic skeleton stores, either alone is off by the first order of dt.
template <int D> void Ground<D>::Parts::keepStrainWork(bool atStart)
{
	const auto&   g       = motion->gradient;
	const double* volume  = points->volume();
	const bool    replace = atStart && averaging();
	clock.skeletonWork += 0.5 * sumOverStrips([&](int first, int last) {
		double work = 0.0;
		for (int p = first; p < last; ++p) {
			double trace = 0.0;
			for (int a = 0; a < D; ++a)
				trace += g[a * D + a][p];
			const double missing = replace ? (cells->mean(p) - trace) * (1.0 / D) : 0.0;
			double       density = 0.0;
			for (int i = 0; i < D; ++i)
				for (int j = 0; j < D; ++j)
					density += motion->stress[stressIndex<D>(i, j)][p] * (g[i * D + j][p] + (i == j ? missing : 0.0));
			work += volume[p] * density;
		}
		return work;
	});
	const double share = atStart ? startShare() : 1.0 - startShare();
	if (!water || share == 0.0) return;
	const double strained = sumOverStrips([&](int first, int last) {
		double work = 0.0;
		for (int p = first; p < last; ++p) {
			double trace = 0.0;
			for (int a = 0; a < D; ++a)
				trace += g[a * D + a][p];
			work += volume[p] * water->pressure[p] * (replace ? cells->mean(p) : trace);
		}
		return work;
	});
	clock.porePressureWork -= share * strained;
	if (!atStart) clock.porePressureWork += share * water->seepageWork(clock.range.firstCell, clock.range.lastCell) / liquidDensity();
}

template <int D> void Ground<D>::beginStep(double dt)
{
	Parts& g = *parts_;
	if (!g.ready) throw std::logic_error("step: the ground is not initialised");
	requireSetting(std::isfinite(dt) && dt > 0.0, "dt", dt, "must be a positive time in s; stableTimeStep() proposes one");
	if (g.clock.halfDone)
		throw std::runtime_error("the last step of the ground ended half way, its points do not fit together: go on from a checkpoint, or from the start");
	g.clock.dt = dt;
	if (g.clock.sortWanted || g.clock.steps - g.clock.lastSort >= stepsBetweenSorts) g.sort();
	g.accounts.take(g);
}

template <int D> void Ground<D>::mapToGrid()
{
	Parts& g = *parts_;
	g.clearNodes();
	g.locateInCells();
	const bool average = g.averaging();
	g.scatter([&](const WeightBlock<D>& w) {
		if (g.motion) {
			if (average)
				for (int k = 0; k < w.count; ++k)
					g.motion->meanStress[w.first + k] = g.cells->mean(w.first + k);
			else
				g.useMeanStress(w.first, w.count);
			g.motion->map(g.grid, w);
			if (g.affine) g.affine->map(g.grid, w, *g.motion);
		}
		if (g.water) g.water->map(g.grid, w, g.averagingCells());
		if (g.heat) g.heat->map(g.grid, w);
		if (g.surface) g.surface->map(g.grid, w);
	});
	if (g.surface) g.surface->collect(g.grid, *g.cells, g.clock.range);
}

template <int D> void Ground<D>::updateTemperature()
{
	Parts& g = *parts_;
	if (!g.heat) return;
	const double time = g.clock.time + g.clock.dt;
	g.heat->nodalTemperature(g.grid, g.clock.range, g.settings.boundaries, time);
	g.scatter([&](const WeightBlock<D>& w) { g.heat->conduct(g.grid, w, g.clock.dt); });
	for (std::size_t b = 0; b < g.settings.boundaries.size(); ++b) {
		const Boundary<D>& boundary = *g.settings.boundaries[b];
		if (boundary.heats()) g.heat->exchange(boundary.heat(time), g.surface->patch(b), *g.surface, g.grid.spacing(), g.clock.dt);
	}
	g.heat->finishNodes(g.clock.range, g.clock.dt);
	if (g.settings.heat->source != 0.0) {
		const double* volume = g.points->volume();
		const double  ground = g.sumOverStrips([&](int first, int last) {
                        double v = 0.0;
                        for (int p = first; p < last; ++p)
                                v += volume[p];
                        return v;
                });
		g.heat->heatIn += g.settings.heat->source * g.settings.heat->thermalTimeScale * ground * g.clock.dt;
	}
}

template <int D> void Ground<D>::solveMomentum()
{
	Parts& g = *parts_;
	if (!g.motion) return;
	const double time = g.clock.time + g.clock.dt;
	if (g.water) {
		g.water->nodalPressure(g.clock.range);
		g.scatter([&](const WeightBlock<D>& w) { g.water->pressureForce(g.grid, w); });
		g.water->liquidForce(g.clock.range, g.motion->settings->gravity);
	}
	g.momentum->addGravity(g.clock.range, *g.motion, g.water.get());
	for (std::size_t b = 0; b < g.settings.boundaries.size(); ++b) {
		const Boundary<D>& boundary = *g.settings.boundaries[b];
		if (boundary.loads()) g.momentum->addLoad(boundary, g.surface->patch(b), time, *g.motion);
		if (boundary.drains()) g.water->drainedForce(g.surface->patch(b), boundary.pressure(time));
	}
	if (g.bodies) g.bodies->push(*g.shape, g.grid, g.clock.dt, *g.motion, g.clock.account.impulse);
	g.momentum->solve(g.clock.range, *g.motion, g.water.get(), g.clock.dt, g.settings.energyLedger, g.clock.account);
	const double mass = g.clock.initialMass - (g.water ? g.water->waterOut : 0.0);
	for (int a = 0; a < D; ++a)
		g.clock.account.impulse[a] += g.clock.dt * mass * g.motion->settings->gravity[a];
	if (g.water) g.seep();
}

template <int D> void Ground<D>::mapToPoints()
{
	Parts& g = *parts_;
	if (g.motion) g.requirePathsInside();
	g.clock.halfDone = 1;
	if (g.averaging()) g.cells->clearSums(g.clock.range);
	const bool average = g.averaging();
	const auto gather  = [&](int strip, int first, int last) {
                g.overBlocks(first, last, [&](const WeightBlock<D>& w) {
                        if (g.heat) g.heat->gather(g.grid, w, g.clock.dt);
                        if (g.water)
                                g.water->gather(g.grid, w, g.content->waterMass, g.heat ? g.heat->enthalpy : nullptr, g.averagingCells());
                        if (g.motion) g.motion->gather(g.grid, w, g.clock.dt);
                        if (g.affine) g.affine->gather(g.grid, w, *g.motion);
                });
                if (!g.motion) return;
                if (average) {
                        const double* volume = g.points->volume();
                        for (int p = first; p < last; ++p) {
                                double trace = g.motion->gradient[0][p];
                                for (int a = 1; a < D; ++a)
                                        trace += g.motion->gradient[a * D + a][p];
                                g.cells->add(p, volume[p] * trace);
                        }
                }
                g.checkPositions(strip, first, last);
	};
	g.points->strips().scatter(gather);
	if (g.motion) g.refuseBadPoints();
}

template <int D> void Ground<D>::updateStrainAndPressure()
{
	Parts& g = *parts_;
	if (g.motion && g.settings.energyLedger) g.keepStrainWork(true);
	const CellMeans<D>* cells  = g.water ? g.averagingCells() : nullptr;
	const auto          update = [&](int strip, int first, int last) {
                if (cells) g.water->receive(*cells, first, last, g.content->waterMass, g.heat ? g.heat->enthalpy : nullptr);
                if (g.motion) g.averageStrain(first, last);
                if (g.record) g.record->accumulate(first, last, g.motion->gradient);
                if (!g.content) return;
                const int failed = g.content->update(first, last, cells);
                if (failed < last) g.bad[strip] = failed;
	};
	if (cells) {
		g.points->strips().scatter(update);
		if (g.cellPressure())
			g.points->strips().gather([&](int, int first, int last) { g.water->shareCellPressure(*cells, first, last); });
	} else
		g.points->strips().gather(update);
	if (!g.content) return;
	for (int& failed : g.bad) {
		if (failed < 0) continue;
		const int p = failed;
		std::fill(g.bad.begin(), g.bad.end(), -1);
		throw std::runtime_error(g.whereabouts(p) + " is in an impossible state: " + g.content->complaint(p) + "; the step has ended half way: go on from a checkpoint with other settings");
	}
}

template <int D> void Ground<D>::updateEffectiveStress()
{
	Parts& g = *parts_;
	std::exception_ptr stop;
	if (g.motion)
		for (std::size_t k = 0; k < g.settings.skeletons.size(); ++k) {
			if (g.skeletonPlaces[k].empty()) continue;
			try {
				g.settings.skeletons[k]->updateStress(g.batch(k));
			} catch (const StopAfterStep&) {
				stop = std::current_exception();
			}
		}
	if (g.motion && g.settings.energyLedger) g.keepStrainWork(false);
	g.clock.time += g.clock.dt;
	++g.clock.steps;
	g.clock.halfDone = 0;
	if (stop) std::rethrow_exception(stop);
}

template void Ground<2>::beginStep(double);
template void Ground<2>::mapToGrid();
template void Ground<2>::updateTemperature();
template void Ground<2>::solveMomentum();
template void Ground<2>::mapToPoints();
template void Ground<2>::updateStrainAndPressure();
template void Ground<2>::updateEffectiveStress();
template void Ground<3>::beginStep(double);
template void Ground<3>::mapToGrid();
template void Ground<3>::updateTemperature();
template void Ground<3>::solveMomentum();
template void Ground<3>::mapToPoints();
template void Ground<3>::updateStrainAndPressure();
template void Ground<3>::updateEffectiveStress();

} // namespace talik
