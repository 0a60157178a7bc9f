// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/ranks/Communicator.hpp>
#include <pkg/ranks/PartedFile.hpp>

#include <boost/crc.hpp>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <stdexcept>
#include <unistd.h>

namespace talik {

std::string FilePlace::text() const { return std::to_string(at) + " " + std::to_string(end) + " " + path; }

FilePlace FilePlace::from(const std::string& text)
{
	const std::size_t first = text.find(' '), second = text.find(' ', first + 1);
	return { text.substr(second + 1), std::stoull(text), std::stoull(text.substr(first + 1)) };
}

// ---- checksum -------------------------------------------------------------------------------------------------------------

namespace {
	// a polynomial over bits: the highest one is the coefficient of x^0
	constexpr std::uint64_t one = std::uint64_t(1) << 63, generator = 0xC96C5795D7870F42ULL;

	using Remainder = boost::crc_optimal<64, 0x42F0E1EBA9EA3693ULL, 0, 0, true, true>;

	std::uint64_t product(std::uint64_t a, std::uint64_t b)
	{
		std::uint64_t sum = 0;
		for (std::uint64_t power = one; power != 0; power >>= 1) {
			if (a & power) sum ^= b;
			b = (b >> 1) ^ (b & 1 ? generator : 0);
		}
		return sum;
	}

	/// Remainder of what has this remainder when so many bytes of zero follow it.
	std::uint64_t followedBy(std::uint64_t remainder, std::uint64_t bytes)
	{
		for (std::uint64_t power = one >> 8; bytes != 0; bytes >>= 1, power = product(power, power))
			if (bytes & 1) remainder = product(power, remainder);
		return remainder;
	}
} // namespace

void PartSum::add(const void* data, std::size_t bytes, std::uint64_t follow)
{
	Remainder remainder;
	remainder.process_bytes(data, bytes);
	sum_ ^= followedBy(remainder.checksum(), follow);
}

std::uint64_t PartSum::checksum(std::uint64_t begun, std::uint64_t follow) const { return ~(followedBy(~begun, follow) ^ sum_); }

std::string partWritten(const std::function<void(PartSum&)>& write)
{
	PartSum sum;
	try {
		write(sum);
	} catch (const std::exception& problem) {
		return "!" + std::string(problem.what());
	}
	return "." + std::to_string(sum.value());
}

std::uint64_t sumOfParts(Communicator& communicator, int answerer, const std::string& order)
{
	const auto answers = communicator.order(answerer, order);
	PartSum    sum;
	for (std::size_t rank = 0; rank < answers.size(); ++rank) {
		if (answers[rank][0] == '!') throw std::runtime_error(answers[rank].substr(1) + " on rank " + std::to_string(rank));
		sum.add(std::stoull(answers[rank].substr(1)));
	}
	return sum.value();
}

// ---- file -----------------------------------------------------------------------------------------------------------------

PartedFile::PartedFile(const std::string& path, For what, std::uint64_t end)
        : path_(path)
        , end_(end)
        , descriptor_(::open(path.c_str(), (what == For::reading ? O_RDONLY : O_WRONLY) | O_CLOEXEC))
{
	if (descriptor_ < 0) throw std::runtime_error("'" + path_ + "' cannot be opened (" + std::strerror(errno) + ")");
}

PartedFile::~PartedFile()
{
	if (descriptor_ >= 0) ::close(descriptor_);
}

void PartedFile::write(const void* data, std::size_t bytes, std::uint64_t at)
{
	sum_.add(data, bytes, end_ - at - bytes);
	for (const char* from = static_cast<const char*>(data); bytes > 0;) {
		const ssize_t done = ::pwrite(descriptor_, from, bytes, off_t(at));
		if (done < 0 && errno == EINTR) continue;
		if (done < 0) throw std::runtime_error(std::strerror(errno));
		from += done;
		at += std::uint64_t(done);
		bytes -= std::size_t(done);
	}
}

void PartedFile::read(void* data, std::size_t bytes, std::uint64_t at) const
{
	for (char* to = static_cast<char*>(data); bytes > 0;) {
		const ssize_t done = ::pread(descriptor_, to, bytes, off_t(at));
		if (done < 0 && errno == EINTR) continue;
		if (done <= 0)
			throw std::runtime_error("'" + path_ + "' cannot be read to its end (" + (done < 0 ? std::strerror(errno) : "it is truncated") + ")");
		to += done;
		at += std::uint64_t(done);
		bytes -= std::size_t(done);
	}
}

void PartedFile::close()
{
	const bool written = ::fsync(descriptor_) == 0, closed = ::close(descriptor_) == 0;
	descriptor_ = -1;
	if (!written || !closed) throw std::runtime_error(std::strerror(errno));
}

} // namespace talik
