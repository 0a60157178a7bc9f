// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/mpm/Errors.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/multiscale/AtomicFile.hpp>
#include <pkg/multiscale/ByteArchive.hpp>
#include <pkg/multiscale/MpmEngine.hpp>
#include <pkg/multiscale/Plausibility.hpp>
#include <pkg/rve/open/HoldGil.hpp>
#include <pkg/rve/open/StepGate.hpp>

#include <boost/python/numpy.hpp>
#include <iostream>
#include <mutex>
#include <numeric>
#include <set>
#include <sstream>

namespace py = boost::python;
namespace np = boost::python::numpy;

namespace yade {
YADE_PLUGIN((MpmEngine));

namespace {
	/// One added point in pointInput: x y volume porosity temperature pressure skeleton sxx syy szz sxy vx vy poreFill.
	constexpr int numbersPerPoint = 14;

	constexpr double secondsPerDay = 86400;

	const char archiveMagic[] = "talik ground 5";

	np::ndarray asArray(const string& name, const py::object& values)
	{
		try {
			return np::from_object(values, np::dtype::get_builtin<double>(), np::ndarray::CARRAY_RO);
		} catch (const py::error_already_set&) {
			PyErr_Clear();
			throw std::invalid_argument(
			        "MpmEngine." + name + " is " + string(py::extract<string>(py::str(values))) + ": give a number or an array of numbers.");
		}
	}

	/// Fills one column per component of the point table from a scalar, a row of components, or an array with a row per point.
	void fillColumns(vector<Real>& table, int points, int first, int components, const string& name, const py::object& values)
	{
		const np::ndarray array = asArray("addPoints: " + name, values);
		const Real*       data  = reinterpret_cast<const Real*>(array.get_data());
		long              size  = 1;
		for (int d = 0; d < array.get_nd(); d++)
			size *= array.shape(d);
		const bool uniform = size == components && (components > 1 || array.get_nd() == 0 || points == 1);
		if (!uniform && size != long(points) * components)
			throw std::invalid_argument(
			        "MpmEngine.addPoints: " + name + " has " + std::to_string(size) + " numbers for " + std::to_string(points) + " points: give "
			        + std::to_string(components) + " or " + std::to_string(long(points) * components)
			        + (name == "stress" ? ", in the order of field('stress'): xx, yy, zz, xy." : "."));
		for (int p = 0; p < points; p++)
			for (int c = 0; c < components; c++)
				table[p * numbersPerPoint + first + c] = data[uniform ? c : p * components + c];
	}

	struct Column {
		const char*  name;
		int          first, components;
		vector<Real> byDefault;
	};
	const vector<Column>& optionalColumns()
	{
		static const vector<Column> columns {
			{ "volume", 2, 1, { NaN } },     { "porosity", 3, 1, { 0.4 } },  { "temperature", 4, 1, { 0 } },
			{ "pressure", 5, 1, { 0 } },     { "skeleton", 6, 1, { 0 } },    { "stress", 7, 4, { NaN, NaN, NaN, NaN } },
			{ "velocity", 11, 2, { 0, 0 } }, { "poreFill", 13, 1, { NaN } },
		};
		return columns;
	}

	/// skeleton is the number of a law: half a number is none.
	void requireWholeNumbers(const vector<Real>& table)
	{
		for (std::size_t row = 0; row < table.size(); row += numbersPerPoint)
			if (table[row + 6] != std::floor(table[row + 6]) || std::abs(table[row + 6]) > 1e9)
				throw std::invalid_argument(
				        "MpmEngine.addPoints: skeleton is " + boost::lexical_cast<string>(table[row + 6])
				        + ": give the number of a law in skeletons, a whole number.");
	}

	talik::PointInput<2> pointFrom(const Real* row)
	{
		talik::PointInput<2> point;
		point.position    = { row[0], row[1] };
		point.volume      = row[2];
		point.porosity    = row[3];
		point.temperature = row[4];
		point.pressure    = row[5];
		point.skeleton    = int(row[6]);
		point.stress      = { row[7], row[8], row[9], row[10] };
		point.velocity    = { row[11], row[12] };
		point.poreFill    = row[13];
		return point;
	}
} // namespace

// ---- before the first step -------------------------------------------------------------------------------------------------

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
			for (int k = 0; k < py::len(value); k++)
				if (contains(value[k], part)) return true;
			return false;
		}
		const py::extract<Serializable*> object(value);
		return object.check() && object() == part.get();
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

bool MpmEngine::hasBegun() const
{
	if (!ground) return false;
	const auto laws = activeSkeletons();
	return begun || std::any_of(laws.begin(), laws.end(), [](const auto& law) { return law && law->changedByHand(); });
}

