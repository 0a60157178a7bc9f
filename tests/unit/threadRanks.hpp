// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
// Ranks that are threads of this process.

#include <pkg/ranks/Communicator.hpp>

#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <thread>

namespace talik {

/// Where threads lay down bytes for each other.
struct Table {
	explicit Table(int ranks)
	        : bytes(std::size_t(ranks), std::vector<std::string>(std::size_t(ranks)))
	        , count(ranks)
	{}
	void wait()
	{
		std::unique_lock<std::mutex> lock(guard);
		const long                   now = round;
		if (++arrived == count) {
			arrived = 0;
			round++;
			all.notify_all();
		} else all.wait(lock, [&] { return round != now; });
	}
	std::vector<std::vector<std::string>> bytes; ///< from, to
	const int                             count;

private:
	std::mutex              guard;
	std::condition_variable all;
	int                     arrived = 0;
	long                    round   = 0;
};

class ThreadRanks final : public Ranks {
public:
	ThreadRanks(Table& t, int number)
	        : table(t)
	        , own(number)
	{}
	int  rank() const override { return own; }
	int  count() const override { return table.count; }
	void allGather(const void* mine, const std::vector<std::size_t>& lengths, void* all) override
	{
		const std::string part(static_cast<const char*>(mine), lengths[std::size_t(own)]);
		const auto        parts = exchange(std::vector<std::string>(lengths.size(), part));
		auto*             into  = static_cast<char*>(all);
		for (std::size_t k = 0; k < parts.size(); into += lengths[k++])
			std::memcpy(into, parts[k].data(), lengths[k]);
	}
	std::vector<std::string> exchange(const std::vector<std::string>& toEach) override
	{
		table.bytes[std::size_t(own)] = toEach;
		table.wait();
		std::vector<std::string> received;
		for (const auto& from : table.bytes)
			received.push_back(from[std::size_t(own)]);
		table.wait();
		return received;
	}
	void endJob(int) override { std::abort(); }

private:
	Table&    table;
	const int own;
};

/// Runs work(communicator) as so many ranks.
template <class Work> void asRanks(int ranks, Work&& work)
{
	Table                    table(ranks);
	std::vector<std::thread> threads;
	for (int r = 0; r < ranks; ++r)
		threads.emplace_back([&, r] { work(std::make_shared<Communicator>(std::make_shared<ThreadRanks>(table, r))); });
	for (auto& thread : threads)
		thread.join();
}

} // namespace talik
