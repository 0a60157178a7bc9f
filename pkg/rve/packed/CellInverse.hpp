// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace talik {

/// Inverse of a periodic cell, both row by row. One source for the processor and for a device, so that neighbours have the same bits.
constexpr void invert(const double* h, double (&inverse)[4])
{
	const double det = h[0] * h[3] - h[1] * h[2];
	inverse[0]       = h[3] / det;
	inverse[1]       = -h[1] / det;
	inverse[2]       = -h[2] / det;
	inverse[3]       = h[0] / det;
}

constexpr void invert(const double* h, double (&inverse)[9])
{
	double det = 0;
	for (int k = 0; k < 3; ++k) {
		const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
		det += h[k] * (h[3 + k1] * h[6 + k2] - h[3 + k2] * h[6 + k1]);
		for (int l = 0; l < 3; ++l) {
			const int l1 = (l + 1) % 3, l2 = (l + 2) % 3;
			inverse[l * 3 + k] = h[k1 * 3 + l1] * h[k2 * 3 + l2] - h[k1 * 3 + l2] * h[k2 * 3 + l1];
		}
	}
	for (double& value : inverse)
		value /= det;
}

} // namespace talik
