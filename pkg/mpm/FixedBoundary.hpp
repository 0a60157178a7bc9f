// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Boundary.hpp>

namespace talik {

/// Rough, impermeable wall: v_s = v_l = 0 on a side or on the nodes of a box.
template <int D> class FixedBoundary final : public Boundary<D> {
public:
	explicit FixedBoundary(const Region<D>& region)
	        : Boundary<D>(region)
	{
	}
	std::string name() const override { return "FixedBoundary"; }
	std::string effect() const override { return "motion"; }
	void        validate(const Grid<D>& grid) const override;
	void        constrainMotion(const Grid<D>&, MotionConstraints<D>&) const override;
};

} // namespace talik
