// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/PointWatch.hpp>

#include <boost/python/numpy.hpp>
#include <cmath>
#include <numeric>

namespace py = boost::python;
namespace np = boost::python::numpy;

namespace yade {
YADE_PLUGIN((PointWatch));

namespace {
	/// `count` rows of `width` numbers, `stride` apart, as an array (count,) or (count, width).
	np::ndarray columns(const Real* first, std::size_t count, int width, std::size_t stride)
	{
		np::ndarray array = np::empty(width == 1 ? py::make_tuple(count) : py::make_tuple(count, width), np::dtype::get_builtin<double>());
		Real*       data  = reinterpret_cast<Real*>(array.get_data());
		for (std::size_t i = 0; i < count; i++)
			std::copy(first + i * stride, first + i * stride + width, data + i * width);
		return array;
	}
} // namespace

void PointWatch::record(Real time, const Look& look)
{
	const bool first = times.empty();
	if (first) next = time;
	for (const int id : ids)
		for (std::size_t f = 0; f < fields.size(); f++) {
			auto numbers = look(fields[f], id);
			if (first && id == ids.front()) components.push_back(int(numbers.size()));
			numbers.resize(std::size_t(components[f]), NaN); // a point that has lost its sample has one NaN in place of a tensor
			rows.insert(rows.end(), numbers.begin(), numbers.end());
		}
	times.push_back(time);
	// whole intervals after the first record, also where a step is longer than one
	if (interval > 0) next += interval * std::max(1., std::floor((time - next) / interval + 1));
}

py::dict PointWatch::history(int id) const
{
	const auto place = std::find(ids.begin(), ids.end(), id) - ids.begin();
	if (place == long(ids.size()))
		throw std::invalid_argument("MpmEngine.history: point " + std::to_string(id) + " is not watched; call watch() with its id.");
	const std::size_t width = std::accumulate(components.begin(), components.end(), std::size_t(0)), stride = width * ids.size();
	py::dict          result;
	result["time"]  = columns(times.data(), times.size(), 1, 1);
	const Real* row = rows.data() + std::size_t(place) * width;
	for (std::size_t f = 0; f < components.size(); f++) {
		result[fields[f]] = columns(row, times.size(), components[f], stride);
		row += components[f];
	}
	return result;
}

} // namespace yade
