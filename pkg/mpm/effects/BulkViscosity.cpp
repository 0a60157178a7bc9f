// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/mpm/effects/BulkViscosity.hpp>

#include <cmath>

namespace talik {

template <int D> void BulkViscosity<D>::validate(const GroundSettings<D>&) const
{
	requireSetting(viscosity >= 0.0 && std::isfinite(viscosity), "BulkViscosity.viscosity", viscosity, "must be 0 or more [Pa s]");
}

template <int D> void BulkViscosity<D>::addStress(const StepContext<D>&, const PointsInMotion<D>& points, int first, int last) const
{
	for (int p = first; p < last; ++p)
		points.addedStress[p] += stress_[p];
}

template <int D> void BulkViscosity<D>::followStrain(const StepContext<D>& step, const PointsInMotion<D>& points, int first, int last, StepAccount<D>& account)
{
	for (int p = first; p < last; ++p) {
		const double trace = points.trace(p);
		account.dampingDissipation += stress_[p] * trace * points.volume[p];
		stress_[p] = viscosity * trace / step.dt;
	}
}

template <int D> double BulkViscosity<D>::largestStep(const PointsInMotion<D>& points, int p, double spacing) const
{
	return points.mass[p] / points.volume[p] * spacing * spacing / (6.0 * D * viscosity);
}

TALIK_IN_PLANE_AND_SPACE(BulkViscosity);

} // namespace talik
