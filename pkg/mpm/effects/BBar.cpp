// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/BBar.hpp>

#include <algorithm>

namespace talik {

namespace {
	/// Of the total stress.
	template <int D> double averagedStress(const SolidMotion<D>& motion, const PoreWater<D>* water, int p)
	{
		return motion.averagedStress(p) - (water ? water->pressure[p] : 0.0);
	}
} // namespace

template <int D>
void BBar<D>::addToCells(
        CellMeans<D>& cells, const MaterialPoints<D>& points, const SolidMotion<D>& motion, const PoreWater<D>* water, const PoreContent<D>* content, int first,
        int last)
{
	const double* volume = points.volume();
	for (int p = first; p < last; ++p)
		cells.add(p, volume[p] * averagedStress(motion, water, p));
	addWeights(cells, points, motion, water, content, first, last);
}

template <int D>
void BBar<D>::addWeights(
        const CellMeans<D>& cells, const MaterialPoints<D>& points, const SolidMotion<D>& motion, const PoreWater<D>* water, const PoreContent<D>* content,
        int first, int last)
{
	const Vec<D> g      = motion.settings->gravity;
	const double square = dot<D>(g, g);
	for (int p = first; p < last; ++p) {
		Weight&      cell   = weights_[cells.cell(p)];
		const double volume = points.volume()[p];
		double       along  = water ? -water->pressure[p] : 0.0;
		for (int i = 0; i < D; ++i) {
			cell.place[i] += volume * points.position(i)[p];
			for (int j = 0; j < D && square > 0.0; ++j)
				along += g[i] * g[j] / square * motion.stress[stressIndex<D>(i, j)][p];
		}
		cell.along += volume * along;
		cell.mass += motion.mass[p] + (water ? content->liquidMass(p) : 0.0);
	}
}

/// What the weight of a cell adds to its mean stress at a point, by the ratio of the mean to the stress along gravity. It does not turn the sign of
/// the mean: ground that nothing carries has none.
template <int D> double BBar<D>::stressOfWeight(const CellMeans<D>& cells, const MaterialPoints<D>& points, const Vec<D>& gravity, int p, double mean) const
{
	const Weight& cell   = weights_[cells.cell(p)];
	const double  volume = cells.cellVolume(cells.cell(p)), along = cell.along / volume;
	if (!(mean < 0.0 && along < 0.0)) return 0.0;
	double below = 0.0;
	for (int a = 0; a < D; ++a)
		below += gravity[a] * (points.position(a)[p] - cell.place[a] / volume);
	const double added = -std::min(1.0, mean / along) * cell.mass / volume * below;
	return std::clamp(added, mean, -mean);
}

template <int D>
void BBar<D>::findAddedStress(
        const CellMeans<D>* cells, const MaterialPoints<D>& points, SolidMotion<D>& motion, const PoreWater<D>* water, int first, int last) const
{
	for (int p = first; p < last; ++p) {
		const double own      = averagedStress(motion, water, p);
		const double mean     = cells ? cells->mean(p, own) : own;
		motion.addedStress[p] = mean - motion.averagedStress(p);
		if (cells) motion.addedStress[p] += stressOfWeight(*cells, points, motion.settings->gravity, p, mean);
	}
}

template <int D> void BBar<D>::addDivergence(CellMeans<D>& cells, const MaterialPoints<D>& points, const SolidMotion<D>& motion, const WeightBlock<D>& w)
{
	const double* volume = points.volume();
	for (int p = w.first; p < w.first + w.count; ++p) {
		double trace = motion.gradient[0][p];
		for (int a = 1; a < D; ++a)
			trace += motion.gradient[a * D + a][p];
		cells.add(p, volume[p] * trace);
	}
}

template <int D> void BBar<D>::replaceTraces(const CellMeans<D>& cells, SolidMotion<D>& motion, int first, int last)
{
	const std::array<double*, D* D> g     = motion.gradient;
	const CellMeans<D>&             means = cells;
	const Vec<D>                    share = motion.traceShare;
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

template <int D> void BBar<D>::strain(const CellMeans<D>* cells, MaterialPoints<D>& points, SolidMotion<D>& motion, int first, int last)
{
	if (cells) replaceTraces(*cells, motion, first, last);
	stretchVolumes(points, motion, first, last);
}

TALIK_IN_PLANE_AND_SPACE(BBar);

} // namespace talik
