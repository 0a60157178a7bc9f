// SPDX-License-Identifier: GPL-2.0-or-later
// A thawed layer on frozen ground slides as far as friction lets it, however thin it is and wherever the front lies on the grid.
#include "Report.hpp"
#include "Roof.hpp"
#include "Slab.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cstring>

using namespace talik;
using namespace talik::validation;

namespace {

/// Layers are long enough for their ends not to be felt at mid-length within half a second.
Slab layer(double thickness, double above = 0.0)
{
	Slab s;
	s.thickness = thickness;
	s.above     = above;
	s.length    = thickness <= 2.0 ? 40.0 : 20.0 * thickness;
	return s;
}

std::string label(const std::string& what, const Slab& s)
{
	char text[160];
	std::snprintf(
	        text, sizeof(text), "slab on a frozen base, %s: X/h = %.1f, front %.2f h above a node, u over a t^2/2", what.c_str(), s.thickness, s.above);
	return text;
}

double slideOf(const Slab& slab) { return SlabScene(slab).slide(0.5); }

/// As slideOf(), of all rows of the layer in place of its surface.
double meanSlideOf(const Slab& slab)
{
	SlabScene scene(slab);
	scene.slide(0.5);
	return scene.displacementBetween(0.0, slab.depth()) / (0.5 * slab.acceleration() * 0.25);
}

void expectSlide(const std::string& what, const Slab& slab, double tolerance)
{
	citing(slab.dilation > 0.0 ? "Coulomb" : "Davis 1968");
	expectRelative(label(what, slab), slideOf(slab), 1.0, tolerance);
}

Slab inclined(double thickness, double front)
{
	Slab s  = layer(thickness);
	s.front = front;
	s.slope = front;
	if (front == 30.0) s.length = 80.0; // it hardly moves: its ends are felt farther
	return s;
}

Slab dilating(Slab s)
{
	s.dilation = s.friction;
	return s;
}

Slab wet(Slab s)
{
	s.wet = true;
	return s;
}

Slab withTransfer(Slab s, VelocityTransfer transfer, const std::string& shape)
{
	s.change = [=](GroundSettings<2>& g) {
		g.motion->transfer = transfer;
		g.shapeFunction    = shape;
	};
	return s;
}

Slab withoutFront(Slab s)
{
	s.change = [](GroundSettings<2>& g) { g.thawFront.reset(); };
	return s;
}

} // namespace

// Of the slow tests one layer of each kind.
TEST(ThawFront, ThinThawedLayerSlidesAsFarAsFrictionLetsIt)
{
	expectSlide("along the grid", layer(0.5), 5e-2);
	expectSlide("along the grid, psi = phi", dilating(layer(2.0)), 5e-2);
	expectSlide("along the grid, saturated", wet(layer(1.0, 0.25)), 5e-2);
	expectSlide("front at 45 degrees to the grid", inclined(1.0, 45.0), 1e-1);
	// what the front is for: with one velocity the same layer does not slide
	EXPECT_LT(slideOf(withoutFront(layer(1.0))), 0.05);
}

// In short steps drag takes hardly any water along at once: the water of a side must keep what it has of the slide.
TEST(ThawFront, SaturatedLayerSlidesAsFarInStepsOfAnyLength)
{
	for (const double courantNumber : { 0.1, 0.025 }) {
		Slab slab   = wet(layer(1.0, 0.25));
		slab.change = [=](GroundSettings<2>& g) { g.courantNumber = courantNumber; };
		char what[80];
		std::snprintf(what, sizeof(what), "saturated, Courant number %g", courantNumber);
		expectSlide(what, slab, 5e-2);
	}
}

TEST(ThawFront, LayerOfAnyThicknessSlidesWhereverTheFrontLies_slow)
{
	for (const double above : { 0.0, 0.25, 0.5, 0.75 })
		for (const double thickness : { 0.5, 1.0, 2.0, 4.0, 8.0 }) {
			expectSlide("along the grid", layer(thickness, above), 5e-2);
			expectSlide("along the grid, saturated", wet(layer(thickness, above)), 5e-2);
			expectSlide("along the grid, psi = phi", dilating(layer(thickness, above)), 5e-2);
		}
}

