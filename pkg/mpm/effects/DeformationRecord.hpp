// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/effects/Effect.hpp>

#include <algorithm>

namespace talik {

/// The points remember their deformation gradient since the start, F_new = (1 + Delta t L) F. Nothing in the step needs it; a scene has it to look at
/// strain.
template <int D> class DeformationRecord : public Effect<D> {
public:
	explicit DeformationRecord(std::string field = "deformationGradient", std::string unit = "-")
	        : field_(std::move(field))
	        , unit_(std::move(unit))
	{}
	std::string name() const override { return "deformation record"; }
	void        declareFields(PointFields& fields) override { handle_ = fields.declare(field_, name(), unit_, D * D); }
	void        start(PointFields& fields, int first, int last) override
	{
		for (int c = 0; c < D * D; ++c)
			f_[c] = fields.component(handle_, c);
		for (int i = 0; i < D; ++i)
			std::fill(f_[i * D + i] + first, f_[i * D + i] + last, 1.0);
	}
	void followStrain(const StepContext<D>&, const PointsInMotion<D>& points, int first, int last, StepAccount<D>&) override
	{
		for (int p = first; p < last; ++p)
			for (int j = 0; j < D; ++j) {
				Vec<D> column, change {};
				for (int k = 0; k < D; ++k)
					column[k] = f_[k * D + j][p];
				for (int i = 0; i < D; ++i)
					for (int k = 0; k < D; ++k)
						change[i] += points.gradient[i * D + k][p] * column[k];
				for (int i = 0; i < D; ++i)
					f_[i * D + j][p] = column[i] + change[i];
			}
	}

protected:
	std::array<double*, D * D> f_ {};

private:
	std::string         field_, unit_;
	PointFields::Handle handle_ = -1;
};

} // namespace talik
