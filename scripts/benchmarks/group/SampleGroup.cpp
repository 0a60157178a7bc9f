// SPDX-License-Identifier: GPL-2.0-or-later
// The module talik_bench of scripts/bench: many copies of one sample, each with a history of its own, as behind the points of a slope.
#include <boost/python.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>

namespace py = boost::python;

namespace talik {
namespace {
	struct SampleGroup {
		virtual ~SampleGroup()                                                                                        = default;
		virtual long        apply(const Eigen::Matrix3d& displacementGradient, long steps, bool tangent, int threads) = 0;
		virtual std::size_t size() const                                                                              = 0;
		virtual std::size_t bytes() const                                                                             = 0;
	};

	/// Of discs or of spheres.
	template <int Dim> class GroupOf final : public SampleGroup {
	public:
		GroupOf(const PackedState<Dim>& state, std::size_t copies)
		{
			for (std::size_t k = 0; k < copies; ++k) {
				pool.add(state);
				requests.push_back({ k, PackedTypes<Dim>::Matrix::Zero(), state.iceSaturation });
			}
		}

		long apply(const Eigen::Matrix3d& displacementGradient, long steps, bool tangent, int threads) override
		{
			PackedUpdateOptions options;
			options.steps   = steps;
			options.tangent = tangent;
			for (auto& request : requests)
				request.displacementGradient = displacementGradient.topLeftCorner<Dim, Dim>();
			long done = 0;
			for (const auto& result : pool.update(requests, options, threads)) {
				if (result.blewUp) throw std::runtime_error("SampleGroup.apply: a sample blew up: " + result.reason);
				done += result.steps;
			}
			return done;
		}
		std::size_t size() const override { return pool.size(); }
		std::size_t bytes() const override { return pool.bytes(); }

	private:
		SamplePool<Dim>                 pool;
		std::vector<PackedRequest<Dim>> requests;
	};

	std::shared_ptr<SampleGroup> make(const py::object& stateBytes, std::size_t copies)
	{
		char*      data = nullptr;
		Py_ssize_t size = 0;
		if (PyBytes_AsStringAndSize(stateBytes.ptr(), &data, &size) < 0) py::throw_error_already_set();
		const std::string bytes(data, std::size_t(size));
		if (packedDimension(bytes) == 2) return std::make_shared<GroupOf<2>>(PackedState<2>::fromBytes(bytes), copies);
		return std::make_shared<GroupOf<3>>(PackedState<3>::fromBytes(bytes), copies);
	}
} // namespace
} // namespace talik

BOOST_PYTHON_MODULE(talik_bench)
{
	using talik::SampleGroup;
	py::class_<SampleGroup, std::shared_ptr<SampleGroup>, boost::noncopyable>("SampleGroup", "SampleGroup(sample.stateBytes, copies).", py::no_init)
	        .def("__init__", py::make_constructor(talik::make, py::default_call_policies(), (py::arg("stateBytes"), py::arg("copies"))))
	        .def("apply", &SampleGroup::apply, (py::arg("displacementGradient"), py::arg("steps"), py::arg("tangent") = false, py::arg("threads") = 1),
	             "Apply the same displacement gradient to each, one after the other, in so many moving steps. Returns the number of all DEM steps.")
	        .def("__len__", &SampleGroup::size)
	        .add_property("bytes", &SampleGroup::bytes, "Bytes held by the samples and their neighbour lists.");
}
