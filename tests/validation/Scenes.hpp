// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// Scenes that several validation tests share: boxes of points, columns, marching to given instants, reading fields.

#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/MohrCoulombSkeleton.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace talik::validation {

/// Mixture of the paper without thermal expansion, as the closed forms assume.
inline MixtureProperties withoutExpansion()
{
	MixtureProperties m;
	m.solid.expansivity = m.ice.expansivity = m.liquid.expansivity = 0.0;
	return m;
}

template <int D> using PointPreparation = std::function<void(PointInput<D>&)>;

/// Fills the box [lower, upper] with perDirection^2 points per grid cell, beginning at lower; prepare sets state by position.
inline void fillBox(Ground<2>& ground, const Vec<2>& lower, const Vec<2>& upper, const PointPreparation<2>& prepare = {}, int perDirection = 2)
{
	const double s  = ground.settings().gridSpacing / perDirection;
	const int    nx = int(std::lround((upper[0] - lower[0]) / s));
	const int    ny = int(std::lround((upper[1] - lower[1]) / s));
	for (int j = 0; j < ny; ++j)
		for (int i = 0; i < nx; ++i) {
			PointInput<2> point;
			point.position = { lower[0] + (i + 0.5) * s, lower[1] + (j + 0.5) * s };
			point.volume   = s * s;
			if (prepare) prepare(point);
			ground.addPoint(point);
		}
}

/// Settings of a vertical strip one cell wide: grid from the base at 0 to gridHeight.
inline GroundSettings<2> columnSettings(double spacing, double gridHeight)
{
	GroundSettings<2> s;
	s.lower       = { 0.0, 0.0 };
	s.upper       = { spacing, gridHeight };
	s.gridSpacing = spacing;
	s.mixture     = withoutExpansion();
	return s;
}

template <class B, class... Arguments> void addBoundary(GroundSettings<2>& s, Arguments&&... arguments)
{
	s.boundaries.push_back(std::make_shared<B>(std::forward<Arguments>(arguments)...));
}

/// Rollers left, right and at the bottom.
inline void standOnRollers(GroundSettings<2>& s)
{
	for (const char* side : { "left", "right", "bottom" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
}

/// Elastic skeleton whose oedometer modulus equals Young's modulus (nu = 0).
inline std::shared_ptr<ElasticSkeleton<2>> elasticOedometer(double modulus)
{
	auto skeleton     = std::make_shared<ElasticSkeleton<2>>();
	skeleton->young   = modulus;
	skeleton->poisson = 0.0;
	return skeleton;
}

/// Steps to the instant with equal steps no longer than the stable one (times fraction); calls each after every step.
template <int D> long marchTo(Ground<D>& ground, double instant, double longest = 1e300, const std::function<void()>& each = {})
{
	const double span = instant - ground.time();
	if (span <= 0.0) return 0;
	const double stable = std::min(longest, ground.stableTimeStep().step);
	const long   count  = long(std::ceil(span / stable * (1.0 - 1e-12)));
	for (long k = 0; k < count; ++k) {
		ground.step(span / count);
		if (each) each();
	}
	return count;
}

/// A point field in the order of ids.
template <int D> std::vector<double> valuesOf(const Ground<D>& ground, const std::string& field, int component = 0)
{
	std::vector<double> values(ground.points().count());
	ground.copyById(field, component, values.data());
	return values;
}

/// Pore pressure of the cells of a column from the base up [Pa].
inline std::vector<double> cellPressures(const Ground<2>& ground, int cells)
{
	const auto          p = valuesOf(ground, "pressure"), y = valuesOf(ground, "position", 1);
	std::vector<double> values(cells, 0.0);
	for (std::size_t k = 0; k < p.size(); ++k)
		values[std::min(cells - 1, int(y[k] / ground.settings().gridSpacing))] = p[k];
	return values;
}

template <int D> double sumOf(const Ground<D>& ground, const std::string& field, int component = 0)
{
	double sum = 0.0;
	for (const double value : valuesOf(ground, field, component))
		sum += value;
	return sum;
}

template <int D> bool hasField(const Ground<D>& ground, const std::string& field)
{
	for (const FieldInfo& info : ground.fields())
		if (info.name == field && info.place == "points") return true;
	return false;
}

inline double largestSize(const std::vector<double>& values)
{
	double largest = 0.0;
	for (const double value : values)
		largest = std::isfinite(value) ? std::max(largest, std::abs(value)) : INFINITY;
	return largest;
}

} // namespace talik::validation
