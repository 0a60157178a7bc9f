// SPDX-License-Identifier: GPL-2.0-or-later
// Identities between what points give to nodes and what nodes give back, on random states.
#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/mpm/effects/FreeSurface.hpp>
#include <pkg/mpm/effects/MomentumSolver.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/points/CellMeans.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

using namespace talik;

namespace {

/// A block of ground with random stresses, pressures, ice and velocities, and the effects that move it.
template <int D> struct RandomGround {
	Grid<D>                           grid;
	MotionSettings<D>                 motionSettings;
	WaterSettings                     waterSettings;
	MaterialPoints<D>                 points;
	SolidMotion<D>                    motion;
	PoreWater<D>                      water;
	PointFields::Handle               ice, waterMass, temperature;
	CellMeans<D>                      cells;
	std::unique_ptr<ShapeFunction<D>> shape = makeShapeFunction<D>("quadraticBSpline");
	ActiveRange                       range;
	std::mt19937                      random { 11 };
	double                            dt = 1e-3;

	double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }

	/// slice: one cell along the second direction.
	explicit RandomGround(bool slice = false, bool turned = false)
	        : grid(turnedGrid(slice, turned))
	        , motion(points.fields(), motionSettings, true, turned)
	        , water(points.fields(), waterSettings)
	        , ice(points.fields().declare("ice", "test", "kg", 1))
	        , waterMass(points.fields().declare("waterMass", "test", "kg", 1))
	        , temperature(points.fields().declare("temperature", "test", "degC", 1))
	{
		const int n = D == 2 ? 400 : 2000;
		points.allocate(n);
		motion.bind(points, grid);
		water.liquid = { 1000.0, nullptr };
		water.bind(points, grid, field(ice), field(temperature), field(waterMass));
		water.allocateCells(grid.cellCount(), grid.cellVolume());
		cells.allocate(grid, n);
		for (int p = 0; p < n; ++p) {
			for (int a = 0; a < D; ++a) {
				points.position(a)[p] = slice && a == 1 ? uniform(0.0, 0.1) : uniform(0.2, 0.8);
				motion.velocity[a][p] = uniform(-1.0, 1.0);
				water.velocity[a][p]  = uniform(-1.0, 1.0);
			}
			points.volume()[p]      = uniform(0.5, 1.5) * std::pow(0.05, D);
			motion.mass[p]          = 1700.0 * points.volume()[p];
			field(waterMass)[p]     = uniform(300.0, 400.0) * points.volume()[p];
			field(ice)[p]           = uniform(0.0, 280.0) * points.volume()[p];
			water.pressure[p]       = uniform(-1e5, 1e5);
			water.liquidFraction[p] = uniform(0.02, 0.4);
			water.drag[p]           = uniform(1e3, 1e6) * points.volume()[p];
			for (auto* s : motion.stress)
				s[p] = uniform(-1e5, 1e5);
		}
		points.sort(grid);
		range = ActiveRange::of(grid, points);
		cells.clearAll();
		forStrips([&](int first, int last) {
			cells.locate(grid, points, first, last);
			water.addPressure(cells, first, last);
		});
		water.finishPressure(range);
		water.findDrivingPressure(grid, range, cells);
	}

	static Grid<D> turnedGrid(bool slice, bool turned)
	{
		Grid<D> grid(box(0.0), slice ? sliced() : box(1.0), 0.1);
		if (turned) grid.turn();
		return grid;
	}
	static Vec<D> box(double value)
	{
		Vec<D> v;
		v.fill(value);
		return v;
	}
	static Vec<D> sliced()
	{
		Vec<D> v = box(1.0);
		v[1]     = 0.1;
		return v;
	}
	double* field(PointFields::Handle h) { return points.fields().component(h); }
	double  liquid(int p) { return field(waterMass)[p] - field(ice)[p]; }

	template <class Work> void forStrips(Work&& work)
	{
		for (int s = 0; s < points.strips().count(); ++s)
			work(points.strips().first[s], points.strips().first[s + 1]);
	}
	template <class Work> void forBlocks(Work&& work)
	{
		std::array<const double*, D> x;
		for (int a = 0; a < D; ++a)
			x[a] = points.position(a);
		WeightBlock<D> w;
		for (int p = 0; p < points.count(); p += blockSize) {
			shape->evaluate(grid, x, p, std::min(blockSize, points.count() - p), w);
			work(w);
		}
	}
	void randomVelocities(NodeField<NodeColumns<D>::Solved::size>& nodes)
	{
		for (int i = 0; i < grid.nodeCount(); ++i)
			for (int a = 0; a < nodes.size; ++a)
				nodes[i][a] = uniform(-1.0, 1.0);
	}
};

