// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Scene.hpp>

namespace talik {

/// Why the next step of a scene would end the whole process on one of stock YADE's own asserts, with the remedy; empty if nothing of
/// the kind is known. Debian's YADE is built with asserts, and throws out of parallel loops where no functor fits a contact. Looks at
/// every body once; holds the GIL while it asks the dispatchers. dense: bodies are sure to touch.
std::string reasonAgainstRunning(const yade::Scene& scene, bool dense);

/// What may end the process as soon as two bodies touch, which need not happen: grains of IceBondMat and bodies of another material for
/// whose contacts there is no functor. Empty if there are none.
std::string contactsThatMayAbort(const yade::Scene& scene);

} // namespace talik
