// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <utility>

namespace talik {

/// Runs work; an std::invalid_argument whose sentence begins with the first of a pair begins with the second instead: a user
/// looks for the attribute that the script has set, not for its name in the ground.
template <class Work> auto underScriptNames(std::initializer_list<std::pair<const char*, const char*>> names, Work&& work)
{
	try {
		return work();
	} catch (const std::invalid_argument& error) {
		const std::string text = error.what();
		for (const auto& [inside, inScript] : names)
			if (text.compare(0, std::string(inside).size(), inside) == 0)
				throw std::invalid_argument(inScript + text.substr(std::string(inside).size()));
		throw;
	}
}

} // namespace talik
