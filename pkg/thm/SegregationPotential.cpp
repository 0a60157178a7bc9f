// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/thm/SegregationPotential.hpp>

#include <algorithm>

namespace talik {

namespace {
	constexpr double kelvin = 273.15, gravity = Permeability::gravity;
} // namespace

void SegregationSettings::validate(const std::string& prefix) const
{
	const double sp = segregationPotential;
	requireSetting(
	        std::isnan(sp) || sp == 0.0 || (sp >= 1e-13 && sp <= 1e-6), prefix + "segregationPotential", sp,
	        "must be 0 or lie between 1e-13 and 1e-6 m^2/(s K); 1 mm^2/(s K), the usual unit, is 1e-6 m^2/(s K), and soils have 1e-10 to 4e-9; leave "
	        "it out to have it computed from permeability, freezing curve and load");
	requireSetting(
	        pressureDecay >= 0.0 && pressureDecay <= 1e-3, prefix + "pressureDecay", pressureDecay,
	        "must lie between 0 and 1e-3 1/Pa; 1/MPa, the usual unit, is 1e-6 1/Pa, and soils have 1e-6 to 1e-5");
	requireSetting(
	        isGiven() || pressureDecay == 0.0, prefix + "pressureDecay", pressureDecay,
	        "belongs to a measured segregationPotential, which is not given; give both, or leave this out: what is computed falls with load by itself");
}

SegregationPotential::SegregationPotential(
        const SegregationSettings& settings, const FreezingCurve& curve, const Permeability& permeability, const MixtureProperties& mixture)
        : settings_(settings)
        , liquidDensity_(mixture.liquid.density)
        , iceDensity_(mixture.ice.density)
        , latentHeat_(mixture.latentHeat)
        , conductivity_(permeability.referenceConductivity)
        , suction_(mixture.latentHeat / (gravity * kelvin))
{
	if (settings.isGiven()) return;
	const int  count = int(std::lround(lowest / step));
	const auto at    = [&](double depth) {
                const double liquid = curve.liquidSaturation(curve.freezingTemperature() - depth), ice = 1.0 - liquid;
                const double resistivity = 1.0 / permeability.conductivity(permeability.referencePorosity, liquid);
                return Fringe { resistivity, ice * resistivity, ice * ice * resistivity };
	};
	fringes_.assign(1, {});
	for (int i = 0; i < count; ++i) {
		const Fringe first = at(i * step), middle = at((i + 0.5) * step), last = at((i + 1) * step);
		const auto   next = [&](double Fringe::*of) { return fringes_.back().*of + step / 6.0 * (first.*of + 4.0 * middle.*of + last.*of); }; // Simpson
		fringes_.push_back({ next(&Fringe::resistance), next(&Fringe::withIce), next(&Fringe::withIceSquared) });
	}
}

SegregationPotential::Fringe SegregationPotential::fringe(double depth) const
{
	const double  at    = depth / step;
	const int     below = std::clamp(int(at), 0, int(fringes_.size()) - 2);
	const Fringe &a = fringes_[below], &b = fringes_[below + 1];
	const double  part = at - below;
	return { a.resistance + part * (b.resistance - a.resistance), a.withIce + part * (b.withIce - a.withIce),
		 a.withIceSquared + part * (b.withIceSquared - a.withIceSquared) };
}

/// Eq. (26.3b), of second order in the scatter of the gradient.
double SegregationPotential::resistance(double depth, const Gradient& g) const
{
	const Fringe f   = fringe(depth);
	const double ice = f.withIce / f.resistance, scatter = std::max(0.0, f.withIceSquared / f.resistance - ice * ice);
	const double mean = g.ofNoIce + g.perIce * ice;
	return f.resistance / mean * (1.0 + g.perIce * g.perIce * scatter / (mean * mean));
}

/// Clapeyron's equation with both pressures: the water at a lens under the load p_i has p_l/rho_l = p_i/rho_i + L T/T_0.
double SegregationPotential::headOf(double load, double pressure) const { return load / (iceDensity_ * gravity) - pressure / (liquidDensity_ * gravity); }

SegregationPotential::Intake SegregationPotential::largestIntake(double head, const Gradient& gradient, double more, double coldest) const
{
	const double end     = std::min(-coldest, lowest);
	const auto   through = [&](double depth) { return (suction_ * depth - head) / (resistance(depth, gradient) + more); };
	// eq. (26.2): an affine function over a convex one has one maximum
	int low = 0, high = int(end / step);
	while (high - low > 1) {
		const int middle = (low + high) / 2;
		if (through((middle + 1) * step) > through(middle * step)) low = middle;
		else high = middle;
	}
	Intake best { 0.0, 0.0 };
	for (const double depth : { low * step, high * step, end })
		if (depth > 0.0 && through(depth) > best.water) best = { through(depth), -depth };
	return best;
}

double SegregationPotential::potential(double load, double pressure, double coldest) const
{
	if (settings_.isGiven()) return settings_.segregationPotential * std::exp(-settings_.pressureDecay * std::max(0.0, load - pressure));
	return largestIntake(headOf(load, pressure), { 1.0, 0.0 }, 0.0, coldest).water;
}

SegregationPotential::Intake SegregationPotential::intake(const Front& f) const
{
	if (!(f.gradient > 0.0) || !(f.coldest < 0.0)) return { 0.0, 0.0 };
	if (settings_.isGiven()) return { f.gradient * potential(f.load, f.pressure), 0.0 };
	const double head = headOf(f.load, f.pressure) + f.rise, more = f.distance / conductivity_;
	const double heat = liquidDensity_ * latentHeat_ / f.conductivity;
	Intake       best {};
	const auto   drawn = [&](double q) {
                const double behind = f.gradient - heat * q;
                if (!(behind > 0.0)) return 0.0;
                // eq. (26.3a): what freezes in the fringe gives off heat
                best = largestIntake(head, { f.unfrozen, (behind - f.unfrozen) / f.ice }, more, f.coldest);
                return best.water;
	};
	// eq. (26.3): what freezes at the lens gives off heat, so that the gradient in the fringe is smaller than that behind it
	double low = 0.0, high = f.gradient / heat;
	double left = drawn(0.0), right = -high;
	if (!(left > 0.0)) return { 0.0, 0.0 };
	for (int k = 0; k < 60 && high - low > 1e-9 * high; ++k) {
		const double q = k % 3 == 2 ? 0.5 * (low + high) : (low * right - high * left) / (right - left), miss = drawn(q) - q;
		if (miss > 0.0) low = q, left = miss;
		else high = q, right = miss;
		if (miss == 0.0) break;
	}
	return { 0.5 * (low + high), best.lens };
}

} // namespace talik
