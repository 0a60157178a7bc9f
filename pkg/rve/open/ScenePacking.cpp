// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/common/ElastMat.hpp>
#include <pkg/common/Sphere.hpp>
#include <pkg/dem/FrictPhys.hpp>
#include <pkg/dem/ScGeom.hpp>
#include <pkg/icebond/IceBondContacts.hpp>
#include <pkg/icebond/IceBondMoments.hpp>
#include <pkg/python/PythonFunction.hpp>
#include <pkg/python/StepGate.hpp>
#include <pkg/rve/open/OpenSample.hpp>
#include <pkg/rve/open/ScenePacking.hpp>
#include <pkg/rve/packed/PackedNeighbours.hpp>

#include <algorithm>
#include <boost/archive/codecvt_null.hpp>
#include <boost/archive/xml_iarchive.hpp>
#include <boost/math/special_functions/nonfinite_num_facets.hpp>
#include <locale>
#include <omp.h>
#include <sstream>
#include <tuple>

namespace py = boost::python;
using namespace yade;

namespace talik {
namespace {

	std::vector<Body*> presentBodies(const Scene& scene)
	{
		std::vector<Body*> present;
		forBodies(scene, [&](Body& body) { present.push_back(&body); });
		return present;
	}

	py::object engineNamed(const Scene& scene, const char* name)
	{
		for (const auto& engine : enginesNow(scene))
			if (engine->getClassName() == name) return py::object(engine);
		return py::object();
	}

	bool isIceBondScene(const Scene& scene)
	{
		const auto bodies = presentBodies(scene);
		return !bodies.empty() && boost::dynamic_pointer_cast<IceBondMat>(bodies.front()->material);
	}

	PackedRolling rollingOf(const Material& material)
	{
		const auto* rolls = dynamic_cast<const RollingIceBondMat*>(&material);
		return rolls && rolls->etaRoll > 0 ? PackedRolling { rolls->alphaKr, rolls->etaRoll } : PackedRolling();
	}

	BondSection sectionOf(const Material& material)
	{
		const auto* bonds = dynamic_cast<const MomentIceBondMat*>(&material);
		return bonds ? bonds->section() : BondSection();
	}

	/// Unit tangent t = z x n of a contact.
	Vector3r tangentOf(const Vector3r& n) { return { -n[1], n[0], 0 }; }

	template <int Dim> Eigen::Matrix<double, Dim, 1> cellVector(const typename PackedTypes<Dim>::CellDist& cells)
	{
		Eigen::Matrix<double, Dim, 1> v;
		for (int d = 0; d < Dim; ++d)
			v[d] = cells[d];
		return v;
	}

	/// A vector in space of one of the sample's, zero out of its plane.
	template <int Dim> Vector3r inSpace(const Eigen::Matrix<double, Dim, 1>& v)
	{
		Vector3r all             = Vector3r::Zero();
		all.template head<Dim>() = v;
		return all;
	}

	template <int Dim> Vector3r branch(const PackedState<Dim>& state, std::size_t c)
	{
		const auto&                       k = state.contacts;
		typename PackedTypes<Dim>::Vector d = state.position[k.second[c]] + state.hSize * cellVector<Dim>(k.cellDist[c]) - state.position[k.first[c]];
		return inSpace<Dim>(d);
	}

	/// The branch of a contact in the last step, whose present one is given.
	Vector3r lastBranch(const PackedState<3>& state, std::size_t c, const Vector3r& now)
	{
		return now - state.dt * (state.velocity[state.contacts.second[c]] - state.velocity[state.contacts.first[c]]);
	}

	Vector3r momentVector(double moment) { return { 0, 0, moment }; }
	Vector3r momentVector(const Vector3r& moment) { return moment; }
	void     setMoment(double& moment, const Vector3r& vector) { moment = vector[2]; }
	void     setMoment(Vector3r& moment, const Vector3r& vector) { moment = vector; }

	Vector3r vectorOf(double scalarShear, const Vector3r& normal) { return scalarShear * tangentOf(normal); }
	Vector3r vectorOf(const Vector3r& shear, const Vector3r&) { return shear; }

	Quaternionr orientationOf(double angle) { return Quaternionr(std::cos(angle / 2), 0, 0, std::sin(angle / 2)); }

