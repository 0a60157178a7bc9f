// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <Eigen/LU>
#include <pkg/multiscale/samples/SampleRecord.hpp>

namespace talik {

/// Change of stress of an elastic body with this tangent by a displacement gradient, symmetrised.
template <int Dim> typename PackedTypes<Dim>::Matrix elasticChange(const CompactTangent<Dim>& c, const typename PackedTypes<Dim>::Matrix& h)
{
	constexpr int size = symmetricSize<Dim>;
	double        strain[size];
	for (int n = 0; n < size; ++n) {
		const auto [i, j] = symmetricPair<Dim>(n);
		strain[n]         = i == j ? h(i, i) : 0.5 * (h(i, j) + h(j, i));
	}
	typename PackedTypes<Dim>::Matrix s;
	for (int n = 0; n < size; ++n) {
		const auto [i, j] = symmetricPair<Dim>(n);
		double sum        = c[n * size] * strain[0];
		for (int m = 1; m < size; ++m)
			sum += c[n * size + m] * strain[m];
		s(i, j) = s(j, i) = sum;
	}
	return s;
}

/// Rotation of the polar decomposition of 1 + H.
inline PackedTypes<2>::Matrix rotationOf(const PackedTypes<2>::Matrix& h)
{
	const double           sine = h(1, 0) - h(0, 1), cosine = 2 + h(0, 0) + h(1, 1), size = std::sqrt(sine * sine + cosine * cosine);
	PackedTypes<2>::Matrix r;
	r << cosine, -sine, sine, cosine;
	return size > 0 ? PackedTypes<2>::Matrix(r / size) : PackedTypes<2>::Matrix::Identity();
}

/// Newton's iteration: converges from every matrix with an inverse.
inline PackedTypes<3>::Matrix rotationOf(const PackedTypes<3>::Matrix& h)
{
	PackedTypes<3>::Matrix r = PackedTypes<3>::Matrix::Identity() + h;
	for (int k = 0; k < 30; ++k) {
		const PackedTypes<3>::Matrix next   = 0.5 * (r + r.inverse().transpose());
		const double                 change = (next - r).norm();
		r                                   = next;
		if (change < 1e-15) break;
	}
	return r;
}

/// Stress of a point between two updates of its sample: that of the last one, turned with the point, and a share of what its tangent gives.
template <int Dim> struct StressPrediction {
	using Matrix                         = typename PackedTypes<Dim>::Matrix;
	static constexpr double failingRatio = 0.3; ///< below it a point deforms plastically: the tangent predicts nothing

	const SampleRecord<Dim>& record;

	bool failing(int p) const { return record.ratio[p] < failingRatio; }
	/// Change of stress that the tangent predicts for the accumulated motion h, beside its rotation.
	Matrix change(int p, const Matrix& h) const
	{
		return failing(p) ? Matrix(Matrix::Zero()) : Matrix(record.ratio[p] * elasticChange<Dim>(record.tangentAt(p), h));
	}
	/// Stress that is predicted for the accumulated motion h, eq. (15.3); change: change(p, h).
	Matrix stress(int p, const Matrix& h, const Matrix& change) const
	{
		const Matrix r = rotationOf(h);
		return r * record.lastStress(p) * r.transpose() + change;
	}
	/// From the stress after the motion h and the tangent then: what the next prediction begins with. The record has still the stress before.
	void learn(int p, const Matrix& h, const Matrix& after, const PackedTangent<Dim>& tangent) const
	{
		const Matrix turn    = rotationOf(h);
		const double elastic = elasticChange<Dim>(record.tangentAt(p), h).norm(),
		             actual  = (after - turn * record.lastStress(p) * turn.transpose()).norm();
		record.ratio[p]      = elastic > 0 ? std::min(1., actual / elastic) : 1.;
		record.setTangent(p, tangent);
	}
};

} // namespace talik
