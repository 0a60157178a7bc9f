// SPDX-License-Identifier: GPL-2.0-or-later
#include <cmath>
#include <pkg/base/SavedBytes.hpp>
#include <pkg/multiscale/samples/RveSample.hpp>
#include <pkg/multiscale/samples/SampleStore.hpp>
#include <pkg/python/PythonFunction.hpp>
#include <pkg/python/ScriptValues.hpp>
#include <pkg/python/StepGate.hpp>
#include <pkg/rve/open/ScenePacking.hpp>

namespace py = boost::python;

namespace yade {
YADE_PLUGIN((RveSample)(OpenRveSample));

using talik::PackedSample;
using talik::PackedState;

namespace {
	py::tuple tupleOf(const std::vector<double>& values) { return py::tuple(talik::listOf(values)); }

	/// What IceCreep.over returned, or None. Throws std::invalid_argument naming the method.
	talik::BondCreep bondCreep(const std::string& method, const py::object& creep)
	{
		if (creep.is_none()) return {};
		const py::extract<py::tuple> pair(creep);
		if (pair.check() && py::len(pair()) == 2) {
			const py::extract<double> fluidity(pair()[0]), exponent(pair()[1]);
			if (fluidity.check() && exponent.check() && talik::BondCreep { fluidity(), exponent() }.isPossible()) return { fluidity(), exponent() };
		}
		throw std::invalid_argument(
		        method + ": creep is " + py::extract<std::string>(py::str(creep))() + ": give what IceCreep.over(temperature,time) returns.");
	}
} // namespace

std::shared_ptr<const void> RveSample::stateNow() const
{
	return std::visit([](const auto& pointer) { return std::shared_ptr<const void>(pointer); }, state);
}

int RveSample::dimension() const
{
	if (!stateNow()) throw std::runtime_error("RveSample is empty: make it by talik.rve.pack(sample) or RveSample.fromScene(scene).");
	return state.index() == 0 ? 2 : 3;
}

template <int Dim> const PackedState<Dim>& RveSample::packed() const
{
	if (dimension() != Dim)
		throw std::invalid_argument(
		        Dim == 2 ? "The sample has spheres and the ground is in the plane: give samples of discs, or run it open, "
		                   "RveSkeleton(scenes=[sample.open()])."
		                 : "The sample has discs and the ground is in space: give samples of spheres, see talik.rve.prepare(dimension=3).");
	return *std::get<StatePointer<Dim>>(state);
}

template <int Dim> void RveSample::setPacked(PackedState<Dim> s) { state = std::make_shared<const PackedState<Dim>>(std::move(s)); }

template const PackedState<2>& RveSample::packed<2>() const;
template const PackedState<3>& RveSample::packed<3>() const;
template void                  RveSample::setPacked<2>(PackedState<2>);
template void                  RveSample::setPacked<3>(PackedState<3>);

namespace {
	/// The dimension of a state.
	template <class State> constexpr int dimensionOf = int(State::Vector::RowsAtCompileTime);
	template <class State> using SampleOf            = PackedSample<dimensionOf<std::decay_t<State>>>;
} // namespace

Real RveSample::iceSaturation() const
{
	return withState([](const auto& s) { return s.iceSaturation; });
}
Real RveSample::timeStep() const
{
	return withState([](const auto& s) { return s.dt; });
}
Real RveSample::thawStrain() const
{
	return withState([](const auto& s) { return s.thawStrain.thawStrain; });
}
Real RveSample::thawedStrength() const
{
	return withState([](const auto& s) { return s.ice.thawedStrength; });
}
Real   RveSample::thickness() const { return packed<2>().thickness; }
string RveSample::path() const
{
	return withState([](const auto& s) { return string(SampleOf<decltype(s)>(s).path()); });
}

void RveSample::action()
{
	const talik::StepGate gate;
	advance(scene->cell->velGrad, 1);
}

shared_ptr<RveSample> RveSample::fromScene(const shared_ptr<Scene>& scene)
{
	if (!scene) throw std::invalid_argument("RveSample.fromScene: the scene is None.");
	shared_ptr<RveSample> sample(new RveSample);
	if (talik::packedDimension(*scene) == 2) sample->setPacked(talik::packScene<2>(*scene));
	else sample->setPacked(talik::packScene<3>(*scene));
	const Real overlap = sample->withState([](const auto& s) { return SampleOf<decltype(s)>(s).statistics().maxOverlapRatio; });
	if (!(overlap < 1))
		throw std::invalid_argument(
		        "RveSample.fromScene: grains of the scene overlap by " + talik::asText(overlap)
		        + " of a radius, which no sample survives: move them apart, or let them come to rest first.");
	const auto frame = talik::copyScene(scene);
	frame->interactions->clear(); // the state has them
	frame->speed       = 0;       // steps per second of wall time: equal samples are to have equal bytes
	sample->sceneBytes = talik::sceneToBytes(frame);
	return sample;
}

shared_ptr<Scene> RveSample::open() const
{
	if (sceneBytes.empty()) throw std::runtime_error("RveSample.open: this sample was not packed from a scene.");
	const auto scene = talik::sceneForView(sceneBytes);
	withState([&](const auto& s) { talik::openInto(*scene, s); });
	return scene;
}

void RveSample::repack(const shared_ptr<Scene>& scene)
{
	if (!scene) throw std::invalid_argument("RveSample.repack: the scene is None: give the Scene that open() returned.");
	withState([&](const auto& s) { setPacked(talik::packScene<dimensionOf<std::decay_t<decltype(s)>>>(*scene, &s)); });
}

namespace {
	void requireSaturation(const char* method, Real iceSaturation)
	{
		if (iceSaturation >= 0 && iceSaturation <= 1) return;
		throw std::invalid_argument(string(method) + ": iceSaturation is " + talik::asText(iceSaturation) + ": give a saturation from 0 to 1.");
	}

