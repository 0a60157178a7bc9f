// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/mpm/effects/FreeSurface.hpp>
#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/grid/NodeColumns.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/points/CellMeans.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <vector>

namespace talik {

template <int D> class SolidMotion;

/// The liquid of a ground, which is the same in all its materials.
struct LiquidOfGround {
	double               density;  ///< [kg/m^3]
	const EnthalpyModel* enthalpy; ///< null: ground without heat
};

/// By how much seepage is accelerated in a step, f_H [-]: smallest and largest among the materials of a ground.
struct SeepageScales {
	double smallest, largest;
};

/// Pore water with a velocity of its own. The force of its pressure and the flux of its mass are adjoint: pressure does exactly
/// the work that the pore content receives. Mass, momentum and enthalpy that seepage moves are handed over by the same
/// partition weights, so that none is made.
template <int D> class PoreWater {
public:
	using Columns = NodeColumns<D>;
	/// Record of a node: liquid mass, its momentum, volume, volume of liquid, mass times pressure, drag, mass times gravity's potential.
	using Liquid                = typename Columns::Liquid;
	static constexpr int massAt = Liquid::mass, momentumAt = Liquid::momentum, volumeAt = Liquid::volume, liquidVolumeAt = Liquid::liquidVolume,
	                     pressureAt = Liquid::pressure, dragAt = Liquid::drag, potentialAt = Liquid::potential;
	/// What is nodal and what drives.
	using Driving = typename Columns::Driving;
	/// Exchange by seepage.
	using Gathered                    = typename Columns::Gathered;
	static constexpr int exchangeSize = Gathered::exchange;
	/// A neighbour that conducts less than this part of a cell is ice to its water [-].
	static constexpr double tight = 0.1;

	PoreWater(PointFields& fields, const WaterSettings& settings);
	void bind(MaterialPoints<D>& points, const Grid<D>& grid, const double* iceMass, const double* temperature, const double* waterMass);

	/// Cell means of pressure and exchange, weighted with the liquid mass: what seeps is then as uniform within a cell as the
	/// strain is, or points of one cell would drift apart in pressure without any force to bring them back. The mean pressure
	/// that drives the liquid is the transpose.
	void allocateCells(int cells, double cellVolume);
	/// rho_l g along an axis in this step [N/m^3].
	void setWeight(const Grid<D>& grid, int axis, double ofVolume);
	void clearCells(int first, int last);
	/// Only nodes, cells and points of this part are used from now on; all others are zero and take no memory.
	void keepOnly(const ActiveRange& range, int firstPoint, int endPoint);
	/// What points add to their cells.
	void shareCells(HaloExchange& rows)
	{
		if (!cells_.empty()) rows.cells(cells_.data());
		if (!freezing_.empty()) rows.cells(freezing_.data());
	}
	/// Adds pressure of points first .. last to their cells; call within MaterialPoints::strips().scatter.
	void addPressure(const CellMeans<D>& cells, int first, int last);

	/// Mean pressure of each cell, when all points were added.
	void finishPressure(const ActiveRange& range);
	/// Pressure that drives the liquid of each cell of ground that freezes. A cell in which ground thaws from one side is a thawed layer
	/// on a frozen one: p = phi u + (1 - phi) p_f, with the part phi that has thawed since it was like its most frozen neighbour and that
	/// neighbour's pressure p_f. Its liquid feels u. If it felt the mean, the load that the ice of the whole cell bore would leave as soon
	/// as the cell conducts, and the pressure behind the front would pulse from cell to cell.
	void findDrivingPressure(const Grid<D>& grid, const ActiveRange& range, const CellMeans<D>& cells);

	/// cells null: without cell means. Maps capacity and capacity times (temperature - carriedFrom) along, if not null, where records Liquid
	/// have columns for them.
	void map(const WeightBlock<D>& w, const CellMeans<D>* cells, const double* capacity = nullptr, double carriedFrom = 0.0);
	/// Nodal pressure and liquid fraction from the mapped sums.
	void nodalPressure(const ActiveRange& range);
	/// Adds sum V S grad p of a block to the nodes.
	void pressureForce(const WeightBlock<D>& w);
	/// Where water may cross the surface of the ground.
	void open(const SurfacePatch<D>& patch);
	/// Adds gravity's potential to the pressure, -rho_l g.x. Surfaces and walls leave the points on one side of a node; there x is the
	/// middle of the liquid that the node sees, as it is for the pressure: hydrostatic pressure then moves nothing, and gravity does the
	/// work that the points, which receive what flows, lose by their height. At the place of the node it would push water through closed
	/// surfaces, and drag would spend what nothing gave. That is so as far as stress and damping carry the ground; what falls freely does not flow,
	/// and through open surfaces water flows by its weight: there x is the node's place.
	void addPotential(const Grid<D>& grid, const ActiveRange& range, const SolidMotion<D>& motion, const std::vector<unsigned char>& heldAxes);
	/// Completes the force on the liquid, -n_I grad(p - rho_l g.x), but for what lies outside drained surfaces.
	void liquidForce(const ActiveRange& range);
	void drainedForce(const SurfacePatch<D>& patch, double pressure);
	/// Mass, momentum and, with an enthalpy model, enthalpy that flows in dt.
	void seep(const WeightBlock<D>& w, double dt);
	/// What leaves through a drained surface.
	void drain(const StepContext<D>& step, const SurfacePatch<D>& patch, bool recharges, const NodeField<1>* temperature);
	/// What is fed through a surface, inflow [m/s] into the ground; temperature of water that enters [degC], NaN: that of the node.
	void feed(const StepContext<D>& step, const SurfacePatch<D>& patch, double inflow, double inflowTemperature, const NodeField<1>* temperature);
	void finishExchange(const ActiveRange& range);
	/// Velocity of a block, and what seepage brings: to the points, or to their cells for receive().
	/// increment (may be null): receives the sums S increment of heat, where its column lies in the same record.
	void gather(const WeightBlock<D>& w, double* waterMass, double* enthalpy, const CellMeans<D>* cells, double* increment = nullptr);
	/// Adds to the exchange of cells, when all of it was gathered, what evens out between neighbours in dt: a pressure that is too high
	/// and too low by turns has no gradient at the nodes, so that no flux of theirs would ever level it. In ground that freezes: every
	/// cell that thaws leaves such a pulse of the load that its ice and water bore.
	void stabiliseCells(const StepContext<D>& step, const CellMeans<D>& cells);
	// Of the liquid of a cell in ground that freezes, at the start of the step; what ice segregation takes from it, and gives to points.
	double pressureOfCell(int cell) const { return cells_[cell].pressure; }
	double heightOfCell(int cell) const { return cells_[cell].height; } ///< gravity's potential per volume [Pa]
	double liquidOfCell(int cell) const { return cells_[cell].liquidMass; }
	double enthalpyOfCell(int cell, const EnthalpyModel& enthalpy) const
	{
		return enthalpy.liquidEnthalpy(freezing_[cell].warmth / cells_[cell].liquidMass);
	}
	Vec<D> velocityOfCell(int cell) const { return freezing_[cell].carried / cells_[cell].liquidMass; }
	/// Before finishCells().
	void give(int cell, double mass, const EnthalpyModel& enthalpy);
	/// Before the water mass of the point grows.
	void mixIn(int place, double mass, const Vec<D>& momentum);
	/// Exchange of each cell per liquid mass.
	void finishCells(const StepContext<D>& step);
	/// Hands what cells gathered to points first .. last: mass, momentum and (if enthalpy is not null) enthalpy. Returns momentum that the
	/// water of cells that run dry gave up, see remainingVelocity: it has gone out with the water [N s].
	Vec<D> receive(const CellMeans<D>& cells, int first, int last, double* waterMass, double* enthalpy, const std::array<double*, D>& solidVelocity);

	/// Adds to the cells of some points from first on the unstressed volume of liquid and ice less the pore volume [m^D], and their compliance
	/// [m^D/Pa]; in ground that freezes also for stabilisePoints() in the step dt. Call within MaterialPoints::strips().scatter.
	void addFills(const CellMeans<D>& cells, int first, int count, const double* excess, const double* compliance, double dt);
	/// Pressure of each cell from what fills it, when all points were added.
	void findCellPressure(const ActiveRange& range);
	/// Hands water on between the points of a cell, in ground that freezes: a point that holds more than its pores, at the pressure of its
	/// cell, gives to those that hold less, eq. (7.7). Exchange by seepage is even within a cell, so that nothing else would ever bring the
	/// water of a point and its pores together, and the point would carry the difference, as a pressure, into the next cell.
	/// Call when the cells have their pressure. enthalpy null: ground without heat.
	void stabilisePoints(const CellMeans<D>& cells, int first, int last, double* waterMass, double* enthalpy);
	/// Gives the points first .. last the pressure of their cell: that of all its liquid and ice in all its pores. Temperature
	/// differs between the points of a cell by more than the grid can resolve; pressures of their own would follow with the
	/// stiffness of water, and cavitation would cut off only the low ones.
	void shareCellPressure(const CellMeans<D>& cells, int first, int last);
	/// Books the work of the pressure of cells on the water that they received in the step, times a share.
	void bookSeepageWork(const ActiveRange& range, double share, StepLedger<D>& ledger) const;

	/// By what the pressure that drives the liquid of a cell differs from that of the cell, see findDrivingPressure [Pa].
	double drivingExcess(int cell) const { return cells_[cell].driving - cells_[cell].pressure; }
	/// What seepage brings to a cell, record Gathered, after gather() and before finishCells(); for ImplicitPressure.
	double* cellExchange(int cell) { return cells_[cell].exchange; }
	/// The same of the pressure of a cell at the end of the step, before shareCellPressure().
	void setCellPressure(int cell, double pressure) { cells_[cell].fillPressure = pressure; }

	const WaterSettings* settings;
	LiquidOfGround       liquid {};
	Vec<D>               weight {};  ///< rho_l g in this step [N/m^3]
	double               kept = 1.0; ///< chi of the liquid in this step, see keptFraction()

	std::array<double*, D> velocity; ///< of the liquid
	double *               pressure = nullptr, *liquidFraction = nullptr, *drag = nullptr;

	NodeField<Liquid::size>  nodes;
	NodeField<Driving::size> nodal; ///< p - rho_l g.x, liquid fraction n_I, inverse liquid mass as mapped
	double pressureAtNode(int node) const { return nodal[node][Driving::pressure] - nodes[node][potentialAt] * nodal[node][Driving::perLiquidMass]; }
	NodeField<Columns::Driven::size> force;  ///< on the liquid
	NodeField<D>                     solved; ///< chi dt a + (1 - chi) v
	NodeField<Columns::Flux::size>   flux;   ///< n_I (v_l - v_s) of the solved velocities
	NodeField<D>                     start;  ///< v_l at the start of the step
	NodeField<Gathered::size>        exchange;

	SeepageScales scales { 1.0, 1.0 }; ///< in this step; the smallest multiplies what is fed in
	/// What accelerated water does against its inertia dies out within k/(n g), whatever the ground is like: within this time [s]. What its
	/// points have and no node sees would not, by drag at the nodes, and would throw the last water out of ground that runs dry.
	static constexpr double longestRest = 0.0125;
	/// Ground conducts water as its porosity and ice let it times f_H, up to this conductivity [m/s] and no further: what water does against its inertia
	/// then dies out within an eightieth of a second; beyond, it would swing in grains that hardly hold it. With explicit pressure the limit holds for f_H
	/// times the conductivity of a material, and ice reduces what it leaves: soft water that freezes would make energy in ground that conducts as it should.
	double largestConductivity = std::numeric_limits<double>::infinity();
	void   chooseLargestConductivity(double smallestReferencePorosity);
	/// f_H where slow processes run f times as fast as motion [-]
	double wantedScale(double f) const { return std::isnan(settings->hydraulicTimeScale) ? f : settings->hydraulicTimeScale; }

private:
	/// What the points of a cell sum up to, and what follows from it in a step. Means are sums first, until all points were added.
	struct Cell {
		double liquidMass;             ///< [kg]
		double pressure, height;       ///< means over the liquid of pressure and of gravity's potential
		double driving;                ///< pressure: at a thaw front that of the thawed layer, the mean anywhere else [Pa]
		double exchange[exchangeSize]; ///< what seepage brings (mass, enthalpy, momentum), mean over the liquid
		double dilution;               ///< of the momentum that a point has, by the water that it receives [-]
		double excess, compliance;     ///< of what fills the pores at the end of the step, see addFills
		double fillPressure;           ///< that follows from them [Pa]
	};
	/// More of a cell in ground that freezes: sums of drag, mass of liquid and ice, liquid mass times temperature and times velocity.
	struct FreezingCell {
		double drag, contentMass, warmth;
		Vec<D> carried;
		double mobility;           ///< k/(rho_l g), with the drag of all that it holds [m^2/(Pa s)]
		double reached;            ///< mobility with which water at rest flows at the end of the step: its inertia holds it back where drag does not
		double excess, compliance; ///< sums of addFills, each times the share that its point levels in the step
		double surplus;            ///< the part of excess beyond the pores at the cavitation pressure [m^D]
		double level;              ///< pressure at which what its points give is what they take [Pa]
		double filled;             ///< share of the room of its points that they fill where there is more room than surplus [-]
		double handed;             ///< enthalpy of the water that they hand on [J/kg]
		Vec<D> velocity;           ///< of that water [m/s]
	};
	/// Of a point at the end of a step: see addFills, and the share of its difference from the cell that it levels in the step.
	struct PointFill {
		double excess, compliance, share;
	};
	/// Between a cell and the next one along an axis: conductance [m^D/(Pa s)] and what Darcy's law would let through [m^D/s].
	struct Face {
		double conductance, flow;
	};
	/// True if far more water flows through a cell than it holds.
	bool isStuck(const Cell& cell, int p) const { return cell.liquidMass < stuckMass_ * (radius_ ? radius_[p] : 1.0); }
	/// Velocity of what stays in a cell that runs dry; call before take(). Water that leaves takes the velocity of the nodes along. What
	/// stays would be left with the difference and become ever faster, without bound. Its velocity changes as if no more than the share
	/// `most` had left, which the points' approach to the nodes' velocity makes up for. The last water moves with its grains.
	Vec<D> remainingVelocity(int place, const Cell& cell, double most, const std::array<double*, D>& solidVelocity) const;
	/// From the sums of a cell; later in the step FreezingCell has them.
	double mobility(int cell, double volume) const;
	/// The driving pressure of a cell at a thaw front, its mean pressure anywhere else.
	double thawedPressure(const Grid<D>& grid, const ActiveRange& range, int cell) const;
	/// Part of the flow that the nodes do not see: what a flow that changes evenly from face to face has none of.
	/// before, after: the faces beside it along the axis, -1 for none.
	double checkerboardFlux(const Face* faces, int face, int before, int after) const;
	double reachedMobility(int cell, double volume, double dt) const;
	void   findFaces(const Grid<D>& grid, const ActiveRange& range, const CellMeans<D>& cells, double dt);
	/// s_p of eq. (7.7) and the surplus of some points from first on, and the former for stabilisePoints().
	TALIK_PROCESSOR_VERSIONS void findShares(
	        int first, int count, const double* excess, const double* compliance, double dt, double* share, double* surplus) const;
	/// Volume that a point gives to the others of its cell in the step [m^D].
	double                          given(const PointFill& point, const FreezingCell& cell) const;
	double                          traceMass_ = 0.0, stuckMass_ = 0.0; ///< of a cell [kg]
	double                          perHalfCell_ = 0.0; ///< area over length from the middle of one half of a cell to that of the other [m^(D-2)]
	std::array<PagedArray<Face>, D> faces_;

	/// Mass and enthalpy that leave a node through the surface, with the momentum of the water there.
	void leave(int node, double mass, double heat, StepLedger<D>& ledger);
	void limitOutflow(const ActiveRange& range, StepLedger<D>& ledger);
	/// What a block maps to the nodes, number by number of their record.
	TALIK_PROCESSOR_VERSIONS void fillRecords(
	        const WeightBlock<D>& w, const double (&driving)[blockSize], const double (&potential)[blockSize],
	        double (&values)[Liquid::size][blockSize]) const;
	/// Gravity's potential per volume of liquid, -rho_l g.x [Pa], without the axes of periodic sides, along which it has no single value.
	double potential(int p) const
	{
		double sum = 0.0;
		for (int a = 0; a < D; ++a)
			sum -= lifted_[a] * position_[a][p];
		return sum;
	}
	TALIK_PROCESSOR_VERSIONS void accelerate(int axis, int first, int count, const double* change);
	double                        liquidMass(int p) const { return waterMass_[p] - (iceMass_ ? iceMass_[p] : 0.0); }
	/// share: exchange per liquid mass of the point; dilution: of the momentum that it has.
	void take(int p, const double* share, double dilution, double* waterMass, double* enthalpy);

	PagedArray<Cell>             cells_;
	PagedArray<FreezingCell>     freezing_;
	PagedArray<PointFill>        fills_;
	Vec<D>                       along_ {}, lifted_ {}; ///< weight along axes with periodic sides, and along the others [N/m^3]
	std::vector<char>            open_;                 ///< nodes through whose surface water may cross in this step
	std::array<const double*, D> position_ {};
	const double *               volume_ = nullptr, *waterMass_ = nullptr, *iceMass_ = nullptr, *temperature_ = nullptr;
	const double*                radius_ = nullptr; ///< of points about an axis, null in the plane
	std::vector<double>          none_, once_;      ///< zeros and ones, in place of the fields of absent effects
};

} // namespace talik
