// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// What the hard cases of wet ground share.

#include "Scenes.hpp"

namespace talik::stability {

/// Pore water of reduced stiffness [Pa], ice four times as stiff.
inline WaterSettings softWater(double liquidBulkModulus = 2.2e7)
{
	WaterSettings w;
	w.state.liquidBulkModulus = liquidBulkModulus;
	w.state.iceBulkModulus    = 4.0 * liquidBulkModulus;
	return w;
}

/// Heavy ground between the origin and upper [m] with heat, freezing and soft water, momentum carried by apic.
inline GroundSettings<2> everyEffect(double spacing, const Vec<2>& upper, double thermalTimeScale)
{
	GroundSettings<2> s;
	s.gridSpacing = spacing;
	s.upper       = upper;
	s.motion.emplace();
	s.motion->gravity  = { 0.0, -9.81 };
	s.motion->transfer = VelocityTransfer::apic;
	s.heat.emplace();
	s.heat->thermalTimeScale = thermalTimeScale;
	s.freezing               = makeFreezingCurve();
	s.water                  = softWater();
	s.energyLedger           = true;
	return s;
}

} // namespace talik::stability
