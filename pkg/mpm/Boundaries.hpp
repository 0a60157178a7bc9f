// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// All boundary conditions; a new one adds its line here.
#include <pkg/mpm/DrainedBoundary.hpp>
#include <pkg/mpm/FixedBoundary.hpp>
#include <pkg/mpm/HeatFlux.hpp>
#include <pkg/mpm/ImpermeableBoundary.hpp>
#include <pkg/mpm/InsulatedBoundary.hpp>
#include <pkg/mpm/RollerBoundary.hpp>
#include <pkg/mpm/SurfaceTemperature.hpp>
#include <pkg/mpm/Traction.hpp>
#include <pkg/mpm/WallTemperature.hpp>
#include <pkg/mpm/WaterFlux.hpp>
