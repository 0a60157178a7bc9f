// SPDX-License-Identifier: GPL-2.0-or-later
// Walls of given velocity against Hooke's law, the standing wave of a column on a shaken base, Rankine's earth pressure, slip along a thaw
// front that a wall drives, and balances.
#include "Report.hpp"
#include "Slab.hpp"

#include <gtest/gtest.h>

#include <sstream>

using namespace talik;
using namespace talik::validation;

namespace {

template <int D> GroundSettings<D> dryBox(double spacing, const Vec<D>& size)
{
	GroundSettings<D> s;
	s.upper        = size;
	s.gridSpacing  = spacing;
	s.mixture      = withoutExpansion();
	s.energyLedger = true;
	s.motion.emplace();
	s.motion->gravity = {};
	return s;
}

template <int D> std::shared_ptr<ElasticSkeleton<D>> elastic(double young, double poisson)
{
	auto skeleton     = std::make_shared<ElasticSkeleton<D>>();
	skeleton->young   = young;
	skeleton->poisson = poisson;
	return skeleton;
}

template <int D, class B, class... Arguments> void add(GroundSettings<D>& s, const char* side, Arguments&&... arguments)
{
	s.boundaries.push_back(std::make_shared<B>(Region<D>::side(side), std::forward<Arguments>(arguments)...));
}

/// Two points per cell and direction from one corner to the other.
template <int D> void fillBlock(Ground<D>& ground, const Vec<D>& lower, const Vec<D>& upper, const PointPreparation<D>& prepare = {})
{
	const double       step = 0.5 * ground.settings().gridSpacing;
	std::array<int, D> count, i {};
	for (int a = 0; a < D; ++a)
		count[a] = int(std::lround((upper[a] - lower[a]) / step));
	for (int a = 0; a < D;) {
		PointInput<D> point;
		for (int k = 0; k < D; ++k)
			point.position[k] = lower[k] + (i[k] + 0.5) * step;
		point.volume = std::pow(step, D);
		if (prepare) prepare(point);
		ground.addPoint(point);
		for (a = 0; a < D && ++i[a] == count[a]; ++a)
			i[a] = 0;
	}
}

/// Speed that grows in a tenth of the time, stays, and ends at the path.
TimeTable pushing(double path, double duration)
{
	const double speed = path / (0.9 * duration);
	return TimeTable({ 0.0, 0.1 * duration, 0.9 * duration, duration }, { 0.0, speed, speed, 0.0 });
}

template <int D> double notAccountedFor(const Balance<D>& b)
{
	return (b.wallWork - b.kineticEnergy - b.skeletonWork - b.porePressureWork - b.dragDissipation - b.dampingDissipation) / b.wallWork;
}

template <int D> Ground<D> pushedColumn(double young, double poisson, double path, bool wet, bool implicit = false, double bulkModulus = 2.2e7)
{
	const int cells = 20;
	Vec<D>    size;
	size.fill(1.0 / cells);
	size[0]                = 1.0;
	auto s                 = dryBox<D>(1.0 / cells, size);
	s.motion->localDamping = 0.2;
	s.skeletons.push_back(elastic<D>(young, poisson));
	if (wet) {
		s.water.emplace();
		s.water->implicit                           = implicit;
		s.water->state.liquidBulkModulus            = bulkModulus;
		s.water->state.iceBulkModulus               = 4.0 * bulkModulus;
		s.water->state.cavitationPressure           = -1e6;
		s.water->permeability.referenceConductivity = 1e-6;
	}
	for (const std::string& side : sideNames(D))
		if (side != "right") add<D, RollerBoundary<D>>(s, side.c_str());
	const double duration = 1.0;
	add<D, MovingBoundary<D>>(s, "right", pushing(path, duration), Vec<D> {}, false);
	Ground<D> ground(s);
	fillBlock<D>(ground, s.lower, s.upper);
	ground.initialise();
	marchTo(ground, duration);
	return ground;
}

/// Change of the mean temperature [K] of frozen ground at -5 degC that a wall pushes by a path; no heat crosses its boundary.
double warmingByStrain(double path, bool wet, const char* curve)
{
	auto s     = dryBox<2>(0.1, { 1.0, 0.1 });
	s.freezing = makeFreezingCurve(curve);
	s.heat.emplace();
	s.motion->localDamping = 0.2;
	s.skeletons.push_back(elastic<2>(1e7, 0.3));
	if (wet) s.water.emplace();
	for (const char* side : { "left", "bottom", "top" })
		add<2, RollerBoundary<2>>(s, side);
	add<2, MovingBoundary<2>>(s, "right", pushing(path, 0.3), Vec<2> {}, false);
	Ground<2> ground(s);
	fillBlock<2>(ground, s.lower, s.upper, [](PointInput<2>& p) { p.temperature = -5.0; });
	ground.initialise();
	marchTo(ground, 0.3);
	const auto t    = valuesOf(ground, "temperature");
	double     mean = 0.0;
	for (const double value : t)
		mean += value / t.size();
	return mean + 5.0;
}

template <int D> void expectConfinedCompression(const std::string& where)
{
	const double young = 1e7, poisson = 0.3, path = 0.02, modulus = young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
	auto         ground    = pushedColumn<D>(young, poisson, path, false);
	const auto   stress    = valuesOf(ground, "stress");
	const double reference = modulus * std::log(1.0 - path), lateral = poisson / (1.0 - poisson);
	double       mean = 0.0, worst = 0.0, area = std::pow(0.05, D - 1);
	for (const double value : stress) {
		mean += value / stress.size();
		worst = std::max(worst, std::abs(value / reference - 1.0));
	}
	const std::string name = "column pushed by a wall, " + where + ": ";
	citing("Hooke, confined modulus");
	expectRelative(name + "mean axial stress [Pa]", mean, reference, 5e-3);
	expectSmall(name + "largest error of a point's stress", worst, 5e-2);
	expectRelative(name + "mean lateral stress [Pa]", sumOf(ground, "stress", 1) / stress.size(), lateral * reference, 5e-3);
	const double work = area * modulus * ((1.0 - path) * std::log(1.0 - path) + path);
	expectRelative(name + "work of the wall [J]", ground.balance().wallWork, work, 1e-2);
}

} // namespace

