// SPDX-License-Identifier: GPL-2.0-or-later
// The preconditioner of implicit pressure, on matrices whose solution is known.
#include <pkg/mpm/effects/PressureMultigrid.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

using namespace talik;

namespace {

/// Ground of n cells along each axis with 1/ratio of the conductance of a face as storage; water leaves through the top.
/// contrast: conductance of the lower half over that of the upper one.
template <int D> struct Box {
	Grid<D>              grid;
	MaterialPoints<D>    points;
	ActiveRange          range;
	StepLedger<D>        ledger;
	PressureMultigrid<D> multigrid;
	std::mt19937         random { 3 };

	Box(int n, double ratio, double contrast)
	        : grid(Vec<D> {}, upper(n), 1.0)
	        , ledger(grid)
	{
		points.allocate(1);
		for (int a = 0; a < D; ++a)
			points.position(a)[0] = 0.5;
		points.sort(grid);
		range.lastCell = grid.cellCount();
		multigrid.allocate(grid);
		for (int c = 0; c < grid.cellCount(); ++c) {
			const int height = c / grid.cellStride(D - 1) % n;
			auto&     m      = multigrid[c];
			m.storage        = 1.0 / ratio + (height + 1 == n ? 2.0 : 0.0);
			for (int a = 0; a < D; ++a)
				m.conductance[a] = c / grid.cellStride(a) % n + 1 == n ? 0.0 : height < n / 2 ? contrast : 1.0;
		}
		multigrid.build(step());
	}
	static Vec<D> upper(int n)
	{
		Vec<D> u;
		u.fill(n);
		return u;
	}
	StepContext<D> step() { return { 1.0, 1.0, 1.0, 1.0, grid, range, range, points.strips(), nullptr, ledger }; }

	std::vector<double> product(const std::vector<double>& x)
	{
		std::vector<double> y(x.size());
		for (std::size_t c = 0; c < x.size(); ++c) {
			y[c] += multigrid[c].storage * x[c];
			for (int a = 0; a < D; ++a)
				if (const double g = multigrid[c].conductance[a]; g > 0.0) {
					const std::size_t next = c + grid.cellStride(a);
					y[c] += g * (x[c] - x[next]);
					y[next] += g * (x[next] - x[c]);
				}
		}
		return y;
	}
	std::vector<double> preconditioned(const std::vector<double>& r)
	{
		PagedArray<double> from, to;
		from.reset(r.size());
		to.reset(r.size());
		std::copy(r.begin(), r.end(), from.begin());
		multigrid.solve(step(), from, to);
		return { to.begin(), to.end() };
	}
	std::vector<double> drawn()
	{
		std::vector<double> x(grid.cellCount());
		for (double& v : x)
			v = std::uniform_real_distribution<double>(-1.0, 1.0)(random);
		return x;
	}
};

double dotOf(const std::vector<double>& a, const std::vector<double>& b)
{
	double sum = 0.0;
	for (std::size_t k = 0; k < a.size(); ++k)
		sum += a[k] * b[k];
	return sum;
}

/// Iterations of conjugate gradients until the energy of the error is 1e-6 of that of the start; the solution is known.
template <int D> int iterations(int n, double ratio, double contrast)
{
	Box<D>     box(n, ratio, contrast);
	const auto exact = box.drawn();
	auto       error = exact, residual = box.product(exact), z = box.preconditioned(residual), direction = z;
	double     norm   = dotOf(residual, z);
	const auto energy = [&] { return dotOf(error, box.product(error)); };
	const auto start  = energy();
	int        k      = 0;
	for (; k < 200 && energy() > 1e-12 * start; ++k) {
		const auto   image = box.product(direction);
		const double way   = norm / dotOf(direction, image);
		for (std::size_t c = 0; c < error.size(); ++c) {
			error[c] -= way * direction[c];
			residual[c] -= way * image[c];
		}
		z                 = box.preconditioned(residual);
		const double next = dotOf(residual, z);
		for (std::size_t c = 0; c < error.size(); ++c)
			direction[c] = z[c] + next / norm * direction[c];
		norm = next;
	}
	return k;
}

template <int D> void expectFewIterations(std::initializer_list<int> sizes, int most)
{
	for (const double contrast : { 1.0, 1e6, 1e-6 }) {
		std::printf("%d-D, conductance below over that above %g: iterations to 1e-6", D, contrast);
		for (const int n : sizes) {
			const int k = iterations<D>(n, 1e4, contrast);
			std::printf(" %d (%d cells a side)", k, n);
			EXPECT_LE(k, most);
		}
		std::printf(", at most %d\n", most);
	}
}

template <int D> double asymmetry(int n)
{
	Box<D>       box(n, 1e4, 100.0);
	const auto   a = box.drawn(), b = box.drawn(), za = box.preconditioned(a), zb = box.preconditioned(b);
	const double size = std::sqrt(dotOf(a, za) * dotOf(b, zb));
	EXPECT_GT(dotOf(a, za), 0.0);
	return std::abs(dotOf(a, zb) - dotOf(b, za)) / size;
}

} // namespace

TEST(PressureMultigrid, IsSymmetricAndPositiveAsConjugateGradientsNeed)
{
	for (const double off : { asymmetry<2>(13), asymmetry<2>(32), asymmetry<3>(9) }) {
		std::printf("asymmetry %.1e, at most 1e-13\n", off);
		EXPECT_LT(off, 1e-13);
	}
}

TEST(PressureMultigrid, NeedsNoMoreIterationsOnFinerCellsOrWhereConductanceJumps)
{
	expectFewIterations<2>({ 16, 64, 256 }, 24);
	expectFewIterations<3>({ 8, 32 }, 24);
}

TEST(PressureMultigrid, GivesNothingWhereNothingIsStored)
{
	Box<2> box(10, 1e4, 1.0);
	for (int c = 50; c < 60; ++c) {
		box.multigrid[c] = {};
		if (c >= 10) box.multigrid[c - 10].conductance[1] = 0.0;
	}
	for (int c = 0; c < 100; ++c)
		for (int a = 0; a < 2; ++a) {
			const int next = c + box.grid.cellStride(a);
			if (next < 100 && box.multigrid[next].storage == 0.0) box.multigrid[c].conductance[a] = 0.0;
		}
	box.multigrid.build(box.step());
	const auto z = box.preconditioned(std::vector<double>(100, 1.0));
	for (int c = 0; c < 100; ++c)
		EXPECT_EQ(z[c] == 0.0, c >= 50 && c < 60) << "cell " << c;
}
