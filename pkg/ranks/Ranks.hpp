// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace talik {

/// What a rank has sent, and how long it has waited for the others.
struct RankTraffic {
	std::uint64_t messages = 0; ///< collective calls in which this rank took part
	std::uint64_t bytes    = 0; ///< sent by this rank, once for each that receives them
	double        waited   = 0; ///< wall time inside these calls [s]
	double        polling  = 0; ///< processor time of it [s]
};

/// Bytes that go to a rank, or are awaited from it.
struct Parcel {
	int         rank   = 0;
	char*       bytes  = nullptr;
	std::size_t length = 0;
};

/// The processes of one job, which run the same script. Carries bytes and does not know what they mean. Every call but rank() and
/// count() is collective: all ranks make the same calls in the same order, each from one thread at a time.
class Ranks {
public:
	virtual ~Ranks() = default;

	virtual int rank() const  = 0; ///< of this process, counted from 0
	virtual int count() const = 0;

	/// Everybody gets the parts of all ranks in the order of ranks; lengths: in bytes by rank, known to all. mine may lie in its place of all.
	virtual void allGather(const void* mine, const std::vector<std::size_t>& lengths, void* all) = 0;
	/// toEach[r] goes to rank r; returns what each rank sent here. Nothing is sent for what is empty.
	virtual std::vector<std::string> exchange(const std::vector<std::string>& toEach) = 0;
	/// Parcels of known length between some ranks. What one sends to another is what that awaits from it, in number, order and length. This
	/// one makes an exchange of it.
	virtual void pass(const std::vector<Parcel>& going, const std::vector<Parcel>& coming);
	/// Ends all processes of the job, whatever they do. Not collective.
	[[noreturn]] virtual void endJob(int status) = 0;

	const RankTraffic& traffic() const { return sent; }

protected:
	RankTraffic sent;
};

/// The ranks of the job that mpirun started, or nullptr for a process that is alone. Collective.
std::shared_ptr<Ranks> joinRanks();
/// False in a Talik that was built without Open MPI: joinRanks() finds no others then.
bool knowsRanks();

} // namespace talik