// Ice at -5 degC neither forms nor melts because the ground is strained: without heat its temperature stays
TEST(MovingWalls, FrozenGroundThatIsStrainedWithoutHeatKeepsItsTemperature)
{
	for (const char* curve : { "sharp", "gauss" })
		for (const bool wet : { false, true })
			for (const double path : { 0.01, -0.01 }) {
				std::ostringstream name;
				name << "frozen ground, " << curve << (wet ? ", with pore water" : "") << ", " << (path > 0.0 ? "pushed" : "pulled")
				     << " by 1 % without heat: warming [K]";
				expectSmall(name.str(), warmingByStrain(path, wet, curve), 1e-3);
			}
}

TEST(MovingWalls, ColumnPushedSlowlyHasTheStressOfConfinedCompression)
{
	expectConfinedCompression<2>("plane");
	expectConfinedCompression<3>("space");
}

namespace {

template <int D> void expectPressureOfWater(const std::string& name, double path, bool implicit, double bulkModulus)
{
	const double porosity = PointInput<D>().porosity;
	auto         ground   = pushedColumn<D>(1e6, 0.0, path, true, implicit, bulkModulus);
	const auto   b        = ground.balance();
	citing("bulk modulus of water");
	expectRelative(name + ": mean pressure [Pa]", sumOf(ground, "pressure") / ground.points().count(), bulkModulus * path / porosity, 1e-2);
	expectSmall(name + ": work of the wall not accounted for", notAccountedFor(b), 2e-2);
}

} // namespace

