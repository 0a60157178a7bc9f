// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/ShapeFunctions.hpp>

#include <stdexcept>

namespace talik {

namespace {
	template <int D> struct Entry {
		const char* name;
		std::unique_ptr<ShapeFunction<D>> (*make)();
	};

	template <int D> const std::vector<Entry<D>>& table()
	{
		static const std::vector<Entry<D>> entries {
			{ "quadraticBSpline", &makeQuadraticBSpline<D> },
			{ "gimp", &makeGimp<D> },
			{ "linear", &makeLinear<D> },
		};
		return entries;
	}
} // namespace

std::vector<std::string> shapeFunctionNames()
{
	std::vector<std::string> names;
	for (const auto& entry : table<2>())
		names.emplace_back(entry.name);
	return names;
}

template <int D> std::unique_ptr<ShapeFunction<D>> makeShapeFunction(const std::string& name)
{
	std::string known;
	for (const auto& entry : table<D>()) {
		if (name == entry.name) return entry.make();
		known += std::string(known.empty() ? "" : ", ") + entry.name;
	}
	throw std::invalid_argument("shapeFunction = '" + name + "': choose one of " + known);
}

template std::unique_ptr<ShapeFunction<2>> makeShapeFunction<2>(const std::string&);
template std::unique_ptr<ShapeFunction<3>> makeShapeFunction<3>(const std::string&);

} // namespace talik
