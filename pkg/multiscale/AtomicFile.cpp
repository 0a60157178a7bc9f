// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/AtomicFile.hpp>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <random>
#include <stdexcept>
#include <sys/stat.h>
#include <unistd.h>

namespace talik {
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
		for (int i = 0; i < 16; i++)
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

AtomicFile::AtomicFile(std::string what, std::string file, std::size_t headerLength)
        : what_(std::move(what))
        , file_(std::move(file))
        , headerLength_(headerLength)
        , buffer_(std::size_t(1) << 20)
{
	std::error_code error;
	std::filesystem::create_directories(folderOf(file_), error);
	open();
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
	for (int attempt = 0; descriptor_ < 0; attempt++) {
		const std::string name = nameBeside(file_);
		descriptor_            = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
		if (descriptor_ >= 0) beside_ = name;
		else if (errno != EEXIST || attempt == attempts) fail(std::strerror(errno));
	}
}

/// A file without a name cannot take the place of another: it gets one first.
void AtomicFile::giveName()
{
	const std::string present = "/proc/self/fd/" + std::to_string(descriptor_);
	for (int attempt = 0; beside_.empty(); attempt++) {
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
