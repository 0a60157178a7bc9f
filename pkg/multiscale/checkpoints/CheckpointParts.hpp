// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/ranks/PartedFile.hpp>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace talik {

/// What follows the archive of the scene in a checkpoint: the numbers of all points and the states of all samples. It is planned while the scene is
/// archived, which one rank does, and written then, by each rank what it has. No rank holds the whole.
class CheckpointParts {
public:
	/// Writes a part to its place, on all ranks; returns what it adds to the sum of the file.
	using Write = std::function<std::uint64_t(const FilePlace&)>;
	/// Takes place for a part. Returns where, counted from the first one.
	std::uint64_t add(std::uint64_t bytes, Write write);
	/// The same of bytes that are here.
	std::uint64_t add(std::string bytes);

	std::uint64_t bytes() const { return bytes_; }
	/// Returns what all add to the sum of the file, of which the first begins at the place.
	std::uint64_t write(const FilePlace& first) const;

	/// Where the parts of a checkpoint that is read are.
	struct Source {
		std::shared_ptr<const PartedFile> file;
		std::uint64_t                     at = 0;
	};

	/// What is being written, and read, while these live; null in a scene that is archived otherwise, as by O.save.
	static CheckpointParts* writing();
	static const Source*    reading();
	class Writing {
	public:
		explicit Writing(CheckpointParts& parts);
		~Writing();
	};
	class Reading {
	public:
		explicit Reading(const Source& source);
		~Reading();
	};

private:
	struct Part {
		std::uint64_t at;
		Write         write;
	};
	std::vector<Part> parts_;
	std::uint64_t     bytes_ = 0;
};

} // namespace talik
