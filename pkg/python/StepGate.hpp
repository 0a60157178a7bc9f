// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <mutex>
#include <Python.h>

namespace talik {

/// Python's lock for as long as it lives, whatever thread asks.
class PythonLock {
	PyGILState_STATE state = PyGILState_Ensure();

public:
	PythonLock()                             = default;
	PythonLock(const PythonLock&)            = delete;
	PythonLock& operator=(const PythonLock&) = delete;
	~PythonLock() { PyGILState_Release(state); }
};

/// Held by a step of one of our engines, or by a call from Python into one of our classes: never both at once, in the order in which
/// they came, so that neither a run nor a console that asks again and again keeps the other out. The thread that holds it may take it
/// again. Whoever waits lets go of Python's lock meanwhile, which the step inside may need.
class StepGate {
public:
	StepGate();
	/// Does not wait: check passes().
	explicit StepGate(std::try_to_lock_t);
	~StepGate();
	/// True if nobody else is inside.
	bool passes() const { return through; }
	StepGate(const StepGate&)            = delete;
	StepGate& operator=(const StepGate&) = delete;

	/// A thread that works for the step inside: it goes through.
	class Helper {
	public:
		Helper();
		~Helper();
		Helper(const Helper&)            = delete;
		Helper& operator=(const Helper&) = delete;

	private:
		const bool before;
	};

private:
	bool taken = false, through = true;
};

} // namespace talik
