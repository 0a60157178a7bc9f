// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/rve/packed/PackedSample.hpp>

namespace talik {

/// Least distance of a grain from an image of itself, over the side of a square (cube) of the cell's size [-]: 1 in a square cell, 1.07
/// (1.12) in the most compact one.
template <int Dim> double cellCompactness(const typename PackedTypes<Dim>::Matrix& hSize);

/// Cells less compact than this slip: where a sample of 100 grains has an image of each grain five (discs) or three (spheres) diameters away.
template <int Dim> constexpr double leastCompactness = Dim == 2 ? 0.5 : 0.6;

/// True for a cell that certainly needs no slip, after a few operations.
template <int Dim> bool isCompact(const typename PackedTypes<Dim>::Matrix& hSize);

/// A thin periodic cell becomes compact again where its images slip past each other along lattice planes, eq. (13.9): what is on either side
/// of the planes stays as it is, contacts across them are lost, bonds among these count as broken in shear. Then overlaps are taken away,
/// and the sample is strained until it carries the stress again that it had. Nothing happens to a cell that is compact, and it costs a few
/// operations.
/// displacementGradient: of the update just done; result: of that update, whose stress, tangent and steps follow.
template <int Dim>
void slipWhereThin(
        PackedSample<Dim>& workspace, const typename PackedTypes<Dim>::Matrix& displacementGradient, const PackedUpdateOptions& options,
        PackedUpdateResult<Dim>& result);

/// What is to be said of a sample that blew up with a cell so thin, in mean diameters: nothing where it is wide enough.
std::string ofThinCell(double thickness);

} // namespace talik