	template <int Dim> void setPart(Matrix3r& target, const typename PackedTypes<Dim>::Matrix& m) { target.template topLeftCorner<Dim, Dim>() = m; }

	void packTurning(const State& motion, const PackedState<2>* former, std::size_t index, PackedState<2>& state)
	{
		state.angularVelocity.push_back(motion.angVel[2]);
		const Quaternionr& q     = motion.se3.orientation;
		double             angle = 2 * std::atan2(q.z(), q.w());
		if (former && index < former->size() && orientationOf(former->orientation[index]).coeffs() == q.coeffs()) angle = former->orientation[index];
		state.orientation.push_back(angle);
	}

	void packTurning(const State& motion, const PackedState<3>*, std::size_t, PackedState<3>& state) { state.angularVelocity.push_back(motion.angVel); }

	template <int Dim> void packGrains(const Scene& scene, const PackedState<Dim>* former, PackedState<Dim>& state, std::map<int, int>& indexOf)
	{
		auto grains     = std::make_shared<PackedGrains>();
		grains->rolling = rollingOf(*presentBodies(scene).front()->material);
		grains->section = sectionOf(*presentBodies(scene).front()->material);
		if (isIceBondScene(scene)) grains->hertz = static_cast<const IceBondMat&>(*presentBodies(scene).front()->material).elasticity();
		for (const Body* body : presentBodies(scene)) {
			const State&      motion = *body->state;
			const std::size_t index  = grains->size();
			indexOf[body->id]        = int(index);
			grains->id.push_back(body->id);
			grains->radius.push_back(static_cast<const Sphere&>(*body->shape).radius);
			grains->mass.push_back(motion.mass);
			grains->inertia.push_back(motion.inertia[2]);
			state.position.push_back(motion.se3.position.template head<Dim>());
			state.velocity.push_back(motion.vel.template head<Dim>());
			packTurning(motion, former, index, state);
		}
		if (former && former->grains && former->grains->sameButRadii(*grains)) {
			bool same = true;
			for (std::size_t i = 0; i < grains->size(); ++i)
				same = same && former->grains->radius[i] * former->radiusFactor == grains->radius[i];
			if (same) {
				state.grains       = former->grains;
				state.radiusFactor = former->radiusFactor;
				return;
			}
		}
		state.grains = grains;
	}

	template <int Dim> void packCell(const Scene& scene, PackedState<Dim>& state)
	{
		const Cell& cell  = *scene.cell;
		state.hSize       = partOf<Dim>(cell.hSize);
		state.prevHSize   = partOf<Dim>(cell.prevHSize);
		state.velGrad     = partOf<Dim>(cell.velGrad);
		state.nextVelGrad = partOf<Dim>(cell.velGradChanged || cell.nextVelGrad != Matrix3r::Zero() ? cell.nextVelGrad : cell.velGrad);
		state.trsf        = partOf<Dim>(cell.trsf);
		if (Dim == 2) state.thickness = thicknessOf(scene);
	}

	template <int Dim> void packParameters(const Scene& scene, PackedState<Dim>& state)
	{
		const py::object newton = engineNamed(scene, "NewtonIntegrator");
		state.dt                = scene.dt;
		state.step              = std::uint64_t(scene.iter);
		state.damping           = py::extract<double>(newton.attr("damping"));
		state.prevVelGrad       = partOf<Dim>(py::extract<Matrix3r>(newton.attr("prevVelGrad"))());
		const auto& material    = static_cast<const FrictMat&>(*presentBodies(scene).front()->material);
		state.friction          = std::tan(material.frictionAngle);
		state.stiffnessRatio    = material.poisson;
		state.density           = Dim == 2 ? material.density * (std::abs(scene.cell->hSize(2, 2)) / state.thickness) : material.density;
		state.ice               = IceBondModel::none();
		if (isIceBondScene(scene)) {
			const auto& ice     = static_cast<const IceBondMat&>(material);
			state.ice           = ice.model();
			state.iceSaturation = ice.iceSaturation;
			if (ice.hertzMindlin) state.stiffnessRatio = ice.elasticity().shearRatio;
		}
		state.ice.young = material.young;
	}

	/// A contact of the scene as the sample knows it.
	template <int Dim> struct PackedEntry {
		int                                 first, second;
		typename PackedTypes<Dim>::CellDist cells;
		int                                 sign; ///< -1 where the scene has the grains the other way round
		const Interaction*                  interaction;
		bool                                crosses;
		std::uint64_t                       code;
	};

