// SPDX-License-Identifier: GPL-2.0-or-later
#include "RandomScene.hpp"

#include "Dice.hpp"

#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/MohrCoulombSkeleton.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace talik::stability {

namespace {

	template <int D> struct Draw {
		Dice              dice;
		RandomScene<D>&   scene;
		GroundSettings<D> s;
		double            softest     = INFINITY; ///< smallest Young's modulus [Pa]
		double            top         = 0.0;      ///< of the ground [m]
		int               cellsFilled = 0;

		void      motion();
		void      skeletons();
		void      heat();
		void      freezing();
		void      water();
		void      walls();
		void      surface();
		void      fill();
		void      body();
		void      movingWall();
		void      segregation();
		TimeTable weather(double from, double to);

		static Vec<D> along(double x, double y)
		{
			Vec<D> v {};
			v[0] = x, v[1] = y;
			return v;
		}
	};

	template <int D> void Draw<D>::motion()
	{
		s.motion.emplace();
		s.shapeFunction        = dice.oneOf<std::string>("shape", { "quadraticBSpline", "quadraticBSpline", "gimp", "quadraticBSpline" });
		const auto transfer    = dice.oneOf<std::string>("transfer", { "flip", "flip", "apic", "tpic" });
		s.motion->transfer     = velocityTransferFromName(transfer);
		s.motion->picTime      = dice.decades("picTime", 1e-6, 1e2);
		s.motion->localDamping = dice.chance("damped", 0.2) ? 0.7 : 0.0;
		s.motion->bBar         = !dice.chance("noCellMeans", 0.25);
		if (dice.chance("gravity", 0.7)) s.motion->gravity = along(dice.uniform(-3.0, 3.0), -9.81);
		s.courantNumber = dice.between("courantNumber", 0.1, 0.99);
	}

	template <int D> void Draw<D>::skeletons()
	{
		const int count = dice.chance("twoSkeletons", 0.4) ? 2 : 1;
		for (int k = 0; k < count; ++k) {
			// its own weight, applied at once, must not crush the ground
			const double weight  = 2700.0 * 10.4 * (s.upper[1] - s.lower[1]);
			const double modulus = dice.decades("E", std::max(1e6, 50.0 * weight), 1e10);
			softest              = std::min(softest, modulus);
			if (dice.chance("mohrCoulomb", 0.4)) {
				auto m             = std::make_shared<MohrCoulombSkeleton<D>>();
				m->young           = modulus;
				m->youngFrozen     = modulus * dice.decades("frozenRatio", 1.0, 100.0);
				m->poisson         = dice.between("nu", 0.0, 0.45);
				m->cohesion        = dice.decades("c", 1.0, 1e5);
				m->cohesionFrozen  = m->cohesion * dice.decades("cFrozenRatio", 1.0, 1e3);
				m->frictionAngle   = dice.between("phi", 0.0, 45.0);
				m->dilationAngle   = m->frictionAngle * dice.between("dilation", 0.0, 1.0);
				m->tensileStrength = m->tensileStrengthFrozen = 0.0;
				s.skeletons.push_back(m);
			} else {
				auto e     = std::make_shared<ElasticSkeleton<D>>();
				e->young   = modulus;
				e->poisson = dice.between("nu", -0.2, 0.49);
				s.skeletons.push_back(e);
			}
		}
	}

	template <int D> void Draw<D>::heat()
	{
		s.heat.emplace();
		s.heat->thermalTimeScale = dice.decades("fT", 1.0, 1e7);
		s.heatFraction           = dice.between("heatFraction", 0.1, 0.99);
		if (dice.chance("noSmoothing", 0.2)) s.heat->smoothingTime = INFINITY;
		if (!dice.chance("source", 0.1)) return;
		s.heat->source            = dice.between("Q", -0.2, 0.2) / (s.gridSpacing * s.gridSpacing); // some 10 K in 300 steps
		scene.temperaturesBounded = false;
	}

