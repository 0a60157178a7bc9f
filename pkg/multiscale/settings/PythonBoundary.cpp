// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/settings/GroundBoundaries.hpp>
#include <pkg/python/PythonFunction.hpp>
#include <pkg/ranks/Communicator.hpp>

namespace py = boost::python;

namespace talik {
namespace {
	template <int D> py::object arrayOf(const std::vector<Vec<D>>& vectors)
	{
		if (vectors.empty()) return py::object();
		return tableOf(vectors.size(), D, [&](std::size_t k, std::size_t a) { return vectors[k][a]; });
	}

	py::object arrayOf(const std::vector<double>& numbers)
	{
		if (numbers.empty()) return py::object();
		return tableOf(numbers.size(), 1, [&](std::size_t k, std::size_t) { return numbers[k]; });
	}
} // namespace

/// What a function of a script may give.
enum class Gift { heat, temperature, traction, acceleration };

constexpr std::pair<Gift, const char*> namesOfGifts[] = {
	{ Gift::heat, "heat" }, { Gift::temperature, "temperature" }, { Gift::traction, "traction" }, { Gift::acceleration, "acceleration" }
};

inline const char* nameOf(Gift gift)
{
	for (const auto& [known, name] : namesOfGifts)
		if (known == gift) return name;
	return "";
}

/// Gives the nodes of its region what a function of Python says, by their state.
template <int D> class PythonBoundary final : public Boundary<D> {
public:
	PythonBoundary(const Region<D>& region, Gift gift, std::string function, std::shared_ptr<py::object> call)
	        : Boundary<D>(region, "PythonBoundary", gift == Gift::heat || gift == Gift::temperature ? "heat" : "motion")
	        , gift_(gift)
	        , function_(std::move(function))
	        , call_(std::move(call))
	{}

	void validate(const Grid<D>& grid) const override
	{
		if (gift_ == Gift::traction) this->requireRegion(!inBox(), "must be surface, cavities or a side: traction acts on a surface");
		if (gift_ == Gift::temperature && inBox())
			this->requireRegion(!nodeShares(grid, this->region_).empty(), "must be surface, cavities, a side, or a box or disc with room in it");
		if (gift_ == Gift::acceleration) this->requireRegion(inBox(), "must be a box or disc: acceleration acts in a volume");
		Boundary<D>::validate(grid);
	}
	bool usesNodes() const override { return true; }
	bool heats() const override { return this->effect() == "heat" && !inBox(); }
	bool producesHeat() const override { return gift_ == Gift::heat && inBox(); }
	bool prescribesTemperature() const override { return gift_ == Gift::temperature && inBox(); }
	bool loads() const override { return gift_ == Gift::traction; }
	bool accelerates() const override { return gift_ == Gift::acceleration; }

	SurfaceHeat heatAt(double, std::size_t k) const override
	{
		SurfaceHeat heat;
		heat.atSurface                              = gift_ == Gift::temperature;
		(heat.atSurface ? heat.ambient : heat.flux) = given_[k][0];
		return heat;
	}
	double temperatureAt(double, std::size_t k) const override { return given_[k][0]; }
	double powerAt(double, std::size_t k) const override { return given_[k][0]; }
	Vec<D> tractionAt(double, const Vec<D>&, std::size_t k) const override { return given_[k]; }
	Vec<D> accelerationAt(std::size_t k) const override { return given_[k]; }

	std::uint64_t digest() const override { return digest_; }

	void evaluate(const BoundaryNodes<D>& nodes) override
	{
		given_.assign(nodes.slots, Vec<D> {});
		digest_ = 0;
		if (nodes.slot.empty()) return;
		const PythonLock held;
		try {
			ask(nodes);
		} catch (const py::error_already_set&) {
			refuse("raised " + takePythonError());
		} catch (const std::domain_error& wrong) {
			refuse(wrong.what());
		}
	}

private:
	bool              inBox() const { return this->region_.kind == Region<D>::Kind::nodeBox; }
	[[noreturn]] void refuse(const std::string& what) const
	{
		throw std::runtime_error("PythonBoundary.function " + function_ + " " + what + "; this step was not made.");
	}

	static void requireTemperatures(const double* given, std::size_t count)
	{
		for (std::size_t k = 0; k < count; ++k)
			if (!(given[k] > -100.0 && given[k] < 100.0))
				throw std::domain_error("gave a temperature of " + talik::asText(given[k]) + ", which is not between -100 and 100 degC");
	}

	void ask(const BoundaryNodes<D>& nodes)
	{
		const int width = this->effect() == "heat" ? 1 : D;
		py::dict  named;
		named["position"]          = arrayOf<D>(nodes.position);
		named["normal"]            = arrayOf<D>(nodes.normal);
		named["velocity"]          = arrayOf<D>(nodes.velocity);
		named["temperature"]       = arrayOf(nodes.temperature);
		named["pressure"]          = arrayOf(nodes.pressure);
		named["time"]              = nodes.time;
		const py::object  returned = (*call_)(py::import("types").attr("SimpleNamespace")(*py::tuple(), **named));
		const char* const what     = nameOf(gift_);
		const auto numbers = numbersOfShape(returned, what, width == 1 ? py::make_tuple(nodes.slot.size()) : py::make_tuple(nodes.slot.size(), D));
		if (rowNotFinite(numbers) >= 0) throw std::domain_error(std::string("gave a ") + what + " that is not finite");
		if (gift_ == Gift::temperature) requireTemperatures(numbersOf(numbers), nodes.slot.size());
		Digest all;
		all.add(numbersOf(numbers), nodes.slot.size() * width * sizeof(double));
		digest_ = all.value();
		for (std::size_t k = 0; k < nodes.slot.size(); ++k)
			if (nodes.slot[k] >= 0) std::copy_n(numbersOf(numbers) + k * width, width, given_[nodes.slot[k]].begin());
	}

	const Gift                        gift_;
	const std::string                 function_;
	const std::shared_ptr<py::object> call_;
	std::vector<Vec<D>>               given_; ///< to each node of the surface or volume, in this step
	std::uint64_t                     digest_ = 0;
};

} // namespace talik

