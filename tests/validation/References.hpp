// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// Closed-form and independently integrated solutions that the solver is measured against. Nothing here uses the code of
// pkg/: material laws that a solution needs are passed in as functions.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

namespace talik::reference {

constexpr double pi = 3.14159265358979323846;

/// Root of f in [low, high] by bisection; f(low) and f(high) differ in sign.
template <class Function> double bisect(const Function& f, double low, double high)
{
	const bool rising = f(high) > 0.0;
	for (int k = 0; k < 200 && high - low > 1e-16 * (std::abs(low) + std::abs(high)); ++k) {
		const double middle                        = 0.5 * (low + high);
		((f(middle) > 0.0) == rising ? high : low) = middle;
	}
	return 0.5 * (low + high);
}

// ---- conduction without phase change (Carslaw & Jaeger 1959) --------------------------------------------------------------

/// Half space, T(0,t) = surface.
inline double halfSpace(double x, double t, double diffusivity, double initial, double surface)
{
	return initial + (surface - initial) * std::erfc(x / (2.0 * std::sqrt(diffusivity * t)));
}

/// Slab 0 < x < length, both faces at surface.
inline double slabBothFaces(double x, double t, double length, double diffusivity, double initial, double surface)
{
	double sum = 0.0;
	for (int j = 0; j < 400; ++j) {
		const double k = 2.0 * j + 1.0;
		sum += 4.0 / (pi * k) * std::sin(k * pi * x / length) * std::exp(-std::pow(k * pi / length, 2) * diffusivity * t);
	}
	return surface + (initial - surface) * sum;
}

/// Slab, face x = 0 at surface, face x = length insulated.
inline double slabInsulated(double x, double t, double length, double diffusivity, double initial, double surface)
{
	double sum = 0.0;
	for (int j = 0; j < 400; ++j) {
		const double k = (j + 0.5) * pi / length;
		sum += 2.0 / (k * length) * std::sin(k * x) * std::exp(-k * k * diffusivity * t);
	}
	return surface + (initial - surface) * sum;
}

/// Sealed slab whose halves start at left and right.
inline double sealedHalves(double x, double t, double length, double diffusivity, double left, double right)
{
	double sum = 0.0;
	for (int m = 1; m < 400; ++m)
		sum += 2.0 * (left - right) / (m * pi) * std::sin(0.5 * m * pi) * std::cos(m * pi * x / length)
		        * std::exp(-std::pow(m * pi / length, 2) * diffusivity * t);
	return 0.5 * (left + right) + sum;
}

// ---- moving fronts --------------------------------------------------------------------------------------------------------

/// Conductivity [W/(m K)] and volumetric capacity [J/(m^3 K)] of one phase of the ground.
struct Conductor {
	double conductivity, capacity;
	double diffusivity() const { return conductivity / capacity; }
};

/// Front position over sqrt(t) [m/s^(1/2)] of the two-phase Neumann problem: near = ground next to the surface.
inline double neumannFront(const Conductor& near, const Conductor& far, double surface, double initial, double freezing, double latentPerVolume)
{
	const double a1 = near.diffusivity(), a2 = far.diffusivity(), nu = std::sqrt(a1 / a2);
	const auto   stefan = [&](double lambda) {
                return near.conductivity * std::abs(surface - freezing) / (std::erf(lambda) * std::sqrt(a1)) * std::exp(-lambda * lambda)
                        - far.conductivity * std::abs(initial - freezing) / (std::erfc(nu * lambda) * std::sqrt(a2)) * std::exp(-nu * nu * lambda * lambda)
                        - latentPerVolume * lambda * std::sqrt(pi * a1);
	};
	return 2.0 * bisect(stefan, 1e-6, 4.0) * std::sqrt(a1);
}

/// Heat conduction into a half space with any T-dependent conductivity and apparent capacity: similarity solution in
/// eta = x/sqrt(t), (kappa T')' + eta/2 C T' = 0, integrated by fourth-order Runge-Kutta and shooting for the surface flux.
class SimilarityFront {
public:
	using Law = std::function<double(double)>;

