// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/RveSkeleton.hpp>

#include <boost/python/numpy.hpp>

namespace py = boost::python;
namespace np = boost::python::numpy;

namespace yade {
YADE_PLUGIN((RveSkeleton));

talik::SampleScheduling RveSkeleton::scheduling() const
{
	talik::SampleScheduling s;
	s.strainTolerance          = strainTolerance;
	s.saturationTolerance      = saturationTolerance;
	s.prediction               = prediction;
	s.stressTolerance          = stressTolerance;
	s.stopOnBlowUp             = onBlowUp == "stop";
	s.update.maxInertialNumber = maxInertialNumber;
	s.update.maxStrainPerStep  = maxStrainPerStep;
	s.update.minSteps          = minSteps;
	s.update.maxRelaxSteps     = maxRelaxSteps;
	return s;
}

SkeletonLaw::Pointer RveSkeleton::build(int pointCount)
{
	if (onBlowUp != "stop" && onBlowUp != "isolate") throw std::invalid_argument("RveSkeleton.onBlowUp is '" + onBlowUp + "': choose stop or isolate.");
	if (!(strainTolerance >= 0)) throw std::invalid_argument("RveSkeleton.strainTolerance is " + boost::lexical_cast<string>(strainTolerance) + ": give 0 or more.");
	if (!(saturationTolerance >= 0)) throw std::invalid_argument("RveSkeleton.saturationTolerance is " + boost::lexical_cast<string>(saturationTolerance) + ": give 0 or more.");
	std::vector<talik::SampleSkeleton::StatePointer> prototypes;
	for (const auto& sample : samples) {
		if (!sample) throw std::invalid_argument("RveSkeleton.samples holds None: give RveSamples only.");
		prototypes.push_back(std::make_shared<talik::PackedState<2>>(sample->packed()));
	}
	if (!sampleOf.empty() && int(sampleOf.size()) != pointCount)
		throw std::invalid_argument(
		        "RveSkeleton.sampleOf has " + std::to_string(sampleOf.size()) + " numbers for " + std::to_string(pointCount) + " points: give one per point, or none.");
	std::vector<int> which = sampleOf.empty() ? std::vector<int>(pointCount, 0) : sampleOf;
	model                  = std::make_shared<talik::SampleSkeleton>(prototypes, which, scheduling());
	return model;
}

talik::SampleSkeleton& RveSkeleton::running() const
{
	if (!model) throw std::runtime_error("RveSkeleton: the ground has not started; call mpm.initialise() or run a step first.");
	return *model;
}

string RveSkeleton::savedState() const { return model ? model->save() : ""; }
void   RveSkeleton::restoreState(const string& bytes) { running().restore(bytes); }

shared_ptr<RveSample> RveSkeleton::sample(int id) const
{
	auto copy = samples[running().prototype(id)]->copy();
	copy->setPacked(*running().state(id));
	return copy;
}

void RveSkeleton::replaceSample(int id, const shared_ptr<RveSample>& sample)
{
	if (!sample) throw std::invalid_argument("RveSkeleton.replaceSample: the sample is None.");
	running().setState(id, std::make_shared<talik::PackedState<2>>(sample->packed()));
}

namespace {
	using State2 = talik::PackedState<2>;

	double intactBonds(const State2& s)
	{
		double n = 0;
		for (const auto b : s.contacts.bond)
			n += talik::BondState(b & 3) == talik::BondState::BONDED;
		return n;
	}

	/// One measure of one sample; several components for tensors.
	using Measure = std::function<void(const State2&, double*)>;
	std::pair<int, Measure> measureNamed(const string& name)
	{
		const auto statistics = [](const State2& s) { return talik::PackedSample<2>(s).statistics(); };
		if (name == "bondsIntact") return { 1, [](const State2& s, double* v) { *v = intactBonds(s); } };
		if (name == "bondsFormed") return { 1, [](const State2& s, double* v) { *v = double(s.bondsFormed); } };
		if (name == "bondsBroken") return { 1, [](const State2& s, double* v) { *v = double(s.bondsBrokenInTension + s.bondsBrokenInShear); } };
		if (name == "bondsMelted") return { 1, [](const State2& s, double* v) { *v = double(s.bondsMelted); } };
		if (name == "contacts") return { 1, [](const State2& s, double* v) { *v = double(s.contacts.size()); } };
		if (name == "coordinationNumber") return { 1, [=](const State2& s, double* v) { *v = statistics(s).coordinationNumber; } };
		if (name == "porosity") return { 1, [=](const State2& s, double* v) { *v = statistics(s).porosity; } };
		if (name == "fabric")
			return { 3, [=](const State2& s, double* v) {
					const auto f = statistics(s).fabric;
					v[0] = f(0, 0), v[1] = f(1, 1), v[2] = f(0, 1);
				} };
		throw std::invalid_argument(
		        "RveSkeleton.values: there is no measure '" + name + "'; choose bondsIntact, bondsFormed, bondsBroken, bondsMelted, contacts, coordinationNumber, porosity or fabric.");
	}
}

py::object RveSkeleton::values(const string& name) const
{
	const auto  measure = measureNamed(name);
	const auto& s       = running();
	int         points  = 0;
	while (points < int(s.samples().size()) || s.has(points))
		points++;
	np::ndarray result = np::zeros(measure.first == 1 ? py::make_tuple(points) : py::make_tuple(points, measure.first), np::dtype::get_builtin<double>());
	Real*       data   = reinterpret_cast<Real*>(result.get_data());
	std::map<const State2*, std::vector<double>> known;
	for (int id = 0; id < points; id++) {
		std::vector<double> value(measure.first, NaN);
		if (s.has(id)) {
			const auto state = s.state(id);
			auto       found = known.find(state.get());
			if (found == known.end()) {
				measure.second(*state, value.data());
				known[state.get()] = value;
			} else value = found->second;
		}
		std::copy(value.begin(), value.end(), data + id * measure.first);
	}
	return result;
}

py::dict RveSkeleton::counters() const
{
	const auto& s = running();
	py::dict    d;
	d["points"]         = s.counters().points;
	d["calls"]          = s.counters().calls;
	d["steps"]          = s.counters().steps;
	d["seconds"]        = s.counters().seconds;
	d["distinctStates"] = s.samples().distinctStates();
	d["bytes"]          = s.samples().bytes();
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
