// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/ranks/RankTalk.hpp>

namespace talik {
namespace {
	std::shared_ptr<RankTalk>& jobTalkNow()
	{
		static auto* const talk = new std::shared_ptr<RankTalk>; // outlives grounds that Python lets go at its end
		return *talk;
	}
} // namespace

const std::shared_ptr<RankTalk>& jobTalk() { return jobTalkNow(); }

void openJobTalk()
{
	if (jobTalkNow()) return;
	if (const auto ranks = joinRanks()) jobTalkNow() = std::make_shared<RankTalk>(ranks);
}

bool isFirstRank() { return !jobTalk() || jobTalk()->rank() == 0; }

} // namespace talik