bool MpmEngine::holds(const shared_ptr<Serializable>& part) const
{
	if (part.get() == this) return true;
	const py::list values(pyDict().values());
	for (int k = 0; k < py::len(values); k++)
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

/// Of a ground that has not begun: its inputs have all that it was made from.
void MpmEngine::discardGround()
{
	ground.reset();
	if (!watched) return;
	watched->times.clear();
	watched->rows.clear();
	watched->components.clear();
	if (watchesDefault) watched->fields.clear();
}

bool MpmEngine::isAsSet() const
{
	try {
		checkFixed();
	} catch (const std::invalid_argument&) {
		return false;
	}
	const auto laws = activeSkeletons();
	return std::none_of(laws.begin(), laws.end(), [](const auto& law) { return law && law->sourcesChanged(); });
}

/// Looking at a ground does not fix it: until it has begun it is what its settings say now.
void MpmEngine::followInputs()
{
	if (!ground || hasBegun() || isAsSet()) return;
	discardGround();
}

// ---- points ----------------------------------------------------------------------------------------------------------------

py::object MpmEngine::pyAddPoints(py::tuple args, py::dict keywords)
{
	static const char* const names[] = { "position", "volume", "porosity", "temperature", "pressure", "skeleton", "stress", "velocity", "poreFill" };
	MpmEngine&               self    = py::extract<MpmEngine&>(args[0]);
	for (int i = 1; i < py::len(args) && i <= 9; i++)
		keywords[names[i - 1]] = args[i];
	self.addPoints(keywords);
	return py::object();
}

void MpmEngine::addPoints(py::dict arrays)
{
	if (hasBegun()) throw std::runtime_error("MpmEngine.addPoints: the ground has started; add all points before the first step.");
	if (!arrays.has_key("position")) throw std::invalid_argument("MpmEngine.addPoints: position is missing; give an array (n,2) [m].");
	const np::ndarray position = asArray("addPoints: position", arrays["position"]);
	if (position.get_nd() != 2 || position.shape(1) != 2) throw std::invalid_argument("MpmEngine.addPoints: position is not an array (n,2).");
	const int    points = position.shape(0);
	vector<Real> rows(points * numbersPerPoint, 0);
	fillColumns(rows, points, 0, 2, "position", arrays["position"]);
	py::list unknown = arrays.keys();
	unknown.remove("position");
	for (const auto& column : optionalColumns()) {
		if (arrays.has_key(column.name)) {
			fillColumns(rows, points, column.first, column.components, column.name, arrays[column.name]);
			unknown.remove(column.name);
			continue;
		}
		for (int p = 0; p < points; p++)
			std::copy(column.byDefault.begin(), column.byDefault.end(), &rows[p * numbersPerPoint + column.first]);
	}
	if (py::len(unknown) > 0) throw std::invalid_argument("MpmEngine.addPoints: there is no argument '" + string(py::extract<string>(unknown[0])) + "'.");
	requireWholeNumbers(rows);
	pointInput.insert(pointInput.end(), rows.begin(), rows.end());
	if (ground) discardGround();
}

int  MpmEngine::lawOf(int id) const { return int(pointInput[id * numbersPerPoint + 6]); }
void MpmEngine::setLawOf(int id, int number) { pointInput[id * numbersPerPoint + 6] = number; }

int MpmEngine::pointCount() const { return int(pointInput.size()) / numbersPerPoint; }

/// goesOn: with a state that comes afterwards.
void MpmEngine::addPointsToGround(bool goesOn)
{
	const auto laws = activeSkeletons();
	for (int id = 0; id < pointCount(); id++) {
		talik::PointInput<2> point = pointFrom(&pointInput[id * numbersPerPoint]);
		if (!std::isnan(point.stress[0]) && !goesOn && motion && point.skeleton >= 0 && point.skeleton < int(laws.size())
		    && laws[point.skeleton]->beginsWithOwnStress())
			throw std::invalid_argument(
			        "MpmEngine.addPoints: stress of point " + std::to_string(id) + " is given, but its " + laws[point.skeleton]->getClassName()
			        + " begins with the stress of its sample: leave stress out, and bring the samples to it by talik.slope.settle or depthBands.");
		if (std::isnan(point.stress[0])) {
			point.stress.fill(0);
			if (point.skeleton >= 0 && point.skeleton < int(laws.size())) laws[point.skeleton]->initialStress(id, point.position, point.stress);
		}
		ground->addPoint(point);
	}
}

// ---- settings --------------------------------------------------------------------------------------------------------------

vector<shared_ptr<SkeletonLaw>> MpmEngine::activeSkeletons() const
{
	if (!skeletons.empty()) return skeletons;
	if (skeleton) return { skeleton };
	return {};
}

void MpmEngine::checkPresence() const
{
	if (pointCount() == 0)
		throw std::invalid_argument(
		        "MpmEngine has no material points: fill it with talik.geometry.fill(mpm, polygon) or mpm.addPoints(…) before the first step.");
	if (!(gridSpacing > 0))
		throw std::invalid_argument("MpmEngine.gridSpacing is " + boost::lexical_cast<string>(gridSpacing) + ": give a positive spacing in m.");
	if (!material) throw std::invalid_argument("MpmEngine.material is None: give a GroundMaterial().");
	if (freezing && !heat) throw std::invalid_argument("MpmEngine.freezing is set but heat is None: add heat=HeatTransfer().");
	if (freezing && water && freezing->residualSaturation < 0.01)
		throw std::invalid_argument(
		        "FreezingCurve.residualSaturation is " + std::to_string(freezing->residualSaturation)
		        + ": give 0.01 to below 1 in a scene with water, whose ground is never quite solid.");
	if (bodies && !motion)
		throw std::invalid_argument("MpmEngine.bodies is set but motion is False: bodies push only ground that may move; set motion=True.");
	if (water && !motion)
		throw std::invalid_argument("MpmEngine.water is set but motion is False: water moves only in ground that may move; set motion=True.");
	const bool otherTransfer = talik::velocityTransferFromName(transfer) != talik::VelocityTransfer::flip;
	if (otherTransfer && !motion)
		throw std::invalid_argument(
		        "MpmEngine.transfer is '" + transfer + "' but motion is False: rigid ground has no velocity to transfer; leave it out.");
	if (motion && activeSkeletons().empty())
		throw std::invalid_argument("MpmEngine.skeleton is None: ground that moves needs one, e.g. skeleton=ElasticSkeleton(); or set motion=False.");
	for (const auto& law : activeSkeletons())
		if (!law) throw std::invalid_argument("MpmEngine.skeletons holds None: give skeleton laws only.");
	for (const auto& boundary : boundaries)
		if (!boundary) throw std::invalid_argument("MpmEngine.boundaries holds None: give boundaries only.");
	checkChangeable();
}

/// What may be changed while the ground is running, before every step.
void MpmEngine::checkChangeable() const
{
	const auto require = [](bool valid, const char* name, Real value, const char* remedy) {
		if (!valid) throw std::invalid_argument("MpmEngine." + string(name) + " is " + boost::lexical_cast<string>(value) + ": give " + remedy + ".");
	};
	for (int axis = 0; axis < 2; axis++)
		require(std::isfinite(gravity[axis]), "gravity", gravity[axis], "finite components in m/s^2");
	require(damping >= 0 && damping < 1, "damping", damping, "a number from 0 to below 1");
	require(!(picTime < 0), "picTime", picTime, "a time in s, 0 or more; inf: none dies out, nan: chosen");
	require(courantNumber > 0 && courantNumber <= 1, "courantNumber", courantNumber, "a number above 0 and up to 1");
	require(heatFraction > 0 && heatFraction <= 1, "heatFraction", heatFraction, "a number above 0 and up to 1");
	require(tolerance == 0 || (tolerance >= 1e-4 && tolerance <= 0.5), "tolerance", tolerance, "0, or a relative error from 1e-4 to 0.5, e.g. 0.03");
	require(motionFraction > 0 && motionFraction <= 0.5, "motionFraction", motionFraction, "a number above 0 and up to 0.5");
	require(limitInterval >= 1, "limitInterval", limitInterval, "1 or more steps");
	require(!std::isnan(stopAtDay), "stopAtDay", stopAtDay, "a day of the calendar, or infinity");
	if (bodies) bodies->build();
}

talik::GroundSettings<2> MpmEngine::buildSettings() const
{
	talik::GroundSettings<2> s;
	s.gridSpacing = gridSpacing;
	for (int axis = 0; axis < 2; axis++) {
		Real low = std::numeric_limits<Real>::infinity(), high = -low;
		for (int id = 0; id < pointCount(); id++) {
			const Real x = pointInput[id * numbersPerPoint + axis], half = 0.5 * std::sqrt(pointInput[id * numbersPerPoint + 2]);
			low  = std::min(low, x - half);
			high = std::max(high, x + half);
		}
		s.lower[axis]    = std::isnan(lower[axis]) ? gridSpacing * std::floor(low / gridSpacing + 1e-6) : lower[axis];
		const Real cells = (high - s.lower[axis]) / gridSpacing;
		s.upper[axis]    = std::isnan(upper[axis]) ? s.lower[axis] + gridSpacing * std::ceil(cells - 1e-6) : upper[axis];
	}
	s.shapeFunction = shapeFunction;
	s.mixture       = material->build();
	if (motion) {
		talik::MotionSettings<2> m;
		m.gravity      = { gravity[0], gravity[1] };
		m.transfer     = talik::velocityTransferFromName(transfer);
		m.picTime      = picTime;
		m.localDamping = damping;
		m.bBar         = bBar;
		s.motion       = m;
	}
	if (heat) s.heat = heat->build();
	if (bodies) s.bodies = bodies->build();
	if (freezing) s.freezing = freezing->build();
	s.thawFront.reset();
	if (thawFront) s.thawFront = thawFront->build();
	if (water) s.water = water->build(freezing ? freezing->residualSaturation : 0);
	s.energyLedger      = energyLedger;
	s.deformationRecord = motion && deformationRecord;
	s.poreFill          = poreFill;
	for (const auto& boundary : boundaries)
		s.boundaries.push_back(boundary->build());
	std::vector<talik::Vec<2>> places;
	for (int id = 0; id < pointCount(); id++)
		places.push_back({ pointInput[id * numbersPerPoint], pointInput[id * numbersPerPoint + 1] });
	if (motion)
		for (const auto& law : activeSkeletons()) {
			law->placePoints(places);
			s.skeletons.push_back(law->build(pointCount()));
			if (tolerance > 0) law->setTolerance(tolerance);
		}
	s.courantNumber  = courantNumber;
	s.heatFraction   = heatFraction;
	s.motionFraction = motionFraction;
	return s;
}

void MpmEngine::initialise()
{
	followInputs();
	if (ground) return;
	const bool goesOn = begun || !saved.empty();
	begun             = false;
	checkPresence();
	ground           = std::make_shared<talik::Ground<2>>(buildSettings());
	stepsUntilLimit  = 0;
	bodiesNamed      = false;
	stableStep       = 0;
	toleranceInForce = tolerance;
	try {
		addPointsToGround(goesOn);
		ground->initialise();
		restoreSavedState();
		stepsAtStart = ground->steps();
		if (!goesOn) {
			sayGraveDoubts();
			warnOfCalendar();
		}
	} catch (...) {
		ground.reset();
		throw;
	}
}

namespace {
	vector<talik::PointInput<2>> pointsFrom(const vector<Real>& table)
	{
		vector<talik::PointInput<2>> points;
		for (std::size_t row = 0; row < table.size(); row += numbersPerPoint)
			points.push_back(pointFrom(&table[row]));
		return points;
	}
} // namespace

py::list MpmEngine::doubts() const
{
	py::list sentences;
	for (const auto& doubt : talik::doubtsAbout(*this, pointsFrom(pointInput)))
		sentences.append(doubt.sentence);
	return sentences;
}

/// Once, however often a ground that has not begun is made anew.
void MpmEngine::say(const string& sentence)
{
	if (said.insert(sentence).second) std::cerr << sentence << std::endl;
}

void MpmEngine::sayGraveDoubts()
{
	for (const auto& doubt : talik::doubtsAbout(*this, pointsFrom(pointInput)))
		if (doubt.grave) say("Talik doubts: " + doubt.sentence);
}

talik::Ground<2>& MpmEngine::runningGround()
{
	initialise();
	return *ground;
}

/// Tables of which nothing is left after one step were probably meant in seconds of motion, or in days; water faster than the grains hold.
void MpmEngine::warnOfCalendar()
{
	if (water && ground->seepageScale() < 1 && !(water->hydraulicTimeScale < 1) && !(heat && heat->thermalTimeScale < 1)) {
		std::ostringstream text;
		text << "Talik warns: PoreWater.conductivity is " << water->conductivity << " m/s, " << water->conductivity * ground->seepageScale()
		     << " m/s is used: pressure in this ground rests within a fraction of a second with it, with more the water would swing.";
		say(text.str());
	}
	const double step = ground->stableTimeStep().step;
	const auto&  c    = ground->calendar();
	const double slow = std::min(
	        heat ? heat->thermalTimeScale * step : step, heat && heat->followsMotion ? c.reach : std::numeric_limits<double>::infinity());
	for (std::size_t i = 0; i < boundaries.size(); i++) {
		const auto& b = *boundaries[i];
		if (b.times.size() < 2 || !(b.times.back() > 0) || !(b.times.back() < slow)) continue;
		std::ostringstream text;
		text << "Talik warns: MpmEngine.boundaries[" << i << "], " << b.getClassName() << ".times ends at " << b.times.back()
		     << " s of calendar time, within the first step of " << slow << " s; days are given as days * talik.day";
		if (heat && heat->thermalTimeScale != 1) text << ", and one second of motion is " << heat->thermalTimeScale << " s of the calendar";
		text << ".";
		say(text.str());
	}
}

// ---- the step --------------------------------------------------------------------------------------------------------------

/// What the ground was built with and cannot change any more: silence would leave a user with another ground than the one written.
void MpmEngine::checkFixed() const
{
	const auto& s       = ground->settings();
	const auto  require = [](bool same, const char* name, const string& value) {
                if (!same)
                        throw std::invalid_argument(
			         "MpmEngine." + string(name) + " is now " + value
			         + ", which the running ground cannot follow: set it back, or give the points to another engine.");
	};
	const auto effect = [&](bool had, bool has, const char* name) { require(had == has, name, has ? "there" : "None"); };
	require(bool(s.motion) == motion, "motion", motion ? "True" : "False");
	effect(bool(s.heat), bool(heat), "heat");
	effect(bool(s.freezing), bool(freezing), "freezing");
	effect(bool(s.water), bool(water), "water");
	effect(bool(s.bodies), bool(bodies), "bodies");
	effect(bool(s.thawFront), bool(thawFront), "thawFront");
	require(s.gridSpacing == gridSpacing, "gridSpacing", boost::lexical_cast<string>(gridSpacing));
	for (int axis = 0; axis < 2; axis++) {
		require(std::isnan(lower[axis]) || lower[axis] == s.lower[axis], "lower", boost::lexical_cast<string>(lower[axis]));
		require(std::isnan(upper[axis]) || upper[axis] == s.upper[axis], "upper", boost::lexical_cast<string>(upper[axis]));
	}
	require(s.shapeFunction == shapeFunction, "shapeFunction", shapeFunction);
	require(!s.motion || s.motion->transfer == talik::velocityTransferFromName(transfer), "transfer", transfer);
	require(s.boundaries.size() == boundaries.size(), "boundaries", "a list of " + std::to_string(boundaries.size()));
}

namespace {
	[[noreturn]] void raiseAttributeError(const string& text)
	{
		PyErr_SetString(PyExc_AttributeError, text.c_str());
		::boost::python::throw_error_already_set();
		throw std::logic_error(text); // never reached
	}

	// a share per step is a viscosity that grows as the step shrinks: there is no time that stands for it
	[[noreturn]] void refuseFlip(const string& className)
	{
		raiseAttributeError(
		        className
		        + ".flip, a share kept per step, is replaced by picTime [s]: exp(-dt/picTime) is kept; leave both out for the default, or give "
		        + className + ".picTime=inf in place of flip=1.");
	}

	const std::map<string, string>& renamedAttributes()
	{
		static const std::map<string, string> names { { "waveFraction", "courantNumber" },
			                                      { "cellAveraging", "bBar" },
			                                      { "believedError", "estimatedError" } };
		return names;
	}
} // namespace

void MpmEngine::refuseFormerName(const char* name)
{
	if (string(name) == "flip") refuseFlip("MpmEngine");
	raiseAttributeError("MpmEngine." + string(name) + " is now MpmEngine." + renamedAttributes().at(name) + ": the same value under the new name.");
}

void MpmEngine::pyHandleCustomCtorArgs(::boost::python::tuple&, ::boost::python::dict& keywords)
{
	if (keywords.has_key("flip")) refuseFlip("MpmEngine");
	for (const auto& [former, present] : renamedAttributes())
		if (keywords.has_key(former)) refuseFormerName(former.c_str());
}

Real PoreWater::refusedFlip() const { refuseFlip("PoreWater"); }
void PoreWater::setFlip(Real) { refuseFlip("PoreWater"); }
void PoreWater::pyHandleCustomCtorArgs(::boost::python::tuple&, ::boost::python::dict& keywords)
{
	if (keywords.has_key("flip")) refuseFlip("PoreWater");
}

void MpmEngine::followAttributes()
{
	checkFixed();
	checkChangeable();
	auto& s = ground->settings();
	if (s.motion) {
		s.motion->gravity      = { gravity[0], gravity[1] };
		s.motion->localDamping = damping;
		s.motion->picTime      = picTime;
	}
	s.courantNumber  = courantNumber;
	s.heatFraction   = heatFraction;
	s.motionFraction = motionFraction;
	s.resting        = resting;
	if (tolerance != toleranceInForce) followTolerance();
	if (heat) followHeat();
	if (s.motion)
		for (const auto& law : activeSkeletons())
			law->followAttributes();
}

/// Scales of the calendar may change between two steps.
void MpmEngine::followHeat()
{
	auto& inForce = *ground->settings().heat;
	if (inForce.thermalTimeScale == heat->thermalTimeScale && inForce.movingTimeScale == heat->movingTimeScale
	    && inForce.motionTolerance == heat->motionTolerance)
		return;
	auto changed                = ground->settings();
	changed.heat                = heat->build();
	changed.heat->followsMotion = inForce.followsMotion;
	talik::checkSettings(changed);
	inForce.thermalTimeScale = heat->thermalTimeScale;
	inForce.movingTimeScale  = heat->movingTimeScale;
	inForce.motionTolerance  = heat->motionTolerance;
	stepsUntilLimit          = 0;
}

void MpmEngine::followTolerance()
{
	if ((tolerance == 0) != (toleranceInForce == 0))
		throw std::invalid_argument(
		        "MpmEngine.tolerance was " + boost::lexical_cast<string>(toleranceInForce) + " when the ground started and is "
		        + boost::lexical_cast<string>(tolerance)
		        + ": change it while running to other values above 0 only; to switch it on or off, begin anew.");
	for (const auto& law : activeSkeletons())
		law->setTolerance(tolerance);
	toleranceInForce = tolerance;
}

/// Determines the stable step anew now and then; true if it did.
bool MpmEngine::watchStableStep()
{
	if (stepsUntilLimit-- > 0) return false;
	stepsUntilLimit = findStableStep() - 1;
	return true;
}

/// Determines the stable step and returns how many steps it may be kept. Ice stiffens the ground: where that forms, the limit is asked
/// again before heat has crossed half a cell.
int MpmEngine::findStableStep()
{
	const auto stable = ground->stableTimeStep();
	stableStep        = stable.step;
	Real steps        = limitInterval;
	if (freezing)
		for (const auto& limit : stable.limits)
			if (limit.name == "heat")
				steps = std::min(
				        steps, 0.5 * limit.step / stableStep * (heat->followsMotion ? heat->movingTimeScale / heat->thermalTimeScale : 1));
	return std::max(1, int(steps));
}

int MpmEngine::subSteps(double dt) const
{
	if (!(dt > 0) || !std::isfinite(dt)) throw std::invalid_argument("O.dt is " + boost::lexical_cast<string>(dt) + ": give a positive time step in s.");
	const double steps = std::ceil(dt / stableStep * (1 - 1e-12));
	if (!(steps < 1e6))
		throw std::runtime_error(
		        "MpmEngine: O.dt = " + boost::lexical_cast<string>(dt) + " s exceeds the stable time step " + boost::lexical_cast<string>(stableStep)
		        + " s a million times: lower O.dt or set automaticTimeStep=True.");
	return std::max(1, int(steps));
}

std::atomic<bool> MpmEngine::runWaitedFor { false };

namespace {
	/// The error comes up where the run is waited for: YADE's log does not say it as well.
	void muteLog()
	{
		const talik::HoldGil held;
		try {
			py::import("talik.console").attr("muteLog")();
		} catch (const py::error_already_set&) {
			PyErr_Clear();
		}
	}
} // namespace

/// A step that fails leaves the scene between two steps: it can be looked at, saved and, with other settings, continued.
void MpmEngine::action()
{
	const talik::StepGate gate;
	if (inspected) throw std::runtime_error("MpmEngine: O shows one of the samples of this ground; mpm.back() returns to the ground, which steps then.");
	failure.clear();
	try {
		stepGround();
	} catch (const std::exception& problem) {
		failure = problem.what();
		failures++;
		if (!scene->isPeriodic && !scene->subStepping) scene->subStep = -1;
		if (runWaitedFor) muteLog();
		throw;
	}
}

void MpmEngine::stepGround()
{
	initialise();
	begun = true;
	followAttributes();
	const bool newLimit = watchStableStep();
	if (watched) recordWatched();
	const double before = ground->calendar().time;
	if (bodies) advanceAmongBodies();
	else advanceAlone(newLimit);
	if (watched) recordWatched();
	stopAtTheDay(before);
}

void MpmEngine::stopAtTheDay(double before)
{
	const double wanted = stopAtDay * secondsPerDay;
	if (before < wanted && ground->calendar().time >= wanted) scene->stopAtIter = scene->iter + 1;
}

/// Of several grounds the first chooses the step: one that chose its own after it would run by another clock than the scene.
bool MpmEngine::leadsTimeStep() const
{
	for (const auto& engine : scene->engines)
		if (const auto* other = dynamic_cast<const MpmEngine*>(engine.get()))
			if (!other->dead && other->automaticTimeStep) return other == this;
	return true;
}

/// What the grounds behind this one want.
Real MpmEngine::timeStepOfOthers()
{
	Real step = std::numeric_limits<Real>::infinity();
	for (const auto& engine : scene->engines) {
		auto* other = dynamic_cast<MpmEngine*>(engine.get());
		if (!other || other == this || other->dead || !other->automaticTimeStep) continue;
		other->scene = scene;
		step         = std::min(step, other->wantedStep());
	}
	return step;
}

Real MpmEngine::wantedStep()
{
	initialise();
	if (stableStep == 0) findStableStep();
	if (!bodies) return stableStep;
	collectBodies();
	return bodies->timeStep(*scene, stableStep);
}

/// A step beyond the limit takes several of the ground's, in which the limit moves on.
void MpmEngine::advanceAlone(bool newLimit)
{
	if (automaticTimeStep && leadsTimeStep()) {
		const Real others = timeStepOfOthers();
		if (newLimit || others < scene->dt) scene->dt = std::min(stableStep, others);
	}
	Real done = 0;
	for (bool whole = false; !whole;) {
		const Real left  = scene->dt - done;
		const int  kept  = subSteps(left) > 1 ? findStableStep() : 1;
		const int  count = subSteps(left), now = std::min(count, kept);
		const Real dt = left / count;
		for (int i = 0; i < now; i++) {
			try {
				advance(dt);
			} catch (const talik::StopAfterStep&) { // the ground has done this step, the clock of the scene follows
				scene->time += done + (i + 1) * dt;
				scene->iter++;
				throw;
			}
		}
		done += now * dt;
		whole = now == count;
	}
}

void MpmEngine::collectBodies()
{
	auto& contact = *ground->bodies();
	bodies->collect(*scene, *this, contact);
	if (bodiesNamed) return;
	for (const auto& boundary : boundaries)
		boundary->checkBodies(contact.bodies);
	bodiesNamed = true;
}

/// In the ground's step the bodies are where their velocities take them from their places in the scene.
void MpmEngine::advanceAmongBodies()
{
	auto& contact = *ground->bodies();
	collectBodies();
	if (automaticTimeStep && leadsTimeStep()) scene->dt = std::min(bodies->timeStep(*scene, stableStep), timeStepOfOthers());
	if (bodies->due(*scene) > 1e-9 * scene->dt) {
		const double begin = bodies->ahead, interval = bodies->groundStep(*scene, stableStep);
		const int    count = subSteps(interval);
		for (int i = 0; i < count; i++) {
			bodies->place(contact, begin + i * (interval / count));
			advance(interval / count);
		}
		bodies->take(contact, interval);
	}
	bodies->deliver(*scene);
}

/// One cycle of Yu & Zhao, section 2.3. The paper's steps 2 and 3 close the cycle here, with the velocities just solved.
void MpmEngine::advance(double dt)
{
	ground->beginStep(dt);
	ground->p2g();                     // step 1: points to grid
	ground->solveNodes();              // step 4: nodal forces and heat flows, implicit drag, boundaries
	ground->g2p();                     // step 5: grid to points
	ground->updateStrainAndPressure(); // step 2: strain, pore pressure, saturations
	ground->updateEffectiveStress();   // step 3: displacement gradient and ice saturation down, effective stress back
}

// ---- what Python sees ------------------------------------------------------------------------------------------------------

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
	if (motion && deformationRecord) {
		names.push_back("strain");
		names.push_back("deviatoricStrain");
	}
	for (const auto& law : activeSkeletons())
		for (const auto& measure : law->measures())
			if (std::find(names.begin(), names.end(), measure) == names.end()) names.push_back(measure);
	return names;
}

