// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/kernels/PlaneLoops.inc>

namespace talik {

#if defined(__x86_64__)
extern const PlaneLoops planeLoopsAvx2;
extern const PlaneLoops planeLoopsAvx512;
#endif

namespace {
	constexpr PlaneLoops plain = loopsNamed("plain");
}

int planeLoopVersions(const PlaneLoops* (&versions)[3])
{
	int count         = 0;
	versions[count++] = &plain;
#if defined(__x86_64__)
	__builtin_cpu_init();
	if (__builtin_cpu_supports("avx2")) versions[count++] = &planeLoopsAvx2;
	if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
		versions[count++] = &planeLoopsAvx512;
#endif
	return count;
}

const PlaneLoops& planeLoops()
{
	static const PlaneLoops& best = []() -> const PlaneLoops& {
		const PlaneLoops* versions[3];
		return *versions[planeLoopVersions(versions) - 1];
	}();
	return best;
}

} // namespace talik