TEST(MovingWalls, SaturatedColumnPushedFastHasThePressureOfItsWater)
{
	expectPressureOfWater<2>("saturated column pushed by a wall", 0.01, false, 2.2e7);
	// with the path of the first the wall is a fifth of a cell ahead of its nodes
	expectPressureOfWater<2>("saturated column pushed by a wall, implicit pressure, K_w = 2.2e+07", 0.01, true, 2.2e7);
	expectPressureOfWater<2>("saturated column pushed by a wall, implicit pressure, K_w = 2.2e+09", 1e-3, true, 2.2e9);
	expectPressureOfWater<3>("saturated column pushed by a wall in space, implicit pressure, K_w = 2.2e+09", 1e-3, true, 2.2e9);
}

TEST(MovingWalls, LayerShearedByARoughWallHasTheStressOfSimpleShear)
{
	const double      young = 1e7, poisson = 0.25, shear = young / (2.0 * (1.0 + poisson)), path = 0.03, height = 0.6, length = 6.0;
	GroundSettings<2> s    = dryBox<2>(0.1, { length + 1.0, height });
	s.motion->localDamping = 0.2;
	s.skeletons.push_back(elastic<2>(young, poisson));
	add<2, FixedBoundary<2>>(s, "bottom");
	add<2, MovingBoundary<2>>(s, "top", pushing(path, 1.0), Vec<2> { 3.0, 0.0 }, true);
	Ground<2> ground(s);
	fillBlock<2>(ground, { 0.5, 0.0 }, { length + 0.5, height });
	ground.initialise();
	marchTo(ground, 1.0);
	const auto x = valuesOf(ground, "position", 0), stress = valuesOf(ground, "stress", 3);
	double     sum = 0.0, count = 0.0;
	for (std::size_t p = 0; p < x.size(); ++p)
		if (std::abs(x[p] - 0.5 * length - 0.5) < 1.0) sum += stress[p], count += 1.0;
	citing("Hooke");
	expectRelative("layer sheared by a rough wall: shear stress at mid-length [Pa]", sum / count, shear * path / height, 1e-2);
	expectSmall("layer sheared by a rough wall: work of the wall not accounted for", notAccountedFor(ground.balance()), 2e-2);
}

// Base at U (1 - cos wt): u = U (1 - cos(w (H - y)/c)/cos(w H/c) cos wt), from rest with the stress that goes with it
TEST(MovingWalls, ColumnOnAShakenBaseVibratesAsTheStandingWave)
{
	const int         cells   = 20;
	const double      modulus = 1e7, density = 2650.0 * 0.6, height = 1.0, h = height / cells, amplitude = 0.02 * h;
	const double      speed = std::sqrt(modulus / density), omega = 0.8 * speed / height, period = 2.0 * M_PI / omega;
	GroundSettings<2> s = dryBox<2>(h, { h, height + 2.0 * h });
	s.motion->picTime   = std::numeric_limits<double>::infinity();
	s.skeletons.push_back(elastic<2>(modulus, 0.0));
	s.poreFill = 0.0;
	add<2, RollerBoundary<2>>(s, "left");
	add<2, RollerBoundary<2>>(s, "right");
	std::vector<double> times, speeds;
	for (int k = 0; k <= 800; ++k) {
		times.push_back(2.0 * period * k / 800);
		speeds.push_back(amplitude * omega * std::sin(omega * times.back()));
	}
	add<2, MovingBoundary<2>>(s, "bottom", TimeTable(times, speeds), Vec<2> {}, false);
	const auto shape = [&](double y) { return std::cos(omega * (height - y) / speed) / std::cos(omega * height / speed); };
	const auto slope = [&](double y) { return omega / speed * std::sin(omega * (height - y) / speed) / std::cos(omega * height / speed); };
	Ground<2>  ground(s);
	fillBox(ground, { 0.0, 0.0 }, { h, height }, [&](PointInput<2>& p) { p.stress[1] = -modulus * amplitude * slope(p.position[1]); });
	ground.initialise();
	const auto   start = valuesOf(ground, "position", 1);
	const double top   = amplitude * shape(height);
	double       worst = 0.0;
	Drawing      drawing("shaken_base", "Column on a base that shakes, displacement of its top and base", "periods", "displacement over that of the base");
	for (int k = 1; k <= 32; ++k) {
		const double time = 2.0 * period * k / 32;
		marchTo(ground, time);
		const auto moved = valuesOf(ground, "displacement", 1);
		for (std::size_t p = 0; p < start.size(); ++p) {
			const double exact = amplitude * (1.0 - shape(start[p]) * std::cos(omega * time)) - amplitude * (1.0 - shape(start[p]));
			worst              = std::max(worst, std::abs(moved[p] - exact) / (2.0 * top));
		}
		drawing.computed("top", time / period, moved.back() / amplitude);
		drawing.reference("top", time / period, shape(start.back()) * (1.0 - std::cos(omega * time)));
		drawing.computed("base", time / period, moved.front() / amplitude);
		drawing.reference("base", time / period, shape(start.front()) * (1.0 - std::cos(omega * time)));
	}
	citing("standing wave; Kramer 1996, 7.2");
	expectSmall("column on a shaken base: largest error of a displacement over the range of the top", worst, 3e-2);
}

