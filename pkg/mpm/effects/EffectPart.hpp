// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <memory>

namespace talik {

/// Takes the place of an effect in code that is built without it: it is false at compile time, so that the compiler removes all that asks for it.
template <class T> struct AbsentEffect {
	AbsentEffect& operator=(std::unique_ptr<T>) { return *this; }
	constexpr explicit operator bool() const { return false; }
	constexpr T* get() const { return nullptr; }
	constexpr T* operator->() const { return nullptr; }
	constexpr T& operator*() const { return *get(); }
};

/// An effect that a scene may have; empty if it has not. With TALIK_DRY_GROUND the ground is built with motion alone:
/// scripts/bench compares with it what effects cost that are switched off.
#ifdef TALIK_DRY_GROUND
template <class T> using EffectPart = AbsentEffect<T>;
#else
template <class T> using EffectPart = std::unique_ptr<T>;
#endif

} // namespace talik
