// SPDX-License-Identifier: GPL-2.0-or-later
// Conduction without phase change against Fourier series and error functions (Carslaw & Jaeger 1959).
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double length = 1.0, initial = 2.0, surface = 12.0;

double diffusivity()
{
	const MixtureProperties m = withoutExpansion();
	const auto              n = VolumeFractions::of(0.4, 1.0);
	return m.conductivity(n) / m.heatCapacity(n);
}

GroundSettings<2> thawedColumn(int cells)
{
	auto s = columnSettings(length / cells, length);
	s.heat.emplace();
	return s;
}

enum class Slab { bothFaces, insulated, sealedHalves, halfSpace };

double exact(Slab slab, double x, double t)
{
	const double a = diffusivity();
	switch (slab) {
		case Slab::bothFaces: return reference::slabBothFaces(x, t, length, a, initial, surface);
		case Slab::insulated: return reference::slabInsulated(x, t, length, a, initial, surface);
		case Slab::sealedHalves: return reference::sealedHalves(x, t, length, a, initial, surface);
		case Slab::halfSpace: break;
	}
	return reference::halfSpace(x, t, a, initial, surface);
}

Ground<2> startedSlab(Slab slab, int cells)
{
	auto s = thawedColumn(cells);
	if (slab != Slab::sealedHalves) addBoundary<WallTemperature<2>>(s, Region<2>::side("bottom"), surface);
	if (slab == Slab::bothFaces) addBoundary<WallTemperature<2>>(s, Region<2>::side("top"), surface);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { length / cells, length },
	        [&](PointInput<2>& p) { p.temperature = slab == Slab::sealedHalves && p.position[1] > 0.5 * length ? surface : initial; });
	ground.initialise();
	return ground;
}

/// Temperatures of the grid cells from the base up: means over the points of a cell. Points of one cell may keep a difference
/// that the grid does not see (here from the jump at the start); it neither conducts nor grows.
std::vector<double> cellTemperatures(const Ground<2>& ground)
{
	const auto          t = valuesOf(ground, "temperature"), y = valuesOf(ground, "position", 1);
	const double        h = ground.settings().gridSpacing;
	std::vector<double> mean(std::lround(length / h), 0.0);
	for (std::size_t p = 0; p < y.size(); ++p)
		mean[int(y[p] / h)] += t[p] / (y.size() / mean.size());
	return mean;
}

/// Root mean square difference of cell temperatures to the solution at Fourier number 0.1, over the jump of 10 K.
double errorOf(Slab slab, int cells)
{
	Ground<2>    ground = startedSlab(slab, cells);
	const double t      = 0.1 * length * length / diffusivity();
	marchTo(ground, t);
	const auto mean = cellTemperatures(ground);
	double     sum  = 0.0;
	for (int c = 0; c < cells; ++c)
		sum += std::pow((mean[c] - exact(slab, (c + 0.5) * length / cells, t)) / (surface - initial), 2);
	return std::sqrt(sum / cells);
}

void expectSecondOrder(Slab slab, const std::string& name)
{
	citing("Carslaw & Jaeger 1959");
	const double coarse = errorOf(slab, 10), medium = errorOf(slab, 20), fine = errorOf(slab, 40);
	expectSmall("V01 " + name + ": rms error over 10 K, h = L/10", coarse, 2e-2);
	expectSmall("V01 " + name + ": rms error over 10 K, h = L/20", medium, 1e-2);
	expectSmall("V01 " + name + ": rms error over 10 K, h = L/40", fine, 5e-3);
	expectAtLeast("V01 " + name + ": order of convergence, L/10 to L/40", 0.5 * std::log2(coarse / fine), 1.7);
}

} // namespace

TEST(HeatConduction, SlabWithBothFacesHeatedConvergesInSecondOrder) { expectSecondOrder(Slab::bothFaces, "slab, both faces at 12 degC"); }

TEST(HeatConduction, SlabWithInsulatedFaceConvergesInSecondOrder) { expectSecondOrder(Slab::insulated, "slab, one face insulated"); }

TEST(HeatConduction, SealedHalvesConvergeInSecondOrder) { expectSecondOrder(Slab::sealedHalves, "sealed halves 2|12 degC"); }

