// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
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

/// A number that differs, but for chance (2^-64), where one bit of what was added differs.
class Digest {
public:
	void add(std::uint64_t word) { mix(sum, word); }
	void add(const void* data, std::size_t bytes)
	{
		const auto* from = static_cast<const unsigned char*>(data);
		add(std::uint64_t(bytes));
		std::uint64_t lanes[] = { sum, ~sum, sum << 1, ~(sum << 1) }; // that do not wait for each other
		for (; bytes >= sizeof lanes; from += sizeof lanes, bytes -= sizeof lanes)
			for (std::size_t k = 0; k < 4; ++k)
				mix(lanes[k], word(from + k * sizeof(std::uint64_t)));
		for (const auto lane : lanes)
			add(lane);
		for (; bytes >= sizeof(std::uint64_t); from += sizeof(std::uint64_t), bytes -= sizeof(std::uint64_t))
			add(word(from));
		std::uint64_t rest = 0;
		std::memcpy(&rest, from, bytes);
		add(rest);
	}
	std::uint64_t value() const { return sum; }

private:
	static void mix(std::uint64_t& lane, std::uint64_t word)
	{
		lane = (lane ^ word) * 0x9e3779b97f4a7c15ULL;
		lane ^= lane >> 29;
	}
	static std::uint64_t word(const unsigned char* from)
	{
		std::uint64_t value;
		std::memcpy(&value, from, sizeof value);
		return value;
	}

	std::uint64_t sum = 0xcbf29ce484222325ULL;
};

/// How ranks that run one script find each other. They meet where all have to act together, and one that only wants to know something
/// asks: it is answered by the others when they come to their next meeting, wherever it is itself. So a rank may look at the ground
/// when the others do not, as rank 0 does on the wall clock.
class Communicator {
public:
	/// Somebody on every rank who knows a part of what is asked for.
	class Answerer {
	public:
		virtual ~Answerer() = default;
		/// The part of this rank.
		virtual std::string answerTo(const std::string& question) const = 0;
		/// Does what another rank wants done by all, and says what came of it. Must not throw.
		virtual std::string carryOut(const std::string&) const { return ""; }
	};

	explicit Communicator(std::shared_ptr<Ranks> ranks)
	        : ranks_(std::move(ranks))
	{}

	Ranks& ranks() { return *ranks_; }
	int    rank() const { return ranks_->rank(); }
	int    count() const { return ranks_->count(); }

	/// Waits until all ranks have come to this meeting and answers questions meanwhile. Throws std::runtime_error, on all ranks with the
	/// same sentence, where a rank has come to another meeting, or to this one with another digest of the state.
	void meet(const std::string& purpose, std::uint64_t digest = 0);

	/// What each rank's answerer of this number says, by rank. purpose and question: at most 100 bytes.
	std::vector<std::string> ask(int answerer, const std::string& question);
	/// The same of what each rank's answerer does upon an order, which may be long. Throws std::runtime_error where a rank has none any more, as
	/// ask() does.
	std::vector<std::string> order(int answerer, const std::string& what);

	/// Numbers follow from the order, which is the same on all ranks.
	int  enrol(const Answerer* answerer);
	void dismiss(int number) { answerers.erase(number); }

	/// How a rank is called in errors: what tells it from the others.
	void describe(std::vector<std::string> byRank) { descriptions = std::move(byRank); }

private:
	struct Message;
	std::vector<Message>     round(const Message& mine);
	std::vector<std::string> answer(const std::vector<Message>& messages, const Message& question, const std::string& ownOrder = "");
	std::vector<std::string> answersTo(const Message& mine, const std::string& ownOrder);
	void                     requireSame(const std::vector<Message>& messages) const;
	std::string              named(int rank) const;

	std::shared_ptr<Ranks>         ranks_;
	std::map<int, const Answerer*> answerers;
	int                            nextAnswerer = 0;
	std::vector<std::string>       descriptions;
};

/// The communicator of this job; nullptr in a process that is alone.
const std::shared_ptr<Communicator>& jobCommunicator();
/// Joins the other ranks, if there are any. Collective; once.
void openJobTalk();
/// The one rank that prints, draws and writes; true in a process that is alone.
bool isFirstRank();

} // namespace talik
