// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/engine/MpmEngine.hpp>
#include <pkg/python/PythonFunction.hpp>

#include <boost/python/numpy.hpp>
#include <boost/python/stl_iterator.hpp>
#include <cmath>
#include <limits>

namespace py = boost::python;
namespace np = boost::python::numpy;

// What Python sees of the ground of an MpmEngine.

namespace yade {

double MpmEngine::stableTimeStep()
{
	runningGround();
	followAttributes();
	return ground->stableTimeStep().step;
}

py::dict MpmEngine::timeStepLimits()
{
	const auto stable = runningGround().stableTimeStep();
	py::dict   result;
	for (const auto& limit : stable.limits)
		result[limit.name] = limit.step;
	result["governing"] = stable.governing;
	return result;
}

vector<string> MpmEngine::existingFields()
{
	vector<string> names;
	for (const auto& info : runningGround().fields())
		if (info.place == "points") names.push_back(info.name);
	if (motion && !axisymmetric) {
		names.push_back("strain");
		names.push_back("deviatoricStrain");
	}
	for (const auto& law : activeSkeletons())
		for (const auto& measure : law->measures())
			if (std::find(names.begin(), names.end(), measure) == names.end()) names.push_back(measure);
	return names;
}

py::list MpmEngine::fieldNames() { return talik::listOf(existingFields()); }

py::list MpmEngine::fields()
{
	py::list result;
	for (const auto& info : runningGround().fields()) {
		py::dict d;
		TALIK_PUT_MEMBERS(d, info, (name)(owner)(unit)(place)(components)(bytes))
		result.append(d);
	}
	return result;
}

namespace {
	bool isStrain(const string& name) { return name == "strain" || name == "deviatoricStrain"; }

} // namespace

/// Skeletons in use that give this measure.
vector<shared_ptr<SkeletonLaw>> MpmEngine::lawsMeasuring(const string& name) const
{
	vector<shared_ptr<SkeletonLaw>> laws;
	for (const auto& law : activeSkeletons()) {
		const auto measures = law->measures();
		if (std::find(measures.begin(), measures.end(), name) != measures.end()) laws.push_back(law);
	}
	return laws;
}

/// See talik._points.field.
py::object MpmEngine::field(const string& name)
{
	runningGround();
	py::list tables;
	for (const auto& law : lawsMeasuring(name))
		tables.append(law->values(name));
	return py::import("talik._points").attr("field")(py::ptr(this), name, tables);
}

py::object MpmEngine::storedField(const string& name)
{
	auto&     g     = runningGround();
	int       parts = 0;
	const int n     = pointCount();
	for (const auto& info : g.fields())
		if (info.place == "points" && info.name == name) parts = info.components;
	if (parts == 0) return py::object();
	vector<Real> components(std::size_t(n) * parts);
	for (int c = 0; c < parts; ++c)
		g.copyById(name, c, components.data() + std::size_t(n) * c);
	return talik::tableOf(n, parts, [&](std::size_t id, std::size_t c) { return components[n * c + id]; });
}

vector<Real> MpmEngine::valueAt(const string& name, int id)
{
	const auto laws = lawsMeasuring(name);
	if (!laws.empty()) {
		vector<Real> value { NaN };
		for (const auto& law : laws)
			if (std::isnan(value.front())) value = law->valueAt(name, id);
		return value;
	}
	const auto&  stored = ground->pointFields();
	const string source = isStrain(name) ? "deformationGradient" : name;
	vector<Real> value;
	for (const auto& info : stored.list())
		if (info.name == source)
			for (int c = 0; c < info.components; ++c)
				value.push_back(stored.find(source, c)[ground->placeOf(id)]);
	return value; // a strain is told by history()
}

namespace {
	/// What a history holds unless the user chooses: soil and sample, without what only the method knows.
	const vector<string> defaultFields { "position",      "displacement",       "velocity",       "temperature",
		                             "iceSaturation", "pressure",           "porosity",       "stress",
		                             "strain",        "deviatoricStrain",   "bondsIntact",    "bondsBroken",
		                             "bondsMelted",   "coordinationNumber", "samplePorosity", "fabric" };
} // namespace

void MpmEngine::watch(py::object ids, Real interval, py::object names)
{
	if (!(interval >= 0)) throw std::invalid_argument("MpmEngine.watch: interval is " + talik::asText(interval) + ": give 0 or more seconds.");
	followInputs();
	watchesDefault = py::len(names) == 0;
	shared_ptr<PointWatch> wanted(new PointWatch);
	wanted->interval         = interval;
	const py::object numbers = py::import("talik._points").attr("watched")(ids, pointCount());
	wanted->ids.assign(py::stl_input_iterator<int>(numbers), py::stl_input_iterator<int>());
	for (int k = 0; k < py::len(names); ++k) {
		const string name = py::extract<string>(names[k]);
		if (ground && !py::list(fieldNames()).count(name))
			throw std::invalid_argument("MpmEngine.watch: there is no field '" + name + "'; see fieldNames().");
		wanted->fields.push_back(name);
	}
	watched = wanted->ids.empty() ? nullptr : wanted;
	if (watched && ground) recordWatched();
}

/// Before the first step of a watch and after every one.
void MpmEngine::recordWatched()
{
	if (!watched->isDue(ground->time())) return;
	if (watched->times.empty()) {
		const auto existing = existingFields();
		if (watched->fields.empty()) watched->fields = defaultFields;
		auto& names = watched->fields;
		names.erase(
		        std::remove_if(
		                names.begin(), names.end(),
		                [&](const string& name) { return std::find(existing.begin(), existing.end(), name) == existing.end(); }),
		        names.end());
	}
	watched->record(ground->time(), [this](const string& name, int id) { return valueAt(name, id); });
}

py::dict MpmEngine::history(int id) const
{
	if (!watched) throw std::invalid_argument("MpmEngine.history: no point is watched; call watch([ids]) first.");
	py::dict   records   = watched->history(id);
	const auto gradients = usedDimension() == 2 ? 4 : 9;
	for (const char* name : { "strain", "deviatoricStrain" }) {
		const py::object recorded = records.get(name);
		if (!recorded.is_none() && recorded.attr("shape") == py::make_tuple(watched->times.size(), gradients))
			records[name] = talik::callPython("talik._points", "strain", name, recorded);
	}
	return records;
}

py::dict MpmEngine::balance()
{
	runningGround();
	return groundOfScene->balance();
}

py::dict MpmEngine::cost()
{
	const auto& g = runningGround();
	py::dict    d;
	for (const auto& [effect, seconds] : g.cost())
		d[effect] = seconds;
	d["steps"] = g.steps() - stepsAtStart;
	return d;
}

py::object MpmEngine::estimatedError()
{
	auto& g = runningGround();
	if (toleranceInForce == 0) return py::object();
	g.pointFields(); // those of other ranks, too
	talik::ErrorSquares sum;
	const auto          laws = activeSkeletons();
	for (std::size_t k = 0; k < laws.size(); ++k) {
		const auto squares = laws[k]->errorSquares(g.skeletonPoints(int(k)));
		sum.add(1, squares.error, squares.stress);
	}
	return py::object(sum.stress > 0 ? std::sqrt(sum.error / sum.stress) : 0.);
}

double MpmEngine::groundTime() const { return ground ? ground->time() : 0; }

py::dict MpmEngine::calendar()
{
	const auto& g       = runningGround();
	const auto& c       = g.calendar();
	const bool  follows = heat && heat->followsMotion;
	py::dict    d;
	d["day"]                 = c.time / secondsPerDay;
	d["scale"]               = c.scale;
	d["followsMotion"]       = follows;
	d["speed"]               = follows ? py::object(c.speed) : py::object();
	d["moving"]              = follows ? py::object(c.moving != 0) : py::object();
	d["seepageScale"]        = g.seepageScale();
	d["largestConductivity"] = water ? py::object(g.largestConductivity()) : py::object();
	return d;
}

py::list MpmEngine::events()
{
	const auto& g = runningGround();
	if (!heat || !heat->followsMotion)
		throw std::runtime_error("MpmEngine.events: events are recorded only where the scale of the calendar follows the motion; set "
		                         "HeatTransfer.followsMotion=True before the first step.");
	py::list          list;
	const auto        events = g.events();
	const std::size_t ended  = g.endedEvents().size();
	for (std::size_t i = 0; i < events.size(); ++i) {
		const auto& e = events[i];
		py::dict    d;
		d["day"]      = e.begin / secondsPerDay;
		d["duration"] = e.duration;
		d["days"]     = e.passed / secondsPerDay;
		TALIK_PUT_MEMBERS(d, e, (volume)(largest))
		d["goesOn"] = i >= ended;
		list.append(d);
	}
	return list;
}

void MpmEngine::setDay(Real day)
{
	if (!std::isfinite(day)) throw std::invalid_argument("MpmEngine.setDay: day is " + talik::asText(day) + ": give a finite number of days.");
	runningGround().setCalendar(day * secondsPerDay);
	begun = true;
}

py::list MpmEngine::pointMaterials() const
{
	py::list numbers;
	for (int id = 0; id < pointCount(); ++id)
		numbers.append(points.material(id));
	return numbers;
}

double MpmEngine::skemptonB()
{
	auto& g = runningGround();
	if (!water) throw std::runtime_error("MpmEngine.skemptonB: the scene has no water.");
	const auto&  s       = g.commonSettings();
	Real         modulus = std::numeric_limits<Real>::infinity();
	int          softest = 0;
	vector<Real> byPlace(pointCount());
	for (int k = 0; k < int(activeSkeletons().size()); ++k) {
		const auto own = g.skeletonPoints(k);
		g.tangentModulus(k, byPlace.data());
		for (int i = 0; i < own.count; ++i)
			if (byPlace[own.place[i]] < modulus) {
				modulus = byPlace[own.place[i]];
				softest = own.id[own.place[i]];
			}
	}
	const talik::PoreState thawed { points.porosity(softest), 1, 0, 0 };
	return talik::skemptonB(s.water->state.coefficients(s.mixture, thawed), modulus);
}

void MpmEngine::setTemperature(py::object values)
{
	auto&             g     = runningGround();
	const int         n     = pointCount();
	const np::ndarray array = py::extract<np::ndarray>(py::import("talik._points").attr("temperatures")(values, n))();
	const Real*       data  = reinterpret_cast<const Real*>(array.get_data());
	if (!heat) throw std::runtime_error("MpmEngine.setTemperature: the scene has no heat; add heat=HeatTransfer() before the first step.");
	meetBefore("MpmEngine.setTemperature");
	begun = true;
	vector<Real> pressure(n, 0);
	if (water) g.copyById("pressure", 0, pressure.data());
	for (int id = 0; id < n; ++id)
		g.setThermalState(id, data[id], pressure[id]);
}

void MpmEngine::resetDisplacement()
{
	auto& g = runningGround();
	meetBefore("MpmEngine.resetDisplacement");
	auto&     f          = g.pointFields();
	const int n          = pointCount();
	const int dimensions = g.dimension();
	for (int axis = 0; axis < dimensions; ++axis)
		if (Real* displacement = f.find("displacement", axis)) {
			// an event that goes on keeps what it moved so far
			if (Real* before = f.find("displacementBefore", axis))
				for (int p = 0; p < n; ++p)
					before[p] -= displacement[p];
			std::fill(displacement, displacement + n, 0.);
		}
	for (int c = 0; c < dimensions * dimensions; ++c)
		if (Real* deformation = f.find("deformationGradient", c)) std::fill(deformation, deformation + n, c % (dimensions + 1) == 0 ? 1. : 0.);
}

} // namespace yade