namespace {

/// Block between rough walls that move along themselves with it: thawed and frozen, with water if wet.
template <int D> void expectRigidTranslation(const std::string& name, bool freezing, bool wet)
{
	const int    up = D - 1;
	const double h = 0.1, velocity = 2.0;
	Vec<D>       size;
	size.fill(2 * h);
	size[0]  = 6 * h;
	size[up] = 24 * h;
	auto s   = dryBox<D>(h, size);
	auto law = std::make_shared<MohrCoulombSkeleton<D>>();
	s.skeletons.push_back(law);
	if (freezing) {
		s.heat.emplace();
		s.freezing = makeFreezingCurve();
	}
	if (wet) s.water.emplace();
	Vec<D> along {};
	along[up] = 1.0;
	for (const char* side : { "left", "right" })
		add<D, MovingBoundary<D>>(s, side, velocity, along, true);
	if (D == 3)
		for (const char* side : { "front", "back" })
			add<D, MovingBoundary<D>>(s, side, velocity, along, true);
	Ground<D> ground(s);
	Vec<D>    from = s.lower, to = s.upper;
	from[up] = 3 * h;
	to[up]   = 9 * h;
	fillBlock<D>(ground, from, to, [&](PointInput<D>& p) {
		p.velocity[up] = velocity;
		p.temperature  = p.position[0] < 0.5 * size[0] ? -5.0 : 5.0;
	});
	ground.initialise();
	const double before = ground.balance().kineticEnergy;
	marchTo(ground, 0.5);
	double worst = 0.0;
	for (int a = 0; a < D; ++a)
		for (const double v : valuesOf(ground, "velocity", a))
			worst = std::max(worst, std::abs(v - (a == up ? velocity : 0.0)) / velocity);
	expectSmall(name + ": largest difference of a velocity from that of the walls, relative", worst, 1e-9);
	expectSmall(name + ": work of the walls over kinetic energy", ground.balance().wallWork / before, 1e-9);
}

} // namespace

TEST(MovingWalls, GroundBetweenWallsOfItsOwnVelocityStaysAsItIs)
{
	citing("Galilean invariance");
	expectRigidTranslation<2>("block that rides with its walls, dry", false, false);
	expectRigidTranslation<2>("block that rides with its walls, half frozen", true, false);
	expectRigidTranslation<3>("block that rides with its walls, in space", false, false);
}

