// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/base/Errors.hpp>
#include <pkg/base/SavedBytes.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/multiscale/engine/MpmEngine.hpp>
#include <pkg/python/PythonFunction.hpp>
#include <pkg/ranks/Communicator.hpp>

#include <boost/python/stl_iterator.hpp>
#include <iomanip>
#include <iostream>
#include <set>
#include <sstream>

namespace py = boost::python;

namespace yade {
YADE_PLUGIN((MpmEngine));

// ---- before the first step -------------------------------------------------------------------------------------------------

bool MpmEngine::hasBegun() const
{
	if (!ground) return false;
	const auto laws = activeSkeletons();
	return begun || std::any_of(laws.begin(), laws.end(), [](const auto& law) { return law && law->changedByHand(); });
}

/// Of a ground that has not begun: its inputs have all that it was made from.
void MpmEngine::discardGround()
{
	dropGround();
	if (!watched) return;
	watched->times.clear();
	watched->rows.clear();
	watched->components.clear();
	if (watchesDefault) watched->fields.clear();
}

std::atomic<std::uint64_t> MpmEngine::settingsChanged { 0 };

bool MpmEngine::isAsSet() const
{
	if (settingsWhenMade != settingsChanged) return false;
	try {
		groundOfScene->checkBox(*this);
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
	MpmEngine& self = py::extract<MpmEngine&>(args[0]);
	self.addPoints(args.slice(1, py::_), keywords);
	return py::object();
}

void MpmEngine::addPoints(const py::object& positional, const py::dict& named)
{
	if (hasBegun()) throw std::runtime_error("MpmEngine.addPoints: the ground has started; add all points before the first step.");
	py::list names;
	for (const auto& each : materials)
		names.append(each ? each->name : "");
	const py::object  added = py::import("talik._points").attr("columns")(positional, named, points.dimension(), names, dimension);
	talik::PointTable more  = points;
	more.add(py::extract<int>(added[0]), py::extract<int>(added[1]), added[2]);
	points = std::move(more);
	if (points.dimension() != 0) dimension = points.dimension();
	if (ground) discardGround();
}

int MpmEngine::usedDimension() const
{
	if (dimension != 0 && dimension != 2 && dimension != 3)
		throw std::invalid_argument(
		        "MpmEngine.dimension is " + std::to_string(dimension) + ": give 2 (plane strain), 3 (space) or 0 (what the points say).");
	if (points.dimension() != 0) {
		if (dimension != 0 && dimension != points.dimension())
			throw std::invalid_argument(
			        "MpmEngine.dimension is " + std::to_string(dimension) + ", but its points have " + std::to_string(points.dimension())
			        + " coordinates: set it back, or give the points to another engine.");
		return points.dimension();
	}
	if (dimension != 0) return dimension;
	const auto inSpace = [](const talik::GroundVector& v) { return v.components() == 3; };
	return inSpace(lower) || inSpace(upper) || inSpace(gravity) ? 3 : 2;
}

int MpmEngine::pointCount() const { return points.count(); }

// ---- settings --------------------------------------------------------------------------------------------------------------

vector<shared_ptr<SkeletonLaw>> MpmEngine::activeSkeletons() const
{
	if (!skeletons.empty()) return skeletons;
	if (skeleton) return { skeleton };
	return {};
}

vector<shared_ptr<GroundMaterial>> MpmEngine::activeMaterials() const
{
	if (!materials.empty()) return materials;
	return { material };
}

vector<talik::SoilMaterial> MpmEngine::soils() const
{
	const auto given = activeMaterials();
	if (given.size() == 1 && !given.front()->isOwnSoil()) return {};
	vector<talik::SoilMaterial> list;
	for (const auto& m : given)
		list.push_back(m->soil(freezing.get(), water.get()));
	return list;
}

void MpmEngine::checkPresence()
{
	talik::velocityTransferFromName(transfer);
	{
		const talik::PythonLock held;
		const string            refusal = py::extract<string>(talik::callPython("talik._refusals", "ofGround", py::ptr(this)));
		if (!refusal.empty()) throw std::invalid_argument(refusal);
	}
	if (freezing && water) freezing->requireLiquid("");
	for (const auto& m : activeMaterials())
		if (m->freezing && water) m->freezing->requireLiquid(" of material '" + m->name + "'");
	checkChangeable();
}

/// What may be changed while the ground is running, before every step.
void MpmEngine::checkChangeable() const
{
	const auto require = [](bool valid, const char* name, Real value, const char* remedy) {
		if (!valid) throw std::invalid_argument("MpmEngine." + string(name) + " is " + talik::asText(value) + ": give " + remedy + ".");
	};
	for (int axis = 0; axis < gravity.components(); ++axis)
		require(std::isfinite(gravity[axis]), "gravity", gravity[axis], "finite components in m/s^2");
	require(damping >= 0 && damping < 1, "damping", damping, "a number from 0 to below 1");
	require(!(picTime < 0), "picTime", picTime, "a time in s, 0 or more; inf: none dies out, nan: chosen");
	require(courantNumber > 0 && courantNumber <= 1, "courantNumber", courantNumber, "a number above 0 and up to 1");
	require(heatFraction > 0 && heatFraction <= 1, "heatFraction", heatFraction, "a number above 0 and up to 1");
	require(tolerance == 0 || (tolerance >= 1e-4 && tolerance <= 0.5), "tolerance", tolerance, "0, or a relative error from 1e-4 to 0.5, e.g. 0.03");
	require(!std::isnan(stopAtDay), "stopAtDay", stopAtDay, "a day of the calendar, or infinity");
	if (bodies) bodies->build(usedDimension());
}

void MpmEngine::initialise()
{
	followInputs();
	if (ground) return;
	const bool goesOn = begun || !saved.empty();
	begun             = false;
	checkPresence();
	shareAmongRanks();
	groundOfScene    = GroundOfScene::make(*this, usedDimension(), goesOn);
	ground           = &groundOfScene->ground();
	settingsWhenMade = settingsChanged;
	stepsUntilLimit  = 0;
	bodiesNamed      = false;
	stableStep       = 0;
	toleranceInForce = tolerance;
	try {
		if (mayBeInSlabs()) ground->distribute(talik::jobCommunicator(), distribute == "ground");
		ground->initialise();
		if (!points.divisions().empty()) ground->repeatDivisions(points.divisions());
		sayHowRanksShare();
		restoreSavedState();
		stepsAtStart = ground->steps();
		if (!goesOn) {
			sayGraveDoubts();
			warnOfCalendar();
		}
	} catch (...) {
		dropGround();
		throw;
	}
}

void MpmEngine::dropGround()
{
	ground = nullptr;
	groundOfScene.reset();
}

/// What talik.plausibility finds hardly meant: sentences, grave ones, or samples of a ground that was made.
vector<string> MpmEngine::foundHardlyMeant(const char* which)
{
	const talik::PythonLock held;
	const py::object        sentences = talik::callPython("talik.plausibility", which, py::ptr(this));
	return { py::stl_input_iterator<string>(sentences), py::stl_input_iterator<string>() };
}

/// With what shows once the ground is made. Not on several ranks, of which one alone may ask.
py::list MpmEngine::doubts()
{
	py::list   sentences;
	const auto add = [&](const string& sentence) { sentences.append(sentence); };
	for (const auto& sentence : foundHardlyMeant("sentences"))
		add(sentence);
	if (begun || !saved.empty() || pointCount() == 0 || talik::jobCommunicator()) return sentences;
	const bool waiting = ground != nullptr;
	silent             = true;
	try {
		initialise();
		for (const auto& sentence : foundHardlyMeant("samples"))
			add(sentence);
	} catch (const std::invalid_argument& refusal) {
		add("The first step refuses this ground: " + string(refusal.what()));
	}
	silent = false;
	if (ground && !waiting) discardGround();
	return sentences;
}

/// Once, however often a ground that has not begun is made anew.
void MpmEngine::say(const string& sentence)
{
	if (silent) return;
	if (said.insert(sentence).second && talik::isFirstRank()) std::cerr << sentence << std::endl;
}

/// Laws learn what the ranks of the job divide.
void MpmEngine::shareAmongRanks()
{
	worthSlabs = false;
	if (motion)
		for (const auto& law : activeSkeletons())
			worthSlabs = (law && law->shareAmongRanks(distribute)) || worthSlabs;
	if (talik::jobCommunicator() && distribute == "ground" && !notInSlabs().empty())
		throw std::invalid_argument(
		        "MpmEngine.distribute is 'ground', and this ground has " + notInSlabs()
		        + ", which slab decomposition does not support: choose automatic or none.");
}

/// What this ground has that slabs do not serve.
string MpmEngine::notInSlabs() const
{
	if (!motion) return "";
	for (const auto& law : activeSkeletons()) {
		const string reason = law ? law->notInSlabs(usedDimension()) : "";
		if (!reason.empty()) return reason;
	}
	return "";
}

/// Each rank computes a slab of this ground, if nothing in it forbids that.
bool MpmEngine::mayBeInSlabs() const
{
	constexpr int worthwhile = 100000; // points
	if (!talik::jobCommunicator()) return false;
	return distribute == "ground" || (distribute == "automatic" && notInSlabs().empty() && (worthSlabs || pointCount() >= worthwhile));
}

void MpmEngine::sayHowRanksShare()
{
	const auto& communicator = talik::jobCommunicator();
	if (!communicator) return;
	const string ranks = "Talik: " + std::to_string(communicator->count()) + " ranks ";
	if (ground->inSlabs()) say(ranks + "share out the strips of this ground (MpmEngine.distribute).");
	else say(ranks + "each compute all of this ground, which takes as long as on one; see MpmEngine.distribute.");
}

/// Ranks that look at this ground alone see it as it was before all change it.
void MpmEngine::meetBefore(const string& change) const
{
	if (talik::jobCommunicator() && ground->inSlabs()) talik::jobCommunicator()->meet(change);
}

/// Ranks whose ground drifts apart, as it does on different processors, stop. Ranks of slabs have no points in common: what they owe each other
/// is compared by what follows from all of them, the times and the impulses of bodies.
void MpmEngine::compareRanks()
{
	constexpr long interval = 100; // steps
	if (!talik::jobCommunicator() || ground->steps() < nextComparison) return;
	nextComparison = ground->steps() + interval;
	talik::Digest digest;
	if (ground->inSlabs()) {
		const double times[] = { ground->time(), ground->calendar().time, stableStep };
		digest.add(times, sizeof times);
		if (bodies) digest.add(bodies->pending.data(), bodies->pending.size() * sizeof(Real));
	} else {
		for (const auto& array : ground->state())
			digest.add(array.data, array.bytes);
	}
	talik::jobCommunicator()->meet("step " + std::to_string(ground->steps()) + " of the ground", digest.value());
}

void MpmEngine::sayGraveDoubts()
{
	if (silent) return;
	for (const auto& sentence : foundHardlyMeant("grave"))
		say("Talik warns: " + sentence);
}

talik::AnyGround& MpmEngine::runningGround()
{
	initialise();
	return *ground;
}

void MpmEngine::warnOfCalendar()
{
	const talik::PythonLock held;
	const double            step      = ground->stableTimeStep().step;
	const py::object        sentences = talik::callPython("talik.plausibility", "ofCalendar", py::ptr(this), step, ground->calendar().reach);
	for (py::stl_input_iterator<string> sentence(sentences), end; sentence != end; ++sentence)
		say("Talik warns: " + *sentence);
}

namespace {
	const string lenses = "lenses"; // of what is said, for all of them
} // namespace

// ---- the step --------------------------------------------------------------------------------------------------------------

void MpmEngine::followAttributes()
{
	groundOfScene->checkBox(*this); // a component of a corner may have been set; changes of attributes are refused in guards/attributes.py
	checkChangeable();
	auto& s = ground->commonSettings();
	if (auto* const moving = ground->motionSettings()) {
		moving->localDamping = damping;
		moving->picTime      = picTime;
	}
	groundOfScene->followGravity(*this);
	TALIK_TAKE_ATTRIBUTES(s, *this, (courantNumber)(heatFraction))
	if (tolerance != toleranceInForce) followTolerance();
	if (heat) followHeat();
	if (motion)
		for (const auto& law : activeSkeletons())
			law->followAttributes();
}

/// Scales of the calendar may change between two steps.
void MpmEngine::followHeat()
{
	const auto& inForce = *ground->commonSettings().heat;
	if (inForce.thermalTimeScale == heat->thermalTimeScale && inForce.movingTimeScale == heat->movingTimeScale
	    && inForce.motionTolerance == heat->motionTolerance)
		return;
	talik::HeatSettings changed = heat->build();
	changed.followsMotion       = inForce.followsMotion;
	groundOfScene->followHeat(changed);
	stepsUntilLimit = 0;
}

void MpmEngine::followTolerance()
{
	if ((tolerance == 0) != (toleranceInForce == 0))
		throw std::invalid_argument(
		        "MpmEngine.tolerance was " + talik::asText(toleranceInForce) + " when the ground started and is " + talik::asText(tolerance)
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
	constexpr int limitInterval = 10;
	const auto    stable        = ground->stableTimeStep();
	stableStep                  = stable.step;
	Real steps                  = limitInterval;
	if (freezing)
		for (const auto& limit : stable.limits)
			if (limit.name == "heat")
				steps = std::min(
				        steps, 0.5 * limit.step / stableStep * (heat->followsMotion ? heat->movingTimeScale / heat->thermalTimeScale : 1));
	return std::max(1, int(steps));
}

int MpmEngine::subSteps(double dt) const
{
	if (!(dt > 0) || !std::isfinite(dt)) throw std::invalid_argument("O.dt is " + talik::asText(dt) + ": give a positive time step in s.");
	const double steps = std::ceil(dt / stableStep * (1 - 1e-12));
	if (!(steps < 1e6))
		throw std::runtime_error(
		        "MpmEngine: O.dt = " + talik::asText(dt) + " s exceeds the stable time step " + talik::asText(stableStep)
		        + " s a million times: lower O.dt or set automaticTimeStep=True.");
	return std::max(1, int(steps));
}

std::atomic<bool> MpmEngine::runWaitedFor { false };

namespace {
	/// The error comes up where the run is waited for: YADE's log does not say it as well.
	void muteLog()
	{
		const talik::PythonLock held;
		try {
			py::import("talik.guards.runs").attr("muteLog")();
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
	if (stepping) throw std::runtime_error("MpmEngine: a function that a step of this ground calls cannot step it again: use the engines of O.");
	failure.clear();
	stepping = true;
	try {
		stepGround();
		stepping = false;
	} catch (const std::exception& problem) {
		stepping = false;
		failure  = problem.what();
		++failures;
		if (!scene->isPeriodic && !scene->subStepping) scene->subStep = -1;
		if (runWaitedFor) muteLog();
		throw;
	}
}

void MpmEngine::checkEngines() const
{
	const auto isThis = [this](const auto& engine) { return engine.get() == this; };
	if (std::count_if(scene->engines.begin(), scene->engines.end(), isThis) > 1)
		throw std::invalid_argument("MpmEngine is in O.engines more than once: each step would move the ground as often; leave it in once.");
}

void MpmEngine::stepGround()
{
	if (!begun) checkEngines();
	initialise();
	begun = true;
	followAttributes();
	const bool newLimit = watchStableStep();
	if (watched) recordWatched();
	const double before = ground->calendar().time;
	if (bodies) advanceAmongBodies();
	else advanceAlone(newLimit);
	compareRanks();
	// once in a run; slabs would hand each other their points for it, and look more seldom
	if (segregation && !pointsDivide && newLimit && !said.count(lenses) && (!ground->inSlabs() || ground->steps() % 1000 == 0)) {
		const talik::PythonLock held;
		const string            sentence = py::extract<string>(talik::callPython("talik.plausibility", "lensThatParts", py::ptr(this)));
		if (!sentence.empty()) said.insert(lenses);
		if (!sentence.empty()) say(sentence);
	}
	if (watched) recordWatched();
	picture.takeIfAsked(*ground, pointCount());
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
	return bodies->timeStep(*scene, groundOfScene->bodies(), stableStep);
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
		for (int i = 0; i < now; ++i) {
			try {
				advance(dt);
			} catch (const talik::StopAfterStep&) { // the ground has done this step, the clock of the scene follows
				scene->time += done + (i + 1) * dt;
				++scene->iter;
				throw;
			}
		}
		done += now * dt;
		whole = now == count;
	}
}

void MpmEngine::collectBodies()
{
	SceneBodies& met = groundOfScene->bodies();
	if (bodies->hasNewBodies(*scene)) ground->pointFields(); // those of other ranks, too: bodies that lie in the ground are refused
	bodies->collect(*scene, *this, met);
	if (bodiesNamed) return;
	std::set<int> numbers; // of bodies, and of clumps that have one
	for (size_t b = 0; b < met.count(); ++b) {
		const Body& body = *(*scene->bodies)[met.id(b)];
		numbers.insert(body.id);
		if (body.clumpId >= 0) numbers.insert(body.clumpId);
	}
	for (const auto& boundary : boundaries)
		boundary->checkBodies(numbers);
	bodiesNamed = true;
}

/// In the ground's step the bodies are where their velocities take them from their places in the scene.
void MpmEngine::advanceAmongBodies()
{
	SceneBodies& met = groundOfScene->bodies();
	collectBodies();
	if (automaticTimeStep && leadsTimeStep()) scene->dt = std::min(bodies->timeStep(*scene, groundOfScene->bodies(), stableStep), timeStepOfOthers());
	if (bodies->due(*scene) > 1e-9 * scene->dt) {
		const double begin = bodies->ahead, interval = bodies->groundStep(*scene, stableStep);
		const int    count = subSteps(interval);
		for (int i = 0; i < count; ++i) {
			met.place(begin + i * (interval / count));
			advance(interval / count);
		}
		bodies->take(met, interval);
	}
	bodies->deliver(*scene);
}

/// The five steps of the ground. They are steps 1, 4, 5, 2 and 3 of Yu & Zhao, section 2.3, see pkg/mpm/README.md.
void MpmEngine::advance(double dt)
{
	ground->beginStep(dt);
	points.follow(ground->divisions());
	ground->p2g();                     // points to grid
	ground->solveNodes();              // nodal forces and heat flows, implicit drag, boundaries
	ground->g2p();                     // grid to points
	ground->updateStrainAndPressure(); // strain, pore pressure, saturations
	ground->updateEffectiveStress();   // displacement gradient and ice saturation down, effective stress back
}

} // namespace yade
