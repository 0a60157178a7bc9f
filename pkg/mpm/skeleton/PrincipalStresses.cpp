// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/mpm/skeleton/PrincipalStresses.hpp>

namespace talik {

namespace {
	struct Vector {
		double x, y, z;
	};
	inline Vector operator*(double a, const Vector& v) { return { a * v.x, a * v.y, a * v.z }; }
	inline Vector operator+(const Vector& a, const Vector& b) { return { a.x + b.x, a.y + b.y, a.z + b.z }; }
	inline double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
	inline Vector cross(const Vector& a, const Vector& b) { return { a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x }; }
	inline Vector either(bool first, const Vector& a, const Vector& b) { return { first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z }; }
	inline double square(double a) { return a * a; }
} // namespace

// The principal value that lies farthest from the other two is found first, as the outer root of the characteristic polynomial: it is
// well conditioned, and so is its axis. What is left is plane (Scherzinger & Dohrmann 2008). Loops are vectors: no branches.
TALIK_PROCESSOR_VERSIONS void Spectra::find()
{
	const double root3 = std::sqrt(3.0);
#pragma GCC ivdep
	for (int i = 0; i < count; ++i) {
		const double mean = (stress[0][i] + stress[1][i] + stress[2][i]) * (1.0 / 3.0);
		const double dx = stress[0][i] - mean, dy = stress[1][i] - mean, dz = stress[2][i] - mean;
		const double j2      = 0.5 * (dx * dx + dy * dy + dz * dz) + square(stress[3][i]) + square(stress[4][i]) + square(stress[5][i]);
		const double radius  = __builtin_sqrt(j2 * (1.0 / 3.0));
		const double perUnit = radius > 0.0 ? 1.0 / radius : 0.0;
		// deviator of second invariant 3: x^3 - 3 x - determinant = 0
		const double xx = dx * perUnit, yy = dy * perUnit, zz = dz * perUnit;
		const double yz = stress[3][i] * perUnit, xz = stress[4][i] * perUnit, xy = stress[5][i] * perUnit;
		const double determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
		const double size        = std::min(2.0, std::abs(determinant));
		double       x           = root3 + (2.0 - root3) * 0.5 * size;
		for (int step = 0; step < 4; ++step) // Newton, from 1 % off
			x -= (x * (x * x - 3.0) - size) / (3.0 * (x * x - 1.0));
		const bool   above = determinant >= 0.0;
		const double outer = above ? x : -x;

		const Vector rowX { xx - outer, xy, xz }, rowY { xy, yy - outer, yz }, rowZ { xz, yz, zz - outer };
		const Vector a = cross(rowY, rowZ), b = cross(rowZ, rowX), c = cross(rowX, rowY);
		const Vector ab      = either(dot(a, a) >= dot(b, b), a, b);
		const Vector longest = either(dot(ab, ab) >= dot(c, c), ab, c);
		const double length  = __builtin_sqrt(dot(longest, longest));
		const Vector n       = either(length > 0.0, (1.0 / (length > 0.0 ? length : 1.0)) * longest, { 0.0, 0.0, 1.0 });

		// two axes across n (Duff et al. 2017) and the deviator there
		const double sign = n.z >= 0.0 ? 1.0 : -1.0, f = -1.0 / (sign + n.z), g = n.x * n.y * f;
		const Vector u { 1.0 + sign * n.x * n.x * f, sign * g, -sign * n.x }, v { g, sign + n.y * n.y * f, -n.y };
		const auto   times = [&](const Vector& w) {
                        return Vector { xx * w.x + xy * w.y + xz * w.z, xy * w.x + yy * w.y + yz * w.z, xz * w.x + yz * w.y + zz * w.z };
		};
		const Vector su = times(u), sv = times(v);
		const double uu = dot(u, su), uv = dot(u, sv), vv = dot(v, sv), half = 0.5 * (uu - vv), centre = 0.5 * (uu + vv);
		const double spread = __builtin_sqrt(half * half + uv * uv), perSpread = spread > 0.0 ? 1.0 / spread : 0.0;
		const double cosine2 = spread > 0.0 ? std::abs(half) * perSpread : 1.0, sine2 = uv * perSpread;
		const double larger = __builtin_sqrt(0.5 * (1.0 + cosine2)), smaller = 0.5 * sine2 / larger;
		const bool   near   = half >= 0.0;
		const double cosine = near ? larger : std::abs(smaller), sine = near ? smaller : (sine2 >= 0.0 ? larger : -larger);
		const Vector major = cosine * u + sine * v, minor = -sine * u + cosine * v;

		const double own     = dot(n, times(n));
		value[0][i]          = mean + radius * (above ? own : centre + spread);
		value[1][i]          = mean + radius * (above ? centre + spread : centre - spread);
		value[2][i]          = mean + radius * (above ? centre - spread : own);
		const Vector axes[3] = { either(above, n, major), either(above, major, minor), either(above, minor, n) };
#pragma GCC unroll 3
		for (int k = 0; k < 3; ++k) {
			axis[k][0][i] = axes[k].x;
			axis[k][1][i] = axes[k].y;
			axis[k][2][i] = axes[k].z;
		}
	}
}

} // namespace talik
