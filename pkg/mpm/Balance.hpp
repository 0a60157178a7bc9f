// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Vector.hpp>

namespace talik {

/// What crosses the boundary of the ground in a step or a run, and the works [J]. Per metre of thickness in 2-D.
template <int D> struct StepAccount {
	Vec<D> impulse {};               ///< of gravity, loads, walls and damping [N s]
	double dragDissipation    = 0.0; ///< only with GroundSettings::energyLedger, as all works but those of walls and segregation
	double dampingDissipation = 0.0;
	double loadWork           = 0.0; ///< done by surface loads
	double slipWork           = 0.0; ///< of the force between frozen and thawed ground on their slip
	double wallWork           = 0.0; ///< done by walls of given velocity
	Vec<D> momentumOut {};           ///< with the water [N s]
	double waterOut         = 0.0;   ///< left through drained boundaries [kg]
	double enthalpyOut      = 0.0;   ///< carried out by water [J]
	double waterEnergyOut   = 0.0;   ///< of that water where it leaves: potential energy, and the pressure outside
	double heatIn           = 0.0;   ///< conducted in through boundaries and produced by sources [J]
	double skeletonWork     = 0.0;   ///< done on the skeleton by effective stress
	double porePressureWork = 0.0;   ///< done by pore pressure on the pore content
	double waterDrawn       = 0.0;   ///< by freezing ground to its fronts [kg]
	double segregationWork  = 0.0;   ///< of suction on that water
	double workAhead        = 0.0;   ///< part of both works that the state at the end of a step did on its strain: it moves the ground in the next

	StepAccount& operator+=(const StepAccount& other)
	{
		constexpr int numbers = sizeof(StepAccount) / sizeof(double);
		static_assert(numbers == 2 * D + 14, "nothing but numbers");
		auto* const       sums  = reinterpret_cast<double*>(this);
		const auto* const added = reinterpret_cast<const double*>(&other);
		for (int k = 0; k < numbers; ++k)
			sums[k] += added[k];
		return *this;
	}
};

/// Sums over the ground and what crossed its boundary since the start.
template <int D> struct Balance : StepAccount<D> {
	double time      = 0.0;
	double solidMass = 0.0, waterMass = 0.0, iceMass = 0.0; ///< [kg]; water includes ice
	Vec<D> momentum {};                                     ///< of both phases [kg m/s]
	double enthalpy      = 0.0;                             ///< [J]
	double kineticEnergy = 0.0;
	double gravityEnergy = 0.0; ///< relative to the origin of coordinates
};

} // namespace talik
