// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// Inversion T(H), written once for every freezing curve so that the curve's own code is inlined.

#include <pkg/thm/Enthalpy.hpp>
#include <pkg/thm/FreezingCurveShapes.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace talik {

inline double EnthalpyModel::iceMassAt(const SoilContent& soil, double temperature, double sl, double dsl, double& slope) const
{
	const double density  = properties_.densityAt(properties_.ice, temperature);
	const double uncapped = density * (1.0 - sl) * soil.poreVolume;
	const double cap      = (1.0 - residualWaterFraction) * soil.waterMass;
	if (uncapped >= cap) {
		slope = 0.0;
		return cap;
	}
	slope = -soil.poreVolume * (density * dsl + properties_.ice.density * properties_.ice.expansivity * (1.0 - sl));
	return uncapped;
}

inline EnthalpyModel::Evaluation EnthalpyModel::evaluation(const SoilContent& soil, double temperature, double sl, double dsl, double integralOfSl) const
{
	const Phase &solid = properties_.solid, &ice = properties_.ice, &liquid = properties_.liquid;
	const double theta = temperature - properties_.referenceTemperature;
	double       iceSlope;
	const double iceMass = iceMassAt(soil, temperature, sl, dsl, iceSlope);
	if (form_ == EnthalpyForm::stateFunction) {
		const double difference = liquid.specificHeat - ice.specificHeat;
		const double capacity   = soil.solidMass * solid.specificHeat + soil.waterMass * liquid.specificHeat - difference * iceMass;
		const double enthalpy   = capacity * theta + (soil.waterMass - iceMass) * latentHeat_;
		return { enthalpy, capacity - iceSlope * (latentHeat_ + difference * theta), sl, iceMass, capacity };
	}
	const double iceCapacity    = ice.density * ice.specificHeat;
	const double liquidCapacity = liquid.density * liquid.specificHeat;
	const double solidCapacity  = soil.solidMass * solid.specificHeat;
	const double capacity       = solidCapacity + soil.poreVolume * ((1.0 - sl) * iceCapacity + sl * liquidCapacity);
	const double enthalpy       = solidCapacity * theta
	        + soil.poreVolume * (iceCapacity * (theta - integralOfSl) + liquidCapacity * integralOfSl + latentPerPoreVolume_ * sl);
	return { enthalpy, capacity + soil.poreVolume * latentPerPoreVolume_ * dsl, sl, iceMass, capacity };
}

inline double EnthalpyModel::thawedCapacity(const SoilContent& soil) const
{
	const double water = form_ == EnthalpyForm::stateFunction ? soil.waterMass : soil.poreVolume * properties_.liquid.density;
	return soil.solidMass * properties_.solid.specificHeat + water * properties_.liquid.specificHeat;
}

/// Enthalpy of thawed ground extrapolated to T_0.
inline double EnthalpyModel::thawedOffset(const SoilContent& soil) const
{
	if (form_ == EnthalpyForm::stateFunction) return soil.waterMass * latentHeat_;
	// between T_0 and T_f the capacity was that of the curve, not of thawed ground
	const double freezingAboveReference = curve_->freezingTemperature() - properties_.referenceTemperature;
	const double missing                = freezingAboveReference + integralAtReference_;
	const double iceCapacity            = properties_.ice.density * properties_.ice.specificHeat;
	const double liquidCapacity         = properties_.liquid.density * properties_.liquid.specificHeat;
	return soil.poreVolume * (latentPerPoreVolume_ + (iceCapacity - liquidCapacity) * missing);
}

inline double EnthalpyModel::smallestCapacity(const SoilContent& soil) const
{
	const double solid = soil.solidMass * properties_.solid.specificHeat;
	if (form_ == EnthalpyForm::stateFunction) return solid + soil.waterMass * properties_.ice.specificHeat;
	return solid
	        + soil.poreVolume
	        * std::min(properties_.ice.density * properties_.ice.specificHeat, properties_.liquid.density * properties_.liquid.specificHeat);
}

template <class Curve>
inline EnthalpyModel::Evaluation EnthalpyModel::evaluateAt(const Curve& curve, const SoilContent& soil, double temperature) const
{
	const double integral = form_ == EnthalpyForm::stateFunction ? 0.0 : curve.integral(temperature) - integralAtReference_;
	return evaluation(soil, temperature, curve.liquidSaturation(temperature), curve.derivative(temperature), integral);
}

/// Phase change at T_f itself: the fraction thawed is the unknown.
template <class Curve>
inline ThermalState EnthalpyModel::plateauState(const Curve& curve, const SoilContent& soil, double fractionThawed) const
{
	const double tf = curve.freezingTemperature;
	double       unused;
	const double frozenIce = iceMassAt(soil, tf, curve.residualSaturation, 0.0, unused);
	const double sl        = curve.residualSaturation + (1.0 - curve.residualSaturation) * fractionThawed;
	const double frozenCapacity = evaluation(soil, tf, curve.residualSaturation, 0.0, 0.0).heatCapacity;
	const double capacity       = frozenCapacity + fractionThawed * (thawedCapacity(soil) - frozenCapacity);
	return { tf, sl, (1.0 - fractionThawed) * frozenIce, capacity, true, std::numeric_limits<double>::infinity() };
}

