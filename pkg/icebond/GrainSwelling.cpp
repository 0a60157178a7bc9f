// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/GlobalEngine.hpp>
#include <core/Scene.hpp>
#include <pkg/common/Sphere.hpp>
#include <pkg/icebond/IceBondContacts.hpp>
#include <pkg/python/ScriptValues.hpp>
#include <pkg/python/StepGate.hpp>
#include <stdexcept>

namespace yade {
class IceBondMat;
class IceBondPhys;

/// Grain radius with pore ice, Yu & Zhao eq. (8), and what it does to the contacts. Goes before the collider.
class GrainSwelling : public GlobalEngine {
public:
	void action() override;
	/// What every formula divides by or takes a root of is checked; throws std::invalid_argument.
	void postLoad(GrainSwelling&);

	/// eq. (8): r_eq/r_0 at an ice saturation in 0..1 [-].
	Real equivalentRatio(Real iceSaturation) const;
	/// Area (dimension 3: volume) strain released by complete thaw if all of eq. (8) acts [-].
	Real fullThawStrain() const;

private:
	enum class Rule { bookkeeping, referenceOverlap, mechanical };
	Rule         rule() const;
	Real         radiusRatio(Real iceSaturation) const;
	void         registerBodies();
	bool         followIce();
	void         moveReferences() const;
	void         report();
	vector<Real> radiusBefore; ///< by id, of the present step

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(GrainSwelling,GlobalEngine,"Equivalent grain radius with pore ice, Yu & Zhao eq. (8): r_eq = r_0 "
			"[(1-n0+(n0+volumetricStrain) S_i)/(1-n0)]^(1/dimension), for spheres of :yref:`IceBondMat`. Put it before the collider. Mass, inertia, stiffness and bond "
			"area keep r_0 under every rule. Example: "
			"O.engines=[ForceResetter(),GrainSwelling(porosity=0.18,radiusRule='mechanical',thawStrain=0.03),"
			"InsertionSortCollider([Bo1_Sphere_Aabb()]),NewtonIntegrator()].",
		((string,radiusRule,"bookkeeping",Attr::triggerPostLoad,"bookkeeping: grains keep r_0, equivalentRadius is only reported (default). referenceOverlap: "
				"grains take r_eq; what they grow is subtracted from the overlap of their contacts, so no force appears, and at S_i = 0 they are back at r_0. mechanical: "
				"ice-rich ground; the grains were prepared frozen with the radii that they have in the first step; thaw shrinks them and contacts open, growth on "
				"refreezing is subtracted from the overlap."))
		((Real,porosity,0.18,Attr::triggerPostLoad,"n0, porosity of the sample of grains [-], above 0 and below 1."))
		((Real,volumetricStrain,0,Attr::triggerPostLoad,"Volumetric strain of the sample, extension positive [-], > -porosity."))
		((int,dimension,2,Attr::triggerPostLoad,"2: discs, 3: spheres."))
		((Real,thawStrain,0,Attr::triggerPostLoad,"Rule mechanical: area strain (dimension 3: volume strain) that the grains release on complete thaw [-], from 0 "
				"to fullThawStrain."))
		((Real,frozenSaturation,1,Attr::triggerPostLoad,"Rule mechanical: ice saturation at which the grains were prepared [-], above 0, at most 1."))
		((vector<Real>,preparedRadius,,Attr::readonly,"Radius of every body by id when it was first met [m]: r_0, or with the rule mechanical the radius prepared "
				"frozen; 0: no sphere of IceBondMat."))
		((vector<Real>,equivalentRadius,,Attr::readonly,"r_eq of every body by id [m] at its present ice saturation; 0: no sphere of IceBondMat."))
		((Real,thawStrainReached,0,Attr::readonly,"Area (volume) of the grains lost by thaw over that prepared [-]."))
		,/*ctor*/ ,
		/*py*/
		.def("equivalentRatio",&GrainSwelling::equivalentRatio,(::boost::python::arg("iceSaturation")),"r_eq/r_0 of eq. (8) at an ice saturation [-].")
		.add_property("fullThawStrain",&GrainSwelling::fullThawStrain,"Area (dimension 3: volume) strain on complete thaw if all of eq. (8) acts, "
				"(n0+volumetricStrain)/(1+volumetricStrain) [-].")
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(GrainSwelling);

YADE_PLUGIN((GrainSwelling));

namespace {

	constexpr AttributeRefusal require { "GrainSwelling" };

	Sphere* sphereWithIce(const Body* body)
	{
		if (!body || !dynamic_cast<IceBondMat*>(body->material.get())) return nullptr;
		return dynamic_cast<Sphere*>(body->shape.get());
	}

	const IceBondMat& materialOf(const Body& body) { return static_cast<const IceBondMat&>(*body.material); }
} // namespace

GrainSwelling::Rule GrainSwelling::rule() const
{
	if (radiusRule == "bookkeeping") return Rule::bookkeeping;
	if (radiusRule == "referenceOverlap") return Rule::referenceOverlap;
	if (radiusRule == "mechanical") return Rule::mechanical;
	throw std::invalid_argument("GrainSwelling.radiusRule is '" + radiusRule + "': choose bookkeeping, referenceOverlap or mechanical.");
}

void GrainSwelling::postLoad(GrainSwelling&)
{
	rule();
	require(porosity > 0 && porosity < 1, "porosity", porosity, "give a number above 0 and below 1.");
	require(volumetricStrain > -porosity, "volumetricStrain", volumetricStrain, "pores cannot lose more than their volume; give a number above -porosity.");
	require(dimension == 2 || dimension == 3, "dimension", dimension, "give 2 for discs or 3 for spheres.");
	require(frozenSaturation > 0 && frozenSaturation <= 1, "frozenSaturation", frozenSaturation, "give a number above 0, at most 1.");
	const Real full = fullThawStrain();
	// a little more than the full value: it is usually typed with a few digits
	require(thawStrain >= 0 && thawStrain <= full * (1 + 1e-3), "thawStrain", thawStrain,
	        "give 0 to " + talik::asText(full) + ", the value at which all of eq. (8) acts.");
}

/// Eq. (14.1).
Real GrainSwelling::equivalentRatio(Real iceSaturation) const { return talik::equivalentRadiusRatio(porosity, volumetricStrain, iceSaturation, dimension); }

Real GrainSwelling::fullThawStrain() const { return (porosity + volumetricStrain) / (1 + volumetricStrain); }

/// Radius over that first met. Area (volume) follows the ice linearly, as in eq. (8); mechanical: eq. (14.5).
Real GrainSwelling::radiusRatio(Real iceSaturation) const
{
	switch (rule()) {
		case Rule::referenceOverlap: return equivalentRatio(iceSaturation);
		case Rule::mechanical: return std::pow(1 - thawStrain * std::max(1 - iceSaturation / frozenSaturation, 0.), 1. / dimension);
		default: return 1;
	}
}

void GrainSwelling::registerBodies()
{
	const auto& bodies = *scene->bodies;
	preparedRadius.resize(bodies.size(), 0);
	equivalentRadius.resize(bodies.size(), 0);
	for (std::size_t id = 0; id < bodies.size(); ++id) {
		const Body*   body   = bodies[id].get();
		const Sphere* sphere = sphereWithIce(body);
		// grains that join later come as they are: with the radius of their material now
		if (sphere && preparedRadius[id] == 0) preparedRadius[id] = sphere->radius / materialOf(*body).radiusRatio;
	}
}

/// Gives every grain the radius of its ice; true if one changed.
bool GrainSwelling::followIce()
{
	for (std::size_t id = 0; id < preparedRadius.size(); ++id) {
		const Body* body = (*scene->bodies)[id].get();
		if (!sphereWithIce(body)) continue;
		auto& material             = static_cast<IceBondMat&>(*body->material);
		material.radiusRatioBefore = material.radiusRatio;
	}
	bool changed = false;
	radiusBefore.resize(preparedRadius.size());
	for (std::size_t id = 0; id < preparedRadius.size(); ++id) {
		Body*   body   = (*scene->bodies)[id].get();
		Sphere* sphere = sphereWithIce(body);
		if (!sphere) continue;
		auto&      material  = static_cast<IceBondMat&>(*body->material);
		const Real ratio     = radiusRatio(material.iceSaturation);
		const Real radius    = preparedRadius[id] * ratio;
		changed              = changed || radius != sphere->radius;
		radiusBefore[id]     = sphere->radius;
		sphere->radius       = radius;
		material.radiusRatio = ratio;
	}
	return changed;
}

/// Contacts that exist take no force from growth. Shrinkage gives growth back first; beyond it only the rule referenceOverlap keeps
/// the force of intact bonds, while a frictional contact cannot push across a gap.
void GrainSwelling::moveReferences() const
{
	const bool keepsForce = rule() == Rule::referenceOverlap;
	for (const auto& interaction : *scene->interactions) {
		auto* phys = dynamic_cast<IceBondPhys*>(interaction->phys.get());
		if (!phys) continue;
		const std::size_t ids[]          = { std::size_t(interaction->id1), std::size_t(interaction->id2) };
		Real              swellingBefore = 0, swellingNow = 0;
		for (const auto id : ids) {
			const Sphere* sphere = sphereWithIce((*scene->bodies)[id].get());
			if (!sphere) continue;
			swellingBefore += radiusBefore[id] - preparedRadius[id];
			swellingNow += sphere->radius - preparedRadius[id];
		}
		// in one piece for contacts older than the ice, so that nothing is left of it when the ice is gone
		const bool olderThanIce = phys->uRef == swellingBefore;
		const Real reference    = olderThanIce ? swellingNow : phys->uRef + (swellingNow - swellingBefore);
		const bool bonded       = phys->bondState == int(talik::BondState::BONDED);
		phys->uRef              = keepsForce && bonded ? reference : std::max(reference, 0.);
	}
}

void GrainSwelling::report()
{
	const bool preparedFrozen = rule() == Rule::mechanical;
	const Real preparedRatio  = preparedFrozen ? equivalentRatio(1) : 1;
	Real       prepared = 0, present = 0;
	for (std::size_t id = 0; id < preparedRadius.size(); ++id) {
		const Body*   body   = (*scene->bodies)[id].get();
		const Sphere* sphere = sphereWithIce(body);
		equivalentRadius[id] = 0;
		if (!sphere) continue;
		equivalentRadius[id] = preparedRadius[id] * equivalentRatio(materialOf(*body).iceSaturation) / preparedRatio;
		prepared += std::pow(preparedRadius[id], dimension);
		present += std::pow(sphere->radius, dimension);
	}
	thawStrainReached = preparedFrozen && prepared > 0 ? 1 - present / prepared : 0;
}

void GrainSwelling::action()
{
	const talik::StepGate gate;
	registerBodies();
	if (followIce()) {
		moveReferences();
		scene->doSort = true; // the collider does not see radii change
	}
	report();
}

} // namespace yade
