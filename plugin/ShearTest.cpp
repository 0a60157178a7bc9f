// SPDX-License-Identifier: GPL-2.0-or-later
#include "ShearTest.hpp"

#include <boost/python/numpy.hpp>
#include <pkg/base/ThreadPool.hpp>
#include <pkg/multiscale/samples/RveSample.hpp>
#include <pkg/python/ScriptValues.hpp>
#include <pkg/rve/SimpleShear.hpp>

namespace py = boost::python;
namespace np = boost::python::numpy;

namespace talik {
namespace {

	struct Record {
		std::vector<double> shearStress, normalStress;
		std::string         failure;
	};

	template <int Dim> Record record(const yade::RveSample& of, ShearPath path)
	{
		PackedUpdateOptions options;
		TALIK_TAKE_ATTRIBUTES(options, of, (maxInertialNumber)(maxStrainPerStep)(minSteps)(timeStepFollowsIce))
		path.across = Dim - 1;
		Record kept;
		kept.failure = shearPacked<Dim>(of.packed<Dim>(), path, options, [&](double shearStress, double normalStress) {
			kept.shearStress.push_back(shearStress);
			kept.normalStress.push_back(normalStress);
		});
		return kept;
	}

	np::ndarray arrayOf(const std::vector<double>& values)
	{
		np::ndarray array = np::zeros(py::make_tuple(values.size()), np::dtype::get_builtin<double>());
		std::copy(values.begin(), values.end(), reinterpret_cast<double*>(array.get_data()));
		return array;
	}

	py::list shearTests(const py::list& samples, const py::list& perCall, double pressure, long calls)
	{
		std::vector<boost::shared_ptr<yade::RveSample>> sheared;
		std::vector<ShearPath>                          paths;
		for (int k = 0; k < py::len(samples); ++k) {
			sheared.push_back(py::extract<boost::shared_ptr<yade::RveSample>>(samples[k])());
			ShearPath path;
			path.perCall  = py::extract<double>(perCall[k])();
			path.pressure = pressure;
			path.calls    = calls;
			paths.push_back(path);
			sheared.back()->dimension(); // an empty one is refused here
		}
		std::vector<Record> records(sheared.size());
		Py_BEGIN_ALLOW_THREADS;
		ThreadPool::run(int(sheared.size()), std::max(1, std::min(ThreadPool::threads(), int(sheared.size()))), [&](int k, int) {
			const auto& sample      = *sheared[std::size_t(k)];
			records[std::size_t(k)] = sample.dimension() == 2 ? record<2>(sample, paths[std::size_t(k)]) : record<3>(sample, paths[std::size_t(k)]);
		});
		Py_END_ALLOW_THREADS;
		py::list results;
		for (const auto& kept : records) {
			if (!kept.failure.empty()) throw std::runtime_error("simple shear at " + asText(pressure) + " Pa: a sample blew up: " + kept.failure);
			results.append(py::make_tuple(arrayOf(kept.shearStress), arrayOf(kept.normalStress)));
		}
		return results;
	}

} // namespace

void exposeShearTests()
{
	py::def("shearTests", shearTests, (py::arg("samples"), py::arg("perCall"), py::arg("pressure"), py::arg("calls")),
	        "Simple shear of RveSamples without ice, each with a shear per call of its own (its sign the direction), at a constant normal stress "
	        "*pressure* "
	        "[Pa]: xy of discs, xz of spheres. The samples stay as they are. List of (shear stress, normal stress) [Pa] by call, tension positive.");
}

} // namespace talik
