// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <memory>

namespace talik {

/// Stands for an effect in code that was built without it: whatever asks for it is known to fail when the code is compiled, and goes.
template <class T> struct NeverThere {
	NeverThere& operator=(std::unique_ptr<T>) { return *this; }
	constexpr explicit operator bool() const { return false; }
	constexpr T* get() const { return nullptr; }
	constexpr T* operator->() const { return nullptr; }
	constexpr T& operator*() const { return *get(); }
};

/// An effect that a scene may have; empty if it has not. With TALIK_DRY_GROUND the ground is built as if only motion existed:
/// scripts/bench holds against it what an effect costs that is switched off.
#ifdef TALIK_DRY_GROUND
template <class T> using EffectPart = NeverThere<T>;
#else
template <class T> using EffectPart = std::unique_ptr<T>;
#endif

} // namespace talik
