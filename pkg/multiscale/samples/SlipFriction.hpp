// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <memory>
#include <pkg/rve/packed/PackedState.hpp>
#include <string>
#include <vector>

namespace talik {

/// A sample whose friction is measured: packed, or a scene as bytes where it cannot be packed.
template <int Dim> struct ShearedSource {
	std::shared_ptr<const PackedState<Dim>> packed;
	std::string                             scene;
};

/// Shear over normal stress with which samples without ice go on in simple shear once they have forgotten how they were packed.
struct SteadyFriction {
	double mean    = 0; ///< over the runs [-]
	double error   = 0; ///< standard error of the mean, from the scatter of the runs [-]
	int    samples = 0; ///< that were sheared
};

/// Of some of the samples, in runs of different directions of shear: eight of packed samples, two where one has to run open. Each has a pressure of its
/// own, that of its sample where that lies between 2 and 50 kPa, else 10 kPa. What comes out does not depend on the number of threads (0: OpenMP's
/// default). Throws std::runtime_error with the reason where more than half of the runs blow up.
template <int Dim> SteadyFriction steadyFriction(const std::vector<ShearedSource<Dim>>&, int threads);

} // namespace talik