// At 30 degrees without water 0.12 g drive the layer against 0.38 g of friction: an error of the friction counts threefold. A thick layer shears in
// itself there, because its strength is used up at every depth: its surface runs ahead of its base, its mean slides as far as it should.
TEST(ThawFront, LayerOnAFrontInclinedToTheGridSlides_slow)
{
	for (const double thickness : { 0.5, 1.0, 2.0, 4.0, 8.0 }) {
		expectSlide("front at 45 degrees to the grid", inclined(thickness, 45.0), 1e-1);
		if (thickness < 8.0) expectSlide("front at 30 degrees to the grid", inclined(thickness, 30.0), thickness < 4.0 ? 1e-1 : 3e-1);
		for (const double front : { 30.0, 45.0 })
			expectSlide(
			        "front at " + std::to_string(front).substr(0, 2) + " degrees to the grid, saturated", wet(inclined(thickness, front)), 1e-1);
	}
}

TEST(ThawFront, MeanOfALayerOnAFrontInclinedToTheGridSlides_slow)
{
	citing("Davis 1968");
	for (const double thickness : { 2.0, 4.0, 8.0 })
		expectRelative(
		        label("front at 30 degrees to the grid, mean of all rows", inclined(thickness, 30.0)), meanSlideOf(inclined(thickness, 30.0)), 1.0,
		        1e-1);
}

namespace {

void expectSlideWith(const std::string& shape, VelocityTransfer transfer)
{
	expectSlide(shape + ", " + velocityTransferNames()[int(transfer)], withTransfer(layer(1.0, 0.25), transfer, shape), 5e-2);
}

} // namespace

TEST(ThawFront, EveryTransferAndShapeFunctionLetsTheLayerSlide)
{
	expectSlideWith("quadraticBSpline", VelocityTransfer::flip);
	expectSlideWith("quadraticBSpline", VelocityTransfer::apic);
	expectSlideWith("gimp", VelocityTransfer::tpic);
}

TEST(ThawFront, OtherPairsOfTransferAndShapeFunctionLetTheLayerSlide_slow)
{
	expectSlideWith("quadraticBSpline", VelocityTransfer::tpic);
	expectSlideWith("gimp", VelocityTransfer::flip);
	expectSlideWith("gimp", VelocityTransfer::apic);
}

namespace {

/// Path at nine tenths of the angle of friction, or of sin(phi) where that is the strength (no dilation), in half a second after the
/// layer has settled, over its thickness.
double creepOf(Slab s)
{
	s.slope      = s.dilation > 0.0 ? 0.9 * s.friction : std::atan(0.9 * s.ratio()) / Slab::radians(1.0);
	s.wallToWall = true;
	SlabScene  scene(s);
	Ground<2>& ground = scene.ground();
	// points do not start quite at rest: what the grid makes of their stress swings until it is damped
	ground.settings().motion->localDamping = 0.5;
	marchTo(ground, 0.2);
	ground.settings().motion->localDamping = 0.0;
	const double settled                   = scene.displacement();
	marchTo(ground, 0.7);
	return (scene.displacement() - settled) / s.depth();
}

void expectStanding(const Slab& slab, double bound)
{
	citing(slab.dilation > 0.0 ? "Coulomb" : "Davis 1968");
	char text[160];
	std::snprintf(
	        text, sizeof(text), "slab on a frozen base, nine tenths of %s: X/h = %.1f, front %.2f h above a node, path in 0.5 s over X",
	        slab.dilation > 0.0 ? "the angle of friction" : "sin(phi)", slab.thickness, slab.above);
	expectSmall(text, creepOf(slab), bound);
}

} // namespace

