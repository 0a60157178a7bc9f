// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// The freezing curves themselves, as plain structs whose functions inline into loops over points, and become vectors there if
// they are free of branches. A new curve is a struct here, with its parameters, its constructor and its line of the table in FreezingCurve.cpp:
// see "How to add a freezing curve" in pkg/thm/how-to.md.

#include <pkg/thm/Exponential.hpp>
#include <pkg/thm/FreezingCurve.hpp>
#include <pkg/thm/Mixture.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talik {

/// What all curves have: the temperature below which ice forms and the liquid saturation that never freezes.
struct CurveBase {
	static constexpr bool sharp        = false;
	static constexpr bool neverFreezes = false;
	/// S_l is linear in T in pieces, of which pieceOf(rootBelow) finds that of a root: rootBelow(T) says whether the root lies at or below T.
	static constexpr bool piecewiseLinear = false;
	struct Piece {
		double low, high; ///< [degC]; low is minus infinity in the lowest piece
	};

	double freezingTemperature = 0.0;  ///< T_f [degC]
	double residualSaturation  = 0.05; ///< S_r [-], in [0,1)

	explicit CurveBase(const CurveParameters& given);

	double scaled(double fraction) const { return residualSaturation + (1.0 - residualSaturation) * fraction; } ///< S_l of S_e, eq. (4.1)
};

/// S_e = exp(-(theta/W)^2), theta = T_f - T (McKenzie et al. 2007).
struct GaussCurve : CurveBase {
	static const char*     name() { return "gauss"; }
	static CurveParameters parameters();
	explicit GaussCurve(const CurveParameters& given);

	double width; ///< W [K]: S_e = 1/e at that undercooling, usually 0.1 to 1

	double liquidSaturation(double temperature) const
	{
		const double theta = freezingTemperature - temperature, below = scaled(fraction(theta));
		return theta <= 0.0 ? 1.0 : below;
	}
	double derivative(double temperature) const
	{
		const double theta = freezingTemperature - temperature;
		const double below = (1.0 - residualSaturation) * 2.0 * theta / (width * width) * fraction(theta);
		return theta <= 0.0 ? 0.0 : below;
	}

private:
	double fraction(double theta) const
	{
		const double x = theta / width;
		return talik::exponential(-x * x);
	}
};

/// S_e = exp(-theta/W).
struct ExponentialCurve : CurveBase {
	static const char*     name() { return "exponential"; }
	static CurveParameters parameters();
	explicit ExponentialCurve(const CurveParameters& given);

	double width; ///< W [K]: S_e = 1/e at that undercooling, usually 0.1 to 1

	double liquidSaturation(double temperature) const
	{
		const double theta = freezingTemperature - temperature, below = scaled(talik::exponential(-theta / width));
		return theta <= 0.0 ? 1.0 : below;
	}
	double derivative(double temperature) const
	{
		const double theta = freezingTemperature - temperature, below = (1.0 - residualSaturation) * talik::exponential(-theta / width) / width;
		return theta <= 0.0 ? 0.0 : below;
	}
};

/// S_e = (1 + theta/D)^-a.
struct PowerCurve : CurveBase {
	static const char*     name() { return "power"; }
	static CurveParameters parameters();
	explicit PowerCurve(const CurveParameters& given);

	double scale;    ///< D [K]
	double exponent; ///< a [-], > 1, usually 2 to 10

	double liquidSaturation(double temperature) const
	{
		const double theta = freezingTemperature - temperature;
		return theta <= 0.0 ? 1.0 : scaled(std::pow(1.0 + theta / scale, -exponent));
	}
	double derivative(double temperature) const
	{
		const double theta = freezingTemperature - temperature;
		return theta <= 0.0 ? 0.0 : (1.0 - residualSaturation) * exponent / scale * std::pow(1.0 + theta / scale, -exponent - 1.0);
	}
};

/// S_e falls linearly from one at T_f to zero at frozenTemperature T_m; has exact moving-boundary solutions (Lunardini).
struct LinearCurve : CurveBase {
	static constexpr bool  piecewiseLinear = true;
	static const char*     name() { return "linear"; }
	static CurveParameters parameters();
	explicit LinearCurve(const CurveParameters& given);

	double frozenTemperature; ///< T_m [degC], < T_f

	double                           span() const { return freezingTemperature - frozenTemperature; }
	template <class RootBelow> Piece pieceOf(RootBelow&& rootBelow) const
	{
		if (rootBelow(frozenTemperature)) return { -std::numeric_limits<double>::infinity(), frozenTemperature };
		return { frozenTemperature, freezingTemperature };
	}
	double liquidSaturation(double temperature) const
	{
		if (temperature >= freezingTemperature) return 1.0;
		if (temperature <= frozenTemperature) return residualSaturation;
		return scaled((temperature - frozenTemperature) / span());
	}
	double derivative(double temperature) const
	{
		const bool inside = temperature > frozenTemperature && temperature < freezingTemperature;
		return inside ? (1.0 - residualSaturation) / span() : 0.0;
	}
};

