// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/mpm/points/ObjectiveUpdate.hpp>

namespace talik {

namespace {
	template <int D>
	[[gnu::always_inline]] inline void update(
	        int count, const double* lambda, const double* shear, std::array<const double*, D * D> gradient, std::array<double*, stressSize<D>> stress)
	{
		// fields of the points never overlap
#pragma GCC ivdep
		for (int p = 0; p < count; ++p) {
			double g[D * D], s[stressSize<D>];
			for (int c = 0; c < D * D; ++c)
				g[c] = gradient[c][p];
			for (int c = 0; c < stressSize<D>; ++c)
				s[c] = stress[c][p];
			const MidpointIncrement<D> increment(g);
			increment.rotate(s);
			increment.addElastic(s, lambda[p], shear[p]);
			for (int c = 0; c < stressSize<D>; ++c)
				stress[c][p] = s[c];
		}
	}
} // namespace

template <>
TALIK_PROCESSOR_VERSIONS void updateElastic<2>(
        int count, const double* lambda, const double* shear, const std::array<const double*, 4>& gradient, const std::array<double*, 4>& stress,
        const double* hoop)
{
	update<2>(count, lambda, shear, gradient, stress);
	for (int p = 0; hoop && p < count; ++p) {
		const double strain = midpointHoop(hoop[p]);
		for (int c = 0; c < 3; ++c)
			stress[c][p] += (c < 2 ? lambda[p] : lambda[p] + 2.0 * shear[p]) * strain;
	}
}

template <>
TALIK_PROCESSOR_VERSIONS void updateElastic<3>(
        int count, const double* lambda, const double* shear, const std::array<const double*, 9>& gradient, const std::array<double*, 6>& stress, const double*)
{
	update<3>(count, lambda, shear, gradient, stress);
}

} // namespace talik
