// SPDX-License-Identifier: GPL-2.0-or-later
#include "RandomScene.hpp"

#include <pkg/mpm/Boundaries.hpp>
#include <pkg/mpm/ElasticSkeleton.hpp>
#include <pkg/mpm/MohrCoulombSkeleton.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

namespace talik::stability {

namespace {

	/// Draws and writes down what it drew.
	class Dice {
	public:
		explicit Dice(std::uint64_t seed)
		        : generator_(seed)
		{
		}
		double uniform(double from, double to) { return from + (to - from) * static_cast<double>(generator_() >> 11) * 0x1p-53; }
		double between(const char* name, double from, double to) { return noted(name, uniform(from, to)); }
		/// Every decade is as likely as another.
		double decades(const char* name, double from, double to) { return noted(name, from * std::pow(to / from, uniform(0.0, 1.0))); }
		int    count(const char* name, int from, int to) { return static_cast<int>(noted(name, from + std::floor(uniform(0.0, to - from + 1.0)))); }
		/// True with the probability given; the name is written down if it comes true.
		bool chance(const char* name, double probability)
		{
			const bool comes = uniform(0.0, 1.0) < probability;
			if (comes) text_ << ' ' << name;
			return comes;
		}
		template <class T> T oneOf(const char* name, const std::vector<T>& choices)
		{
			const T& choice = choices[std::min(choices.size() - 1, static_cast<std::size_t>(uniform(0.0, choices.size())))];
			text_ << ' ' << name << '=' << choice;
			return choice;
		}
		std::string text() const { return text_.str(); }

	private:
		double noted(const char* name, double value)
		{
			text_ << ' ' << name << '=' << value;
			return value;
		}
		std::mt19937_64    generator_;
		std::ostringstream text_;
	};

	struct Draw {
		Dice              dice;
		RandomScene&      scene;
		GroundSettings<2> s;
		double            softest = INFINITY; ///< smallest Young's modulus [Pa]

		void motion();
		void skeletons();
		void heat();
		void freezing();
		void water();
		void walls();
		void surface();
		void fill();
		TimeTable weather(double from, double to);
	};

	void Draw::motion()
	{
		s.motion.emplace();
		s.shapeFunction       = dice.oneOf<std::string>("shape", { "quadraticBSpline", "quadraticBSpline", "gimp", "linear" });
		const auto transfer   = dice.oneOf<std::string>("transfer", { "flip", "flip", "apic", "tpic" });
		s.motion->transfer    = velocityTransferFromName(transfer == "apic" && s.shapeFunction == "linear" ? "tpic" : transfer);
		s.motion->flipFraction  = dice.between("flip", 0.0, 1.0);
		s.motion->localDamping  = dice.chance("damped", 0.2) ? 0.7 : 0.0;
		s.motion->cellAveraging = !dice.chance("noCellMeans", 0.25);
		if (dice.chance("gravity", 0.7)) s.motion->gravity = { dice.uniform(-3.0, 3.0), -9.81 };
		s.waveFraction = dice.between("waveFraction", 0.1, 0.99);
	}

	void Draw::skeletons()
	{
		const int count = dice.chance("twoSkeletons", 0.4) ? 2 : 1;
		for (int k = 0; k < count; ++k) {
			// its own weight, applied at once, must not crush the ground
			const double weight  = 2700.0 * 10.4 * (s.upper[1] - s.lower[1]);
			const double modulus = dice.decades("E", std::max(1e6, 50.0 * weight), 1e10);
			softest              = std::min(softest, modulus);
			if (dice.chance("mohrCoulomb", 0.4)) {
				auto m                = std::make_shared<MohrCoulombSkeleton<2>>();
				m->youngModulus       = modulus;
				m->youngModulusFrozen = modulus * dice.decades("frozenRatio", 1.0, 100.0);
				m->poissonRatio       = dice.between("nu", 0.0, 0.45);
				m->cohesion           = dice.decades("c", 1.0, 1e5);
				m->cohesionFrozen     = m->cohesion * dice.decades("cFrozenRatio", 1.0, 1e3);
				m->frictionAngle      = dice.between("phi", 0.0, 45.0);
				m->dilationAngle      = m->frictionAngle * dice.between("dilation", 0.0, 1.0);
				m->tensileStrength = m->tensileStrengthFrozen = 0.0;
				s.skeletons.push_back(m);
			} else {
				auto e          = std::make_shared<ElasticSkeleton<2>>();
				e->youngModulus = modulus;
				e->poissonRatio = dice.between("nu", -0.2, 0.49);
				s.skeletons.push_back(e);
			}
		}
	}