py::list MpmEngine::fieldNames()
{
	py::list names;
	for (const auto& name : existingFields())
		names.append(name);
	return names;
}

py::list MpmEngine::fields()
{
	py::list result;
	for (const auto& info : runningGround().fields()) {
		py::dict entry;
		entry["name"]       = info.name;
		entry["owner"]      = info.owner;
		entry["unit"]       = info.unit;
		entry["place"]      = info.place;
		entry["components"] = info.components;
		entry["bytes"]      = info.bytes;
		result.append(entry);
	}
	return result;
}

namespace {
	/// Logarithmic strain of F in the plane: xx, yy, xy [-].
	std::array<Real, 3> logarithmicStrain(const Real* f)
	{
		Eigen::Matrix2d F;
		F << f[0], f[1], f[2], f[3];
		const Eigen::Matrix2d b    = F * F.transpose();
		const double          mean = 0.5 * b.trace(), radius = std::sqrt(std::max(0., mean * mean - b.determinant()));
		const double          e1 = 0.5 * std::log(mean + radius), e2 = 0.5 * std::log(std::max(mean - radius, 1e-300));
		const double          half = radius > 0 ? 0.5 * (e1 - e2) / radius : 0;
		return { 0.5 * (e1 + e2) + 0.5 * half * (b(0, 0) - b(1, 1)), 0.5 * (e1 + e2) - 0.5 * half * (b(0, 0) - b(1, 1)), half * b(0, 1) };
	}