// Without dilation the layer slides from tan(beta) = sin(phi) on, a hundredth above nine tenths of phi: it is held at nine tenths of that.
TEST(ThawFront, LayerThatFrictionHoldsStays)
{
	expectStanding(dilating(layer(0.5, 0.25)), 1e-3);
	expectStanding(layer(1.0, 0.25), 1e-3);
}

TEST(ThawFront, LayerThatFrictionHoldsStaysWhereverTheFrontLies_slow)
{
	for (const double thickness : { 0.5, 1.0, 2.0 })
		for (const double above : { 0.0, 0.25, 0.5, 0.75 }) {
			expectStanding(dilating(layer(thickness, above)), 1e-3);
			expectStanding(layer(thickness, above), 1e-3);
		}
}

namespace {

/// Speed at mid-length over that of the closed form without cohesion, with some part of the cohesion that holds the layer; after 0.55 s, when what
/// shakes the layer at the start has died out.
double speedWithCohesion(Slab s, double part)
{
	const double driven = 0.55 * s.acceleration(), beta = Slab::radians(s.slope), phi = Slab::radians(s.friction);
	s.cohesion = part * (std::sin(beta) - std::sin(phi) * std::cos(beta)) * s.density() * Slab::gravity * s.depth() / std::cos(phi);
	SlabScene scene(s);
	marchTo(scene.ground(), 0.5);
	const double before = scene.displacement();
	marchTo(scene.ground(), 0.6);
	return (scene.displacement() - before) / 0.1 / driven;
}

void expectCohesionToHold(const std::string& what, const Slab& slab)
{
	citing("infinite slope");
	char thickness[40];
	std::snprintf(thickness, sizeof(thickness), "X/h = %.1f, ", slab.thickness);
	const std::string name = "slab on a frozen base, " + what + thickness + "cohesion ";
	expectScaled(name + "0.9 of what holds it: speed after 0.55 s over that without cohesion", speedWithCohesion(slab, 0.9), 0.1, 1.0, 0.1);
	expectSmall(name + "1.1 of what holds it: speed after 0.55 s over that without cohesion", speedWithCohesion(slab, 1.1), 5e-2);
}

} // namespace

// The layer is long: at its ends the front has area beyond the last points, half a cell each, where cohesion acts, too.
TEST(ThawFront, CohesionHoldsALayerUpToItsClosedFormThickness)
{
	Slab s   = layer(2.0);
	s.length = 120.0;
	expectCohesionToHold("", s);
}

// Thin layers on steps: with the stress of the points, which is rough there, half as much cohesion again did not hold them.
TEST(ThawFront, CohesionHoldsALayerOnAnInclinedFront_slow)
{
	for (const double front : { 45.0, 60.0 })
		for (const double thickness : { 1.0, 2.0, 4.0 }) {
			Slab s   = inclined(thickness, front);
			s.length = front == 45.0 ? 80.0 : 40.0; // the steeper one falls freely at its ends, which shakes a longer one for longer
			expectCohesionToHold("front at " + std::to_string(front).substr(0, 2) + " degrees to the grid, ", s);
		}
}

namespace {

void expectToStop(const std::vector<double>& fronts)
{
	citing("Davis 1968");
	for (const double above : fronts) {
		const Slab   s    = layer(2.0, above);
		const double half = 0.5 * s.depth(), first = 0.3, last = 0.5, end = 1.0;
		const auto   freePath = [&](double t) { return 0.5 * s.acceleration() * t * t; };
		const auto   row      = [&](const std::string& what) {
                        return "slab that freezes to its base while it slides, front " + std::to_string(above).substr(0, 4) + " h above a node: " + what;
		};
		SlabScene scene(s);
		marchTo(scene.ground(), first);
		const double lower = scene.displacementBetween(0.0, half);
		scene.freeze(0.0, half);
		marchTo(scene.ground(), last);
		const double upper = scene.displacementBetween(half, s.depth());
		expectSmall(
		        row("path of the frozen half from then on over a t^2/2"),
		        (scene.displacementBetween(0.0, half) - lower) / (freePath(last) - freePath(first)), 2e-2);
		expectRelative(row("path of the half that slides on over a t^2/2"), upper, freePath(last), 5e-2);
		scene.freeze(half, s.depth());
		marchTo(scene.ground(), end);
		const double gone = scene.displacementBetween(half, s.depth()) - upper;
		expectSmall(row("path when it is frozen too over a t^2/2"), gone / (freePath(end) - freePath(last)), 1e-2);
	}
}

} // namespace

