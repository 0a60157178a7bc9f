// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/common/Sphere.hpp>
#include <pkg/python/PythonFunction.hpp>
#include <pkg/python/StepGate.hpp>
#include <pkg/rve/open/ScenePacking.hpp>

#include <algorithm>
#include <map>
#include <tuple>

namespace py = boost::python;
using namespace yade;

namespace talik {
namespace {

	shared_ptr<Engine> liveEngine(const Scene& scene, const char* name)
	{
		for (const auto& engine : enginesNow(scene))
			if (!engine->dead && engine->getClassName() == name) return engine;
		return nullptr;
	}

	std::string named(const Body& body) { return "O.bodies[" + std::to_string(body.id) + "]"; }

	/// Bodies without shape do not collide, and a clump leaves that to its members.
	bool collides(const Body& body) { return body.shape && body.clumpId != body.id; }

	std::string reasonOfBody(const Body& body, bool meetsOthers, bool periodic)
	{
		if (!body.state) return named(body) + " has no state: give it one (State()) or erase the body";
		if (meetsOthers && collides(body) && !body.material) return named(body) + " has no material: give it one or erase the body";
		if (!periodic) return "";
		if (!body.shape && body.bound) return named(body) + " has lost its shape in a periodic cell: give it one or erase the body";
		if (collides(body) && !body.state->se3.position.allFinite()) return "the position of " + named(body) + " is not finite: set state.pos";
		return "";
	}

	/// The collider asserts that a body with the margin around it, half a smallest radius, is shorter than the cell.
	std::string reasonOfCell(const Scene& scene)
	{
		double smallest = std::numeric_limits<double>::infinity(), largest = 0;
		forBodies(scene, [&](const Body& body) {
			const auto* sphere = dynamic_cast<const Sphere*>(body.shape.get());
			if (sphere) smallest = std::min(smallest, sphere->radius);
			if (sphere) largest = std::max(largest, sphere->radius);
		});
		const double extent = 2 * largest + smallest;
		for (int axis = 0; largest > 0 && axis < 3; ++axis) {
			const double length = scene.cell->hSize.col(axis).norm();
			if (!(extent < 0.99 * length))
				return "its cell is " + std::to_string(length) + " m long along axis " + std::to_string(axis)
				        + ", too short for spheres of radius " + std::to_string(largest) + " m: YADE needs more than four radii";
		}
		return "";
	}

	/// Bodies that the dispatchers and the collider cannot tell apart, by one of them, and how many.
	py::list kindsOf(const Scene& scene)
	{
		std::map<std::tuple<std::string, std::string, mask_t>, std::pair<shared_ptr<Body>, int>> kinds;
		for (std::size_t id = 0; id < scene.bodies->size(); ++id) {
			const auto& body = (*scene.bodies)[id];
			if (!body || !collides(*body) || !body->material) continue;
			const auto key = std::make_tuple(body->material->getClassName(), body->shape->getClassName(), body->groupMask);
			kinds.emplace(key, std::make_pair(body, 0)).first->second.second++;
		}
		py::list found;
		for (const auto& [_, kind] : kinds)
			found.append(py::make_tuple(kind.first, kind.second));
		return found;
	}

} // namespace

std::string reasonAgainstRunning(const Scene& scene, bool dense)
{
	const auto loop = liveEngine(scene, "InteractionLoop");
	for (std::size_t id = 0; id < scene.bodies->size(); ++id) {
		const auto&       body   = (*scene.bodies)[id];
		const std::string reason = body ? reasonOfBody(*body, bool(loop), scene.isPeriodic) : "";
		if (!reason.empty()) return reason;
	}
	if (!loop) return "";
	if (scene.isPeriodic && scene.cell) {
		const std::string reason = reasonOfCell(scene);
		if (!reason.empty()) return reason;
	}
	const auto       collider = liveEngine(scene, "InsertionSortCollider");
	const PythonLock held;
	const mask_t     avoided = collider ? mask_t(py::extract<mask_t>(py::object(collider).attr("avoidSelfInteractionMask"))) : 0;
	return py::extract<std::string>(callPython("talik.guards.functors", "reason", kindsOf(scene), loop, dense, avoided));
}

} // namespace talik
