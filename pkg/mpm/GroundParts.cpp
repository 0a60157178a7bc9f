// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundParts.hpp>

namespace talik {

template <int D> void Ground<D>::Parts::sort()
{
	takePlaces(false);
	clock.lastSort   = clock.steps;
	clock.sortWanted = 0;
	if (!division) return;
	const auto divided = points->divide(division->find(grid, *points, ranks.halo()));
	if (divided.empty()) return;
	followDivision(divided);
	takePlaces(true);
}

template <int D> void Ground<D>::Parts::takePlaces(bool costKnown)
{
	points->strips().parallel = points->count() >= settings.parallelFrom;
	if (ranks) sortInSlabs(costKnown);
	else {
		points->sort(grid);
		clock.range = ActiveRange::of(grid, *points);
	}
	afterReordering(true);
}

template <int D> void Ground<D>::Parts::followDivision(const std::vector<int>& divided)
{
	for (const int id : divided) {
		parents.push_back(id);
		if (!given.fill.empty()) given.fill.push_back(given.fill[id]);
	}
	for (const auto& law : settings.skeletons)
		law->divide(divided);
}

template <int D> void Ground<D>::Parts::afterReordering(bool pointsMoved)
{
	if (ranks) ranks.cut();
	if (ranks && motion) followSlabs(pointsMoved);
	ranks.chooseRows(clock.range);
	// what lies outside the active range stays zero until the next sorting
	if (ranks) keepOwnPart();
	clearNodes(ranks ? ranks.halo().firstNode : 0, ranks ? ranks.halo().lastNode : grid.nodeCount());
	if (cells && !ranks) cells->clearAll();
	if (water && !ranks) water->clearCells(0, grid.cellCount());
	if (!motion) return;
	skeletons.list();
	positions.start(*points);
}

template <int D> void Ground<D>::Parts::clearNodes(int first, int last)
{
	if (motion) motion->nodes.clear(first, last);
	if (mappedBack) mappedBack->missing.clear(first, last);
	if (water) water->nodes.clear(first, last);
	if (heat) heat->clear(first, last);
	if (surface) surface->nodes.clear(first, last);
}

template <int D> void Ground<D>::Parts::clearNodes()
{
	ranks.halo().overNodes([&](int, int first, int last) { clearNodes(first, last); });
}

template <int D> typename PoreContent<D>::PointArrays Ground<D>::Parts::contentOf() const
{
	typename PoreContent<D>::PointArrays of {};
	if (motion) of.solid = { motion->mass, motion->velocity, motion->initialVolume };
	if (heat) of.heat = { heat->enthalpy, heat->temperature, heat->heatCapacity, heat->capacityWeight, heat->conductivity };
	if (water) of.water = { water->pressure, water->liquidFraction, water->drag, water->velocity };
	return of;
}

template <int D> void Ground<D>::Parts::locateInCells()
{
	if (!cells) return;
	const ActiveRange& halo = ranks.halo();
	cells->clearVolumes(halo);
	cells->clearSums(halo);
	const bool average = averaging();
	if (water) water->clearCells(halo.firstCell, halo.lastCell);
	if (implicit) implicit->clear(halo);
	bBar.clear(halo);
	points->strips().scatter(
	        [&](int, int first, int last) {
		        cells->locate(grid, *points, first, last);
		        if (!average) return;
		        if (frontHasOwnMeans()) front->exceptFromMeans(*cells, first, last);
		        if (water) water->addPressure(*cells, first, last);
		        if (implicit) implicit->addContent(*points, *cells, *content, *water, heat ? heat->temperature : nullptr, first, last);
		        bBar.addToCells(*cells, *points, *motion, water.get(), content.get(), first, last);
	        },
	        [&](HaloExchange& rows) {
		        rows.beyond = true;
		        cells->share(rows);
		        if (average && water) water->shareCells(rows);
		        if (average && implicit) implicit->shareContent(rows);
		        bBar.share(rows);
	        });
	if (!average) return;
	cells->finish(ranks.owned());
	bBar.finish(ranks.owned(), *cells);
	if (!water) return;
	water->finishPressure(halo);
	water->findDrivingPressure(grid, halo, *cells);
}

TALIK_IN_PLANE_AND_SPACE(Ground);

} // namespace talik
