// SPDX-License-Identifier: GPL-2.0-or-later
#include "MinimalMpm.hpp"

#include <pkg/mpm/skeleton/MohrCoulombReturn.hpp>

#include <cmath>

namespace minimal {

Block::Block(const Scene& s, double left, double width, double height, int perDirection, double density)
        : scene(s)
        , nodeCount((s.columns + 3) * (s.rows + 3))
        , stride(s.rows + 3)
{
	const double side = s.spacing / perDirection;
	const long   nx = std::lround(width / side), ny = std::lround(height / side);
	count = int(nx * ny);
	// arrays of equal size must not begin at the same place of a page: they would fight for the same lines of the cache
	constexpr long stagger = 24;
	memory.assign(10 * (count + stagger + 8) + nodeCount * 10L + 64, 0.0);
	double* next = memory.data();
	for (double** array : { &x, &y, &vx, &vy, &mass, &volume, &xx, &yy, &zz, &xy }) {
		*array = next;
		next += count + stagger;
	}
	nodes            = next;
	solved           = nodes + nodeCount * 6L;
	const int inCell = perDirection * perDirection;
	for (long p = 0; p < count; ++p) {
		const long cell = p / inCell, inside = p % inCell, cellsUp = ny / perDirection;
		const long i = cell / cellsUp * perDirection + inside / perDirection, j = cell % cellsUp * perDirection + inside % perDirection;
		x[p]      = left + (i + 0.5) * side;
		y[p]      = (j + 0.5) * side;
		volume[p] = side * side;
		mass[p]   = density * side * side;
	}
}

const Kernel& fastest()
{
#if defined(__x86_64__)
	if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) return avx512;
	if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return avx2;
#endif
	return plain;
}

void returnStress(const Scene& scene, double (&s)[4])
{
	const talik::MohrCoulombState m { scene.lambda, scene.shear, scene.cohesion, scene.sinFriction, scene.cosFriction, 0.0, 0.0 };
	const double                  centre = 0.5 * (s[0] + s[1]), half = 0.5 * (s[0] - s[1]), radius = std::sqrt(half * half + s[3] * s[3]);
	double                        principal[3] = { centre + radius, centre - radius, s[2] };
	int                           order[3]     = { 0, 1, 2 };
	for (int a : { 0, 1, 0 })
		if (principal[order[a]] < principal[order[a + 1]]) std::swap(order[a], order[a + 1]);
	double sorted[3] = { principal[order[0]], principal[order[1]], principal[order[2]] };
	talik::returnToMohrCoulomb(m, sorted);
	for (int a = 0; a < 3; ++a)
		principal[order[a]] = sorted[a];
	const double cosine = radius > 0.0 ? half / radius : 1.0, sine = radius > 0.0 ? s[3] / radius : 0.0;
	const double newCentre = 0.5 * (principal[0] + principal[1]), newRadius = 0.5 * (principal[0] - principal[1]);
	s[0] = newCentre + newRadius * cosine;
	s[1] = newCentre - newRadius * cosine;
	s[2] = principal[2];
	s[3] = newRadius * sine;
}

} // namespace minimal
