// SPDX-License-Identifier: GPL-2.0-or-later
// Affine velocity transfers: adjointness, momentum, angular momentum and linear fields, on random points and nodal velocities.
#include <pkg/mpm/effects/AffineVelocity.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

using namespace talik;

namespace {

template <int D> struct RandomPoints {
	Grid<D>                           grid { filled(0.0), filled(1.0), 0.1 };
	MotionSettings<D>                 settings;
	MaterialPoints<D>                 points;
	SolidMotion<D>                    motion { points.fields(), settings };
	AffineVelocity<D>                 affine;
	std::unique_ptr<ShapeFunction<D>> shape;
	std::mt19937                      random { 5 };

	static Vec<D> filled(double value)
	{
		Vec<D> v;
		v.fill(value);
		return v;
	}
	double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }

	RandomPoints(VelocityTransfer transfer, const std::string& shapeName)
	        : affine(points.fields(), transfer)
	        , shape(makeShapeFunction<D>(shapeName))
	{
		settings.transfer = transfer;
		motion.kept       = 0.0;
		points.allocate(D == 2 ? 300 : 600);
		motion.bind(points, grid);
		for (int p = 0; p < points.count(); ++p) {
			for (int a = 0; a < D; ++a) {
				points.position(a)[p] = uniform(0.15, 0.85);
				motion.velocity[a][p] = uniform(-1.0, 1.0);
			}
			for (double* c : affine.gradient)
				c[p] = uniform(-10.0, 10.0);
			motion.mass[p] = uniform(0.5, 1.5);
		}
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
	void map()
	{
		forBlocks([&](const WeightBlock<D>& w) {
			motion.map(w);
			affine.map(grid, w, motion);
		});
	}
	void gather()
	{
		forBlocks([&](const WeightBlock<D>& w) {
			motion.gather(w, 0.0);
			affine.gather(grid, w, motion);
		});
	}
	double nodePosition(int node, int axis) const { return grid.nodePosition(axis, grid.nodeOf(node)[axis]); }
	/// Second moment of the weights of every point along an axis, summed the long way.
	std::vector<double> secondMoments(int axis)
	{
		std::vector<double> moment(points.count(), 0.0);
		forBlocks([&](const WeightBlock<D>& w) {
			for (int k = 0; k < w.count; ++k)
				overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) {
					const double d = nodePosition(node, axis) - points.position(axis)[w.first + k];
					moment[w.first + k] += s * d * d;
				});
		});
		return moment;
	}
};

/// sum_I (momentum of node).u_I against sum_p m (v.v' + C D : C') for random u that the points gather as v', C'.
template <int D> double adjointError(const std::string& shape)
{
	RandomPoints<D>                    g(VelocityTransfer::apic, shape);
	std::array<std::vector<double>, D> moment;
	for (int a = 0; a < D; ++a)
		moment[a] = g.secondMoments(a);
	g.map();
	double power = 0.0, size = 0.0;
	for (int i = 0; i < g.grid.nodeCount(); ++i)
		for (int a = 0; a < D; ++a) {
			const double u                              = g.uniform(-1.0, 1.0);
			g.motion.solved[i][a]                       = u;
			g.motion.solved[i][g.motion.velocityAt + a] = u;
			power += g.motion.nodes[i][g.motion.momentumAt + a] * u;
			size += std::abs(g.motion.nodes[i][g.motion.momentumAt + a] * u);
		}
	const int           n = g.points.count();
	std::vector<double> v, c;
	for (int a = 0; a < D; ++a)
		v.insert(v.end(), g.motion.velocity[a], g.motion.velocity[a] + n);
	for (int k = 0; k < D * D; ++k)
		c.insert(c.end(), g.affine.gradient[k], g.affine.gradient[k] + n);
	g.gather();
	for (int p = 0; p < n; ++p)
		for (int i = 0; i < D; ++i) {
			power -= g.motion.mass[p] * v[i * n + p] * g.motion.velocity[i][p];
			for (int j = 0; j < D; ++j)
				power -= g.motion.mass[p] * c[(i * D + j) * n + p] * moment[j][p] * g.affine.gradient[i * D + j][p];
		}
	return std::abs(power) / size;
}

