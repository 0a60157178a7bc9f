// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// The freezing curves themselves, as plain structs whose functions inline into loops over points, and become vectors there if
// they are free of branches. A new curve is a struct here and its line of the table in FreezingCurve.cpp: see "How to add a freezing curve" in
// pkg/thm/how-to.md.

#include <pkg/thm/Exponential.hpp>
#include <pkg/thm/FreezingCurve.hpp>
#include <pkg/thm/Mixture.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

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

	CurveBase() = default;
	explicit CurveBase(const CurveParameters& given)
	        : freezingTemperature(given.at("freezingTemperature"))
	        , residualSaturation(given.at("residualSaturation"))
	{
		requireSetting(
		        freezingTemperature > -50.0 && freezingTemperature < 50.0, "FreezingCurve.freezingTemperature", freezingTemperature,
		        "must be a temperature in degC between -50 and 50 (pure water: 0)");
		requireSetting(
		        residualSaturation >= 0.0 && residualSaturation < 1.0, "FreezingCurve.residualSaturation", residualSaturation,
		        "must lie in [0, 1); 0.01 or more keeps the liquid defined in frozen ground");
	}

	double scaled(double fraction) const { return residualSaturation + (1.0 - residualSaturation) * fraction; } ///< S_l of S_e, eq. (4.1)

protected:
	static constexpr double narrowest = 1e-9; ///< [K]; a millionth of what any ground shows, and its square is a number

	/// Parameters of a curve with their defaults, and those that all have.
	static CurveParameters withBase(CurveParameters more)
	{
		more.insert({ { "freezingTemperature", 0.0 }, { "residualSaturation", 0.05 } });
		return more;
	}
	static double positive(const CurveParameters& given, const std::string& name, const std::string& unit)
	{
		const double value = given.at(name);
		requireSetting(std::isfinite(value) && value > 0.0, "FreezingCurve." + name, value, "must be positive, in " + unit);
		return value;
	}
	static double undercooling(const CurveParameters& given, const std::string& name)
	{
		const double value = given.at(name);
		requireSetting(
		        std::isfinite(value) && value >= narrowest, "FreezingCurve." + name, value,
		        "must be positive, at least 1e-9, in K (for a jump choose the curve sharp)");
		return value;
	}
};

/// Curves that follow the undercooling theta = T_f - T: fraction(theta) is S_e, slope(theta) is dS_l/dT [1/K], at theta > 0.
template <class Curve> struct CurveOfUndercooling : CurveBase {
	using CurveBase::CurveBase;

	double liquidSaturation(double temperature) const
	{
		const double theta = freezingTemperature - temperature, below = scaled(curve().fraction(theta));
		return theta <= 0.0 ? 1.0 : below;
	}
	double derivative(double temperature) const
	{
		const double theta = freezingTemperature - temperature, below = curve().slope(theta);
		return theta <= 0.0 ? 0.0 : below;
	}

private:
	const Curve& curve() const { return static_cast<const Curve&>(*this); }
};

/// Those of one width.
template <class Curve> struct CurveOfWidth : CurveOfUndercooling<Curve> {
	static CurveParameters parameters() { return CurveBase::withBase({ { "width", 0.5 } }); }
	explicit CurveOfWidth(const CurveParameters& given)
	        : CurveOfUndercooling<Curve>(given)
	        , width(CurveBase::undercooling(given, "width"))
	{}

	double width; ///< W [K]: S_e = 1/e at that undercooling, usually 0.1 to 1
};

/// S_e = exp(-(theta/W)^2), theta = T_f - T (McKenzie et al. 2007).
struct GaussCurve : CurveOfWidth<GaussCurve> {
	static const char* name() { return "gauss"; }
	using CurveOfWidth::CurveOfWidth;

	double fraction(double theta) const
	{
		const double x = theta / width;
		return talik::exponential(-x * x);
	}
	double slope(double theta) const { return (1.0 - residualSaturation) * 2.0 * theta / (width * width) * fraction(theta); }
};

/// S_e = exp(-theta/W).
struct ExponentialCurve : CurveOfWidth<ExponentialCurve> {
	static const char* name() { return "exponential"; }
	using CurveOfWidth::CurveOfWidth;

	double fraction(double theta) const { return talik::exponential(-theta / width); }
	double slope(double theta) const { return (1.0 - residualSaturation) * fraction(theta) / width; }
};

/// S_e = (1 + theta/D)^-a.
struct PowerCurve : CurveOfUndercooling<PowerCurve> {
	static const char*     name() { return "power"; }
	static CurveParameters parameters() { return withBase({ { "width", 1.0 }, { "exponent", 5.0 } }); }
	explicit PowerCurve(const CurveParameters& given)
	        : CurveOfUndercooling(given)
	        , scale(undercooling(given, "width"))
	        , exponent(given.at("exponent"))
	{
		requireSetting(std::isfinite(exponent) && exponent > 1.0, "FreezingCurve.exponent", exponent, "must exceed 1 (usual range 2 to 10)");
	}