	/// Forces of the shear kind. Of discs the component along t, or the scalar of a former state that opened into this very vector.
	template <int Dim> class PackedShears {
	public:
		explicit PackedShears(const PackedState<Dim>* state)
		        : former(state)
		{
			if (Dim == 3 || !state) return;
			const auto& k = state->contacts;
			for (std::size_t c = 0; c < k.size(); ++c)
				place[PairKey<Dim> { k.first[c], k.second[c], k.cellDist[c] }.encode()] = c;
		}
		typename PackedTypes<Dim>::Shear operator()(const PackedEntry<Dim>& e, const Vector3r& vector, const Vector3r& normal, bool ofIce) const
		{
			if constexpr (Dim == 3) return e.sign * vector;
			else {
				const auto found = place.find(e.code);
				if (found == place.end()) return vector.dot(tangentOf(normal));
				const auto&  k = former->contacts;
				const double s = !ofIce ? k.shear[found->second] : k.iceShear.empty() ? 0 : k.iceShear[found->second];
				return vectorOf(s, normal) == vector ? s : vector.dot(tangentOf(normal));
			}
		}

	private:
		const PackedState<Dim>*              former;
		std::map<std::uint64_t, std::size_t> place; ///< of each contact of the former state
	};

	template <int Dim> void packContacts(const Scene& scene, const PackedState<Dim>* former, const std::map<int, int>& indexOf, PackedState<Dim>& state)
	{
		const PackedShears<Dim> shearOf(former);
		const bool              ice    = isIceBondScene(scene);
		bool                    anyIce = false;
		using Entry                    = PackedEntry<Dim>;
		std::vector<Entry> entries;
		for (const auto& interaction : *scene.interactions) {
			if (!interaction->isReal()) continue;
			int a = indexOf.at(interaction->id1), b = indexOf.at(interaction->id2);
			int sign = 1;
			if (a > b) {
				std::swap(a, b);
				sign = -1;
			}
			PairKey<Dim> pair { std::uint32_t(a), std::uint32_t(b), {} };
			for (int d = 0; d < Dim; ++d)
				pair.cellDist[d] = std::int8_t(sign * interaction->cellDist[d]);
			entries.push_back({ a, b, pair.cellDist, sign, interaction.get(), pair.crossesCell(), pair.encode() });
		}
		// in the order in which a packed sample keeps them
		std::sort(entries.begin(), entries.end(), [](const Entry& l, const Entry& r) {
			return std::tie(l.crosses, l.code) < std::tie(r.crosses, r.code);
		});
		auto& k = state.contacts;
		for (const auto& entry : entries) {
			const auto& geom = static_cast<const ScGeom&>(*entry.interaction->geom);
			const auto& phys = static_cast<const FrictPhys&>(*entry.interaction->phys);
			k.first.push_back(std::uint16_t(entry.first));
			k.second.push_back(std::uint16_t(entry.second));
			k.cellDist.push_back(entry.cells);
			k.shear.push_back(shearOf(entry, phys.shearForce, geom.normal, false));
			if (state.resistsRolling()) {
				k.moment.emplace_back();
				setMoment(k.moment.back(), entry.sign * static_cast<const RollingIceBondPhys&>(phys).moment_bending);
			}
			if (!ice) continue;
			const auto& bond = static_cast<const IceBondPhys&>(phys);
			k.iceShear.push_back(shearOf(entry, bond.iceShear, geom.normal, true));
			if (state.bondsCarryMoments()) {
				k.bondMoment.emplace_back();
				setMoment(k.bondMoment.back(), entry.sign * static_cast<const MomentIceBondPhys&>(phys).bondMoment);
			}
			k.iceReference.push_back(bond.uIce);
			k.grainReference.push_back(bond.uGrain);
			k.bond.push_back(k.encode(bond.bond()));
			anyIce = anyIce || bond.bondState != 0;
		}
		if (ice && !anyIce && !(former && former->bonded())) {
			k.iceShear.clear();
			k.bondMoment.clear();
			k.iceReference.clear();
			k.grainReference.clear();
			k.bond.clear();
		}
	}

