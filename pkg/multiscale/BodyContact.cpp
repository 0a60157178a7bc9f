// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <core/TimeStepper.hpp>
#include <pkg/common/Box.hpp>
#include <pkg/common/ElastMat.hpp>
#include <pkg/common/Facet.hpp>
#include <pkg/common/Sphere.hpp>
#include <pkg/common/Wall.hpp>
#include <pkg/mpm/Errors.hpp>
#include <pkg/multiscale/BodyContact.hpp>
#include <pkg/multiscale/ScriptNames.hpp>

namespace yade {
YADE_PLUGIN((BodyContact));

namespace {
	using Shown = talik::RigidBody<2>;

	constexpr int  numbersPerImpulse = 4;
	constexpr int  facetGroup        = -2; // all facets are one surface: neighbours share edges
	constexpr Real outOfPlane        = 1e-6;
	constexpr Real courantNumber     = 0.3; // of the time that a wave needs through the smallest sphere

	void turnAxes(Shown& shown, Real angle)
	{
		const Real c = std::cos(angle), s = std::sin(angle);
		shown.axes = { { { c, s }, { -s, c } } };
	}

	/// Angle about z; axes of a body that turned about z only lie in the plane.
	Real angleAboutZ(const Quaternionr& q) { return std::atan2(2 * (q.w() * q.z() + q.x() * q.y()), 1 - 2 * (q.y() * q.y() + q.z() * q.z())); }

	// Each returns why a surface cannot be met, or nothing; without a shape shown it is one that plane strain does not meet.
	string showSphere(const Body&, const Sphere& sphere, Shown& shown)
	{
		shown.shape = &talik::rigidBall<2>();
		shown.size  = { sphere.radius, sphere.radius };
		return "";
	}

	string showBox(const Body& body, const Box& box, Shown& shown)
	{
		const Quaternionr& q = body.state->se3.orientation;
		if (std::abs(q.x()) > outOfPlane || std::abs(q.y()) > outOfPlane)
			return "its axis z does not point along z, but ground in plane strain meets sections across z: turn boxes about z only, "
			       "blockedDOFs='zXY'";
		shown.shape = &talik::rigidBox<2>();
		shown.size  = { box.extents[0], box.extents[1] };
		return "";
	}

	string showWall(const Body&, const Wall& wall, Shown& shown)
	{
		if (wall.axis == 2) return "";
		shown.shape = &talik::rigidPlane<2>();
		shown.side  = wall.sense;
		shown.axes  = wall.axis == 0 ? decltype(shown.axes) { { { 1, 0 }, { 0, 1 } } } : decltype(shown.axes) { { { 0, 1 }, { -1, 0 } } };
		return "";
	}

	/// Seen along z a facet is its edge.
	string showFacet(const Body& body, const Facet& facet, Shown& shown)
	{
		const Se3r& pose   = body.state->se3;
		Vector3r    normal = pose.orientation * (facet.vertices[1] - facet.vertices[0]).cross(facet.vertices[2] - facet.vertices[0]);
		normal.normalize();
		if (std::abs(normal[2]) > 1 - 1e-3) return "";
		if (std::abs(normal[2]) > 1e-3) return "it is neither along nor across z, but ground in plane strain meets surfaces along z only";
		const Vector2r along = Vector2r(-normal[1], normal[0]).normalized();
		Real           low = std::numeric_limits<Real>::infinity(), high = -low;
		for (const Vector3r& vertex : facet.vertices) {
			const Vector3r corner = pose.orientation * vertex;
			const Real     t      = corner[0] * along[0] + corner[1] * along[1];
			low                   = std::min(low, t);
			high                  = std::max(high, t);
		}
		const Vector3r corner = pose.orientation * facet.vertices[0];
		const Vector2r foot   = Vector2r(corner[0], corner[1]) - (corner[0] * along[0] + corner[1] * along[1]) * along;
		shown.shape           = &talik::rigidPlate<2>();
		shown.size            = { 0, (high - low) / 2 };
		for (int a = 0; a < 2; a++)
			shown.position[a] += foot[a] + (low + high) / 2 * along[a];
		shown.axes = { { { along[1], -along[0] }, { along[0], along[1] } } };
		return "";
	}

	template <class Shape> bool showAs(string (*how)(const Body&, const Shape&, Shown&), const Body& body, Shown& shown, string& reason)
	{
		const auto* shape = dynamic_cast<const Shape*>(body.shape.get());
		if (shape) reason = how(body, *shape, shown);
		return shape;
	}