	/// sqrt(2/3 e:e) of the deviator in plane strain.
	double deviatoricPart(const std::array<Real, 3>& e)
	{
		const double third = (e[0] + e[1]) / 3;
		return std::sqrt(2. / 3 * ((e[0] - third) * (e[0] - third) + (e[1] - third) * (e[1] - third) + third * third + 2 * e[2] * e[2]));
	}

	vector<Real> strainOf(const string& name, const Real* f)
	{
		const auto e = logarithmicStrain(f);
		if (name == "strain") return { e[0], e[1], e[2] };
		return { deviatoricPart(e) };
	}

	bool isStrain(const string& name) { return name == "strain" || name == "deviatoricStrain"; }

	/// Rows of equal length as an array (n,) or (n, components).
	np::ndarray arrayOf(const vector<vector<Real>>& rows)
	{
		const std::size_t parts = rows.empty() ? 1 : rows.front().size();
		np::ndarray result = np::zeros(parts == 1 ? py::make_tuple(rows.size()) : py::make_tuple(rows.size(), parts), np::dtype::get_builtin<double>());
		Real*       data   = reinterpret_cast<Real*>(result.get_data());
		for (const auto& row : rows)
			data = std::copy(row.begin(), row.end(), data);
		return result;
	}
} // namespace

