// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/Errors.hpp>
#include <pkg/base/ParameterList.hpp>
#include <pkg/mpm/effects/Effect.hpp>

#include <cmath>

/// Parameters of BulkViscosity, for the model and for the class that a script sees.
// clang-format off
#define TALIK_BULK_VISCOSITY \
	((Real, viscosity, 0,,"Bulk viscosity eta [Pa s], >= 0, in time of motion. 0.06 rho c h, with density, wave speed and grid spacing, is common for shocks. " \
		"Limits the time step to rho h^2/(6 D eta)."))
// clang-format on

namespace talik {

/// A mean stress in proportion to the rate of volume change, eq. (28.1): it damps pressure waves, the shorter ones faster, and leaves shear alone.
/// In use from the step after the one whose strain it follows.
template <int D> class BulkViscosity final : public Effect<D> {
public:
	TALIK_PARAMETERS(TALIK_BULK_VISCOSITY)

	std::string name() const override { return "bulk viscosity"; }
	void        validate(const GroundSettings<D>&) const override
	{
		requireSetting(viscosity >= 0.0 && std::isfinite(viscosity), "BulkViscosity.viscosity", viscosity, "must be 0 or more [Pa s]");
	}
	void declareFields(PointFields& fields) override { fields.declare("viscousStress", name(), "Pa", stress_); }
	bool addsStress() const override { return true; }
	void addStress(const StepContext<D>&, const PointsInMotion<D>& points, int first, int last) const override
	{
		for (int p = first; p < last; ++p)
			points.addedStress[p] += stress_[p];
	}
	void followStrain(const StepContext<D>& step, const PointsInMotion<D>& points, int first, int last, StepAccount<D>& account) override
	{
		for (int p = first; p < last; ++p) {
			const double trace = points.trace(p);
			account.dampingDissipation += stress_[p] * trace * points.volume[p];
			stress_[p] = viscosity * trace / step.dt;
		}
	}
	bool limitsStep() const override { return viscosity > 0.0; }
	/// Eq. (28.2).
	double largestStep(const PointsInMotion<D>& points, int p, double spacing) const override
	{
		return points.mass[p] / points.volume[p] * spacing * spacing / (6.0 * D * viscosity);
	}

private:
	double* stress_ = nullptr; ///< tension positive [Pa]
};

} // namespace talik