	template <int Dim> shared_ptr<RollingIceBondPhys> openedMoments(const PackedState<Dim>& s, std::size_t c)
	{
		if (!s.bondsCarryMoments()) return shared_ptr<RollingIceBondPhys>(new RollingIceBondPhys);
		shared_ptr<MomentIceBondPhys> phys(new MomentIceBondPhys);
		phys->bondRadiusFactor   = s.grains->section.radiusFactor;
		phys->momentContribution = s.grains->section.contribution;
		if (s.bonded()) phys->bondMoment = momentVector(s.contacts.bondMoment[c]);
		return phys;
	}

	template <int Dim> shared_ptr<IceBondPhys> openedBond(const PackedState<Dim>& s, std::size_t c, double r1, double r2, double shearStiffness)
	{
		if (!s.resistsRolling() && !s.bondsCarryMoments()) return shared_ptr<IceBondPhys>(new IceBondPhys);
		const shared_ptr<RollingIceBondPhys> phys = openedMoments(s, c);
		if (!s.resistsRolling()) return phys;
		phys->kr             = s.grains->rolling.stiffness(shearStiffness, r1, r2);
		phys->maxRollPl      = s.grains->rolling.lever(r1, r2);
		phys->moment_bending = momentVector(s.contacts.moment[c]);
		return phys;
	}

	template <int Dim> shared_ptr<IPhys> openedPhys(const PackedState<Dim>& s, std::size_t c, bool ice, double r1, double r2, const Vector3r& n, double un)
	{
		const auto&  k     = s.contacts;
		const double grain = 2 * r1 * r2 / (r1 + r2) * s.ice.young;
		if (!ice) {
			shared_ptr<FrictPhys> phys(new FrictPhys);
			phys->kn                     = grain;
			phys->ks                     = s.stiffnessRatio * grain;
			phys->tangensOfFrictionAngle = s.friction;
			phys->shearForce             = vectorOf(k.shear[c], n);
			phys->normalForce            = grain * std::max(un, 0.) * n;
			return phys;
		}
		const double                  hertz = s.grains->hertz.stiffness(r1, r2);
		const shared_ptr<IceBondPhys> phys  = openedBond(s, c, r1, r2, s.stiffnessRatio * (hertz > 0 ? hertz : grain));
		phys->kno                           = hertz;
		phys->grainStiffness                = grain;
		phys->stiffnessRatio                = s.stiffnessRatio;
		phys->tangensOfFrictionAngle        = s.friction;
		phys->iceSaturation                 = s.iceSaturation;
		phys->bondArea                      = s.ice.bondArea(std::min(r1, r2));
		phys->gapLimit                      = s.ice.bondRange * std::min(r1, r2);
		phys->shearForce                    = vectorOf(k.shear[c], n);
		if (s.bonded()) {
			phys->setBond(k.iceBond(c));
			phys->iceShear = vectorOf(k.iceShear[c], n);
		}
		const IceBond bond      = phys->bond().relaxed(un);
		const auto    stiffness = phys->stiffness(s.ice.iceStiffnessRatio(s.iceSaturation));
		const auto    spring    = stiffness.spring(bond.response(stiffness, { 0, 0 }), un);
		phys->normalForce       = (bond.intact() ? spring.force : std::max(spring.force, 0.)) * n;
		phys->kn                = spring.tangent;
		phys->ks                = s.stiffnessRatio * spring.tangent;
		return phys;
	}

	template <int Dim> void openContacts(Scene& scene, const PackedState<Dim>& s)
	{
		const bool  ice = isIceBondScene(scene);
		const auto& k   = s.contacts;
		scene.interactions->clear();
		for (std::size_t c = 0; c < k.size(); ++c) {
			const double       r1 = s.grains->radius[k.first[c]], r2 = s.grains->radius[k.second[c]];
			const Vector3r     d      = branch(s, c);
			const double       length = d.norm();
			shared_ptr<ScGeom> geom(new ScGeom);
			geom->normal          = d / length;
			const Vector3r normal = geom->normal;
			if constexpr (Dim == 3) geom->normal = lastBranch(s, c, d).normalized(); // the scene's next step turns the shear force from here
			geom->refR1            = r1 * s.radiusFactor;
			geom->refR2            = r2 * s.radiusFactor;
			geom->penetrationDepth = geom->refR1 + geom->refR2 - length;
			const Vector3r x1      = (*scene.bodies)[s.grains->id[k.first[c]]]->state->se3.position;
			geom->contactPoint     = x1 + (geom->refR1 - 0.5 * geom->penetrationDepth) * normal;
			shared_ptr<Interaction> interaction(new Interaction(s.grains->id[k.first[c]], s.grains->id[k.second[c]]));
			interaction->cellDist     = inSpace<Dim>(cellVector<Dim>(k.cellDist[c])).template cast<int>();
			interaction->geom         = geom;
			interaction->phys         = openedPhys(s, c, ice, r1, r2, normal, geom->penetrationDepth);
			interaction->iterMadeReal = scene.iter;
			scene.interactions->insert(interaction);
		}
		// the collider has to find the pairs that do not touch anew
		scene.interactions->dirty = true;
	}

