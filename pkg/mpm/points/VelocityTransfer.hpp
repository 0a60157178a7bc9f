// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <string>
#include <vector>

namespace talik {

/// How the velocity of the solid comes back from the grid. What a point's own velocity differs by from that of the grid dies out in
/// the time picTime with each of them.
/// flip: points keep their own velocity and take the grid's acceleration (Brackbill & Ruppel 1986): little dissipation.
/// apic: points take the grid's velocity and its first moment and give both back (Jiang et al. 2015): momentum and angular momentum
///       are kept to round-off, noise is filtered.
/// tpic: points take the grid's velocity and its gradient (Taylor expansion; Nakamura et al. 2023): as apic, for any shape function,
///       angular momentum is kept approximately only.
enum class VelocityTransfer { flip, apic, tpic };

/// "flip" (default), "apic", "tpic".
std::vector<std::string> velocityTransferNames();
/// Throws std::invalid_argument that lists the names.
VelocityTransfer velocityTransferFromName(const std::string& name);

/// chi, the share of its difference from the grid that a point keeps in a step: exp(-dt/picTime). A share per step in its place is a
/// viscosity of some (1 - chi) h^2/(4 dt), larger the smaller the step.
double keptFraction(double picTime, double dt);
/// sqrt(h/g): in that time a body at rest falls by half a cell, or ground that flows under gravity passes one; g: gravity, that of
/// the earth where a scene has less. The viscosity h^2/(4 picTime) then vanishes as h^1.5, whatever stiffness and step.
double gravityTime(double spacing, double gravity);

} // namespace talik
