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

} // namespace

FreezingCurvePtr makeFreezingCurve(const std::vector<CurvePoint>& points) { return std::make_shared<CurveOf<TableCurve>>(TableCurve(points)); }

FreezingCurvePtr makeFreezingCurve(const std::string& name, const CurveParameters& parameters)
{
	const Registration& entry = registered(name);
	return entry.make(completed(name, entry.parameters(), parameters));
}

FreezingCurvePtr unfrozenCurve()
{
	static const FreezingCurvePtr curve = std::make_shared<CurveOf<UnfrozenCurve>>(UnfrozenCurve());
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
