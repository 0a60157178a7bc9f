// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/dem/ScGeom.hpp>
#include <pkg/icebond/ContactForces.hpp>
#include <pkg/icebond/IceBondMoments.hpp>
#include <pkg/python/ScriptValues.hpp>

namespace yade {
YADE_PLUGIN((RollingIceBondMat)(RollingIceBondPhys)(MomentIceBondMat)(MomentIceBondPhys));

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
	const Vector3r spin      = spinBetween(interaction, scene);
	const Vector3r bending   = spin - geom.normal.dot(spin) * geom.normal;
	const Real     stiffness = kno > 0 ? 1.5 * kr * std::sqrt(std::max(geom.penetrationDepth - uRef, 0.)) : kr;
	geom.rotate(moment_bending);
	moment_bending = talik::HWY_NAMESPACE::rollingMoment(maxRollPl, normalForce.dot(geom.normal), moment_bending, Vector3r(stiffness * scene.dt * bending));
	scene.forces.addTorque(interaction.id1, -moment_bending);
	scene.forces.addTorque(interaction.id2, moment_bending);
}

void MomentIceBondMat::postLoad(MomentIceBondMat&)
{
	constexpr AttributeRefusal require { "MomentIceBondMat" };
	require(bondRadiusFactor > 0, "bondRadiusFactor", bondRadiusFactor, "give a finite number greater than 0; bonds of IceBondMat carry no moments.");
	require(momentContribution >= 0 && momentContribution <= 1, "momentContribution", momentContribution, "give a share from 0 to 1.");
}

shared_ptr<IceBondPhys> MomentIceBondMat::newContact(const IceBondMat& other, Real r1, Real r2, Real shearStiffness) const
{
	const auto* second = dynamic_cast<const MomentIceBondMat*>(&other);
	if (!second) return RollingIceBondMat::newContact(other, r1, r2, shearStiffness);
	shared_ptr<MomentIceBondPhys> phys(new MomentIceBondPhys);
	resistRolling(*phys, *second, r1, r2, shearStiffness);
	phys->bondRadiusFactor   = std::min(bondRadiusFactor, second->bondRadiusFactor);
	phys->momentContribution = std::max(momentContribution, second->momentContribution);
	return phys;
}

talik::EdgeForces<double> MomentIceBondPhys::bend(
        const ScGeom& geom, const Interaction& interaction, const Scene& scene, const talik::ContactStiffness& contact)
{
	geom.rotate(bondMoment);
	const auto     stiffness = section().stiffness(bondArea, contact.ice(), contact.shearRatio);
	const Vector3r spin      = spinBetween(interaction, scene);
	const Vector3r twisting  = geom.normal.dot(spin) * geom.normal;
	// eq. (14.12)
	bondMoment -= scene.dt * (stiffness.bending * (spin - twisting) + stiffness.twisting * twisting);
	const double along = geom.normal.dot(bondMoment), edge = section().edgeOverMoment(bondArea);
	return { edge * (bondMoment - along * geom.normal).norm(), 0.5 * edge * std::abs(along) };
}

void MomentIceBondPhys::keepBondMoment(double share) { bondMoment = share > 0 ? Vector3r(share * bondMoment) : Vector3r::Zero(); }

void MomentIceBondPhys::addMoments(const ScGeom& geom, const Interaction& interaction, Scene& scene)
{
	if (maxRollPl > 0) RollingIceBondPhys::addMoments(geom, interaction, scene);
	scene.forces.addTorque(interaction.id1, -bondMoment);
	scene.forces.addTorque(interaction.id2, bondMoment);
}

void MomentIceBondPhys::clearMoments()
{
	RollingIceBondPhys::clearMoments();
	bondMoment = Vector3r::Zero();
}

} // namespace yade
