// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <array>
#include <pkg/mpm/points/PointFields.hpp>
#include <pkg/rve/packed/PackedState.hpp>
#include <string>

namespace talik {

/// Independent components of a symmetric tensor, in the order of components().
template <int Dim> constexpr int                symmetricSize = Dim*(Dim + 1) / 2;
template <int Dim> constexpr std::array<int, 2> symmetricPair(int n)
{
	constexpr int plane[3][2] = { { 0, 0 }, { 1, 1 }, { 0, 1 } }, space[6][2] = { { 0, 0 }, { 1, 1 }, { 2, 2 }, { 1, 2 }, { 0, 2 }, { 0, 1 } };
	return Dim == 2 ? std::array<int, 2> { plane[n % 3][0], plane[n % 3][1] } : std::array<int, 2> { space[n][0], space[n][1] };
}
template <int Dim> constexpr int tangentSize = symmetricSize<Dim>* symmetricSize<Dim>;
/// Rows: components of stress; columns: those of the tensor strain.
template <int Dim> using CompactTangent = std::array<double, tangentSize<Dim>>;

template <int Dim> CompactTangent<Dim> compact(const PackedTangent<Dim>& c)
{
	const auto          at  = [&](int i, int j, int k, int l) { return c[((i * Dim + j) * Dim + k) * Dim + l]; };
	const auto          row = [&](int i, int j, int k, int l) { return i == j ? at(i, j, k, l) : 0.5 * (at(i, j, k, l) + at(j, i, k, l)); };
	CompactTangent<Dim> result;
	for (int n = 0; n < tangentSize<Dim>; ++n) {
		const auto [i, j] = symmetricPair<Dim>(n / symmetricSize<Dim>);
		const auto [k, l] = symmetricPair<Dim>(n % symmetricSize<Dim>);
		result[n]         = k == l ? row(i, j, k, l) : row(i, j, k, l) + row(i, j, l, k);
	}
	return result;
}

/// What the points remember of their samples, as arrays by place.
template <int Dim> struct SampleRecord {
	using Matrix     = typename PackedTypes<Dim>::Matrix;
	using Components = std::array<double*, Dim * Dim>;

	Components                            gradient {};          ///< displacement gradient since the last update of the sample [-]
	Components                            last {};              ///< stress that it answered then [Pa]
	std::array<double*, tangentSize<Dim>> tangent {};           ///< the same of the tangent [Pa]
	double*                               ratio      = nullptr; ///< change of stress over that of the tangent, in the interval before [-], 0 to 1
	double*                               saturation = nullptr; ///< ice saturation of the sample [-]
	double*                               tolerance  = nullptr; ///< strain after which it is updated [-]
	double*                               time       = nullptr; ///< of the calendar since then [s], where ice depends on it

	void declare(PointFields& f, const std::string& prefix, const std::string& owner, bool withTime)
	{
		f.declare(prefix + "accumulatedGradient", owner, "-", gradient);
		f.declare(prefix + "sampleStress", owner, "Pa", last);
		f.declare(prefix + "sampleIceSaturation", owner, "-", saturation);
		f.declare(prefix + "strainTolerance", owner, "-", tolerance);
		f.declare(prefix + "tangentRatio", owner, "-", ratio);
		f.declare(prefix + "tangent", owner, "Pa", tangent);
		if (withTime) f.declare(prefix + "timeSinceUpdate", owner, "s", time);
	}

	static Matrix matrixAt(const Components& components, int p)
	{
		Matrix m;
		for (int c = 0; c < Dim * Dim; ++c)
			m(c / Dim, c % Dim) = components[c][p];
		return m;
	}
	static void setMatrixAt(const Components& components, int p, const Matrix& m)
	{
		for (int c = 0; c < Dim * Dim; ++c)
			components[c][p] = m(c / Dim, c % Dim);
	}
	Matrix              accumulated(int p) const { return matrixAt(gradient, p); }
	void                setAccumulated(int p, const Matrix& h) const { setMatrixAt(gradient, p, h); }
	Matrix              lastStress(int p) const { return matrixAt(last, p); }
	void                setLastStress(int p, const Matrix& s) const { setMatrixAt(last, p, s); }
	CompactTangent<Dim> tangentAt(int p) const
	{
		CompactTangent<Dim> c;
		for (int i = 0; i < tangentSize<Dim>; ++i)
			c[i] = tangent[i][p];
		return c;
	}
	void setTangent(int p, const PackedTangent<Dim>& all) const
	{
		const auto c = compact<Dim>(all);
		for (int i = 0; i < tangentSize<Dim>; ++i)
			tangent[i][p] = c[i];
	}
};

} // namespace talik
