// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/ranks/Communicator.hpp>

#include <algorithm>
#include <stdexcept>

namespace talik {

void Ranks::pass(const std::vector<Parcel>& going, const std::vector<Parcel>& coming)
{
	auto toEach = std::vector<std::string>(std::size_t(count()));
	for (const Parcel& parcel : going)
		toEach[std::size_t(parcel.rank)].append(parcel.bytes, parcel.length);
	const auto               received = exchange(toEach);
	std::vector<std::size_t> taken(toEach.size(), 0);
	for (const Parcel& parcel : coming) {
		std::size_t& from = taken[std::size_t(parcel.rank)];
		std::memcpy(parcel.bytes, received[std::size_t(parcel.rank)].data() + from, parcel.length);
		from += parcel.length;
	}
}

/// What a rank holds up in each round.
struct Communicator::Message {
	static constexpr std::int32_t meeting = -1;

	std::uint64_t digest   = 0;       ///< of the state at a meeting; other than 0 with a question: it is an order
	std::int32_t  answerer = meeting; ///< number of the answerer who is asked
	char          text[116] {};       ///< purpose of the meeting, or question

	Message() = default;
	Message(std::int32_t number, const std::string& words, std::uint64_t state)
	        : digest(state)
	        , answerer(number)
	{
		if (words.size() >= sizeof text) throw std::logic_error("too long for a message: " + words);
		std::memcpy(text, words.data(), words.size());
	}
	bool asks() const { return answerer != meeting; }
	bool orders() const { return asks() && digest != 0; }
	bool saysTheSame(const Message& other) const { return answerer == other.answerer && std::strcmp(text, other.text) == 0; }
};

std::vector<Communicator::Message> Communicator::round(const Message& mine)
{
	auto messages = std::vector<Message>(std::size_t(count()));
	ranks_->allGather(&mine, std::vector<std::size_t>(messages.size(), sizeof(Message)), messages.data());
	return messages;
}

namespace {
	constexpr char known = '.', unknown = '?'; ///< last letter of an answer: whether there is an answerer
} // namespace

/// The part of this rank goes to all who ask the same.
std::vector<std::string> Communicator::answer(const std::vector<Message>& messages, const Message& question, const std::string& ownOrder)
{
	std::string order;
	if (question.orders()) {
		const auto orders = ranks_->exchange(std::vector<std::string>(messages.size(), ownOrder));
		order             = *std::find_if(orders.begin(), orders.end(), [](const std::string& words) { return !words.empty(); });
	}
	const auto  found = answerers.find(question.answerer);
	std::string own;
	if (found != answerers.end()) own = question.orders() ? found->second->carryOut(order) : found->second->answerTo(question.text);
	own.push_back(found == answerers.end() ? unknown : known);
	std::vector<std::string> toEach(messages.size());
	for (std::size_t k = 0; k < messages.size(); ++k)
		if (messages[k].saysTheSame(question)) toEach[k] = own;
	return ranks_->exchange(toEach);
}

void Communicator::meet(const std::string& purpose, std::uint64_t digest)
{
	const Message mine(Message::meeting, purpose, digest);
	for (;;) {
		const auto messages = round(mine);
		const auto question = std::find_if(messages.begin(), messages.end(), [](const Message& message) { return message.asks(); });
		if (question == messages.end()) {
			requireSame(messages);
			return;
		}
		answer(messages, *question);
	}
}

std::vector<std::string> Communicator::ask(int answerer, const std::string& words) { return answersTo(Message(answerer, words, 0), ""); }

std::vector<std::string> Communicator::order(int answerer, const std::string& what)
{
	return answersTo(Message(answerer, "order of rank " + std::to_string(rank()), 1), what);
}

std::vector<std::string> Communicator::answersTo(const Message& mine, const std::string& ownOrder)
{
	for (;;) {
		const auto    messages = round(mine);
		const Message question = *std::find_if(messages.begin(), messages.end(), [](const Message& message) { return message.asks(); });
		auto          answers  = answer(messages, question, question.saysTheSame(mine) ? ownOrder : "");
		if (!question.saysTheSame(mine)) continue;
		for (std::size_t k = 0; k < answers.size(); ++k) {
			if (answers[k].back() == unknown)
				throw std::runtime_error(
				        named(int(k)) + " has dropped the ground or the samples that " + named(rank())
				        + " looks at: let all ranks come to  talik.ranks.meet('looked')  before they begin another scene.");
			answers[k].pop_back();
		}
		return answers;
	}
}

int Communicator::enrol(const Answerer* answerer)
{
	answerers[nextAnswerer] = answerer;
	return nextAnswerer++;
}

std::string Communicator::named(int rank) const
{
	const std::string number = "rank " + std::to_string(rank);
	return std::size_t(rank) < descriptions.size() ? number + " (" + descriptions[std::size_t(rank)] + ")" : number;
}

/// Names a rank that came to another place, or whose state is not that of most ranks.
void Communicator::requireSame(const std::vector<Message>& messages) const
{
	for (std::size_t k = 1; k < messages.size(); ++k)
		if (!messages[k].saysTheSame(messages[0]))
			throw std::runtime_error(
			        "The ranks of this job do different things: " + named(0) + " is at '" + messages[0].text + "', " + named(int(k)) + " at '"
			        + messages[k].text + "'. Let all run the same script; steps must depend neither on the rank nor on the wall clock.");
	const auto like = [&](std::size_t k) {
		return std::count_if(messages.begin(), messages.end(), [&](const Message& message) { return message.digest == messages[k].digest; });
	};
	std::size_t usual = 0;
	for (std::size_t k = 1; k < messages.size(); ++k)
		if (like(k) > like(usual)) usual = k;
	for (std::size_t k = 0; k < messages.size(); ++k)
		if (messages[k].digest != messages[usual].digest)
			throw std::runtime_error(
			        "The ground of " + named(int(k)) + " is no longer that of " + named(int(usual)) + " (noticed at '" + messages[k].text
			        + "'): start the same script with the same settings on all ranks, on processors of one kind.");
}

} // namespace talik
