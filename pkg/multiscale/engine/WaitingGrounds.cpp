// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/engine/MpmEngine.hpp>

#include <mutex>
#include <set>

namespace py = boost::python;

// Grounds whose fields were read but that have not begun: a change of what they were made from makes them anew.

namespace yade {
namespace {
	/// All engines that live, so that a change of a setting finds the grounds that were made with it.
	struct Register {
		std::recursive_mutex          guard; // looking into an engine may let Python's collector end another one
		std::set<MpmEngine*>          engines;
		template <class Visitor> void visit(Visitor&& look)
		{
			std::lock_guard<std::recursive_mutex> lock(guard);
			for (MpmEngine* engine : std::set<MpmEngine*>(engines))
				if (engines.count(engine)) look(*engine);
		}
	};
	Register& everyEngine()
	{
		static Register* const all = new Register; // outlives engines that Python lets go at its end
		return *all;
	}

	/// Whether a Python value is this object, or a list that has it.
	bool contains(const py::object& value, const shared_ptr<Serializable>& part)
	{
		if (PyList_Check(value.ptr())) {
			for (int k = 0; k < py::len(value); ++k)
				if (contains(value[k], part)) return true;
			return false;
		}
		const py::extract<Serializable*> object(value);
		if (!object.check()) return false;
		const auto* const material = dynamic_cast<GroundMaterial*>(object());
		return object() == part.get() || (material && material->freezing && material->freezing == part);
	}
} // namespace

void MpmEngine::enrol()
{
	std::lock_guard<std::recursive_mutex> lock(everyEngine().guard);
	everyEngine().engines.insert(this);
}

MpmEngine::~MpmEngine()
{
	std::lock_guard<std::recursive_mutex> lock(everyEngine().guard);
	everyEngine().engines.erase(this);
}

bool MpmEngine::holds(const shared_ptr<Serializable>& part) const
{
	if (part.get() == this) return true;
	const py::list values(pyDict().values());
	for (int k = 0; k < py::len(values); ++k)
		if (contains(values[k], part)) return true;
	return false;
}

bool MpmEngine::heldByWaitingGround(const shared_ptr<Serializable>& part)
{
	bool held = false;
	everyEngine().visit([&](MpmEngine& engine) { held = held || (engine.ground && !engine.hasBegun() && engine.holds(part)); });
	return held;
}

void MpmEngine::renewWaitingGrounds(const shared_ptr<Serializable>& part)
{
	everyEngine().visit([&](MpmEngine& engine) {
		if (engine.ground && !engine.hasBegun() && engine.holds(part)) engine.discardGround();
	});
}

} // namespace yade
