// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/SavedBytes.hpp>
#include <pkg/icebond/IceLaws.hpp>
#include <pkg/multiscale/samples/RveSkeleton.hpp>
#include <pkg/python/PythonFunction.hpp>
#include <pkg/python/StepGate.hpp>
#include <pkg/rve/device/SampleDevice.hpp>

#include <boost/python/numpy.hpp>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <map>

namespace py = boost::python;
namespace np = boost::python::numpy;

namespace yade {
YADE_PLUGIN((RveSkeleton));

talik::SampleScheduling RveSkeleton::scheduling() const
{
	talik::SampleScheduling s;
	TALIK_TAKE_ATTRIBUTES(s, *this, (strainTolerance)(saturationTolerance)(prediction)(stressTolerance)(threads))
	TALIK_TAKE_ATTRIBUTES(s.update, *this, (maxInertialNumber)(maxStrainPerStep)(minSteps)(timeStepFollowsIce))
	s.stopOnBlowUp = onBlowUp == "stop";
	if (iceStrength) s.iceStrength = iceStrength->law();
	if (iceCreep) s.iceCreep = iceCreep->law();
	if (!std::isnan(slipFriction)) s.slipStrength = talik::ShearStrength { slipFriction, slipCohesion };
	return s;
}

namespace {
	void refuse(const py::object& sentence)
	{
		const string words = py::extract<string>(sentence);
		if (!words.empty()) throw std::invalid_argument(words);
	}
} // namespace

void RveSkeleton::followAttributes()
{
	if (running().scheduling().threads == threads && deviceInUse == device) return;
	{
		const talik::PythonLock held;
		refuse(talik::callPython("talik._refusals", "ofScheduling", py::ptr(this)));
	}
	running().scheduling().threads = threads;
	if (deviceInUse != device) std::visit([this](auto& stores) { useDevice(stores); }, now);
}

/// Takes the device that the script names, and gives the former one up.
template <int Dim> void RveSkeleton::useDevice(Stores<Dim>& stores)
{
	const auto say = [](const string& sentence) {
		if (talik::isFirstRank()) std::cerr << "RveSkeleton: " << sentence << std::endl;
	};
	deviceInUse = device;
	if (stores.packed) stores.packed->useDevice(talik::deviceNamed(device, say), say);
	else if (device != "cpu") say("Samples that run open stay on the processor.");
}

bool RveSkeleton::bondsCarryMoments() const
{
	const auto ofSample = [](const auto& sample) {
		return sample->dimension() == 2 ? sample->template packed<2>().bondsCarryMoments() : sample->template packed<3>().bondsCarryMoments();
	};
	return std::any_of(samples.begin(), samples.end(), ofSample)
	        || std::any_of(scenes.begin(), scenes.end(), [](const auto& scene) { return talik::bondsCarryMoments(*scene); });
}

void RveSkeleton::checkSettings(int pointCount)
{
	const talik::PythonLock held;
	refuse(talik::callPython("talik._refusals", "ofSamples", py::ptr(this), pointCount));
	if (iceCreep && bondsCarryMoments()) throw std::invalid_argument("RveSkeleton.iceCreep: " + string(talik::momentsDoNotCreep));
}

namespace {
	/// Mixes the bits of a number so that neighbours have nothing in common (splitmix64).
	std::uint64_t mixed(std::uint64_t z)
	{
		z += 0x9e3779b97f4a7c15;
		z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
		z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
		return z ^ (z >> 31);
	}

	std::size_t digestOf(const shared_ptr<Scene>& scene) { return std::hash<std::string>()(talik::sceneToBytes(scene)); }

	constexpr double placeUnit = 1e-6; ///< places that differ by less are the same [m]: round-off must not decide