/// Clausius-Clapeyron suction s = -rho_i L_f ln(T_K/T_fK) in van Genuchten's retention curve,
/// S_e = [1 + (s/P_0)^(1/(1-lambda))]^-lambda (form of Nishimura et al. 2009).
struct VanGenuchtenCurve : CurveBase {
	static const char*     name() { return "vanGenuchten"; }
	static CurveParameters parameters();
	explicit VanGenuchtenCurve(const CurveParameters& given);

	double                  entryPressure;      ///< P_0 [Pa]: sand 1e4 to 5e4, silt 5e4 to 5e5, clay 2e5 to 2e6
	double                  lambda;             ///< [-], in (0,1), usually 0.2 to 0.6
	double                  suctionCoefficient; ///< rho_i L_f [Pa]
	double                  freezingKelvin;     ///< T_f [K]
	static constexpr double zeroCelsius = 273.15;

	double suction(double temperature) const
	{
		// log1p keeps the digits of a small undercooling that the ratio of absolute temperatures would lose
		return -suctionCoefficient * std::log1p((temperature - freezingTemperature) / freezingKelvin);
	}
	double liquidSaturation(double temperature) const
	{
		if (temperature >= freezingTemperature) return 1.0;
		const double x = std::pow(suction(temperature) / entryPressure, 1.0 / (1.0 - lambda));
		return scaled(std::pow(1.0 + x, -lambda));
	}
	double derivative(double temperature) const
	{
		if (temperature >= freezingTemperature) return 0.0;
		const double s = suction(temperature);
		const double x = std::pow(s / entryPressure, 1.0 / (1.0 - lambda));
		return (1.0 - residualSaturation) * lambda / (1.0 - lambda) * (x / s) * std::pow(1.0 + x, -lambda - 1.0) * suctionCoefficient
		        / (temperature + zeroCelsius);
	}
};

/// All pore water but the residual freezes at T_f itself.
struct SharpCurve : CurveBase {
	static constexpr bool  sharp           = true;
	static constexpr bool  piecewiseLinear = true;
	static const char*     name() { return "sharp"; }
	static CurveParameters parameters();
	explicit SharpCurve(const CurveParameters& given);

	template <class RootBelow> Piece pieceOf(RootBelow&&) const { return { -std::numeric_limits<double>::infinity(), freezingTemperature }; }
	double                           liquidSaturation(double temperature) const { return temperature >= freezingTemperature ? 1.0 : residualSaturation; }
	double                           derivative(double) const { return 0.0; }
};

/// Measured points, linear in between.
struct TableCurve : CurveBase {
	static constexpr bool piecewiseLinear = true;
	static const char*    name() { return "table"; }
	/// See makeFreezingCurve.
	explicit TableCurve(std::vector<CurvePoint> points);

	template <class RootBelow> Piece pieceOf(RootBelow&& rootBelow) const
	{
		const auto above = std::partition_point(points_.begin(), points_.end(), [&](const CurvePoint& point) { return !rootBelow(point.temperature); });
		if (above == points_.begin()) return { -std::numeric_limits<double>::infinity(), points_.front().temperature };
		return { (above - 1)->temperature, above == points_.end() ? freezingTemperature : above->temperature };
	}
	double liquidSaturation(double temperature) const
	{
		if (temperature >= freezingTemperature) return 1.0;
		const int k = pointBelow(temperature);
		return k < 0 ? residualSaturation : points_[k].liquidSaturation + slope(k) * (temperature - points_[k].temperature);
	}
	double derivative(double temperature) const
	{
		const int k = pointBelow(temperature);
		return temperature >= freezingTemperature || k < 0 ? 0.0 : slope(k);
	}

private:
	/// Place of the last point below a temperature, -1 where there is none.
	int pointBelow(double temperature) const
	{
		const auto lower = [](const CurvePoint& point, double t) { return point.temperature < t; };
		return int(std::lower_bound(points_.begin(), points_.end(), temperature, lower) - points_.begin()) - 1;
	}
	/// dS_l/dT between the points k and k + 1 [1/K]
	double slope(int k) const
	{
		const CurvePoint &low = points_[k], &high = points_[k + 1];
		return (high.liquidSaturation - low.liquidSaturation) / (high.temperature - low.temperature);
	}

	std::vector<CurvePoint> points_; ///< the last one is that of T_f
};

/// Ground that never freezes.
struct UnfrozenCurve : CurveBase {
	static constexpr bool  neverFreezes = true;
	static const char*     name() { return "unfrozen"; }
	static CurveParameters parameters() { return {}; }
	explicit UnfrozenCurve(const CurveParameters&)
	        : CurveBase(CurveParameters {})
	{}

	double liquidSaturation(double) const { return 1.0; }
	double derivative(double) const { return 0.0; }
};

} // namespace talik
