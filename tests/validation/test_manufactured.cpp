// SPDX-License-Identifier: GPL-2.0-or-later
// A manufactured solution of the coupled small-strain equations of thawed ground: two momentum balances with drag, water mass with
// thermal expansion, heat with conduction. On the unit square between rollers, impermeable and insulated, with
//   X = sin(pi x) cos(pi y),  Y = cos(pi x) sin(pi y),  Z = cos(pi x) cos(pi y),
// all conditions on the walls hold by themselves for
//   u = (A X, B Y) a(t),   w = v_l - v_s = (C X, D Y) c(t),   p = P Z b(t),   T = K Z d(t).
// With div (X, 0) = div (0, Y) = pi Z, grad Z = -pi (X, Y), lap Z = -2 pi^2 Z and
//   div sigma' = (lambda + G) grad div u + G lap u = -pi^2 ((lambda + G)(A + B) + 2 G (A, B)) a (X, Y)
// the sources that make it a solution follow from theory's balances, per volume:
//   M_s b_s = M_s u'' - div sigma' + (1 - n) grad p - Q w           (solid)
//   M_l b_l = M_l (u'' + w') + n grad p + Q w                       (water; Q = n^2 rho_l g/k, M_l = n rho_l)
//   s_w     = n/K_w p' + div u' + n div w - beta_m T'               (water volume; beta_m = n beta_l + (1 - n) beta_s)
//   s_T     = C_m T' - kappa f_T lap T                              (heat; the part that seepage carries is of second order)
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double pi = reference::pi, porosity = 0.4, gravity = 9.81, conductivity = 1e-2, bulkModulus = 2.2e7, timeScale = 2e7;
constexpr double lambda = 8e6, shear = 8e6, omega = 300.0, end = 5e-3;
// strains of 1e-6: what is not linear is a millionth
constexpr double A = 6e-7, B = -2e-7, C = 4e-5, D = 6e-5, P = 100.0, K = 0.02;

struct Wave {
	double phase;
	double value(double t) const { return std::sin(omega * t + phase); }
	double rate(double t) const { return omega * std::cos(omega * t + phase); }
	double second(double t) const { return -omega * omega * value(t); }
};
constexpr Wave a { 0.0 }, c { 0.7 }, b { 1.1 }, d { 1.9 };

struct Shape {
	double x, y, z;
	Shape(double px, double py)
	        : x(std::sin(pi * px) * std::cos(pi * py))
	        , y(std::cos(pi * px) * std::sin(pi * py))
	        , z(std::cos(pi * px) * std::cos(pi * py))
	{}
};

