// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Boundary.hpp>

namespace talik {

/// Frictionless, impermeable wall: v_s.n = v_l.n = 0 on a side. The wall is a plane of symmetry: the ghost nodes mirror.
template <int D> class RollerBoundary final : public Boundary<D> {
public:
	explicit RollerBoundary(const Region<D>& region)
	        : Boundary<D>(region)
	{
	}
	std::string name() const override { return "RollerBoundary"; }
	std::string effect() const override { return "motion"; }
	void        validate(const Grid<D>& grid) const override;
	void        constrainMotion(const Grid<D>&, MotionConstraints<D>&) const override;
};

} // namespace talik
