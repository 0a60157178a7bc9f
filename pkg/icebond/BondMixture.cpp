// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <atomic>
#include <pkg/icebond/BondMixture.hpp>
#include <pkg/icebond/BondTable.hpp>

namespace talik {

std::uint64_t nextBondNumber()
{
	static std::atomic<std::uint64_t> last { 0 };
	return ++last;
}

std::shared_ptr<const BondMixture> BondMixtures::with(const NumberedBonds& own, const NumberedBonds& other)
{
	const std::lock_guard<std::mutex> lock(guard);
	known.erase(std::remove_if(known.begin(), known.end(), [](const auto& mixture) { return mixture.expired(); }), known.end());
	for (const auto& mixture : known) {
		const auto found = mixture.lock();
		if (found && found->isOf(own.number, own.model.young, other.number, other.model.young)) return found;
	}
	const bool same = own.number == other.number; // grains of one material: nothing to mix
	const auto made = std::make_shared<const BondMixture>(
	        BondMixture { same ? own.model : mixed(own.model, other.model), own.number, other.number, other.model.young });
	known.push_back(made);
	return made;
}

} // namespace talik
