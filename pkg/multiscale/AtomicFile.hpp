// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/crc.hpp>
#include <cstdint>
#include <streambuf>
#include <string>
#include <vector>

namespace talik {

using Checksum = boost::crc_optimal<64, 0x42F0E1EBA9EA3693ULL, ~0ULL, ~0ULL, true, true>;

/// Stream buffer of a file that takes the place of another only when it is complete. It has no name until then where the file system
/// knows how to (nothing is left of a process that is killed), else one that cannot be foreseen; neither a file nor a link that is
/// there already is written through or removed. Knows how much went through it and its checksum.
class AtomicFile : public std::streambuf {
public:
	/// what: as the file is called in errors. The first headerLength bytes are left out, for commit(). Throws std::runtime_error.
	AtomicFile(std::string what, std::string file, std::size_t headerLength = 0);
	~AtomicFile() override;

	std::uint64_t bytes() const { return bytes_; }
	std::uint64_t checksum() const { return checksum_.checksum(); }
	/// errno of the first write that failed, 0 if none did.
	int  problem() const { return problem_; }
	bool flush() { return sync() == 0; }

	/// Puts the header in its place, waits for the disk, and lets the file take the place of the former one.
	void commit(std::string header = "");

	[[noreturn]] void fail(const std::string& why) const;

protected:
	int_type overflow(int_type c) override;
	int      sync() override;

private:
	void open();
	void openNamed();
	void giveName();
	bool write(const char* data, std::size_t length);

	std::string       what_, file_;
	std::string       beside_; ///< empty while the file has no name
	std::size_t       headerLength_;
	std::vector<char> buffer_;
	int               descriptor_ = -1, problem_ = 0;
	std::uint64_t     bytes_ = 0;
	Checksum          checksum_;
};

} // namespace talik
