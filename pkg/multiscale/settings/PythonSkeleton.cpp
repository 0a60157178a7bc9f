// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/mpm/points/ObjectiveUpdate.hpp>
#include <pkg/multiscale/settings/SkeletonLaws.hpp>
#include <pkg/python/PythonFunction.hpp>

#include <algorithm>

namespace py = boost::python;
namespace np = boost::python::numpy;

namespace talik {

/// Arrays that a law sees, for as many points as it has; reused from step to step.
template <int D> struct LawArrays {
	explicit LawArrays(int count, int states)
	        : gradient(zeros(py::make_tuple(count, D, D)))
	        , strain(zeros(py::make_tuple(count, stressSize<D>)))
	        , stress(zeros(py::make_tuple(count, stressSize<D>)))
	        , state(zeros(py::make_tuple(count, states)))
	        , iceSaturation(zeros(py::make_tuple(count)))
	        , temperature(zeros(py::make_tuple(count)))
	        , volume(zeros(py::make_tuple(count)))
	        , id(np::zeros(py::make_tuple(count), np::dtype::get_builtin<int>()))
	{}
	np::ndarray gradient, strain, stress, state, iceSaturation, temperature, volume, id;
};

/// What a script says of its law.
struct LawOfScript {
	std::string                 name;
	std::shared_ptr<py::object> law;
	double                      modulus; ///< [Pa]
	bool                        canFail;
	std::vector<std::string>    states;
	std::vector<double>         statesAtStart;
	bool                        byStrips;
};

/// Asks a function of Python for the stress of all points at once.
template <int D> class PythonSkeleton final : public SkeletonModel<D> {
public:
	explicit PythonSkeleton(LawOfScript script)
	        : script_(std::move(script))
	{}

	std::string name() const override { return "PythonSkeleton"; }
	bool        canFail() const override { return script_.canFail; }

	void declareFields(PointFields& fields, const std::string& prefix) override
	{
		fields_ = &fields;
		for (const auto& state : script_.states)
			states_.push_back(fields.declare(prefix + state, name(), "of the law", 1));
	}

	void initialise(const SkeletonBatch<D>& b) override
	{
		for (std::size_t s = 0; s < script_.statesAtStart.size(); ++s)
			for (int k = 0; k < b.count; ++k)
				fields_->component(states_[s])[b.place[k]] = script_.statesAtStart[s];
	}

	void tangentModulus(const SkeletonBatch<D>& b, double* modulus) const override { b.fill(modulus, script_.modulus); }

	bool knowsHoopStrain() const override { return true; }
	bool seesStrips() const override { return script_.byStrips; }

	void updateStress(const SkeletonBatch<D>& b) override
	{
		const PythonLock held;
		try {
			show(b);
			ask(b);
		} catch (const py::error_already_set&) {
			refuse("raised " + takePythonError());
		} catch (const std::domain_error& wrong) {
			refuse(wrong.what());
		}
	}

private:
	int states() const { return int(states_.size()); }

	[[noreturn]] void refuse(const std::string& what) const
	{
		throw std::runtime_error(
		        "PythonSkeleton.law " + script_.name + " " + what
		        + "; the step has ended half way: go on from a checkpoint, or begin anew, with another law.");
	}

	void show(const SkeletonBatch<D>& b)
	{
		if (arrays_.size() <= std::size_t(b.strip)) arrays_.resize(std::size_t(b.strip) + 1);
		auto& ofStrip = arrays_[std::size_t(b.strip)];
		if (!ofStrip || ofStrip->id.shape(0) != b.count) {
			ofStrip.reset();
			ofStrip = endingUnderLock(new LawArrays<D>(b.count, states()));
		}
		LawArrays<D>& a        = *ofStrip;
		double *const gradient = numbersOf(a.gradient), *const strain = numbersOf(a.strain), *const stress = numbersOf(a.stress);
		double *const state = numbersOf(a.state), *const ice = numbersOf(a.iceSaturation);
		double *const temperature = numbersOf(a.temperature), *const volume = numbersOf(a.volume);
		int* const    id   = reinterpret_cast<int*>(a.id.get_data());
		constexpr int size = stressSize<D>;
		for (int k = 0; k < b.count; ++k) {
			const int place = b.place[k];
			for (int c = 0; c < D * D; ++c)
				gradient[k * D * D + c] = b.gradient[c][place];
			for (int c = 0; c < size; ++c)
				stress[k * size + c] = b.stress[c][place];
			const MidpointIncrement<D> increment(gradient + k * D * D);
			increment.rotate(stress + k * size);
			if (D == 2) strain[k * size + 2] = b.hoop ? midpointHoop(b.hoop[place]) : 0;
			for (int c = 0; c < D * (D + 1) / 2; ++c)
				strain[k * size + stressOfStrain<D>(c)] = increment.strain[c];
			for (int s = 0; s < states(); ++s)
				state[k * states() + s] = fields_->component(states_[s])[place];
			ice[k]         = b.iceSaturation ? b.iceSaturation[place] : 0;
			temperature[k] = b.temperature ? b.temperature[place] : 0;
			volume[k]      = b.volume[place];
			id[k]          = b.id[place];
		}
	}

	void ask(const SkeletonBatch<D>& b)
	{
		LawArrays<D>& a = *arrays_[std::size_t(b.strip)];
		py::dict      named;
		TALIK_PUT_MEMBERS(named, a, (gradient)(strain)(stress)(state)(iceSaturation)(volume)(id))
		named["temperature"]      = b.temperature ? py::object(a.temperature) : py::object();
		named["timeStep"]         = b.time.motion;
		named["calendarTimeStep"] = b.time.calendar;
		const py::object step     = py::import("types").attr("SimpleNamespace")(*py::tuple(), **named);
		const py::object returned = (*script_.law)(step);
		const auto       stress   = numbers(returned.is_none() ? step.attr("stress") : returned, b, "stress", stressSize<D>);
		const auto       state    = numbers(step.attr("state"), b, "state", states());
		for (int c = 0; c < stressSize<D>; ++c)
			scatter(stress, c, b, b.stress[c]);
		for (int s = 0; s < states(); ++s)
			scatter(state, s, b, fields_->component(states_[s]));
	}

	np::ndarray numbers(const py::object& given, const SkeletonBatch<D>& b, const std::string& what, int width) const
	{
		const np::ndarray result = numbersOfShape(given, what, py::make_tuple(b.count, width));
		const long        bad    = rowNotFinite(result);
		if (bad >= 0) throw std::domain_error("gave point " + std::to_string(b.id[b.place[bad]]) + " a " + what + " that is not finite");
		return result;
	}

	void scatter(const np::ndarray& from, int component, const SkeletonBatch<D>& b, double* to) const
	{
		const double* const first = numbersOf(from);
		const int           width = from.shape(1);
		for (int k = 0; k < b.count; ++k)
			to[b.place[k]] = first[k * width + component];
	}

	const LawOfScript script_;
	/// Of all points, or of those of each strip.
	std::vector<std::shared_ptr<LawArrays<D>>> arrays_;

	PointFields*                     fields_ = nullptr;
	std::vector<PointFields::Handle> states_;
};

} // namespace talik

