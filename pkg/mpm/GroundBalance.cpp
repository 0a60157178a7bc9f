// SPDX-License-Identifier: GPL-2.0-or-later
// The stress in which the ground rests at the start.
#include <pkg/mpm/GroundParts.hpp>

#include <algorithm>
#include <numeric>

namespace talik {

namespace {
	/// Of the weight, in the norm of the displacements that it would cause.
	constexpr double smallestImbalance = 1e-13;
	constexpr int    mostIterations    = 20000;

	template <int D> double product(const ActiveRange& range, const NodeField<D>& a, const NodeField<D>& b)
	{
		std::vector<double> parts(range.chunks());
		range.overNodes([&](int chunk, int first, int last) {
			for (int i = first; i < last; ++i)
				for (int k = 0; k < D; ++k)
					parts[chunk] += a[i][k] * b[i][k];
		});
		return std::accumulate(parts.begin(), parts.end(), 0.0);
	}
} // namespace

/// Forces on the nodes at rest: those of the stress that points have, gravity and loads.
template <int D> void Ground<D>::Parts::findForcesAtRest()
{
	clearNodes();
	locateInCells();
	passes.scatter(
	        passes.toGrid,
	        [&](const WeightBlock<D>& w) {
		        if (motion->addedStress) bBar.findAddedStress(averagingCells(), *points, *motion, water.get(), w.first, w.first + w.count);
		        motion->map(w);
		        if (water) water->map(w, averagingCells());
		        if (surface) surface->map(w);
	        },
	        [&](HaloExchange& rows) {
		        rows.nodes(motion->nodes);
		        if (water) rows.nodes(water->nodes);
		        if (surface) rows.nodes(surface->nodes);
	        });
	if (surface) collectSurfaces(context());
	momentum->addGravity(ranks.halo(), *motion, water.get());
	for (std::size_t b = 0; b < settings.boundaries.size(); ++b)
		if (settings.boundaries[b]->loads()) momentum->addLoad(*settings.boundaries[b], surface->patch(b), clock.calendar.time, *motion);
	momentum->forgetLoads();
}

/// Strains, with the means of cells, that displacements of the nodes are to the points; strain: by component of stress.
template <int D> void Ground<D>::Parts::findStrains(const NodeField<D>& displacement, std::array<std::vector<double>, stressSize<D>>& strain)
{
	std::vector<double> traces(grid.cellCount(), 0.0);
	const bool          average = averaging();
	points->strips().gather([&](int, int first, int last) {
		passes.overBlocks(passes.flows, first, last, [&](const WeightBlock<D>& w) {
			for (int k = 0; k < w.count; ++k) {
				double g[D][D] = {};
				overNodes<D>(w, k, [&](int node, double, const Vec<D>& slope) {
					for (int i = 0; i < D; ++i)
						for (int j = 0; j < D; ++j)
							g[i][j] += displacement[node][i] * slope[j];
				});
				const int p = w.first + k;
				for (int i = 0; i < D; ++i) {
					for (int j = i; j < D; ++j)
						strain[stressIndex<D>(i, j)][p] = 0.5 * (g[i][j] + g[j][i]);
					if (average) traces[cells->cell(p)] += points->volume()[p] * g[i][i] / cells->cellVolume(cells->cell(p));
				}
			}
		});
		for (int p = first; p < last && average; ++p) {
			double missing = traces[cells->cell(p)];
			for (int i = 0; i < D; ++i)
				missing -= strain[stressIndex<D>(i, i)][p];
			for (int i = 0; i < D; ++i)
				strain[stressIndex<D>(i, i)][p] += motion->traceShare[i] * missing;
		}
	});
}

/// The transpose: what stresses of the points are to the nodes.
template <int D> void Ground<D>::Parts::findReactions(const std::array<std::vector<double>, stressSize<D>>& stress, NodeField<D>& force)
{
	std::vector<double> means(grid.cellCount(), 0.0);
	const bool          average    = averaging();
	const auto          averagedAt = [&](int p) {
                double sum = 0.0;
                for (int i = 0; i < D; ++i)
                        sum += motion->traceShare[i] * stress[stressIndex<D>(i, i)][p];
                return sum;
	};
	points->strips().gather([&](int, int first, int last) {
		for (int p = first; p < last && average; ++p)
			means[cells->cell(p)] += points->volume()[p] * averagedAt(p) / cells->cellVolume(cells->cell(p));
	});
	ranks.halo().overNodes([&](int, int first, int last) { std::fill(force[first], force[last], 0.0); });
	passes.scatter(
	        passes.flows,
	        [&](const WeightBlock<D>& w) {
		        for (int k = 0; k < w.count; ++k) {
			        const int    p     = w.first + k;
			        const double added = average ? means[cells->cell(p)] - averagedAt(p) : 0.0;
			        overNodes<D>(w, k, [&](int node, double, const Vec<D>& slope) {
				        for (int i = 0; i < D; ++i)
					        for (int j = 0; j < D; ++j)
						        force[node][i] += points->volume()[p] * (stress[stressIndex<D>(i, j)][p] + (i == j ? added : 0.0))
						                * slope[j];
			        });
		        }
	        },
	        [&](HaloExchange& rows) { rows.nodes(force); });
}

/// Adds the smallest stress, in the mean square over the volume, with which the forces on all nodes are zero: the strain of an elastic body of
/// unit modulus whose nodes give way to them. Conjugate gradients, each node by its own stiffness.
template <int D> void Ground<D>::Parts::balanceStart()
{
	if (std::any_of(settings.boundaries.begin(), settings.boundaries.end(), [](const auto& b) { return b->usesNodes(); }))
		throw std::invalid_argument(
		        "balanceStart = true: a boundary of a script answers to steps only, and there is none yet at the start; leave balanceStart "
		        "out, or take a boundary of Talik");
	findForcesAtRest();
	const int                                      n = points->count();
	std::array<std::vector<double>, stressSize<D>> strain;
	for (auto& component : strain)
		component.assign(n, 0.0);
	NodeField<D> path, residual, direction, image, inverse, scaled, weight;
	for (auto* field : { &path, &residual, &direction, &image, &inverse, &scaled, &weight })
		field->allocate(grid.nodeCount());
	passes.scatter(
	        passes.flows,
	        [&](const WeightBlock<D>& w) {
		        for (int k = 0; k < w.count; ++k)
			        overNodes<D>(w, k, [&](int node, double, const Vec<D>& slope) {
				        for (int i = 0; i < D; ++i)
					        inverse[node][i] += points->volume()[w.first + k] * dot<D>(slope, slope);
			        });
	        },
	        [&](HaloExchange& rows) { rows.nodes(inverse); });
	const auto overAll = [&](auto&& work) {
		ranks.halo().overNodes([&](int, int first, int last) {
			for (int i = first; i < last; ++i)
				for (int a = 0; a < D; ++a)
					work(i, a);
		});
	};
	overAll([&](int i, int a) {
		const double mass = motion->nodes[i][motion->massAt] + (water ? water->nodes[i][PoreWater<D>::massAt] : 0.0);
		residual[i][a]    = motion->nodes[i][motion->forceAt + a];
		weight[i][a]      = mass * motion->settings->gravity[a];
	});
	for (auto* field : { &residual, &weight }) {
		momentum->foldForces(ranks.halo(), *field);
		momentum->holdWalls(ranks.halo(), *field);
	}
	overAll([&](int i, int a) { inverse[i][a] = inverse[i][a] > 0.0 ? 1.0 / inverse[i][a] : 0.0; });
	const auto precondition = [&](const NodeField<D>& from) {
		overAll([&](int i, int a) { scaled[i][a] = inverse[i][a] * from[i][a]; });
		return product<D>(ranks.halo(), from, scaled);
	};
	const double goal = smallestImbalance * smallestImbalance * precondition(weight);
	double       norm = precondition(residual);
	overAll([&](int i, int a) { direction[i][a] = scaled[i][a]; });
	int iterations = 0;
	for (; iterations < mostIterations && norm > goal; ++iterations) {
		momentum->unfoldChanges(ranks.halo(), direction);
		findStrains(direction, strain);
		findReactions(strain, image);
		momentum->foldForces(ranks.halo(), image);
		momentum->holdWalls(ranks.halo(), image);
		overAll([&](int i, int a) {
			if (inverse[i][a] == 0.0) image[i][a] = 0.0;
		});
		momentum->clearGhosts(ranks.halo(), direction);
		const double step = norm / product<D>(ranks.halo(), direction, image);
		overAll([&](int i, int a) {
			path[i][a] += step * direction[i][a];
			residual[i][a] -= step * image[i][a];
		});
		const double next = precondition(residual);
		overAll([&](int i, int a) { direction[i][a] = scaled[i][a] + next / norm * direction[i][a]; });
		norm = next;
	}
	if (!(norm <= goal))
		throw std::invalid_argument(
		        "balanceStart = true: there is no stress in which this ground rests; hold it by boundaries, or leave balanceStart out");
	momentum->unfoldChanges(ranks.halo(), path);
	findStrains(path, strain);
	for (int c = 0; c < stressSize<D>; ++c)
		for (int p = 0; p < n; ++p)
			motion->stress[c][p] += strain[c][p];
	clearNodes();
}

/// Of laws that take the stress of their points as it is given.
template <int D> void Ground<D>::Parts::requireBalancedStress(const std::vector<double>& vertical) const
{
	if (std::equal(vertical.begin(), vertical.end(), motion->stress[stressIndex<D>(D - 1, D - 1)])) return;
	throw std::invalid_argument(
	        "balanceStart = true: the skeleton states the stress of its points itself, as samples do; leave balanceStart out, or take a law");
}

template void Ground<2>::Parts::requireBalancedStress(const std::vector<double>&) const;
template void Ground<3>::Parts::requireBalancedStress(const std::vector<double>&) const;
template void Ground<2>::Parts::balanceStart();
template void Ground<3>::Parts::balanceStart();

} // namespace talik
