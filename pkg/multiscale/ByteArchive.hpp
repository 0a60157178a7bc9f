// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

namespace talik {

/// Appends plain values and blocks to a string of bytes.
class ByteWriter {
public:
	void block(const void* data, std::size_t bytes)
	{
		number(bytes);
		bytes_.append(static_cast<const char*>(data), bytes);
	}
	void               block(const std::string& text) { block(text.data(), text.size()); }
	void               number(std::uint64_t value) { bytes_.append(reinterpret_cast<const char*>(&value), sizeof value); }
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
	std::uint64_t number()
	{
		std::uint64_t value;
		copy(&value, sizeof value);
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
	void block(void* data, std::size_t expected)
	{
		if (number() != expected) throw std::runtime_error("the saved state does not fit this scene: its settings or points have changed");
		copy(data, expected);
	}

private:
	void require(std::size_t length) const
	{
		if (position_ + length > bytes_.size()) throw std::runtime_error("the saved state is truncated");
	}
	void copy(void* data, std::size_t length)
	{
		require(length);
		std::memcpy(data, bytes_.data() + position_, length);
		position_ += length;
	}
	const std::string& bytes_;
	std::size_t        position_ = 0;
};

/// Bytes as text that every archive format takes.
std::string toBase64(const std::string& bytes);
std::string fromBase64(const std::string& text);

} // namespace talik
