// SPDX-License-Identifier: GPL-2.0-or-later
#include "ReferenceLoops.hpp"

#include <pkg/mpm/grid/ShapeFunctions.hpp>

#include <algorithm>

namespace talik {

namespace {

	template <int D> using Tensor = std::array<Vec<D>, D>;

	/// Stress of a point, with addedStress on its diagonal unless that is null.
	template <int D> Tensor<D> stressOf(const typename NodeLoops<D>::MotionMap& a, int p)
	{
		const double added = a.addedStress ? a.addedStress[p] : 0.0;
		Tensor<D>    stress;
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D; ++j)
				stress[i][j] = a.stress[stressIndex<D>(i, j)][p] + (i == j ? added : 0.0);
		return stress;
	}

	template <int D> void mapMotion(const WeightBlock<D>& w, const typename NodeLoops<D>::MotionMap& a)
	{
		using Moving = typename NodeColumns<D>::Moving;
		for (int k = 0; k < w.count; ++k) {
			const int       p        = w.first + k;
			const Tensor<D> stress   = stressOf<D>(a, p);
			const double    capacity = a.capacity ? a.capacity[p] : 0.0;
			overNodes<D>(w, k, [&](int node, double s, const Vec<D>& g) {
				double* r = a.nodes + long(node) * Moving::size;
				r[Moving::mass] += s * a.mass[p];
				for (int i = 0; i < D; ++i) {
					r[Moving::momentum + i] += s * a.mass[p] * a.velocity[i][p];
					r[Moving::force + i] -= a.volume[p] * dot<D>(stress[i], g);
				}
				if (!a.capacity) return;
				r[Moving::capacity] += s * capacity;
				r[Moving::heat] += s * capacity * (a.carried[p] - a.carriedFrom);
			});
		}
	}

	template <int D> void gatherMotion(const WeightBlock<D>& w, const typename NodeLoops<D>::MotionGather& a)
	{
		using Solved = typename NodeColumns<D>::Solved;
		for (int k = 0; k < w.count; ++k) {
			const int p = w.first + k;
			Vec<D>    change {}, v {};
			Tensor<D> gradient {};
			double    increment = 0.0;
			overNodes<D>(w, k, [&](int node, double s, const Vec<D>& g) {
				const double* r = a.nodes + long(node) * Solved::size;
				if (a.increment) increment += s * r[Solved::increment];
				for (int i = 0; i < D; ++i) {
					change[i] += s * r[Solved::change + i];
					v[i] += s * r[Solved::velocity + i];
					for (int j = 0; j < D; ++j)
						gradient[i][j] += g[j] * r[Solved::velocity + i];
				}
			});
			if (a.increment) a.increment[k] = increment;
			for (int i = 0; i < D; ++i) {
				a.velocity[i][p] = a.kept * a.velocity[i][p] + change[i];
				a.position[i][p] += a.dt * v[i];
				a.displacement[i][p] += a.dt * v[i];
				for (int j = 0; j < D; ++j)
					a.gradient[i * D + j][p] = a.dt * gradient[i][j];
			}
		}
	}

