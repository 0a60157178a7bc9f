// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/ThreadPool.hpp>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <stdexcept>
#include <thread>
#include <vector>

using namespace talik;

TEST(ThreadPool, everyPieceIsDoneExactlyOnceByAMemberOfTheTeam)
{
	long done = 0;
	for (int count : { 1, 2, 3, 7, 64, 1000, 65535, 65536, 200001 })
		for (int threads : { 1, 2, 3, 8 }) {
			std::vector<int> times(std::size_t(count), 0);
			std::atomic<int> strangers { 0 };
			ThreadPool::run(count, threads, [&](int i, int member) {
				times[std::size_t(i)]++;
				if (member < 0 || member >= threads) strangers++;
			});
			EXPECT_EQ(*std::min_element(times.begin(), times.end()), 1) << count << " pieces, " << threads << " threads";
			EXPECT_EQ(*std::max_element(times.begin(), times.end()), 1) << count << " pieces, " << threads << " threads";
			EXPECT_EQ(strangers, 0);
			done += count;
		}
	std::printf("%ld pieces done once each\n", done);
	ThreadPool::run(0, 4, [](int, int) { ADD_FAILURE() << "there is no piece"; });
}

/// A thread that comes late must not take a piece of the next loop for one of its own.
TEST(ThreadPool, manyShortLoopsInARowMixNothingUp)
{
	std::vector<long> sums(64, 0);
	const int         loops = 100000;
	for (int loop = 0; loop < loops; ++loop) {
		const int count = 2 + loop % 62;
		ThreadPool::run(count, 4, [&, loop](int i, int) { sums[std::size_t(i)] += loop; });
	}
	std::vector<long> expected(64, 0);
	for (int loop = 0; loop < loops; ++loop)
		for (int i = 0; i < 2 + loop % 62; ++i)
			expected[std::size_t(i)] += loop;
	EXPECT_EQ(sums, expected);
}

TEST(ThreadPool, noTwoThreadsHaveOneMemberNumberAtATime)
{
	std::vector<std::atomic<int>> inside(4);
	std::atomic<int>              meetings { 0 };
	for (int loop = 0; loop < 200; ++loop)
		ThreadPool::run(100, 4, [&](int, int member) {
			if (inside[std::size_t(member)]++ > 0) meetings++;
			for (volatile int k = 0; k < 100;)
				k = k + 1;
			inside[std::size_t(member)]--;
		});
	EXPECT_EQ(meetings, 0);
}

TEST(ThreadPool, anExceptionOfAPieceComesUpWhenAllHaveEndedAndTheTeamGoesOn)
{
	std::atomic<int> done { 0 };
	EXPECT_THROW(
	        ThreadPool::run(
	                100, 3,
	                [&](int i, int) {
		                done++;
		                if (i % 10 == 5) throw std::runtime_error("piece");
	                }),
	        std::runtime_error);
	EXPECT_EQ(done, 100);
	done = 0;
	ThreadPool::run(100, 3, [&](int, int) { done++; });
	EXPECT_EQ(done, 100);
}

TEST(ThreadPool, loopsInsideOfLoopsAndOfSeveralThreadsAtATimeAreDoneToo)
{
	std::atomic<int>         done { 0 };
	std::vector<std::thread> askers;
	for (int asker = 0; asker < 3; ++asker)
		askers.emplace_back([&] {
			for (int loop = 0; loop < 200; ++loop)
				ThreadPool::run(8, 3, [&](int, int) { ThreadPool::run(4, 3, [&](int, int) { done++; }); });
		});
	for (auto& asker : askers)
		asker.join();
	EXPECT_EQ(done, 3 * 200 * 8 * 4);
}

TEST(ThreadPool, aForkedProcessGoesOnWithThreadsOfItsOwn)
{
	const auto loops = [] {
		std::atomic<int> done { 0 };
		for (int loop = 0; loop < 50; ++loop) {
			ThreadPool::run(20, 3, [&](int, int) { done++; });
			usleep(200); // helpers sleep in between
		}
		return done.load();
	};
	EXPECT_EQ(loops(), 1000);
	const pid_t child = fork();
	if (child == 0) {
		alarm(20);
		_exit(loops() == 1000 ? 0 : 1);
	}
	int status = -1;
	waitpid(child, &status, 0);
	EXPECT_EQ(status, 0);
	EXPECT_EQ(loops(), 1000);
}
