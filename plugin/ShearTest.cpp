// SPDX-License-Identifier: GPL-2.0-or-later
#include "ShearTest.hpp"

#include <pkg/base/ThreadPool.hpp>
#include <pkg/multiscale/samples/RveSample.hpp>
#include <pkg/python/PythonFunction.hpp>
#include <pkg/python/ScriptValues.hpp>
#include <pkg/rve/SimpleShear.hpp>

namespace py = boost::python;

namespace talik {
namespace {

	struct Record {
		std::vector<double> shearStress, normalStress;
		std::string         failure;
	};

	template <int Dim> Record record(const yade::RveSample& of, const ShearPath& path)
	{
		PackedUpdateOptions options;
		TALIK_TAKE_ATTRIBUTES(options, of, (maxInertialNumber)(maxStrainPerStep)(minSteps)(timeStepFollowsIce))
		Record kept;
		kept.failure = shearPacked<Dim>(of.packed<Dim>(), path, options, [&](double shearStress, double normalStress) {
			kept.shearStress.push_back(shearStress);
			kept.normalStress.push_back(normalStress);
		});
		return kept;
	}

	py::object arrayOf(const std::vector<double>& values)
	{
		return tableOf(values.size(), 1, [&](std::size_t k, std::size_t) { return values[k]; });
	}

	py::list shearTests(const py::list& runs, int threads)
	{
		std::vector<boost::shared_ptr<yade::RveSample>> sheared;
		std::vector<ShearPath>                          paths;
		for (int k = 0; k < py::len(runs); ++k) {
			const auto run = runs[k];
			sheared.push_back(py::extract<boost::shared_ptr<yade::RveSample>>(run[0])());
			ShearPath path;
			path.perCall  = py::extract<double>(run[1])();
			path.pressure = py::extract<double>(run[2])();
			path.calls    = py::extract<long>(run[3])();
			path.along    = py::extract<int>(run[4])();
			path.across   = py::extract<int>(run[5])();
			paths.push_back(path);
			sheared.back()->dimension(); // an empty one is refused here
		}
		std::vector<Record> records(sheared.size());
		Py_BEGIN_ALLOW_THREADS;
		ThreadPool::run(
		        int(sheared.size()), std::max(1, std::min(threads > 0 ? threads : ThreadPool::threads(), int(sheared.size()))), [&](int k, int) {
			        const auto& sample      = *sheared[std::size_t(k)];
			        records[std::size_t(k)] = sample.dimension() == 2 ? record<2>(sample, paths[std::size_t(k)])
			                                                          : record<3>(sample, paths[std::size_t(k)]);
		        });
		Py_END_ALLOW_THREADS;
		py::list results;
		for (const auto& kept : records)
			results.append(py::make_tuple(arrayOf(kept.shearStress), arrayOf(kept.normalStress), kept.failure));
		return results;
	}

} // namespace

void exposeShearTests()
{
	py::def("shearTests", shearTests, (py::arg("runs"), py::arg("threads") = 0),
	        "Simple shear of RveSamples without ice. Each run is (sample, shear per call, its sign the direction; constant normal stress [Pa], "
	        "compression positive; number of calls; axis along and axis across). The samples stay as they are. List of (shear stress, normal stress, why "
	        "it blew up) [Pa] by call, tension positive.");
}

} // namespace talik