namespace {

/// Dry sand at rest on a smooth base, whose right wall moves by a path into it or (negative) back: thrust of the wall during the last third of
/// its path over the weight gamma H^2/2, H as high as the ground has become.
double earthPressure(double friction, double path)
{
	const double      h = 0.1, length = 2.0, depth = 1.0, unitWeight = 2650.0 * 0.6 * 9.81, duration = 2.0;
	const double      ahead = std::max(0.0, -path), width = length - ahead;
	GroundSettings<2> s    = dryBox<2>(h, { length, depth + 2.0 * h });
	s.poreFill             = 0.0;
	s.motion->gravity      = { 0.0, -9.81 };
	s.motion->localDamping = 0.3;
	auto law               = std::make_shared<MohrCoulombSkeleton<2>>();
	law->young             = 2e7;
	law->poisson           = 0.25;
	law->frictionAngle     = friction;
	law->cohesion          = 0.0;
	s.skeletons.push_back(law);
	add<2, RollerBoundary<2>>(s, "left");
	add<2, RollerBoundary<2>>(s, "bottom");
	add<2, MovingBoundary<2>>(s, "right", pushing(path, duration), Vec<2> {}, false, ahead);
	Ground<2>    ground(s);
	const int    across = 40, up = 20;
	const double dx = width / across, dy = depth / up;
	for (int j = 0; j < up; ++j)
		for (int i = 0; i < across; ++i) {
			PointInput<2> p;
			p.position  = { (i + 0.5) * dx, (j + 0.5) * dy };
			p.volume    = dx * dy;
			p.stress[1] = -unitWeight * (depth - p.position[1]);
			p.stress[0] = p.stress[2] = 0.5 * p.stress[1];
			ground.addPoint(p);
		}
	ground.initialise();
	marchTo(ground, 0.6 * duration);
	const double before = ground.balance().wallWork;
	marchTo(ground, 0.9 * duration);
	const double thrust = (ground.balance().wallWork - before) / (path / 3.0), height = depth * width / (width - path * 0.8);
	return thrust / (0.5 * unitWeight * depth * height);
}

} // namespace

TEST(MovingWalls, WallThatIsPushedIntoSandOrGivesWayHasRankinesEarthPressure)
{
	for (const double friction : { 25.0, 35.0 }) {
		const double      passive = std::pow(std::tan((45.0 + 0.5 * friction) * M_PI / 180.0), 2);
		const std::string name    = friction == 25.0 ? "smooth wall and dry sand of 25 degrees: " : "smooth wall and dry sand of 35 degrees: ";
		citing("Rankine 1857");
		expectRelative(name + "passive coefficient", earthPressure(friction, 0.04), passive, 5e-2);
		expectRelative(name + "active coefficient", earthPressure(friction, -0.04), 1.0 / passive, 5e-2);
	}
}

namespace {

/// Box with a thaw front and gravity downwards, walls still to be added.
GroundSettings<2> freezingBox(double spacing, const Vec<2>& size, double gravity, std::shared_ptr<MohrCoulombSkeleton<2>> law)
{
	GroundSettings<2> s = dryBox<2>(spacing, size);
	s.motion->gravity   = { 0.0, -gravity };
	s.heat.emplace();
	s.freezing = makeFreezingCurve();
	s.skeletons.push_back(law);
	return s;
}

/// Weight of the Slab's ground.
double unitWeight() { return Slab().density() * Slab::gravity; }

/// Law of ground without cohesion when thawed, that nothing breaks when frozen.
std::shared_ptr<MohrCoulombSkeleton<2>> thawedSand(double friction)
{
	auto law                   = std::make_shared<MohrCoulombSkeleton<2>>();
	law->young                 = 20e6;
	law->youngFrozen           = 100e6;
	law->cohesion              = 0.0;
	law->cohesionFrozen        = 50e6;
	law->tensileStrengthFrozen = 50e6;
	law->frictionAngle         = friction;
	return law;
}

} // namespace

