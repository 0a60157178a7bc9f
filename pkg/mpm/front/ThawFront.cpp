// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/front/ThawFront.hpp>

namespace talik {

template <int D>
ThawFront<D>::ThawFront(PointFields& fields, const ThawFrontSettings& settings)
        : sideField_(fields.declare("frozenSide", "thaw front", "-", 1))
        , slipField_(fields.declare("slip", "thaw front", "m", 1))
        , nodes_(settings)
        , transfer_(settings.constants)
        , constants_(settings.constants)
{}

template <int D> void ThawFront<D>::bind(MaterialPoints<D>& points, const Grid<D>& grid, bool water)
{
	nodes_.bind(grid, points, points.fields().component(sideField_));
	transfer_.bind(nodes_, records_, points.fields().component(slipField_), points.capacity(), water);
}

template <int D> void ThawFront<D>::keepOnly(int firstPoint, int endPoint)
{
	nodes_.keepOnly(firstPoint, endPoint);
	transfer_.keepOnly(firstPoint, endPoint);
}

template <int D> void ThawFront<D>::find(const StepContext<D>& step, const double* iceSaturation, const Mirrors& mirrors, const std::vector<int>& freeLiquid)
{
	nodes_.find(step, iceSaturation, mirrors, freeLiquid);
	records_.clear(nodes_.count());
}

template <int D> void ThawFront<D>::addLoad(int node, double mass, const Vec<D>& force)
{
	if (present() && nodes_.slot(node) >= 0) transfer_.addLoad(nodes_.slot(node), mass, force);
}

template <int D>
void ThawFront<D>::solve(
        const StepContext<D>& step, const SolidMotion<D>& motion, const PoreWater<D>* water, const MotionConstraints<D>& constraints, const Mirrors& mirrors)
{
	if (!present()) return;
	walls_.applySymmetry(step, nodes_, mirrors, records_);
	walls_.pushAhead(step, nodes_, mirrors, motion, records_);
	contact_.solve(step, { nodes_, motion, water, constraints, constants_, step.dt }, records_, work_);
	walls_.leadWalls(step, nodes_, mirrors, motion, contact_, water != nullptr, records_);
	walls_.unfold(step, nodes_, mirrors, records_);
	for (int slot = 0; slot < nodes_.count(); ++slot)
		step.ledger.ofNode(nodes_.node(slot)).slipWork += work_[slot];
}

TALIK_IN_PLANE_AND_SPACE(ThawFront);

} // namespace talik
