// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/common/Collider.hpp>
#include <pkg/common/ElastMat.hpp>
#include <pkg/common/NormShearPhys.hpp>
#include <pkg/common/Sphere.hpp>
#include <pkg/dem/ScGeom.hpp>
#include <pkg/icebond/IceBondContacts.hpp>
#include <pkg/icebond/IceStrengthAndCreep.hpp>
#include <pkg/python/PythonFunction.hpp>
#include <pkg/python/StepGate.hpp>
#include <pkg/rve/open/OpenSample.hpp>
#include <pkg/rve/open/ScenePacking.hpp>
#include <pkg/rve/packed/CellSlip.hpp>

#include <omp.h>
#include <stdexcept>

namespace py = boost::python;
using namespace yade;

namespace talik {
namespace {

	/// YADE's per-thread storage in a sample is for one thread, whichever thread of an outer team it runs on: inside a team of one the
	/// thread number is zero.
	template <class Work> void onOneThread(Work&& work)
	{
		std::exception_ptr failure;
#pragma omp parallel num_threads(1)
		{
			omp_set_num_threads(1);
			try {
				work();
			} catch (...) {
				failure = std::current_exception();
			}
		}
		if (failure) std::rethrow_exception(failure);
	}

	bool isClumpMember(const Body& body) { return body.clumpId >= 0 && body.clumpId != body.id; }

	/// The rigid body that a contact acts on: a grain or the clump that it belongs to.
	const Body& rigidBody(const Scene& scene, Body::id_t id)
	{
		const Body& body = *(*scene.bodies)[id];
		return isClumpMember(body) ? *(*scene.bodies)[body.clumpId] : body;
	}

	Vector3r forceOf(const Interaction& contact)
	{
		if (const auto* both = dynamic_cast<const NormShearPhys*>(contact.phys.get())) return both->normalForce + both->shearForce;
		if (const auto* normal = dynamic_cast<const NormPhys*>(contact.phys.get())) return normal->normalForce;
		throw std::invalid_argument(
		        "The contact " + std::to_string(contact.id1) + "-" + std::to_string(contact.id2)
		        + " of a sample has no normalForce: its law cannot be homogenised; use one whose contacts derive from NormPhys.");
	}

	/// visit(contact, first body, second body, vector from first to second) for every contact that exists.
	template <class Visitor> void forContacts(const Scene& scene, Visitor&& visit)
	{
		for (const auto& contact : *scene.interactions) {
			if (!contact->isReal()) continue;
			const Body &   first = rigidBody(scene, contact->id1), &second = rigidBody(scene, contact->id2);
			const Vector3r branch = second.state->se3.position - first.state->se3.position + scene.cell->hSize * contact->cellDist.cast<Real>();
			visit(*contact, first, second, branch);
		}
	}

	double volumeOf(const Cell& cell) { return std::abs(cell.hSize.determinant()); }

	Matrix3r symmetric(const Matrix3r& m) { return 0.5 * (m + m.transpose()); }

	bool inPlane(const Matrix3r& m) { return m(0, 2) == 0 && m(1, 2) == 0 && m(2, 0) == 0 && m(2, 1) == 0 && m(2, 2) == 0; }

	/// Bounds recorded in one cell mean nothing in another. (A collider from an archive would not do: it comes with a NewtonIntegrator
	/// of its own, waits for that one to move grains, and finds no new contact ever again.)
	void renewCollider(Scene& scene)
	{
		for (const auto& engine : scene.engines)
			if (auto* collider = dynamic_cast<Collider*>(engine.get())) collider->invalidatePersistentData();
		scene.interactions->dirty = true;
	}