	int dealtAt(const double* place, int dimension, int samples, int seed)
	{
		std::uint64_t chance = mixed(std::uint64_t(seed));
		for (int d = 0; d < dimension; ++d)
			chance = mixed(chance ^ std::uint64_t(std::llround(place[d] / placeUnit)));
		return int(chance % std::uint64_t(samples));
	}
} // namespace

py::list RveSkeleton::deal(const py::object& position, int samples, int seed)
{
	if (samples < 1) throw std::invalid_argument("RveSkeleton.deal: samples is " + std::to_string(samples) + ": give 1 or more.");
	if (seed < 0) throw std::invalid_argument("RveSkeleton.deal: seed is " + std::to_string(seed) + ": give a whole number, 0 or more.");
	const np::ndarray array = np::from_object(position, np::dtype::get_builtin<double>(), np::ndarray::CARRAY_RO);
	if (array.get_nd() != 2 || (array.shape(1) != 2 && array.shape(1) != 3))
		throw std::invalid_argument("RveSkeleton.deal: position is not an array (n,2) or (n,3).");
	const Real* data = reinterpret_cast<const Real*>(array.get_data());
	py::list    numbers;
	for (int p = 0; p < array.shape(0); ++p)
		numbers.append(dealtAt(data + array.shape(1) * p, int(array.shape(1)), samples, seed));
	return numbers;
}

template <int Dim> vector<int> RveSkeleton::assigned(const Places<Dim>& places) const
{
	const int   count = std::max(1, int(samples.size() + scenes.size()));
	vector<int> numbers;
	for (const auto& place : places)
		numbers.push_back(dealtAt(place.data(), Dim, count, seed));
	return numbers;
}

/// Samples may have been strained or frozen since.
bool RveSkeleton::sourcesChanged() const
{
	if (!model) return false;
	if (takenStates.size() != samples.size() || takenScenes.size() != scenes.size()) return true;
	for (std::size_t k = 0; k < scenes.size(); ++k)
		if (!scenes[k] || digestOf(scenes[k]) != takenScenes[k]) return true;
	for (std::size_t k = 0; k < samples.size(); ++k)
		if (!samples[k] || samples[k]->stateNow() != takenStates[k]) return true;
	return false;
}

string RveSkeleton::reasonAgainstPacking(int dimension) const
{
	for (std::size_t k = 0; k < scenes.size(); ++k) {
		string reason = talik::reasonAgainstPacking(*scenes[k]);
		if (reason.empty() && talik::packedDimension(*scenes[k]) != dimension)
			reason = dimension == 2 ? "its grains are free to move out of the plane of the ground"
			                        : "its grains are discs and the ground is in space";
		if (!reason.empty()) return "scenes[" + std::to_string(k) + "] cannot be packed: " + reason;
	}
	return "";
}

/// Their archives are exact to some 1e-12 only: one that followed its point to another rank would go on with other bits.
string RveSkeleton::notInSlabs(int dimension) const { return form == "packed" && reasonAgainstPacking(dimension).empty() ? "" : "samples that run open"; }

template <int Dim> void RveSkeleton::makeStore(Stores<Dim>& stores)
{
	const string reason = form == "packed" ? reasonAgainstPacking(Dim) : "";
	if (form == "packed" && reason.empty()) {
		prototypes = samples;
		for (const auto& scene : scenes)
			prototypes.push_back(RveSample::fromScene(scene));
		std::vector<typename talik::PackedStore<Dim>::StatePointer> states;
		for (const auto& sample : prototypes)
			states.push_back(std::make_shared<talik::PackedState<Dim>>(sample->template packed<Dim>()));
		const auto ranks = sharedOut ? talik::jobCommunicator() : nullptr;
		stores.packed    = ranks ? std::make_shared<talik::SlabStore<Dim>>(states, ranks) : std::make_shared<talik::PackedStore<Dim>>(states);
		return;
	}
	if (!reason.empty() && !told && talik::isFirstRank())
		std::cerr << "RveSkeleton: the samples run open, with YADE's own engines, and a call takes 20 to 30 times as long as with packed "
		             "discs, more with Hertz-Mindlin contacts (examples/own_sample.py measures it): "
		          << reason << "." << std::endl;
	const auto ofSpheres = [](const auto& scene) { return talik::packedDimension(*scene) == 3; };
	if (Dim == 2 && reason.empty() && !told && talik::isFirstRank() && std::any_of(scenes.begin(), scenes.end(), ofSpheres))
		std::cerr << "RveSkeleton: samples of spheres behind points in the plane run open only, strained in that plane; their stress out of it is not "
		             "used."
		          << std::endl;
	told = true;
	std::vector<string> bytes;
	for (const auto& sample : samples)
		bytes.push_back(talik::sceneToBytes(sample->open()));
	for (const auto& scene : scenes)
		bytes.push_back(talik::sceneToBytes(scene));
	stores.open = std::make_shared<talik::OpenStore<Dim>>(bytes);
}

/// Friction of samples for which the script gives none, measured on them as they are now when the thaw front first asks. It stays while the samples
/// are the same, in a scene that was saved, too.
template <int Dim> void RveSkeleton::prepareSlip(Stores<Dim>& stores)
{
	if (!std::isnan(slipFriction)) measuredFriction = measuredFrictionError = NaN;
	if (!std::isnan(slipFriction) || samples.size() + scenes.size() == 0) return;
	vector<shared_ptr<RveSample>> packed;
	vector<string>                open;
	for (const auto& sample : stores.packed ? prototypes : samples)
		packed.push_back(sample->copy());
	if (stores.open)
		for (const auto& scene : scenes)
			open.push_back(talik::sceneToBytes(scene));
	stores.model->measureSlip = [this, packed, open] {
		if (std::isnan(measuredFriction)) measureFriction(packed, open, Dim);
		return talik::ShearStrength { measuredFriction, slipCohesion };
	};
}

void RveSkeleton::measureFriction(const vector<shared_ptr<RveSample>>& packed, const vector<string>& open, int dimension)
{
	const talik::PythonLock held;
	py::list                ofScenes;
	for (const auto& bytes : open)
		ofScenes.append(talik::sceneFromBytes(bytes));
	const py::object found   = talik::callPython("talik.studies._friction", "steady", packed, ofScenes, dimension, threads);
	const int        sheared = py::extract<int>(found[2]);
	const string     problem = py::extract<string>(found[3]);
	if (!problem.empty())
		throw std::runtime_error(
		        "RveSkeleton.slipFriction is nan, and the friction of the samples could not be measured: " + problem
		        + "; give slipFriction, e.g. 0.3.");
	measuredFriction      = py::extract<Real>(found[0]);
	measuredFrictionError = py::extract<Real>(found[1]);
	if (talik::isFirstRank())
		std::cerr << "RveSkeleton: the samples slip at the thaw front with a friction of " << std::setprecision(3) << measuredFriction << " +- "
		          << std::setprecision(2) << measuredFrictionError << ", measured in simple shear (" << sheared
		          << (sheared == 1 ? " sample" : " samples") << "); slipFriction sets another." << std::setprecision(6) << std::endl;
}

SkeletonLaw::Model<3> RveSkeleton::build(const Places<3>& places)
{
	checkSettings(int(places.size()));
	return makeModel<3>(sampleOf.empty() ? assigned<3>(places) : sampleOf);
}

SkeletonLaw::Model<2> RveSkeleton::build(const Places<2>& places)
{
	checkSettings(int(places.size()));
	return makeModel<2>(sampleOf.empty() ? assigned<2>(places) : sampleOf);
}

template <int Dim> std::shared_ptr<talik::SampleSkeleton<Dim>> RveSkeleton::makeModel(const vector<int>& numbers)
{
	Stores<Dim> made;
	makeStore(made);
	byHand = false;
	if (sourcesChanged()) measuredFriction = measuredFrictionError = NaN;
	takenStates.clear();
	for (const auto& sample : samples)
		takenStates.push_back(sample->stateNow());
	takenScenes.clear();
	for (const auto& scene : scenes)
		takenScenes.push_back(digestOf(scene));
	std::shared_ptr<talik::SampleStoreOf<Dim>> store = made.packed;
	if (made.open) store = made.open;
	made.model  = std::make_shared<talik::SampleSkeleton<Dim>>(store, numbers, scheduling());
	deviceInUse = "cpu";
	if (device != "cpu") useDevice(made);
	prepareSlip(made);
	made.model->onBlowUp = [this](int id) {
		keepBlownUp(id);
		return onBlowUp == "stop";
	};
	model = made.model;
	now   = made;
	return made.model;
}

template std::shared_ptr<talik::SampleSkeleton<2>> RveSkeleton::makeModel<2>(const vector<int>&);
template std::shared_ptr<talik::SampleSkeleton<3>> RveSkeleton::makeModel<3>(const vector<int>&);

void RveSkeleton::keepBlownUp(int id) const
{
	if (blowUpFolder.empty() || !talik::isFirstRank()) return;
	const auto file = std::filesystem::path(blowUpFolder) / ("point" + std::to_string(id) + ".yade");
	try {
		const string      bytes = talik::sceneToBytes(scene(id));
		talik::AtomicFile beside("sample", file.string());
		beside.sputn(bytes.data(), std::streamsize(bytes.size()));
		beside.commit();
		std::cerr << "The sample of point " << id << " blew up; its last good state is in " << file.string() << "." << std::endl;
	} catch (const std::runtime_error& problem) {
		std::cerr << "The sample of point " << id << " blew up and its last good state was not kept: " << problem.what() << "." << std::endl;
	}
}

talik::PointSamples& RveSkeleton::running() const
{
	if (!model) throw std::runtime_error("RveSkeleton: the ground has not started; call mpm.initialise() or run a step first.");
	return *model;
}

string RveSkeleton::saved(talik::CheckpointParts* beside) const
{
	if (!model) return "";
	const auto&       store  = model->samples();
	const auto        layout = std::make_shared<talik::SampleStore::Layout>(store.layout());
	talik::ByteWriter writer;
	writer.block(model->save(*layout));
	if (beside) writer.number(beside->add(layout->bytes(), [&store, layout](const talik::FilePlace& place) { return store.writeStates(*layout, place); }));
	else writer.block(store.states());
	return writer.bytes();
}

void RveSkeleton::restore(const string& bytes, const talik::CheckpointParts::Source* beside)
{
	talik::ByteReader   reader(bytes);
	const string        books  = reader.block();
	const std::uint64_t first  = beside ? beside->at + reader.number() : 0;
	const string        states = beside ? "" : reader.block();
	running().restore(books, [&](std::uint64_t at, std::uint64_t length) {
		if (!beside) return states.substr(at, length);
		string state(length, '\0');
		beside->file->read(&state[0], length, first + at);
		return state;
	});
}

shared_ptr<RveSample> RveSkeleton::sample(int id) const
{
	const std::size_t number = running().sampleNumber(id);
	running().bring(id);
	return withStores([&](const auto& stores) {
		if (stores.open) return RveSample::fromScene(stores.open->scene(number));
		auto copy = prototypes.at(running().prototype(id))->copy();
		copy->setPacked(*stores.packed->state(number));
		return copy;
	});
}

shared_ptr<Scene> RveSkeleton::scene(int id) const
{
	const std::size_t number = running().sampleNumber(id);
	running().bring(id);
	return withStores([&](const auto& stores) { return stores.open ? stores.open->scene(number) : sample(id)->open(); });
}

void RveSkeleton::replaceSample(int id, const shared_ptr<RveSample>& sample)
{
	if (!sample) throw std::invalid_argument("RveSkeleton.replaceSample: the sample is None.");
	const std::size_t number = running().sampleNumber(id);
	running().beforeReplacing(id);
	withStores([&](const auto& stores) {
		constexpr int dim = std::decay_t<decltype(stores)>::dimension;
		if (stores.open) stores.open->setScene(number, sample->open());
		else stores.packed->setState(number, std::make_shared<talik::PackedState<dim>>(sample->template packed<dim>()));
	});
	byHand = true;
	running().askNext(id);
}

namespace {
	/// Bonds lost or made by hand: one whose grains still touch counts as broken in shear, else in tension.
	template <int Dim> void countByHand(const talik::PackedState<Dim>& former, talik::PackedState<Dim>& state)
	{
		using Pair = std::tuple<int, int, typename talik::PackedTypes<Dim>::CellDist>;
		std::map<Pair, bool> before; // bonded pairs, and whether they touch now
		const auto           pair = [](const talik::PackedContacts<Dim>& k, std::size_t c) { return Pair { k.first[c], k.second[c], k.cellDist[c] }; };
		const auto           bonded = [](const talik::PackedContacts<Dim>& k, std::size_t c) {
                        return !k.bond.empty() && talik::BondState(k.bond[c] & 3) == talik::BondState::BONDED;
		};
		for (std::size_t c = 0; c < former.contacts.size(); ++c)
			if (bonded(former.contacts, c)) before[pair(former.contacts, c)] = false;
		for (std::size_t c = 0; c < state.contacts.size(); ++c) {
			const auto found = before.find(pair(state.contacts, c));
			if (!bonded(state.contacts, c)) {
				if (found != before.end()) found->second = true;
			} else if (found != before.end()) before.erase(found);
			else ++state.bondsFormed;
		}
		for (const auto& [contact, touches] : before)
			(state.iceSaturation == 0 ? state.bondsMelted : touches ? state.bondsBrokenInShear : state.bondsBrokenInTension)++;
	}
} // namespace

void RveSkeleton::replaceScene(int id, const shared_ptr<Scene>& scene)
{
	if (!scene) throw std::invalid_argument("RveSkeleton.replaceScene: the scene is None.");
	const std::size_t number = running().sampleNumber(id);
	running().bring(id);
	const bool differs = withStores([&](const auto& stores) {
		constexpr int dim = std::decay_t<decltype(stores)>::dimension;
		if (stores.open) {
			running().beforeReplacing(id);
			stores.open->setScene(number, scene);
			return true;
		}
		const auto former = stores.packed->state(number);
		auto       state  = std::make_shared<talik::PackedState<dim>>(talik::packScene<dim>(*scene, former.get()));
		if (state->toBytes() == former->toBytes()) return false;
		running().beforeReplacing(id);
		countByHand<dim>(*former, *state);
		stores.packed->setState(number, state);
		return true;
	});
	if (!differs) return;
	byHand = true;
	running().askNext(id);
}

vector<string> RveSkeleton::measures() const { return talik::sampleMeasures(); }

py::list RveSkeleton::pyMeasures() const { return talik::listOf(measures()); }

vector<Real> RveSkeleton::valueAt(const string& name, int id) const
{
	if (!hasSample(id)) return { NaN };
	return running().samples().measure(running().sampleNumber(id), name);
}

py::object RveSkeleton::values(const string& name) const
{
	const auto&                   s        = running();
	const int                     points   = s.points();
	const auto                    bySample = s.samples().measureAll(name);
	vector<const vector<double>*> rows(points, nullptr);
	const std::size_t             parts = bySample.empty() ? 1 : bySample.front().size();
	for (int id = 0; id < points; ++id)
		if (s.has(id)) rows[id] = &bySample[s.sampleNumber(id)];
	return talik::tableOf(points, parts, [&](std::size_t id, std::size_t c) { return rows[id] ? (*rows[id])[c] : NaN; });
}

py::dict RveSkeleton::cost() const
{
	const auto& s = running();
	py::dict    d;
	d["form"] = withStores([](const auto& stores) { return bool(stores.open); }) ? "open" : "packed";
	TALIK_PUT_MEMBERS(d, s.counters(), (points)(calls)(steps)(seconds))
	d["distinctStates"] = s.samples().distinctStates();
	d["bytes"]          = s.samples().bytes();
	const auto use      = withStores([](const auto& stores) { return stores.packed ? stores.packed->deviceUse() : talik::DeviceUse(); });
	if (deviceInUse != "cpu") {
		d["onDevice"]         = use.done;
		d["endedOnProcessor"] = use.ended;
		d["leftToProcessor"]  = use.left;
		d["listsOnDevice"]    = use.lists;
		py::dict seconds;
		TALIK_PUT_MEMBERS(seconds, use, (making)(sending)(waiting)(receiving)(taking))
		d["deviceSeconds"] = seconds;
	}
	if (const auto* sharing = s.samples().sharing()) {
		d["owned"]   = sharing->samples;
		d["moved"]   = sharing->moved;
		d["balance"] = sharing->balance;
	}
	return d;
}

py::dict RveSkeleton::blownUp() const
{
	py::dict d;
	for (const auto& [id, reason] : running().blownUp())
		d[id] = reason;
	return d;
}

} // namespace yade