/// Internal force on the nodes times any nodal velocity against minus the stress times the strain rate, with cell means.
template <int D> double stressPairError(bool slice = false, bool turned = false)
{
	RandomGround<D> g { slice, turned };
	const int       direct   = turned ? 3 : D;
	const auto      share    = g.motion.traceShare;
	const double*   volume   = g.points.volume();
	const auto      averaged = [&](int p) {
                double sum = 0.0;
                for (int a = 0; a < direct; ++a)
                        sum += share[a] * g.motion.stress[a][p];
                return sum;
	};
	for (int p = 0; p < g.points.count(); ++p)
		g.cells.add(p, volume[p] * (averaged(p) - g.water.pressure[p]));
	g.cells.finish(g.range);
	for (int p = 0; p < g.points.count(); ++p)
		g.motion.addedStress[p] = g.cells.mean(p, 0.0) - averaged(p);
	const auto sizes = [&](int p) { return volume[p] / g.points.position(0)[p]; };
	g.forBlocks([&](const WeightBlock<D>& w) {
		g.motion.map(w);
		if (turned) g.motion.mapHoop(g.shape->meanOfFaces(g.grid, sizes, w));
	});
	g.randomVelocities(g.motion.solved);
	double power = 0.0, size = 0.0;
	for (int i = 0; i < g.grid.nodeCount(); ++i)
		for (int a = 0; a < D; ++a) {
			const double part = g.motion.nodes[i][g.motion.forceAt + a] * g.motion.solved[i][g.motion.velocityAt + a];
			power += part;
			size += std::abs(part);
		}
	g.forBlocks([&](const WeightBlock<D>& w) {
		if (turned) g.motion.gatherHoop(g.shape->meanOfFaces(g.grid, sizes, w), 1.0);
		g.motion.gather(w, 1.0);
	});
	g.cells.clearSums(g.range);
	const auto trace = [&](int p) {
		double sum = 0.0;
		for (int a = 0; a < direct; ++a)
			sum += g.motion.direct[a][p];
		return sum;
	};
	for (int p = 0; p < g.points.count(); ++p)
		g.cells.add(p, volume[p] * trace(p));
	g.cells.finish(g.range);
	for (int p = 0; p < g.points.count(); ++p) {
		const double missing = g.cells.mean(p, 0.0) - trace(p);
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D; ++j) {
				const double total = g.motion.stress[stressIndex<D>(i, j)][p] - (i == j ? g.water.pressure[p] : 0.0);
				power += volume[p] * total * (g.motion.gradient[i * D + j][p] + (i == j ? missing * share[i] : 0.0));
			}
		if (turned) power += volume[p] * (g.motion.stress[2][p] - g.water.pressure[p]) * (g.motion.hoop[p] + missing * share[2]);
	}
	return std::abs(power) / size;
}

/// Force of pore pressure on the liquid times any relative velocity against pressure times the volume that it brings, with cell
/// means and a drained free surface at zero pressure.
template <int D> double seepagePairError(bool averaged)
{
	RandomGround<D>                                 g;
	const CellMeans<D>*                             cells = averaged ? &g.cells : nullptr;
	const double                                    rho   = 1000.0;
	FreeSurface<D>                                  surface;
	const std::vector<std::shared_ptr<Boundary<D>>> boundaries { std::make_shared<DrainedBoundary<D>>(Region<D>::freeSurface()) };
	surface.bind(g.points, g.grid, nullptr);
	surface.setBoundaries(boundaries, g.grid);
	std::vector<double> pressure(g.water.pressure, g.water.pressure + g.points.count());
	std::vector<double> before(g.field(g.waterMass), g.field(g.waterMass) + g.points.count());
	g.forBlocks([&](const WeightBlock<D>& w) {
		g.water.map(w, cells);
		surface.map(w);
	});
	surface.collect(g.grid, g.cells, g.range);
	EXPECT_FALSE(surface.patch(0).nodes.empty());
	g.water.nodalPressure(g.range);
	g.forBlocks([&](const WeightBlock<D>& w) { g.water.pressureForce(w); });
	g.water.liquidForce(g.range);
	g.water.drainedForce(surface.patch(0), 0.0);
	double work = 0.0, size = 0.0;
	for (int i = g.range.firstNode; i < g.range.lastNode; ++i)
		for (int a = 0; a < D; ++a) {
			const double relative = g.uniform(-1.0, 1.0);
			const double part     = g.dt * g.water.force[i][a] * relative;
			work += part;
			size += std::abs(part);
			g.water.flux[i][a] = g.water.nodal[i][1] * relative;
		}
	g.forBlocks([&](const WeightBlock<D>& w) { g.water.seep(w, g.dt); });
	StepLedger<D>        ledger(g.grid);
	const StepContext<D> step { g.dt, 1.0, g.dt, g.dt, g.grid, g.range, g.range, g.points.strips(), nullptr, ledger };
	g.water.drain(step, surface.patch(0), true, nullptr);
	g.water.finishExchange(g.range);
	g.forBlocks([&](const WeightBlock<D>& w) { g.water.gather(w, g.field(g.waterMass), nullptr, cells); });
	if (cells) g.water.finishCells(step);
	if (cells) g.forStrips([&](int first, int last) { g.water.receive(*cells, first, last, g.field(g.waterMass), nullptr, g.motion.velocity); });
	double mass = 0.0, largest = 0.0;
	for (int p = 0; p < g.points.count(); ++p) {
		const double received = g.field(g.waterMass)[p] - before[p];
		work += pressure[p] * received / rho;
		mass += received;
		largest = std::max(largest, std::abs(received));
	}
	EXPECT_LT(std::abs(mass + ledger.sum(nullptr).waterOut) / (largest * g.points.count()), 1e-13) << "water made or lost";
	return std::abs(work) / size;
}

} // namespace

