// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace talik::stability {

inline std::uint64_t fromEnvironment(const char* name, std::uint64_t otherwise)
{
	const char* text = std::getenv(name);
	return text && *text ? std::strtoull(text, nullptr, 10) : otherwise;
}

/// TALIK_DRAWS: how many (default 200); TALIK_SEED: the first (default 1). TALIK_DRAWS=1 TALIK_SEED=n repeats that of seed n.
inline std::uint64_t drawsAskedFor() { return fromEnvironment("TALIK_DRAWS", 200); }
inline std::uint64_t firstSeed() { return fromEnvironment("TALIK_SEED", 1); }

/// Draws and writes down what it drew. The same seed draws the same on any machine.
class Dice {
public:
	explicit Dice(std::uint64_t seed)
	        : generator_(seed)
	{}

	double uniform(double from, double to) { return from + (to - from) * double(generator_() >> 11) * 0x1p-53; }
	double between(const char* name, double from, double to) { return noted(name, uniform(from, to)); }
	/// Every decade is as likely as another.
	double decades(const char* name, double from, double to) { return noted(name, from * std::pow(to / from, uniform(0.0, 1.0))); }
	int    count(const char* name, int from, int to) { return int(noted(name, from + std::floor(uniform(0.0, to - from + 1.0)))); }
	/// True with the probability given; the name is written down if it comes true.
	bool chance(const char* name, double probability)
	{
		const bool comes = uniform(0.0, 1.0) < probability;
		if (comes) text_ << ' ' << name;
		return comes;
	}
	template <class T> T oneOf(const char* name, const std::vector<T>& choices)
	{
		const T& choice = choices[std::min(choices.size() - 1, std::size_t(uniform(0.0, choices.size())))];
		text_ << ' ' << name << '=' << choice;
		return choice;
	}

	std::string text() const { return text_.str(); }

private:
	double noted(const char* name, double value)
	{
		text_ << ' ' << name << '=' << value;
		return value;
	}

	std::mt19937_64    generator_;
	std::ostringstream text_;
};

} // namespace talik::stability
