// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/common/Sphere.hpp>
#include <pkg/python/StepGate.hpp>
#include <pkg/rve/open/ScenePacking.hpp>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

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
		for (std::size_t id = 0; id < scene.bodies->size(); ++id) {
			const auto& body = (*scene.bodies)[id];
			if (const auto* sphere = body ? dynamic_cast<const Sphere*>(body->shape.get()) : nullptr) {
				smallest = std::min(smallest, sphere->radius);
				largest  = std::max(largest, sphere->radius);
			}
		}
		const double extent = 2 * largest + smallest;
		for (int axis = 0; largest > 0 && axis < 3; ++axis) {
			const double length = scene.cell->hSize.col(axis).norm();
			if (!(extent < 0.99 * length))
				return "its cell is " + std::to_string(length) + " m long along axis " + std::to_string(axis)
				        + ", too short for spheres of radius " + std::to_string(largest) + " m: YADE needs more than four radii";
		}
		return "";
	}

	/// Bodies that the dispatchers and the collider cannot tell apart, by one of them.
	struct Kind {
		const Body* body;
		std::size_t count;
	};

	std::vector<Kind> kindsOf(const Scene& scene)
	{
		std::map<std::tuple<std::string, std::string, mask_t>, Kind> kinds;
		for (std::size_t id = 0; id < scene.bodies->size(); ++id) {
			const auto& body = (*scene.bodies)[id];
			if (!body || !collides(*body) || !body->material) continue;
			const auto key = std::make_tuple(body->material->getClassName(), body->shape->getClassName(), body->groupMask);
			kinds.emplace(key, Kind { body.get(), 0 }).first->second.count++;
		}
		std::vector<Kind> found;
		for (const auto& [_, kind] : kinds)
			found.push_back(kind);
		return found;
	}

	std::string materialOf(const Kind& kind) { return kind.body->material->getClassName(); }

	std::string className(const py::object& object) { return py::extract<std::string>(object.attr("__class__").attr("__name__")); }

	/// Functors are named by what they take and, last, what they make: Ip2_FrictMat_FrictMat_FrictPhys. None if that is no class.
	py::object madeBy(const py::object& functor)
	{
		const std::string name = className(functor), made = name.substr(name.rfind('_') + 1);
		const py::object  classes = py::import("yade.wrapper");
		return PyObject_HasAttrString(classes.ptr(), made.c_str()) ? py::object(classes.attr(made.c_str())()) : py::object();
	}

	/// Ip2 functors for all pairs of the materials that have one.
	std::vector<py::object> contactParameters(const std::vector<Kind>& kinds, const py::object& dispatcher)
	{
		std::vector<py::object> functors;
		for (const Kind& first : kinds)
			for (const Kind& second : kinds) {
				const py::object functor = dispatcher.attr("dispFunctor")(first.body->material, second.body->material);
				if (!functor.is_none()) functors.push_back(functor);
			}
		return functors;
	}

	/// True also where a functor does not say by its name what it makes.
	bool someLawFits(const py::object& loop, const std::vector<py::object>& parameters)
	{
		const py::object geometries = loop.attr("geomDispatcher").attr("functors"), laws = loop.attr("lawDispatcher");
		for (long g = 0; g < py::len(geometries); ++g)
			for (const auto& functor : parameters) {
				const py::object geom = madeBy(geometries[g]), phys = madeBy(functor);
				if (geom.is_none() || phys.is_none() || !py::object(laws.attr("dispFunctor")(geom, phys)).is_none()) return true;
			}
		return py::len(geometries) == 0;
	}

	/// Where nothing fits, the first contact would be the end, whichever it is.
	std::string reasonOfContacts(const std::vector<Kind>& kinds, const py::object& loop, bool dense)
	{
		if (kinds.empty()) return "";
		std::set<std::string> materials;
		for (const Kind& kind : kinds)
			materials.insert(materialOf(kind));
		std::string names;
		for (const std::string& name : materials)
			names += (names.empty() ? "" : ", ") + name;
		const auto parameters = contactParameters(kinds, loop.attr("physDispatcher"));
		if (parameters.empty() && !dense && py::len(loop.attr("physDispatcher").attr("functors")) > 0) return ""; // they may never touch
		if (parameters.empty())
			return "its InteractionLoop has no Ip2 functor for contacts of " + names + ": add one, e.g. Ip2_IceBondMat_IceBondMat_IceBondPhys()";
		if (someLawFits(loop, parameters)) return "";
		return "its InteractionLoop has no Law2 functor for what " + className(parameters.front())
		        + " makes of contacts: add one, e.g. Law2_ScGeom_IceBondPhys_IceBond()";
	}

	bool isOfIce(const Kind& kind) { return materialOf(kind) == "IceBondMat"; }

	/// As the collider decides it.
	bool mayMeet(const Kind& a, const Kind& b, mask_t avoidedAmongThemselves)
	{
		if (&a == &b && a.count < 2) return false;
		const mask_t common = a.body->groupMask & b.body->groupMask;
		return common != 0 && (a.body->groupMask != b.body->groupMask || (a.body->groupMask & avoidedAmongThemselves) == 0);
	}

	/// Contacts of ice-bonded grains that some Ig2 functor finds, and that no Ip2 or no Law2 functor knows: the first would be the end.
	std::string reasonOfIceContacts(const std::vector<Kind>& kinds, const py::object& loop, mask_t avoidedAmongThemselves)
	{
		const py::object geometries = loop.attr("geomDispatcher"), parameters = loop.attr("physDispatcher");
		for (std::size_t i = 0; i < kinds.size(); ++i)
			for (std::size_t j = i; j < kinds.size(); ++j) {
				const Kind &a = kinds[i], &b = kinds[j];
				if (!(isOfIce(a) || isOfIce(b)) || !mayMeet(a, b, avoidedAmongThemselves)) continue;
				if (geometries.attr("dispFunctor")(a.body->shape, b.body->shape).is_none()
				    && geometries.attr("dispFunctor")(b.body->shape, a.body->shape).is_none())
					continue;
				const py::object functor = parameters.attr("dispFunctor")(a.body->material, b.body->material);
				if (!functor.is_none() && someLawFits(loop, { functor })) continue;
				return "its InteractionLoop has no " + std::string(functor.is_none() ? "Ip2" : "Law2") + " functor for contacts of "
				        + named(*a.body) + " (" + materialOf(a) + ") and " + named(*b.body) + " (" + materialOf(b)
				        + "), the first of which would end YADE: add Ip2_FrictMat_FrictMat_FrictPhys() and "
				          "Law2_ScGeom_FrictPhys_CundallStrack(), or keep them apart by Body.mask";
			}
		return "";
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
	const auto        kinds    = kindsOf(scene);
	const auto        collider = liveEngine(scene, "InsertionSortCollider");
	const PythonLock  held;
	const py::object  inPython(loop);
	const std::string reason = reasonOfContacts(kinds, inPython, dense);
	if (!reason.empty()) return reason;
	const mask_t avoided = collider ? mask_t(py::extract<mask_t>(py::object(collider).attr("avoidSelfInteractionMask"))) : 0;
	return reasonOfIceContacts(kinds, inPython, avoided);
}

} // namespace talik
