// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/ThreadPool.hpp>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <pthread.h>
#include <thread>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace talik {
namespace {
	constexpr int  largestTeam = 256;
	constexpr auto shortWait   = std::chrono::microseconds(30);

	void relax()
	{
#if defined(__x86_64__) || defined(__i386__)
		__builtin_ia32_pause();
#elif defined(__aarch64__)
		asm volatile("yield");
#endif
	}

	/// True if the condition came to hold within the short wait.
	template <class Condition> bool holdsSoon(Condition&& condition)
	{
		const auto end = std::chrono::steady_clock::now() + shortWait;
		do {
			for (int i = 0; i < 32; ++i) {
				if (condition()) return true;
				relax();
			}
		} while (std::chrono::steady_clock::now() < end);
		return condition();
	}

	/// Pieces of one thread that have not been taken: number of the loop, end, next. In one word, so that a thread that comes late takes
	/// no piece of another loop.
	struct alignas(64) Share {
		std::atomic<std::uint64_t> word { 0 };

		static std::uint64_t pack(std::uint32_t loop, int next, int end)
		{
			return std::uint64_t(loop) << 32 | std::uint64_t(end) << 16 | std::uint64_t(next);
		}
	};

	using Function = void (*)(void*, int, int);
	using Clock    = std::chrono::steady_clock;

	double secondsSince(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

	/// Decides whether short loops are shared out. Where other processes want the processors, a thread may be kept from its own for a time
	/// slice of the system: longer than the whole loop takes. That cannot be foreseen. So time is measured against that of one thread, and
	/// after a loss one thread does all for a while, the longer the more often it happened.
	class SharingChoice {
	public:
		/// What is known of a loop.
		struct Loop {
			Function function = nullptr;
			double   piece    = 0; ///< time that one thread takes for a piece [s]
			unsigned calls    = 0;
		};

		Loop& of(Function function)
		{
			std::size_t place = (reinterpret_cast<std::uintptr_t>(function) >> 4) * 0x9E3779B97F4A7C15ULL >> 58;
			for (int tries = 0; tries < known; ++tries, place = (place + 1) % known)
				if (!loops[place].function || loops[place].function == function) break;
			if (loops[place].function != function) loops[place] = Loop { function };
			return loops[place];
		}
		/// True if one thread shall do it all: after a loss, and now and then to know how long that takes.
		bool alone(Loop& loop, int count) const
		{
			if (loop.piece == 0 || isLong(loop, count)) return false;
			return ++loop.calls % askedAgain == 0 || Clock::now() < resumed;
		}
		void tookAlone(Loop& loop, double piece) const { loop.piece += (loop.piece == 0 ? 1 : 0.2) * (piece - loop.piece); }
		void tookTogether(const Loop& loop, int count, double seconds)
		{
			if (isLong(loop, count)) return;
			const double expected = loop.piece * count;
			lost                  = std::max(lost + seconds - expected, -tolerated);
			watched += expected;
			if (lost > tolerated) {
				pause   = std::min(longestPause, 2 * pause);
				resumed = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(pause));
			} else if (watched > 50 * tolerated) pause = std::max(shortestPause, 0.5 * pause);
			else return;
			lost = watched = 0;
		}

	private:
		static constexpr int    known = 64, askedAgain = 128;
		static constexpr double tolerated = 0.5e-3, shortestPause = 5e-3, longestPause = 0.5, longLoop = 3e-3; // [s]

		/// Far longer than a time slice: always shared out.
		static bool isLong(const Loop& loop, int count) { return loop.piece * count > longLoop; }

		Loop              loops[known];
		double            lost = 0, watched = 0, pause = shortestPause;
		Clock::time_point resumed;
	};

	class Team {
	public:
		void run(int count, int threads, Function f, void* w)
		{
			SharingChoice::Loop& known = choice.of(f);
			const auto           begin = Clock::now();
			if (choice.alone(known, count)) {
				for (int i = 0; i < count; ++i)
					f(w, i, 0);
				choice.tookAlone(known, secondsSince(begin) / count);
				return;
			}
			runTogether(count, threads, f, w);
			if (known.piece == 0 && ownPieces > 0) choice.tookAlone(known, ownSeconds / ownPieces);
			else choice.tookTogether(known, count, secondsSince(begin));
			if (!failure) return;
			const std::exception_ptr thrown = failure;
			failure                         = nullptr;
			std::rethrow_exception(thrown);
		}

		std::atomic_flag busy = ATOMIC_FLAG_INIT;

