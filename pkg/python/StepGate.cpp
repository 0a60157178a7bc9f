// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/python/StepGate.hpp>
#include <Python.h>

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

namespace talik {
namespace {
	thread_local bool helps = false;

	class Queue {
	public:
		/// True if the calling thread was inside already or nobody is.
		bool tryEnter()
		{
			std::lock_guard<std::mutex> lock(mutex);
			if (depth > 0 && inside == std::this_thread::get_id()) {
				++depth;
				return true;
			}
			if (next != served) return false;
			++next;
			takePlace();
			return true;
		}
		void enter()
		{
			std::unique_lock<std::mutex> lock(mutex);
			const std::uint64_t          ticket = next++;
			turn.wait(lock, [&] { return served == ticket; });
			takePlace();
		}
		void leave()
		{
			std::lock_guard<std::mutex> lock(mutex);
			if (--depth > 0) return;
			inside = {};
			++served;
			if (next != served) turn.notify_all();
		}

	private:
		void takePlace()
		{
			inside = std::this_thread::get_id();
			depth  = 1;
		}

		std::mutex              mutex;
		std::condition_variable turn;
		std::thread::id         inside;
		int                     depth = 0;
		std::uint64_t           next = 0, served = 0;
	};

	/// Never destroyed: a run may still be under way when the process ends.
	Queue& queue()
	{
		static Queue& one = *new Queue;
		return one;
	}
} // namespace

StepGate::StepGate()
        : taken(!helps)
{
	if (!taken || queue().tryEnter()) return;
	PyThreadState* const state = Py_IsInitialized() && PyGILState_Check() ? PyEval_SaveThread() : nullptr;
	queue().enter();
	if (state) PyEval_RestoreThread(state);
}

StepGate::StepGate(std::try_to_lock_t)
        : taken(!helps && queue().tryEnter())
        , through(helps || taken)
{}

StepGate::~StepGate()
{
	if (taken) queue().leave();
}

StepGate::Helper::Helper()
        : before(helps)
{
	helps = true;
}

StepGate::Helper::~Helper() { helps = before; }

} // namespace talik
