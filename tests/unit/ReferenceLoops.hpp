// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/NodeLoops.hpp>

namespace talik {

/// Written to be read: what the vector versions of the loops are tested against.
template <int D> const NodeLoops<D>& referenceLoops();

} // namespace talik
