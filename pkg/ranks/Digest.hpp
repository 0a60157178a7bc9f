// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstdint>
#include <cstring>

namespace talik {

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

} // namespace talik