/// Root of the enthalpy where it is a polynomial of degree two in T (linear and sharp curve, ice expansion left out).
template <class Curve>
inline double EnthalpyModel::closedFormGuess(const Curve& curve, const SoilContent& soil, double enthalpy, double guess) const
{
	if constexpr (std::is_same_v<Curve, LinearCurve> || std::is_same_v<Curve, SharpCurve>) {
		double low = -std::numeric_limits<double>::infinity(), high = curve.freezingTemperature;
		if constexpr (std::is_same_v<Curve, LinearCurve>) {
			const bool belowInterval = enthalpy <= evaluateAt(curve, soil, curve.frozenTemperature).enthalpy;
			(belowInterval ? high : low) = curve.frozenTemperature;
		}
		// Between low and high H is its second-order expansion about one temperature inside; the expansion is exact.
		const double base = std::isfinite(low) ? 0.5 * (low + high) : high - 1.0;
		const double step = 0.25 * (std::isfinite(low) ? high - low : 1.0);
		const auto   at = evaluateAt(curve, soil, base), above = evaluateAt(curve, soil, base + step);
		const double curvature = (above.slope - at.slope) / step;
		const double residual  = enthalpy - at.enthalpy;
		const double root      = at.slope * at.slope + 2.0 * curvature * residual;
		if (root < 0.0) return guess;
		// the form that does not cancel when the curvature is small
		return base + 2.0 * residual / (at.slope + std::sqrt(root));
	}
	(void)curve;
	(void)soil;
	(void)enthalpy;
	return guess;
}

template <class Curve>
inline ThermalState EnthalpyModel::solveFrozen(const Curve& curve, const SoilContent& soil, double enthalpy, double guess) const
{
	double       high       = curve.freezingTemperature;
	const double frozenEdge = Curve::sharp ? evaluation(soil, high, curve.residualSaturation, 0.0, -integralAtReference_).enthalpy
	                                       : thawedOffset(soil) + thawedCapacity(soil) * (high - properties_.referenceTemperature);
	double       low        = high - (frozenEdge - enthalpy) / smallestCapacity(soil) - 1e-9;
	low                     = std::max(low, lowestTemperature - 1.0);
	const double accepted   = tolerance_ * residualScale(soil);
	double       t          = std::min(std::max(closedFormGuess(curve, soil, enthalpy, guess), low), high);
	if (Curve::sharp && t >= high) t = std::nextafter(high, low);
	Evaluation at = evaluateAt(curve, soil, t);
	for (int iteration = 0; iteration < 200; ++iteration) {
		const double residual = at.enthalpy - enthalpy;
		if (!(std::abs(residual) > accepted)) break;
		(residual > 0.0 ? high : low) = t;
		if (high - low <= 2.0 * std::numeric_limits<double>::epsilon() * std::max(1.0, std::abs(t))) break;
		const double newton = t - residual / at.slope;
		t                   = newton > low && newton < high ? newton : 0.5 * (low + high);
		at                  = evaluateAt(curve, soil, t);
	}
	return { t, at.liquidSaturation, at.iceMass, at.heatCapacity, t > lowestTemperature && std::isfinite(at.enthalpy), at.slope };
}

template <class Curve>
inline ThermalState EnthalpyModel::solveWith(const Curve& curve, const SoilContent& soil, double enthalpy, double guess) const
{
	constexpr double nan = std::numeric_limits<double>::quiet_NaN();
	if (!std::isfinite(enthalpy)) return { nan, nan, nan, nan, false, nan };
	const double capacity = thawedCapacity(soil);
	const double thawed   = properties_.referenceTemperature + (enthalpy - thawedOffset(soil)) / capacity;
	if (Curve::neverFreezes || thawed >= curve.freezingTemperature) return { thawed, 1.0, 0.0, capacity, thawed > lowestTemperature, capacity };
	if constexpr (Curve::sharp) {
		const double edge      = curve.freezingTemperature;
		const double thawedH   = thawedOffset(soil) + capacity * (edge - properties_.referenceTemperature);
		const double frozenH   = evaluation(soil, edge, curve.residualSaturation, 0.0, -integralAtReference_).enthalpy;
		if (enthalpy >= frozenH) return plateauState(curve, soil, (enthalpy - frozenH) / (thawedH - frozenH));
	}
	ThermalState state = solveFrozen(curve, soil, enthalpy, std::isfinite(guess) ? guess : curve.freezingTemperature);
	if (!state.valid) state.temperature = nan;
	return state;
}

} // namespace talik
