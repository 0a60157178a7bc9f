// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/boundary/Boundary.hpp>
#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

using namespace talik;

namespace {

template <int D> Grid<D> testGrid()
{
	Vec<D> lower, upper;
	for (int a = 0; a < D; ++a) {
		lower[a] = -0.3 * (a + 1);
		upper[a] = lower[a] + 0.1 * (6 + 5 * a);
	}
	return Grid<D>(lower, upper, 0.1);
}

struct ShapeErrors {
	double unity = 0.0, gradientSum = 0.0, position = 0.0, slope = 0.0, lowest = 1.0;
};

/// Largest violations over random points and points on the walls.
template <int D> ShapeErrors shapeErrors(const std::string& name)
{
	const Grid<D>                           grid  = testGrid<D>();
	const std::unique_ptr<ShapeFunction<D>> shape = makeShapeFunction<D>(name);
	std::mt19937                            random(7);
	std::uniform_real_distribution<double>  uniform(0.0, 1.0);
	constexpr int                           count = blockSize;
	constexpr double                        step  = 1e-6;
	std::vector<double>                     x[D], ahead[D];
	for (int a = 0; a < D; ++a)
		for (int k = 0; k < count; ++k) {
			double s = uniform(random);
			if (k < 2) s = k; // on the walls
			x[a].push_back(grid.lower()[a] + s * (grid.upper()[a] - grid.lower()[a]));
		}
	ShapeErrors                  e;
	WeightBlock<D>               w;
	std::array<const double*, D> p;
	for (int a = 0; a < D; ++a)
		p[a] = x[a].data();
	shape->evaluate(grid, p, 0, count, w);
	for (int k = 0; k < count; ++k) {
		double sum = 0.0;
		Vec<D> gradients {}, centre {};
		overNodes<D>(w, k, [&](int node, double s, const Vec<D>& g) {
			EXPECT_GE(node, 0);
			EXPECT_LT(node, grid.nodeCount());
			sum += s;
			e.lowest         = std::min(e.lowest, s);
			const auto where = grid.nodeOf(node);
			for (int a = 0; a < D; ++a) {
				gradients[a] += g[a];
				centre[a] += s * grid.nodePosition(a, where[a]);
			}
		});
		e.unity = std::max(e.unity, std::abs(sum - 1.0));
		for (int a = 0; a < D; ++a) {
			e.gradientSum = std::max(e.gradientSum, std::abs(gradients[a]) * grid.spacing());
			e.position    = std::max(e.position, std::abs(centre[a] - x[a][k]) / grid.spacing());
		}
	}
	// slopes against difference quotients of the values
	for (int k = 2; k < count; ++k)
		for (int a = 0; a < D; ++a) {
			double         before[supportNodes], after[supportNodes];
			WeightBlock<D> moved;
			for (int side = -1; side <= 1; side += 2) {
				std::vector<double> shifted = x[a];
				shifted[k] += side * step;
				auto q = p;
				q[a]   = shifted.data();
				shape->evaluate(grid, q, 0, count, moved);
				for (int i = 0; i < supportNodes; ++i)
					(side < 0 ? before : after)[i] = moved.base[k] == w.base[k] ? moved.value[a][i][k] : NAN;
			}
			for (int i = 0; i < supportNodes; ++i)
				if (std::isfinite(after[i] + before[i]))
					e.slope = std::max(e.slope, std::abs((after[i] - before[i]) / (2.0 * step) - w.slope[a][i][k]) * grid.spacing());
		}
	return e;
}

} // namespace

TEST(MpmShapeFunctions, PartitionUnityReproducePositionAndHaveTrueSlopes)
{
	for (const std::string& name : shapeFunctionNames()) {
		const ShapeErrors plane = shapeErrors<2>(name), space = shapeErrors<3>(name);
		std::printf(
		        "%s: sum S - 1: %.1e %.1e, h sum grad S: %.1e %.1e, (sum S x_I - x)/h: %.1e %.1e, slope: %.1e %.1e (2-D, 3-D)\n", name.c_str(),
		        plane.unity, space.unity, plane.gradientSum, space.gradientSum, plane.position, space.position, plane.slope, space.slope);
		for (const ShapeErrors& e : { plane, space }) {
			EXPECT_LT(e.unity, 1e-14);
			EXPECT_LT(e.gradientSum, 1e-13);
			EXPECT_LT(e.position, 1e-13);
			EXPECT_LT(e.slope, 1e-6);
			EXPECT_GE(e.lowest, -1e-14);
		}
	}
}

TEST(MpmShapeFunctions, QuadraticSplineHasTheTabulatedValues)
{
	// N(0) = 3/4, N(1/2) = 1/2, N(1) = 1/8, N'(1/2) = -1/h
	const Grid<2>  grid({ 0.0, 0.0 }, { 4.0, 4.0 }, 1.0);
	const auto     shape = makeShapeFunction<2>("quadraticBSpline");
	const double   x[]   = { 2.0, 2.5 };
	WeightBlock<2> w;
	shape->evaluate(grid, { x, x }, 0, 2, w);
	EXPECT_DOUBLE_EQ(w.value[0][0][0], 0.125);
	EXPECT_DOUBLE_EQ(w.value[0][1][0], 0.75);
	EXPECT_DOUBLE_EQ(w.value[0][2][0], 0.125);
	EXPECT_DOUBLE_EQ(w.value[0][0][1], 0.5);
	EXPECT_DOUBLE_EQ(w.value[0][1][1], 0.5);
	EXPECT_DOUBLE_EQ(w.slope[0][0][1], -1.0);
	EXPECT_DOUBLE_EQ(w.slope[0][1][1], 1.0);
}

