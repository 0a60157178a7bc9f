// SPDX-License-Identifier: GPL-2.0-or-later
#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/binary_from_base64.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <boost/crc.hpp>
#include <iomanip>
#include <pkg/multiscale/ByteArchive.hpp>
#include <sstream>

namespace talik {
namespace iterators = boost::archive::iterators;

namespace {
	/// Of the text itself: a reader of base64 passes over bits that no byte needs.
	std::string checksumOf(const std::string& text)
	{
		boost::crc_optimal<64, 0x42F0E1EBA9EA3693ULL, ~0ULL, ~0ULL, true, true> checksum;
		checksum.process_bytes(text.data(), text.size());
		std::ostringstream digits;
		digits << std::hex << std::setw(16) << std::setfill('0') << checksum.checksum();
		return digits.str();
	}

	[[noreturn]] void refuseDamage()
	{
		throw std::runtime_error("the saved state is damaged, or of an earlier version of Talik (its checksum does not fit): load an earlier file, or "
		                         "continue it with the version that saved it");
	}
} // namespace

std::string toBase64(const std::string& bytes)
{
	using Encoder = iterators::base64_from_binary<iterators::transform_width<std::string::const_iterator, 6, 8>>;
	// the length in front: base64 alone does not tell how many bits of the last character count
	const std::string body = std::to_string(bytes.size()) + ":" + std::string(Encoder(bytes.begin()), Encoder(bytes.end()));
	return checksumOf(body) + ":" + body;
}

std::string fromBase64(const std::string& text)
{
	using Decoder = iterators::transform_width<iterators::binary_from_base64<std::string::const_iterator>, 8, 6>;
	if (text.find(':') != 16 || text.find(':', 17) == std::string::npos || text.compare(0, 16, checksumOf(text.substr(17))) != 0) refuseDamage();
	const std::size_t length = std::stoull(text.substr(17));
	const std::string body   = text.substr(text.find(':', 17) + 1);
	if (body.size() < (length * 8 + 5) / 6) refuseDamage();
	std::string bytes;
	bytes.reserve(length);
	Decoder next(body.begin());
	for (std::size_t i = 0; i < length; i++)
		bytes.push_back(*next++);
	return bytes;
}

} // namespace talik
