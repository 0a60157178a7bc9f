// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/crc.hpp>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <vector>

namespace talik {

/// Appends plain values, arrays and blocks to a string of bytes.
class ByteWriter {
public:
	void raw(const void* data, std::size_t bytes) { bytes_.append(static_cast<const char*>(data), bytes); }
	void number(std::uint64_t value) { raw(&value, sizeof value); }
	void block(const void* data, std::size_t bytes)
	{
		number(bytes);
		raw(data, bytes);
	}
	void block(const std::string& text) { block(text.data(), text.size()); }
	/// Of plain items without padding.
	template <class T> void array(const std::vector<T>& items)
	{
		number(items.size());
		raw(items.data(), items.size() * sizeof(T));
	}
	const std::string& bytes() const { return bytes_; }

private:
	std::string bytes_;
};

/// Reads them back in the same order. Throws std::runtime_error where the bytes end early or do not fit.
class ByteReader {
public:
	explicit ByteReader(const std::string& bytes)
	        : bytes_(bytes)
	{}
	void raw(void* data, std::size_t length)
	{
		require(length);
		if (length > 0) std::memcpy(data, bytes_.data() + position_, length);
		position_ += length;
	}
	std::uint64_t number()
	{
		std::uint64_t value;
		raw(&value, sizeof value);
		return value;
	}
	std::string block()
	{
		const std::size_t length = number();
		require(length);
		std::string text = bytes_.substr(position_, length);
		position_ += length;
		return text;
	}
	/// A block that is not wanted.
	void pass()
	{
		const std::size_t length = number();
		require(length);
		position_ += length;
	}
	void block(void* data, std::size_t expected)
	{
		if (number() != expected) throw std::runtime_error("the saved state does not fit this scene: its settings or points have changed");
		raw(data, expected);
	}
	template <class T> void array(std::vector<T>& items)
	{
		const std::uint64_t count = number();
		require(count > bytes_.size() ? count : count * sizeof(T));
		items.resize(count);
		raw(items.data(), count * sizeof(T));
	}

	bool atEnd() const { return position_ == bytes_.size(); }

private:
	void require(std::size_t length) const
	{
		if (length > bytes_.size() - position_) throw std::runtime_error("the saved state is truncated");
	}
	const std::string& bytes_;
	std::size_t        position_ = 0;
};

using Checksum = boost::crc_optimal<64, 0x42F0E1EBA9EA3693ULL, ~0ULL, ~0ULL, true, true>;
/// Sixteen digits.
std::string hexadecimal(std::uint64_t value);

/// Bytes as text that every archive format takes.
std::string toBase64(const std::string& bytes);
std::string fromBase64(const std::string& text);

/// Stream buffer of a file that takes the place of another only when it is complete. It has no name until then where the file system
/// knows how to (nothing is left of a process that is killed), else one that cannot be foreseen; neither a file nor a link that is
/// there already is written through or removed. Knows how much went through it and its checksum.
class AtomicFile : public std::streambuf {
public:
	/// what: as the file is called in errors. The first headerLength bytes are left out, for commit(). named: it has a name from the beginning,
	/// by which other processes find it. Throws std::runtime_error.
	AtomicFile(std::string what, std::string file, std::size_t headerLength = 0, bool named = false);
	~AtomicFile() override;

	std::uint64_t bytes() const { return bytes_; }
	std::uint64_t checksum() const { return checksum_.checksum(); }
	/// By which this process can open it meanwhile, and others where it has a name.
	std::string path() const;
	/// So long, with zeros where nobody writes, before others write into it.
	void extend(std::uint64_t bytes);
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