TEST(MpmShapeFunctions, UnknownNameIsRefusedWithTheKnownOnes)
{
	try {
		makeShapeFunction<2>("cubic");
		FAIL() << "accepted";
	} catch (const std::invalid_argument& e) {
		EXPECT_NE(std::string(e.what()).find("cubic"), std::string::npos);
		EXPECT_NE(std::string(e.what()).find("quadraticBSpline"), std::string::npos);
	}
}

TEST(MpmGrid, IndicesAndPositionsAgree)
{
	const Grid<3> grid = testGrid<3>();
	EXPECT_EQ(grid.slowAxis(), 2);
	EXPECT_EQ(grid.nodeCount(), 9 * 14 * 19);
	for (int index = 0; index < grid.nodeCount(); ++index)
		ASSERT_EQ(grid.nodeIndex(grid.nodeOf(index)), index);
	EXPECT_NEAR(grid.nodePosition(1, 1), grid.lower()[1], 1e-15);
	EXPECT_NEAR(grid.nodePosition(1, grid.cells(1) + 1), grid.upper()[1], 1e-12);
}

TEST(MpmGrid, BadBoxesAreRefusedByName)
{
	const auto message = [](const Vec<2>& lower, const Vec<2>& upper, double h) -> std::string {
		try {
			Grid<2> grid(lower, upper, h);
		} catch (const std::invalid_argument& e) {
			return e.what();
		}
		return "accepted";
	};
	EXPECT_NE(message({ 0, 0 }, { 1, 1 }, 0.0).find("gridSpacing"), std::string::npos);
	EXPECT_NE(message({ 0, 0 }, { 1, 1 }, NAN).find("gridSpacing"), std::string::npos);
	EXPECT_NE(message({ 0, 0 }, { 1, 1.05 }, 0.1).find("upper.y"), std::string::npos);
	EXPECT_NE(message({ 0, 0 }, { -1, 1 }, 0.1).find("upper.x"), std::string::npos);
	EXPECT_NE(message({ NAN, 0 }, { 1, 1 }, 0.1).find("lower.x"), std::string::npos);
}

TEST(MpmPoints, SortingKeepsEachPointsFieldsTogetherAndOrdersCells)
{
	const Grid<2>     grid = testGrid<2>();
	MaterialPoints<2> points;
	const auto        mark = points.fields().declare("mark", "test", "-", 1);
	points.allocate(500);
	std::mt19937                           random(3);
	std::uniform_real_distribution<double> uniform(0.0, 1.0);
	std::vector<Vec<2>>                    start(500);
	for (int p = 0; p < 500; ++p) {
		for (int a = 0; a < 2; ++a)
			points.position(a)[p] = start[p][a] = grid.lower()[a] + uniform(random) * (grid.upper()[a] - grid.lower()[a]);
		points.fields().component(mark)[p] = p;
		points.skeletons()[p]              = p % 3;
	}
	points.sort(grid);
	int lastCell = -1, lastId = -1;
	for (int k = 0; k < 500; ++k) {
		const int id = points.id(k);
		ASSERT_EQ(points.place(id), k);
		ASSERT_EQ(points.position(0)[k], start[id][0]);
		ASSERT_EQ(points.fields().component(mark)[k], id);
		ASSERT_EQ(points.skeletons()[k], id % 3);
		const int cell = int((points.position(0)[k] - grid.lower()[0]) / 0.1) * grid.cellStride(0)
		        + int((points.position(1)[k] - grid.lower()[1]) / 0.1) * grid.cellStride(1);
		ASSERT_GE(cell, lastCell);
		if (cell == lastCell) {
			ASSERT_GT(id, lastId) << "sorting is not stable";
		}
		lastCell = cell;
		lastId   = id;
	}
	EXPECT_EQ(points.strips().first.back(), 500);
}

TEST(MpmTimeTable, IsLinearBetweenInstantsAndConstantOutside)
{
	const TimeTable t({ 1.0, 3.0, 4.0 }, { -5.0, 10.0, 10.0 });
	EXPECT_DOUBLE_EQ(t.at(0.0), -5.0);
	EXPECT_DOUBLE_EQ(t.at(2.0), 2.5);
	EXPECT_DOUBLE_EQ(t.at(9.0), 10.0);
	EXPECT_DOUBLE_EQ(TimeTable(7.0).at(123.0), 7.0);
	EXPECT_THROW(TimeTable({ 1.0, 1.0 }, { 0.0, 1.0 }).validate("x"), std::invalid_argument);
	EXPECT_THROW(TimeTable({ 1.0, 2.0 }, { 0.0 }).validate("x"), std::invalid_argument);
	EXPECT_THROW(TimeTable({ 1.0 }, { NAN }).validate("x"), std::invalid_argument);
}
