// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/ByteArchive.hpp>
#include <pkg/multiscale/RveSample.hpp>
#include <pkg/rve/open/StepGate.hpp>

#include <boost/python/numpy.hpp>
#include <cmath>

namespace py = boost::python;
namespace np = boost::python::numpy;

namespace yade {
YADE_PLUGIN((RveSample));

using InPlane = talik::PackedTypes<2>::Matrix;
using talik::PackedSample;
using talik::PackedState;

const PackedState<2>& RveSample::packed() const
{
	if (!state) throw std::runtime_error("RveSample is empty: make it by talik.rve.pack(sample) or RveSample.fromScene(scene).");
	return *state;
}

void RveSample::setPacked(PackedState<2> s) { state = std::make_shared<PackedState<2>>(std::move(s)); }

void RveSample::action()
{
	const talik::StepGate gate;
	PackedSample<2>       sample(packed());
	sample.advance(InPlane(scene->cell->velGrad.topLeftCorner<2, 2>()), 1);
	setPacked(sample.state());
}

shared_ptr<RveSample> RveSample::fromScene(const shared_ptr<Scene>& scene)
{
	if (!scene) throw std::invalid_argument("RveSample.fromScene: the scene is None.");
	shared_ptr<RveSample> sample(new RveSample);
	sample->setPacked(talik::packScene(*scene));
	const Real overlap = PackedSample<2>(sample->packed()).statistics().maxOverlapRatio;
	if (!(overlap < 1))
		throw std::invalid_argument(
		        "RveSample.fromScene: grains of the scene overlap by " + boost::lexical_cast<string>(overlap)
		        + " of a radius, which no sample survives: move them apart, or let them come to rest first.");
	const auto frame = talik::copyScene(scene);
	frame->interactions->clear(); // the state has them
	sample->sceneBytes = talik::sceneToBytes(frame);
	return sample;
}

shared_ptr<Scene> RveSample::open() const
{
	if (sceneBytes.empty()) throw std::runtime_error("RveSample.open: this sample was not packed from a scene.");
	const auto scene = talik::sceneForView(sceneBytes);
	talik::openInto(*scene, packed());
	return scene;
}

void RveSample::repack(const shared_ptr<Scene>& scene)
{
	if (!scene) throw std::invalid_argument("RveSample.repack: the scene is None: give the Scene that open() returned.");
	setPacked(talik::packScene(*scene, state.get()));
}

namespace {
	void requireSaturation(const char* method, Real iceSaturation)
	{
		if (iceSaturation >= 0 && iceSaturation <= 1) return;
		throw std::invalid_argument(
		        string(method) + ": iceSaturation is " + boost::lexical_cast<string>(iceSaturation) + ": give a saturation from 0 to 1.");
	}
} // namespace

py::dict RveSample::apply(const Matrix3r& displacementGradient, Real iceSaturation)
{
	requireSaturation("RveSample.apply", iceSaturation);
	talik::PackedUpdateOptions options;
	options.maxInertialNumber = maxInertialNumber;
	options.maxStrainPerStep  = maxStrainPerStep;
	options.minSteps          = minSteps;
	PackedSample<2> sample(packed());
	const auto      result = sample.apply(displacementGradient.topLeftCorner<2, 2>(), iceSaturation, options);
	if (!result.blewUp) setPacked(sample.state());
	py::dict d;
	d["stress"]  = py::make_tuple(result.stress(0, 0), result.stress(1, 1), result.stress(0, 1));
	d["steps"]   = result.steps;
	d["flipped"] = result.flipped;
	d["blewUp"]  = result.blewUp;
	d["reason"]  = result.reason;
	return d;
}

void RveSample::advance(const Matrix3r& velGrad, long steps)
{
	PackedSample<2> sample(packed());
	sample.advance(InPlane(velGrad.topLeftCorner<2, 2>()), steps);
	setPacked(sample.state());
}

void RveSample::freeze(Real iceSaturation)
{
	requireSaturation("RveSample.freeze", iceSaturation);
	apply(Matrix3r::Zero(), iceSaturation);
}

bool RveSample::servo(Real stressX, Real stressY)
{
	for (const auto& [name, stress] : { std::make_pair("stressX", stressX), std::make_pair("stressY", stressY) })
		if (!std::isfinite(stress) || !(stress < 0))
			throw std::invalid_argument(
			        string("RveSample.servo: ") + name + " is " + boost::lexical_cast<string>(stress)
			        + " Pa: give a compression, that is a negative number.");
	talik::PackedServoOptions<2> options;
	options.principalStress = talik::PackedTypes<2>::Vector(stressX, stressY);
	PackedSample<2> sample(packed());
	const bool      reached = sample.servo(options);
	setPacked(sample.state());
	return reached;
}

py::tuple RveSample::stress() const
{
	const InPlane& s = packed().stress;
	return py::make_tuple(s(0, 0), s(1, 1), 0.5 * (s(0, 1) + s(1, 0)));
}

py::dict RveSample::statistics() const
{
	const auto& s     = packed();
	const auto  stats = PackedSample<2>(s).statistics();
	py::dict    d;
	d["contacts"]             = stats.contacts;
	d["bondsIntact"]          = stats.bondsIntact;
	d["bondsBroken"]          = stats.bondsBroken;
	d["bondsFormed"]          = s.bondsFormed;
	d["bondsBrokenInTension"] = s.bondsBrokenInTension;
	d["bondsBrokenInShear"]   = s.bondsBrokenInShear;
	d["bondsMelted"]          = s.bondsMelted;
	d["coordinationNumber"]   = stats.coordinationNumber;
	d["porosity"]             = stats.porosity;
	d["fabric"]               = py::make_tuple(stats.fabric(0, 0), stats.fabric(1, 1), stats.fabric(0, 1));
	d["unbalancedForce"]      = stats.unbalancedForce;
	d["kineticEnergy"]        = stats.kineticEnergy;
	return d;
}

namespace {
	template <class Get> py::object table(std::size_t rows, int columns, Get get)
	{
		np::ndarray array = np::zeros(columns == 1 ? py::make_tuple(rows) : py::make_tuple(rows, columns), np::dtype::get_builtin<double>());
		Real*       data  = reinterpret_cast<Real*>(array.get_data());
		for (std::size_t i = 0; i < rows; i++)
			for (int c = 0; c < columns; c++)
				data[i * columns + c] = get(i, c);
		return array;
	}
} // namespace

py::dict RveSample::arrays() const
{
	const auto& s = packed();
	const auto& k = s.contacts;
	py::dict    d;
	d["position"] = table(s.size(), 2, [&](std::size_t i, int c) { return s.position[i][c]; });
	d["radius"]   = table(s.size(), 1, [&](std::size_t i, int) { return s.grains->radius[i] * s.radiusFactor; });
	d["contact"]  = table(k.size(), 2, [&](std::size_t i, int c) { return c ? k.second[i] : k.first[i]; });
	d["cellDist"] = table(k.size(), 2, [&](std::size_t i, int c) { return k.cellDist[i][c]; });
	d["shear"]    = table(k.size(), 1, [&](std::size_t i, int) { return k.shear[i]; });
	d["bond"]     = table(k.size(), 1, [&](std::size_t i, int) { return k.bond.empty() ? 0 : k.bond[i] & 3; });
	d["hSize"]    = table(2, 2, [&](std::size_t i, int c) { return s.hSize(int(i), c); });
	return d;
}

shared_ptr<RveSample> RveSample::copy() const
{
	shared_ptr<RveSample> other(new RveSample);
	other->maxInertialNumber = maxInertialNumber;
	other->maxStrainPerStep  = maxStrainPerStep;
	other->minSteps          = minSteps;
	other->sceneBytes        = sceneBytes;
	other->setPacked(packed());
	return other;
}

py::object RveSample::stateBytes() const
{
	const string bytes = packed().toBytes();
	return py::object(py::handle<>(PyBytes_FromStringAndSize(bytes.data(), Py_ssize_t(bytes.size()))));
}

void RveSample::setTimeStep(Real dt)
{
	if (!(dt > 0) || !std::isfinite(dt))
		throw std::invalid_argument("RveSample.dt is " + boost::lexical_cast<string>(dt) + ": give a positive time step in s.");
	PackedState<2> s = packed();
	s.dt             = dt;
	setPacked(std::move(s));
}

void RveSample::setThawStrain(Real strain)
{
	PackedState<2> s        = packed();
	const Real     porosity = PackedSample<2>(s).statistics().porosity;
	if (!(strain >= 0 && strain <= porosity))
		throw std::invalid_argument(
		        "RveSample.thawStrain is " + boost::lexical_cast<string>(strain) + ": it must lie between 0 and the porosity of the sample, "
		        + boost::lexical_cast<string>(porosity) + ", which is all of eq. (8).");
	if (s.iceSaturation > 0)
		throw std::invalid_argument(
		        "RveSample.thawStrain is set on a sample that holds ice (iceSaturation " + boost::lexical_cast<string>(s.iceSaturation)
		        + "): set it before the sample freezes.");
	s.thawStrain.thawStrain = strain;
	setPacked(std::move(s));
}

void RveSample::setThawedStrength(Real strength)
{
	if (!(strength >= 0) || !std::isfinite(strength))
		throw std::invalid_argument("RveSample.thawedStrength is " + boost::lexical_cast<string>(strength) + ": give a strength in Pa, 0 or more.");
	PackedState<2> s = packed();
	if (!s.ice.formsBondsEver())
		throw std::invalid_argument("RveSample.thawedStrength is set on a sample whose grains carry no ice bonds: prepare it with ice=True.");
	s.ice.thawedStrength = strength;
	setPacked(std::move(s));
}

Matrix3r RveSample::deformation() const
{
	Matrix3r m              = Matrix3r::Identity();
	m.topLeftCorner<2, 2>() = packed().trsf;
	return m;
}

void RveSample::preSave(RveSample&)
{
	saved      = state ? talik::toBase64(state->toBytes()) : "";
	savedScene = sceneBytes.empty() ? "" : talik::toBase64(sceneBytes);
}

void RveSample::postLoad(RveSample&)
{
	if (!saved.empty()) setPacked(PackedState<2>::fromBytes(talik::fromBase64(saved)));
	if (!savedScene.empty()) sceneBytes = talik::fromBase64(savedScene);
	saved.clear();
	savedScene.clear();
}

} // namespace yade