py::object MpmEngine::strains(const string& name)
{
	if (!deformationRecord || !motion) throw std::invalid_argument("MpmEngine.field: " + name + " needs motion and deformationRecord=True.");
	np::ndarray          f = py::extract<np::ndarray>(field("deformationGradient"))();
	vector<vector<Real>> rows(f.shape(0));
	for (std::size_t i = 0; i < rows.size(); i++)
		rows[i] = strainOf(name, reinterpret_cast<const Real*>(f.get_data()) + 4 * i);
	return arrayOf(rows);
}

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

/// A measure of the samples, each point's from the skeleton that it has.
py::object MpmEngine::measured(const vector<shared_ptr<SkeletonLaw>>& laws, const string& name) const
{
	vector<vector<Real>> rows(pointCount());
	vector<np::ndarray>  tables;
	for (const auto& law : laws)
		tables.push_back(py::extract<np::ndarray>(law->values(name))());
	for (int id = 0; id < pointCount(); id++)
		for (const auto& table : tables) {
			const int   parts = table.get_nd() == 1 ? 1 : table.shape(1);
			const Real* row   = reinterpret_cast<const Real*>(table.get_data()) + id * parts;
			if (rows[id].empty() || std::isnan(rows[id].front())) rows[id].assign(row, row + parts);
		}
	return arrayOf(rows);
}

