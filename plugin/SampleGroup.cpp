// SPDX-License-Identifier: GPL-2.0-or-later
#include "SampleGroup.hpp"

#include <pkg/multiscale/samples/RveSample.hpp>
#include <pkg/multiscale/samples/SampleStore.hpp>
#include <pkg/python/StepGate.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>
#include <variant>

namespace py = boost::python;

namespace talik {
namespace {

	using yade::Matrix3r;

	/// Many copies of one sample, each with a history of its own: what stands behind the points of a slope, without the ground.
	template <int Dim> class GroupOf {
	public:
		GroupOf(const yade::RveSample& sample, std::size_t copies)
		{
			for (std::size_t k = 0; k < copies; ++k)
				pool.add(sample.packed<Dim>());
			options.maxInertialNumber  = sample.maxInertialNumber;
			options.maxStrainPerStep   = sample.maxStrainPerStep;
			options.minSteps           = sample.minSteps;
			options.timeStepFollowsIce = sample.timeStepFollowsIce;
			for (std::size_t k = 0; k < copies; ++k)
				requests.push_back({ k, PackedTypes<Dim>::Matrix::Zero(), sample.iceSaturation() });
			stresses.resize(copies, PackedTypes<Dim>::Matrix::Zero());
		}

		/// Every copy is asked once, all in turn; returns the DEM steps done.
		long apply(const Matrix3r& displacementGradient, long steps, bool tangent, int threads)
		{
			options.steps   = steps;
			options.tangent = tangent;
			for (auto& request : requests)
				request.displacementGradient = displacementGradient.template topLeftCorner<Dim, Dim>();
			std::vector<PackedUpdateResult<Dim>> results;
			Py_BEGIN_ALLOW_THREADS;
			results = pool.update(requests, options, threads);
			Py_END_ALLOW_THREADS;
			long done = 0;
			for (std::size_t k = 0; k < results.size(); ++k) {
				if (results[k].blewUp) throw std::runtime_error("SampleGroup.apply: a sample blew up: " + results[k].reason);
				stresses[k] = results[k].stress;
				done += results[k].steps;
			}
			return done;
		}

		std::vector<double>    stress(std::size_t sample) const { return components<Dim>(stresses.at(sample)); }
		const SamplePool<Dim>& samples() const { return pool; }

	private:
		SamplePool<Dim>                                pool;
		PackedUpdateOptions                            options;
		std::vector<PackedRequest<Dim>>                requests;
		std::vector<typename PackedTypes<Dim>::Matrix> stresses; ///< of the last call [Pa]
	};

	/// Such a group of discs or of spheres.
	class SampleGroup {
		std::variant<std::unique_ptr<GroupOf<2>>, std::unique_ptr<GroupOf<3>>> group;

		template <class Visitor> decltype(auto) with(Visitor&& visitor) const
		{
			return std::visit([&](const auto& one) { return visitor(*one); }, group);
		}

	public:
		SampleGroup(const yade::RveSample& sample, std::size_t copies)
		{
			if (sample.dimension() == 2) group = std::make_unique<GroupOf<2>>(sample, copies);
			else group = std::make_unique<GroupOf<3>>(sample, copies);
		}

		long apply(const Matrix3r& displacementGradient, long steps, bool tangent, int threads)
		{
			const StepGate gate; // another thread may ask while this one has let go of Python's lock
			return with([&](auto& all) { return all.apply(displacementGradient, steps, tangent, threads); });
		}

		py::tuple stress(std::size_t sample) const
		{
			const StepGate gate;
			py::list       list;
			for (const double component : with([&](auto& all) { return all.stress(sample); }))
				list.append(component);
			return py::tuple(list);
		}

		std::size_t size() const
		{
			return with([](auto& all) { return all.samples().size(); });
		}
		std::size_t bytes() const
		{
			const StepGate gate;
			return with([](auto& all) { return all.samples().bytes(); });
		}
		std::size_t distinctStates() const
		{
			const StepGate gate;
			return with([](auto& all) { return all.samples().distinctStates(); });
		}
	};

} // namespace

void exposeSampleGroup()
{
	py::class_<SampleGroup, boost::noncopyable>(
	        "SampleGroup",
	        "Many copies of an RveSample, each with a history of its own: what stands behind the points of a slope, without the ground. "
	        "SampleGroup(sample, copies).",
	        py::init<const yade::RveSample&, std::size_t>((py::arg("sample"), py::arg("copies"))))
	        .def("apply", &SampleGroup::apply, (py::arg("displacementGradient"), py::arg("steps") = 0, py::arg("tangent") = false, py::arg("threads") = 1),
	             "Apply the same displacement gradient (3x3; of discs the in-plane part) to each, one after the other, at constant ice saturation. "
	             "steps: moving DEM steps, 0: as the limits of the sample say. Returns the number of all DEM steps. RuntimeError on blow-up.")
	        .def("stress", &SampleGroup::stress, py::arg("sample"),
	             "(xx, yy, xy) [Pa], of spheres (xx, yy, zz, yz, xz, xy), tension positive, that the last apply() returned for a sample.")
	        .def("__len__", &SampleGroup::size)
	        .add_property("bytes", &SampleGroup::bytes, "Bytes held by the samples and their neighbour lists.")
	        .add_property("distinctStates", &SampleGroup::distinctStates, "Number of states that are not shared.");
}

} // namespace talik