TEST(HeatConduction, TabulatedTemperaturesAtAQuarterAndHalfTheSlab)
{
	struct Row {
		Slab        slab;
		const char* name;
		double      quarter, half;
	};
	citing("Carslaw & Jaeger 1959");
	Drawing drawing("conduction", "V01 conduction, h = L/40, Fo = 0.1", "x/L [-]", "temperature [degC]");
	// Fourier number 0.1; the half space is the slab before its far face matters, so it is compared at x = 0.25 only
	for (const Row& row : { Row { Slab::bothFaces, "both faces", 8.64403, 7.25513 }, Row { Slab::insulated, "insulated", 7.76241, 4.64349 } }) {
		Ground<2> ground = startedSlab(row.slab, 40);
		marchTo(ground, 0.1 * length * length / diffusivity());
		const auto mean = cellTemperatures(ground);
		for (std::size_t c = 0; c < mean.size(); ++c)
			drawing.computed(row.name, (c + 0.5) / mean.size(), mean[c]);
		drawing.reference(row.name, 0.0, 1.0, [&](double x) { return exact(row.slab, x * length, 0.1 * length * length / diffusivity()); });
		const auto t = valuesOf(ground, "temperature"), y = valuesOf(ground, "position", 1);
		const auto at = [&](double x) {
			// mean of the two rows beside x: second-order accurate
			double sum = 0.0;
			int    n   = 0;
			for (std::size_t p = 0; p < y.size(); ++p)
				if (std::abs(y[p] - x) < 0.5 * length / 40) sum += t[p], ++n;
			return sum / n;
		};
		expectScaled(std::string("V01 ") + row.name + ": T(0.25 L), Fo = 0.1, h = L/40 [degC]", at(0.25), row.quarter, 10.0, 5e-3);
		expectScaled(std::string("V01 ") + row.name + ": T(0.5 L), Fo = 0.1, h = L/40 [degC]", at(0.5), row.half, 10.0, 5e-3);
	}
}

TEST(HeatConduction, HeatTakenUpThroughAWallIsThatOfTheHalfSpace)
{
	citing("Carslaw & Jaeger 1959");
	Ground<2>    ground = startedSlab(Slab::insulated, 40);
	const double t      = 0.02 * length * length / diffusivity(); // the far face is still at rest
	marchTo(ground, t);
	const MixtureProperties m       = withoutExpansion();
	const double            kappa   = m.conductivity(VolumeFractions::of(0.4, 1.0));
	const double            perArea = 2.0 * kappa * (surface - initial) * std::sqrt(t / (reference::pi * diffusivity()));
	expectRelative("V01 half space: heat taken up, h = L/40 [J/m^2]", ground.balance().heatIn * 40.0, perArea, 1e-2);
}

TEST(HeatConduction, SealedGroundKeepsItsHeat)
{
	Ground<2>    ground = startedSlab(Slab::sealedHalves, 20);
	const double before = ground.balance().enthalpy;
	marchTo(ground, 0.5 * length * length / diffusivity());
	expectSmall("V01 sealed slab: relative drift of heat, Fo = 0.5", ground.balance().enthalpy / before - 1.0, 1e-12);
}

TEST(HeatConduction, HeatOfAWallIsAccountedForToRoundOff)
{
	Ground<2>    ground = startedSlab(Slab::bothFaces, 20);
	const double before = ground.balance().enthalpy;
	marchTo(ground, 0.2 * length * length / diffusivity());
	const auto after = ground.balance();
	expectSmall("V01 heated slab: (gain - logged heat)/logged heat", (after.enthalpy - before - after.heatIn) / after.heatIn, 1e-12);
}