py::object MpmEngine::field(const string& name)
{
	auto& g = runningGround();
	if (isStrain(name)) return strains(name);
	const auto laws = lawsMeasuring(name);
	if (!laws.empty()) return measured(laws, name);
	int       parts = 1;
	const int n     = g.points().count();
	for (const auto& info : g.fields())
		if (info.place == "points" && info.name == name) parts = info.components;
	np::ndarray  result = np::zeros(parts == 1 ? py::make_tuple(n) : py::make_tuple(n, parts), np::dtype::get_builtin<double>());
	Real*        data   = reinterpret_cast<Real*>(result.get_data());
	vector<Real> component(n);
	for (int c = 0; c < parts; c++) {
		g.copyById(name, c, component.data());
		for (int i = 0; i < n; i++)
			data[i * parts + c] = component[i];
	}
	return result;
}

// ---- points by what they suffer --------------------------------------------------------------------------------------------

int MpmEngine::pick(Real x, Real y)
{
	const auto& points  = runningGround().points();
	int         nearest = -1;
	Real        least   = std::numeric_limits<Real>::infinity();
	for (int id = 0; id < points.count(); id++) {
		const int  place = points.place(id);
		const Real dx = points.position(0)[place] - x, dy = points.position(1)[place] - y, square = dx * dx + dy * dy;
		if (!(square < least)) continue; // also where (x, y) is not a number
		least   = square;
		nearest = id;
	}
	if (nearest < 0)
		throw std::invalid_argument("MpmEngine.pick: (" + boost::lexical_cast<string>(x) + ", " + boost::lexical_cast<string>(y) + ") is no place.");
	return nearest;
}

