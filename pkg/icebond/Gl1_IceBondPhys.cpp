// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <core/Scene.hpp>
#include <pkg/dem/ScGeom.hpp>
#include <pkg/icebond/Gl1_IceBondPhys.hpp>

namespace yade {
YADE_PLUGIN((Gl1_IceBondPhys));

Real Gl1_IceBondPhys::maxForce;
Real Gl1_IceBondPhys::maxRadius;

namespace {
	constexpr Real thinnest = 0.1; // rod over the thickest: unloaded bonds remain visible

	void drawRod(const Vector3r& start, const Vector3r& end, Real radius)
	{
		constexpr int  sides = 8;
		const Vector3r axis  = (end - start).normalized();
		const Vector3r u = axis.unitOrthogonal(), v = axis.cross(u);
		glBegin(GL_QUAD_STRIP);
		for (int side = 0; side <= sides; ++side) {
			const Real     angle  = 2 * M_PI * side / sides;
			const Vector3r offset = radius * (std::cos(angle) * u + std::sin(angle) * v);
			const Vector3r a = start + offset, b = end + offset;
			glVertex3d(a[0], a[1], a[2]);
			glVertex3d(b[0], b[1], b[2]);
		}
		glEnd();
	}

	void drawLine(const Vector3r& start, const Vector3r& end)
	{
		glBegin(GL_LINES);
		glVertex3d(start[0], start[1], start[2]);
		glVertex3d(end[0], end[1], end[2]);
		glEnd();
	}
} // namespace

Real Gl1_IceBondPhys::radiusFor(const IceBondPhys& phys) const
{
	const Real force = (phys.normalForce + phys.shearForce).norm();
	maxForce         = std::max(maxForce, force);
	const Real part  = maxForce > 0 ? force / maxForce : 0;
	return maxRadius * std::max(part, thinnest);
}

/// In a periodic scene the image of a point inside the cell.
Vector3r Gl1_IceBondPhys::wrapped(const Vector3r& position) const
{
	if (!scene->isPeriodic) return position;
	Vector3r cells = scene->cell->hSize.inverse() * position;
	for (int axis = 0; axis < 3; ++axis)
		cells[axis] -= std::floor(cells[axis]);
	return scene->cell->hSize * cells;
}

void Gl1_IceBondPhys::go(
        const shared_ptr<IPhys>& ip, const shared_ptr<Interaction>& interaction, const shared_ptr<Body>& first, const shared_ptr<Body>& second, bool wire)
{
	const auto* geom = dynamic_cast<const GenericSpheresContact*>(interaction->geom.get());
	if (!geom || !first || !second || !scene) return;
	const auto& phys   = static_cast<const IceBondPhys&>(*ip);
	Vector3r    branch = second->state->se3.position - first->state->se3.position;
	if (scene->isPeriodic) branch += scene->cell->hSize * interaction->cellDist.cast<Real>();
	if (!(branch.squaredNorm() > 0)) return;
	if (!(maxRadius > 0)) maxRadius = 0.25 * std::min(geom->refR1, geom->refR2);

	const Vector3r     start = wrapped(first->state->se3.position);
	const talik::Unlit unlit(true);
	glColor3d(phys.bondState == int(talik::BondState::BONDED) ? 0.9 : 0., 0., 0.);
	if (wire) drawLine(start, start + branch);
	else drawRod(start, start + branch, radiusFor(phys));
}

} // namespace yade
