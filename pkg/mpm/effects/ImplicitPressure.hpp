// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/PagedArray.hpp>
#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/mpm/effects/FreeSurface.hpp>
#include <pkg/mpm/effects/MomentumSolver.hpp>
#include <pkg/mpm/effects/PoreContent.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/PressureMultigrid.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/points/CellMeans.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <array>
#include <vector>

namespace talik {

/// Pore pressure of all cells at the end of a step at once, so that neither the stiffness of water nor its conductivity limits the step.
///
/// Water has the inertia of the ground that it flows through, and none relative to it (the u-p form, Zienkiewicz et al. 1980): the nodes have one
/// velocity v of grains and water. They are solved with the pressure of the start. Then the change x of the pressure of the cells follows from
///   (C + dt B A B' + dt L + S) x = e + inflow - dt B v - C p
/// with the compliance C of what fills the pores, the divergence B of the points of a cell and its transpose B', the response A = dt/(m_s + m_l) of
/// the nodes to a force, the flow L between the middles of cells (Darcy, with the mobility of both halves of the way), and a share S of the
/// storage that nodes do not see, eq. (7.8). Velocities take A B' x, water flows between cells by L. So the masses and the pore volume of the
/// end fit the pressure, but for what is left over: ice that forms or thaws within the step, and rounding. That part is in e of the next step.
template <int D> class ImplicitPressure {
public:
	explicit ImplicitPressure(PointFields& fields);
	void bind(MaterialPoints<D>& points, const std::array<double*, D>& solidVelocity);
	/// fed: a boundary gives water to nodes.
	void allocate(const Grid<D>& grid, bool fed);
	bool isFed() const { return fed_; }
	void clear(const ActiveRange& range);
	/// Only nodes and cells of this part are used from now on; all others are zero and take no memory.
	void keepOnly(const ActiveRange& range, int firstPoint, int endPoint);
	/// What points add to their cells in addContent() and in map().
	void shareContent(HaloExchange& rows) { rows.cells(cells_.data()); }
	void shareLiquids(HaloExchange& rows) { rows.cells(reinterpret_cast<std::array<double, corners>*>(liquids_.data())); }
	/// What points bring to their cells; call within MaterialPoints::strips().scatter. temperature may be null.
	void addContent(
	        const MaterialPoints<D>& points, const CellMeans<D>& cells, const PoreContent<D>& content, const PoreWater<D>& water, const double* temperature,
	        int first, int last);
	/// The liquid that the nodes share, in ground that is fed.
	void map(const WeightBlock<D>& w, const CellMeans<D>& cells, const PoreContent<D>& content);
	/// The divergence of each cell by its nodes: not that of its points, whose sums are as far from the integral as they do not lie evenly, but of 2^D
	/// places in the middles of the halves of its ground. Forces of one pressure then add up to nothing within the ground.
	void findLinks(const StepContext<D>& step, const CellMeans<D>& cells, const ShapeFunction<D>& shape, const PoreWater<D>& water);

	/// The liquid of the nodes moves with their grains: its drag leaves no difference by the end of the step. Before nodes are solved.
	static void tieLiquid(const StepContext<D>& step, PoreWater<D>& water);
	/// Means of the cells and conductances between them, when nodes are solved.
	void beginFlow(const StepContext<D>& step, const PoreWater<D>& water);
	/// Faces of the surface of the ground through which water flows to a pressure outside [Pa].
	void drain(const StepContext<D>& step, const SurfacePatch<D>& patch, double outside, bool recharges);
	/// Solves for the pressure, and corrects the velocities of the nodes.
	void solve(const StepContext<D>& step, MomentumSolver<D>& momentum, SolidMotion<D>& motion, PoreWater<D>& water);
	/// What the flow between cells loses by drag.
	void bookDissipation(const StepContext<D>& step) const;
	/// Adds what flows to the exchange of the cells.
	void exchange(const StepContext<D>& step, PoreWater<D>& water);
	/// Seepage velocity of points, by what flowed between cells, and the acceleration of their ground as water feels it: its mean over the time
	/// m_l/Q in which drag brings water to rest in the ground, eq. (7.11).
	void giveToPoints(const CellMeans<D>& cells, double dt, int first, int last);
	/// The pressure of the cells, for their points.
	void givePressure(const ActiveRange& range, PoreWater<D>& water) const;

	std::array<double*, D> seepage; ///< by point: velocity of the liquid relative to the grains, mean over its cell and the last step [m/s]

private:
	using Multigrid              = PressureMultigrid<D>;
	static constexpr int corners = D == 2 ? 16 : 64; ///< nodes that the points of a cell reach
	static constexpr int inRow   = 4 * D;            ///< numbers of a row of four nodes, which follow each other in memory
	/// Sums over the points of a cell, and means of them once the flow begins.
	struct Cell {
		double liquidMass, drag, excess, compliance, pressure, temperature;
		Vec<D> carried;
		Vec<D> place;           ///< of the liquid [m]
		Vec<D> weight;          ///< of water in ground that accelerates, rho_l (b - a) [N/m^3]
		double recent;          ///< share of this step in the acceleration that water feels
		double open, opensWell; ///< sum V times the mobility of each point, of layers beside each other; and times its square
		double layer;           ///< mobility of the way out of a layer that is open
		double ice;             ///< [kg]
		double thawed;          ///< as open, with all ice melted
		double part;            ///< of it that has thawed as a layer on one side, see thawedPart(); 0: none
		double volume, mobility, fill, base, drivingExcess; ///< base: pressure from which x counts [Pa]
		double ofPlane;                                     ///< about an axis the volume without the radius, else the same
		Vec<D> middle;                                      ///< of its ground: sum of ofPlane x; then from the middle of the cell, in spacings
		double drained, drives; ///< conductance of its drained faces [m^D/(Pa s)], and the flow that they let out at p = 0 [m^D/s]
		double out;             ///< volume that leaves through them in the step [m^D]
		Vec<D> leaves;          ///< their conductances, along their outward normals [m^D/(Pa s)]
		double flows[D];        ///< seepage velocity [m/s]
		int    state;           ///< see State
	};
	enum State { none, wet, cavitated };
	/// Between a cell and the next one along an axis.
	struct Face {
		double covered;     ///< part of it that ground covers on both sides [-]
		double conductance; ///< [m^D/(Pa s)]
		double weight;      ///< pressure by which gravity drives [Pa]
		double moved;       ///< volume that flows in the step [m^D]
	};
	double*       link(int cell) { return links_.data() + std::size_t(cell) * corners * D; }
	const double* link(int cell) const { return links_.data() + std::size_t(cell) * corners * D; }
	bool          hasNext(const ActiveRange& range, int cell, int axis) const { return next_[axis][cell] >= 0 && next_[axis][cell] < range.lastCell; }
	void          linkCell(int cell, const WeightBlock<D>& w, int k, const double (&parts)[D][blockSize], const double* radius, const PoreWater<D>& water);
	double        filledBy(int cell) const { return cells_[cell].ofPlane / grid_->cellVolume(); } ///< of a cell [-]
	void          foldLinks(int cell, const double* volumes, const PoreWater<D>& water);
	/// Place of a node among the corners of a cell.
	int           cornerOf(int cell, int node) const;
	static double weightBetween(const Cell& from, const Cell& to, int axis, double farther);
	static double wayFrom(const Cell& cell, const Cell& neighbour);
	int           wetCell(const ActiveRange& range, int cell, int axis, int by) const;
	double        thawedPart(const ActiveRange& range, int cell, int axis, int side) const;
	void          findLayers(const ActiveRange& range);
	void          findMiddle(int cell);
	double        section(const Cell& cell, int axis, int side) const;
	double        coveredAt(const ActiveRange& range, int cell, int axis, int side) const;
	void          findFaces(const ActiveRange& range);
	/// Surface of the ground in a cell: its area vector over the area of a face, and how far it lies from the middle of the ground, in spacings.
	struct Surface {
		Vec<D> area;
		double distance;
	};
	Surface                    surfaceIn(const ActiveRange& range, int cell) const;
	double                     openAt(int cell, const Vec<D>& outward) const;
	void                       drainThrough(int cell, double area, double distance, const Vec<D>& outward, double outside, bool recharges);
	template <class Work> void overCorners(int cell, Work&& work) const;
	/// Force of pressures on the nodes.
	void                          forces(const ActiveRange& range, const double* x, NodeField<D>& force) const;
	TALIK_PROCESSOR_VERSIONS void push(int first, int last, const double* x, NodeField<D>& force) const;
	/// sum B v of cells with water, of velocities that follow each other in memory.
	TALIK_PROCESSOR_VERSIONS void divergence(int first, int last, const NodeField<D>& values, double* sums) const;
	/// y of the cells of this rank, from x of those around them, too.
	void                           apply(const StepContext<D>& step, const MomentumSolver<D>& momentum, const double* x, double* y);
	int                            cellsOfRow() const { return grid_->cellStride(grid_->slowAxis()); }
	template <class Drives> double flowOut(int cell, double out, Drives&& drives) const;
	double                         checkerboard(int cell, const double* x) const;
	double                         hourglass(int cell, int pair, int a, int b, const double* x) const;
	void                           findSquares(const ActiveRange& range);
	void                           findResiduals(const StepContext<D>& step, SolidMotion<D>& motion, const PoreWater<D>& water);
	double                         movedAcross(int cell, int axis) const;
	void                           findSeepage(const ActiveRange& range, double dt, double liquidDensity);
	void                           findPreconditioner(const StepContext<D>& step, const MomentumSolver<D>& momentum);
	/// Temperature of the water that a cell gives to the next one along an axis (step 1) or to the one before (-1): second order where it changes
	/// evenly, and never beyond both cells [degC].
	double                        givenTemperature(const ActiveRange& range, int cell, int axis, int step) const;
	template <class Work> double  sumOfStrips(const StepContext<D>& step, Work&& ofStrip);
	template <class Value> double sum(const StepContext<D>& step, Value&& value);
	template <class Value> double sumOfNodes(const StepContext<D>& step, Value&& value);
	void                          iterate(const StepContext<D>& step, const MomentumSolver<D>& momentum, double& goal);
	bool                          changeStates(const StepContext<D>& step);
	void                          findMoved(const ActiveRange& range, double dt);

	PagedArray<Cell>                  cells_;
	std::array<PagedArray<int>, D>    next_, before_; ///< of each cell, those beside it along an axis; -1: none
	PagedArray<int>                   baseNodes_;
	PagedArray<unsigned char>         squares_; ///< see findSquares()
	PagedArray<double>                links_;   ///< sum V grad S of each cell at its nodes
	PagedArray<double>                liquids_; ///< sum m_l S of each cell at its nodes, in ground that is fed
	std::array<PagedArray<Face>, D>   faces_;
	std::array<int, corners>          nodeOffset_ {};
	std::array<int, supportCount<D>>  within_ {};            ///< place of a node of a point's support among the corners
	std::array<int, corners>          inward_ {};            ///< of each corner, the nearest one on the cell itself
	std::array<int, D>                byStride_ {};          ///< axes, the slowest first
	std::array<int, D>                strides_ {}, step_ {}; ///< from a node to the next one along an axis, on the grid and among the corners
	std::array<int, corners / 4>      rowOffset_ {};
	PagedArray<double>                change_, residual_, initial_, direction_, image_, preconditioned_;
	Multigrid                         multigrid_;
	NodeField<D>                      response_, force_, moved_;
	std::vector<Vec<D>>               open_;    ///< direction in which water may leave at a node; the faces of a slope then have its area
	std::vector<int>                  exposed_; ///< cells with a face without ground behind it
	std::vector<double>               partial_;
	double                            checkerboard_ = 0.0; ///< storage that only alternating pressures have [m^D/Pa]
	double                            lowest_       = 0.0; ///< cavitation pressure [Pa]
	std::array<double*, D>            velocity_, acceleration_;
	std::array<PagedArray<double>, D> startVelocity_; ///< of the ground of points at the start of the step [m/s]
	bool                              fed_  = false;
	const Grid<D>*                    grid_ = nullptr;
};

} // namespace talik
