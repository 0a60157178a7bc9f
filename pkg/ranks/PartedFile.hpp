// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace talik {

class Communicator;

/// Where a part of a file begins, and where the file will end, counted from its first byte.
struct FilePlace {
	std::string   path;
	std::uint64_t at = 0, end = 0;

	/// As text, which another rank reads.
	std::string      text() const;
	static FilePlace from(const std::string& text);
	FilePlace        after(std::uint64_t bytes) const { return { path, at + bytes, end }; }
};

/// What bytes of a file add to its checksum (CRC-64 of ECMA-182, bits reversed): sums of parts are combined by exclusive or, in any order.
class PartSum {
public:
	/// Bytes after which so many follow up to the end of the file.
	void add(const void* data, std::size_t bytes, std::uint64_t follow);
	void add(std::uint64_t ofOthers) { sum_ ^= ofOthers; }

	std::uint64_t value() const { return sum_; }
	/// Checksum of a file of which only the beginning, of checksum `begun`, was known, and so many bytes follow whose sum this is.
	std::uint64_t checksum(std::uint64_t begun, std::uint64_t follow) const;

private:
	std::uint64_t sum_ = 0;
};

/// A file that is there already and into which several ranks write, each what it has; or from which each reads what it needs. Functions throw
/// std::runtime_error with the reason.
class PartedFile {
public:
	enum class For { reading, writing };
	/// end: of the file when it is whole; for writing.
	PartedFile(const std::string& path, For what, std::uint64_t end = 0);
	~PartedFile();
	PartedFile(const PartedFile&)            = delete;
	PartedFile& operator=(const PartedFile&) = delete;

	void write(const void* data, std::size_t bytes, std::uint64_t at);
	void read(void* data, std::size_t bytes, std::uint64_t at) const;
	/// Waits until the disk has what was written.
	void close();
	/// Of what was written.
	const PartSum& sum() const { return sum_; }

private:
	std::string   path_;
	std::uint64_t end_;
	int           descriptor_;
	PartSum       sum_;
};

/// What a rank says that has written its part, or could not.
std::string partWritten(const std::function<void(PartSum&)>& write);
/// Orders the answerers of all ranks to write their parts, each of which says partWritten(). Throws std::runtime_error with rank and reason.
std::uint64_t sumOfParts(Communicator& communicator, int answerer, const std::string& order);

} // namespace talik
