// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/common/Sphere.hpp>
#include <pkg/rve/HoldGil.hpp>
#include <pkg/rve/RunningScene.hpp>

#include <map>

namespace py = boost::python;
using namespace yade;

namespace talik {
namespace {

	shared_ptr<Engine> liveEngine(const Scene& scene, const char* name)
	{
		for (const auto& engine : scene._nextEngines.empty() ? scene.engines : scene._nextEngines)
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
		for (std::size_t id = 0; id < scene.bodies->size(); id++) {
			const auto& body = (*scene.bodies)[id];
			if (const auto* sphere = body ? dynamic_cast<const Sphere*>(body->shape.get()) : nullptr) {
				smallest = std::min(smallest, sphere->radius);
				largest  = std::max(largest, sphere->radius);
			}
		}
		const double extent = 2 * largest + smallest;
		for (int axis = 0; largest > 0 && axis < 3; axis++) {
			const double length = scene.cell->hSize.col(axis).norm();
			if (!(extent < 0.99 * length))
				return "its cell is " + std::to_string(length) + " m long along axis " + std::to_string(axis) + ", too short for spheres of radius "
				        + std::to_string(largest) + " m: YADE needs more than four radii";
		}
		return "";
	}

	/// One body of each class of material that may touch another.
	std::map<std::string, const Body*> bodiesByMaterial(const Scene& scene)
	{
		std::map<std::string, const Body*> found;
		for (std::size_t id = 0; id < scene.bodies->size(); id++) {
			const auto& body = (*scene.bodies)[id];
			if (body && collides(*body) && body->material) found.emplace(body->material->getClassName(), body.get());
		}
		return found;
	}

	std::string className(const py::object& object) { return py::extract<std::string>(object.attr("__class__").attr("__name__")); }

	/// Functors are named by what they take and, last, what they make: Ip2_FrictMat_FrictMat_FrictPhys. None if that is no class.
	py::object madeBy(const py::object& functor)
	{
		const std::string name    = className(functor), made = name.substr(name.rfind('_') + 1);
		const py::object  classes = py::import("yade.wrapper");
		return PyObject_HasAttrString(classes.ptr(), made.c_str()) ? py::object(classes.attr(made.c_str())()) : py::object();
	}

	/// Ip2 functors for all pairs of the materials that have one.
	std::vector<py::object> contactParameters(const std::map<std::string, const Body*>& materials, const py::object& dispatcher)
	{
		std::vector<py::object> functors;
		for (const auto& [_, first] : materials)
			for (const auto& [__, second] : materials) {
				const py::object functor = dispatcher.attr("dispFunctor")(first->material, second->material);
				if (!functor.is_none()) functors.push_back(functor);
			}
		return functors;
	}

	/// True also where a functor does not say by its name what it makes.
	bool someLawFits(const py::object& loop, const std::vector<py::object>& parameters)
	{
		const py::object geometries = loop.attr("geomDispatcher").attr("functors"), laws = loop.attr("lawDispatcher");
		for (long g = 0; g < py::len(geometries); g++)
			for (const auto& functor : parameters) {
				const py::object geom = madeBy(geometries[g]), phys = madeBy(functor);
				if (geom.is_none() || phys.is_none() || !py::object(laws.attr("dispFunctor")(geom, phys)).is_none()) return true;
			}
		return py::len(geometries) == 0;
	}

	/// Where nothing fits, the first contact would be the end, whichever it is.
	std::string reasonOfContacts(const Scene& scene, const shared_ptr<Engine>& engine, bool dense)
	{
		const auto materials = bodiesByMaterial(scene);
		if (materials.empty()) return "";
		std::string names;
		for (const auto& [name, _] : materials)
			names += (names.empty() ? "" : ", ") + name;
		const HoldGil    held;
		const py::object loop(engine);
		const auto       parameters = contactParameters(materials, loop.attr("physDispatcher"));
		if (parameters.empty() && !dense && py::len(loop.attr("physDispatcher").attr("functors")) > 0) return ""; // they may never touch
		if (parameters.empty()) return "its InteractionLoop has no Ip2 functor for contacts of " + names + ": add one, e.g. Ip2_IceBondMat_IceBondMat_IceBondPhys()";
		if (someLawFits(loop, parameters)) return "";
		return "its InteractionLoop has no Law2 functor for what " + className(parameters.front()) + " makes of contacts: add one, e.g. Law2_ScGeom_IceBondPhys_IceBond()";
	}

} // namespace

std::string reasonAgainstRunning(const Scene& scene, bool dense)
{
	const auto loop = liveEngine(scene, "InteractionLoop");
	for (std::size_t id = 0; id < scene.bodies->size(); id++) {
		const auto&       body   = (*scene.bodies)[id];
		const std::string reason = body ? reasonOfBody(*body, bool(loop), scene.isPeriodic) : "";
		if (!reason.empty()) return reason;
	}
	if (!loop) return "";
	if (scene.isPeriodic && scene.cell) {
		const std::string reason = reasonOfCell(scene);
		if (!reason.empty()) return reason;
	}
	return reasonOfContacts(scene, loop, dense);
}

std::string contactsThatMayAbort(const Scene& scene)
{
	const auto loop = liveEngine(scene, "InteractionLoop");
	if (!loop) return "";
	const auto materials = bodiesByMaterial(scene);
	const auto ice       = materials.find("IceBondMat");
	if (ice == materials.end()) return "";
	const HoldGil    held;
	const py::object dispatcher = py::object(loop).attr("physDispatcher");
	for (const auto& [name, body] : materials)
		if (body != ice->second && py::object(dispatcher.attr("dispFunctor")(ice->second->material, body->material)).is_none())
			return "bodies of IceBondMat and of " + name + " must not touch: the InteractionLoop has no Ip2 functor for them, and stock YADE would end; add Ip2_FrictMat_FrictMat_FrictPhys() and Law2_ScGeom_FrictPhys_CundallStrack()";
	return "";
}

} // namespace talik