	void Draw::heat()
	{
		s.heat.emplace();
		s.heat->thermalTimeScale = dice.decades("fT", 1.0, 1e7);
		s.heatFraction           = dice.between("heatFraction", 0.1, 0.99);
		if (dice.chance("noSmoothing", 0.2)) s.heat->smoothingTime = INFINITY;
		if (!dice.chance("source", 0.1)) return;
		s.heat->source            = dice.between("Q", -0.2, 0.2) / (s.gridSpacing * s.gridSpacing); // some 10 K in 300 steps
		scene.temperaturesBounded = false;
	}

	void Draw::freezing()
	{
		const auto      name  = dice.oneOf<std::string>("curve", freezingCurveNames());
		const double    width = dice.decades("width", 1e-6, 1.0);
		CurveParameters p { { "residualSaturation", dice.between("Sr", 0.0, 0.3) } };
		if (name == "gauss" || name == "exponential") p["width"] = width;
		if (name == "linear") p["frozenTemperature"] = -width;
		if (name == "power") p["scale"] = width;
		s.freezing = makeFreezingCurve(name, p);
	}

	void Draw::water()
	{
		s.water.emplace();
		auto& w                                = *s.water;
		w.permeability.referenceConductivity   = dice.decades("k", 1e-16, 1e-2);
		w.permeability.impedance               = dice.between("Omega", 0.0, 10.0);
		w.state.liquidBulkModulus              = dice.decades("Kw", 1e7, 2.2e9);
		w.state.iceBulkModulus                 = dice.chance("noIceStorage", 0.1) ? INFINITY : 4.0 * w.state.liquidBulkModulus;
		w.state.cavitationPressure             = dice.chance("suction", 0.3) ? -dice.decades("pCav", 1e3, 1e5) : 0.0;
		w.state.densityChange                  = !dice.chance("noDensityChange", 0.3);
		w.flipFraction                         = dice.between("flipLiquid", 0.0, 1.0);
	}

	void Draw::walls()
	{
		for (const char* side : { "left", "right", "bottom" }) {
			if (!dice.chance(side, 0.8)) {
				scene.open = true;
				continue;
			}
			if (dice.chance("fixed", 0.3)) s.boundaries.push_back(std::make_shared<FixedBoundary<2>>(Region<2>::side(side)));
			else
				s.boundaries.push_back(std::make_shared<RollerBoundary<2>>(Region<2>::side(side)));
		}
	}

	/// Constant, or a sequence of jumps.
	TimeTable Draw::weather(double from, double to)
	{
		if (!dice.chance("jumps", 0.5)) return TimeTable(dice.between("level", from, to));
		std::vector<double> times, values;
		double              time = 0.0;
		const double        pause = dice.decades("pause", 1e-4, 1.0);
		for (int k = 0; k < 40; ++k) {
			times.push_back(time);
			values.push_back(dice.uniform(from, to));
			times.push_back(time + pause);
			values.push_back(values.back());
			time += pause * 1.001;
		}
		return TimeTable(times, values);
	}

