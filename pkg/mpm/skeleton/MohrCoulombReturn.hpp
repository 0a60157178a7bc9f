// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cmath>

namespace talik {

/// Strength and stiffness of a point at its present ice saturation.
struct MohrCoulombState {
	double lambda, shear; ///< elastic [Pa]
	double cohesion;      ///< [Pa]
	double sinFriction, cosFriction, sinDilation;
	double tensileStrength; ///< [Pa], <= c cot(phi)
};

/// Returns principal stresses s[0] >= s[1] >= s[2] (tension positive, [Pa]) from a trial state to the yield surface
///   (s0 - s2) + (s0 + s2) sin(phi) <= 2 c cos(phi),  s0 <= tensileStrength,  eq. (23.1).
/// Main plane, edges and apex follow the flow rule with the dilation angle; tension above the cut-off is then taken off the
/// principal stresses that exceed it, which leaves the state inside the cone. Returns true if the state was changed.
inline bool returnToMohrCoulomb(const MohrCoulombState& m, double* s)
{
	const double limit = 2.0 * m.cohesion * m.cosFriction;
	const double sp = m.sinFriction, sd = m.sinDilation;
	const auto   yield = [&](double high, double low) { return (high - low) + (high + low) * sp - limit; };

	bool changed = false;
	if (yield(s[0], s[2]) > 0.0) {
		changed               = true;
		const double trial[3] = { s[0], s[1], s[2] };
		// C r of flow on the plane of directions (i high, j low): lambda tr r + 2 G r, tr r = 2 sin(psi)
		const double spherical = 2.0 * m.lambda * sd, up = 2.0 * m.shear * (1.0 + sd), down = -2.0 * m.shear * (1.0 - sd);
		const double high = spherical + up, low = spherical + down, rest = spherical;
		// n . C r for the same plane, and for planes that share the high or the low direction
		const double same      = (1.0 + sp) * high - (1.0 - sp) * low;
		const double shareHigh = (1.0 + sp) * high - (1.0 - sp) * rest;
		const double shareLow  = (1.0 + sp) * rest - (1.0 - sp) * low;

		const double f02   = yield(trial[0], trial[2]);
		const double gamma = f02 / same;
		s[0]               = trial[0] - gamma * high;
		s[1]               = trial[1] - gamma * rest;
		s[2]               = trial[2] - gamma * low;

		if (s[1] > s[0]) { // edge s0 = s1: planes (0,2) and (1,2)
			const double f12 = yield(trial[1], trial[2]);
			const double det = same * same - shareLow * shareLow;
			const double g02 = (same * f02 - shareLow * f12) / det, g12 = (same * f12 - shareLow * f02) / det;
			s[0] = trial[0] - g02 * high - g12 * rest;
			s[1] = trial[1] - g02 * rest - g12 * high;
			s[2] = trial[2] - (g02 + g12) * low;
		} else if (s[2] > s[1]) { // edge s1 = s2: planes (0,2) and (0,1)
			const double f01 = yield(trial[0], trial[1]);
			const double det = same * same - shareHigh * shareHigh;
			const double g02 = (same * f02 - shareHigh * f01) / det, g01 = (same * f01 - shareHigh * f02) / det;
			s[0] = trial[0] - (g02 + g01) * high;
			s[1] = trial[1] - g02 * rest - g01 * low;
			s[2] = trial[2] - g02 * low - g01 * rest;
		}
		if (sp > 0.0) {
			const double apex = m.cohesion * m.cosFriction / sp;
			const double mean = (s[0] + s[1] + s[2]) / 3.0;
			if (mean > apex) s[0] = s[1] = s[2] = apex;
		}
	}
	for (int i = 0; i < 3; ++i)
		if (s[i] > m.tensileStrength) {
			s[i]    = m.tensileStrength;
			changed = true;
		}
	return changed;
}

} // namespace talik