	/// Cell distance at which the second body is nearest to the first.
	Vector3i nearestImage(const Cell& cell, const Matrix3r& inverse, const Vector3r& difference)
	{
		const Vector3r reduced = inverse * difference;
		const Vector3i centre(-int(std::lround(reduced[0])), -int(std::lround(reduced[1])), -int(std::lround(reduced[2])));
		Vector3i       nearest = centre;
		double         least   = std::numeric_limits<double>::infinity();
		for (int i = -1; i <= 1; ++i)
			for (int j = -1; j <= 1; ++j)
				for (int k = -1; k <= 1; ++k) {
					const Vector3i image  = centre + Vector3i(i, j, k);
					const double   square = (difference + cell.hSize * image.cast<Real>()).squaredNorm();
					if (square >= least) continue;
					least   = square;
					nearest = image;
				}
		return nearest;
	}

	shared_ptr<ScGeom> touch(const Body& first, const Body& second, const Vector3r& branch)
	{
		const double       distance = branch.norm();
		shared_ptr<ScGeom> geom(new ScGeom);
		geom->normal           = branch / distance;
		geom->refR1            = static_cast<const Sphere&>(*first.shape).radius;
		geom->refR2            = static_cast<const Sphere&>(*second.shape).radius;
		geom->penetrationDepth = geom->refR1 + geom->refR2 - distance;
		geom->contactPoint     = first.state->se3.position + (geom->refR1 - 0.5 * geom->penetrationDepth) * geom->normal;
		return geom;
	}

	/// Switched off altogether only where it is in use: YADE warns of every scene that may not redirect.
	void forbidRedirection(Scene& scene)
	{
		auto& bodies = *scene.bodies;
		if (!bodies.useRedirection) return;
		bodies.enableRedirection = false;
		bodies.useRedirection    = false;
	}