	SimilarityFront(Law conductivity, Law apparentCapacity, double surface, double initial, double etaEnd, int steps = 20000)
	        : conductivity_(std::move(conductivity))
	        , capacity_(std::move(apparentCapacity))
	        , surface_(surface)
	        , step_(etaEnd / steps)
	        , temperature_(steps + 1)
	{
		const double flux = bisect([&](double q) { return (integrate(q) - initial) * (initial > surface ? 1.0 : -1.0); }, 0.0, bound(initial));
		integrate(flux);
		surfaceFlux_ = flux;
	}

	/// kappa dT/deta at the surface, over the sign of (initial - surface) [W s^(1/2)/m^2]; heat flux is this over sqrt(t).
	double surfaceFlux() const { return surfaceFlux_; }

	double temperature(double eta) const
	{
		const double k = eta / step_;
		const auto   i = std::size_t(k);
		if (i + 1 >= temperature_.size()) return temperature_.back();
		return temperature_[i] + (k - i) * (temperature_[i + 1] - temperature_[i]);
	}

	/// Integral of f(T) - f(T_initial) over eta, by the trapezoidal rule.
	double integralOf(const Law& f) const
	{
		const double far = f(temperature_.back());
		double       sum = 0.5 * (f(temperature_.front()) - far);
		for (std::size_t k = 1; k + 1 < temperature_.size(); ++k)
			sum += f(temperature_[k]) - far;
		return sum * step_;
	}

private:
	double integrate(double flux)
	{
		double t = surface_, q = direction_ * flux;
		temperature_[0]  = t;
		const auto slope = [&](double eta, double ti, double qi, double& dt, double& dq) {
			dt = qi / conductivity_(ti);
			dq = -0.5 * eta * capacity_(ti) * dt;
		};
		for (std::size_t k = 1; k < temperature_.size(); ++k) {
			const double eta = (k - 1) * step_;
			double       t1, q1, t2, q2, t3, q3, t4, q4;
			slope(eta, t, q, t1, q1);
			slope(eta + 0.5 * step_, t + 0.5 * step_ * t1, q + 0.5 * step_ * q1, t2, q2);
			slope(eta + 0.5 * step_, t + 0.5 * step_ * t2, q + 0.5 * step_ * q2, t3, q3);
			slope(eta + step_, t + step_ * t3, q + step_ * q3, t4, q4);
			t += step_ / 6.0 * (t1 + 2.0 * t2 + 2.0 * t3 + t4);
			q += step_ / 6.0 * (q1 + 2.0 * q2 + 2.0 * q3 + q4);
			temperature_[k] = t;
		}
		return t;
	}

	double bound(double initial)
	{
		direction_ = initial > surface_ ? 1.0 : -1.0;
		double q   = 1.0;
		while ((integrate(q) - initial) * direction_ < 0.0)
			q *= 2.0;
		return q;
	}

	Law                 conductivity_, capacity_;
	double              surface_, step_, direction_ = 1.0, surfaceFlux_ = 0.0;
	std::vector<double> temperature_;
};

/// Lunardini's three-zone solution: freezing or thawing from a surface, latent heat released evenly between two temperatures.
/// All zones with one conductivity and one sensible capacity (then the solution is exact with the enthalpy method's own laws).
struct Lunardini {
	double nearFront; ///< of the zone next to the surface, over sqrt(t)
	double farFront;  ///< of the zone that has not begun to change phase, over sqrt(t)

