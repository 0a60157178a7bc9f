// SPDX-License-Identifier: GPL-2.0-or-later
// A thawed layer on frozen ground slides as far as friction lets it, however thin it is and wherever the front lies on the grid.
#include "Report.hpp"
#include "Slab.hpp"

#include <gtest/gtest.h>

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
	std::snprintf(text, sizeof(text), "slab on a frozen base, %s: X/h = %.1f, front %.2f h above a node, u over a t^2/2", what.c_str(), s.thickness, s.above);
	return text;
}

double slideOf(const Slab& slab) { return SlabScene(slab).slide(0.5); }

void expectSlide(const std::string& what, const Slab& slab, double tolerance)
{
	citing(slab.dilation > 0.0 ? "Coulomb" : "Davis 1968");
	expectRelative(label(what, slab), slideOf(slab), 1.0, tolerance);
}

Slab inclined(double thickness, double front)
{
	Slab s   = layer(thickness);
	s.front  = front;
	s.slope  = front;
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

TEST(ThawFront, ThinThawedLayerSlidesAsFarAsFrictionLetsIt)
{
	expectSlide("along the grid", layer(0.5), 5e-2);
	expectSlide("along the grid", layer(1.0, 0.25), 5e-2);
	expectSlide("along the grid", layer(2.0, 0.75), 5e-2);
	expectSlide("along the grid, psi = phi", dilating(layer(2.0)), 5e-2);
	expectSlide("along the grid, saturated", wet(layer(2.0)), 5e-2);
	expectSlide("front at 45 degrees to the grid", inclined(1.0, 45.0), 1e-1);
	// what the front is for: with one velocity the same layer does not slide
	EXPECT_LT(slideOf(withoutFront(layer(1.0))), 0.05);
}

TEST(ThawFront, LayerOfAnyThicknessSlidesWhereverTheFrontLies_slow)
{
	for (const double above : { 0.0, 0.25, 0.5, 0.75 })
		for (const double thickness : { 0.5, 1.0, 2.0, 4.0, 8.0 }) {
			// a single row of points, most of it in cells that it shares with frozen ground
			const bool singleRow = thickness == 0.5 && above == 0.75;
			expectSlide("along the grid", layer(thickness, above), 5e-2);
			// the stress of a single row that dilates wanders
			expectSlide("along the grid, psi = phi", dilating(layer(thickness, above)), singleRow ? 2.5e-1 : thickness < 2.0 ? 7e-2 : 5e-2);
			// pressure in a layer thinner than a cell has one value
			expectSlide("along the grid, saturated", wet(layer(thickness, above)), thickness < 2.0 ? 3e-1 : 5e-2);
		}
}

TEST(ThawFront, LayerOnAFrontInclinedToTheGridSlides_slow)
{
	for (const double thickness : { 0.5, 1.0, 2.0, 4.0 }) {
		expectSlide("front at 45 degrees to the grid", inclined(thickness, 45.0), 1e-1);
		expectSlide("front at 30 degrees to the grid", inclined(thickness, 30.0), thickness <= 2.0 ? 1e-1 : 3e-1);
	}
}

TEST(ThawFront, EveryTransferAndShapeFunctionLetsTheLayerSlide)
{
	for (const char* shape : { "quadraticBSpline", "gimp" })
		for (const VelocityTransfer transfer : { VelocityTransfer::flip, VelocityTransfer::apic, VelocityTransfer::tpic })
			expectSlide(
			        std::string(shape) + ", " + velocityTransferNames()[static_cast<int>(transfer)], withTransfer(layer(1.0, 0.25), transfer, shape), 5e-2);
}

TEST(ThawFront, LayerThatFrictionHoldsStays)
{
	Slab s       = dilating(layer(2.0, 0.25)); // without dilation elastic, perfectly plastic ground so near to its strength is not stable itself
	s.slope      = 0.9 * s.friction;
	s.wallToWall = true;
	citing("Coulomb");
	for (const double thickness : { 0.5, 1.0, 2.0 }) {
		s.thickness = thickness;
		SlabScene  scene(s);
		Ground<2>& ground = scene.ground();
		// points do not start quite at rest: what the grid makes of their stress swings until it is damped
		ground.settings().motion->localDamping = 0.5;
		marchTo(ground, 0.2);
		ground.settings().motion->localDamping = 0.0;
		const double settled = scene.displacement();
		marchTo(ground, 0.7);
		expectSmall(
		        "slab on a frozen base, nine tenths of the angle of friction: path in 0.5 s over X, X/h = " + std::to_string(thickness).substr(0, 3),
		        (scene.displacement() - settled) / s.depth(), 1e-3);
	}
}

TEST(ThawFront, CohesionHoldsALayerUpToItsClosedFormThickness)
{
	Slab s             = layer(2.0);
	const double beta  = Slab::radians(s.slope), phi = Slab::radians(s.friction);
	const double limit = (std::sin(beta) - std::sin(phi) * std::cos(beta)) * s.density() * Slab::gravity * s.depth() / std::cos(phi);
	const auto   speed = [&](double cohesion) {
		s.cohesion = cohesion;
		SlabScene scene(s);
		marchTo(scene.ground(), 0.4);
		const double before = scene.displacement();
		marchTo(scene.ground(), 0.5);
		return (scene.displacement() - before) / 0.1;
	};
	citing("infinite slope");
	s.cohesion          = 0.9 * limit;
	const double driven = 0.45 * s.acceleration();
	expectAtLeast("slab on a frozen base, cohesion 0.9 of what holds it: speed after 0.45 s over that of the closed form", speed(0.9 * limit) / driven, 0.9);
	expectSmall("slab on a frozen base, cohesion 1.1 of what holds it: speed after 0.45 s over that without cohesion", speed(1.1 * limit) / (0.45 * 3.896), 5e-2);
}

TEST(ThawFront, SlipKeepsMomentumAndAccountsForItsWork)
{
	Slab s   = layer(2.0, 0.25);
	s.change = [](GroundSettings<2>& g) { g.energyLedger = true; };
	SlabScene         scene(s);
	Ground<2>&        ground = scene.ground();
	const Balance<2>  before = ground.balance();
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
	expectRelative("slab on a frozen base, balances: work of slip [J]", after.slipWork, mass * Slab::gravity * std::cos(Slab::radians(s.slope)) * s.sine() * path, 1e-1);
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

TEST(ThawFront, SidesOutOfOrderAreRefusedWithASentence)
{
	Slab s   = layer(1.0);
	s.length = 4.0;
	s.change = [](GroundSettings<2>& g) { g.thawFront->thawedBelow = 0.2; };
	EXPECT_THROW(SlabScene scene(s), std::invalid_argument);
}
