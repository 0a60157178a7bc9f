// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Boundary.hpp>

namespace talik {

/// Water does not cross: v_l.n = v_s.n on a side whose solid is free to move.
template <int D> class ImpermeableBoundary final : public Boundary<D> {
public:
	explicit ImpermeableBoundary(const Region<D>& region)
	        : Boundary<D>(region)
	{
	}
	std::string name() const override { return "ImpermeableBoundary"; }
	std::string effect() const override { return "water"; }
	void        validate(const Grid<D>& grid) const override;
	void        constrainMotion(const Grid<D>&, MotionConstraints<D>&) const override;
};

} // namespace talik
