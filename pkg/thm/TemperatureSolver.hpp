// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/thm/Enthalpy.hpp>
#include <pkg/thm/FreezingCurveShapes.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talik {

/// Inversion T(H) of many points, written once for every freezing curve so that the curve's own code becomes part of its loops.
/// Thawed ground is solved in closed form, and so is the sharp curve at T_f; all points below freezing take Newton's steps
/// together, each inside a bracket of its own that holds the root. A point's result does not depend on its neighbours.
template <class Curve> class TemperatureSolver {
public:
	TemperatureSolver(const EnthalpyFormula& formula, const Curve& curve)
	        : formula_(formula)
	        , curve_(curve)
	{}

	/// See EnthalpyModel::temperatures.
	std::size_t solve(const EnthalpyBatch& b) const
	{
		for (std::size_t first = 0; first < b.count; first += most)
			solvePiece(b, first, int(std::min<std::size_t>(most, b.count - first)));
		for (std::size_t p = 0; p < b.count; ++p)
			if (!std::isfinite(b.temperature[p])) return p;
		return b.count;
	}

private:
	static constexpr int    most = 32; ///< points at once: what they need stays in the first-level cache
	static constexpr double nan  = std::numeric_limits<double>::quiet_NaN();

	/// Points whose temperature is being sought.
	struct Unsolved {
		int    count = 0;
		int    place[most];
		double solidMass[most], waterMass[most], poreVolume[most], enthalpy[most];
		double temperature[most], low[most], high[most], accepted[most];
		// at the present temperature
		double liquidSaturation[most], reached[most], slope[most], iceMass[most], heatCapacity[most];
		int    done[most];

		SoilContent soil(int k) const { return { solidMass[k], waterMass[k], poreVolume[k] }; }
		void        move(int from, int to)
		{
			place[to] = place[from];
			for (double* field : { solidMass, waterMass, poreVolume, enthalpy, temperature, low, high, accepted })
				field[to] = field[from];
		}
	};

	/// sets all results as if the points were thawed, and marks those which are not.
	TALIK_PROCESSOR_VERSIONS void assumeThawed(const EnthalpyBatch& b, std::size_t first, int count, double (&guess)[most], int (&frozen)[most]) const;
	TALIK_PROCESSOR_VERSIONS void evaluate(Unsolved& u) const;
	TALIK_PROCESSOR_VERSIONS void iterate(Unsolved& u) const;

	void solvePiece(const EnthalpyBatch& b, std::size_t first, int count) const
	{
		double   guess[most];
		int      frozen[most];
		Unsolved u;
		assumeThawed(b, first, count, guess, frozen);
		for (int k = 0; k < count; ++k)
			if (frozen[k]) begin(b, int(first) + k, guess[k], u);
		for (int iteration = 0; u.count > 0; ++iteration) {
			evaluate(u);
			iterate(u);
			if (iteration == 200) std::fill(u.done, u.done + u.count, 1);
			finish(b, u);
		}
	}

	/// A point at or below freezing: solved at once if it is changing phase at T_f, else added to the unsolved ones.
	void begin(const EnthalpyBatch& b, int p, double guess, Unsolved& u) const
	{
		const SoilContent soil { b.solidMass[p], b.waterMass[p], b.poreVolume[p] };
		const double      tf = curve_.freezingTemperature, enthalpy = b.enthalpy[p];
		const double      thawedEdge = formula_.thawedOffset(soil) + formula_.thawedCapacity(soil) * (tf - formula_.properties.referenceTemperature);
		double            frozenEdge = thawedEdge;
		if (Curve::neverFreezes || !std::isfinite(enthalpy)) return store(b, p, nan, nan, { nan, nan, nan, nan });
		if constexpr (Curve::sharp) {
			frozenEdge = formula_.at(soil, tf, curve_.residualSaturation, 0.0).enthalpy;
			if (enthalpy >= frozenEdge) return changePhase(b, p, soil, (enthalpy - frozenEdge) / (thawedEdge - frozenEdge));
		}
		const int k      = u.count++;
		u.place[k]       = p;
		u.solidMass[k]   = soil.solidMass;
		u.waterMass[k]   = soil.waterMass;
		u.poreVolume[k]  = soil.poreVolume;
		u.enthalpy[k]    = enthalpy;
		u.accepted[k]    = EnthalpyModel::tolerance * formula_.residualScale(soil);
		u.high[k]        = tf;
		u.low[k]         = std::max(tf - (frozenEdge - enthalpy) / formula_.smallestCapacity(soil) - 1e-9, EnthalpyModel::lowestTemperature - 1.0);
		const double t   = closedForm(soil, enthalpy, std::isfinite(guess) ? guess : tf);
		u.temperature[k] = std::min(std::max(t, u.low[k]), u.high[k]);
		if (Curve::sharp && u.temperature[k] >= tf) u.temperature[k] = std::nextafter(tf, u.low[k]);
	}

	/// Phase change at T_f itself: the fraction thawed is the unknown.
	void changePhase(const EnthalpyBatch& b, int p, const SoilContent& soil, double fractionThawed) const
	{
		const double                 tf = curve_.freezingTemperature, sr = curve_.residualSaturation;
		const EnthalpyFormula::Value frozen   = formula_.at(soil, tf, sr, 0.0);
		const double                 capacity = frozen.heatCapacity + fractionThawed * (formula_.thawedCapacity(soil) - frozen.heatCapacity);
		store(b, p, tf, sr + (1.0 - sr) * fractionThawed,
		      { nan, std::numeric_limits<double>::infinity(), (1.0 - fractionThawed) * frozen.iceMass, capacity });
	}

	/// Root where the enthalpy is in pieces a polynomial of degree two in T (linear curve, sharp one and table, ice expansion left out); else the guess.
	double closedForm(const SoilContent& soil, double enthalpy, double guess) const
	{
		if constexpr (!Curve::piecewiseLinear) return guess;
		else {
			const auto [low, high] = curve_.pieceOf([&](double t) { return enthalpy <= valueAt(soil, t).enthalpy; });
			// Between low and high H is its second-order expansion about one temperature inside; the expansion is exact.
			const double base = std::isfinite(low) ? 0.5 * (low + high) : high - 1.0;
			const double step = 0.25 * (std::isfinite(low) ? high - low : 1.0);
			const auto   at = valueAt(soil, base), above = valueAt(soil, base + step);
			const double curvature = (above.slope - at.slope) / step;
			const double residual  = enthalpy - at.enthalpy;
			const double root      = at.slope * at.slope + 2.0 * curvature * residual;
			if (root < 0.0) return guess;
			// the form that does not cancel when the curvature is small
			return base + 2.0 * residual / (at.slope + std::sqrt(root));
		}
	}

	EnthalpyFormula::Value valueAt(const SoilContent& soil, double t) const
	{
		return formula_.at(soil, t, curve_.liquidSaturation(t), curve_.derivative(t));
	}

	/// Stores what is done and keeps the others, in their order.
	void finish(const EnthalpyBatch& b, Unsolved& u) const
	{
		int kept = 0;
		for (int k = 0; k < u.count; ++k) {
			if (!u.done[k]) {
				if (kept < k) u.move(k, kept);
				++kept;
				continue;
			}
			const bool valid = u.temperature[k] > EnthalpyModel::lowestTemperature && std::isfinite(u.reached[k]);
			store(b, u.place[k], valid ? u.temperature[k] : nan, u.liquidSaturation[k],
			      { u.reached[k], u.slope[k], u.iceMass[k], u.heatCapacity[k] });
		}
		u.count = kept;
	}

	static void store(const EnthalpyBatch& b, int p, double temperature, double liquidSaturation, const EnthalpyFormula::Value& at)
	{
		b.temperature[p]      = temperature;
		b.liquidSaturation[p] = liquidSaturation;
		b.iceMass[p]          = at.iceMass;
		b.heatCapacity[p]     = at.heatCapacity;
		if (b.apparentCapacity) b.apparentCapacity[p] = at.slope;
	}

	const EnthalpyFormula formula_;
	const Curve&          curve_;
};

