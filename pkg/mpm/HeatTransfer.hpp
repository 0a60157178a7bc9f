// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/ActiveRange.hpp>
#include <pkg/mpm/FreeSurface.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/NodeField.hpp>
#include <pkg/mpm/ShapeFunctions.hpp>

#include <vector>

namespace talik {

/// Heat: enthalpy on the points, conduction on the nodes. Nodal heat is handed to the points by partition weights, so that the
/// sum over points changes by exactly what boundaries and sources supply.
template <int D> class HeatTransfer {
public:
	HeatTransfer(PointFields& fields, const HeatSettings& settings);
	void bind(MaterialPoints<D>& points, const Grid<D>& grid);

	/// Collects the nodes with prescribed temperature.
	void constrain(const Grid<D>& grid, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries);

	/// Adds heat capacity and heat of a block to the nodes.
	void map(const Grid<D>& grid, const WeightBlock<D>& w);
	/// Nodal temperatures from the mapped sums, prescribed ones at their nodes.
	void nodalTemperature(const ActiveRange& range, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries, double time);
	/// Adds the heat that conduction and sources bring to the nodes in dt.
	void conduct(const Grid<D>& grid, const WeightBlock<D>& w, double dt);
	/// Heat of a surface patch, implicit in the temperature of each node.
	void exchange(const SurfaceHeat& heat, const SurfacePatch<D>& patch, const FreeSurface<D>& surface, double spacing, double dt);
	/// Prescribed temperatures replace the conduction residual of their nodes; afterwards nodes hold the rise of temperature
	/// that points receive.
	void finishNodes(const ActiveRange& range, double dt);
	/// Enthalpy of a block.
	void gather(const Grid<D>& grid, const WeightBlock<D>& w, double dt);

	const HeatSettings* settings;
	double *enthalpy, *temperature, *heatCapacity, *conductivity, *volume;

	NodeField<2> nodes;       ///< C, C T
	NodeField<1> mapped;      ///< T_I from the points
	NodeField<1> nodal;       ///< T_I with prescribed values
	NodeField<1> energy;      ///< Delta E_I [J]
	NodeField<1> rise;        ///< Delta E_I/C_I + chi_T T_I

	double heatIn = 0.0; ///< through boundaries and from sources since the start [J]

private:
	PointFields::Handle          enthalpy_, temperature_, heatCapacity_, conductivity_;
	std::vector<TemperatureNode> prescribed_;
	std::vector<double>          wanted_;
	std::vector<double>          partial_;
};

extern template class HeatTransfer<2>;
extern template class HeatTransfer<3>;

} // namespace talik
