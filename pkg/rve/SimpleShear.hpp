// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <functional>
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
	double pressure  = 1e4;  ///< normal stress that is held [Pa], compression positive
	double stiffness = 3e7;  ///< order of magnitude of that of the sample [Pa]
	double perCall   = 4e-5; ///< shear of a call [-], its sign the direction
	long   calls     = 0;
};

/// Calls visit(shear stress in the direction of motion, normal stress, tension positive, strain across so far) after every call of the sample. Ends
/// early where that blows up and returns the reason.
template <int Dim>
std::string shearSample(
        const ShearPath& path, const typename PackedTypes<Dim>::Matrix& stressNow,
        const std::function<PackedUpdateResult<Dim>(const typename PackedTypes<Dim>::Matrix& gradient)>& apply,
        const std::function<void(double shearStress, double normalStress, double strainAcross)>&         visit)
{
	using Matrix = typename PackedTypes<Dim>::Matrix;
	NormalStressControl control(path.pressure, std::abs(path.perCall), path.stiffness);
	const double        direction = path.perCall < 0 ? -1 : 1;
	double              normal = stressNow(path.across, path.across), across = 0;
	for (long k = 0; k < path.calls; ++k) {
		Matrix gradient                    = Matrix::Zero();
		gradient(path.along, path.across)  = path.perCall;
		gradient(path.across, path.across) = control.strain(normal);
		const auto result                  = apply(gradient);
		if (result.blewUp) return result.reason.empty() ? "it blew up" : result.reason;
		across += gradient(path.across, path.across);
		normal = result.stress(path.across, path.across);
		visit(direction * result.stress(path.along, path.across), normal, across);
	}
	return "";
}

} // namespace talik