GroundSettings<2> square(int cells)
{
	GroundSettings<2> s;
	s.upper       = { 1.0, 1.0 };
	s.gridSpacing = 1.0 / cells;
	for (const char* side : { "left", "right", "bottom", "top" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
	s.motion.emplace();
	s.motion->picTime = std::numeric_limits<double>::infinity();
	s.heat.emplace();
	s.heat->thermalTimeScale = timeScale;
	s.water.emplace();
	s.water->picTime                            = std::numeric_limits<double>::infinity();
	s.water->state.liquidBulkModulus            = bulkModulus;
	s.water->state.cavitationPressure           = -1e6;
	s.water->permeability.referenceConductivity = conductivity;
	s.water->hydraulicTimeScale                 = 1.0;
	auto skeleton                               = std::make_shared<ElasticSkeleton<2>>();
	skeleton->young                             = shear * (3.0 * lambda + 2.0 * shear) / (lambda + shear);
	skeleton->poisson                           = 0.5 * lambda / (lambda + shear);
	s.skeletons.push_back(skeleton);
	return s;
}

/// The sources of one step of length dt that begins at t, handed to the points.
class Sources {
public:
	explicit Sources(const GroundSettings<2>& s)
	        : mixture_(s.mixture)
	        , solidMass_((1.0 - porosity) * mixture_.solid.density)
	        , liquidMass_(porosity * mixture_.liquid.density)
	{
		const auto n = VolumeFractions::of(porosity, 1.0);
		capacity_    = mixture_.heatCapacity(n);
		conduction_  = mixture_.conductivity(n) * timeScale;
		expansivity_ = porosity * mixture_.liquid.expansivity + (1.0 - porosity) * mixture_.solid.expansivity;
		drag_        = porosity * porosity * mixture_.liquid.density * gravity / conductivity;
	}

	void apply(Ground<2>& ground, double t, double dt) const
	{
		PointFields&                 f = ground.points().fields();
		const std::array<double*, 2> v { f.find("velocity", 0), f.find("velocity", 1) };
		const std::array<double*, 2> vl { f.find("liquidVelocity", 0), f.find("liquidVelocity", 1) };
		double *const water = f.find("waterMass"), *const enthalpy = f.find("enthalpy");
		const double *const temperature = f.find("temperature"), *const volume = ground.points().volume();
		const double both = (lambda + shear) * (A + B);
		for (int p = 0; p < ground.points().count(); ++p) {
			const Shape  s(ground.points().position(0)[p], ground.points().position(1)[p]);
			const double z[2] = { s.x, s.y }, u[2] = { A, B }, w[2] = { C, D };
			for (int i = 0; i < 2; ++i) {
				const double divStress = -pi * pi * (both + 2.0 * shear * u[i]) * a.value(t) * z[i];
				const double gradP = -pi * P * b.value(t) * z[i], qw = drag_ * w[i] * c.value(t) * z[i];
				const double solid = u[i] * a.second(t) * z[i], liquid = solid + w[i] * c.rate(t) * z[i];
				v[i][p] += dt * (solid + (-divStress + (1.0 - porosity) * gradP - qw) / solidMass_);
				vl[i][p] += dt * (liquid + (porosity * gradP + qw) / liquidMass_);
			}
			const double heat = capacity_ * K * s.z * d.rate(t) + 2.0 * pi * pi * conduction_ * K * s.z * d.value(t);
			const double fed  = porosity / bulkModulus * P * s.z * b.rate(t) + pi * s.z * ((A + B) * a.rate(t) + porosity * (C + D) * c.value(t))
			        - expansivity_ * K * s.z * d.rate(t);
			const double mass = mixture_.liquid.density * fed * dt * volume[p];
			water[p] += mass;
			enthalpy[p] += dt * heat * volume[p] + mass * (mixture_.liquid.specificHeat * temperature[p] + mixture_.latentHeat);
		}
	}

private:
	MixtureProperties mixture_;
	double            solidMass_, liquidMass_, capacity_, conduction_, expansivity_, drag_;
};

/// Fields of the cells at the end: displacement x and y [m], relative velocity x and y [m/s], pressure [Pa], temperature [degC].
struct Solution {
	static constexpr int                   count = 6;
	std::array<std::vector<double>, count> cells;
};

Solution computed(int cells, long steps)
{
	const auto s = square(cells);
	Ground<2>  ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 1.0, 1.0 }, [&](PointInput<2>& p) {
		const Shape z(p.position[0], p.position[1]);
		p.porosity    = porosity;
		p.velocity    = { A * a.rate(0.0) * z.x, B * a.rate(0.0) * z.y };
		p.pressure    = P * b.value(0.0) * z.z;
		p.temperature = K * d.value(0.0) * z.z;
	});
	ground.initialise();
	for (int p = 0; p < ground.points().count(); ++p) {
		const Shape z(ground.points().position(0)[p], ground.points().position(1)[p]);
		ground.points().fields().find("liquidVelocity", 0)[p] += C * c.value(0.0) * z.x;
		ground.points().fields().find("liquidVelocity", 1)[p] += D * c.value(0.0) * z.y;
	}
	const Sources sources(s);
	const double  dt = end / steps;
	EXPECT_LE(dt, ground.stableTimeStep().step);
	for (long k = 0; k < steps; ++k) {
		sources.apply(ground, k * dt, dt);
		ground.step(dt);
	}
	Solution                           result;
	std::array<std::vector<double>, 6> points { valuesOf(ground, "displacement", 0),   valuesOf(ground, "displacement", 1),
		                                    valuesOf(ground, "liquidVelocity", 0), valuesOf(ground, "liquidVelocity", 1),
		                                    valuesOf(ground, "pressure"),          valuesOf(ground, "temperature") };
	const auto                         x = valuesOf(ground, "position", 0), y = valuesOf(ground, "position", 1);
	for (int i = 0; i < 2; ++i) {
		const auto solid = valuesOf(ground, "velocity", i);
		for (std::size_t p = 0; p < solid.size(); ++p)
			points[2 + i][p] -= solid[p];
	}
	for (int f = 0; f < Solution::count; ++f) {
		result.cells[f].assign(cells * cells, 0.0);
		for (std::size_t p = 0; p < x.size(); ++p)
			result.cells[f][int(y[p] * cells) * cells + int(x[p] * cells)] += 0.25 * points[f][p];
	}
	return result;
}