TEST(MpmTransfers, StressDoesTheWorkOfTheStrainToRoundOff)
{
	const double plane = stressPairError<2>(), space = stressPairError<3>(), column = stressPairError<2>(true), slice = stressPairError<3>(true);
	std::printf(
	        "sum f.v + sum V (sigma' - p) : L over sum |f v|: %.1e (2-D), %.1e (3-D), one cell thick %.1e (2-D), %.1e (3-D), requirement 1e-13\n", plane,
	        space, column, slice);
	const double round = stressPairError<2>(false, true);
	std::printf("the same about an axis: %.1e\n", round);
	for (const double error : { plane, space, column, slice, round })
		EXPECT_LT(error, 1e-13);
}

TEST(MpmTransfers, BBarSharesWhatItAddsEquallyButForTheThicknessOfASliceOfSpace)
{
	const double third = 1.0 / 3.0;
	const auto   plane = [](double x, double y) { return traceShares(Grid<2>({ 0, 0 }, { x, y }, 1.0)); };
	const auto   space = [](double x, double y, double z) { return traceShares(Grid<3>({ 0, 0, 0 }, { x, y, z }, 1.0)); };
	EXPECT_EQ(plane(4, 3), (Vec<3> { 0.5, 0.5, 0.0 }));
	EXPECT_EQ(plane(1, 3), (Vec<3> { 0.5, 0.5, 0.0 }));
	EXPECT_EQ(space(4, 3, 2), (Vec<3> { third, third, third }));
	EXPECT_EQ(space(4, 1, 2), (Vec<3> { 0.5, 0.0, 0.5 }));
	EXPECT_EQ(space(1, 3, 2), (Vec<3> { 0.0, 0.5, 0.5 }));
	EXPECT_EQ(space(4, 3, 1), (Vec<3> { 0.5, 0.5, 0.0 }));
	EXPECT_EQ(space(1, 1, 3), (Vec<3> { third, third, third }));
	EXPECT_EQ(space(1, 1, 1), (Vec<3> { third, third, third }));
	std::printf("shares of the direct strains: equal ones, and 1/2, 0, 1/2 in a slice of space\n");
}

TEST(MpmTransfers, PorePressureDoesTheWorkOfTheWaterItMovesToRoundOff)
{
	for (const bool averaged : { false, true }) {
		const double plane = seepagePairError<2>(averaged), space = seepagePairError<3>(averaged);
		std::printf(
		        "sum p dm/rho + dt sum w.f over dt sum |w f|, %s: %.1e (2-D), %.1e (3-D), requirement 1e-13\n", averaged ? "cell means" : "points",
		        plane, space);
		EXPECT_LT(plane, 1e-13);
		EXPECT_LT(space, 1e-13);
	}
}

