// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/ActiveRange.hpp>
#include <pkg/mpm/FreeSurface.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/NodeField.hpp>
#include <pkg/mpm/ShapeFunctions.hpp>

namespace talik {

/// Pore water with a velocity of its own. The force of its pressure and the flux of its mass are adjoint: pressure does exactly
/// the work that the pore content receives. Mass, momentum and enthalpy that seepage moves are handed over by the same
/// partition weights, so that none is made.
template <int D> class PoreWater {
public:
	/// Record of a node: liquid mass, its momentum, volume, volume of liquid, mass times pressure, drag.
	static constexpr int mapSize = 8;
	static constexpr int massAt = 0, momentumAt = 1, volumeAt = 1 + D, liquidVolumeAt = 2 + D, pressureAt = 3 + D, dragAt = 4 + D;
	/// Exchange by seepage: mass, enthalpy, momentum; first sums, then per liquid mass of the node.
	static constexpr int exchangeSize = 2 + D;

	PoreWater(PointFields& fields, const WaterSettings& settings);
	void bind(MaterialPoints<D>& points, const Grid<D>& grid, const double* iceMass, const double* temperature, const double* waterMass);

	void map(const Grid<D>& grid, const WeightBlock<D>& w);
	/// Nodal pressure and liquid fraction from the mapped sums.
	void nodalPressure(const ActiveRange& range);
	/// Adds sum V S grad p of a block to the nodes.
	void pressureForce(const Grid<D>& grid, const WeightBlock<D>& w);
	/// Completes the force on the liquid: pressure, what lies outside drained surfaces, body force.
	void liquidForce(const ActiveRange& range, const Vec<D>& gravity);
	void drainedForce(const SurfacePatch<D>& patch, double pressure);
	/// Mass, momentum and, with an enthalpy model, enthalpy that flows in dt.
	void seep(const Grid<D>& grid, const WeightBlock<D>& w, double dt, double liquidDensity, const EnthalpyModel* enthalpy);
	/// What leaves through a drained surface.
	void drain(const SurfacePatch<D>& patch, bool recharges, double dt, double liquidDensity, const EnthalpyModel* enthalpy, const NodeField<1>* temperature);
	void finishExchange(const ActiveRange& range);
	/// Velocity, water mass and (if enthalpy is not null) enthalpy of a block.
	void gather(const Grid<D>& grid, const WeightBlock<D>& w, double* waterMass, double* enthalpy);

	const WaterSettings* settings;

	std::array<double*, D> velocity; ///< of the liquid
	double *pressure, *liquidFraction, *drag;

	NodeField<mapSize>      nodes;
	NodeField<3>            nodal;  ///< pressure, liquid fraction n_I, inverse liquid mass as mapped
	NodeField<D>            force;  ///< on the liquid
	NodeField<D>            solved; ///< chi dt a + (1 - chi) v
	NodeField<D>            flux;   ///< n_I (v_l - v_s) of the solved velocities
	NodeField<D>            start;  ///< v_l at the start of the step
	NodeField<exchangeSize> exchange;

	double waterOut = 0.0, enthalpyOut = 0.0; ///< through drained surfaces since the start [kg, J]
	Vec<D> momentumOut {};

private:
	PointFields::Handle velocity_, pressure_, liquidFraction_, drag_;
	const double *      volume_ = nullptr, *waterMass_ = nullptr, *iceMass_ = nullptr, *temperature_ = nullptr;
	std::vector<double> none_; ///< zeros, in place of the fields of absent effects
};

extern template class PoreWater<2>;
extern template class PoreWater<3>;

} // namespace talik