namespace yade {

class PythonSkeleton : public LawInAnyDimension<PythonSkeleton> {
public:
	template <int D> Model<D> model() const
	{
		const auto function = law.forRun("PythonSkeleton.law");
		return std::make_shared<talik::PythonSkeleton<D>>(
		        talik::LawOfScript { law.name(), function, modulus, canFail, states, statesAtStart, byStrips });
	}
	/// Functions of NumPy do not give the bits of many points for a part of them: it sees the points of a strip, whichever ranks there are, where
	/// the script says so, even on one rank.
	bool shareAmongRanks(const string& what) override
	{
		byStrips = what == "ground";
		return false;
	}
	string notInSlabs(int) const override { return byStrips ? "" : "a law in Python"; }

private:
	bool byStrips = false;

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(PythonSkeleton,SkeletonLaw,"A skeleton law written in Python: a function of all points of the law, called once in each "
			"step. Example: PythonSkeleton(law=lambda step: step.stress+7.7e6*step.strain,modulus=13.5e6).\n\n"
			"The argument has NumPy arrays of n points, in the plane (in space) with components xx, yy, zz, xy (xx, yy, zz, yz, xz, xy): stress (n,4) or (n,6), "
			"effective, tension positive, of the step before and turned with the ground [Pa]; strain of the step, tensor components of the same shape [-]; gradient "
			"(n,2,2) or (n,3,3), increment of the displacement gradient [-]; state (n,k), which the law owns; iceSaturation (n,) [-], 0 where nothing freezes; "
			"temperature (n,) [degC], None in ground without heat; volume (n,) [m^3; in the plane m^2]; id (n,), numbers of the points, whose order changes in a run; "
			"timeStep, time of motion that passes in the step [s]: strain/timeStep is the rate of strain; and calendarTimeStep, time of the calendar that passes, "
			"for creep and ageing [s]. The law writes the new stress and state into the arrays or returns the new stress. The "
			"arrays are used again in the next step: copy what is to be kept. An elastic law costs 80 ns per point and step, of which NumPy takes half, and doubles "
			"the time of a dry step; a step costs 30 us at least. Errors and values that are not finite end the run with a sentence. Checkpoints "
			"have the states and the name of the function, from which it is imported again. With MpmEngine.distribute='ground' the "
			"function sees the points of one strip of the ground after the other, on any number of ranks, and has to keep in state what it remembers of points.",
		((talik::PythonFunction,law,,,"Function of one argument, or an object that can be called so, or the name of one as 'module:name', which is imported."))
		((Real,modulus,NaN,,"Largest modulus of the law in confined compression, lambda+2G of an elastic one [Pa], > 0. It sets the time step: a law that is "
				"stiffer makes the run unstable."))
		((bool,canFail,true,,"Stress is limited by a strength, so that thawed ground may slip under frozen ground. False for elastic laws."))
		((vector<string>,states,,,"Names of the states that the law keeps at each point, columns of step.state; field('skeleton0.name') shows that of "
				"the first law."))
		((vector<Real>,statesAtStart,,,"Their values at the start [of the law], one each; empty: zeros."))
		,talik::PythonFunction::registerOnce();
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(PythonSkeleton);
YADE_PLUGIN((PythonSkeleton));

} // namespace yade
