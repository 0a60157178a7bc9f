// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// All boundary conditions; a new one adds its line here.
#include <pkg/mpm/boundary/HydraulicBoundaries.hpp>
#include <pkg/mpm/boundary/MechanicalBoundaries.hpp>
#include <pkg/mpm/boundary/ThermalBoundaries.hpp>