	/// nearTemperature, farTemperature: ends of the interval on the side of the surface and of the undisturbed ground.
	static Lunardini solve(const Conductor& ground, double latentPerVolume, double surface, double nearTemperature, double farTemperature, double initial)
	{
		const double a = ground.diffusivity(), span = std::abs(farTemperature - nearTemperature);
		const double am = ground.conductivity / (ground.capacity + latentPerVolume / span);
		// flux continuity at both fronts for given near front eta1: far front from the near condition, then residual of the other
		const auto farFrom = [&](double x1) {
			const double left = (nearTemperature - surface) / std::erf(x1 / (2 * std::sqrt(a))) / std::sqrt(a) * std::exp(-x1 * x1 / (4 * a));
			const auto   mush = [&](double x2) {
                                const double width = std::erf(x2 / (2 * std::sqrt(am))) - std::erf(x1 / (2 * std::sqrt(am)));
                                return (farTemperature - nearTemperature) / width / std::sqrt(am) * std::exp(-x1 * x1 / (4 * am));
			};
			return bisect([&](double x2) { return std::abs(left) - std::abs(mush(x2)); }, x1 * (1 + 1e-12), x1 + 12 * std::sqrt(am));
		};
		const auto residual = [&](double x1) {
			const double x2    = farFrom(x1);
			const double width = std::erf(x2 / (2 * std::sqrt(am))) - std::erf(x1 / (2 * std::sqrt(am)));
			const double mush  = (farTemperature - nearTemperature) / width / std::sqrt(am) * std::exp(-x2 * x2 / (4 * am));
			const double far   = (initial - farTemperature) / std::erfc(x2 / (2 * std::sqrt(a))) / std::sqrt(a) * std::exp(-x2 * x2 / (4 * a));
			return std::abs(mush) - std::abs(far);
		};
		// the residual changes sign once; start where the far front is still defined
		double       low = 1e-4 * std::sqrt(a), high = low;
		const double sign = residual(low) > 0 ? 1.0 : -1.0;
		while (residual(high) * sign > 0.0)
			high *= 1.05;
		const double x1 = bisect(residual, low, high);
		return { x1, farFrom(x1) };
	}
};

// ---- consolidation --------------------------------------------------------------------------------------------------------

/// Terzaghi with compressible water: base impermeable, top drained and loaded at t = 0.
struct Terzaghi {
	double height, load, oedometer, storage, mobility; ///< [m, Pa, Pa, 1/Pa, k/(rho g) in m^2/(Pa s)]

	double initialPressure() const { return load / (1.0 + oedometer * storage); }
	double cv() const { return mobility / (1.0 / oedometer + storage); }
	double timeAt(double factor) const { return factor * height * height / cv(); }
	double factorAt(double time) const { return cv() * time / (height * height); }
	/// heightAboveBase in [0, height]
	double pressure(double heightAboveBase, double time) const
	{
		double sum = 0.0, sign = 1.0;
		for (int j = 1; j < 2000; ++j, sign = -sign) {
			const double k = 2.0 * j - 1.0;
			sum += sign / k * std::cos(k * pi * heightAboveBase / (2.0 * height)) * std::exp(-k * k * pi * pi * factorAt(time) / 4.0);
		}
		return initialPressure() * 4.0 / pi * sum;
	}
	double degree(double time) const
	{
		double sum = 0.0;
		for (int j = 1; j < 2000; ++j) {
			const double k = 2.0 * j - 1.0;
			sum += std::exp(-k * k * pi * pi * factorAt(time) / 4.0) / (k * k);
		}
		return 1.0 - 8.0 / (pi * pi) * sum;
	}
	double settlement(double time) const { return height / oedometer * (load - initialPressure() * (1.0 - degree(time))); }
};

/// McTigue (1986): half space free to expand along x, drained surface heated to temperatureRise at t = 0.
/// pressurePerKelvin = beta_m/(S + 1/M): undrained pressure rise per kelvin.
inline double mcTiguePressure(double x, double t, double heatDiffusivity, double cv, double pressurePerKelvin, double temperatureRise)
{
	return pressurePerKelvin * temperatureRise / (1.0 - cv / heatDiffusivity)
	        * (std::erfc(x / (2.0 * std::sqrt(heatDiffusivity * t))) - std::erfc(x / (2.0 * std::sqrt(cv * t))));
}

/// Morgenstern & Nixon (1971): thaw front X = a sqrt(t) moving into loaded ground, drained surface; R = a/(2 sqrt(c_v)).
struct MorgensternNixon {
	double ratio; ///< R

