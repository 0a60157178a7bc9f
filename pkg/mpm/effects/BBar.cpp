// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/BBar.hpp>

#include <algorithm>

namespace talik {

template <int D>
void BBar<D>::addToCells(
        CellMeans<D>& cells, const MaterialPoints<D>& points, const SolidMotion<D>& motion, const PoreWater<D>* water, const PoreContent<D>* content, int first,
        int last)
{
	const Vec<D>                       g      = motion.settings->gravity;
	const Vec<3>                       share  = motion.traceShare;
	const double                       square = dot<D>(g, g);
	const std::array<const double*, D> x      = points.positions();
	const auto                         stress = motion.stress;
	const double *const mass = motion.mass, *const volume = points.volume(), *const pressure = water ? water->pressure : nullptr;
	double part[stressSize<D>] = {}; // of the components in the stress along gravity
	for (int i = 0; i < D && square > 0.0; ++i)
		for (int j = 0; j < D; ++j)
			part[stressIndex<D>(i, j)] += g[i] * g[j] / square;
	motion.overDirect([&](auto direct) {
		for (int p = first; p < last; ++p) {
			double along = pressure ? -pressure[p] : 0.0, mean = along, depth = 0.0;
			for (int k = 0; k < stressSize<D>; ++k)
				along += part[k] * stress[k][p];
			for (int a = 0; a < D; ++a) {
				mean += share[a] * stress[a][p];
				depth += g[a] * x[a][p];
			}
			if constexpr (direct > D) mean += share[2] * stress[2][p];
			cells.add(p, volume[p] * mean);
			Weight& cell = weights_[cells.cell(p)];
			cell.depth += volume[p] * depth;
			cell.along += volume[p] * along;
			cell.mass += mass[p] + (water ? content->liquidMass(p) : 0.0);
		}
	});
}

template <int D> void BBar<D>::finish(const ActiveRange& range, const CellMeans<D>& cells)
{
	range.overCells([&](int first, int last) {
		for (int c = first; c < last; ++c) {
			Weight&      cell   = weights_[c];
			const double volume = cells.cellVolume(c), mean = cells.cellMean(c);
			const bool   bears = mean < 0.0 && cell.along < 0.0;
			cell.mass          = bears ? std::min(1.0, mean * volume / cell.along) * cell.mass / volume : 0.0;
			cell.depth         = bears ? cell.depth / volume : 0.0;
		}
	});
}

/// The weight of a cell does not turn the sign of its mean: ground that nothing carries has none.
template <int D>
void BBar<D>::findAddedStress(
        const CellMeans<D>* cells, const MaterialPoints<D>& points, SolidMotion<D>& motion, const PoreWater<D>* water, int first, int last) const
{
	const Vec<D>                       g        = motion.settings->gravity;
	const Vec<3>                       share    = motion.traceShare;
	const std::array<const double*, D> x        = points.positions();
	const auto                         stress   = motion.stress;
	const double* const                pressure = water ? water->pressure : nullptr;
	double* const                      added    = motion.addedStress;
	motion.overDirect([&](auto direct) {
		for (int p = first; p < last; ++p) {
			double solid = 0.0;
			for (int a = 0; a < direct; ++a)
				solid += share[a] * stress[a][p];
			const double own = solid - (pressure ? pressure[p] : 0.0);
			added[p]         = (cells ? cells->mean(p, own) : own) - solid;
			if (!cells) continue;
			const Weight& cell  = weights_[cells->cell(p)];
			double        below = -cell.depth;
			for (int a = 0; a < D; ++a)
				below += g[a] * x[a][p];
			const double most = std::max(0.0, -(added[p] + solid));
			added[p] += std::clamp(-cell.mass * below, -most, most);
		}
	});
}

template <int D> void BBar<D>::addDivergence(CellMeans<D>& cells, const MaterialPoints<D>& points, const SolidMotion<D>& motion, const WeightBlock<D>& w)
{
	const double* volume = points.volume();
	motion.overDirect([&](auto direct) {
		for (int p = w.first; p < w.first + w.count; ++p) {
			double trace = motion.direct[0][p];
			for (int a = 1; a < direct; ++a)
				trace += motion.direct[a][p];
			cells.add(p, volume[p] * trace);
		}
	});
}

template <int D> void BBar<D>::replaceTraces(const CellMeans<D>& cells, SolidMotion<D>& motion, int first, int last)
{
	const std::array<double*, D* D> g     = motion.gradient;
	const CellMeans<D>&             means = cells;
	const Vec<3>                    share = motion.traceShare;
#pragma GCC ivdep
	for (int p = first; p < last; ++p) {
		double trace = g[0][p];
		for (int a = 1; a < D; ++a)
			trace += g[a * D + a][p];
		const double missing = means.mean(p, trace) - trace;
		for (int a = 0; a < D; ++a)
			g[a * D + a][p] += missing * share[a];
	}
}

template <int D> void BBar<D>::stretchVolumes(MaterialPoints<D>& points, const SolidMotion<D>& motion, int first, int last)
{
	const std::array<double*, D* D> g      = motion.gradient;
	double* const                   volume = points.volume();
#pragma GCC ivdep
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

template <int D> void BBar<D>::strainAboutAxis(const CellMeans<D>* cells, MaterialPoints<D>& points, SolidMotion<D>& motion, int first, int last)
{
	for (int p = first; p < last; ++p) {
		const double trace = motion.direct[0][p] + motion.direct[1][p] + motion.hoop[p], missing = cells ? cells->mean(p, trace) - trace : 0.0;
		for (int a = 0; a < 3; ++a)
			motion.direct[a][p] += missing * motion.traceShare[a];
		points.volume()[p] *= 1.0 + motion.hoop[p];
	}
	stretchVolumes(points, motion, first, last);
}

template <int D> void BBar<D>::strain(const CellMeans<D>* cells, MaterialPoints<D>& points, SolidMotion<D>& motion, int first, int last)
{
	if (motion.hoop) return strainAboutAxis(cells, points, motion, first, last);
	if (cells) replaceTraces(*cells, motion, first, last);
	stretchVolumes(points, motion, first, last);
}

TALIK_IN_PLANE_AND_SPACE(BBar);

} // namespace talik
