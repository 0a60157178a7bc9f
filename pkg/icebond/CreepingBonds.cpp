// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/dem/ScGeom.hpp>
#include <pkg/icebond/AttributeRefusal.hpp>
#include <pkg/icebond/CreepingBonds.hpp>
#include <pkg/icebond/IceBondCreep.hpp>
#include <pkg/icebond/IceBondPhys.hpp>
#include <pkg/rve/open/HoldGil.hpp>
#include <pkg/rve/open/StepGate.hpp>

namespace py = boost::python;

namespace talik {
namespace {
	/// 2 R_1 R_2/(R_1 + R_2) of the radii that stiffness is counted with; a flat body takes the sphere's.
	double stiffnessRadius(const yade::ScGeom& geom, const yade::IceBondMat& a, const yade::IceBondMat& b)
	{
		const double r1 = geom.refR1 > 0 ? geom.refR1 / a.radiusRatio : geom.refR2 / b.radiusRatio;
		const double r2 = geom.refR2 > 0 ? geom.refR2 / b.radiusRatio : r1;
		return 2 * r1 * r2 / (r1 + r2);
	}
} // namespace

void relaxContact(const yade::Scene& scene, yade::Interaction& contact, double overlap, const BondCreep& creep)
{
	auto*       phys = dynamic_cast<yade::IceBondPhys*>(contact.phys.get());
	const auto* geom = dynamic_cast<const yade::ScGeom*>(contact.geom.get());
	if (!phys || !geom || phys->bondNow) return;
	if (phys->carriesMoments()) throw std::invalid_argument(momentsDoNotCreep);
	IceBond bond = phys->bond();
	if (!bond.hasIceSpring()) return;
	const auto& a = static_cast<const yade::IceBondMat&>(*(*scene.bodies)[contact.id1]->material);
	const auto& b = static_cast<const yade::IceBondMat&>(*(*scene.bodies)[contact.id2]->material);
	if (phys->iceSaturation <= std::max(a.meltSaturation, b.meltSaturation)) return;
	CreepingContact c;
	c.stiffness = { phys->grainStiffness, phys->stiffnessRatio, phys->kn / phys->grainStiffness - 1 };
	c.young     = phys->kn / stiffnessRadius(*geom, a, b);
	c.area      = phys->bondArea;
	c.friction  = phys->tangensOfFrictionAngle;
	c.overlap   = overlap - phys->uRef;
	relaxIce(bond, creep, c, phys->shearForce, phys->iceShear);
	phys->setBond(bond);
}

} // namespace talik

namespace yade {
YADE_PLUGIN((CreepingBonds));

void CreepingBonds::postLoad(CreepingBonds&)
{
	constexpr AttributeRefusal require { "CreepingBonds" };
	require(temperature > -talik::IceCreepLaw::celsius, "temperature", temperature, "give a temperature in degC, above -273.15.");
	require(timeScale >= 0, "timeScale", timeScale, "give a ratio of times, 0 or more.");
}

/// Other rules have one spring for grains and ice.
void CreepingBonds::requireParallelSprings() const
{
	talik::HoldGil gil;
	for (const auto& engine : scene->engines) {
		if (engine->getClassName() != "InteractionLoop") continue;
		const py::object functors = py::object(engine).attr("lawDispatcher").attr("functors");
		for (long k = 0; k < py::len(functors); k++) {
			const py::object law = functors[k];
			if (!PyObject_HasAttrString(law.ptr(), "stiffnessRule")) continue;
			const string rule = py::extract<string>(law.attr("stiffnessRule"));
			if (rule != "parallel")
				throw std::invalid_argument(
				        "CreepingBonds needs bonds whose ice is a spring beside the grains': Law2_ScGeom_IceBondPhys_IceBond.stiffnessRule is '"
				        + rule + "', choose parallel.");
		}
	}
}

void CreepingBonds::action()
{
	const talik::StepGate gate;
	if (!iceCreep) return;
	if (!checked) requireParallelSprings();
	checked                      = true;
	const talik::BondCreep creep = iceCreep->law().over(temperature, timeScale * scene->dt);
	if (!creep.acts()) return;
	for (const auto& contact : *scene->interactions) {
		if (!contact->isReal()) continue;
		if (const auto* geom = dynamic_cast<const ScGeom*>(contact->geom.get())) talik::relaxContact(*scene, *contact, geom->penetrationDepth, creep);
	}
}

} // namespace yade
