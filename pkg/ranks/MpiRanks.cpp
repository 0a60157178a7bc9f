// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/ranks/Communicator.hpp>

#ifndef TALIK_WITHOUT_MPI
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <mpi.h>
#include <numeric>
#include <thread>
#endif

namespace talik {

#ifdef TALIK_WITHOUT_MPI

std::shared_ptr<Ranks> joinRanks() { return nullptr; }
bool                   knowsRanks() { return false; }

#else

namespace {
	constexpr std::size_t largestMessage = std::size_t(1) << 30; ///< Open MPI counts in int

	using Clock = std::chrono::steady_clock;

	double processorTime()
	{
		timespec now {};
		clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
		return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
	}

	/// From its making on: wall time, and processor time of this thread.
	struct Watch {
		Clock::time_point begin     = Clock::now();
		double            processor = processorTime();
	};

	/// Open MPI waits at full speed, which takes the processor from the threads of other ranks where there are more ranks than cores.
	void waitFor(std::vector<MPI_Request>& requests)
	{
		const auto begin = Clock::now();
		for (;;) {
			int done = 0;
			MPI_Testall(int(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
			if (done) return;
			const auto waited = Clock::now() - begin;
			if (waited < std::chrono::microseconds(30)) continue;
			if (waited < std::chrono::milliseconds(5)) std::this_thread::yield();
			else std::this_thread::sleep_for(std::chrono::microseconds(100));
		}
	}

	class MpiRanks final : public Ranks {
	public:
		/// A communicator of its own: messages of the script and of YADE do not meet these.
		MpiRanks()
		{
			MPI_Comm_dup(MPI_COMM_WORLD, &all);
			MPI_Comm_rank(all, &own);
			MPI_Comm_size(all, &number);
		}

		int rank() const override { return own; }
		int count() const override { return number; }

		void allGather(const void* mine, const std::vector<std::size_t>& lengths, void* into) override
		{
			std::vector<int> counts(lengths.begin(), lengths.end()), begins(lengths.size(), 0);
			std::partial_sum(counts.begin(), counts.end() - 1, begins.begin() + 1);
			std::vector<MPI_Request> request(1);
			const Watch              watch;
			const bool               inPlace = mine == static_cast<char*>(into) + begins[std::size_t(own)];
			MPI_Iallgatherv(
			        inPlace ? MPI_IN_PLACE : mine, counts[std::size_t(own)], MPI_BYTE, into, counts.data(), begins.data(), MPI_BYTE, all,
			        request.data());
			waitFor(request);
			note(lengths[std::size_t(own)] * std::size_t(number - 1), watch);
		}

		std::vector<std::string> exchange(const std::vector<std::string>& toEach) override
		{
			const Watch                watch;
			std::vector<std::uint64_t> going, coming(toEach.size());
			for (const auto& bytes : toEach)
				going.push_back(bytes.size());
			std::vector<MPI_Request> requests(1);
			MPI_Ialltoall(going.data(), 1, MPI_UINT64_T, coming.data(), 1, MPI_UINT64_T, all, requests.data());
			waitFor(requests);
			std::vector<std::string> received(toEach.size());
			std::size_t              sum = 0;
			requests.clear();
			for (int other = 0; other < number; ++other) {
				const auto k = std::size_t(other);
				if (other == own) {
					received[k] = toEach[k];
					continue;
				}
				received[k].resize(coming[k]);
				inPieces(coming[k], [&](std::size_t at, int length) {
					MPI_Irecv(&received[k][at], length, MPI_BYTE, other, 0, all, &requests.emplace_back());
				});
				inPieces(going[k], [&](std::size_t at, int length) {
					MPI_Isend(&toEach[k][at], length, MPI_BYTE, other, 0, all, &requests.emplace_back());
				});
				sum += toEach[k].size();
			}
			waitFor(requests);
			note(sum, watch);
			return received;
		}

		void pass(const std::vector<Parcel>& going, const std::vector<Parcel>& coming) override
		{
			const Watch watch;
			std::size_t sum = 0;
			parcels.clear();
			for (const Parcel& parcel : coming)
				inPieces(parcel.length, [&](std::size_t at, int length) {
					MPI_Irecv(parcel.bytes + at, length, MPI_BYTE, parcel.rank, 1, all, &parcels.emplace_back());
				});
			for (const Parcel& parcel : going) {
				inPieces(parcel.length, [&](std::size_t at, int length) {
					MPI_Isend(parcel.bytes + at, length, MPI_BYTE, parcel.rank, 1, all, &parcels.emplace_back());
				});
				sum += parcel.length;
			}
			waitFor(parcels);
			note(sum, watch);
		}

		void endJob(int status) override
		{
			MPI_Abort(all, status);
			std::abort();
		}

	private:
		template <class Piece> static void inPieces(std::size_t bytes, Piece&& piece)
		{
			for (std::size_t at = 0; at < bytes; at += largestMessage)
				piece(at, int(std::min(largestMessage, bytes - at)));
		}

		void note(std::size_t bytes, const Watch& watch)
		{
			++sent.messages;
			sent.bytes += bytes;
			sent.waited += std::chrono::duration<double>(Clock::now() - watch.begin).count();
			sent.polling += processorTime() - watch.processor;
		}

		std::vector<MPI_Request> parcels;

		MPI_Comm all = MPI_COMM_NULL;
		int      own = 0, number = 1;
	};
} // namespace

bool knowsRanks() { return true; }

std::shared_ptr<Ranks> joinRanks()
{
	const char* const size = std::getenv("OMPI_COMM_WORLD_SIZE");
	if (!size || std::atoi(size) < 2) return nullptr;
	int ready = 0, provided = 0;
	MPI_Initialized(&ready);
	if (!ready) MPI_Init_thread(nullptr, nullptr, MPI_THREAD_MULTIPLE, &provided);
	return std::make_shared<MpiRanks>();
}

#endif

namespace {
	std::shared_ptr<Communicator>& jobCommunicatorNow()
	{
		static auto* const communicator = new std::shared_ptr<Communicator>; // outlives grounds that Python lets go at its end
		return *communicator;
	}
} // namespace

const std::shared_ptr<Communicator>& jobCommunicator() { return jobCommunicatorNow(); }

void openJobTalk()
{
	if (jobCommunicatorNow()) return;
	if (const auto ranks = joinRanks()) jobCommunicatorNow() = std::make_shared<Communicator>(ranks);
}

bool isFirstRank() { return !jobCommunicator() || jobCommunicator()->rank() == 0; }

} // namespace talik
