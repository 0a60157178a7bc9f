// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/boundary/Boundary.hpp>

namespace talik {

/// Rough, impermeable wall: v_s = v_l = 0 on a side or on the nodes of a box.
template <int D> class FixedBoundary final : public Boundary<D> {
public:
	explicit FixedBoundary(const Region<D>& region)
	        : Boundary<D>(region)
	{}
	std::string name() const override { return "FixedBoundary"; }
	std::string effect() const override { return "motion"; }
	void        validate(const Grid<D>& grid) const override;
	void        constrainMotion(const Grid<D>&, MotionConstraints<D>&) const override;
};

/// Frictionless, impermeable wall: v_s.n = v_l.n = 0 on a side. The wall is a plane of symmetry: the ghost nodes mirror.
template <int D> class RollerBoundary final : public Boundary<D> {
public:
	explicit RollerBoundary(const Region<D>& region)
	        : Boundary<D>(region)
	{}
	std::string name() const override { return "RollerBoundary"; }
	std::string effect() const override { return "motion"; }
	void        validate(const Grid<D>& grid) const override;
	void        constrainMotion(const Grid<D>&, MotionConstraints<D>&) const override;
};

/// Load on the free surface, a side or a line of nodes: traction vector plus pressure against the outward normal [Pa].
template <int D> class Traction final : public Boundary<D> {
public:
	/// pressure [Pa] pushes onto the surface; traction [Pa] one table per component, empty for none. On a node box, which has
	/// no normal, only the traction counts and each node carries one cell face (half at the ends of the box).
	explicit Traction(const Region<D>& region, const TimeTable& pressure, const std::vector<TimeTable>& traction = {})
	        : Boundary<D>(region)
	        , pressure_(pressure)
	        , traction_(traction)
	{}
	std::string name() const override { return "Traction"; }
	std::string effect() const override { return "motion"; }
	void        validate(const Grid<D>& grid) const override;
	bool        usesSurface() const override { return true; }
	bool        loads() const override { return true; }
	Vec<D>      traction(double time, const Vec<D>& normal) const override;

private:
	TimeTable              pressure_;
	std::vector<TimeTable> traction_;
};

} // namespace talik