py::list MpmEngine::most(const string& name, int count)
{
	if (count < 0) throw std::invalid_argument("MpmEngine.most: n is " + std::to_string(count) + ": give 0 or more.");
	const np::ndarray            values = py::extract<np::ndarray>(field(name))();
	const int                    points = values.shape(0), parts = values.get_nd() == 1 ? 1 : values.shape(1);
	vector<std::pair<Real, int>> order;
	for (int id = 0; id < points; id++) {
		const Real* row  = reinterpret_cast<const Real*>(values.get_data()) + id * parts;
		const Real  size = parts == 1 ? row[0] : std::sqrt(std::inner_product(row, row + parts, row, 0.));
		if (!std::isnan(size)) order.emplace_back(-size, id);
	}
	std::sort(order.begin(), order.end());
	py::list ids;
	for (int k = 0; k < std::min(count, int(order.size())); k++)
		ids.append(order[k].second);
	return ids;
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
	const auto&  points = ground->points();
	const auto&  stored = points.fields();
	const string source = isStrain(name) ? "deformationGradient" : name;
	vector<Real> value;
	for (const auto& info : stored.list())
		if (info.name == source)
			for (int c = 0; c < info.components; c++)
				value.push_back(stored.find(source, c)[points.place(id)]);
	return isStrain(name) ? strainOf(name, value.data()) : value;
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
	if (!(interval >= 0))
		throw std::invalid_argument("MpmEngine.watch: interval is " + boost::lexical_cast<string>(interval) + ": give 0 or more seconds.");
	followInputs();
	watchesDefault = py::len(names) == 0;
	shared_ptr<PointWatch> wanted(new PointWatch);
	wanted->interval         = interval;
	const np::ndarray points = asArray("watch: ids", ids);
	const Real*       data   = reinterpret_cast<const Real*>(points.get_data());
	for (int k = 0; k < (points.get_nd() == 0 ? 1 : points.shape(0)); k++) {
		if (!(data[k] >= 0 && data[k] < pointCount()) || data[k] != std::floor(data[k]))
			throw std::invalid_argument(
			        "MpmEngine.watch: " + boost::lexical_cast<string>(data[k]) + " is no point: give ids from 0 to "
			        + std::to_string(pointCount() - 1) + ".");
		if (std::find(wanted->ids.begin(), wanted->ids.end(), int(data[k])) == wanted->ids.end()) wanted->ids.push_back(int(data[k]));
	}
	for (int k = 0; k < py::len(names); k++) {
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
	return watched->history(id);
}

py::dict MpmEngine::balance()
{
	const auto b = runningGround().balance();
	py::dict   d;
	d["time"]               = b.time;
	d["solidMass"]          = b.solidMass;
	d["waterMass"]          = b.waterMass;
	d["iceMass"]            = b.iceMass;
	d["waterOut"]           = b.waterOut;
	d["momentum"]           = py::make_tuple(b.momentum[0], b.momentum[1]);
	d["impulse"]            = py::make_tuple(b.impulse[0], b.impulse[1]);
	d["enthalpy"]           = b.enthalpy;
	d["heatIn"]             = b.heatIn;
	d["enthalpyOut"]        = b.enthalpyOut;
	d["kineticEnergy"]      = b.kineticEnergy;
	d["gravityEnergy"]      = b.gravityEnergy;
	d["skeletonWork"]       = b.skeletonWork;
	d["porePressureWork"]   = b.porePressureWork;
	d["dragDissipation"]    = b.dragDissipation;
	d["dampingDissipation"] = b.dampingDissipation;
	d["loadWork"]           = b.loadWork;
	d["slipWork"]           = b.slipWork;
	return d;
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
	talik::ErrorSquares sum;
	const auto          laws = activeSkeletons();
	for (std::size_t k = 0; k < laws.size(); k++) {
		const auto squares = laws[k]->errorSquares(g.skeletonBatch(int(k)));
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
	for (std::size_t i = 0; i < events.size(); i++) {
		const auto& e = events[i];
		py::dict    d;
		d["day"]      = e.begin / secondsPerDay;
		d["duration"] = e.duration;
		d["days"]     = e.passed / secondsPerDay;
		d["volume"]   = e.volume;
		d["largest"]  = e.largest;
		d["goesOn"]   = i >= ended;
		list.append(d);
	}
	return list;
}

void MpmEngine::setDay(Real day)
{
	if (!std::isfinite(day))
		throw std::invalid_argument("MpmEngine.setDay: day is " + boost::lexical_cast<string>(day) + ": give a finite number of days.");
	runningGround().setCalendar(day * secondsPerDay);
	begun = true;
}

double MpmEngine::skemptonB()
{
	auto& g = runningGround();
	if (!water) throw std::runtime_error("MpmEngine.skemptonB: the scene has no water.");
	const auto&  s       = g.settings();
	Real         modulus = std::numeric_limits<Real>::infinity();
	int          softest = 0;
	vector<Real> byPlace(g.points().count());
	for (int k = 0; k < int(s.skeletons.size()); k++) {
		const auto batch = g.skeletonBatch(k);
		s.skeletons[k]->tangentModulus(batch, byPlace.data());
		for (int i = 0; i < batch.count; i++)
			if (byPlace[batch.place[i]] < modulus) {
				modulus = byPlace[batch.place[i]];
				softest = batch.id[batch.place[i]];
			}
	}
	const talik::PoreState thawed { pointInput[softest * numbersPerPoint + 3], 1, 0, 0 };
	return talik::skemptonB(s.water->state.coefficients(s.mixture, thawed), modulus);
}

void MpmEngine::setTemperature(py::object values)
{
	auto&             g     = runningGround();
	const np::ndarray array = asArray("setTemperature: temperature", values);
	const int         n     = g.points().count();
	const bool        same  = array.get_nd() == 0;
	if (!same && array.shape(0) != n) throw std::invalid_argument("MpmEngine.setTemperature: give a number or one per point.");
	const Real* data = reinterpret_cast<const Real*>(array.get_data());
	for (int id = 0; id < (same ? 1 : n); id++)
		if (!(data[id] > -100 && data[id] < 100))
			throw std::invalid_argument(
			        "MpmEngine.setTemperature: temperature is " + boost::lexical_cast<string>(data[id]) + ": give -100 to 100 degC.");
	if (!heat) throw std::runtime_error("MpmEngine.setTemperature: the scene has no heat; add heat=HeatTransfer() before the first step.");
	begun = true;
	vector<Real> pressure(n, 0);
	if (water) g.copyById("pressure", 0, pressure.data());
	for (int id = 0; id < n; id++)
		g.setThermalState(id, data[same ? 0 : id], pressure[id]);
}

void MpmEngine::resetDisplacement()
{
	auto&     g = runningGround();
	auto&     f = g.points().fields();
	const int n = g.points().count();
	for (int axis = 0; axis < 2; axis++)
		if (Real* displacement = f.find("displacement", axis)) {
			// an event that goes on keeps what it moved so far
			if (Real* before = f.find("displacementBefore", axis))
				for (int p = 0; p < n; p++)
					before[p] -= displacement[p];
			std::fill(displacement, displacement + n, 0.);
		}
	for (int c = 0; c < 4; c++)
		if (Real* deformation = f.find("deformationGradient", c)) std::fill(deformation, deformation + n, c % 3 == 0 ? 1. : 0.);
}

// ---- archives --------------------------------------------------------------------------------------------------------------

namespace {
	/// Bit by bit, but for numbers that are none: archives of text keep only that.
	std::uint64_t digestOf(const vector<Real>& numbers)
	{
		talik::Checksum checksum;
		for (const Real number : numbers) {
			const Real plain = std::isnan(number) ? std::numeric_limits<Real>::quiet_NaN() : number;
			checksum.process_bytes(&plain, sizeof plain);
		}
		return checksum.checksum();
	}
} // namespace

void MpmEngine::preSave(MpmEngine&)
{
	if (!ground || !hasBegun()) return; // until it has begun it comes from its inputs
	talik::ByteWriter writer;
	writer.block(archiveMagic);
	writer.block(&stableStep, sizeof stableStep);
	writer.block(&stepsUntilLimit, sizeof stepsUntilLimit);
	writer.number(digestOf(pointInput));
	for (const auto& array : ground->state()) {
		writer.block(array.name);
		writer.block(array.data, array.bytes);
	}
	const auto& events = ground->endedEvents();
	writer.block(string(reinterpret_cast<const char*>(events.data()), events.size() * sizeof(talik::MotionEvent)));
	for (const auto& law : activeSkeletons())
		writer.block(law->savedState());
	saved = talik::toBase64(writer.bytes());
}

/// A running ground needs its archived state no more; that of one loaded and not yet begun is its only one.
void MpmEngine::postSave(MpmEngine&)
{
	if (ground) string().swap(saved);
}

void MpmEngine::restoreSavedState()
{
	if (saved.empty()) return;
	begun                   = true;
	const string      bytes = talik::fromBase64(saved);
	talik::ByteReader reader(bytes);
	if (reader.block() != archiveMagic)
		throw std::runtime_error("MpmEngine: the saved state is not one of this version of Talik: continue it with the version that saved it.");
	// the run goes on with the same time steps as if it had not been saved
	reader.block(&stableStep, sizeof stableStep);
	reader.block(&stepsUntilLimit, sizeof stepsUntilLimit);
	if (reader.number() != digestOf(pointInput))
		throw std::runtime_error("MpmEngine: the points in the file are not those of its saved state, it is damaged: load an earlier file.");
	for (const auto& array : ground->state()) {
		const string name = reader.block();
		if (name != array.name)
			throw std::runtime_error(
			        "MpmEngine: the saved state has the field '" + name + "' where this Talik has '" + array.name
			        + "': continue it with the version that saved it.");
		reader.block(array.data, array.bytes);
	}
	const string events = reader.block();
	if (events.size() % sizeof(talik::MotionEvent) != 0)
		throw std::runtime_error("MpmEngine: the saved events are damaged; go on from another checkpoint.");
	vector<talik::MotionEvent> ended(events.size() / sizeof(talik::MotionEvent));
	std::copy_n(events.data(), events.size(), reinterpret_cast<char*>(ended.data()));
	ground->setEndedEvents(ended);
	ground->stateRestored();
	for (const auto& law : activeSkeletons())
		law->restoreState(reader.block());
	saved.clear();
}

} // namespace yade
