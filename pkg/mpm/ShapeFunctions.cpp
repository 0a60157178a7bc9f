// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/PlaneLoops.hpp>
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

template <> void multiplyFactors<2>(const Grid<2>& grid, WeightBlock<2>& w)
{
	int n = 0;
	for (int b = 0; b < supportNodes; ++b)
		for (int a = 0; a < supportNodes; ++a, ++n)
			w.offset[n] = a * grid.nodeStride(0) + b * grid.nodeStride(1);
	planeLoops().multiply(w);
}

template <> void multiplyFactors<3>(const Grid<3>& grid, WeightBlock<3>& w)
{
	int n = 0;
	for (int c = 0; c < supportNodes; ++c)
		for (int b = 0; b < supportNodes; ++b)
			for (int a = 0; a < supportNodes; ++a, ++n) {
				w.offset[n] = a * grid.nodeStride(0) + b * grid.nodeStride(1) + c * grid.nodeStride(2);
				for (int k = 0; k < w.count; ++k) {
					const double nx = w.value[0][a][k], ny = w.value[1][b][k], nz = w.value[2][c][k];
					w.weight[n][k]      = nx * ny * nz;
					w.gradient[0][n][k] = w.slope[0][a][k] * ny * nz;
					w.gradient[1][n][k] = nx * w.slope[1][b][k] * nz;
					w.gradient[2][n][k] = nx * ny * w.slope[2][c][k];
				}
			}
}

template std::unique_ptr<ShapeFunction<2>> makeShapeFunction<2>(const std::string&);
template std::unique_ptr<ShapeFunction<3>> makeShapeFunction<3>(const std::string&);

} // namespace talik
