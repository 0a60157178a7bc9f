// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstdint>
#include <cstring>

namespace talik {

/// A number that differs, but for chance (2^-64), where one bit of what was added differs.
class Digest {
public:
	void add(std::uint64_t word)
	{
		sum = (sum ^ word) * 0x9e3779b97f4a7c15ULL;
		sum ^= sum >> 29;
	}
	void add(const void* data, std::size_t bytes)
	{
		const auto* from = static_cast<const unsigned char*>(data);
		add(std::uint64_t(bytes));
		for (; bytes >= sizeof(std::uint64_t); from += sizeof(std::uint64_t), bytes -= sizeof(std::uint64_t)) {
			std::uint64_t word;
			std::memcpy(&word, from, sizeof word);
			add(word);
		}
		std::uint64_t rest = 0;
		std::memcpy(&rest, from, bytes);
		add(rest);
	}
	std::uint64_t value() const { return sum; }

private:
	std::uint64_t sum = 0xcbf29ce484222325ULL;
};

} // namespace talik
