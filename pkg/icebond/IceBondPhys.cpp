// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/dem/ScGeom.hpp>
#include <pkg/icebond/IceBondMat.hpp>
#include <pkg/icebond/IceBondPhys.hpp>

namespace yade {
YADE_PLUGIN((IceBondPhys)(Ip2_IceBondMat_IceBondMat_IceBondPhys));

talik::IceBond IceBondPhys::bond() const { return { static_cast<talik::BondState>(bondState), iceCut, uGrain, uIce }; }

void IceBondPhys::setBond(const talik::IceBond& b)
{
	bondState = static_cast<int>(b.state);
	iceCut    = b.iceCut;
	uGrain    = b.uGrain;
	uIce      = b.uIce;
}

namespace {
	/// Grains that touch because they have grown in this step do so free of force.
	Real overlapFromSwelling(const IceBondMat& a, const IceBondMat& b, const IGeom& geom)
	{
		const auto* contact = dynamic_cast<const ScGeom*>(&geom);
		if (!contact) return 0;
		const Real growth = a.growth(contact->refR1) + b.growth(contact->refR2);
		return std::min(std::max(contact->penetrationDepth, 0.), growth);
	}
} // namespace

void Ip2_IceBondMat_IceBondMat_IceBondPhys::go(const shared_ptr<Material>& m1, const shared_ptr<Material>& m2, const shared_ptr<Interaction>& interaction)
{
	if (interaction->phys) return;
	const auto& a    = static_cast<const IceBondMat&>(*m1);
	const auto& b    = static_cast<const IceBondMat&>(*m2);
	const auto& geom = static_cast<const GenericSpheresContact&>(*interaction->geom);
	// a flat body has no radius of its own: the sphere's counts for both
	const Real r1 = geom.refR1 > 0 ? geom.refR1 / a.radiusRatio : geom.refR2 / b.radiusRatio;
	const Real r2 = geom.refR2 > 0 ? geom.refR2 / b.radiusRatio : geom.refR1 / a.radiusRatio;
	const Real k1 = a.young * r1, k2 = b.young * r2;

	const Real grainStiffness = k1 + k2 > 0 ? 2 * k1 * k2 / (k1 + k2) : 0;
	const Real stiffnessRatio = a.poisson == b.poisson ? a.poisson : 2 * a.poisson * b.poisson / (a.poisson + b.poisson);

	const shared_ptr<IceBondPhys> phys = a.newContact(b, r1, r2, stiffnessRatio * grainStiffness);
	phys->grainStiffness               = grainStiffness;
	phys->stiffnessRatio               = stiffnessRatio;
	phys->tangensOfFrictionAngle       = std::tan(std::min(a.frictionAngle, b.frictionAngle));
	phys->kn                           = phys->grainStiffness;
	phys->ks                           = phys->stiffnessRatio * phys->kn;
	phys->iceSaturation                = std::min(a.iceSaturation, b.iceSaturation);
	phys->bondArea                     = std::min(a.bondAreaFactor, b.bondAreaFactor) * std::pow(std::min(r1, r2), 2);
	phys->gapLimit                     = std::min(a.bondRange, b.bondRange) * std::min(r1, r2);
	phys->bondNow                      = bondNewContacts;
	phys->uRef                         = overlapFromSwelling(a, b, *interaction->geom);
	interaction->phys                  = phys;
}

} // namespace yade
