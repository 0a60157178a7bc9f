// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <map>
#include <pkg/ranks/Ranks.hpp>

namespace talik {

/// How ranks that run one script find each other. They meet where all have to act together, and one that only wants to know something
/// asks: it is answered by the others when they come to their next meeting, wherever it is itself. So a rank may look at the ground
/// when the others do not, as rank 0 does on the wall clock.
class RankTalk {
public:
	/// Somebody on every rank who knows a part of what is asked for.
	class Answerer {
	public:
		virtual ~Answerer() = default;
		/// The part of this rank.
		virtual std::string answerTo(const std::string& question) const = 0;
	};

	explicit RankTalk(std::shared_ptr<Ranks> ranks)
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

	/// Numbers follow from the order, which is the same on all ranks.
	int  enrol(const Answerer* answerer);
	void dismiss(int number) { answerers.erase(number); }

	/// How a rank is called in errors: what tells it from the others.
	void describe(std::vector<std::string> byRank) { descriptions = std::move(byRank); }

private:
	struct Message;
	std::vector<Message>     round(const Message& mine);
	std::vector<std::string> answer(const std::vector<Message>& messages, const Message& question);
	void                     requireSame(const std::vector<Message>& messages) const;
	std::string              named(int rank) const;

	std::shared_ptr<Ranks>         ranks_;
	std::map<int, const Answerer*> answerers;
	int                            nextAnswerer = 0;
	std::vector<std::string>       descriptions;
};

/// The talk of this job; nullptr in a process that is alone.
const std::shared_ptr<RankTalk>& jobTalk();
/// Joins the other ranks, if there are any. Collective; once.
void openJobTalk();
/// The one rank that prints, draws and writes; true in a process that is alone.
bool isFirstRank();

} // namespace talik