	void Draw::surface()
	{
		const auto keepTemperatures = [&](const TimeTable& table) {
			for (const double t : table.values())
				scene.coldest = std::min(scene.coldest, t), scene.hottest = std::max(scene.hottest, t);
		};
		if (s.heat && dice.chance("surfaceTemperature", 0.6)) {
			const TimeTable table = weather(-40.0, 40.0);
			keepTemperatures(table);
			const double h = dice.chance("air", 0.4) ? dice.decades("h", 0.1, 1e4) : INFINITY;
			s.boundaries.push_back(std::make_shared<SurfaceTemperature<2>>(Region<2>::freeSurface(), table, h));
		}
		if (s.heat && dice.chance("wallTemperature", 0.3)) {
			const TimeTable table = weather(-40.0, 40.0);
			keepTemperatures(table);
			s.boundaries.push_back(std::make_shared<WallTemperature<2>>(Region<2>::side("bottom"), table));
		}
		if (s.motion && dice.chance("traction", 0.5))
			s.boundaries.push_back(std::make_shared<Traction<2>>(Region<2>::freeSurface(), TimeTable(softest * dice.decades("loadOverE", 1e-6, 1e-3))));
		if (s.water && dice.chance("drained", 0.5)) {
			s.boundaries.push_back(std::make_shared<DrainedBoundary<2>>(
			        Region<2>::freeSurface(), TimeTable(dice.between("pOut", 0.0, 1e4)), dice.chance("recharge", 0.5)));
			scene.energyAccounted = false;
		}
	}

	void Draw::fill()
	{
		const double h  = s.gridSpacing;
		const int    nx = static_cast<int>(std::lround((s.upper[0] - s.lower[0]) / h));
		const int    ny = static_cast<int>(std::lround((s.upper[1] - s.lower[1]) / h));
		const int    perCell = dice.count("perDirection", 1, 3);
		const int    rows = std::max(1, ny - dice.count("emptyRows", 2, 4)), columns = std::max(1, nx - (dice.chance("gap", 0.3) ? 2 : 0));
		const double jitter = dice.chance("irregular", 0.3) ? dice.between("jitter", 0.0, 0.45) : 0.0;
		const double size = h / perCell;
		const double temperature = dice.between("T", -20.0, 20.0), gradient = dice.chance("twoTemperatures", 0.3) ? dice.between("dT", -20.0, 20.0) : 0.0;
		const double pressure = dice.chance("pressure", 0.5) ? dice.decades("p", 1.0, 1e5) : 0.0;
		const double speed = s.motion && dice.chance("moving", 0.3) ? dice.between("machNumber", 0.0, 0.02) * std::sqrt(softest / 2000.0) : 0.0;
		const double porosity = dice.between("n", 0.1, 0.7);
		// one row of cells shows no gradient of pressure: its water percolates on the spot, and drag spends what nobody gave
		if (rows == 1 && s.water && s.motion->gravity[1] != 0.0) scene.energyAccounted = false;
		int number = 0;
		for (int j = 0; j < rows * perCell; ++j)
			for (int i = 0; i < columns * perCell; ++i) {
				PointInput<2> point;
				point.position = { s.lower[0] + (i + 0.5 + dice.uniform(-jitter, jitter)) * size, s.lower[1] + (j + 0.5 + dice.uniform(-jitter, jitter)) * size };
				point.volume      = size * size;
				point.porosity    = porosity;
				point.temperature = temperature + (2 * i < columns * perCell ? gradient : 0.0);
				point.pressure    = pressure;
				point.velocity    = { speed, -0.3 * speed };
				point.skeleton    = s.skeletons.empty() ? 0 : number++ % static_cast<int>(s.skeletons.size());
				scene.coldest     = std::min(scene.coldest, point.temperature);
				scene.hottest     = std::max(scene.hottest, point.temperature);
				scene.ground->addPoint(point);
			}
	}

} // namespace

RandomScene::RandomScene(std::uint64_t seed)
{
	Draw d { Dice(seed), *this, {}, INFINITY };
	d.s.gridSpacing  = d.dice.decades("h", 0.02, 1.0);
	d.s.upper        = { d.s.gridSpacing * d.dice.count("nx", 1, 8), d.s.gridSpacing * d.dice.count("ny", 3, 12) };
	d.s.energyLedger = true;
	const bool moves = d.dice.chance("motion", 0.85), wet = moves && d.dice.chance("water", 0.6), warm = !moves || d.dice.chance("heat", 0.7);
	if (moves) d.motion(), d.skeletons();
	if (warm) d.heat();
	if (warm && d.dice.chance("freezing", 0.7)) d.freezing();
	if (wet) d.water();
	if (moves) d.walls();
	d.surface();
	ground = std::make_unique<Ground<2>>(d.s);
	d.fill();
	steps     = d.dice.count("steps", 100, 300);
	described = d.dice.text();
}

} // namespace talik::stability