/// Largest difference of the points' velocity and gradient to a linear field that the nodes carry.
template <int D> double linearFieldError(VelocityTransfer transfer, const std::string& shape)
{
	RandomPoints<D> g(transfer, shape);
	double          a[D][D + 1];
	for (auto& row : a)
		for (double& entry : row)
			entry = g.uniform(-1.0, 1.0);
	const auto field = [&](int i, const auto& coordinate) {
		double v = a[i][D];
		for (int j = 0; j < D; ++j)
			v += a[i][j] * coordinate(j);
		return v;
	};
	for (int node = 0; node < g.grid.nodeCount(); ++node)
		for (int i = 0; i < D; ++i)
			g.motion.solved[node][i] = g.motion.solved[node][g.motion.velocityAt + i] = field(i, [&](int j) { return g.nodePosition(node, j); });
	g.gather();
	double worst = 0.0;
	for (int p = 0; p < g.points.count(); ++p)
		for (int i = 0; i < D; ++i) {
			worst = std::max(worst, std::abs(g.motion.velocity[i][p] - field(i, [&](int j) { return g.points.position(j)[p]; })));
			for (int j = 0; j < D; ++j)
				worst = std::max(worst, std::abs(g.affine.gradient[i * D + j][p] - a[i][j]));
		}
	return worst;
}

} // namespace

TEST(MpmAffine, PointsToGridAndGridToPointsAreAdjointToRoundOff)
{
	for (const char* shape : { "quadraticBSpline", "gimp" }) {
		const double plane = adjointError<2>(shape), space = adjointError<3>(shape);
		std::printf("%s: sum p_I.u_I - sum m (v.v' + C D : C') over sum |p_I.u_I|: %.1e (2-D), %.1e (3-D), requirement 1e-13\n", shape, plane, space);
		EXPECT_LT(plane, 1e-13);
		EXPECT_LT(space, 1e-13);
	}
}

TEST(MpmAffine, PointsTakeALinearVelocityFieldOfTheNodesExactly)
{
	for (const VelocityTransfer transfer : { VelocityTransfer::apic, VelocityTransfer::tpic })
		for (const char* shape : { "quadraticBSpline", "gimp" }) {
			const double plane = linearFieldError<2>(transfer, shape), space = linearFieldError<3>(transfer, shape);
			std::printf(
			        "%s, %s: largest error of v and C against a linear field: %.1e (2-D), %.1e (3-D), requirement 1e-12\n",
			        velocityTransferNames()[int(transfer)].c_str(), shape, plane, space);
			EXPECT_LT(plane, 1e-12);
			EXPECT_LT(space, 1e-12);
		}
}

TEST(MpmAffine, NodesReceiveMomentumAndAngularMomentumOfThePoints)
{
	for (const char* shape : { "quadraticBSpline", "gimp" }) {
		RandomPoints<2> g(VelocityTransfer::apic, shape);
		const auto      dx = g.secondMoments(0), dy = g.secondMoments(1);
		g.map();
		double momentum = 0.0, spin = 0.0, size = 0.0;
		for (int i = 0; i < g.grid.nodeCount(); ++i) {
			const double* r = g.motion.nodes[i] + g.motion.momentumAt;
			momentum += r[0] + r[1];
			spin += g.nodePosition(i, 0) * r[1] - g.nodePosition(i, 1) * r[0];
		}
		for (int p = 0; p < g.points.count(); ++p) {
			const double m = g.motion.mass[p], vx = g.motion.velocity[0][p], vy = g.motion.velocity[1][p];
			momentum -= m * (vx + vy);
			// x cross v of the point, and of the velocity within it
			spin -= m
			        * (g.points.position(0)[p] * vy - g.points.position(1)[p] * vx + g.affine.gradient[2][p] * dx[p]
			           - g.affine.gradient[1][p] * dy[p]);
			size += m * (std::abs(vx) + std::abs(vy));
		}
		std::printf("%s: momentum %.1e, angular momentum %.1e of their size, requirement 1e-13\n", shape, momentum / size, spin / size);
		EXPECT_LT(std::abs(momentum / size), 1e-13);
		EXPECT_LT(std::abs(spin / size), 1e-13);
	}
}
