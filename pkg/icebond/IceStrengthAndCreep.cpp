// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/dem/ScGeom.hpp>
#include <pkg/icebond/IceBondContacts.hpp>
#include <pkg/icebond/IceStrengthAndCreep.hpp>
#include <pkg/python/ScriptValues.hpp>
#include <pkg/python/StepGate.hpp>

namespace yade {
YADE_PLUGIN((IceStrength)(IceCreep)(CreepingBonds));

namespace {
	constexpr AttributeRefusal requireOfStrength { "IceStrength" }, requireOfCreep { "IceCreep" };
} // namespace

void IceStrength::postLoad(IceStrength&)
{
	requireOfStrength(referenceRate > 0, "referenceRate", referenceRate, "give a positive rate in 1/s.");
	requireOfStrength(tensileCold >= 0, "tensileCold", tensileCold, "give a number in 1/K, 0 or more.");
	requireOfStrength(shearCold >= 0, "shearCold", shearCold, "give a number in 1/K, 0 or more.");
	requireOfStrength(
	        tensileRateExponent >= 0 && tensileRateExponent < 1, "tensileRateExponent", tensileRateExponent, "give an exponent from 0 to below 1.");
	requireOfStrength(stiffnessCold >= 0, "stiffnessCold", stiffnessCold, "give a number in 1/K, 0 or more.");
	requireOfStrength(shearRateExponent >= 0 && shearRateExponent < 1, "shearRateExponent", shearRateExponent, "give an exponent from 0 to below 1.");
}

Real IceStrength::stiffnessFactor(Real temperature) const
{
	requireOfStrength(true, "stiffnessFactor: temperature", temperature, "give a temperature in degC.");
	return law().stiffness(temperature);
}

talik::IceStrengthLaw IceStrength::law() const
{
	talik::IceStrengthLaw l;
	l.tensile = { tensileCold, tensileRateExponent };
	l.shear   = { shearCold, shearRateExponent };
	TALIK_TAKE_ATTRIBUTES(l, *this, (referenceRate)(stiffnessCold))
	return l;
}

::boost::python::tuple IceStrength::factors(Real temperature, Real strainRate) const
{
	requireOfStrength(true, "factors: temperature", temperature, "give a temperature in degC.");
	requireOfStrength(strainRate >= 0, "factors: strainRate", strainRate, "give a rate in 1/s, 0 or more.");
	const auto both = law().factors(temperature, strainRate);
	return ::boost::python::make_tuple(both.tensile, both.shear);
}

void IceCreep::postLoad(IceCreep&)
{
	requireOfCreep(rateFactor >= 0, "rateFactor", rateFactor, "give a rate factor in Pa^-n/s, 0 or more.");
	requireOfCreep(exponent >= 1 && exponent <= 10, "exponent", exponent, "give an exponent from 1 to 10; Glen's is 3.");
}

talik::IceCreepLaw IceCreep::law() const
{
	talik::IceCreepLaw l;
	TALIK_TAKE_ATTRIBUTES(l, *this, (rateFactor)(exponent))
	return l;
}

Real IceCreep::rateFactorAt(Real temperature) const
{
	requireOfCreep(temperature > -talik::IceCreepLaw::celsius, "rateFactorAt: temperature", temperature, "give a temperature in degC, above -273.15.");
	return law().rateFactorAt(temperature);
}

::boost::python::tuple IceCreep::over(Real temperature, Real time) const
{
	requireOfCreep(temperature > -talik::IceCreepLaw::celsius, "over: temperature", temperature, "give a temperature in degC, above -273.15.");
	requireOfCreep(time >= 0, "over: time", time, "give a time in s, 0 or more.");
	const auto creep = law().over(temperature, time);
	return ::boost::python::make_tuple(creep.fluidity, creep.exponent);
}

} // namespace yade

namespace py = boost::python;

namespace talik {
void stiffenContact(yade::Interaction& contact, double overlap, double factor)
{
	auto* phys = dynamic_cast<yade::IceBondPhys*>(contact.phys.get());
	if (!phys || phys->bondNow) return;
	IceBond bond = phys->bond();
	bond.stiffenIce(factor, overlap - phys->uRef);
	phys->setBond(bond);
}

void relaxContact(const yade::Scene& scene, yade::Interaction& contact, double overlap, const BondCreep& creep)
{
	auto*       phys = dynamic_cast<yade::IceBondPhys*>(contact.phys.get());
	const auto* geom = dynamic_cast<const yade::ScGeom*>(contact.geom.get());
	if (!phys || !geom || phys->bondNow) return;
	if (phys->carriesMoments()) throw std::invalid_argument(momentsDoNotCreep);
	IceBond bond = phys->bond();
	if (!bond.hasIceSpring()) return;
	const auto& a     = static_cast<const yade::IceBondMat&>(*(*scene.bodies)[contact.id1]->material);
	const auto& b     = static_cast<const yade::IceBondMat&>(*(*scene.bodies)[contact.id2]->material);
	const auto& model = phys->bonds(a, b);
	if (model.melted(phys->iceSaturation)) return;
	CreepingContact c;
	c.stiffness         = phys->stiffness(phys->kno > 0 ? model.iceStiffnessRatio(phys->iceSaturation) : phys->kn / phys->grainStiffness - 1);
	const auto [r1, r2] = yade::stiffnessRadii(*geom, a, b);
	c.young             = (phys->kno > 0 ? c.stiffness.ice() : phys->kn) / (2 * r1 * r2 / (r1 + r2));
	c.area              = phys->bondArea;
	c.friction          = phys->tangensOfFrictionAngle;
	c.overlap           = overlap - phys->uRef;
	relaxIce(bond, creep, c, phys->shearForce, phys->iceShear);
	phys->setBond(bond);
}

} // namespace talik

namespace yade {

void CreepingBonds::postLoad(CreepingBonds&)
{
	constexpr AttributeRefusal require { "CreepingBonds" };
	require(temperature > -talik::IceCreepLaw::celsius, "temperature", temperature, "give a temperature in degC, above -273.15.");
	require(timeScale >= 0, "timeScale", timeScale, "give a ratio of times, 0 or more.");
}

void CreepingBonds::action()
{
	const talik::StepGate gate;
	if (!iceCreep) return;
	const talik::BondCreep creep = iceCreep->law().over(temperature, timeScale * scene->dt);
	if (!creep.acts()) return;
	for (const auto& contact : *scene->interactions) {
		if (!contact->isReal()) continue;
		if (const auto* geom = dynamic_cast<const ScGeom*>(contact->geom.get())) talik::relaxContact(*scene, *contact, geom->penetrationDepth, creep);
	}
}

} // namespace yade