TEST(MpmTransfers, NodesReceiveAllMassAndMomentum)
{
	RandomGround<3> g;
	g.forBlocks([&](const WeightBlock<3>& w) {
		g.motion.map(w);
		g.water.map(w, nullptr);
	});
	double mass = 0.0, momentum = 0.0, force = 0.0, pointMass = 0.0, pointMomentum = 0.0, forceSize = 0.0;
	for (int i = 0; i < g.grid.nodeCount(); ++i) {
		mass += g.motion.nodes[i][g.motion.massAt] + g.water.nodes[i][PoreWater<3>::massAt];
		momentum += g.motion.nodes[i][g.motion.momentumAt] + g.water.nodes[i][PoreWater<3>::momentumAt];
		force += g.motion.nodes[i][g.motion.forceAt];
		forceSize += std::abs(g.motion.nodes[i][g.motion.forceAt]);
	}
	for (int p = 0; p < g.points.count(); ++p) {
		pointMass += g.motion.mass[p] + g.liquid(p);
		pointMomentum += g.motion.mass[p] * g.motion.velocity[0][p] + g.liquid(p) * g.water.velocity[0][p];
	}
	std::printf(
	        "mass %.1e, momentum %.1e, sum of internal forces %.1e (relative)\n", mass / pointMass - 1.0, (momentum - pointMomentum) / pointMass,
	        force / forceSize);
	EXPECT_NEAR(mass / pointMass, 1.0, 1e-13);
	EXPECT_NEAR((momentum - pointMomentum) / pointMass, 0.0, 1e-13);
	EXPECT_NEAR(force / forceSize, 0.0, 1e-13);
}

TEST(MpmTransfers, SurfaceAreaOfABlockIsItsPerimeter)
{
	// a block 0.5 x 0.4 between nodes: the areas along each face add up to its length
	const Grid<2>     grid({ 0.0, 0.0 }, { 1.0, 1.0 }, 0.1);
	MaterialPoints<2> points;
	points.allocate(10 * 8 * 4);
	int p = 0;
	for (int j = 0; j < 16; ++j)
		for (int i = 0; i < 20; ++i, ++p) {
			points.position(0)[p] = 0.237 + (i + 0.5) * 0.025;
			points.position(1)[p] = 0.261 + (j + 0.5) * 0.025;
			points.volume()[p]    = 0.025 * 0.025;
		}
	points.sort(grid);
	const ActiveRange range = ActiveRange::of(grid, points);
	CellMeans<2>      cells;
	cells.allocate(grid, points.count());
	cells.locate(grid, points, 0, points.count());
	FreeSurface<2> surface;
	surface.bind(points, grid, nullptr);
	surface.setBoundaries({ std::make_shared<DrainedBoundary<2>>(Region<2>::freeSurface()) }, grid);
	const auto     shape = makeShapeFunction<2>("quadraticBSpline");
	WeightBlock<2> w;
	for (int first = 0; first < points.count(); first += blockSize) {
		shape->evaluate(grid, { points.position(0), points.position(1) }, first, std::min(blockSize, points.count() - first), w);
		surface.map(w);
	}
	surface.collect(grid, cells, range);
	double right = 0.0, left = 0.0, top = 0.0, bottom = 0.0;
	for (const SurfaceNode<2>& n : surface.patch(0).nodes) {
		(n.area[0] > 0.0 ? right : left) += n.area[0];
		(n.area[1] > 0.0 ? top : bottom) += n.area[1];
	}
	std::printf("faces: right %.6f left %.6f (0.4), top %.6f bottom %.6f (0.5)\n", right, left, top, bottom);
	EXPECT_NEAR(right, 0.4, 0.02);
	EXPECT_NEAR(-left, 0.4, 0.02);
	EXPECT_NEAR(top, 0.5, 0.02);
	EXPECT_NEAR(-bottom, 0.5, 0.02);
}

TEST(MpmDrag, NodeSolutionMatchesTheClosedFormAndKeepsMomentum)
{
	// V = 0.01, n = 0.4: w1 = w0/(1 + dt Q (1/M_s + 1/M_l)); reference value for k = 1e-4, dt = 1e-4: 0.1691713
	const double ms = 0.6 * 2650.0 * 0.01, ml = 0.4 * 1000.0 * 0.01;
	for (const double k : { 1e-2, 1e-4, 1e-10 })
		for (const double dt : { 1e-5, 1e-4, 1e-3 }) {
			const double             q = 0.4 * 0.4 * 1000.0 * 9.81 / k * 0.01;
			const PhaseAccelerations a = NodeDrag(ms, ml, q, dt)(0.0, 1.0, 0.0, 0.0);
			const double             w = 1.0 + dt * (a.liquid - a.solid), closed = 1.0 / (1.0 + dt * q * (1.0 / ms + 1.0 / ml));
			std::printf(
			        "k %.0e dt %.0e: w1/w0 %.9e, closed form %.9e, momentum residual %.1e\n", k, dt, w, closed,
			        (ms * a.solid + ml * a.liquid) / (ml * std::abs(a.liquid)));
			EXPECT_NEAR(w, closed, 1e-12);
			EXPECT_LT(std::abs(ms * a.solid + ml * a.liquid), 1e-12 * ml * std::abs(a.liquid));
			if (k == 1e-4 && dt == 1e-4) {
				EXPECT_NEAR(w, 0.1691713, 1e-7);
			}
		}
}