	template <int Dim> void openCell(Scene& scene, const PackedState<Dim>& s)
	{
		Cell& cell = *scene.cell;
		setPart<Dim>(cell.hSize, s.hSize);
		setPart<Dim>(cell.trsf, s.trsf);
		cell.velGrad.setZero();
		setPart<Dim>(cell.velGrad, s.velGrad);
		cell.callPostLoad();
		setPart<Dim>(cell.prevHSize, s.prevHSize);
		cell.nextVelGrad.setZero();
		setPart<Dim>(cell.nextVelGrad, s.nextVelGrad);
		cell.velGradChanged = s.nextVelGrad != s.velGrad;
		cell.prevVelGrad.setZero();
		setPart<Dim>(cell.prevVelGrad, s.prevVelGrad);
		Matrix3r used = Matrix3r::Zero();
		setPart<Dim>(used, s.prevVelGrad);
		py::object newton          = engineNamed(scene, "NewtonIntegrator");
		newton.attr("prevVelGrad") = used;
	}

	/// Grains of a scene with a time step of their own: calls visit(body, material, radius, its stiffening). False if some body is no such grain.
	template <class Visitor> bool forStiffening(const Scene& scene, Visitor&& visit)
	{
		double largest = 0, smallest = std::numeric_limits<double>::infinity();
		for (const Body* body : presentBodies(scene))
			if (const auto* sphere = dynamic_cast<const Sphere*>(body->shape.get())) {
				largest  = std::max(largest, sphere->radius);
				smallest = std::min(smallest, sphere->radius);
			}
		bool                                all = true;
		std::map<const IceBondMat*, double> ofGrains;
		for (const Body* body : presentBodies(scene)) {
			const auto* ice    = dynamic_cast<const IceBondMat*>(body->material.get());
			const auto* sphere = dynamic_cast<const Sphere*>(body->shape.get());
			all                = all && ice && sphere;
			if (!ice || !sphere) continue;
			const double ratio = ice->hertzMindlin ? ice->elasticity().shearRatio : ice->poisson;
			if (!ofGrains.count(ice)) ofGrains[ice] = overLinear(scene, *ice, smallest, 1);
			visit(*body, *ice, sphere->radius,
			      GrainStiffening { rollingOf(*ice).alphaKr * largest / sphere->radius,
			                        GrainStiffening::momentsOf(sectionOf(*ice), ice->bondAreaFactor, ratio), ofGrains[ice] });
		}
		return all;
	}
} // namespace

double overLinear(const Scene& scene, const IceBondMat& grains, double radius, double times)
{
	if (!grains.hertzMindlin) return 1;
	const bool     discs     = packedDimension(scene) == 2;
	const double   thickness = discs ? thicknessOf(scene) : 1, depth = discs ? std::abs(scene.cell->hSize(2, 2)) : 1;
	const Matrix3r stress   = stressOf(scene, std::abs(scene.cell->hSize.determinant()) * thickness / depth);
	const double   pressure = discs ? -(stress(0, 0) + stress(1, 1)) / 2 : -stress.trace() / 3;
	return grains.elasticity().overLinear(grains.young, times * pressure, discs ? thickness / radius : 1);
}

double timeStepForIce(const Scene& scene)
{
	double period2 = std::numeric_limits<double>::infinity(), stiffening = 1; // m/k [s^2]
	forStiffening(scene, [&](const Body& body, const IceBondMat& ice, double radius, const GrainStiffening& grain) {
		if (!(ice.iceYoung > 0 || ice.hertzMindlin) || !(body.state->mass > 0)) return;
		const double stiffened = grain.total(ice.iceYoung / ice.young);
		if (!ice.hertzMindlin) stiffening = std::max(stiffening, stiffened / grain.total(0)); // of Hertz's grains at a stress that is still to come
		period2 = std::min(period2, body.state->mass / (ice.young * radius * stiffened));
	});
	const double limit = timeStepOverPeriod * std::sqrt(period2);
	return scene.dt > limit ? std::min(scene.dt / std::sqrt(stiffening), limit) : scene.dt;
}

/// Time step of the motion, eq. (13.8).
double longestTimeStep(const Scene& scene, double iceStiffness)
{
	double     period2 = std::numeric_limits<double>::infinity(), softening = period2; // m/k [s^2]
	const bool known = forStiffening(scene, [&](const Body& body, const IceBondMat& ice, double radius, const GrainStiffening& grain) {
		const auto   model = ice.model();
		const double now   = grain.total(model.iceStiffnessRatio(ice.iceSaturation));
		period2            = std::min(period2, body.state->mass / (ice.young * radius * now));
		softening          = std::min(softening, grain.total(model.iceStiffnessRatio(1) / iceStiffness) / now);
	});
	return known ? std::min(timeStepOverPeriod * std::sqrt(period2), scene.dt * std::sqrt(softening)) : scene.dt;
}

bool bondsCarryMoments(const Scene& scene)
{
	const auto bodies = presentBodies(scene);
	return std::any_of(bodies.begin(), bodies.end(), [](const Body* body) { return body->material && sectionOf(*body->material).acts(); });
}

py::object cellOf(const Scene& scene) { return scene.isPeriodic ? py::object(scene.cell) : py::object(); }

py::list bodiesOf(const Scene& scene)
{
	py::list bodies;
	for (std::size_t id = 0; id < scene.bodies->size(); ++id)
		if ((*scene.bodies)[id]) bodies.append((*scene.bodies)[id]);
	return bodies;
}

py::list enginesOf(const Scene& scene)
{
	py::list engines;
	for (const auto& engine : enginesNow(scene))
		engines.append(engine);
	return engines;
}

std::string reasonAgainstPacking(const Scene& scene)
{
	const PythonLock gil;
	py::list         contacts;
	for (const auto& interaction : *scene.interactions)
		if (interaction->isReal()) contacts.append(interaction);
	return py::extract<std::string>(callPython("talik._packable", "reason", cellOf(scene), bodiesOf(scene), enginesOf(scene), contacts));
}

int packedDimension(const Scene& scene)
{
	const auto bodies  = presentBodies(scene);
	const auto inLayer = [&](const Body* body) { return body->state->se3.position[2] == bodies.front()->state->se3.position[2]; };
	return bodies.empty() || bodies.front()->state->blockedDOFs || std::all_of(bodies.begin(), bodies.end(), inLayer) ? 2 : 3;
}

template <int Dim> PackedState<Dim> packScene(const Scene& scene, const PackedState<Dim>* former)
{
	PythonLock  gil;
	std::string reason = reasonAgainstPacking(scene);
	if (reason.empty() && packedDimension(scene) != Dim)
		reason = Dim == 2 ? "it has spheres and a sample of discs is wanted" : "it has discs and a sample of spheres is wanted";
	if (!reason.empty()) {
		const std::string open   = reasonAgainstSample(scene);
		const std::string remedy = open.empty() ? ". RveSkeleton(scenes=[scene]) runs it open, with YADE's own engines."
		                                        : ", and it cannot run open: " + open + "; give a periodic scene of grains that stock YADE moves.";
		throw std::invalid_argument("The scene cannot be packed: " + reason + remedy);
	}
	PackedState<Dim>   state;
	std::map<int, int> indexOf;
	packGrains(scene, former, state, indexOf);
	packCell(scene, state);
	packParameters(scene, state);
	packContacts(scene, former, indexOf, state);
	if (!former) state.dt = timeStepForIce(scene);
	if (former) {
		state.thawStrain           = former->thawStrain;
		state.bondsFormed          = former->bondsFormed;
		state.bondsBrokenInTension = former->bondsBrokenInTension;
		state.bondsBrokenInShear   = former->bondsBrokenInShear;
		state.bondsMelted          = former->bondsMelted;
		state.cellSlips            = former->cellSlips;
		state.cellSlipStrain       = former->cellSlipStrain;
		state.cellSlipStress       = former->cellSlipStress;
		// the stress of the last step is not that of the forces at the present positions, which an opened scene shows
		state.stress = former->stress;
		if (state.toBytes() == former->toBytes()) return state;
	}
	state.stress = partOf<Dim>(stressOf(scene, state.volume()));
	return state;
}

template PackedState<2> packScene<2>(const Scene&, const PackedState<2>*);
template PackedState<3> packScene<3>(const Scene&, const PackedState<3>*);

double thicknessOf(const Scene& scene)
{
	const PythonLock held;
	py::list         tags;
	for (const auto& tag : scene.tags)
		tags.append(tag);
	const py::object          found = callPython("talik._packable", "thickness", tags, std::abs(scene.cell->hSize(2, 2)));
	const py::extract<double> thickness(found);
	if (!thickness.check()) throw std::invalid_argument(py::extract<std::string>(found)());
	return thickness();
}

template <int Dim> void openInto(Scene& scene, const PackedState<Dim>& s)
{
	PythonLock gil;
	for (std::size_t i = 0; i < s.size(); ++i) {
		const int id = s.grains->id[i];
		if (id >= int(scene.bodies->size()) || !(*scene.bodies)[id])
			throw std::invalid_argument("The sample cannot be opened: its scene lost body " + std::to_string(id) + ".");
		const auto& body                         = (*scene.bodies)[id];
		State&      motion                       = *body->state;
		motion.se3.position.template head<Dim>() = s.position[i];
		if constexpr (Dim == 2) motion.se3.orientation = orientationOf(s.orientation[i]);
		motion.vel = inSpace<Dim>(s.velocity[i]);
		if constexpr (Dim == 2) motion.angVel = Vector3r(0, 0, s.angularVelocity[i]);
		else motion.angVel = s.angularVelocity[i];
		static_cast<Sphere&>(*body->shape).radius = s.grains->radius[i] * s.radiusFactor;
	}
	scene.dt   = s.dt;
	scene.iter = long(s.step);
	if (isIceBondScene(scene))
		for (Body* body : presentBodies(scene)) {
			auto& material             = static_cast<IceBondMat&>(*body->material);
			material.iceSaturation     = s.iceSaturation;
			material.radiusRatio       = s.radiusFactor;
			material.radiusRatioBefore = s.radiusFactor;
			material.takeBonds(s.ice);
		}
	openCell(scene, s);
	openContacts(scene, s);
}

template void openInto<2>(Scene&, const PackedState<2>&);
template void openInto<3>(Scene&, const PackedState<3>&);

std::string sceneToBytes(const shared_ptr<Scene>& scene)
{
	std::ostringstream stream;
	{
		boost::archive::binary_oarchive archive(stream);
		shared_ptr<Scene>               held = scene;
		archive << boost::serialization::make_nvp("scene", held);
	}
	return stream.str();
}

shared_ptr<Scene> sceneFromBytes(const std::string& bytes, int threads)
{
	const int before = omp_get_max_threads();
	omp_set_num_threads(threads);
	shared_ptr<Scene> scene;
	try {
		std::istringstream              stream(bytes);
		boost::archive::binary_iarchive archive(stream);
		archive >> boost::serialization::make_nvp("scene", scene);
	} catch (...) {
		omp_set_num_threads(before);
		throw;
	}
	omp_set_num_threads(before);
	return scene;
}

shared_ptr<Scene> sceneFromFile(const std::string& content, bool xml)
{
	std::istringstream stream(content);
	stream.imbue(std::locale(std::locale(std::locale::classic(), new boost::archive::codecvt_null<char>), new boost::math::nonfinite_num_get<char>));
	shared_ptr<Scene> scene;
	const auto        read = [&](auto&& archive) { archive >> boost::serialization::make_nvp("scene", scene); };
	if (xml) read(boost::archive::xml_iarchive(stream, boost::archive::no_codecvt));
	else read(boost::archive::binary_iarchive(stream, boost::archive::no_codecvt));
	if (!scene) throw std::invalid_argument("it holds no scene");
	return scene;
}

shared_ptr<Scene> sceneForView(const std::string& bytes) { return sceneFromBytes(bytes, omp_get_max_threads()); }

shared_ptr<Scene> copyScene(const shared_ptr<Scene>& scene) { return sceneFromBytes(sceneToBytes(scene)); }

} // namespace talik
