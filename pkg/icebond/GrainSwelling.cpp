// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/common/Sphere.hpp>
#include <pkg/icebond/GrainSwelling.hpp>
#include <pkg/icebond/IceBondContacts.hpp>
#include <pkg/python/ScriptValues.hpp>
#include <pkg/python/StepGate.hpp>
#include <stdexcept>

namespace yade {
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
	const Real full = fullThawStrain();
	// a little more than the full value: it is usually typed with a few digits
	require(thawStrain >= 0 && thawStrain <= full * (1 + 1e-3), "thawStrain", thawStrain,
	        "give 0 to " + boost::lexical_cast<string>(full) + ", the value at which all of eq. (8) acts.");
}

Real GrainSwelling::equivalentRatio(Real iceSaturation) const { return talik::equivalentRadiusRatio(porosity, volumetricStrain, iceSaturation, dimension); }

Real GrainSwelling::fullThawStrain() const { return (porosity + volumetricStrain) / (1 + volumetricStrain); }

/// Radius over that first met. Area (volume) follows the ice linearly, as in eq. (8).
Real GrainSwelling::radiusRatio(Real iceSaturation) const
{
	switch (rule()) {
		case Rule::referenceOverlap: return equivalentRatio(iceSaturation);
		case Rule::mechanical: return std::pow(1 - thawStrain * (1 - iceSaturation), 1. / dimension);
		default: return 1;
	}
}

void GrainSwelling::registerBodies()
{
	const auto& bodies = *scene->bodies;
	preparedRadius.resize(bodies.size(), 0);
	equivalentRadius.resize(bodies.size(), 0);
	for (std::size_t id = 0; id < bodies.size(); id++) {
		const Body*   body   = bodies[id].get();
		const Sphere* sphere = sphereWithIce(body);
		// grains that join later come as they are: with the radius of their material now
		if (sphere && preparedRadius[id] == 0) preparedRadius[id] = sphere->radius / materialOf(*body).radiusRatio;
	}
}

/// Gives every grain the radius of its ice; true if one changed.
bool GrainSwelling::followIce()
{
	for (std::size_t id = 0; id < preparedRadius.size(); id++) {
		const Body* body = (*scene->bodies)[id].get();
		if (!sphereWithIce(body)) continue;
		auto& material             = static_cast<IceBondMat&>(*body->material);
		material.radiusRatioBefore = material.radiusRatio;
	}
	bool changed = false;
	radiusBefore.resize(preparedRadius.size());
	for (std::size_t id = 0; id < preparedRadius.size(); id++) {
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
	for (std::size_t id = 0; id < preparedRadius.size(); id++) {
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
