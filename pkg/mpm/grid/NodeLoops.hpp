// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/NodeColumns.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>

#include <vector>

namespace talik {

/// The inner loops between the points of a block and the nodes of their support, in the plane and in space. There is a vector version for each
/// kind of processor, from one source, and for the tests a reference that is written to be read (tests/unit/ReferenceLoops.cpp). Versions for
/// processors that multiply and add in one rounding (all since 2013) give the same bits, and so do those that round twice; the reference differs
/// by round-off. Arrays of
/// points are whole arrays, indexed by place; arrays of nodes begin at node 0 and have the records of NodeColumns.
template <int D> struct NodeLoops {
	using Columns                 = NodeColumns<D>;
	template <int n> using Values = double[n][blockSize]; ///< number i of point k of a block at [i][k]

	const char* name;
	bool        roundsOnce; ///< multiplies and adds in one rounding

	/// Mass, momentum and internal force, eq. (8.1), to records Moving.
	struct MotionMap {
		const double *                           mass, *volume;
		const double*                            addedStress; ///< to the diagonal of the stress; may be null
		std::array<const double*, D>             velocity;
		std::array<const double*, stressSize<D>> stress;
		const double *                           capacity,
		        *carried;    ///< of a quantity mapped along, capacity and capacity times carried; may be null; only where Moving carries heat
		double  carriedFrom; ///< carried counts from here
		double* nodes;
	};
	void (*mapMotion)(const WeightBlock<D>& w, const MotionMap& a);

	/// Velocity, position, displacement and displacement gradient, eq. (8.3), from records Solved.
	struct MotionGather {
		const double*              nodes;
		std::array<double*, D>     velocity, position, displacement;
		std::array<double*, D * D> gradient;
		double                     kept, dt;
		double*                    increment; ///< sum S of column increment by point of the block; may be null; only where Solved carries it
	};
	void (*gatherMotion)(const WeightBlock<D>& w, const MotionGather& a);

	/// Adds S values to records Liquid.
	void (*mapLiquid)(const WeightBlock<D>& w, const Values<Columns::Liquid::size>& values, double* nodes);
	/// Adds S values to records of two numbers.
	void (*mapPair)(const WeightBlock<D>& w, const Values<2>& values, double* nodes);
	/// Sums S record of Gathered.
	void (*gatherExchange)(const WeightBlock<D>& w, const double* nodes, Values<Columns::Gathered::size>& sums);
	/// Sums S number.
	void (*gatherNumber)(const WeightBlock<D>& w, const double* nodes, double (&sums)[blockSize]);

	/// V grad S, S V and S V conductivity (null: zero) to records Surface.
	void (*mapSurface)(const WeightBlock<D>& w, const double* volume, const double* conductivity, double* nodes);

	/// Conduction in a step, eq. (9.4), temperatures of nodes relative to that of reference: heat -V kappa duration grad T . grad S +
	/// V produced S, and what the grid does not see, C (T_grid - T) S.
	struct HeatFlow {
		const double *volume, *conductivity, *capacity, *temperature;
		double        duration, produced, reference;
	};
	/// From one number T to records Conducted.
	void (*flowHeat)(const WeightBlock<D>& w, const HeatFlow& h, const double* temperature, double* conducted);
	/// sum V S grad p, from records Driving to Driven.
	void (*flowPressure)(const WeightBlock<D>& w, const double* volume, const double* driving, double* driven);
	/// Both, from records Driving to Driven.
	void (*flowHeatAndPressure)(const WeightBlock<D>& w, const HeatFlow& h, const double* driving, double* driven);

	/// Mass that flows, eq. (7.3), with its enthalpy and momentum, from records Flux to the first numbers of Gathered.
	struct Seepage {
		const double*                flux;
		const double*                volume;
		std::array<const double*, D> velocity;    ///< of the liquid
		const double*                temperature; ///< null: the water carries no enthalpy
		double                       massPerFlux, specificHeat, enthalpyAtZero;
		double*                      exchange;
	};
	void (*seep)(const WeightBlock<D>& w, const Seepage& s);

	/// Records of size numbers that some nodes have: slot[node] is the place of that of a node, or -1.
	template <class Number> struct SparseRecords {
		const int* slot;
		Number*    first;
		int        size;
	};
	/// What some points of a block, in its order, bring to the numbers Numbers of such records: S value, and dS/dx_a slope[a] to those that
	/// take slopes.
	template <class Numbers> struct Shares {
		struct Share {
			int    point; ///< in the block
			double value[Numbers::size];
			double slope[D][Numbers::size > Numbers::straight ? Numbers::size - Numbers::straight : 1];
		};
		int    count = 0;
		Share  of[blockSize];
		Share& next(int point)
		{
			of[count]       = {};
			of[count].point = point;
			return of[count++];
		}
	};
	void (*mapFrozen)(const WeightBlock<D>& w, const Shares<typename Columns::Frozen>& shares, const SparseRecords<double>& records);
	void (*mapThawed)(const WeightBlock<D>& w, const Shares<typename Columns::Thawed>& shares, const SparseRecords<double>& records);
	void (*mapPores)(const WeightBlock<D>& w, const Shares<typename Columns::Pores>& shares, const SparseRecords<double>& records);

	/// What one point gathers from records Side and Slip.
	struct FrontSums {
		double side[Columns::Side::size];
		double gradient[D][4]; ///< of velocity component i along axis a at [a][i]
		double slip[Columns::Slip::size];
	};
	/// Sums of point k of a block on the frozen side: side and gradient. On the thawed side slip too.
	void (*gatherFrozen)(const WeightBlock<D>& w, int k, const SparseRecords<const double>& records, FrontSums& sums);
	void (*gatherThawed)(const WeightBlock<D>& w, int k, const SparseRecords<const double>& records, FrontSums& sums);
};

/// The loops that all ground uses: the vector version for this processor, unless others were chosen.
template <int D> const NodeLoops<D>& nodeLoops();
/// All ground of dimension D uses these from now on; they must live as long. For tests.
template <int D> void chooseNodeLoops(const NodeLoops<D>& loops);

/// All vector versions that this processor can run.
template <int D> std::vector<const NodeLoops<D>*> vectorLoops();
/// The best of them.
template <int D> const NodeLoops<D>& bestVectorLoops();

} // namespace talik
