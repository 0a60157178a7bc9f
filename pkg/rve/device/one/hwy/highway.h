// SPDX-License-Identifier: GPL-2.0-or-later
// In place of Highway where every thread deals with one number at a time: a graphics card, or its twin on a processor. With it
// pkg/icebond/ContactForces.hpp compiles as it is; it names no more of Highway than what stands here.
#pragma once
#ifndef TALIK_CARD
#define TALIK_CARD ///< functions of the card
#endif
#define HWY_NAMESPACE N_ONE
#define HWY_INLINE TALIK_CARD inline __attribute__((always_inline))
#define HWY_ATTR
#define HWY_UNLIKELY(condition) __builtin_expect(!!(condition), 0)
#define HWY_BEFORE_NAMESPACE()
#define HWY_AFTER_NAMESPACE()
#define HWY_STATIC_TARGET 2
#define HWY_TARGET 1 // another one: without what ContactForces.hpp has for shear forces of YADE's

namespace hwy {
namespace N_ONE {
	template <class V> using DFromV = V;
	template <class D> TALIK_CARD D             Zero(D);
	template <class D> TALIK_CARD D             Set(D, double);
	template <class D, class M> TALIK_CARD bool AllFalse(D, M);
} // namespace N_ONE
} // namespace hwy
