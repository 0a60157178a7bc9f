// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/rve/packed/PackedSample.hpp>

/// One update of a sample in a workspace: what PackedSample and SamplePool share.
namespace talik {

/// Loads nothing: `workspace` holds `before` already. On blow-up the workspace holds `before` again and the result says so.
/// Throws std::invalid_argument for arguments that no sample could follow; the workspace is then undefined.
template <int Dim>
PackedUpdateResult<Dim> updateWorkspace(
        PackedWorkspace<Dim>& workspace, const PackedState<Dim>& before, const typename PackedTypes<Dim>::Matrix& displacementGradient,
        double targetIceSaturation, const PackedUpdateOptions& options);

/// Number of moving steps for a displacement gradient, eq. (13.1), with stress, time step and density of the parameters.
template <int Dim>
long movingSteps(
        const PackedParameters<Dim>& parameters, double meanRadius, const typename PackedTypes<Dim>::Matrix& displacementGradient,
        const PackedUpdateOptions& options);

/// Throws std::invalid_argument on a factor that no strength can have.
void checkStrength(const BondStrengthFactors& strength);

/// Throws std::invalid_argument on creep that no ice can have.
void checkCreep(const BondCreep& creep);

/// Throws std::invalid_argument naming the option.
void checkOptions(const PackedUpdateOptions& options);

/// What PackedSample::forcePortable last said.
bool portablePathForced();

} // namespace talik
