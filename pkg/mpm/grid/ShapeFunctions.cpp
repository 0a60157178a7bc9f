// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/grid/ShapeFunctions.hpp>

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

template <int D>
void ShapeFunction<D>::evaluate(const Grid<D>& grid, const std::array<const double*, D>& position, int first, int count, WeightBlock<D>& w) const
{
	w.first = first;
	w.count = count;
	for (int k = 0; k < count; ++k)
		w.base[k] = 0;
	for (int n = 0; n < supportCount<D>; ++n) {
		w.offset[n] = 0;
		for (int a = 0, rest = n; a < D; ++a, rest /= supportNodes)
			w.offset[n] += rest % supportNodes * grid.nodeStride(a);
	}
	for (int a = 0; a < D; ++a)
		along(grid, a, position[a] + first, count, w);
}

template <int D> void ShapeFunction<D>::moveToFace(const Grid<D>& grid, const Vec<D>& toFace, int k, WeightBlock<D>& w) const
{
	const double width = 2.0 * lengthOf<D>(toFace) * grid.inverseSpacing();
	for (int a = 0; a < D; ++a) {
		double slope[supportNodes];
		for (int i = 0; i < supportNodes; ++i)
			slope[i] = w.slope[a][i][k] * grid.spacing();
		const double cells = toFace[a] * grid.inverseSpacing(), part = 2.0 * cells / width;
		const double curvature = width > 0.0 ? part * part * faceCurvature(slope, width) : 0.0;
		for (int i = 0; i < supportNodes; ++i)
			w.value[a][i][k] += cells * slope[i] + (i == 1 ? -2.0 : 1.0) * curvature;
	}
}

template class ShapeFunction<2>;
template class ShapeFunction<3>;

template std::unique_ptr<ShapeFunction<2>> makeShapeFunction<2>(const std::string&);
template std::unique_ptr<ShapeFunction<3>> makeShapeFunction<3>(const std::string&);

} // namespace talik