	double scale;    ///< D [K]
	double exponent; ///< a [-], > 1, usually 2 to 10

	double fraction(double theta) const { return std::pow(1.0 + theta / scale, -exponent); }
	double slope(double theta) const { return (1.0 - residualSaturation) * exponent / scale * std::pow(1.0 + theta / scale, -exponent - 1.0); }
};

/// S_e falls linearly from one at T_f to zero at frozenTemperature T_m; has exact moving-boundary solutions (Lunardini).
struct LinearCurve : CurveBase {
	static constexpr bool  piecewiseLinear = true;
	static const char*     name() { return "linear"; }
	static CurveParameters parameters() { return withBase({ { "frozenTemperature", -1.0 } }); }
	explicit LinearCurve(const CurveParameters& given)
	        : CurveBase(given)
	        , frozenTemperature(given.at("frozenTemperature"))
	{
		requireSetting(
		        frozenTemperature <= freezingTemperature - narrowest && frozenTemperature > -100.0, "FreezingCurve.frozenTemperature",
		        frozenTemperature, "must lie below freezingTemperature, in degC (for a jump choose the curve sharp)");
	}

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
	static CurveParameters parameters()
	{
		return withBase({ { "airEntryPressure", 1e5 }, { "exponent", 0.4 }, { "suctionCoefficient", 910.0 * 334.0e3 } });
	}
	explicit VanGenuchtenCurve(const CurveParameters& given)
	        : CurveBase(given)
	        , entryPressure(positive(given, "airEntryPressure", "Pa"))
	        , lambda(given.at("exponent"))
	        , suctionCoefficient(positive(given, "suctionCoefficient", "Pa"))
	        , freezingKelvin(freezingTemperature + zeroCelsius)
	{
		requireSetting(lambda > 0.0 && lambda < 1.0, "FreezingCurve.exponent", lambda, "must lie in (0, 1)");
	}

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
	static CurveParameters parameters() { return withBase({}); }
	using CurveBase::CurveBase;

	template <class RootBelow> Piece pieceOf(RootBelow&&) const { return { -std::numeric_limits<double>::infinity(), freezingTemperature }; }
	double                           liquidSaturation(double temperature) const { return temperature >= freezingTemperature ? 1.0 : residualSaturation; }
	double                           derivative(double) const { return 0.0; }
};

/// Measured points, linear in between.
struct TableCurve : CurveBase {
	static constexpr bool piecewiseLinear = true;
	static const char*    name() { return "table"; }
	/// See makeFreezingCurve.
	explicit TableCurve(const std::vector<CurvePoint>& points)
	{
		requireSetting(points.size() >= 2, "FreezingCurve.temperatures: number of points", points.size(), "must be 2 or more");
		requireMonotone(points);
		requireSetting(
		        points.back().liquidSaturation == 1.0, "FreezingCurve.liquidSaturations: last value", points.back().liquidSaturation,
		        "must be 1, at the temperature at which freezing begins");
		points_ = usedPoints(points);
		requireSetting(
		        points_.size() >= 2, "FreezingCurve.liquidSaturations: first value", points_.front().liquidSaturation,
		        "must be less than 1, the liquid that is left in the coldest ground");
		freezingTemperature = points_.back().temperature;
		residualSaturation  = points_.front().liquidSaturation;
	}

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
	/// The points of a table up to the first at which nothing is frozen.
	static std::vector<CurvePoint> usedPoints(const std::vector<CurvePoint>& points)
	{
		const auto thawed = std::find_if(points.begin(), points.end(), [](const CurvePoint& point) { return point.liquidSaturation == 1.0; });
		return { points.begin(), thawed == points.end() ? thawed : thawed + 1 };
	}

	static void requireMonotone(const std::vector<CurvePoint>& points)
	{
		const auto require = [](bool valid, const char* attribute, std::size_t k, double value, const char* remedy) {
			requireSetting(valid, "FreezingCurve." + std::string(attribute) + "[" + std::to_string(k) + "]", value, remedy);
		};
		for (std::size_t k = 0; k < points.size(); ++k) {
			const auto [temperature, saturation] = points[k];
			require(temperature > -100.0 && temperature < 50.0, "temperatures", k, temperature,
			        "must be a temperature in degC between -100 and 50");
			require(saturation >= 0.0 && saturation <= 1.0, "liquidSaturations", k, saturation, "must lie in [0, 1]");
			if (k == 0) continue;
			require(temperature - points[k - 1].temperature >= narrowest, "temperatures", k, temperature,
			        "must exceed the one before by 1e-9 K or more: give the points in ascending order, each temperature once");
			require(saturation >= points[k - 1].liquidSaturation, "liquidSaturations", k, saturation,
			        "must not be less than the one before: liquid water does not decrease as ground warms up");
		}
	}
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
	static constexpr bool neverFreezes = true;
	static const char*    name() { return "unfrozen"; }

	double liquidSaturation(double) const { return 1.0; }
	double derivative(double) const { return 0.0; }
};

} // namespace talik
