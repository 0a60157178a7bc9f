// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include "packedReference.hpp"
#include "packedSpheres.hpp"

namespace talik::stability {

/// The packed sample of stock YADE that the references were made with, of discs or of spheres.
template <int D> PackedState<D>   ofStock();
template <> inline PackedState<2> ofStock<2>() { return packedReference::sample().state(); }
template <> inline PackedState<3> ofStock<3>() { return packedSpheres::sample().state(); }

} // namespace talik::stability