	template <int D> void Draw<D>::freezing()
	{
		const auto      name  = dice.oneOf<std::string>("curve", freezingCurveNames());
		const double    width = dice.decades("width", 1e-6, 1.0);
		CurveParameters p { { "residualSaturation", dice.between("Sr", 0.0, 0.3) } };
		if (name == "gauss" || name == "exponential") p["width"] = width;
		if (name == "linear") p["frozenTemperature"] = -width;
		if (name == "power") p["width"] = width;
		s.freezing = makeFreezingCurve(name, p);
	}

	template <int D> void Draw<D>::water()
	{
		s.water.emplace();
		auto& w                              = *s.water;
		w.permeability.referenceConductivity = dice.decades("k", 1e-16, 1e-2);
		w.permeability.impedance             = dice.between("Omega", 0.0, 10.0);
		w.state.liquidBulkModulus            = dice.decades("Kw", 1e7, 2.2e9);
		w.state.iceBulkModulus               = dice.chance("noIceStorage", 0.1) ? INFINITY : 4.0 * w.state.liquidBulkModulus;
		w.state.cavitationPressure           = dice.chance("suction", 0.3) ? -dice.decades("pCav", 1e3, 1e5) : 0.0;
		w.state.densityChange                = !dice.chance("noDensityChange", 0.3);
		w.picTime                            = dice.decades("picTimeOfLiquid", 1e-6, 1e2);
	}

	template <int D> void Draw<D>::walls()
	{
		// all but the side that y points to, which is up here in space too
		std::vector<std::string> sides = sideNames(D);
		sides.erase(sides.begin() + 3);
		for (const std::string& side : sides) {
			if (!dice.chance(side.c_str(), 0.8)) {
				scene.open = true;
				continue;
			}
			if (dice.chance("fixed", 0.3)) s.boundaries.push_back(std::make_shared<FixedBoundary<D>>(Region<D>::side(side)));
			else s.boundaries.push_back(std::make_shared<RollerBoundary<D>>(Region<D>::side(side)));
		}
	}

	/// Constant, or a sequence of jumps.
	template <int D> TimeTable Draw<D>::weather(double from, double to)
	{
		if (!dice.chance("jumps", 0.5)) return TimeTable(dice.between("level", from, to));
		std::vector<double> times, values;
		double              time  = 0.0;
		const double        pause = dice.decades("pause", 1e-4, 1.0) * (s.heat ? s.heat->thermalTimeScale : 1.0);
		for (int k = 0; k < 40; ++k) {
			times.push_back(time);
			values.push_back(dice.uniform(from, to));
			times.push_back(time + pause);
			values.push_back(values.back());
			time += pause * 1.001;
		}
		return TimeTable(times, values);
	}

	template <int D> void Draw<D>::surface()
	{
		const auto keepTemperatures = [&](const TimeTable& table) {
			for (const double t : table.values())
				scene.coldest = std::min(scene.coldest, t), scene.hottest = std::max(scene.hottest, t);
		};
		if (s.heat && dice.chance("surfaceTemperature", 0.6)) {
			const TimeTable table = weather(-40.0, 40.0);
			keepTemperatures(table);
			const double h = dice.chance("air", 0.4) ? dice.decades("h", 0.1, 1e4) : INFINITY;
			s.boundaries.push_back(std::make_shared<SurfaceTemperature<D>>(Region<D>::freeSurface(), table, h));
		}
		if (s.heat && dice.chance("wallTemperature", 0.3)) {
			const TimeTable table = weather(-40.0, 40.0);
			keepTemperatures(table);
			s.boundaries.push_back(std::make_shared<WallTemperature<D>>(Region<D>::side(sideNames(D)[2]), table));
		}
		if (s.motion && dice.chance("traction", 0.5))
			s.boundaries.push_back(
			        std::make_shared<Traction<D>>(Region<D>::freeSurface(), TimeTable(softest * dice.decades("loadOverE", 1e-6, 1e-3))));
		if (s.water && dice.chance("drained", 0.5)) {
			s.boundaries.push_back(std::make_shared<DrainedBoundary<D>>(
			        Region<D>::freeSurface(), TimeTable(dice.between("pOut", 0.0, 1e4)), dice.chance("recharge", 0.5)));
			scene.energyAccounted = false;
		}
	}