	bool bearsIce(const Body& body) { return dynamic_cast<IceBondMat*>(body.material.get()) && dynamic_cast<Sphere*>(body.shape.get()); }

} // namespace

Matrix3r stressOf(const Scene& scene, double volume)
{
	Matrix3r sum = Matrix3r::Zero();
	forContacts(scene, [&](const Interaction& contact, const Body&, const Body&, const Vector3r& branch) { sum -= forceOf(contact) * branch.transpose(); });
	return sum / volume;
}

void forbidRedirection() { forbidRedirection(*Omega::instance().getScene()); }

std::string reasonAgainstSample(const Scene& scene)
{
	const PythonLock  held;
	const std::string reason = py::extract<std::string>(
	        callPython("talik._packable", "againstSample", cellOf(scene), enginesOf(scene), bodiesOf(scene), scene.dt));
	return reason.empty() ? reasonAgainstRunning(scene, true) : reason;
}

// ---------------------------------------------------------------------------------------------- making

OpenSample::OpenSample(const std::string& sceneBytes)
{
	adopt(sceneFromBytes(sceneBytes));
	formed = intactBonds();
	keepState(0);
}

void OpenSample::adopt(shared_ptr<Scene> adopted)
{
	const std::string reason = reasonAgainstSample(*adopted);
	if (!reason.empty()) throw std::invalid_argument("The scene cannot be a sample: " + reason + ".");
	scene                      = std::move(adopted);
	scene->cell->flipFlippable = false;
	forbidRedirection(*scene);
	scene->dt = timeStepForIce(*scene);
	measureGrains();
	meanStress = stressOf(*scene, stressVolume());
}

void OpenSample::measureGrains()
{
	std::set<IceBondMat*> withIce;
	std::size_t           spheres = 0;
	averageRadius = density = 0;
	discs                   = true;
	forBodies(*scene, [&](Body& body) {
		if (!isClumpMember(body)) discs = discs && (body.state->blockedDOFs & State::DOF_Z);
		if (auto* material = dynamic_cast<IceBondMat*>(body.material.get())) withIce.insert(material);
		const auto* sphere = dynamic_cast<const Sphere*>(body.shape.get());
		if (!sphere || !body.material) return;
		averageRadius += sphere->radius;
		density += body.material->density;
		++spheres;
	});
	if (spheres == 0) throw std::invalid_argument("The scene cannot be a sample: it has no spheres.");
	averageRadius /= double(spheres);
	density /= double(spheres);
	iceMaterials.assign(withIce.begin(), withIce.end());
	thicknessOverDepth = discs ? thicknessOf(*scene) / std::abs(scene->cell->hSize(2, 2)) : 1;
	density /= thicknessOverDepth;
}

double OpenSample::stressVolume() const { return volumeOf(*scene->cell) * thicknessOverDepth; }

void OpenSample::setBondCounts(const std::array<std::uint64_t, 2>& counts)
{
	formed     = counts[0];
	melted     = counts[1];
	keptCounts = counts;
}

void OpenSample::keepState(long steps)
{
	if (!kept.empty() && scene->iter - keptAt < steps) return;
	kept       = sceneToBytes(scene);
	keptCounts = bondCounts();
	keptAt     = scene->iter;
}

void OpenSample::recover()
{
	adopt(sceneFromBytes(kept));
	setBondCounts(keptCounts);
}

// ---------------------------------------------------------------------------------------------- one update

/// The ice of materials and contacts is that of an update as long as it lives; contacts see that it has changed, and forces stay.
class OpenSample::ChangedIce {
public:
	ChangedIce(OpenSample& changed, const IceOfUpdate& ice)
	        : sample(changed)
	        , stiffness(ice.iceStiffness)
	{
		for (auto* material : sample.iceMaterials) {
			before.push_back(material->model());
			IceBondModel m = before.back();
			m.tensileStrength *= ice.strength.tensile;
			m.iceTensileStrength *= ice.strength.tensile;
			m.shearStrength *= ice.strength.shear;
			m.iceShearStrength *= ice.strength.shear;
			m.iceYoung *= stiffness;
			material->takeBonds(m);
		}
		stiffen(stiffness);
	}
	~ChangedIce()
	{
		stiffen(1 / stiffness);
		for (std::size_t k = 0; k < before.size(); ++k)
			sample.iceMaterials[k]->takeBonds(before[k]);
	}
	ChangedIce(const ChangedIce&)            = delete;
	ChangedIce& operator=(const ChangedIce&) = delete;

private:
	void stiffen(double by)
	{
		if (by != 1) sample.visitContacts([by](Interaction& contact, double overlap) { stiffenContact(contact, overlap, by); });
	}
	OpenSample&               sample;
	const double              stiffness;
	std::vector<IceBondModel> before;
};

PackedUpdateResult<3> OpenSample::apply(const Matrix3r& displacementGradient, double targetIceSaturation, const PackedUpdateOptions& options)
{
	checkOptions(options);
	if (!(targetIceSaturation >= 0 && targetIceSaturation <= 1))
		throw std::invalid_argument("open sample: ice saturation " + std::to_string(targetIceSaturation) + " must lie in 0..1");
	PackedUpdateResult<3> result;
	result.stress    = symmetric(meanStress);
	const long start = scene->iter;
	try {
		const ChangedIce ice(*this, options);
		onOneThread([&] {
			SampleUpdate<OpenSample>(*this, options).perform(displacementGradient, targetIceSaturation);
			checkHealth();
			result.flipped = options.flipSkew > 0 && flip(options.flipSkew);
			if (options.tangent) result.tangent = tangent();
		});
		result.stress = symmetric(meanStress);
	} catch (const std::runtime_error& problem) {
		result.blewUp = true;
		result.reason = problem.what() + ofThinCell(thickness());
	}
	result.steps = scene->iter - start;
	return result;
}

void OpenSample::setNextVelGrad(const Matrix3r& velGrad)
{
	scene->cell->nextVelGrad    = velGrad;
	scene->cell->velGradChanged = true;
}

void OpenSample::run(long steps)
{
	for (long k = 0; k < steps; ++k)
		scene->moveToNextTimeStep();
	if (steps > 0) meanStress = stressOf(*scene, stressVolume());
	scene->speed = 0; // steps per second by the clock on the wall, which YADE archives: the same run is to give the same bytes
}

double OpenSample::iceSaturation() const { return hasIce() ? iceMaterials.front()->iceSaturation : 0; }

void OpenSample::setIceSaturation(double iceSaturation)
{
	const double before = this->iceSaturation();
	const auto   model  = iceMaterials.front()->model();
	const bool   melts = model.melted(iceSaturation) && !model.melted(before), births = model.formsBonds(before, iceSaturation);
	if (melts && !model.bondsOutlastIce()) melted += intactBonds();
	for (auto* material : iceMaterials)
		material->iceSaturation = iceSaturation;
	if (births && !model.melted(iceSaturation)) bondAll();
}

template <class Visitor> void OpenSample::visitContacts(Visitor&& visit) const
{
	for (const auto& contact : *scene->interactions) {
		if (!contact->isReal()) continue;
		const Body &first = *(*scene->bodies)[contact->id1], &second = *(*scene->bodies)[contact->id2];
		const auto *a = dynamic_cast<const Sphere*>(first.shape.get()), *b = dynamic_cast<const Sphere*>(second.shape.get());
		if (!a || !b) continue;
		const Vector3r branch = second.state->se3.position - first.state->se3.position + scene->cell->hSize * contact->cellDist.cast<Real>();
		visit(*contact, a->radius + b->radius - branch.norm());
	}
}

void OpenSample::creep(const BondCreep& creep)
{
	visitContacts([&](Interaction& contact, double overlap) { relaxContact(*scene, contact, overlap, creep); });
}

Matrix3r OpenSample::motionPerStep(const Matrix3r& displacementGradient, long steps) const
{
	if (!inPlane(displacementGradient)) return matrixRootIncrement<3>(displacementGradient, steps);
	Matrix3r increment              = Matrix3r::Zero();
	increment.topLeftCorner<2, 2>() = matrixRootIncrement<2>(displacementGradient.topLeftCorner<2, 2>(), steps);
	return increment;
}

long OpenSample::movingSteps(const Matrix3r& displacementGradient, const PackedUpdateOptions& options) const
{
	const auto steps = [&](auto dimension) {
		constexpr int         dim = dimension;
		PackedParameters<dim> p;
		p.density = density;
		p.stress  = partOf<dim>(meanStress);
		return talik::movingSteps<dim>(p, scene->dt, averageRadius, partOf<dim>(displacementGradient), options);
	};
	return discs && inPlane(displacementGradient) ? steps(std::integral_constant<int, 2>()) : steps(std::integral_constant<int, 3>());
}

void OpenSample::checkHealth() const
{
	forBodies(*scene, [](Body& body) {
		if (!body.state->se3.position.allFinite() || !body.state->vel.allFinite())
			throw std::runtime_error("position or velocity of body " + std::to_string(body.id) + " is not finite");
	});
	for (const auto& contact : *scene->interactions) {
		const auto* geom = dynamic_cast<const ScGeom*>(contact->geom.get());
		if (geom && contact->isReal() && geom->penetrationDepth > std::min(geom->refR1, geom->refR2))
			throw std::runtime_error(
			        "the overlap of bodies " + std::to_string(contact->id1) + " and " + std::to_string(contact->id2) + " exceeds a radius");
	}
}

// ---------------------------------------------------------------------------------------------- cell and bonds

// H c = H' (M^-1 c) for the flipped cell H' = H M: positions, velocities, deformation and velocity gradient stay as they are.
bool OpenSample::flip(double skew)
{
	Cell&                 cell        = *scene->cell;
	const Eigen::Matrix3i combination = cellReduction<3>(cell.hSize, std::max(skew, 0.5));
	if (combination == Eigen::Matrix3i::Identity()) return false;
	const Eigen::Matrix3i unwind = integerInverse<3>(combination);
	cell.hSize                   = (cell.hSize * combination.cast<Real>()).eval();
	cell.integrateAndUpdate(0);
	for (const auto& interaction : *scene->interactions)
		interaction->cellDist = (unwind * interaction->cellDist).eval();
	renewCollider(*scene);
	return true;
}

std::size_t OpenSample::bondAll()
{
	std::size_t        count = 0;
	std::vector<Body*> grains;
	forBodies(*scene, [&](Body& body) {
		if (bearsIce(body)) grains.push_back(&body);
	});
	for (std::size_t a = 0; a < grains.size(); ++a)
		for (std::size_t b = a + 1; b < grains.size(); ++b)
			count += bondPair(*grains[a], *grains[b]);
	formed += count;
	return count;
}

bool OpenSample::bondPair(Body& first, Body& second)
{
	if (isClumpMember(first) && first.clumpId == second.clumpId) return false;
	const auto &   one = static_cast<const IceBondMat&>(*first.material), &two = static_cast<const IceBondMat&>(*second.material);
	const double   r1 = static_cast<const Sphere&>(*first.shape).radius, r2 = static_cast<const Sphere&>(*second.shape).radius;
	const double   reach      = r1 + r2 + one.mixedWith(two)->model.bondRange * std::min(r1, r2);
	const Vector3r difference = second.state->se3.position - first.state->se3.position;
	const Vector3i image      = nearestImage(*scene->cell, scene->cell->hSize.inverse(), difference);
	const Vector3r branch     = difference + scene->cell->hSize * image.cast<Real>();
	if (branch.squaredNorm() > reach * reach) return false;
	shared_ptr<Interaction> contact = scene->interactions->find(first.id, second.id);
	if (contact && contact->isReal()) {
		auto* phys = dynamic_cast<IceBondPhys*>(contact->phys.get());
		if (!phys || BondState(phys->bondState) != BondState::NONE) return false;
		phys->bondNow = true;
		return true;
	}
	if (!contact) {
		contact.reset(new Interaction(first.id, second.id));
		scene->interactions->insert(contact);
	}
	const bool swapped = contact->id1 != first.id;
	contact->cellDist  = swapped ? Vector3i(-image) : image;
	contact->geom      = swapped ? touch(second, first, -branch) : touch(first, second, branch);
	Ip2_IceBondMat_IceBondMat_IceBondPhys parameters;
	parameters.bondNewContacts = true;
	parameters.go((*scene->bodies)[contact->id1]->material, (*scene->bodies)[contact->id2]->material, contact);
	contact->iterMadeReal = scene->iter;
	return true;
}

std::size_t OpenSample::intactBonds() const
{
	std::size_t intact = 0;
	for (const auto& contact : *scene->interactions) {
		const auto* phys = contact->isReal() ? dynamic_cast<const IceBondPhys*>(contact->phys.get()) : nullptr;
		intact += phys && BondState(phys->bondState) == BondState::BONDED;
	}
	return intact;
}

// ---------------------------------------------------------------------------------------------- measures

Matrix3r OpenSample::stress() const { return symmetric(meanStress); }

PackedTangent<3> OpenSample::tangent() const
{
	PackedTangent<3> result {};
	const double     volume = stressVolume();
	forContacts(*scene, [&](const Interaction& contact, const Body&, const Body&, const Vector3r& branch) {
		const auto*    normal = dynamic_cast<const NormPhys*>(contact.phys.get());
		const auto*    shear  = dynamic_cast<const NormShearPhys*>(contact.phys.get());
		const double   kn = normal ? normal->kn : 0, ks = shear ? shear->ks : 0;
		const Vector3r n       = branch.normalized();
		const double   squared = branch.squaredNorm() / volume;
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j)
				for (int k = 0; k < 3; ++k)
					for (int l = 0; l < 3; ++l) {
						const double nn = n[i] * n[k], tt = (i == k ? 1. : 0.) - nn;
						result[((i * 3 + j) * 3 + k) * 3 + l] += squared * (kn * nn + ks * tt) * n[j] * n[l];
					}
	});
	return result;
}

