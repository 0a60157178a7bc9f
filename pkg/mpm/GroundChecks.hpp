// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/GroundSettings.hpp>

namespace talik {

// What a scene must fulfil before its ground is set up. All throw std::invalid_argument naming attribute, value and remedy.

template <int D> void checkSettings(const GroundSettings<D>& settings);
template <int D> void checkBoundaries(const GroundSettings<D>& settings, const Grid<D>& grid);
template <int D> void checkPoints(const GroundSettings<D>& settings, const Grid<D>& grid, const std::vector<PointInput<D>>& points);

} // namespace talik
