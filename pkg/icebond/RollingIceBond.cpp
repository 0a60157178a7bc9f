// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/dem/ScGeom.hpp>
#include <pkg/icebond/AttributeRefusal.hpp>
#include <pkg/icebond/ContactForces.hpp>
#include <pkg/icebond/RollingIceBond.hpp>

namespace yade {
YADE_PLUGIN((RollingIceBondMat)(RollingIceBondPhys));

void RollingIceBondMat::postLoad(RollingIceBondMat&)
{
	constexpr AttributeRefusal require { "RollingIceBondMat" };
	const char* const          remedy = "give a finite number greater than 0; grains of IceBondMat roll freely.";
	require(alphaKr > 0, "alphaKr", alphaKr, remedy);
	require(etaRoll > 0 || (etaRoll == 0 && mayRollFreely()), "etaRoll", etaRoll, remedy);
}

shared_ptr<IceBondPhys> RollingIceBondMat::newContact(const IceBondMat& other, Real r1, Real r2, Real shearStiffness) const
{
	const auto* second = dynamic_cast<const RollingIceBondMat*>(&other);
	if (!second) return IceBondMat::newContact(other, r1, r2, shearStiffness);
	shared_ptr<RollingIceBondPhys> phys(new RollingIceBondPhys);
	resistRolling(*phys, *second, r1, r2, shearStiffness);
	return phys;
}

void RollingIceBondMat::resistRolling(RollingIceBondPhys& phys, const RollingIceBondMat& second, Real r1, Real r2, Real shearStiffness) const
{
	const Real alpha = alphaKr == second.alphaKr ? alphaKr : 2 * alphaKr * second.alphaKr / (alphaKr + second.alphaKr);
	phys.kr          = alpha * shearStiffness * r1 * r2;
	phys.maxRollPl   = std::min(etaRoll * r1, second.etaRoll * r2);
}

Vector3r RollingIceBondPhys::spinBetween(const Interaction& interaction, const Scene& scene)
{
	const auto spinOf = [&](Body::id_t id) { return (*scene.bodies)[id]->state->angVel; };
	return spinOf(interaction.id2) - spinOf(interaction.id1);
}

void RollingIceBondPhys::addMoments(const ScGeom& geom, const Interaction& interaction, Scene& scene)
{
	const Vector3r spin    = spinBetween(interaction, scene);
	const Vector3r bending = spin - geom.normal.dot(spin) * geom.normal;
	geom.rotate(moment_bending);
	moment_bending = talik::HWY_NAMESPACE::rollingMoment(maxRollPl, normalForce.dot(geom.normal), moment_bending, Vector3r(kr * scene.dt * bending));
	scene.forces.addTorque(interaction.id1, -moment_bending);
	scene.forces.addTorque(interaction.id2, moment_bending);
}

} // namespace yade