TEST(ThawFront, BlockThatFreezesToItsBaseWhileItSlidesStops) { expectToStop({ 0.0, 0.75 }); }

TEST(ThawFront, BlockThatFreezesToItsBaseWhileItSlidesStopsWhereverTheFrontLies_slow) { expectToStop({ 0.25, 0.5 }); }

namespace {

/// Two cells of frozen ground, or what fits into the box, on thawed ground without cohesion, in a strip between rollers.
class FrozenOnThawed {
public:
	/// base of the thawed ground and front [m] over the bottom of the box; settings and points may be changed.
	FrozenOnThawed(double base, double front, const std::function<void(GroundSettings<2>&)>& change, const PointPreparation<2>& prepare = {})
	{
		GroundSettings<2> s = columnSettings(spacing, 8.0 * spacing);
		s.motion.emplace();
		s.motion->gravity = { 0.0, -gravity };
		s.heat.emplace();
		s.freezing    = makeFreezingCurve();
		auto law      = std::make_shared<MohrCoulombSkeleton<2>>();
		law->cohesion = 0.0;
		s.skeletons   = { law };
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("left"));
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("right"));
		change(s);
		ground_ = std::make_unique<Ground<2>>(s);
		fillBox(*ground_, { 0.0, base }, { spacing, std::min(front + 2.0 * spacing, s.upper[1]) }, [&](PointInput<2>& p) {
			p.temperature = p.position[1] > front ? -10.0 : 5.0;
			if (prepare) prepare(p);
		});
		ground_->initialise();
		for (const double y : valuesOf(*ground_, "position", 1))
			height_.push_back(y - front);
	}
	/// Mean rise of the points that started between two heights over the front [m].
	double rise(double lower, double upper) const
	{
		const auto u     = valuesOf(*ground_, "displacement", 1);
		double     sum   = 0.0;
		int        count = 0;
		for (std::size_t id = 0; id < u.size(); ++id)
			if (height_[id] > lower && height_[id] < upper) {
				sum += u[id];
				++count;
			}
		return sum / count;
	}
	double     rowAbove() const { return rise(0.0, 0.5 * spacing); }
	double     rowBelow() const { return rise(-0.5 * spacing, 0.0); }
	Ground<2>& ground() { return *ground_; }

	static constexpr double spacing = 0.25, gravity = 9.81;

private:
	std::unique_ptr<Ground<2>> ground_;
	std::vector<double>        height_;
};

} // namespace

TEST(ThawFront, ThawedGroundFallsFreelyFromAFrozenRoof)
{
	citing("free fall");
	for (const char* shape : { "quadraticBSpline", "gimp" })
		for (const double above : { 0.0, 0.25, 0.5, 0.75 }) {
			const double   h = FrozenOnThawed::spacing, duration = 0.2, path = 0.5 * FrozenOnThawed::gravity * duration * duration;
			FrozenOnThawed scene((4.0 + above) * h, (6.0 + above) * h, [&](GroundSettings<2>& s) {
				s.shapeFunction = shape;
				addBoundary<FixedBoundary<2>>(s, Region<2>::side("top"));
			});
			marchTo(scene.ground(), duration);
			const std::string what = std::string("thawed ground under a frozen roof, ") + shape + ", front " + std::to_string(above).substr(0, 4)
			        + " h above a node: path of ";
			expectRelative(what + "its upper row over g t^2/2", -scene.rowBelow() / path, 1.0, 2e-2);
			expectSmall(what + "the roof over g t^2/2", scene.rowAbove() / path, 1e-2);
		}
}