	template <int D, int n> void mapRecords(const WeightBlock<D>& w, const double (&values)[n][blockSize], double* nodes)
	{
		for (int k = 0; k < w.count; ++k)
			overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) {
				for (int i = 0; i < n; ++i)
					nodes[long(node) * n + i] += s * values[i][k];
			});
	}

	template <int D, int n> void gatherRecords(const WeightBlock<D>& w, const double* nodes, double (&sums)[n][blockSize])
	{
		for (int k = 0; k < w.count; ++k) {
			for (int i = 0; i < n; ++i)
				sums[i][k] = 0.0;
			overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) {
				for (int i = 0; i < n; ++i)
					sums[i][k] += s * nodes[long(node) * n + i];
			});
		}
	}

	template <int D> void gatherNumber(const WeightBlock<D>& w, const double* nodes, double (&sums)[blockSize])
	{
		double list[1][blockSize];
		gatherRecords<D, 1>(w, nodes, list);
		for (int k = 0; k < w.count; ++k)
			sums[k] = list[0][k];
	}

	template <int D> void mapSurface(const WeightBlock<D>& w, const double* volume, const double* conductivity, double* nodes)
	{
		using Surface = typename NodeColumns<D>::Surface;
		for (int k = 0; k < w.count; ++k) {
			const double v     = volume[w.first + k];
			const double kappa = conductivity ? conductivity[w.first + k] : 0.0;
			overNodes<D>(w, k, [&](int node, double s, const Vec<D>& g) {
				double* r = nodes + long(node) * Surface::size;
				for (int i = 0; i < D; ++i)
					r[Surface::area + i] += v * g[i];
				r[Surface::volume] += s * v;
				r[Surface::conduction] += s * v * kappa;
			});
		}
	}

	/// One number of the nodes' records and where the flow that its gradient drives goes.
	struct Field {
		const double* from;
		int           fromSize;
		double*       to;
		int           toSize;

		double  at(int node) const { return from[long(node) * fromSize]; }
		double* flowAt(int node) const { return to + long(node) * toSize; }
	};

	/// Value and slope of a field at point k of a block.
	template <int D> double evaluate(const WeightBlock<D>& w, int k, const Field& field, Vec<D>& slope)
	{
		double value = 0.0;
		slope        = {};
		overNodes<D>(w, k, [&](int node, double s, const Vec<D>& g) {
			value += s * field.at(node);
			for (int a = 0; a < D; ++a)
				slope[a] += g[a] * field.at(node);
		});
		return value;
	}

	/// Adds heat and, in the next column, what the grid does not see.
	template <int D> void conduct(const WeightBlock<D>& w, const typename NodeLoops<D>::HeatFlow& h, const Field& field)
	{
		for (int k = 0; k < w.count; ++k) {
			const int    p = w.first + k;
			Vec<D>       slope;
			const double temperature = evaluate<D>(w, k, field, slope),
			             nullSpace   = h.capacity[p] * (temperature - (h.temperature[p] - h.reference));
			const double conductance = h.volume[p] * h.conductivity[p] * h.duration;
			overNodes<D>(w, k, [&](int node, double s, const Vec<D>& g) {
				field.flowAt(node)[0] += s * h.volume[p] * h.produced - conductance * dot<D>(slope, g);
				field.flowAt(node)[1] += s * nullSpace;
			});
		}
	}

	template <int D> void flowHeat(const WeightBlock<D>& w, const typename NodeLoops<D>::HeatFlow& h, const double* temperature, double* conducted)
	{
		conduct<D>(w, h, { temperature, 1, conducted, NodeColumns<D>::Conducted::size });
	}

	template <int D> void flowPressure(const WeightBlock<D>& w, const double* volume, const double* driving, double* driven)
	{
		using Driving = typename NodeColumns<D>::Driving;
		using Driven  = typename NodeColumns<D>::Driven;
		const Field pressure { driving + Driving::pressure, Driving::size, driven + Driven::force, Driven::size };
		for (int k = 0; k < w.count; ++k) {
			Vec<D> slope;
			evaluate<D>(w, k, pressure, slope);
			overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) {
				for (int i = 0; i < D; ++i)
					pressure.flowAt(node)[i] += s * volume[w.first + k] * slope[i];
			});
		}
	}

	template <int D> void flowHeatAndPressure(const WeightBlock<D>& w, const typename NodeLoops<D>::HeatFlow& h, const double* driving, double* driven)
	{
		using Driving = typename NodeColumns<D>::Driving;
		using Driven  = typename NodeColumns<D>::Driven;
		flowPressure<D>(w, h.volume, driving, driven);
		conduct<D>(w, h, { driving + Driving::temperature, Driving::size, driven + Driven::heat, Driven::size });
	}

	template <int D> void seep(const WeightBlock<D>& w, const typename NodeLoops<D>::Seepage& s)
	{
		using Flux     = typename NodeColumns<D>::Flux;
		using Gathered = typename NodeColumns<D>::Gathered;
		for (int k = 0; k < w.count; ++k) {
			const int p = w.first + k;
			Vec<D>    q {};
			overNodes<D>(w, k, [&](int node, double weight, const Vec<D>&) {
				for (int i = 0; i < D; ++i)
					q[i] += weight * s.flux[long(node) * Flux::size + i];
			});
			const double scale = s.massPerFlux * s.volume[p];
			const double heat  = s.temperature ? s.specificHeat * s.temperature[p] + s.enthalpyAtZero : 0.0;
			overNodes<D>(w, k, [&](int node, double, const Vec<D>& g) {
				const double mass = scale * dot<D>(q, g);
				double*      r    = s.exchange + long(node) * Gathered::size;
				r[Gathered::water] += mass;
				r[Gathered::enthalpy] += heat * mass;
				for (int i = 0; i < D; ++i)
					r[Gathered::momentum + i] += s.velocity[i][p] * mass;
			});
		}
	}

	template <class Numbers, int D>
	void mapSome(
	        const WeightBlock<D>& w, const typename NodeLoops<D>::template Shares<Numbers>& shares,
	        const typename NodeLoops<D>::template SparseRecords<double>& records)
	{
		for (int k = 0; k < shares.count; ++k) {
			const auto& share = shares.of[k];
			overNodes<D>(w, share.point, [&](int node, double s, const Vec<D>& g) {
				if (records.slot[node] < 0) return;
				double* r = records.first + long(records.slot[node]) * records.size + Numbers::at;
				for (int i = 0; i < Numbers::size; ++i)
					r[i] += s * share.value[i];
				for (int i = Numbers::straight; i < Numbers::size; ++i)
					for (int a = 0; a < D; ++a)
						r[i] += g[a] * share.slope[a][i - Numbers::straight];
			});
		}
	}

	/// Adds S numbers [first, first + n) of the records of the support.
	template <int D>
	void addSome(const WeightBlock<D>& w, int k, const typename NodeLoops<D>::template SparseRecords<const double>& records, int first, int n, double* sums)
	{
		std::fill(sums, sums + n, 0.0);
		overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) {
			for (int i = 0; i < n && records.slot[node] >= 0; ++i)
				sums[i] += s * records.first[long(records.slot[node]) * records.size + first + i];
		});
	}

	template <int D>
	void gatherSide(
	        const WeightBlock<D>& w, int k, const typename NodeLoops<D>::template SparseRecords<const double>& records, int first,
	        typename NodeLoops<D>::FrontSums& sums)
	{
		using Side = typename NodeColumns<D>::Side;
		addSome<D>(w, k, records, first, Side::size, sums.side);
		for (auto& along : sums.gradient)
			std::fill(along, along + 4, 0.0);
		overNodes<D>(w, k, [&](int node, double, const Vec<D>& g) {
			for (int a = 0; a < D && records.slot[node] >= 0; ++a)
				for (int i = 0; i < 4; ++i)
					sums.gradient[a][i] += g[a] * records.first[long(records.slot[node]) * records.size + first + Side::velocity + i];
		});
	}

	template <int D>
	void gatherFrozen(
	        const WeightBlock<D>& w, int k, const typename NodeLoops<D>::template SparseRecords<const double>& records,
	        typename NodeLoops<D>::FrontSums& sums)
	{
		gatherSide<D>(w, k, records, 0, sums);
	}

	template <int D>
	void gatherThawed(
	        const WeightBlock<D>& w, int k, const typename NodeLoops<D>::template SparseRecords<const double>& records,
	        typename NodeLoops<D>::FrontSums& sums)
	{
		using C = NodeColumns<D>;
		gatherSide<D>(w, k, records, C::Side::size, sums);
		addSome<D>(w, k, records, C::Slip::at, C::Slip::size, sums.slip);
	}

} // namespace

template <int D> const NodeLoops<D>& referenceLoops()
{
	using Columns = NodeColumns<D>;
	static const NodeLoops<D> loops { "reference",
		                          false,
		                          &mapMotion<D>,
		                          &gatherMotion<D>,
		                          &mapRecords<D, Columns::Liquid::size>,
		                          &mapRecords<D, 2>,
		                          &gatherRecords<D, Columns::Gathered::size>,
		                          &gatherNumber<D>,
		                          &mapSurface<D>,
		                          &flowHeat<D>,
		                          &flowPressure<D>,
		                          &flowHeatAndPressure<D>,
		                          &seep<D>,
		                          &mapSome<typename Columns::Frozen, D>,
		                          &mapSome<typename Columns::Thawed, D>,
		                          &mapSome<typename Columns::Pores, D>,
		                          &gatherFrozen<D>,
		                          &gatherThawed<D> };
	return loops;
}

template const NodeLoops<2>& referenceLoops<2>();
template const NodeLoops<3>& referenceLoops<3>();

} // namespace talik
