// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Vector.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>

namespace talik {

/// Effect: the points remember their deformation gradient since the start, F_new = (1 + Delta t L) F. Nothing in the step needs it;
/// a scene has it to look at strain.
template <int D> class DeformationRecord {
public:
	explicit DeformationRecord(PointFields& fields)
	        : handle(fields.declare("deformationGradient", "deformation record", "-", D * D))
	{}
	void bind(MaterialPoints<D>& points)
	{
		for (int c = 0; c < D * D; ++c)
			f[c] = points.fields().component(handle, c);
	}
	void start(int first, int end)
	{
		for (int i = 0; i < D; ++i)
			std::fill(f[i * D + i] + first, f[i * D + i] + end, 1.0);
	}
	/// gradient: Delta t dv_i/dx_j at [i*D+j] of the points first .. last-1.
	void accumulate(int first, int last, const std::array<double*, D * D>& gradient)
	{
		for (int p = first; p < last; ++p)
			for (int j = 0; j < D; ++j) {
				Vec<D> column, change {};
				for (int k = 0; k < D; ++k)
					column[k] = f[k * D + j][p];
				for (int i = 0; i < D; ++i)
					for (int k = 0; k < D; ++k)
						change[i] += gradient[i * D + k][p] * column[k];
				for (int i = 0; i < D; ++i)
					f[i * D + j][p] = column[i] + change[i];
			}
	}

private:
	PointFields::Handle        handle;
	std::array<double*, D * D> f {};
};

} // namespace talik