TEST(MpmDrag, RigidDragGivesCommonAccelerationAndDarcyVelocity)
{
	const double ms = 16.0, ml = 4.0, q = 1e12, dt = 1e-3, fm = 30.0, fl = 11.0;
	const auto   a = NodeDrag(ms, ml, q, dt)(0.0, 0.0, fm, fl);
	EXPECT_NEAR(a.solid / (fm / (ms + ml)), 1.0, 1e-8);
	EXPECT_NEAR(a.liquid / (fm / (ms + ml)), 1.0, 1e-8);
	// relative velocity = (f_l - M_l a)/Q
	const double w = 1.0 + dt * (a.liquid - a.solid) - 1.0;
	EXPECT_NEAR(w * q / (fl - ml * a.solid), 1.0, 1e-2);
}

namespace {

/// A strip of ground whose points move against each other so that no node moves, except at its far ends; what is left of their
/// velocities in the middle after a time [s], over what should be [solid, liquid].
std::array<double, 2> leftOfWhatTheGridDoesNotSee(VelocityTransfer transfer, double step, double time)
{
	GroundSettings<2> s;
	s.upper       = { 12.0, 0.125 };
	s.gridSpacing = 0.125;
	s.motion.emplace();
	s.motion->transfer = transfer;
	s.motion->picTime  = 0.02;
	s.water.emplace();
	s.water->picTime = 0.05;
	s.skeletons.push_back(std::make_shared<ElasticSkeleton<2>>());
	Ground<2> ground(s);
	for (int j = 0; j < 2; ++j)
		for (int i = 2; i < 190; ++i) {
			PointInput<2> p;
			p.position = { (i + 0.5) * 0.0625, (j + 0.5) * 0.0625 };
			p.volume   = 0.0625 * 0.0625;
			p.velocity = { i % 2 ? 1e-3 : -1e-3, 0.0 };
			ground.addPoint(p);
		}
	ground.initialise();
	const int steps = int(std::lround(time / step));
	for (int k = 0; k < steps; ++k)
		ground.step(step);
	std::array<double, 2> left {};
	const char* const     names[] = { "velocity", "liquidVelocity" };
	for (int phase = 0; phase < 2; ++phase) {
		std::vector<double> v(ground.points().count());
		ground.copyById(names[phase], 0, v.data());
		left[phase] = std::abs(v[94]) / (1e-3 * std::exp(-time / (phase ? 0.05 : 0.02)));
	}
	return left;
}

} // namespace

TEST(MpmTransfers, WhatTheGridDoesNotSeeDiesOutInPicTimeWhateverTheStepAndTransfer)
{
	for (const VelocityTransfer transfer : { VelocityTransfer::flip, VelocityTransfer::apic, VelocityTransfer::tpic })
		for (const double step : { 2e-4, 5e-5 }) {
			const auto left = leftOfWhatTheGridDoesNotSee(transfer, step, 2e-3);
			std::printf(
			        "%s, dt %.1e s: velocity left over exp(-t/picTime): solid 1 %+.1e, liquid 1 %+.1e\n",
			        velocityTransferNames()[int(transfer)].c_str(), step, left[0] - 1.0, left[1] - 1.0);
			EXPECT_NEAR(left[0], 1.0, 1e-9);
			EXPECT_NEAR(left[1], 1.0, 1e-9);
		}
}

TEST(MpmTransfers, ByDefaultFlipKeepsWhatTheGridDoesNotSeeForTheTimeThatABodyNeedsToFallByHalfACell)
{
	MotionSettings<2> s;
	s.gravity = { 3.0, -4.0 };
	EXPECT_DOUBLE_EQ(s.usedPicTime(0.25), std::sqrt(0.25 / 9.81)); // gravity below that of the earth
	s.gravity = { 0.0, -981.0 };
	EXPECT_DOUBLE_EQ(s.usedPicTime(0.25), std::sqrt(0.25 / 981.0)); // in a centrifuge
	s.transfer = VelocityTransfer::apic;
	EXPECT_EQ(s.usedPicTime(0.25), 0.0); // as published
	EXPECT_EQ(keptFraction(0.0, 1e-3), 0.0);
	EXPECT_EQ(keptFraction(std::numeric_limits<double>::infinity(), 1e-3), 1.0);
}
