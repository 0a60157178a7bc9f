// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <string>
#include <vector>

namespace talik {

/// How the velocity of the solid comes back from the grid.
/// flip: points keep a fraction of their own velocity and take the grid's acceleration (Brackbill & Ruppel 1986): little
///       dissipation, noise that the grid does not see stays on the points.
/// apic: points take the grid's velocity and its first moment and give both back (Jiang et al. 2015): momentum and angular momentum
///       are kept to round-off, noise is filtered.
/// tpic: points take the grid's velocity and its gradient (Taylor expansion; Nakamura et al. 2023): as apic, for any shape function,
///       angular momentum is kept approximately only.
enum class VelocityTransfer { flip, apic, tpic };

/// "flip" (default), "apic", "tpic".
std::vector<std::string> velocityTransferNames();
/// Throws std::invalid_argument that lists the names.
VelocityTransfer velocityTransferFromName(const std::string& name);

} // namespace talik