// Square whose left wall is warm and whose other walls are cold: T = sum over odd n of 4/(n pi) sin(n pi y) sinh(n pi (1 - x))/sinh(n pi), over the jump.
// Two walls meet in each corner; the order in which they are listed must not matter.
TEST(HeatConduction, CornersOfWallsLieBetweenTheirTemperatures)
{
	citing("Carslaw & Jaeger 1959, 5.3");
	const auto exactAt = [](double x, double y) {
		double sum = 0.0;
		for (int n = 1; n < 400; n += 2)
			sum += 4.0 / (n * M_PI) * std::sin(n * M_PI * y) * (std::exp(-n * M_PI * x) - std::exp(-n * M_PI * (2.0 - x)))
			        / (1.0 - std::exp(-2.0 * n * M_PI));
		return sum;
	};
	std::vector<double> first;
	for (const std::vector<const char*>& order : { std::vector<const char*> { "left", "bottom", "right", "top" }, { "top", "right", "bottom", "left" } }) {
		GroundSettings<2> s;
		s.upper       = { 1.0, 1.0 };
		s.gridSpacing = 0.1;
		s.mixture     = withoutExpansion();
		s.heat.emplace();
		for (const std::string side : order)
			addBoundary<WallTemperature<2>>(s, Region<2>::side(side), side == "left" ? 10.0 : 0.0);
		Ground<2> ground(s);
		fillBox(ground, { 0.0, 0.0 }, { 1.0, 1.0 }, [](PointInput<2>& p) { p.temperature = 2.5; });
		ground.initialise();
		marchTo(ground, 1.0 / diffusivity());
		const auto          t = valuesOf(ground, "temperature"), x = valuesOf(ground, "position", 0), y = valuesOf(ground, "position", 1);
		std::vector<double> mean(100, 0.0);
		for (std::size_t p = 0; p < t.size(); ++p)
			mean[int(x[p] / 0.1) + 10 * int(y[p] / 0.1)] += 0.25 * t[p];
		if (!first.empty()) {
			double apart = 0.0;
			for (std::size_t p = 0; p < t.size(); ++p)
				apart = std::max(apart, std::abs(t[p] - first[p]));
			expectSmall("square with a warm wall: listed in another order, largest difference [K] of 10 K", apart, 1e-6);
			continue;
		}
		first       = t;
		double most = 0.0, beyond = 0.0;
		for (int c = 0; c < 100; ++c) {
			const double x = (c % 10 + 0.5) * 0.1, y = (c / 10 + 0.5) * 0.1;
			if (std::hypot(x, std::min(y, 1.0 - y)) > 0.25) most = std::max(most, std::abs(mean[c] / 10.0 - exactAt(x, y)));
		}
		for (const double value : t)
			beyond = std::max({ beyond, value - 10.0, -value });
		const double corner = 0.5 * (mean[0] + mean[90]);
		expectSmall("square with a warm wall: largest error of a cell 0.25 m from the corners of the warm wall, over 10 K, h = L/10", most, 2e-2);
		expectScaled("square with a warm wall: cell in the corner of the warm wall [degC], h = L/10", corner, 10.0 * exactAt(0.05, 0.05), 10.0, 5e-2);
		expectSmall("square with a warm wall: how far points are outside of 0 to 10 degC [K]", beyond, 0.1);
	}
}

// Manufactured: with constant heat production Q between two cold walls, T = T_w + Q x (L - x)/(2 kappa) in the steady state
TEST(HeatConduction, ConstantHeatProductionGivesTheParabola)
{
	citing("steady state, parabola");
	const auto errorAt = [](int cells) {
		auto         s     = thawedColumn(cells);
		const double kappa = s.mixture.conductivity(VolumeFractions::of(0.4, 1.0));
		const double peak  = 10.0;
		s.heat->source     = peak * 8.0 * kappa / (length * length);
		for (const char* side : { "bottom", "top" })
			addBoundary<WallTemperature<2>>(s, Region<2>::side(side), initial);
		Ground<2>  ground(s);
		const auto parabola = [&](double x) { return initial + peak * 4.0 * x * (length - x) / (length * length); };
		fillBox(ground, { 0.0, 0.0 }, { length / cells, length }, [&](PointInput<2>& p) { p.temperature = initial; });
		ground.initialise();
		marchTo(ground, 1.5 * length * length / diffusivity());
		const auto mean  = cellTemperatures(ground);
		double     worst = 0.0;
		for (int c = 0; c < cells; ++c)
			worst = std::max(worst, std::abs(mean[c] - parabola((c + 0.5) * length / cells)) / peak);
		return worst;
	};
	const double coarse = errorAt(10), fine = errorAt(20);
	expectSmall("heat production between cold walls: largest error, h = L/10", coarse, 2e-2);
	expectSmall("heat production between cold walls: largest error, h = L/20", fine, 1e-2);
	expectAtLeast("heat production between cold walls: order of convergence, L/10 to L/20", std::log2(coarse / fine), 1.6);
}

