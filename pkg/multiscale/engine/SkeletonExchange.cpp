// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/SavedBytes.hpp>
#include <pkg/multiscale/engine/MpmEngine.hpp>

#include <algorithm>
#include <boost/python/stl_iterator.hpp>
#include <cstring>
#include <map>

namespace py = boost::python;

namespace yade {

namespace {
	using Laws = vector<shared_ptr<SkeletonLaw>>;

	string prefixOf(std::size_t law) { return "skeleton" + std::to_string(law) + "."; }

	/// The arrays of a ground's state by name, copied; the fields of skeleton models under the name that they will have.
	std::map<string, string> copyState(talik::AnyGround& ground, const Laws& before, const Laws& after)
	{
		std::map<string, string> copies;
		for (const auto& array : ground.state()) {
			string name = array.name;
			for (std::size_t k = 0; k < before.size(); ++k) {
				if (array.name.rfind(prefixOf(k), 0) != 0) continue;
				const auto found = std::find(after.begin(), after.end(), before[k]);
				name             = found == after.end() ? "" : prefixOf(found - after.begin()) + array.name.substr(prefixOf(k).size());
			}
			if (!name.empty()) copies[name].assign(static_cast<const char*>(array.data), array.bytes);
		}
		return copies;
	}

	void overwriteState(talik::AnyGround& ground, const std::map<string, string>& copies)
	{
		for (const auto& array : ground.state()) {
			const auto copy = copies.find(array.name);
			if (copy == copies.end()) continue; // of a skeleton that is new
			if (copy->second.size() != array.bytes)
				throw std::runtime_error("MpmEngine.exchangeSkeletons: the state does not fit at " + array.name + ".");
			std::memcpy(array.data, copy->second.data(), array.bytes);
		}
	}

} // namespace

py::list MpmEngine::skeletonNumbers() const
{
	py::list numbers;
	for (int id = 0; id < pointCount(); ++id)
		numbers.append(points.skeleton(id));
	return numbers;
}

void MpmEngine::checkExchange(const Laws& laws, const vector<int>& skeletonOf) const
{
	const Laws before = activeSkeletons();
	for (int id = 0; id < pointCount(); ++id) {
		const auto& law = laws[skeletonOf[id]];
		if (!law)
			throw std::invalid_argument(
			        "MpmEngine.exchangeSkeletons: skeletons[" + std::to_string(skeletonOf[id]) + "] is None: give skeleton laws only.");
		if (law != before[points.skeleton(id)] && !law->admitsPoints())
			throw std::invalid_argument(
			        "MpmEngine.exchangeSkeletons: skeletons[" + std::to_string(skeletonOf[id])
			        + "] has samples behind other points already: give point " + std::to_string(id) + " a new " + law->getClassName() + ".");
	}
}

void MpmEngine::exchangeSkeletons(const Laws& laws, const py::object& skeletonOf)
{
	if (stepping)
		throw std::runtime_error("MpmEngine.exchangeSkeletons: a law cannot be exchanged while it works: do it between two steps, by a PyRunner.");
	auto& running = runningGround();
	if (!motion) throw std::invalid_argument("MpmEngine.exchangeSkeletons: the ground does not move (motion=False) and has no skeletons.");
	if (laws.empty()) throw std::invalid_argument("MpmEngine.exchangeSkeletons: skeletons is empty: give at least one skeleton law.");
	const py::object  asked = py::import("talik._points").attr("lawNumbers")(skeletonOf, pointCount(), laws.size());
	const vector<int> numbers { py::stl_input_iterator<int>(asked), py::stl_input_iterator<int>() };
	checkExchange(laws, numbers);
	meetBefore("MpmEngine.exchangeSkeletons");
	const Laws before = activeSkeletons();
	const auto state  = copyState(running, before, laws);
	const auto former = std::make_tuple(skeleton, skeletons, points);
	begun             = true;
	preSave(*this);
	const string whole = std::move(saved);
	saved.clear();
	try {
		skeleton.reset();
		skeletons = laws;
		for (int id = 0; id < pointCount(); ++id)
			points.setSkeleton(id, numbers[id]);
		takeOver(before, state);
	} catch (...) {
		std::tie(skeleton, skeletons, points) = former;
		dropGround();
		saved = whole;
		initialise();
		throw;
	}
}

/// Makes a ground of the present settings, which goes on from the state of the former one; skeletons that are new begin with it.
void MpmEngine::takeOver(const Laws& before, const std::map<string, string>& state)
{
	const auto     isOld = [&](const shared_ptr<SkeletonLaw>& law) { return std::count(before.begin(), before.end(), law) > 0; };
	vector<string> histories;
	for (const auto& law : skeletons)
		histories.push_back(isOld(law) ? law->saved(nullptr) : "");
	const auto steps = std::make_pair(stableStep, stepsUntilLimit);
	dropGround();
	initialise();
	begun                                 = true;
	std::tie(stableStep, stepsUntilLimit) = steps;
	overwriteState(*ground, state);
	for (int place = 0; place < pointCount(); ++place)
		ground->skeletonNumbers()[place] = points.skeleton(ground->idAt(place));
	ground->stateRestored();
	for (std::size_t k = 0; k < skeletons.size(); ++k) {
		if (isOld(skeletons[k])) {
			skeletons[k]->restore(histories[k], nullptr);
			skeletons[k]->keepOnly(ground->skeletonPoints(int(k)));
		} else ground->startSkeleton(int(k));
	}
}

} // namespace yade
