// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <core/TimeStepper.hpp>
#include <pkg/base/Errors.hpp>
#include <pkg/common/ElastMat.hpp>
#include <pkg/common/Sphere.hpp>
#include <pkg/multiscale/bodies/BodyContact.hpp>
#include <pkg/python/ScriptValues.hpp>

namespace yade {
YADE_PLUGIN((BodyContact));

namespace {
	constexpr int  numbersPerImpulse = 7;
	constexpr Real courantNumber     = 0.3; // of the time that a wave needs through the smallest sphere
	constexpr Real mostBodySteps     = 100; // that one step of the ground covers

	bool isClump(const Body& body) { return body.clumpId == body.id; }

	/// The body that moves: the clump of a member.
	const Body& mover(const Scene& scene, const Body& body) { return body.clumpId >= 0 ? *(*scene.bodies)[body.clumpId] : body; }

	bool hasTimeStepper(const Scene& scene)
	{
		for (const auto& engine : scene.engines) {
			const auto* stepper = dynamic_cast<const TimeStepper*>(engine.get());
			if (stepper && stepper->active && !stepper->dead) return true;
		}
		return false;
	}
} // namespace

talik::RigidContactSettings BodyContact::build(int dimension) const
{
	talik::requireSetting(std::isfinite(thickness) && thickness > 0, "BodyContact.thickness", thickness, "must be positive, in m");
	talik::requireSetting(
	        dimension == 2 || thickness == 1, "BodyContact.thickness", thickness, "must be 1 in space, where the ground has its own thickness");
	talik::requireSetting(
	        std::isnan(frictionAngle) || (frictionAngle >= 0 && frictionAngle < 90), "BodyContact.frictionAngle", frictionAngle,
	        "must lie in [0, 90), in degrees");
	talik::requireSetting(
	        !(frictionAngle > 0 && frictionAngle < 1.58), "BodyContact.frictionAngle", frictionAngle,
	        "is in degrees, as in MohrCoulombSkeleton (FrictMat has radians); give " + std::to_string(int(std::lround(frictionAngle * 180 / M_PI)))
	                + " if radians were meant");
	talik::RigidContactSettings settings;
	settings.stiffness = stiffness;
	settings.damping   = damping;
	settings.validate();
	return settings;
}

// ---- from the scene to the ground ------------------------------------------------------------------------------------------

void BodyContact::refuse(const Body& body, const string& reason) const
{
	throw std::invalid_argument(
	        "O.bodies[" + std::to_string(body.id) + "] (" + body.shape->getClassName() + ") cannot meet the ground: " + reason
	        + "; BodyContact.mask may leave it out.");
}

Real BodyContact::frictionOf(const Body& body) const
{
	if (!std::isnan(frictionAngle)) return std::tan(frictionAngle * M_PI / 180);
	const auto* material = dynamic_cast<const FrictMat*>(body.material.get());
	if (!material) refuse(body, "its material has no frictionAngle: give it a FrictMat or set BodyContact.frictionAngle");
	return std::tan(material->frictionAngle);
}

bool BodyContact::hasNewBodies(const Scene& scene) const { return bodiesChecked != scene.bodies->size(); }

void BodyContact::collect(const Scene& scene, const Engine& mpm, SceneBodies& met)
{
	checkEngines(scene, mpm);
	met.clear();
	const BodyContainer& all = *scene.bodies;
	for (size_t id = 0; id < all.size(); ++id) {
		const Body* body = all[id].get();
		if (!body || !body->shape || isClump(*body) || (mask != 0 && (body->groupMask & mask) == 0)) continue;
		const string reason = met.add(*body, [this](const Body& of) { return frictionOf(of); });
		if (!reason.empty()) refuse(*body, reason);
	}
	met.show();
	limitByContact(scene, met);
	if (hasNewBodies(scene)) refuseOverlap(scene, met);
	bodiesChecked = all.size();
}

void BodyContact::checkEngines(const Scene& scene, const Engine& mpm)
{
	if (enginesChecked) return;
	bool reset = false, reached = false;
	for (const auto& engine : scene.engines) {
		reached           = reached || engine.get() == &mpm;
		const string name = engine->getClassName();
		if (name == "ForceResetter" && !reached) reset = true;
		if (name == "NewtonIntegrator" && !reached)
			throw std::invalid_argument("MpmEngine.bodies: NewtonIntegrator stands before MpmEngine in O.engines, so that bodies never feel the "
			                            "ground; put MpmEngine before it.");
	}
	if (reached && !reset)
		throw std::invalid_argument("MpmEngine.bodies: no ForceResetter before MpmEngine in O.engines, so that forces on bodies would add up from step "
		                            "to step; put ForceResetter() first.");
	enginesChecked = true;
}

void BodyContact::refuseOverlap(const Scene& scene, const SceneBodies& met) const
{
	const auto overlap = met.deepestOverlap();
	if (overlap.met < 0) return;
	refuse(*(*scene.bodies)[met.id(overlap.met)],
	       "the ground's material points lie up to " + talik::asText(overlap.depth) + " m inside it: move it or leave the ground out there");
}

void BodyContact::limitByContact(const Scene& scene, const SceneBodies& met)
{
	grips.assign(scene.bodies->size(), {});
	for (size_t b = 0; b < met.count(); ++b) {
		const auto grip = met.gripOn(b);
		if (!std::isfinite(grip.spring)) continue;
		auto& whole = grips[mover(scene, *(*scene.bodies)[met.id(b)]).id];
		whole.spring += thickness * grip.spring;
		whole.dashpot += thickness * grip.dashpot;
	}
	contactLimit = std::numeric_limits<Real>::infinity();
	for (size_t id = 0; id < grips.size(); ++id) {
		if (grips[id].spring == 0) continue;
		const State& state = *(*scene.bodies)[id]->state;
		if (met.movesFreely(state)) contactLimit = std::min(contactLimit, met.timeStep(state.mass, grips[id]));
	}
}

// ---- from the ground to the scene ------------------------------------------------------------------------------------------

void BodyContact::take(SceneBodies& met, Real interval)
{
	// what is still to be delivered of bodies that are there no more is nobody's
	vector<Real> former;
	former.swap(pending);
	for (size_t b = 0; b < met.count(); ++b) {
		const auto received = met.take(b);
		const Real id       = met.id(b);
		pending.push_back(id);
		for (const Vector3r& vector : { received.impulse, received.angularImpulse })
			for (int a = 0; a < 3; ++a)
				pending.push_back(thickness * vector[a]);
		for (size_t k = 0; k < former.size(); k += numbersPerImpulse)
			if (former[k] == id)
				for (int i = 1; i < numbersPerImpulse; ++i)
					pending[pending.size() - numbersPerImpulse + i] += former[k + i];
	}
	ahead += interval;
}

void BodyContact::deliver(Scene& scene)
{
	const Real share = ahead > scene.dt * (1 + 1e-9) ? scene.dt / ahead : 1;
	for (size_t k = 0; k < pending.size(); k += numbersPerImpulse) {
		const auto id = Body::id_t(pending[k]);
		if (size_t(id) >= scene.bodies->size() || !(*scene.bodies)[id]) continue;
		Real* impulse = &pending[k + 1];
		scene.forces.addForce(id, Vector3r(impulse[0], impulse[1], impulse[2]) * (share / scene.dt));
		scene.forces.addTorque(id, Vector3r(impulse[3], impulse[4], impulse[5]) * (share / scene.dt));
		for (int i = 0; i < numbersPerImpulse - 1; ++i)
			impulse[i] -= share * impulse[i];
	}
	ahead = share < 1 ? ahead - scene.dt : 0;
}

// ---- steps -----------------------------------------------------------------------------------------------------------------

Real BodyContact::due(const Scene& scene) const { return scene.dt - ahead; }

Real BodyContact::timeStep(const Scene& scene, const SceneBodies& met, Real stableStep) const
{
	if (hasTimeStepper(scene)) return std::min(contactLimit, scene.dt);
	Real limit         = std::min(contactLimit, stableStep);
	bool meetEachOther = false;
	for (const auto& engine : scene.engines)
		meetEachOther = meetEachOther || engine->getClassName() == "InteractionLoop";
	if (!meetEachOther || met.count() < 2) return limit;
	for (size_t b = 0; b < met.count(); ++b) {
		const Body& body     = *(*scene.bodies)[met.id(b)];
		const auto* material = dynamic_cast<const ElastMat*>(body.material.get());
		const auto* sphere   = dynamic_cast<const Sphere*>(body.shape.get());
		if (sphere && material && met.movesFreely(*mover(scene, body).state))
			limit = std::min(limit, courantNumber * sphere->radius * std::sqrt(material->density / material->young));
	}
	return limit;
}

Real BodyContact::groundStep(const Scene& scene, Real stableStep) const
{
	const Real longest = std::min(stableStep, contactLimit);
	if (scene.dt > contactLimit * (1 + 1e-9))
		throw std::runtime_error(
		        "MpmEngine: O.dt = " + talik::asText(scene.dt) + " s is too long for the contact of ground and bodies: set it to at most "
		        + talik::asText(contactLimit) + " s, or lower BodyContact.stiffness.");
	const Real more = std::floor((longest - due(scene)) / scene.dt * (1 + 1e-12));
	return due(scene) + scene.dt * std::max(Real(0), std::min(more, mostBodySteps - 1));
}

} // namespace yade
