// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/thm/FreezingCurve.hpp>
#include <pkg/thm/FreezingCurveShapes.hpp>
#include <pkg/thm/TemperatureSolver.hpp>

#include <algorithm>
#include <stdexcept>

namespace talik {

namespace {

	template <class Curve> class CurveOf final : public FreezingCurve {
	public:
		explicit CurveOf(const Curve& curve)
		        : curve_(curve)
		{}
		std::string name() const override { return Curve::name(); }
		double      freezingTemperature() const override { return curve_.freezingTemperature; }
		double      residualSaturation() const override { return curve_.residualSaturation; }
		bool        isSharp() const override { return Curve::sharp; }
		double      liquidSaturation(double temperature) const override { return curve_.liquidSaturation(temperature); }
		double      derivative(double temperature) const override { return curve_.derivative(temperature); }

		std::size_t solveTemperatures(const EnthalpyModel& model, const EnthalpyBatch& batch) const override
		{
			return TemperatureSolver<Curve>(model.formula(), curve_).solve(batch);
		}

	private:
		Curve curve_;
	};

	struct Registration {
		CurveParameters (*parameters)();
		FreezingCurvePtr (*make)(const CurveParameters&);
	};

	template <class Curve> std::pair<const std::string, Registration> entry()
	{
		return { Curve::name(), { &Curve::parameters, [](const CurveParameters& values) -> FreezingCurvePtr {
			                         return std::make_shared<CurveOf<Curve>>(Curve(values));
			                 } } };
	}

	const std::map<std::string, Registration>& registry()
	{
		static const std::map<std::string, Registration> table {
			entry<VanGenuchtenCurve>(), entry<GaussCurve>(),  entry<ExponentialCurve>(),
			entry<PowerCurve>(),        entry<LinearCurve>(), entry<SharpCurve>(),
		};
		return table;
	}

	template <class Named> std::string listed(const std::map<std::string, Named>& all)
	{
		std::string text;
		for (const auto& [name, of] : all)
			text += (text.empty() ? "" : ", ") + name;
		return text;
	}

	const Registration& registered(const std::string& name)
	{
		const auto found = registry().find(name);
		if (found == registry().end()) throw std::invalid_argument("FreezingCurve.curve = '" + name + "': choose one of " + listed(registry()));
		return found->second;
	}

	/// given, and for what is missing there the values of known.
	CurveParameters completed(const std::string& name, const CurveParameters& known, CurveParameters given)
	{
		for (const auto& [key, value] : given)
			if (!known.count(key))
				throw std::invalid_argument("FreezingCurve.curve = '" + name + "' has no parameter '" + key + "': it has " + listed(known));
		given.insert(known.begin(), known.end());
		return given;
	}

	/// What all curves have, and more.
	CurveParameters withBase(CurveParameters more)
	{
		more.insert({ { "freezingTemperature", 0.0 }, { "residualSaturation", 0.05 } });
		return more;
	}

	double positive(const CurveParameters& given, const std::string& name, const std::string& unit)
	{
		const double value = given.at(name);
		requireSetting(std::isfinite(value) && value > 0.0, "FreezingCurve." + name, value, "must be positive, in " + unit);
		return value;
	}

	constexpr double narrowest = 1e-9; // [K]; a millionth of what any ground shows, and its square is a number

