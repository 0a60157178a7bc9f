// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/icebond/BondTable.hpp>
#include <pkg/icebond/ContactForces.hpp>
#include <pkg/icebond/IceBondContacts.hpp>
#include <pkg/python/ScriptValues.hpp>

namespace yade {
YADE_PLUGIN((IceBondMat)(IceBondPhys)(Ip2_IceBondMat_IceBondMat_IceBondPhys)(Law2_ScGeom_IceBondPhys_IceBond));

talik::IceBondModel IceBondMat::model() const
{
	talik::IceBondModel m;
	m.young = young;
#define TALIK_TAKE(name, initial, unit, range, mixing, help, note) m.name = name;
	TALIK_BOND_PARAMETERS(TALIK_TAKE)
#undef TALIK_TAKE
	return m;
}

void IceBondMat::takeBonds(const talik::IceBondModel& m)
{
#define TALIK_TAKE(name, initial, unit, range, mixing, help, note) name = m.name;
	TALIK_BOND_PARAMETERS(TALIK_TAKE)
#undef TALIK_TAKE
	numberBonds();
}

/// Ice saturation changes often and leaves the parameters, and what was mixed of them, as they are.
void IceBondMat::numberBonds()
{
	const auto now = model();
	if (!talik::sameBonds(now, numbered.model)) numbered = { now, talik::nextBondNumber() };
}

std::shared_ptr<const talik::BondMixture> IceBondMat::mixedWith(const IceBondMat& second) const
{
	return mixtures.with({ model(), numbered.number }, { second.model(), second.numbered.number });
}

talik::HertzMindlin IceBondMat::elasticityWith(const IceBondMat& second) const
{
	return hertzMindlin && second.hertzMindlin ? talik::HertzMindlin::of(young, poisson, second.young, second.poisson) : talik::HertzMindlin();
}

shared_ptr<IceBondPhys> IceBondMat::newContact(const IceBondMat&, Real, Real, Real) const { return shared_ptr<IceBondPhys>(new IceBondPhys); }

namespace {
	constexpr AttributeRefusal require { "IceBondMat" };
} // namespace

void IceBondMat::postLoad(IceBondMat&)
{
	require(iceSaturation >= 0 && iceSaturation <= 1, "iceSaturation", iceSaturation, "give a saturation from 0 to 1.");
	require(!hertzMindlin || (poisson >= 0 && poisson < 0.5), "poisson", poisson, "with hertzMindlin it is Poisson's ratio of the grains, 0 to below 0.5.");
	const auto bonds = model();
	for (const auto& parameter : talik::bondParameters)
		require(parameter.isValid(bonds), parameter.name, bonds.*parameter.value, parameter.remedy());
	require(radiusRatio > 0, "radiusRatio", radiusRatio, "it is a positive ratio that GrainSwelling sets; leave it out.");
	require(radiusRatioBefore > 0, "radiusRatioBefore", radiusRatioBefore, "it is a positive ratio that GrainSwelling sets; leave it out.");
	numberBonds();
}

talik::IceBond IceBondPhys::bond() const { return { static_cast<talik::BondState>(bondState), iceCut, uGrain, uIce }; }

void IceBondPhys::setBond(const talik::IceBond& b)
{
	bondState = int(b.state);
	iceCut    = b.iceCut;
	uGrain    = b.uGrain;
	uIce      = b.uIce;
}

const talik::IceBondModel& IceBondPhys::bonds(const IceBondMat& first, const IceBondMat& second)
{
	if (!mixture || !first.agree(*mixture, second)) mixture = first.mixedWith(second);
	return mixture->model;
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

std::pair<Real, Real> stiffnessRadii(const GenericSpheresContact& geom, const IceBondMat& first, const IceBondMat& second)
{
	const Real r1 = geom.refR1 / first.radiusRatio, r2 = geom.refR2 / second.radiusRatio;
	return { r1 > 0 ? r1 : r2, r2 > 0 ? r2 : r1 };
}

void Ip2_IceBondMat_IceBondMat_IceBondPhys::go(const shared_ptr<Material>& m1, const shared_ptr<Material>& m2, const shared_ptr<Interaction>& interaction)
{
	if (interaction->phys) return;
	const auto& a       = static_cast<const IceBondMat&>(*m1);
	const auto& b       = static_cast<const IceBondMat&>(*m2);
	const auto& geom    = static_cast<const GenericSpheresContact&>(*interaction->geom);
	const auto [r1, r2] = stiffnessRadii(geom, a, b);
	const Real k1 = a.young * r1, k2 = b.young * r2;

	// stiffness and area of a bond, eq. (14.2)
	const Real grainStiffness = k1 + k2 > 0 ? 2 * k1 * k2 / (k1 + k2) : 0;
	const Real ofSprings      = a.poisson == b.poisson ? a.poisson : 2 * a.poisson * b.poisson / (a.poisson + b.poisson);
	const auto elasticity     = a.elasticityWith(b);
	const Real stiffnessRatio = elasticity.acts() ? elasticity.shearRatio : ofSprings, hertz = elasticity.stiffness(r1, r2);

	const shared_ptr<IceBondPhys> phys = a.newContact(b, r1, r2, stiffnessRatio * (elasticity.acts() ? hertz : grainStiffness));
	phys->grainStiffness               = grainStiffness;
	phys->stiffnessRatio               = stiffnessRatio;
	phys->kno                          = hertz;
	phys->tangensOfFrictionAngle       = std::tan(std::min(a.frictionAngle, b.frictionAngle));
	phys->kn                           = elasticity.acts() ? 0 : grainStiffness; // until the law has seen its overlap
	phys->ks                           = phys->stiffnessRatio * phys->kn;
	phys->iceSaturation                = std::min(a.iceSaturation, b.iceSaturation);
	const auto& bonds                  = phys->bonds(a, b);
	phys->bondArea                     = bonds.bondAreaFactor * std::pow(std::min(r1, r2), 2);
	phys->gapLimit                     = bonds.bondRange * std::min(r1, r2);
	phys->bondNow                      = bondNewContacts;
	phys->uRef                         = overlapFromSwelling(a, b, *interaction->geom);
	interaction->phys                  = phys;
}

using talik::BondFailure;
using talik::BondState;
using talik::BondStrength;
using talik::ContactStiffness;
using Forces = talik::ContactForces<double, Vector3r>;

ContactStiffness Law2_ScGeom_IceBondPhys_IceBond::stiffness(const Contact& c, double iceSaturation) const
{
	return c.phys.stiffness(c.model.iceStiffnessRatio(iceSaturation));
}

/// Without its bond a contact cannot push across a gap that shrinking grains have left, see GrainSwelling.
void Law2_ScGeom_IceBondPhys_IceBond::meltBond(Contact& c)
{
	c.bond.melt(c.phys.shearForce, c.phys.iceShear);
	c.phys.keepBondMoment(0);
	if (c.phys.uRef >= 0) return;
	c.phys.uRef = 0;
	c.un        = c.geom.penetrationDepth;
}

void Law2_ScGeom_IceBondPhys_IceBond::formOrMelt(Contact& c, double iceSaturation)
{
	const double before   = c.phys.iceSaturation;
	const bool   bondable = c.bond.state == BondState::NONE || (healBroken && c.bond.state == BondState::BROKEN);
	if (c.model.melted(iceSaturation)) {
		if (c.bond.state != BondState::BONDED || !c.model.bondsOutlastIce()) meltBond(c);
	} else if (bondable && c.un >= -c.phys.gapLimit && (c.phys.bondNow || c.model.formsBonds(before, iceSaturation))) c.bond.form(c.un, c.phys.iceShear);
	c.phys.bondNow = false;
}

void Law2_ScGeom_IceBondPhys_IceBond::takeUpIceSaturation(Contact& c, double iceSaturation)
{
	const double before = c.phys.iceSaturation;
	if (iceSaturation == before && !c.phys.bondNow) return;
	formOrMelt(c, iceSaturation);
	const ContactStiffness former = stiffness(c, before), present = stiffness(c, iceSaturation);
	c.bond.changeStiffness(former, present, c.un, c.phys.shearForce, c.phys.iceShear);
	if (present.iceRatio < former.iceRatio) c.phys.keepBondMoment(present.iceRatio / former.iceRatio);
	c.phys.iceSaturation = iceSaturation;
}

void Law2_ScGeom_IceBondPhys_IceBond::countBroken()
{
#pragma omp atomic
	++brokenBonds;
}

void Law2_ScGeom_IceBondPhys_IceBond::respond(Contact& c, const ContactStiffness& k)
{
	const double friction = c.phys.tangensOfFrictionAngle, area = c.phys.bondArea, saturation = c.phys.iceSaturation;
	BondStrength strength { 0, 0 };
	if (c.bond.intact()) strength = { c.model.tensileStrengthAt(saturation) * area, c.model.shearStrengthAt(saturation) * area };
	const auto   springs = c.bond.response(k, strength);
	const double un      = c.un;
	const auto   contact = k.isHertz() ? talik::HWY_NAMESPACE::responseAt<true>(springs, un) : springs;
	const auto   settle  = [&](bool, Forces& forces) {
                if (c.bond.settle(k, strength, friction, c.model.melted(saturation), forces) != BondFailure::none) countBroken();
	};
	c.geom.rotate(c.phys.shearForce);
	c.geom.rotate(c.phys.iceShear);
	const Vector3r increment = k.shearRatio * k.spring(springs, un).tangent * c.geom.shearIncrement();
	const auto     forces    = [&](const auto& edge) {
                return talik::HWY_NAMESPACE::bondedForces(contact, friction, un, c.phys.shearForce, c.phys.iceShear, increment, edge, settle);
	};
	const bool   bends = c.bond.intact() && c.phys.carriesMoments();
	const Forces f     = bends ? forces(c.phys.bend(c.geom, c.interaction, *scene, k)) : forces(talik::NoMoments());
	if (bends && !c.bond.intact()) c.phys.keepBondMoment(0);
	c.phys.normalForce = f.normal * c.geom.normal;
	c.phys.shearForce  = f.shear;
	c.phys.iceShear    = f.iceShear;
	c.phys.kn          = k.spring(c.bond.response(k, strength), un).tangent;
	c.phys.ks          = k.shearRatio * c.phys.kn;
}

void Law2_ScGeom_IceBondPhys_IceBond::applyForces(const Contact& c, const Interaction* interaction) const
{
	const Body::id_t id1 = interaction->getId1(), id2 = interaction->getId2();
	const Vector3r   force = -c.phys.normalForce - c.phys.shearForce;
	scene->forces.addForce(id1, force);
	scene->forces.addForce(id2, -force);
	if (scene->isPeriodic || sphericalBodies) {
		const double   halfOverlap = 0.5 * c.geom.penetrationDepth;
		const Vector3r moment      = c.geom.normal.cross(force);
		scene->forces.addTorque(id1, (c.geom.radius1 - halfOverlap) * moment);
		scene->forces.addTorque(id2, (c.geom.radius2 - halfOverlap) * moment);
	} else {
		scene->forces.addTorque(id1, (c.geom.contactPoint - (*scene->bodies)[id1]->state->pos).cross(force));
		scene->forces.addTorque(id2, -(c.geom.contactPoint - (*scene->bodies)[id2]->state->pos).cross(force));
	}
}

/// A contact without bond that has opened ends, unless the swollen grains still overlap: its reference is then kept for their
/// return. True if it is kept.
bool Law2_ScGeom_IceBondPhys_IceBond::stayOpen(Contact& c) const
{
	if (c.geom.penetrationDepth < 0) return false;
	c.bond.iceCut      = c.bond.state == BondState::BROKEN;
	c.phys.iceShear    = Vector3r::Zero();
	c.phys.shearForce  = Vector3r::Zero();
	c.phys.normalForce = Vector3r::Zero();
	c.phys.clearMoments();
	c.phys.setBond(c.bond);
	return true;
}

bool Law2_ScGeom_IceBondPhys_IceBond::go(shared_ptr<IGeom>& ig, shared_ptr<IPhys>& ip, Interaction* interaction)
{
	const auto&  geom          = static_cast<const ScGeom&>(*ig);
	auto&        phys          = static_cast<IceBondPhys&>(*ip);
	const auto&  a             = static_cast<const IceBondMat&>(*(*scene->bodies)[interaction->id1]->material);
	const auto&  b             = static_cast<const IceBondMat&>(*(*scene->bodies)[interaction->id2]->material);
	const double iceSaturation = std::min(a.iceSaturation, b.iceSaturation); // the grain with less ice decides
	Contact      c { geom, phys, phys.bonds(a, b), phys.bond(), geom.penetrationDepth - phys.uRef, *interaction };

	takeUpIceSaturation(c, iceSaturation);
	if (c.un < 0 && c.bond.state != BondState::BONDED) return stayOpen(c);

	respond(c, stiffness(c, iceSaturation));
	if (c.un < 0 && c.bond.state != BondState::BONDED) return stayOpen(c);
	phys.setBond(c.bond);
	applyForces(c, interaction);
	phys.addMoments(geom, *interaction, *scene);
	return true;
}

} // namespace yade
