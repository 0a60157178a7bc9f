// SPDX-License-Identifier: GPL-2.0-or-later
#include "SampleGroup.hpp"

#include <pkg/multiscale/samples/RveSample.hpp>
#include <pkg/multiscale/samples/SampleStore.hpp>
#include <pkg/python/StepGate.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>

namespace py = boost::python;

namespace talik {
namespace {

	using yade::Matrix3r;

	/// Many copies of one sample, each with a history of its own: what stands behind the points of a slope, without the ground.
	struct SampleGroup {
		virtual ~SampleGroup() = default;
		/// Every copy is asked once, all in turn; returns the DEM steps done.
		virtual long        apply(const Matrix3r& displacementGradient, long steps, bool tangent, int threads) = 0;
		virtual py::tuple   stress(std::size_t sample) const                                                   = 0;
		virtual std::size_t size() const                                                                       = 0;
		virtual std::size_t bytes() const                                                                      = 0;
		virtual std::size_t distinctStates() const                                                             = 0;
	};

	/// Of discs or of spheres.
	template <int Dim> class GroupOf final : public SampleGroup {
	public:
		GroupOf(const yade::RveSample& sample, std::size_t copies)
		        : results(copies)
		{
			TALIK_TAKE_ATTRIBUTES(options, sample, (maxInertialNumber)(maxStrainPerStep)(minSteps)(timeStepFollowsIce))
			for (std::size_t k = 0; k < copies; ++k) {
				pool.add(sample.packed<Dim>());
				requests.push_back({ k, PackedTypes<Dim>::Matrix::Zero(), sample.iceSaturation() });
			}
		}

		long apply(const Matrix3r& displacementGradient, long steps, bool tangent, int threads) override
		{
			const StepGate gate; // another thread may ask while this one has let go of Python's lock
			options.steps   = steps;
			options.tangent = tangent;
			for (auto& request : requests)
				request.displacementGradient = partOf<Dim>(displacementGradient);
			Py_BEGIN_ALLOW_THREADS;
			results = pool.update(requests, options, threads);
			Py_END_ALLOW_THREADS;
			long done = 0;
			for (const auto& result : results) {
				if (result.blewUp) throw std::runtime_error("SampleGroup.apply: a sample blew up: " + result.reason);
				done += result.steps;
			}
			return done;
		}

		py::tuple stress(std::size_t sample) const override
		{
			const StepGate gate;
			return py::tuple(listOf(components<Dim>(results.at(sample).stress)));
		}
		std::size_t size() const override { return pool.size(); }
		std::size_t bytes() const override
		{
			const StepGate gate;
			return pool.bytes();
		}
		std::size_t distinctStates() const override
		{
			const StepGate gate;
			return pool.distinctStates();
		}

	private:
		SamplePool<Dim>                      pool;
		PackedUpdateOptions                  options;
		std::vector<PackedRequest<Dim>>      requests;
		std::vector<PackedUpdateResult<Dim>> results; ///< of the last call
	};

	std::shared_ptr<SampleGroup> make(const yade::RveSample& sample, std::size_t copies)
	{
		if (sample.dimension() == 2) return std::make_shared<GroupOf<2>>(sample, copies);
		return std::make_shared<GroupOf<3>>(sample, copies);
	}

} // namespace

void exposeSampleGroup()
{
	py::class_<SampleGroup, std::shared_ptr<SampleGroup>, boost::noncopyable>(
	        "SampleGroup",
	        "Many copies of an RveSample, each with a history of its own: what stands behind the points of a slope, without the ground. "
	        "SampleGroup(sample, copies).",
	        py::no_init)
	        .def("__init__", py::make_constructor(make, py::default_call_policies(), (py::arg("sample"), py::arg("copies"))))
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