TEST(ThawFront, FrozenBlockThrownUpPartsFromTheThawedGroundUnderIt)
{
	citing("free flight");
	const double density = 0.6 * 2650.0 + 0.4 * 1000.0;
	for (const char* shape : { "quadraticBSpline", "gimp" })
		for (const double above : { 0.0, 0.5 }) {
			const double h = FrozenOnThawed::spacing, g = FrozenOnThawed::gravity, duration = 0.15, speed = 2.0,
			             path = speed * duration - 0.5 * g * duration * duration;
			FrozenOnThawed scene(
			        0.0, (2.0 + above) * h,
			        [&](GroundSettings<2>& s) {
				        s.shapeFunction = shape;
				        addBoundary<RollerBoundary<2>>(s, Region<2>::side("bottom"));
			        },
			        [&](PointInput<2>& p) {
				        const double vertical = -density * g * ((4.0 + above) * h - p.position[1]), across = 0.3 / 0.7 * vertical;
				        p.stress = { across, vertical, across, 0.0 };
				        if (p.temperature < 0.0) p.velocity = { 0.0, speed };
			        });
			marchTo(scene.ground(), duration);
			const std::string what = std::string("frozen block thrown up from thawed ground, ") + shape + ", front "
			        + std::to_string(above).substr(0, 4) + " h above a node: path of ";
			expectRelative(what + "the block over v t - g t^2/2", scene.rowAbove() / path, 1.0, 2e-2);
			expectSmall(what + "the ground over v t - g t^2/2", scene.rowBelow() / path, 1e-2);
		}
}

TEST(ThawFront, ThawedLayerThatARoofWeighsUponStays)
{
	citing("Coulomb");
	for (const int rows : { 1, 2 })
		expectSmall(
		        "thawed layer of " + std::to_string(rows)
		                + " rows under 0.8 m of frozen ground, pushed by its own weight towards a gap: path in 0.5 s over X",
		        pathUnderRoof(rows), 1e-2);
}

TEST(ThawFront, FrozenBlockSlidesOnThawedGround)
{
	citing("Davis 1968");
	const double duration = 0.5, from = 0.4, to = 4.4;
	for (const double degrees : { 45.0, 75.0 }) {
		const double angle = Slab::radians(degrees), sine = std::sin(Slab::radians(Roof::friction));
		const double free = 0.5 * Roof::gravity * duration * duration * (std::sin(angle) - sine * std::cos(angle));
		Roof         scene(
		                4, 0.4, from, to, { 7.0, 1.4 }, degrees, [](double, double) { return true; }, [](double, double) { return false; });
		char what[99];
		std::snprintf(what, sizeof what, "frozen block on two cells of thawed ground at %g degrees: path in 0.5 s over a t^2/2", degrees);
		expectRelative(what, scene.path(duration, scene.layer(), 1.0, 0.5 * (from + to), 0.5) / free, 1.0, 5e-2);
	}
}

TEST(ThawFront, SlipKeepsMomentumAndAccountsForItsWork)
{
	Slab s   = layer(2.0, 0.25);
	s.change = [](GroundSettings<2>& g) { g.energyLedger = true; };
	SlabScene        scene(s);
	Ground<2>&       ground = scene.ground();
	const Balance<2> before = ground.balance();
	marchTo(ground, 0.3);
	const Balance<2> after = ground.balance();
	double           drift = 0.0, scale = 0.0;
	for (int a = 0; a < 2; ++a) {
		drift = std::max(drift, std::abs(after.momentum[a] - before.momentum[a] - (after.impulse[a] - before.impulse[a])));
		scale = std::max(scale, std::abs(after.impulse[a]));
	}
	citing("exact");
	expectSmall("slab on a frozen base, balances: momentum less impulse over the impulse", drift / scale, 1e-11);
	const double fallen = before.gravityEnergy - after.gravityEnergy;
	const double held   = (after.kineticEnergy - before.kineticEnergy) + (after.skeletonWork - before.skeletonWork) + (after.slipWork - before.slipWork);
	expectRelative("slab on a frozen base, balances: kinetic energy, work of strain and of slip over the work of gravity", held / fallen, 1.0, 2e-2);
	// friction sin(phi) cos(beta) of the weight along the path of the layer
	const double path = scene.displacement(), mass = s.density() * s.length * s.spacing * s.depth();
	expectRelative(
	        "slab on a frozen base, balances: work of slip [J]", after.slipWork, mass * Slab::gravity * std::cos(Slab::radians(s.slope)) * s.sine() * path,
	        1e-1);
}