/// The solution as means over the four points of a cell, as computed() takes them.
Solution exact(int cells)
{
	Solution result;
	for (auto& field : result.cells)
		field.assign(cells * cells, 0.0);
	for (int j = 0; j < 2 * cells; ++j)
		for (int i = 0; i < 2 * cells; ++i) {
			const Shape  z((i + 0.5) * 0.5 / cells, (j + 0.5) * 0.5 / cells);
			const double values[] = { A * a.value(end) * z.x, B * a.value(end) * z.y, C * c.value(end) * z.x,
				                  D * c.value(end) * z.y, P * b.value(end) * z.z, K * d.value(end) * z.z };
			for (int f = 0; f < Solution::count; ++f)
				result.cells[f][(j / 2) * cells + i / 2] += 0.25 * values[f];
		}
	return result;
}

/// Root mean square difference over the root mean square of the reference, components together.
double difference(const Solution& one, const Solution& other, const Solution& reference, const std::vector<int>& fields)
{
	double sum = 0.0, size = 0.0;
	for (const int f : fields)
		for (std::size_t k = 0; k < one.cells[f].size(); ++k) {
			sum += std::pow(one.cells[f][k] - other.cells[f][k], 2);
			size += std::pow(reference.cells[f][k], 2);
		}
	return std::sqrt(sum / size);
}

struct Quantity {
	const char*      name;
	std::vector<int> fields;
};
const Quantity quantities[] = {
	{ "displacement", { 0, 1 } }, { "relative velocity of the water", { 2, 3 } }, { "pore pressure", { 4 } }, { "temperature", { 5 } }
};

} // namespace

// the time step shrinks with h^2, so that its first order does not cover the second order in space
TEST(Manufactured, CoupledEquationsConvergeInSecondOrderInSpace_slow)
{
	const Solution coarse = computed(8, 40), medium = computed(16, 160), fine = computed(32, 640);
	Drawing        drawing("manufactured_space", "Manufactured solution, errors over h", "log2 of 1/h [1/m]", "log2 of the relative error [-]");
	for (const Quantity& q : quantities) {
		const double      e8 = difference(coarse, exact(8), exact(8), q.fields), e16 = difference(medium, exact(16), exact(16), q.fields);
		const double      e32   = difference(fine, exact(32), exact(32), q.fields);
		const std::string label = std::string("manufactured, ") + q.name;
		for (const auto& [level, error] : { std::pair(3.0, e8), std::pair(4.0, e16), std::pair(5.0, e32) })
			drawing.computed(q.name, level, std::log2(error));
		drawing.reference(q.name, 3.0, 5.0, [=](double level) { return std::log2(e32) + 2.0 * (5.0 - level); });
		expectSmall(label + ": relative error, h = 1/8, eight cells in half a wave", e8, 1.0);
		expectSmall(label + ": relative error, h = 1/32", e32, 0.04);
		expectAtLeast(label + ": order in space, 1/16 to 1/32", std::log2(e16 / e32), 1.8);
	}
}

// successive halvings on one grid, from which the error in space drops out
TEST(Manufactured, CoupledEquationsConvergeInFirstOrderInTime)
{
	const Solution coarse = computed(8, 320), medium = computed(8, 640), fine = computed(8, 1280);
	Drawing        drawing("manufactured_time", "Manufactured solution, change on halving dt", "log2 of the steps [-]", "log2 of the relative change [-]");
	for (const Quantity& q : quantities) {
		const double first = difference(coarse, medium, exact(8), q.fields), second = difference(medium, fine, exact(8), q.fields);
		drawing.computed(q.name, std::log2(640.0), std::log2(first));
		drawing.computed(q.name, std::log2(1280.0), std::log2(second));
		drawing.reference(q.name, std::log2(640.0), std::log2(1280.0), [=](double level) { return std::log2(second) + std::log2(1280.0) - level; });
		expectSmall(std::string("manufactured, ") + q.name + ": change from dt/2 to dt/4", second, 2e-2);
		expectAtLeast(std::string("manufactured, ") + q.name + ": order in time", std::log2(first / second), 0.9);
	}
}