	private:
		void runTogether(int count, int threads, Function f, void* w)
		{
			members = std::min(threads, largestTeam);
			startHelpers(members - 1);
			function.store(f, std::memory_order_relaxed);
			work.store(w, std::memory_order_relaxed);
			done.store(0, std::memory_order_relaxed);
			total.store(count, std::memory_order_relaxed);
			parts.store(members, std::memory_order_relaxed);
			const std::uint32_t now = loop.load(std::memory_order_relaxed) + 1;
			for (int m = 0; m < members; ++m)
				shares[m].word.store(
				        Share::pack(now, int(long(count) * m / members), int(long(count) * (m + 1) / members)), std::memory_order_release);
			loop.store(now);
			if (waiting.load() > 0) {
				std::lock_guard<std::mutex> lock(mutex);
				begun.notify_all();
			}
			const auto begin = Clock::now();
			ownPieces        = takePart(0, now);
			ownSeconds       = secondsSince(begin);
			awaitOthers(count);
		}

		void startHelpers(int helpers)
		{
			for (; started < helpers; ++started)
				std::thread([this, member = started + 1] { helpLoops(member); }).detach();
		}

		/// What a helper does as long as the process lives. No loop waits for it to join.
		void helpLoops(int member)
		{
			std::uint32_t seen = 0;
			for (;;) {
				const auto isNew = [&] { return loop.load(std::memory_order_acquire) != seen; };
				if (!holdsSoon(isNew)) {
					std::unique_lock<std::mutex> lock(mutex);
					++waiting;
					begun.wait(lock, [&] { return loop.load() != seen; });
					--waiting;
				}
				seen = loop.load(std::memory_order_acquire);
				if (member < parts.load(std::memory_order_relaxed)) takePart(member, seen);
			}
		}

		/// Its own share first, then what the others have left. Returns the number of pieces.
		int takePart(int member, std::uint32_t now)
		{
			const int all  = parts.load(std::memory_order_relaxed);
			int       done = 0;
			for (int k = 0; k < all && empty(shares[(member + k) % all], member, now, done);)
				++k;
			return done;
		}

		/// False if the loop has ended.
		bool empty(Share& share, int member, std::uint32_t now, int& pieces)
		{
			std::uint64_t word = share.word.load(std::memory_order_acquire);
			for (;;) {
				if (std::uint32_t(word >> 32) != now) return false;
				const int next = int(word & 0xffff), end = int(word >> 16 & 0xffff);
				if (next >= end) return true;
				const Function f = function.load(std::memory_order_relaxed);
				void* const    w = work.load(std::memory_order_relaxed);
				if (!share.word.compare_exchange_weak(word, word + 1, std::memory_order_acq_rel, std::memory_order_acquire)) continue;
				// the piece is ours: the loop does not end before it
				++pieces;
				const int count = total.load(std::memory_order_relaxed);
				try {
					f(w, next, member);
				} catch (...) {
					std::lock_guard<std::mutex> lock(mutex);
					if (!failure) failure = std::current_exception();
				}
				if (done.fetch_add(1) + 1 == count && callerSleeps.load()) {
					std::lock_guard<std::mutex> lock(mutex);
					ended.notify_one();
				}
				word = share.word.load(std::memory_order_acquire);
			}
		}

		void awaitOthers(int count)
		{
			const auto all = [&] { return done.load(std::memory_order_acquire) == count; };
			if (holdsSoon(all)) return;
			std::unique_lock<std::mutex> lock(mutex);
			callerSleeps.store(true);
			ended.wait(lock, [&] { return done.load() == count; });
			callerSleeps.store(false);
		}

		alignas(64) std::atomic<std::uint32_t> loop { 0 };
		std::atomic<Function> function { nullptr };
		std::atomic<void*>    work { nullptr };
		std::atomic<int>      parts { 0 }, total { 0 }, waiting { 0 };
		std::atomic<bool>     callerSleeps { false };
		alignas(64) std::atomic<int> done { 0 };
		Share                   shares[largestTeam];
		std::mutex              mutex;
		std::condition_variable begun, ended;
		std::exception_ptr      failure;
		int                     members = 1, started = 0, ownPieces = 0;
		double                  ownSeconds = 0;
		SharingChoice           choice;
	};

	std::atomic<Team*> present { nullptr };

	/// Never destroyed: its threads outlive everything. A process that was forked has none of them and starts its own.
	Team& team()
	{
		static const bool made = [] {
			present = new Team;
			pthread_atfork(nullptr, nullptr, [] { present = new Team; });
			return true;
		}();
		(void)made;
		return *present.load(std::memory_order_relaxed);
	}
} // namespace

int ThreadPool::threads()
{
#ifdef _OPENMP
	return omp_in_parallel() ? 1 : omp_get_max_threads();
#else
	return 1;
#endif
}

/// A loop inside of a loop, or beside one of another thread, is done by the thread that asks.
void ThreadPool::share(int count, int threads, Function function, void* work)
{
	Team& t = team();
	if (t.busy.test_and_set(std::memory_order_acquire)) {
		for (int i = 0; i < count; ++i)
			function(work, i, 0);
		return;
	}
	struct Free {
		Team& t;
		~Free() { t.busy.clear(std::memory_order_release); }
	} const free { t };
	t.run(count, threads, function, work);
}

} // namespace talik