namespace {

/// A saturated block of six by two cells on a frozen base of two cells, which slides; three cells across in space.
template <int D> Ground<D> block(int parallelFrom)
{
	constexpr double  h = 0.25, slope = 0.7;
	GroundSettings<D> s;
	const Vec<3>      upper { 14.0 * h, 6.0 * h, 3.0 * h };
	s.gridSpacing  = h;
	s.mixture      = withoutExpansion();
	s.parallelFrom = parallelFrom;
	std::copy_n(upper.begin(), D, s.upper.begin());
	s.motion.emplace();
	s.motion->gravity[0] = 9.81 * std::sin(slope);
	s.motion->gravity[1] = -9.81 * std::cos(slope);
	s.heat.emplace();
	s.freezing = makeFreezingCurve();
	s.water.emplace();
	s.water->permeability.referenceConductivity = 1e-4;
	s.water->hydraulicTimeScale                 = 1.0;
	s.water->state.liquidBulkModulus            = 2.2e7;
	s.water->state.iceBulkModulus               = 8.8e7;
	auto law                                    = std::make_shared<MohrCoulombSkeleton<D>>();
	law->young                                  = 20e6;
	law->cohesion                               = 0.0;
	law->frictionAngle                          = 26.0;
	law->cohesionFrozen                         = 50e6;
	law->tensileStrengthFrozen                  = 50e6;
	s.skeletons                                 = { law };
	for (int a = 0; a < D; ++a)
		for (const bool high : { false, true }) {
			if (a == 1 && high) continue;
			const std::string name = sideNames(D)[2 * a + high];
			if (a == 1) s.boundaries.push_back(std::make_shared<FixedBoundary<D>>(Region<D>::side(name)));
			else s.boundaries.push_back(std::make_shared<RollerBoundary<D>>(Region<D>::side(name)));
		}
	Ground<D> ground(s);
	for (double z = 0.25 * h; z < (D == 3 ? 3.0 * h : 0.5 * h); z += 0.5 * h)
		for (double y = 0.25 * h; y < 4.0 * h; y += 0.5 * h)
			for (double x = 0.25 * h; x < 14.0 * h; x += 0.5 * h) {
				if (y > 2.0 * h && (x < 3.0 * h || x > 9.0 * h)) continue;
				const Vec<3>  position { x, y, z };
				PointInput<D> p;
				std::copy_n(position.begin(), D, p.position.begin());
				p.volume            = std::pow(0.5 * h, D);
				p.temperature       = y > 2.0 * h ? 5.0 : -0.5;
				const double normal = -(0.6 * 2650.0 + 400.0) * 9.81 * std::cos(slope) * (4.0 * h - y);
				for (int a = 0; a < 3; ++a)
					p.stress[a] = normal;
				ground.addPoint(p);
			}
	ground.initialise();
	return ground;
}

std::vector<std::vector<char>> copyOf(const std::vector<StateArray>& state)
{
	std::vector<std::vector<char>> copy;
	for (const StateArray& a : state)
		copy.emplace_back(static_cast<const char*>(a.data), static_cast<const char*>(a.data) + a.bytes);
	return copy;
}

} // namespace