template <class Curve>
void TemperatureSolver<Curve>::assumeThawed(const EnthalpyBatch& b, std::size_t first, int count, double (&guess)[most], int (&frozen)[most]) const
{
	const EnthalpyFormula f  = formula_;
	const double          tf = curve_.freezingTemperature, lowest = Curve::neverFreezes ? EnthalpyModel::lowestTemperature : tf;
	const double* const   enthalpy         = b.enthalpy + first;
	const double* const   solidMass        = b.solidMass + first;
	const double* const   waterMass        = b.waterMass + first;
	const double* const   poreVolume       = b.poreVolume + first;
	double* const         temperature      = b.temperature + first;
	double* const         liquidSaturation = b.liquidSaturation + first;
	double* const         iceMass          = b.iceMass + first;
	double* const         heatCapacity     = b.heatCapacity + first;
	double                capacities[most];
#pragma GCC ivdep
	for (int k = 0; k < count; ++k) {
		const SoilContent soil { solidMass[k], waterMass[k], poreVolume[k] };
		const double      capacity = f.thawedCapacity(soil);
		const double      thawed   = f.properties.referenceTemperature + (enthalpy[k] - f.thawedOffset(soil)) / capacity;
		guess[k]                   = temperature[k];
		temperature[k]             = thawed;
		liquidSaturation[k]        = 1.0;
		iceMass[k]                 = 0.0;
		capacities[k]              = capacity;
		// what is no number counts as frozen
		frozen[k] = thawed >= lowest && thawed < std::numeric_limits<double>::infinity() ? 0 : 1;
	}
	std::copy(capacities, capacities + count, heatCapacity);
	if (b.apparentCapacity) std::copy(capacities, capacities + count, b.apparentCapacity + first);
}