	/// How an increment is applied to a sample of either form.
	template <class Sample> talik::PackedUpdateOptions optionsOf(const Sample& sample, const talik::BondCreep& creep)
	{
		talik::PackedUpdateOptions options;
		TALIK_TAKE_ATTRIBUTES(options, sample, (maxInertialNumber)(maxStrainPerStep)(minSteps)(timeStepFollowsIce))
		options.strength     = { sample.tensileStrengthFactor, sample.shearStrengthFactor };
		options.iceStiffness = sample.iceStiffnessFactor;
		options.creep        = creep;
		return options;
	}
} // namespace

py::dict RveSample::apply(const Matrix3r& displacementGradient, Real iceSaturation, const py::object& creep)
{
	requireSaturation("RveSample.apply", iceSaturation);
	const talik::BondCreep given = bondCreep("RveSample.apply", creep);
	return dimension() == 2 ? applied<2>(displacementGradient, iceSaturation, given) : applied<3>(displacementGradient, iceSaturation, given);
}

template <int Dim> py::dict RveSample::applied(const Matrix3r& displacementGradient, Real iceSaturation, const talik::BondCreep& creep)
{
	PackedSample<Dim> sample(packed<Dim>());
	const auto        result = sample.apply(talik::partOf<Dim>(displacementGradient), iceSaturation, optionsOf(*this, creep));
	if (!result.blewUp) setPacked(sample.state());
	py::dict d;
	d["stress"] = tupleOf(talik::components<Dim>(result.stress));
	TALIK_PUT_MEMBERS(d, result, (steps)(flipped)(slipped)(blewUp)(reason))
	return d;
}

void RveSample::advance(const Matrix3r& velGrad, long steps)
{
	withState([&](const auto& s) {
		SampleOf<decltype(s)> sample(s);
		sample.advance(talik::partOf<dimensionOf<std::decay_t<decltype(s)>>>(velGrad), steps);
		setPacked(sample.state());
	});
}

void RveSample::freeze(Real iceSaturation)
{
	requireSaturation("RveSample.freeze", iceSaturation);
	apply(Matrix3r::Zero(), iceSaturation);
}

bool RveSample::servo(Real stressX, Real stressY, const py::object& stressZ)
{
	const bool discs = dimension() == 2;
	if (discs != stressZ.is_none())
		throw std::invalid_argument(
		        discs ? "RveSample.servo: stressZ is given and the sample has discs: leave it out."
		              : "RveSample.servo: stressZ is missing: the sample has spheres.");
	const Real stresses[3] = { stressX, stressY, discs ? 0 : py::extract<Real>(stressZ)() };
	const char axes[4]     = "XYZ";
	for (int d = 0; d < dimension(); ++d)
		if (!std::isfinite(stresses[d]) || !(stresses[d] < 0))
			throw std::invalid_argument(
			        string("RveSample.servo: stress") + axes[d] + " is " + talik::asText(stresses[d])
			        + " Pa: give a compression, that is a negative number.");
	return withState([&](const auto& s) {
		constexpr int                  dim = dimensionOf<std::decay_t<decltype(s)>>;
		talik::PackedServoOptions<dim> options;
		for (int d = 0; d < dim; ++d)
			options.stress(d, d) = stresses[d];
		PackedSample<dim> sample(s);
		const bool        reached = sample.servo(options);
		setPacked(sample.state());
		return reached;
	});
}

py::tuple RveSample::stress() const
{
	return withState([](const auto& s) { return tupleOf(talik::components<dimensionOf<std::decay_t<decltype(s)>>>(s.stress)); });
}

py::dict RveSample::statistics() const
{
	return withState([](const auto& s) {
		const auto stats = SampleOf<decltype(s)>(s).statistics();
		py::dict   d;
		TALIK_PUT_MEMBERS(d, stats, (contacts)(bondsIntact))
		d["bondsBroken"] = s.bondsBrokenInTension + s.bondsBrokenInShear; // as MpmEngine.field has it
		TALIK_PUT_MEMBERS(d, s, (bondsFormed)(bondsBrokenInTension)(bondsBrokenInShear)(bondsMelted))
		d["brokenBondsInContact"] = stats.bondsBroken;
		TALIK_PUT_MEMBERS(d, stats, (coordinationNumber)(porosity))
		d["fabric"] = tupleOf(talik::components<dimensionOf<std::decay_t<decltype(s)>>>(stats.fabric));
		TALIK_PUT_MEMBERS(d, stats, (unbalancedForce)(kineticEnergy)(cellThickness))
		TALIK_PUT_MEMBERS(d, s, (cellSlips)(cellSlipStrain)(cellSlipStress))
		d["steps"] = s.step;
		return d;
	});
}

namespace {
	double shearComponent(double shear, int) { return shear; }
	double shearComponent(const Vector3r& shear, int c) { return shear[c]; }
} // namespace

py::dict RveSample::arrays() const
{
	return withState([](const auto& s) {
		constexpr int dim = dimensionOf<std::decay_t<decltype(s)>>;
		const auto&   k   = s.contacts;
		py::dict      d;
		d["position"] = talik::tableOf(s.size(), dim, [&](std::size_t i, int c) { return s.position[i][c]; });
		d["radius"]   = talik::tableOf(s.size(), 1, [&](std::size_t i, int) { return s.grains->radius[i] * s.radiusFactor; });
		d["contact"]  = talik::tableOf(k.size(), 2, [&](std::size_t i, int c) { return c ? k.second[i] : k.first[i]; });
		d["cellDist"] = talik::tableOf(k.size(), dim, [&](std::size_t i, int c) { return k.cellDist[i][c]; });
		d["shear"]    = talik::tableOf(k.size(), dim == 2 ? 1 : 3, [&](std::size_t i, int c) { return shearComponent(k.shear[i], c); });
		d["bond"]     = talik::tableOf(k.size(), 1, [&](std::size_t i, int) { return k.bond.empty() ? 0 : k.bond[i] & 3; });
		d["hSize"]    = talik::tableOf(dim, dim, [&](std::size_t i, int c) { return s.hSize(int(i), c); });
		return d;
	});
}

shared_ptr<RveSample> RveSample::copy() const
{
	shared_ptr<RveSample> other(new RveSample);
	TALIK_TAKE_ATTRIBUTES(
	        *other, *this,
	        (maxInertialNumber)(maxStrainPerStep)(minSteps)(timeStepFollowsIce)(tensileStrengthFactor)(shearStrengthFactor)(iceStiffnessFactor)(sceneBytes))
	dimension(); // none of an empty sample
	other->state = state;
	return other;
}

std::size_t RveSample::digest() const
{
	return withState([](const auto& s) { return std::hash<string>()(s.toBytes()); });
}

py::object RveSample::stateBytes() const
{
	const string bytes = withState([](const auto& s) { return s.toBytes(); });
	return py::object(py::handle<>(PyBytes_FromStringAndSize(bytes.data(), Py_ssize_t(bytes.size()))));
}

void RveSample::setTimeStep(Real dt)
{
	if (!(dt > 0) || !std::isfinite(dt)) throw std::invalid_argument("RveSample.dt is " + talik::asText(dt) + ": give a positive time step in s.");
	withState([&](auto s) {
		s.dt = dt;
		setPacked(std::move(s));
	});
}

void RveSample::setThawStrain(Real strain)
{
	withState([&](auto s) {
		const Real porosity = SampleOf<decltype(s)>(s).statistics().porosity;
		if (!(strain >= 0 && strain <= porosity))
			throw std::invalid_argument(
			        "RveSample.thawStrain is " + talik::asText(strain) + ": it must lie between 0 and the porosity of the sample, "
			        + talik::asText(porosity) + ", which is all of eq. (8).");
		if (s.iceSaturation > 0)
			throw std::invalid_argument(
			        "RveSample.thawStrain is set on a sample that holds ice (iceSaturation " + talik::asText(s.iceSaturation)
			        + "): set it before the sample freezes.");
		s.thawStrain.thawStrain = strain;
		setPacked(std::move(s));
	});
}

void RveSample::setThawedStrength(Real strength)
{
	if (!(strength >= 0) || !std::isfinite(strength))
		throw std::invalid_argument("RveSample.thawedStrength is " + talik::asText(strength) + ": give a strength in Pa, 0 or more.");
	withState([&](auto s) {
		if (!s.ice.formsBondsEver())
			throw std::invalid_argument("RveSample.thawedStrength is set on a sample whose grains carry no ice bonds: prepare it with ice=True.");
		s.ice.thawedStrength = strength;
		setPacked(std::move(s));
	});
}

Matrix3r RveSample::deformation() const
{
	return withState([](const auto& s) {
		Matrix3r m = talik::inSpace<dimensionOf<std::decay_t<decltype(s)>>>(s.trsf);
		if (s.trsf.rows() == 2) m(2, 2) = 1;
		return m;
	});
}

void RveSample::preSave(RveSample&)
{
	saved      = stateNow() ? talik::toBase64(withState([](const auto& s) { return s.toBytes(); })) : "";
	savedScene = sceneBytes.empty() ? "" : talik::toBase64(sceneBytes);
}

void RveSample::postLoad(RveSample&)
{
	if (!saved.empty()) {
		const string bytes = talik::fromBase64(saved);
		if (talik::packedDimension(bytes) == 2) setPacked(PackedState<2>::fromBytes(bytes));
		else setPacked(PackedState<3>::fromBytes(bytes));
	}
	if (!savedScene.empty()) sceneBytes = talik::fromBase64(savedScene);
	saved.clear();
	savedScene.clear();
}

talik::OpenSample& OpenRveSample::sample() const
{
	if (running) return *running;
	if (!source) throw std::invalid_argument("OpenRveSample.source is None: give a Scene, e.g. OpenRveSample(source=O._sceneObj).");
	running = std::make_shared<talik::OpenSample>(talik::sceneToBytes(source));
	return *running;
}

py::dict OpenRveSample::apply(const Matrix3r& displacementGradient, Real iceSaturation, const py::object& creep)
{
	requireSaturation("OpenRveSample", iceSaturation);
	const auto options = optionsOf(*this, bondCreep("OpenRveSample.apply", creep));
	talik::forbidRedirection();
	sample().keepState();
	const auto result = sample().apply(displacementGradient, iceSaturation, options);
	if (result.blewUp) sample().recover();
	py::dict d;
	TALIK_PUT_MEMBERS(d, result, (stress)(steps)(flipped)(blewUp)(reason))
	return d;
}

bool OpenRveSample::flip(Real skew) { return sample().flip(skew); }

shared_ptr<Scene> OpenRveSample::open() const { return talik::sceneForView(talik::sceneToBytes(sample().yadeScene())); }

void OpenRveSample::freeze(Real iceSaturation) { apply(Matrix3r::Zero(), iceSaturation); }

py::dict OpenRveSample::statistics() const
{
	const auto s = sample().statistics();
	py::dict   d;
	TALIK_PUT_MEMBERS(
	        d, s, (contacts)(bondsIntact)(bondsFormed)(bondsBroken)(bondsMelted)(coordinationNumber)(porosity)(fabric)(unbalancedForce)(kineticEnergy))
	return d;
}

} // namespace yade