// Newmark: a block on a base that accelerates by more than friction gives it follows with mu g
TEST(MovingWalls, ThawedLayerOnAFrozenBaseThatIsDraggedAwayFollowsByFriction)
{
	for (const int rows : { 2, 4, 6 }) {
		const double h = 0.25, base = 0.5 * rows * h, depth = 2.0 * h, length = 40.0 * h, duration = 0.5, friction = 26.0;
		auto         s     = freezingBox(h, { length + 16.0 * h, 8.0 * h }, Slab::gravity, thawedSand(friction));
		const double ratio = std::sin(Slab::radians(friction)), drive = 2.0 * ratio * Slab::gravity;
		add<2, MovingBoundary<2>>(s, "bottom", TimeTable({ 0.0, duration }, { 0.0, drive * duration }), Vec<2> { 1.0, 0.0 }, true);
		Ground<2>        ground(s);
		std::vector<int> layer;
		int              id   = 0;
		const double     from = 4.0 * h, middle = from + 0.5 * length;
		fillBox(ground, { from, 0.0 }, { from + length, base + depth }, [&](PointInput<2>& p) {
			const bool thawed = p.position[1] > base;
			p.temperature     = thawed ? 5.0 : -10.0;
			p.stress[1]       = -unitWeight() * (base + depth - p.position[1]);
			p.stress[0] = p.stress[2] = p.stress[1];
			p.stress[3]               = ratio * p.stress[1];
			if (thawed && std::abs(p.position[0] - middle) < 3.0 * h) layer.push_back(id);
			++id;
		});
		ground.initialise();
		marchTo(ground, duration);
		const auto moved = valuesOf(ground, "displacement", 0);
		double     sum   = 0.0;
		for (const int k : layer)
			sum += moved[k];
		citing("Newmark 1965; Davis 1968");
		expectRelative(
		        "thawed layer on a frozen base of " + std::to_string(rows) + " rows of points that is dragged away: path over sin(phi) g t^2/2",
		        sum / layer.size() / (0.5 * ratio * Slab::gravity * duration * duration), 1.0, 5e-2);
	}
}

// A soft and a stiff layer that a wall pushes by one path have one strain each: nothing shears the front between them.
TEST(MovingWalls, FrozenAndThawedLayersPushedTogetherDoNotSlipOnEachOther)
{
	const double h = 0.1, length = 2.0, height = 1.0, path = 0.045, duration = 1.0;
	auto         law = thawedSand(26.0);
	law->poisson     = 0.0;
	law->young       = 10e6;
	law->cohesion = law->tensileStrength = 1e7;
	auto s                               = freezingBox(h, { length, height }, 0.0, law);
	s.motion->localDamping               = 0.3;
	for (const char* side : { "left", "bottom", "top" })
		add<2, RollerBoundary<2>>(s, side);
	add<2, MovingBoundary<2>>(s, "right", pushing(path, duration), Vec<2> {}, false);
	Ground<2>        ground(s);
	std::vector<int> layer[2];
	int              id = 0;
	fillBox(ground, s.lower, s.upper, [&](PointInput<2>& p) {
		const bool thawed = p.position[1] > 0.5 * height;
		p.temperature     = thawed ? 5.0 : -10.0;
		layer[thawed].push_back(id++);
	});
	ground.initialise();
	marchTo(ground, duration);
	const auto   stress = valuesOf(ground, "stress", 0), slip = valuesOf(ground, "slip");
	const double strain = std::log(1.0 - path / length);
	for (const bool thawed : { false, true }) {
		double mean = 0.0;
		for (const int k : layer[thawed])
			mean += stress[k] / layer[thawed].size();
		citing("Hooke");
		expectRelative(
		        std::string("frozen and thawed layer pushed together by a wall: mean axial stress of the ") + (thawed ? "thawed" : "frozen") + " [Pa]",
		        mean, (thawed ? law->young : law->youngFrozen) * strain, 2e-2);
	}
	expectSmall("frozen and thawed layer pushed together by a wall: largest slip over the path", largestSize(slip) / path, 1e-2);
}