template <class Curve> void TemperatureSolver<Curve>::evaluate(Unsolved& u) const
{
	const EnthalpyFormula f = formula_;
	const int             n = u.count;
#pragma GCC ivdep
	for (int k = 0; k < n; ++k) {
		const double t        = u.temperature[k];
		const double sl       = curve_.liquidSaturation(t);
		const auto   at       = f.at(u.soil(k), t, sl, curve_.derivative(t));
		u.liquidSaturation[k] = sl;
		u.reached[k]          = at.enthalpy;
		u.slope[k]            = at.slope;
		u.iceMass[k]          = at.iceMass;
		u.heatCapacity[k]     = at.heatCapacity;
	}
}

/// One step of Newton for those whose enthalpy is not reached yet, halving the bracket where it would lead outside.
template <class Curve> void TemperatureSolver<Curve>::iterate(Unsolved& u) const
{
	constexpr double roundOff = 2.0 * std::numeric_limits<double>::epsilon();
	const int        n        = u.count;
#pragma GCC ivdep
	for (int k = 0; k < n; ++k) {
		const double t = u.temperature[k], residual = u.reached[k] - u.enthalpy[k];
		const double low = residual > 0.0 ? u.low[k] : t, high = residual > 0.0 ? t : u.high[k];
		const double newton  = t - residual / u.slope[k];
		const double next    = newton > low && newton < high ? newton : 0.5 * (low + high);
		const bool   reached = !(std::abs(residual) > u.accepted[k]) || high - low <= roundOff * std::max(1.0, std::abs(t));
		u.low[k]             = low;
		u.high[k]            = high;
		u.temperature[k]     = reached ? t : next;
		u.done[k]            = reached ? 1 : 0;
	}
}

} // namespace talik
