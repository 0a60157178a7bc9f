// SPDX-License-Identifier: GPL-2.0-or-later
#include "SampleGroup.hpp"

#include <pkg/multiscale/RveSample.hpp>
#include <pkg/rve/open/StepGate.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>

namespace py = boost::python;

namespace talik {
namespace {

	using Matrix = PackedTypes<2>::Matrix;
	using yade::Matrix3r;

	/// Many copies of one sample, each with a history of its own: what stands behind the points of a slope, without the ground.
	class SampleGroup {
	public:
		SampleGroup(const yade::RveSample& sample, std::size_t copies)
		        : iceSaturation(sample.iceSaturation())
		{
			for (std::size_t k = 0; k < copies; k++)
				pool.add(sample.packed());
			options.maxInertialNumber = sample.maxInertialNumber;
			options.maxStrainPerStep  = sample.maxStrainPerStep;
			options.minSteps          = sample.minSteps;
			for (std::size_t k = 0; k < copies; k++)
				requests.push_back({ k, Matrix::Zero(), iceSaturation });
			results.resize(copies);
		}

		/// Every copy is asked once, all in turn; returns the DEM steps done.
		long apply(const Matrix3r& displacementGradient, long steps, bool tangent, int threads)
		{
			const StepGate gate; // another thread may ask while this one has let go of Python's lock
			options.steps   = steps;
			options.tangent = tangent;
			for (auto& request : requests)
				request.displacementGradient = displacementGradient.topLeftCorner<2, 2>();
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

		py::tuple stress(std::size_t sample) const
		{
			const StepGate gate;
			const Matrix&  s = results.at(sample).stress;
			return py::make_tuple(s(0, 0), s(1, 1), s(0, 1));
		}

		std::size_t size() const { return pool.size(); }
		std::size_t bytes() const
		{
			const StepGate gate;
			return pool.bytes();
		}
		std::size_t distinctStates() const
		{
			const StepGate gate;
			return pool.distinctStates();
		}

	private:
		double                             iceSaturation;
		SamplePool<2>                      pool;
		PackedUpdateOptions                options;
		std::vector<PackedRequest<2>>      requests;
		std::vector<PackedUpdateResult<2>> results;
	};

} // namespace

void exposeSampleGroup()
{
	py::class_<SampleGroup>(
	        "SampleGroup",
	        "Many copies of an RveSample, each with a history of its own: what stands behind the points of a slope, without the ground. "
	        "SampleGroup(sample, copies).",
	        py::init<const yade::RveSample&, std::size_t>((py::arg("sample"), py::arg("copies"))))
	        .def("apply", &SampleGroup::apply, (py::arg("displacementGradient"), py::arg("steps") = 0, py::arg("tangent") = false, py::arg("threads") = 1),
	             "Apply the same displacement gradient (3x3, in-plane part) to each, one after the other, at constant ice saturation. "
	             "steps: moving DEM steps, 0: as the limits of the sample say. Returns the number of all DEM steps. RuntimeError on blow-up.")
	        .def("stress", &SampleGroup::stress, py::arg("sample"), "(xx, yy, xy) [Pa], tension positive, that the last apply() returned for a sample.")
	        .def("__len__", &SampleGroup::size)
	        .add_property("bytes", &SampleGroup::bytes, "Bytes held by the samples and their neighbour lists.")
	        .add_property("distinctStates", &SampleGroup::distinctStates, "Number of states that are not shared.");
}

} // namespace talik
