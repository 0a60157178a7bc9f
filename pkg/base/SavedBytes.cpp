// SPDX-License-Identifier: GPL-2.0-or-later
#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/binary_from_base64.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <iomanip>
#include <pkg/base/SavedBytes.hpp>
#include <random>
#include <sstream>
#include <sys/stat.h>
#include <unistd.h>

namespace talik {
namespace iterators = boost::archive::iterators;

namespace {
	/// Of the text itself: a reader of base64 passes over bits that no byte needs.
	std::string checksumOf(const std::string& text)
	{
		Checksum checksum;
		checksum.process_bytes(text.data(), text.size());
		return hexadecimal(checksum.checksum());
	}

	[[noreturn]] void refuseDamage()
	{
		throw std::runtime_error("the saved state is damaged, or of an earlier version of Talik (its checksum does not fit): load an earlier file, or "
		                         "continue it with the version that saved it");
	}
} // namespace

std::string hexadecimal(std::uint64_t value)
{
	std::ostringstream digits;
	digits << std::hex << std::setw(16) << std::setfill('0') << value;
	return digits.str();
}

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
	for (std::size_t i = 0; i < length; ++i)
		bytes.push_back(*++next);
	return bytes;
}

namespace {
	std::string folderOf(const std::string& file)
	{
		const auto folder = std::filesystem::path(file).parent_path();
		return folder.empty() ? "." : folder.string();
	}

	/// Sixteen letters from the system's source of chance.
	std::string unforeseen()
	{
		static const char  letters[] = "abcdefghijklmnopqrstuvwxyz012345";
		std::random_device chance;
		std::string        name;
		for (int i = 0; i < 16; ++i)
			name += letters[chance() % 32];
		return name;
	}

	std::string nameBeside(const std::string& file)
	{
		const auto path = std::filesystem::path(file);
		return (std::filesystem::path(folderOf(file)) / ("." + path.filename().string().substr(0, 100) + "." + unforeseen() + ".part")).string();
	}

	constexpr int attempts = 8;
} // namespace

AtomicFile::AtomicFile(std::string what, std::string file, std::size_t headerLength, bool named)
        : what_(std::move(what))
        , file_(std::move(file))
        , headerLength_(headerLength)
        , buffer_(std::size_t(1) << 20)
{
	std::error_code error;
	std::filesystem::create_directories(folderOf(file_), error);
	if (named) openNamed();
	else open();
	write(std::string(headerLength_, ' ').data(), headerLength_);
	setp(buffer_.data(), buffer_.data() + buffer_.size());
}

AtomicFile::~AtomicFile()
{
	if (descriptor_ >= 0) ::close(descriptor_);
	if (!beside_.empty()) ::unlink(beside_.c_str());
}

void AtomicFile::fail(const std::string& why) const { throw std::runtime_error(what_ + " '" + file_ + "' could not be written: " + why); }

void AtomicFile::open()
{
#ifdef O_TMPFILE
	const bool canBeNamedLater = ::access("/proc/self/fd", X_OK) == 0;
	if (canBeNamedLater) descriptor_ = ::open(folderOf(file_).c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0644);
	if (descriptor_ >= 0) return;
	if (canBeNamedLater && errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT && errno != EINVAL) fail(std::strerror(errno));
#endif
	openNamed();
}

void AtomicFile::openNamed()
{
	for (int attempt = 0; descriptor_ < 0; ++attempt) {
		const std::string name = nameBeside(file_);
		descriptor_            = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
		if (descriptor_ >= 0) beside_ = name;
		else if (errno != EEXIST || attempt == attempts) fail(std::strerror(errno));
	}
}

std::string AtomicFile::path() const { return beside_.empty() ? "/proc/self/fd/" + std::to_string(descriptor_) : beside_; }

void AtomicFile::extend(std::uint64_t bytes)
{
	if (::ftruncate(descriptor_, off_t(headerLength_ + bytes)) != 0) fail(std::strerror(errno));
}

/// A file without a name cannot take the place of another: it gets one first.
void AtomicFile::giveName()
{
	const std::string present = path();
	for (int attempt = 0; beside_.empty(); ++attempt) {
		const std::string name = nameBeside(file_);
		if (::linkat(AT_FDCWD, present.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0) beside_ = name;
		else if (errno != EEXIST || attempt == attempts) fail(std::strerror(errno));
	}
}

void AtomicFile::commit(std::string header)
{
	header.resize(headerLength_, ' ');
	if (!flush()) fail(std::strerror(problem_));
	if (::pwrite(descriptor_, header.data(), headerLength_, 0) != ssize_t(headerLength_) || ::fsync(descriptor_) != 0) fail(std::strerror(errno));
	if (beside_.empty()) giveName();
	const int open = descriptor_;
	descriptor_    = -1;
	if (::close(open) != 0 || std::rename(beside_.c_str(), file_.c_str()) != 0) fail(std::strerror(errno));
	beside_.clear();
	const int folder = ::open(folderOf(file_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
	if (folder < 0) return;
	::fsync(folder); // the new name survives a power failure, too
	::close(folder);
}

AtomicFile::int_type AtomicFile::overflow(int_type c)
{
	if (sync() != 0) return traits_type::eof();
	if (!traits_type::eq_int_type(c, traits_type::eof())) sputc(traits_type::to_char_type(c));
	return traits_type::not_eof(c);
}

int AtomicFile::sync()
{
	const std::size_t length = std::size_t(pptr() - pbase());
	checksum_.process_bytes(pbase(), length);
	bytes_ += length;
	const bool written = write(pbase(), length);
	setp(buffer_.data(), buffer_.data() + buffer_.size());
	return written ? 0 : -1;
}

bool AtomicFile::write(const char* data, std::size_t length)
{
	while (length > 0 && problem_ == 0) {
		const ssize_t done = ::write(descriptor_, data, length);
		if (done < 0 && errno == EINTR) continue;
		if (done < 0) problem_ = errno;
		else data += done, length -= std::size_t(done);
	}
	return problem_ == 0;
}

} // namespace talik
