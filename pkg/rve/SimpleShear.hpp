// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <pkg/rve/packed/PackedSample.hpp>

namespace talik {

/// Strain of each call that holds a normal stress, by its error now and the sum of the errors so far.
class NormalStressControl {
public:
	/// pressure to be held [Pa], compression positive; strain of a call across, a third of the largest answer; stiffness of the sample, order of magnitude [Pa].
	NormalStressControl(double pressureToHold, double perCall, double stiffnessOfSample)
	        : pressure(pressureToHold)
	        , limit(3 * perCall)
	        , stiffness(stiffnessOfSample)
	{}
	/// Of the next call; stress: the normal stress now [Pa], tension positive.
	double strain(double stress)
	{
		const double error = (-pressure - stress) / stiffness;
		sum += 0.05 * error;
		return std::max(-limit, std::min(limit, 0.4 * error + sum));
	}

private:
	double pressure, limit, stiffness, sum = 0;
};

/// Simple shear of a sample without ice: planes across one axis slide along another under a constant normal stress, with no strain along them.
struct ShearPath {
	int    along = 0, across = 1;
	double pressure = 1e4;  ///< normal stress that is held [Pa], compression positive
	double perCall  = 4e-5; ///< shear of a call [-], its sign the direction
	long   calls    = 0;
};

/// Calls visit(shear stress in the direction of motion, normal stress, tension positive) after every call of a packed sample, which stays as it is.
/// Ends early where it blows up and returns the reason.
template <int Dim, class Visit> std::string shearPacked(const PackedState<Dim>& state, const ShearPath& path, const PackedUpdateOptions& options, Visit&& visit)
{
	using Matrix          = typename PackedTypes<Dim>::Matrix;
	const int           a = path.across;
	PackedSample<Dim>   sample(state);
	const double        stiffness = std::max(100 * path.pressure, sample.tangent()[std::size_t((a * Dim + a) * Dim + a) * Dim + std::size_t(a)]);
	NormalStressControl control(path.pressure, std::abs(path.perCall), stiffness);
	const double        direction = path.perCall < 0 ? -1 : 1;
	double              normal    = state.stress(a, a);
	for (long k = 0; k < path.calls; ++k) {
		Matrix gradient         = Matrix::Zero();
		gradient(path.along, a) = path.perCall;
		gradient(a, a)          = control.strain(normal);
		const auto result       = sample.update(state, gradient, 0, options);
		if (result.blewUp) return result.reason.empty() ? "it blew up" : result.reason;
		normal = result.stress(a, a);
		visit(direction * result.stress(path.along, a), normal);
	}
	return "";
}

} // namespace talik