TEST(ThawFront, BlockInSpaceSlidesAsItDoesInThePlane)
{
	Ground<2>    plane = block<2>(4000);
	Ground<3>    space = block<3>(4000);
	const double step  = space.stableTimeStep().step;
	while (plane.time() < 0.1) {
		plane.step(step);
		space.step(step);
	}
	citing("the plane");
	const auto slip = [](const std::vector<double>& values) {
		double sum = 0.0;
		for (const double v : values)
			sum += v;
		return sum / values.size();
	};
	EXPECT_GT(slip(valuesOf(plane, "slip")), 1e-3);
	expectRelative(
	        "block on a frozen base in space, uniform across: mean slip after 0.1 s over that in the plane", slip(valuesOf(space, "slip")),
	        slip(valuesOf(plane, "slip")), 1e-2);
	expectRelative(
	        "block on a frozen base in space, uniform across: mean displacement after 0.1 s over that in the plane",
	        slip(valuesOf(space, "displacement", 0)), slip(valuesOf(plane, "displacement", 0)), 1e-2);
	expectSmall(
	        "block on a frozen base in space, uniform across: largest displacement across over that along",
	        largestSize(valuesOf(space, "displacement", 2)) / largestSize(valuesOf(space, "displacement", 0)), 1e-6);
}

TEST(ThawFront, FrontThatMovesGivesTheSameBitsForAnyNumberOfThreadsAndThroughACheckpoint)
{
	const int    steps = 400, halfWay = steps / 2, before = omp_get_max_threads();
	const auto   start = [] { return block<2>(0); };
	const double step  = 0.5 * start().stableTimeStep().step;
	// half a row of the base thaws in the first half, and half a row of the block freezes in the second
	const auto march = [&](Ground<2>& ground, int from, int to) {
		for (int k = from; k < to; ++k) {
			if (k == steps / 4)
				for (int id = 84; id < 98; ++id)
					ground.setThermalState(id, 1.0, 0.0);
			if (k == 3 * steps / 4)
				for (int id = 112; id < 118; ++id)
					ground.setThermalState(id, -1.0, 0.0);
			ground.step(step);
		}
		return copyOf(ground.state());
	};
	omp_set_num_threads(1);
	Ground<2>    whole  = start();
	const double frozen = sumOf(whole, "frozenSide");
	const auto   saved  = march(whole, 0, halfWay);
	EXPECT_EQ(sumOf(whole, "frozenSide"), frozen - 14.0);
	const auto reference = march(whole, halfWay, steps);
	EXPECT_EQ(sumOf(whole, "frozenSide"), frozen - 8.0);
	EXPECT_GT(sumOf(whole, "slip"), 0.0);
	for (const int threads : { 2, 3 }) {
		omp_set_num_threads(threads);
		Ground<2> other = start();
		EXPECT_EQ(march(other, 0, steps), reference) << threads << " threads";
	}
	Ground<2>  resumed = start();
	const auto state   = resumed.state();
	ASSERT_EQ(state.size(), saved.size());
	for (std::size_t k = 0; k < state.size(); ++k)
		std::memcpy(state[k].data, saved[k].data(), state[k].bytes);
	resumed.stateRestored();
	EXPECT_EQ(march(resumed, halfWay, steps), reference);
	omp_set_num_threads(before);
}

TEST(ThawFront, SceneWithoutFreezingOrMotionOrStrengthHasNoFront)
{
	const auto fieldsOf = [](const std::function<void(GroundSettings<2>&)>& change) {
		Slab s   = layer(1.0);
		s.length = 4.0;
		s.change = change;
		SlabScene scene(s);
		return hasField(scene.ground(), "slip") || hasField(scene.ground(), "frozenSide");
	};
	EXPECT_TRUE(fieldsOf([](GroundSettings<2>&) {}));
	EXPECT_FALSE(fieldsOf([](GroundSettings<2>& g) { g.freezing.reset(); }));
	EXPECT_FALSE(fieldsOf([](GroundSettings<2>& g) { g.thawFront.reset(); }));
	EXPECT_FALSE(fieldsOf([](GroundSettings<2>& g) { g.skeletons = { elasticOedometer(2e7) }; }));
}
