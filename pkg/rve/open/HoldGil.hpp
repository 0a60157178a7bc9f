// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <Python.h>

namespace talik {

/// Python's lock for as long as it lives, whatever thread asks.
class HoldGil {
	PyGILState_STATE state = PyGILState_Ensure();

public:
	HoldGil()                          = default;
	HoldGil(const HoldGil&)            = delete;
	HoldGil& operator=(const HoldGil&) = delete;
	~HoldGil() { PyGILState_Release(state); }
};

} // namespace talik