namespace yade {

class PythonBoundary : public BoundaryInAnyDimension<PythonBoundary> {
public:
	template <int D> Pointer<D> make() const
	{
		const auto call = function.forRun("PythonBoundary.function");
		return std::make_shared<talik::PythonBoundary<D>>(always<D>(), gift(), function.name(), call);
	}

private:
	talik::Gift gift() const
	{
		for (const auto& [gift, name] : talik::namesOfGifts)
			if (gives == name) return gift;
		throw std::invalid_argument("PythonBoundary.gives is '" + gives + "': choose heat, temperature, traction or acceleration.");
	}

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(PythonBoundary,GroundBoundary,"A boundary or an effect written in Python: a function of the nodes of its region, called once "
			"in each step, that gives heat, temperature, traction or acceleration. Example, a surface that radiates: "
			"PythonBoundary(region='surface',function=lambda nodes: 200-5.67e-8*((nodes.temperature+273.15)**4-260**4)).\n\n"
			"The argument has NumPy arrays of the n nodes "
			"of the grid that have ground: position (n,2) or (n,3) [m], velocity of the grains at the beginning of the step [m/s], normal, "
			"outward, on surfaces [-], temperature (n,) [degC], at a node the mean of the ground around it, pressure of pore water (n,) [Pa], "
			"None each where the ground has none, and time, of the calendar [s]. The function returns heat into the ground (n,), in W/m^2 on "
			"surfaces and sides and W/m^3 of ground in a box or disc; or the temperature (n,) that the surface, the side, or the ground in a box or disc has "
			"[degC]; or traction (n,2) or (n,3) on surfaces and sides [Pa]; or acceleration "
			"(n,2) or (n,3) in a box or disc [m/s^2], beside gravity and in ground without water. balance() has it in heatIn, loadWork and "
			"impulse. What it gives acts for a step: heat swings where that of one step reverses the temperature. Errors and "
			"values that are not finite end the run with a sentence. Checkpoints have the name of the function, from which it is imported "
			"again.",
		((talik::PythonFunction,function,,,"Function of one argument, or an object that can be called so, or the name of one as 'module:name', which is imported."))
		((string,gives,"heat",,"heat, temperature, traction or acceleration."))
		,talik::PythonFunction::registerOnce();
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(PythonBoundary);
YADE_PLUGIN((PythonBoundary));

} // namespace yade
