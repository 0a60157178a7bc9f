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
		explicit CurveOf(const CurveParameters& parameters)
		        : CurveOf(Curve(parameters), parameters)
		{}
		CurveOf(const Curve& curve, const CurveParameters& parameters)
		        : curve_(curve)
		        , name_(Curve::name())
		        , parameters_(parameters)
		{}
		const std::string&     name() const override { return name_; }
		const CurveParameters& parameters() const override { return parameters_; }
		double                 freezingTemperature() const override { return curve_.freezingTemperature; }
		double                 residualSaturation() const override { return curve_.residualSaturation; }
		bool                   isSharp() const override { return Curve::sharp; }
		double                 liquidSaturation(double temperature) const override { return curve_.liquidSaturation(temperature); }
		double                 derivative(double temperature) const override { return curve_.derivative(temperature); }

		std::size_t solveTemperatures(const EnthalpyModel& model, const EnthalpyBatch& batch) const override
		{
			return TemperatureSolver<Curve>(model.formula(), curve_).solve(batch);
		}

	private:
		Curve           curve_;
		std::string     name_;
		CurveParameters parameters_;
	};

	struct Registration {
		std::vector<CurveParameter> (*parameters)();
		FreezingCurvePtr (*make)(const CurveParameters&);
	};

	template <class Curve> std::pair<const std::string, Registration> entry()
	{
		return { Curve::name(),
			 { &Curve::parameters, [](const CurveParameters& values) -> FreezingCurvePtr { return std::make_shared<CurveOf<Curve>>(values); } } };
	}

	const std::map<std::string, Registration>& registry()
	{
		static const std::map<std::string, Registration> table {
			entry<VanGenuchtenCurve>(), entry<GaussCurve>(),  entry<ExponentialCurve>(),
			entry<PowerCurve>(),        entry<LinearCurve>(), entry<SharpCurve>(),
		};
		return table;
	}

	std::string listed(const std::vector<std::string>& names)
	{
		std::string text;
		for (const std::string& name : names)
			text += (text.empty() ? "" : ", ") + name;
		return text;
	}

	const Registration& registered(const std::string& name)
	{
		const auto found = registry().find(name);
		if (found == registry().end())
			throw std::invalid_argument("FreezingCurve.curve = '" + name + "': choose one of " + listed(freezingCurveNames()));
		return found->second;
	}

	CurveParameters completed(const std::string& name, const std::vector<CurveParameter>& known, const CurveParameters& given)
	{
		CurveParameters          values;
		std::vector<std::string> names;
		for (const CurveParameter& parameter : known) {
			values[parameter.name] = parameter.defaultValue;
			names.push_back(parameter.name);
		}
		for (const auto& [key, value] : given) {
			if (!values.count(key))
				throw std::invalid_argument("FreezingCurve.curve = '" + name + "' has no parameter '" + key + "': it has " + listed(names));
			values[key] = value;
		}
		return values;
	}

	std::vector<CurveParameter> with(std::vector<CurveParameter> parameters, const std::vector<CurveParameter>& more)
	{
		parameters.insert(parameters.end(), more.begin(), more.end());
		return parameters;
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

std::vector<CurveParameter> CurveBase::baseParameters()
{
	return { { "freezingTemperature", 0.0, "T_f, ice forms below it [degC]" },
		 { "residualSaturation", 0.05, "S_r, liquid saturation that never freezes [-], in [0,1)" } };
}

std::vector<CurveParameter> GaussCurve::parameters()
{
	return with(baseParameters(), { { "width", 0.5, "W, undercooling at which S_e = 1/e [K], usually 0.3 to 1" } });
}
GaussCurve::GaussCurve(const CurveParameters& given)
        : CurveBase(given)
        , width(undercooling(given, "width"))
{}

std::vector<CurveParameter> ExponentialCurve::parameters()
{
	return with(baseParameters(), { { "width", 0.5, "W, undercooling at which S_e = 1/e [K], usually 0.1 to 1" } });
}
ExponentialCurve::ExponentialCurve(const CurveParameters& given)
        : CurveBase(given)
        , width(undercooling(given, "width"))
{}

std::vector<CurveParameter> PowerCurve::parameters()
{
	return with(baseParameters(), { { "width", 1.0, "D [K]" }, { "exponent", 5.0, "a [-], > 1, usually 2 to 10" } });
}
PowerCurve::PowerCurve(const CurveParameters& given)
        : CurveBase(given)
        , scale(undercooling(given, "width"))
        , exponent(given.at("exponent"))
{
	requireSetting(std::isfinite(exponent) && exponent > 1.0, "FreezingCurve.exponent", exponent, "must exceed 1 (usual range 2 to 10)");
}

std::vector<CurveParameter> LinearCurve::parameters()
{
	return with(baseParameters(), { { "frozenTemperature", -1.0, "T_m, S_l = S_r below it [degC], < T_f" } });
}
LinearCurve::LinearCurve(const CurveParameters& given)
        : CurveBase(given)
        , frozenTemperature(given.at("frozenTemperature"))
{
	requireSetting(
	        frozenTemperature <= freezingTemperature - narrowest && frozenTemperature > -100.0, "FreezingCurve.frozenTemperature", frozenTemperature,
	        "must lie below freezingTemperature, in degC (for a jump choose the curve sharp)");
}

std::vector<CurveParameter> VanGenuchtenCurve::parameters()
{
	return with(
	        baseParameters(),
	        { { "airEntryPressure", 1e5, "P_0 [Pa]: sand 1e4 to 5e4, silt 5e4 to 5e5, clay 2e5 to 2e6" },
	          { "exponent", 0.4, "lambda [-], in (0,1), usually 0.2 to 0.6" },
	          { "suctionCoefficient", 910.0 * 334.0e3, "rho_i L_f [Pa]" } });
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

std::vector<CurveParameter> SharpCurve::parameters() { return baseParameters(); }
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

FreezingCurvePtr makeFreezingCurve(const std::vector<CurvePoint>& points)
{
	const TableCurve curve(points);
	return std::make_shared<CurveOf<TableCurve>>(
	        curve, CurveParameters { { "freezingTemperature", curve.freezingTemperature }, { "residualSaturation", curve.residualSaturation } });
}

FreezingCurvePtr makeFreezingCurve(const std::string& name, const CurveParameters& parameters)
{
	const Registration& entry = registered(name);
	return entry.make(completed(name, entry.parameters(), parameters));
}

FreezingCurvePtr unfrozenCurve()
{
	static const FreezingCurvePtr curve = std::make_shared<CurveOf<UnfrozenCurve>>(CurveParameters {});
	return curve;
}

std::vector<std::string> freezingCurveNames()
{
	std::vector<std::string> names;
	for (const auto& [name, entry] : registry())
		names.push_back(name);
	return names;
}

std::vector<CurveParameter> freezingCurveParameters(const std::string& name) { return registered(name).parameters(); }

} // namespace talik