	/// Excess pore pressure over load, at depth x in units of X.
	double pressure(double depthOverFront) const
	{
		return std::erf(ratio * depthOverFront) / (std::erf(ratio) + std::exp(-ratio * ratio) / (std::sqrt(pi) * ratio));
	}
	double atThawLine() const { return pressure(1.0); }
	/// Mean of 1 - u/P over the thawed layer: settlement is this times X P/M.
	double degree() const
	{
		const double r       = ratio;
		const double meanErf = std::erf(r) + (std::exp(-r * r) - 1.0) / (r * std::sqrt(pi));
		return 1.0 - meanErf / (std::erf(r) + std::exp(-r * r) / (std::sqrt(pi) * r));
	}
};

/// The same for a front that moves in any way, from the similarity solution at its first depth: finite volumes in depth over X, implicit in time.
/// What thaws brings the load P: d/dt of the integral of u over X is P dX/dt less what leaves through the drained surface. u over P.
class ThawConsolidation {
public:
	ThawConsolidation(double consolidation, double depth, const MorgensternNixon& start)
	        : consolidation_(consolidation)
	        , depth_(depth)
	{
		for (int i = 0; i < cells; ++i)
			u_[i] = start.pressure((i + 0.5) / cells);
	}
	/// The front goes to a depth within dt.
	void advance(double depth, double dt)
	{
		const double              speed = (depth - depth_) / dt, conducts = consolidation_ / depth * cells, per = dt * cells;
		std::array<double, cells> lower {}, middle {}, upper {};
		for (int i = 0; i < cells; ++i) {
			u_[i] *= depth_;
			middle[i] = depth;
		}
		for (int i = 0; i + 1 < cells; ++i) { // faces within
			const double moved = 0.5 * speed * (i + 1) / cells;
			middle[i] -= per * (moved - conducts);
			upper[i] -= per * (moved + conducts);
			middle[i + 1] += per * (moved + conducts);
			lower[i + 1] += per * (moved - conducts);
		}
		middle[0] += per * 2.0 * conducts;
		u_[cells - 1] += per * speed;
		for (int i = 1; i < cells; ++i) {
			const double part = lower[i] / middle[i - 1];
			middle[i] -= part * upper[i - 1];
			u_[i] -= part * u_[i - 1];
		}
		for (int i = cells - 1; i >= 0; --i)
			u_[i] = (u_[i] - (i + 1 < cells ? upper[i] * u_[i + 1] : 0.0)) / middle[i];
		depth_ = depth;
	}
	/// At depth over front.
	double pressure(double place) const
	{
		const double at = std::min(std::max(place * cells - 0.5, 0.0), cells - 1.001);
		const int    i  = int(at);
		return u_[i] + (at - i) * (u_[i + 1] - u_[i]);
	}

private:
	static constexpr int      cells = 200;
	double                    consolidation_, depth_;
	std::array<double, cells> u_ {};
};

// ---- dynamics -------------------------------------------------------------------------------------------------------------

/// Tip displacement of a fixed-free column, gravity switched on at t = 0 (positive downwards).
inline double suddenGravityTip(double t, double length, double waveSpeed, double oedometer, double weightPerVolume)
{
	const double omega = pi * waveSpeed / (2.0 * length);
	double       sum = 0.0, sign = 1.0;
	for (int j = 1; j < 4000; j += 2, sign = -sign)
		sum += 32.0 / (std::pow(j, 3) * std::pow(pi, 3)) * sign * std::cos(j * omega * t);
	return weightPerVolume * length * length / (2.0 * oedometer) * (1.0 - sum);
}

} // namespace talik::reference
