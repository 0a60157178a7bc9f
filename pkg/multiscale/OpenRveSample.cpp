// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/BondCreepOfScript.hpp>
#include <pkg/multiscale/OpenRveSample.hpp>
#include <pkg/rve/open/ScenePacking.hpp>

namespace py = boost::python;

namespace yade {
YADE_PLUGIN((OpenRveSample));

talik::OpenSample& OpenRveSample::sample() const
{
	if (running) return *running;
	if (!source) throw std::invalid_argument("OpenRveSample.source is None: give a Scene, e.g. OpenRveSample(source=O._sceneObj).");
	running = std::make_shared<talik::OpenSample>(talik::sceneToBytes(source));
	return *running;
}

py::dict OpenRveSample::apply(const Matrix3r& displacementGradient, Real iceSaturation, const py::object& creep)
{
	if (!(iceSaturation >= 0 && iceSaturation <= 1))
		throw std::invalid_argument(
		        "OpenRveSample: iceSaturation is " + boost::lexical_cast<string>(iceSaturation) + ": give a saturation from 0 to 1.");
	talik::PackedUpdateOptions options;
	options.maxInertialNumber = maxInertialNumber;
	options.maxStrainPerStep  = maxStrainPerStep;
	options.minSteps          = minSteps;
	options.strength          = { tensileStrengthFactor, shearStrengthFactor };
	options.creep             = bondCreep("OpenRveSample.apply", creep);
	talik::forbidRedirection();
	sample().keepState();
	const auto result = sample().apply(displacementGradient, iceSaturation, options);
	if (result.blewUp) sample().recover();
	py::dict d;
	d["stress"]  = result.stress;
	d["steps"]   = result.steps;
	d["flipped"] = result.flipped;
	d["blewUp"]  = result.blewUp;
	d["reason"]  = result.reason;
	return d;
}

bool OpenRveSample::flip(Real skew) { return sample().flip(skew); }

shared_ptr<Scene> OpenRveSample::open() const { return talik::sceneForView(talik::sceneToBytes(sample().yadeScene())); }

void OpenRveSample::freeze(Real iceSaturation) { apply(Matrix3r::Zero(), iceSaturation); }

py::dict OpenRveSample::statistics() const
{
	const auto s = sample().statistics();
	py::dict   d;
	d["contacts"]           = s.contacts;
	d["bondsIntact"]        = s.bondsIntact;
	d["bondsFormed"]        = s.bondsFormed;
	d["bondsBroken"]        = s.bondsBroken;
	d["bondsMelted"]        = s.bondsMelted;
	d["coordinationNumber"] = s.coordinationNumber;
	d["porosity"]           = s.porosity;
	d["fabric"]             = s.fabric;
	d["unbalancedForce"]    = s.unbalancedForce;
	d["kineticEnergy"]      = s.kineticEnergy;
	return d;
}

} // namespace yade
