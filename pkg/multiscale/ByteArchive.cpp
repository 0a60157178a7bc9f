// SPDX-License-Identifier: GPL-2.0-or-later
#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/binary_from_base64.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <pkg/multiscale/ByteArchive.hpp>

namespace talik {
namespace iterators = boost::archive::iterators;

std::string toBase64(const std::string& bytes)
{
	using Encoder = iterators::base64_from_binary<iterators::transform_width<std::string::const_iterator, 6, 8>>;
	// the length in front: base64 alone does not tell how many bits of the last character count
	return std::to_string(bytes.size()) + ":" + std::string(Encoder(bytes.begin()), Encoder(bytes.end()));
}

std::string fromBase64(const std::string& text)
{
	using Decoder    = iterators::transform_width<iterators::binary_from_base64<std::string::const_iterator>, 8, 6>;
	const auto colon = text.find(':');
	if (colon == std::string::npos) throw std::runtime_error("the saved state is damaged");
	const std::size_t length = std::stoull(text.substr(0, colon));
	const std::string body   = text.substr(colon + 1);
	if (body.size() < (length * 8 + 5) / 6) throw std::runtime_error("the saved state is truncated");
	std::string bytes;
	bytes.reserve(length);
	Decoder next(body.begin());
	for (std::size_t i = 0; i < length; i++)
		bytes.push_back(*next++);
	return bytes;
}

} // namespace talik