	// the shapes that can be met; a new one adds its line
	string showShape(const Body& body, Shown& shown)
	{
		string reason = "it is none of Sphere, Box, Wall, Facet or a clump of these";
		showAs(showSphere, body, shown, reason) || showAs(showBox, body, shown, reason) || showAs(showWall, body, shown, reason)
		        || showAs(showFacet, body, shown, reason);
		return reason;
	}

	bool isClump(const Body& body) { return body.clumpId == body.id; }

	/// The body that moves: the clump of a member.
	const Body& mover(const Scene& scene, const Body& body) { return body.clumpId >= 0 ? *(*scene.bodies)[body.clumpId] : body; }

	bool movesFreely(const State& state) { return state.mass > 0 && (~state.blockedDOFs & (State::DOF_X | State::DOF_Y)); }

	bool hasTimeStepper(const Scene& scene)
	{
		for (const auto& engine : scene.engines) {
			const auto* stepper = dynamic_cast<const TimeStepper*>(engine.get());
			if (stepper && stepper->active && !stepper->dead) return true;
		}
		return false;
	}
} // namespace

talik::RigidContactSettings BodyContact::build() const
{
	talik::requireSetting(std::isfinite(thickness) && thickness > 0, "BodyContact.thickness", thickness, "must be positive, in m");
	talik::requireSetting(
	        std::isnan(frictionAngle) || (frictionAngle >= 0 && frictionAngle < 90), "BodyContact.frictionAngle", frictionAngle,
	        "must lie in [0, 90), in degrees");
	talik::requireSetting(
	        !(frictionAngle > 0 && frictionAngle < 1.58), "BodyContact.frictionAngle", frictionAngle,
	        "is in degrees, as in MohrCoulombSkeleton (FrictMat has radians); give " + std::to_string(int(std::lround(frictionAngle * 180 / M_PI)))
	                + " if radians were meant");
	talik::requireSetting(bodySteps >= 1, "BodyContact.bodySteps", bodySteps, "must be 1 or more");
	const talik::RigidContactSettings settings { stiffness, shearRatio, damping };
	talik::underScriptNames({ { "bodies.", "BodyContact." } }, [&] { settings.validate(); });
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

bool BodyContact::show(const Body& body, Shown& shown) const
{
	const State& state = *body.state;
	shown.id           = body.id;
	shown.position     = { state.se3.position[0], state.se3.position[1] };
	shown.velocity     = { state.vel[0], state.vel[1] };
	shown.spin         = { state.angVel[2] };
	turnAxes(shown, angleAboutZ(state.se3.orientation));
	const string reason = showShape(body, shown);
	if (!reason.empty()) refuse(body, reason);
	if (!shown.shape) return false;
	shown.group    = body.clumpId >= 0 ? body.clumpId : shown.shape == &talik::rigidPlate<2>() ? facetGroup : body.id;
	shown.friction = frictionOf(body);
	// the shown surface turns with the body about the body's position
	const Real x = shown.position[0] - state.se3.position[0], y = shown.position[1] - state.se3.position[1];
	shown.velocity[0] -= shown.spin[0] * y;
	shown.velocity[1] += shown.spin[0] * x;
	return true;
}

void BodyContact::collect(const Scene& scene, const Engine& mpm, talik::RigidContact<2>& contact)
{
	checkEngines(scene, mpm);
	collected.clear();
	leverArms.clear();
	const BodyContainer& all = *scene.bodies;
	for (size_t id = 0; id < all.size(); id++) {
		const Body* body = all[id].get();
		if (!body || !body->shape || isClump(*body) || (mask != 0 && (body->groupMask & mask) == 0)) continue;
		Shown shown;
		if (!show(*body, shown)) continue;
		const Vector3r& at = body->state->se3.position;
		leverArms.push_back(Vector2r(shown.position[0] - at[0], shown.position[1] - at[1]));
		collected.push_back(shown);
	}
	contact.bodies = collected;
	limitByContact(scene, contact);
	if (bodiesChecked != all.size()) refuseOverlap(scene, contact);
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

void BodyContact::refuseOverlap(const Scene& scene, const talik::RigidContact<2>& contact) const
{
	const auto overlap = contact.deepestOverlap();
	if (overlap.body < 0) return;
	refuse(*(*scene.bodies)[collected[overlap.body].id],
	       "the ground's material points lie up to " + boost::lexical_cast<string>(overlap.depth) + " m inside it: move it or leave the ground out there");
}

void BodyContact::limitByContact(const Scene& scene, const talik::RigidContact<2>& contact)
{
	grips.assign(scene.bodies->size(), {});
	for (const auto& shown : collected) {
		const auto grip = contact.gripOn(shown);
		if (!std::isfinite(grip.spring)) continue;
		auto& whole = grips[mover(scene, *(*scene.bodies)[shown.id]).id];
		whole.spring += thickness * grip.spring;
		whole.dashpot += thickness * grip.dashpot;
	}
	contactLimit = std::numeric_limits<Real>::infinity();
	for (size_t id = 0; id < grips.size(); id++) {
		if (grips[id].spring == 0) continue;
		const State& state = *(*scene.bodies)[id]->state;
		if (movesFreely(state)) contactLimit = std::min(contactLimit, talik::RigidContact<2>::timeStep(state.mass, grips[id]));
	}
}

void BodyContact::place(talik::RigidContact<2>& contact, Real time) const
{
	for (size_t b = 0; b < collected.size(); b++) {
		const Shown& from = collected[b];
		Shown&       to   = contact.bodies[b];
		const Real   turn = from.spin[0] * time, c = std::cos(turn), s = std::sin(turn);
		for (int a = 0; a < 2; a++) {
			to.position[a] = from.position[a] + time * from.velocity[a];
			to.axes[a]     = { c * from.axes[a][0] - s * from.axes[a][1], s * from.axes[a][0] + c * from.axes[a][1] };
		}
	}
}

// ---- from the ground to the scene ------------------------------------------------------------------------------------------

void BodyContact::take(talik::RigidContact<2>& contact, Real interval)
{
	// what is still to be delivered of bodies that are there no more is nobody's
	vector<Real> former;
	former.swap(pending);
	for (size_t b = 0; b < contact.bodies.size(); b++) {
		Shown&     body = contact.bodies[b];
		const auto p    = body.impulse;
		const Real l    = body.angularImpulse[0] + leverArms[b][0] * p[1] - leverArms[b][1] * p[0];
		pending.insert(pending.end(), { Real(body.id), thickness * p[0], thickness * p[1], thickness * l });
		for (size_t k = 0; k < former.size(); k += numbersPerImpulse)
			if (former[k] == body.id)
				for (int i = 1; i < numbersPerImpulse; i++)
					pending[pending.size() - numbersPerImpulse + i] += former[k + i];
		body.impulse        = {};
		body.angularImpulse = {};
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
		scene.forces.addForce(id, Vector3r(impulse[0], impulse[1], 0) * (share / scene.dt));
		scene.forces.addTorque(id, Vector3r(0, 0, impulse[2]) * (share / scene.dt));
		for (int i = 0; i < 3; i++)
			impulse[i] -= share * impulse[i];
	}
	ahead = share < 1 ? ahead - scene.dt : 0;
}

// ---- steps -----------------------------------------------------------------------------------------------------------------

Real BodyContact::due(const Scene& scene) const { return scene.dt - ahead; }

Real BodyContact::timeStep(const Scene& scene, Real stableStep) const
{
	if (hasTimeStepper(scene)) return std::min(contactLimit, scene.dt);
	Real limit         = std::min(contactLimit, stableStep);
	bool meetEachOther = false;
	for (const auto& engine : scene.engines)
		meetEachOther = meetEachOther || engine->getClassName() == "InteractionLoop";
	if (!meetEachOther || collected.size() < 2) return limit;
	for (const auto& shown : collected) {
		const Body& body     = *(*scene.bodies)[shown.id];
		const auto* material = dynamic_cast<const ElastMat*>(body.material.get());
		const auto* sphere   = dynamic_cast<const Sphere*>(body.shape.get());
		if (sphere && material && movesFreely(*mover(scene, body).state))
			limit = std::min(limit, courantNumber * sphere->radius * std::sqrt(material->density / material->young));
	}
	return limit;
}

Real BodyContact::groundStep(const Scene& scene, Real stableStep) const
{
	const Real longest = std::min(stableStep, contactLimit);
	if (scene.dt > contactLimit * (1 + 1e-9))
		throw std::runtime_error(
		        "MpmEngine: O.dt = " + boost::lexical_cast<string>(scene.dt) + " s is too long for the contact of ground and bodies: set it to at most "
		        + boost::lexical_cast<string>(contactLimit) + " s, or lower BodyContact.stiffness.");
	const Real more = std::floor((longest - due(scene)) / scene.dt * (1 + 1e-12));
	return due(scene) + scene.dt * std::max(Real(0), std::min(more, Real(bodySteps - 1)));
}

} // namespace yade