	template <int D> void Draw<D>::fill()
	{
		const double h       = s.gridSpacing;
		const auto   cells   = [&](int axis) { return int(std::lround((s.upper[axis] - s.lower[axis]) / h)); };
		const int    perCell = dice.count("perDirection", 1, D == 2 ? 3 : 2);
		const int    rows = std::max(1, cells(1) - dice.count("emptyRows", 2, 4)), columns = std::max(1, cells(0) - (dice.chance("gap", 0.3) ? 2 : 0));
		const double jitter      = dice.chance("irregular", 0.3) ? dice.between("jitter", 0.0, 0.45) : 0.0;
		const double size        = h / perCell;
		const double temperature = dice.between("T", -20.0, 20.0),
		             gradient    = dice.chance("twoTemperatures", 0.3) ? dice.between("dT", -20.0, 20.0) : 0.0;
		const double pressure    = dice.chance("pressure", 0.5) ? dice.decades("p", 1.0, 1e5) : 0.0;
		const double speed       = s.motion && dice.chance("moving", 0.3) ? dice.between("machNumber", 0.0, 0.02) * std::sqrt(softest / 2000.0) : 0.0;
		scene.open               = scene.open || speed > 0.0; // loose ground that meets a wall splashes, and the box has no lid
		const double porosity    = dice.between("n", 0.1, 0.7);
		int          number      = 0;
		for (int k = 0; k < (D == 2 ? 1 : cells(D - 1) * perCell); ++k)
			for (int j = 0; j < rows * perCell; ++j)
				for (int i = 0; i < columns * perCell; ++i) {
					PointInput<D>            point;
					const std::array<int, 3> at { i, j, k };
					for (int a = 0; a < D; ++a)
						point.position[a] = s.lower[a] + (at[a] + 0.5 + dice.uniform(-jitter, jitter)) * size;
					point.volume      = std::pow(size, D);
					point.porosity    = porosity;
					point.temperature = temperature + (2 * i < columns * perCell ? gradient : 0.0);
					point.pressure    = pressure;
					point.velocity    = along(speed, -0.3 * speed);
					point.skeleton    = s.skeletons.empty() ? 0 : number++ % int(s.skeletons.size());
					scene.coldest     = std::min(scene.coldest, point.temperature);
					scene.hottest     = std::max(scene.hottest, point.temperature);
					scene.ground->addPoint(point);
				}
		top         = s.lower[1] + rows * h + jitter * size;
		cellsFilled = rows * columns * (D == 2 ? 1 : cells(D - 1));
	}

	/// A ball or a box, driven or free, a little above the ground and coming down.
	template <int D> void Draw<D>::body()
	{
		auto& contact      = scene.ground->settings().bodies.emplace();
		contact.damping    = dice.between("contactDamping", 0.0, 0.9);
		contact.shearRatio = dice.between("shearRatio", 0.1, 1.0);
		if (dice.chance("contactStiffness", 0.3)) contact.stiffness = softest / s.gridSpacing * dice.decades("kOverE", 0.1, 10.0);
		RigidBody<D>& b = scene.drawn;
		b.id = b.group = 0;
		b.shape        = dice.chance("ball", 0.5) ? &rigidBall<D>() : &rigidBox<D>();
		b.friction     = dice.between("friction", 0.0, 1.0);
		for (int a = 0; a < D; ++a) {
			b.axes[a][a]  = 1.0;
			b.size[a]     = s.gridSpacing * dice.decades("half", 0.05, 3.0);
			b.position[a] = s.lower[a] + dice.between("at", 0.0, 1.0) * (s.upper[a] - s.lower[a]);
		}
		const double reach = b.shape->reach(b.size)[1];
		b.position[1]      = top + reach + s.gridSpacing * dice.between("above", 0.0, 0.2);
		// whoever drives it must not crush the ground
		const bool   driven = dice.chance("driven", 0.3);
		const double speed  = (driven ? 2e-3 : 0.02) * dice.between("bodySpeed", 0.0, 1.0) * std::sqrt(softest / 2000.0);
		b.velocity          = along(speed * dice.uniform(-1.0, 1.0), -speed);
		if (driven) return;
		scene.body.mass = 2700.0 * std::pow(s.gridSpacing, D) * cellsFilled * dice.decades("massOfGround", 1e-2, 1.0);
	}