/// Discs have images above and below that they never meet.
double OpenSample::thickness() const
{
	const Matrix3r& h = scene->cell->hSize;
	return (discs ? shortestImage<2>(h.topLeftCorner<2, 2>()) : shortestImage<3>(h)) / (2 * averageRadius);
}

OpenStatistics OpenSample::statistics() const
{
	OpenStatistics                 result;
	std::map<Body::id_t, Vector3r> net;
	double                         forces = 0;
	forContacts(*scene, [&](const Interaction& contact, const Body& first, const Body& second, const Vector3r& branch) {
		const Vector3r force = forceOf(contact), n = branch.normalized();
		net.emplace(first.id, Vector3r::Zero()).first->second -= force;
		net.emplace(second.id, Vector3r::Zero()).first->second += force;
		result.fabric += n * n.transpose();
		forces += force.norm();
		++result.contacts;
	});
	std::size_t bodies = 0;
	double      solid = 0, imbalance = 0;
	const auto& velGrad = scene->cell->velGrad;
	forBodies(*scene, [&](Body& body) {
		const State& motion = *body.state;
		if (const auto* sphere = dynamic_cast<const Sphere*>(body.shape.get())) {
			const double r = sphere->radius;
			solid += discs ? M_PI * r * r * std::abs(scene->cell->hSize(2, 2)) : 4. / 3. * M_PI * r * r * r;
		}
		if (isClumpMember(body)) return;
		++bodies;
		const Vector3r fluctuation = motion.vel - velGrad * motion.se3.position;
		result.kineticEnergy += 0.5 * (motion.mass * fluctuation.squaredNorm() + motion.angVel.dot(motion.inertia.cwiseProduct(motion.angVel)));
	});
	for (const auto& entry : net)
		imbalance += entry.second.norm();
	result.cellThickness      = thickness();
	result.porosity           = 1 - solid / volumeOf(*scene->cell);
	result.coordinationNumber = bodies > 0 ? 2. * double(result.contacts) / double(bodies) : 0;
	if (result.contacts > 0) result.fabric /= double(result.contacts);
	if (forces > 0) result.unbalancedForce = (imbalance / double(bodies)) / (forces / double(result.contacts));
	result.bondsIntact       = intactBonds();
	result.bondsFormed       = formed;
	result.bondsMelted       = melted;
	const std::uint64_t gone = melted + result.bondsIntact;
	result.bondsBroken       = formed > gone ? formed - gone : 0;
	return result;
}

double StiffnessBound::modulus(double iceSaturation) const { return (hasIce ? ice.youngAt(iceSaturation) : young) * std::max(1.1 * scale, 1.2 * network); }

StiffnessBound OpenSample::stiffnessBound() const
{
	StiffnessBound bound;
	forBodies(*scene, [&](Body& body) {
		if (const auto* elastic = dynamic_cast<const ElastMat*>(body.material.get())) bound.young = std::max(bound.young, elastic->young);
	});
	bound.hasIce = hasIce();
	if (hasIce()) bound.ice = iceMaterials.front()->model();
	if (hasIce()) bound.ice.young *= overLinear(*scene, *iceMaterials.front(), averageRadius, 10); // of Hertz's grains under ten times the stress of now
	const auto   contacts = tangent();
	const double stiffest = std::max({ contacts[0], contacts[40], contacts[80] }), present = hasIce() ? bound.ice.youngAt(iceSaturation()) : bound.young;
	bound.scale = discs ? averageRadius / (thicknessOverDepth * std::abs(scene->cell->hSize(2, 2))) : 1;
	if (present > 0) bound.network = stiffest / present;
	else bound.young = stiffest; // a material without modulus: the contacts are all there is
	return bound;
}

} // namespace talik
