// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <core/Scene.hpp>
#include <cstring>
#include <limits>
#include <numeric>
#include <pkg/base/SavedBytes.hpp>
#include <pkg/multiscale/engine/PointTable.hpp>
#include <pkg/python/PythonFunction.hpp>
#include <pkg/python/ScriptValues.hpp>

namespace py = boost::python;
namespace np = boost::python::numpy;

namespace talik {
namespace {
	constexpr double none = std::numeric_limits<double>::quiet_NaN();

	/// What follows the position, in its order.
	constexpr const char* optionalColumns[] = { "volume", "porosity", "temperature", "pressure", "skeleton", "stress", "velocity", "poreFill" };

	/// What is the same for all points is held once.
	void holdOnce(std::vector<double>& column, std::size_t width)
	{
		const std::size_t bytes = width * sizeof(double);
		for (std::size_t at = width; at < column.size(); at += width)
			if (std::memcmp(column.data(), column.data() + at, bytes) != 0) return;
		column.resize(width);
		column.shrink_to_fit();
	}

} // namespace

void PointTable::add(int points, int dimension, const py::object& arrays)
{
	if (points == 0) return;
	dimension_ = dimension;
	std::vector<Numbers> columns;
	for (int c = 0; c < py::len(arrays); ++c) {
		const np::ndarray array = py::extract<np::ndarray>(arrays[c]);
		const auto*       data  = reinterpret_cast<const double*>(array.get_data());
		columns.emplace_back(data, data + long(py::extract<long>(array.attr("size"))));
		holdOnce(columns.back(), width(std::size_t(c)));
	}
	const Numbers materials = std::move(columns.back());
	columns.pop_back();
	if (!materials_.empty() || materials != Numbers { 0. }) {
		materials_.resize(count(), 0);
		for (int p = 0; p < points; ++p)
			materials_.push_back(int(materials[materials.size() == 1 ? 0 : p]));
	}
	columns_.resize(columns.size());
	for (std::size_t c = 0; c < columns.size(); ++c)
		append(c, columns[c], points);
	count_ += points;
}

std::size_t PointTable::width(std::size_t column) const
{
	constexpr std::size_t stress[] = { stressSize<2>, stressSize<3> };
	switch (column) {
		case 0:
		case 7: return std::size_t(dimension_); // position, velocity
		case 6: return stress[dimension_ - 2];
		default: return 1;
	}
}

/// A row for each point.
void PointTable::expand(std::size_t column)
{
	Numbers&          numbers = columns_[column];
	const std::size_t size = width(column), points = std::size_t(column == ofSkeleton ? count() : count_);
	if (numbers.size() != size) return;
	numbers.reserve(size * points);
	for (std::size_t k = size; k < size * points; ++k)
		numbers.push_back(numbers[k - size]);
}

void PointTable::append(std::size_t column, const Numbers& more, int points)
{
	Numbers&          numbers = columns_[column];
	const std::size_t size    = width(column);
	if (count_ == 0) {
		numbers = more;
		return;
	}
	const bool once = numbers.size() == size && more.size() == size;
	if (once && std::memcmp(numbers.data(), more.data(), size * sizeof(double)) == 0) return;
	expand(column);
	for (std::size_t k = 0; k < size * std::size_t(points); ++k)
		numbers.push_back(more[more.size() == size ? k % size : k]);
}

void PointTable::setSkeleton(int id, int number)
{
	if (skeleton(id) == number) return;
	expand(ofSkeleton);
	columns_[ofSkeleton][std::size_t(id)] = number;
}

void PointTable::follow(const std::vector<int>& divisions)
{
	Numbers& skeletons = columns_[ofSkeleton];
	for (std::size_t k = divisions_.size(); k < divisions.size(); ++k) {
		if (skeletons.size() > 1) skeletons.push_back(skeletons[std::size_t(divisions[k])]);
		divisions_.push_back(divisions[k]);
	}
}

template <int D> PointInput<D> PointTable::point(int id) const
{
	std::size_t column = 0;
	const auto  next   = [&] { return number(column++, id); };
	const auto  fill   = [&](auto& components) {
                for (std::size_t c = 0; c < components.size(); ++c)
                        components[c] = number(column, id, int(c));
                ++column;
	};
	PointInput<D> p;
	fill(p.position);
	p.volume      = next();
	p.porosity    = next();
	p.temperature = next();
	p.pressure    = next();
	p.skeleton    = int(next());
	fill(p.stress);
	fill(p.velocity);
	p.poreFill = next();
	p.material = material(id);
	return p;
}

template PointInput<2> PointTable::point<2>(int) const;
template PointInput<3> PointTable::point<3>(int) const;

py::dict PointTable::arrays() const
{
	py::dict   all;
	const auto put = [&](const char* name, std::size_t width, auto numberAt) {
		all[name] = tableOf(count_, width, [&](std::size_t id, std::size_t c) { return numberAt(int(id), int(c)); });
	};
	std::size_t column = 0;
	put("position", std::size_t(dimension_), [&](int id, int c) { return position(id, c); });
	for (const char* name : optionalColumns) {
		++column;
		put(name, width(column), [&](int id, int c) { return number(column, id, c); });
	}
	put("material", 1, [&](int id, int) { return double(material(id)); });
	return all;
}

std::uint64_t PointTable::digest() const
{
	Checksum checksum;
	for (int id = 0; id < count_; ++id) // of the script
		for (std::size_t column = 0; column < columns_.size(); ++column)
			for (std::size_t c = 0; c < width(column); ++c) {
				const double value = number(column, id, int(c)), plain = std::isnan(value) ? none : value;
				checksum.process_bytes(&plain, sizeof plain);
			}
	if (!materials_.empty()) checksum.process_bytes(materials_.data(), materials_.size() * sizeof(int));
	return checksum.checksum();
}

} // namespace talik

namespace yade {
YADE_PLUGIN((PointWatch));

void PointWatch::record(Real time, const Look& look)
{
	const bool first = times.empty();
	if (first) next = time;
	for (const int id : ids)
		for (std::size_t f = 0; f < fields.size(); ++f) {
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
	result["time"]  = talik::tableOf(times.size(), 1, [&](std::size_t t, std::size_t) { return times[t]; });
	const Real* row = rows.data() + std::size_t(place) * width;
	for (std::size_t f = 0; f < components.size(); ++f) {
		result[fields[f]] = talik::tableOf(times.size(), components[f], [&](std::size_t t, std::size_t c) { return row[t * stride + c]; });
		row += components[f];
	}
	return result;
}

} // namespace yade