	/// One of the walls moves: pushes, gives way, shears or shakes.
	template <int D> void Draw<D>::movingWall()
	{
		auto&                    boundaries = scene.ground->settings().boundaries;
		std::vector<std::size_t> walls;
		for (std::size_t k = 0; k < boundaries.size(); ++k)
			if (boundaries[k]->name() == "RollerBoundary" || boundaries[k]->name() == "FixedBoundary") walls.push_back(k);
		if (walls.empty()) return;
		auto&           wall = boundaries[walls[dice.count("movingWallNumber", 0, int(walls.size()) - 1)]];
		const Region<D> side = wall->region();
		Vec<D>          direction {};
		const bool      rough = dice.chance("movingWallRough", 0.5);
		if (rough)
			for (double& component : direction)
				component = dice.uniform(-1.0, 1.0);
		// in 300 steps less than half a cell, and less than a twentieth of the box
		const double cells    = std::lround((s.upper[side.on.axis] - s.lower[side.on.axis]) / s.gridSpacing);
		const double fastest  = 1.4e-3 * std::min(1.0, 0.1 * cells) * dice.between("movingWallSpeed", 0.0, 1.0) * std::sqrt(softest / 2000.0);
		const double standing = dice.chance("movingWallAhead", 0.2) ? dice.between("ahead", 0.0, 0.05) * s.gridSpacing : 0.0;
		wall                  = std::make_shared<MovingBoundary<D>>(side, weather(-fastest, fastest), direction, rough, standing);
	}

	/// By a potential of soils or far beyond, or by permeability, curve and load.
	template <int D> void Draw<D>::segregation()
	{
		auto& drawn = scene.ground->settings().segregation.emplace();
		if (!dice.chance("potentialGiven", 0.7)) return;
		drawn.segregationPotential = dice.decades("SP", 1e-12, 1e-7);
		drawn.pressureDecay        = dice.chance("decays", 0.5) ? dice.decades("a", 1e-7, 1e-4) : 0.0;
	}

} // namespace

template <int D> RandomScene<D>::RandomScene(std::uint64_t seed, bool wallsRest, bool segregates)
{
	Draw<D> d { Dice(seed), *this, {} };
	d.s.gridSpacing = d.dice.decades("h", 0.02, 1.0);
	for (int a = 0; a < D; ++a) {
		const char* name = a == 0 ? "nx" : a == 1 ? "ny" : "nz";
		d.s.upper[a]     = d.s.gridSpacing
		        * (D == 2 ? d.dice.count(name, a == 1 ? 3 : 1, a == 1 ? 12 : 8) : d.dice.count(name, a == 1 ? 3 : 1, a == 1 ? 7 : 3));
	}
	d.s.energyLedger = true;
	const bool moves = d.dice.chance("motion", 0.85), wet = moves && d.dice.chance("water", 0.6), warm = !moves || d.dice.chance("heat", 0.7);
	if (moves) d.motion(), d.skeletons();
	if (warm) d.heat();
	if (warm && d.dice.chance("freezing", 0.7)) d.freezing();
	if (wet) d.water();
	if (moves) d.walls();
	d.surface();
	ground = std::make_unique<Ground<D>>(d.s);
	d.fill();
	steps = d.dice.count("steps", 100, 300);
	if (moves && d.dice.chance("body", 0.3)) d.body();
	// last, so that the rest of a scene does not depend on it
	if (moves && !wallsRest && d.dice.chance("movingWall", 0.25)) d.movingWall();
	if (segregates && d.s.motion && d.s.motion->bBar && d.s.water && d.s.freezing) d.segregation();
	described = d.dice.text();
}

template <int D> bool RandomScene<D>::solvePressure()
{
	auto& s = ground->settings();
	if (!s.water || !s.motion->bBar) return false;
	s.water->implicit = true;
	return true;
}

template <int D> void RandomScene<D>::start()
{
	ground->initialise();
	body.contact = ground->bodies();
	if (body.contact) body.contact->bodies = { drawn };
}

template struct RandomScene<2>;
template struct RandomScene<3>;

} // namespace talik::stability