	double undercooling(const CurveParameters& given, const std::string& name)
	{
		const double value = given.at(name);
		requireSetting(
		        std::isfinite(value) && value >= narrowest, "FreezingCurve." + name, value,
		        "must be positive, at least 1e-9, in K (for a jump choose the curve sharp)");
		return value;
	}

} // namespace

CurveBase::CurveBase(const CurveParameters& given)
{
	if (given.empty()) return;
	freezingTemperature = given.at("freezingTemperature");
	residualSaturation  = given.at("residualSaturation");
	requireSetting(
	        freezingTemperature > -50.0 && freezingTemperature < 50.0, "FreezingCurve.freezingTemperature", freezingTemperature,
	        "must be a temperature in degC between -50 and 50 (pure water: 0)");
	requireSetting(
	        residualSaturation >= 0.0 && residualSaturation < 1.0, "FreezingCurve.residualSaturation", residualSaturation,
	        "must lie in [0, 1); 0.01 or more keeps the liquid defined in frozen ground");
}

CurveParameters GaussCurve::parameters() { return withBase({ { "width", 0.5 } }); }
GaussCurve::GaussCurve(const CurveParameters& given)
        : CurveBase(given)
        , width(undercooling(given, "width"))
{}

CurveParameters ExponentialCurve::parameters() { return withBase({ { "width", 0.5 } }); }
ExponentialCurve::ExponentialCurve(const CurveParameters& given)
        : CurveBase(given)
        , width(undercooling(given, "width"))
{}

CurveParameters PowerCurve::parameters() { return withBase({ { "width", 1.0 }, { "exponent", 5.0 } }); }
PowerCurve::PowerCurve(const CurveParameters& given)
        : CurveBase(given)
        , scale(undercooling(given, "width"))
        , exponent(given.at("exponent"))
{
	requireSetting(std::isfinite(exponent) && exponent > 1.0, "FreezingCurve.exponent", exponent, "must exceed 1 (usual range 2 to 10)");
}

CurveParameters LinearCurve::parameters() { return withBase({ { "frozenTemperature", -1.0 } }); }
LinearCurve::LinearCurve(const CurveParameters& given)
        : CurveBase(given)
        , frozenTemperature(given.at("frozenTemperature"))
{
	requireSetting(
	        frozenTemperature <= freezingTemperature - narrowest && frozenTemperature > -100.0, "FreezingCurve.frozenTemperature", frozenTemperature,
	        "must lie below freezingTemperature, in degC (for a jump choose the curve sharp)");
}

CurveParameters VanGenuchtenCurve::parameters()
{
	return withBase({ { "airEntryPressure", 1e5 }, { "exponent", 0.4 }, { "suctionCoefficient", 910.0 * 334.0e3 } });
}
VanGenuchtenCurve::VanGenuchtenCurve(const CurveParameters& given)
        : CurveBase(given)
        , entryPressure(positive(given, "airEntryPressure", "Pa"))
        , lambda(given.at("exponent"))
        , suctionCoefficient(positive(given, "suctionCoefficient", "Pa"))
        , freezingKelvin(freezingTemperature + zeroCelsius)
{
	requireSetting(lambda > 0.0 && lambda < 1.0, "FreezingCurve.exponent", lambda, "must lie in (0, 1)");
}

CurveParameters SharpCurve::parameters() { return withBase({}); }
SharpCurve::SharpCurve(const CurveParameters& given)
        : CurveBase(given)
{}

namespace {
	/// The points of a table up to the first at which nothing is frozen.
	std::vector<CurvePoint> usedPoints(const std::vector<CurvePoint>& points)
	{
		const auto thawed = std::find_if(points.begin(), points.end(), [](const CurvePoint& point) { return point.liquidSaturation == 1.0; });
		return { points.begin(), thawed == points.end() ? thawed : thawed + 1 };
	}

	void requireMonotone(const std::vector<CurvePoint>& points)
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
} // namespace

TableCurve::TableCurve(std::vector<CurvePoint> points)
        : CurveBase(CurveParameters {})
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

FreezingCurvePtr makeFreezingCurve(const std::vector<CurvePoint>& points) { return std::make_shared<CurveOf<TableCurve>>(TableCurve(points)); }

FreezingCurvePtr makeFreezingCurve(const std::string& name, const CurveParameters& parameters)
{
	const Registration& entry = registered(name);
	return entry.make(completed(name, entry.parameters(), parameters));
}

FreezingCurvePtr unfrozenCurve()
{
	static const FreezingCurvePtr curve = std::make_shared<CurveOf<UnfrozenCurve>>(UnfrozenCurve({}));
	return curve;
}

std::vector<std::string> freezingCurveNames()
{
	std::vector<std::string> names;
	for (const auto& [name, entry] : registry())
		names.push_back(name);
	return names;
}

CurveParameters freezingCurveParameters(const std::string& name) { return registered(name).parameters(); }

} // namespace talik
