// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <string>
#include <vector>

namespace yade {
class MpmEngine;
}

namespace talik {

/// A setting that is valid and yet hardly what was meant.
struct Doubt {
	std::string sentence; ///< attribute, value, what was probably meant
	bool        grave;    ///< nothing sensible comes of it: the first step says so unasked
};

std::vector<Doubt> doubtsAbout(const yade::MpmEngine& mpm);

} // namespace talik
