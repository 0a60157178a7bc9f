// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundParts.hpp>

namespace talik {

template <int D> void Ground<D>::Parts::sort()
{
	points->strips().parallel = points->count() >= settings.parallelFrom;
	if (bands) sortInBands();
	else {
		points->sort(grid);
		clock.range = ActiveRange::of(grid, *points);
	}
	clock.lastSort   = clock.steps;
	clock.sortWanted = 0;
	afterReordering(true);
}

template <int D> void Ground<D>::Parts::afterReordering(bool pointsMoved)
{
	if (bands) cutBands();
	if (bands && motion) followBands(pointsMoved);
	chooseRows();
	// what lies outside the active range stays zero until the next sorting
	if (bands) keepOwnPart();
	clearNodes(bands ? around.firstNode : 0, bands ? around.lastNode : grid.nodeCount());
	if (cells && !bands) cells->clearAll();
	if (water && !bands) water->clearCells(0, grid.cellCount());
	if (!motion) return;
	skeletons.list();
	positions.start(*points);
}

template <int D> void Ground<D>::Parts::clearNodes(int first, int last)
{
	if (motion) motion->nodes.clear(first, last);
	if (water) water->nodes.clear(first, last);
	if (heat) heat->clear(first, last);
	if (surface) surface->nodes.clear(first, last);
}

template <int D> void Ground<D>::Parts::clearNodes()
{
	around.overNodes([&](int, int first, int last) { clearNodes(first, last); });
}

template <int D> void Ground<D>::Parts::locateInCells()
{
	if (!cells) return;
	cells->clearVolumes(around);
	cells->clearSums(around);
	const bool average = averaging();
	if (water) water->clearCells(around.firstCell, around.lastCell);
	if (implicit) implicit->clear(around);
	bBar.clear(around);
	points->strips().scatter(
	        [&](int, int first, int last) {
		        cells->locate(grid, *points, first, last);
		        if (!average) return;
		        if (frontHasOwnMeans()) front->exceptFromMeans(*cells, first, last);
		        if (water) water->addPressure(*cells, first, last);
		        if (implicit) implicit->addContent(*points, *cells, *content, *water, *motion, heat ? heat->temperature : nullptr, first, last);
		        bBar.addToCells(*cells, *points, *motion, water.get(), content.get(), first, last);
	        },
	        [&](SharedRows& rows) {
		        rows.beyond = true;
		        cells->share(rows);
		        if (average && water) water->shareCells(rows);
		        bBar.share(rows);
	        });
	if (!average) return;
	cells->finish(reached);
	if (!water) return;
	water->finishPressure(around);
	water->findDrivingPressure(grid, around, *cells, motion->settings->gravity, liquidDensity());
}

template void Ground<2>::Parts::sort();
template void Ground<2>::Parts::afterReordering(bool);
template void Ground<2>::Parts::clearNodes();
template void Ground<2>::Parts::locateInCells();
template void Ground<3>::Parts::sort();
template void Ground<3>::Parts::afterReordering(bool);
template void Ground<3>::Parts::clearNodes();
template void Ground<3>::Parts::locateInCells();

} // namespace talik
