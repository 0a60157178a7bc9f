// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Scene.hpp>

namespace talik {

/// Why the next step of a scene would end the whole process on one of stock YADE's own asserts, with the remedy; empty if nothing of
/// the kind is known. Debian's YADE is built with asserts, and throws out of parallel loops where no functor fits a contact. Looks at
/// every body once; holds the GIL while it asks the dispatchers. Grains of IceBondMat must have functors for all that they may touch; other
/// bodies need not touch, unless dense.
std::string reasonAgainstRunning(const yade::Scene& scene, bool dense);

} // namespace talik
