// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/mpm/effects/FreeSurface.hpp>
#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/grid/NodeLoops.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <cmath>
#include <vector>

namespace talik {

/// Heat: enthalpy on the points, conduction on the nodes, eqs. (9.3) to (9.6). Nodal heat is handed to the points by partition weights, so that the
/// sum over points changes by exactly what boundaries and sources supply.
template <int D> class HeatTransfer {
public:
	HeatTransfer(PointFields& fields, const HeatSettings& settings, bool freezing);
	void bind(MaterialPoints<D>& points, const Grid<D>& grid);
	/// Its numbers are mapped along by motion, whose record holds them.
	void carriedAlong() { carried_ = true; }
	/// Where no water has a record for both, conducted heat and nullSpaceResidual lie in one record of its own.
	void receiveInOneRecord(const Grid<D>& grid);
	/// From now on it is known how cold walls and surfaces are, see outside.
	void keepOutside(const Grid<D>& grid) { outside.allocate(grid.nodeCount()); }

	/// Collects the nodes with prescribed temperature.
	void constrain(const Grid<D>& grid, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries);

	/// Fixes the smoothing time from the state of the points, if the settings leave it open.
	void chooseSmoothing(const Grid<D>& grid, int points);

	/// Prepares nodes [first, last) for mapping.
	void clear(int first, int last)
	{
		nodes.clear(first, last);
		if (walls_) moments.clear(first, last);
		if (!produced_.empty()) volumes.clear(first, last);
	}
	/// Only nodes [first, last) are used from now on; all others are zero and take no memory.
	void keepOnly(int first, int last)
	{
		const auto keep = [&](auto&... fields) { (fields.keepOnly(first, last), ...); };
		keep(nodes, capacity, mapped, nodal, energy, nullSpaceResidual, increment, moments, volumes, received_, outside);
	}
	/// Adds capacity weights and their heat of a block to the nodes, unless motion or water maps them along.
	void map(const WeightBlock<D>& w);
	/// Nodal temperatures from the mapped sums, prescribed ones at their nodes.
	void nodalTemperature(const StepContext<D>& step, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries);
	/// Capacity weights, for motion or water to map along with the temperature, or null.
	const double* carriedWeight() const { return carried_ ? capacityWeight : nullptr; }
	/// Conduction of a step as the loops over nodes see it.
	typename NodeLoops<D>::HeatFlow flow(const StepContext<D>& step) const;
	/// What map() adds to, but for records of motion or water.
	void shareMapped(HaloExchange& rows)
	{
		rows.nodes(nodes);
		if (walls_) rows.nodes(moments);
		if (!produced_.empty()) rows.nodes(volumes);
	}
	/// What conduct() adds to, but for records of water.
	void shareConducted(HaloExchange& rows)
	{
		rows.nodes(energy);
		rows.nodes(nullSpaceResidual);
		rows.nodes(received_);
	}
	/// Adds the heat that conduction and sources bring to the nodes in the step.
	void conduct(const StepContext<D>& step, const WeightBlock<D>& w);
	/// Heat of the regions that produce it, eq. (9.7).
	void produce(const StepContext<D>& step, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries);
	/// Heat of a surface patch, implicit in the temperature of each node.
	void exchange(const StepContext<D>& step, const Boundary<D>& boundary, const SurfacePatch<D>& patch, const FreeSurface<D>& surface);
	/// Prescribed temperatures replace the conduction residual of their nodes; afterwards nodes hold the increment of temperature
	/// that points receive.
	void finishNodes(const StepContext<D>& step, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries);
	/// Enthalpy of a block; gained: sum S increment of its points, if somebody has formed it already.
	void gather(const WeightBlock<D>& w, const double* gained = nullptr);

	const HeatSettings* settings;
	double *            enthalpy = nullptr, *temperature = nullptr, *heatCapacity = nullptr, *conductivity = nullptr, *volume = nullptr;
	double*             capacityWeight
	        = nullptr; ///< [J/K] weight of a point in a node's temperature and in its heat: the sensible capacity, more where ice forms or melts

	double reference = 0.0; ///< T_r from which nodal temperatures count, but for mapped [degC]

	NodeField<2>     nodes;             ///< C, C (T - T_r); near walls those of the ground and its mirror image
	NodeField<1>     capacity;          ///< C of the ground alone
	NodeField<1>     mapped;            ///< T_I from the points, absolute
	NodeField<1>     nodal;             ///< T_I - T_r whose gradient conducts: prescribed at walls
	NodeField<1>     energy;            ///< Delta E_I [J]
	NodeField<1>     nullSpaceResidual; ///< sum S C (T of the grid at the point - T of the point)
	NodeField<1>     increment;         ///< what points receive: Delta E_I/C_I and smoothing
	NodeField<D + 1> moments;           ///< sum S C x and sum S V kappa, in scenes with walls of given temperature
	NodeField<1>     volumes;           ///< sum S V, in scenes with regions that produce heat
	/// Of the surfaces and walls at a node in this step, for ice segregation: outward area vector, area, area times temperature of the surface
	/// itself, heat that leaves [W of calendar time].
	NodeField<D + 3> outside;

	double smoothingTime = 0.0; ///< in use [s of calendar time]

private:
	void                       clearOutside(const ActiveRange& range);
	void                       addOutside(int node, const Vec<D>& area, double temperature, double heatOut);
	template <class Heat> void bookWalls(const StepContext<D>& step, const Heat& heat);
	void                       mapMoments(const WeightBlock<D>& w);
	void                       mapVolumes(const WeightBlock<D>& w);
	void                       mirrorWalls(const Grid<D>& grid, const ActiveRange& range);
	void                       prescribe(const StepContext<D>& step);
	/// What boxes and discs of given temperature give to their nodes, implicit in the temperature of each.
	void                          hold(const StepContext<D>& step, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries);
	TALIK_PROCESSOR_VERSIONS void warm(int first, int count, const double* gained);
	double                        smoothing(const StepContext<D>& step) const { return -std::expm1(-step.calendarDt / smoothingTime); }

	std::vector<TemperatureNode> prescribed_;
	std::vector<char>            isPrescribed_; ///< by how many walls
	struct HeldNode {
		int    node;
		double rate; ///< at which it takes the temperature, times diffusionTime_ [-]
		int    boundary;
		int    number; ///< among the nodes of its region
	};
	struct ProducingNode {
		int    node;
		double share;
		int    boundary;
		int    number; ///< among the nodes of the boundary
	};
	std::vector<ProducingNode> produced_;
	std::vector<HeldNode>      held_;
	double                     diffusionTime_ = 0.0; ///< h^2 C/kappa of the ground at the start [s]
	std::vector<int>           affected_;            ///< nodes whose heat the prescribed temperatures change
	std::vector<double>        wanted_;              ///< temperature of the wall at each of them
	std::vector<double>        expected_;            ///< mean temperature of the points around it that goes with this wall temperature
	std::vector<double>        gradient_;            ///< of temperature in front of each of them
	std::array<double*, D>     position_ {};
	NodeField<2>               received_;       ///< energy and nullSpaceResidual in one record, without water
	double                     smoothed_ = 0.0; ///< part of the null-space differences that dies out in this step
	bool                       walls_ = false, carried_ = false;
};

} // namespace talik