namespace {

/// Column of thawed ground, along the last axis, between walls of the initial temperature, with a source of q [W/m^3] from a to b; largest error
/// of a point's temperature in the steady state over the peak.
template <int D> double errorOfSource(int cells, double a, double b, Balance<D>* balance = nullptr)
{
	const double      h = length / cells, q = 500.0;
	GroundSettings<D> s;
	s.upper.fill(h);
	s.upper[D - 1] = length;
	s.gridSpacing  = h;
	s.mixture      = withoutExpansion();
	s.heat.emplace();
	auto lower = Region<D>::filled(-1.0), upper = Region<D>::filled(2.0);
	lower[D - 1] = a;
	upper[D - 1] = b;
	s.boundaries.push_back(std::make_shared<HeatSource<D>>(Region<D>::nodeBox(lower, upper), q));
	for (const char* side : { "bottom", "top" })
		s.boundaries.push_back(std::make_shared<WallTemperature<D>>(Region<D>::side(side), initial));
	Ground<D> ground(s);
	for (int k = 0; k < 2 * cells * (1 << (D - 1)); ++k) {
		PointInput<D> p;
		for (int axis = 0; axis < D; ++axis)
			p.position[axis] = axis == D - 1 ? (k / (1 << (D - 1)) + 0.5) * 0.5 * h : ((k >> axis) % 2 + 0.5) * 0.5 * h;
		p.volume      = std::pow(0.5 * h, D);
		p.temperature = initial;
		ground.addPoint(p);
	}
	ground.initialise();
	const double before = ground.balance().enthalpy;
	marchTo(ground, 1.5 * length * length / diffusivity());
	const double kappa = s.mixture.conductivity(VolumeFractions::of(0.4, 1.0));
	const auto   twice = [&](double x) { return 0.5 * (std::pow(std::max(0.0, x - a), 2) - std::pow(std::max(0.0, x - b), 2)); };
	const auto   above = [&](double x) { return q / kappa * (twice(length) * x / length - twice(x)); };
	double       peak = 0.0, worst = 0.0;
	for (int k = 0; k <= 1000; ++k)
		peak = std::max(peak, above(k * 1e-3 * length));
	const auto t = valuesOf(ground, "temperature"), x = valuesOf(ground, "position", D - 1);
	for (std::size_t p = 0; p < t.size(); ++p)
		worst = std::max(worst, std::abs(t[p] - initial - above(x[p])) / peak);
	if (!balance) return worst;
	*balance = ground.balance();
	balance->enthalpy -= before;
	return worst;
}

template <int D> void expectSource(const std::string& where)
{
	const std::string name = "heat source in a slab, " + where + ": ";
	expectSmall(name + "largest error over the peak q L^2/(8 kappa), whole slab, h = L/20", errorOfSource<D>(20, 0.0, length), 1e-2);
	const double coarse = errorOfSource<D>(10, 0.33, 0.71);
	Balance<D>   balance;
	const double fine = errorOfSource<D>(20, 0.33, 0.71, &balance);
	expectSmall(name + "largest error over the peak, from 0.33 to 0.71 L, h = L/20", fine, 2e-2);
	expectAtLeast(name + "order of convergence, L/10 to L/20", std::log2(coarse / fine), 1.0);
	const double produced = 500.0 * 0.38 * length * std::pow(length / 20, D - 1) * balance.time;
	expectSmall(name + "(gain - logged heat)/heat produced", (balance.enthalpy - balance.heatIn) / produced, 1e-11);
}

} // namespace

TEST(HeatConduction, SourceInPartOfASlabGivesTheParabolaInItAndLinesBeside)
{
	citing("steady state, parabola and lines");
	expectSource<2>("plane");
	expectSource<3>("space");
}

TEST(HeatConduction, SourceThatChangesInTimeGivesItsPowerTimesItsAreaToFrozenGroundThatThaws)
{
	GroundSettings<2> s;
	s.upper       = { 2.0, 2.0 };
	s.gridSpacing = 0.1;
	s.heat.emplace();
	s.freezing         = makeFreezingCurve();
	const double power = 4e4, hour = 3600.0, radius = 0.37;
	addBoundary<HeatSource<2>>(
	        s, Region<2>::disc({ 1.03 - radius, 0.94 - radius }, { 1.03 + radius, 0.94 + radius }),
	        TimeTable({ 0.0, hour, 2.0 * hour, 3.0 * hour }, { 0.0, power, power, 0.0 }));
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 2.0, 2.0 }, [](PointInput<2>& p) { p.temperature = -2.0; });
	ground.initialise();
	const auto before = ground.balance();
	marchTo(ground, 4.0 * hour, 60.0);
	const auto after = ground.balance();
	citing("power times area");
	expectRelative("heat source in a disc, two hours of full power: heat [J/m]", after.heatIn, 2.0 * hour * power * M_PI * radius * radius, 5e-3);
	expectSmall(
	        "heat source in a disc, two hours of full power: (gain - logged heat)/gain", (after.enthalpy - before.enthalpy - after.heatIn) / after.heatIn,
	        1e-12);
	expectAtLeast("heat source in a disc, two hours of full power: ice that melted [kg/m]", before.iceMass - after.iceMass, 1.0);
}
