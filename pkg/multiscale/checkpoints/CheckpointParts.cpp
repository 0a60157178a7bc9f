// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/checkpoints/CheckpointParts.hpp>

namespace talik {

namespace {
	constexpr std::uint64_t alignment = 8;

	thread_local CheckpointParts*               writingNow = nullptr;
	thread_local const CheckpointParts::Source* readingNow = nullptr;
} // namespace

CheckpointParts*               CheckpointParts::writing() { return writingNow; }
const CheckpointParts::Source* CheckpointParts::reading() { return readingNow; }

CheckpointParts::Writing::Writing(CheckpointParts& parts) { writingNow = &parts; }
CheckpointParts::Writing::~Writing() { writingNow = nullptr; }
CheckpointParts::Reading::Reading(const Source& source) { readingNow = &source; }
CheckpointParts::Reading::~Reading() { readingNow = nullptr; }

std::uint64_t CheckpointParts::add(std::uint64_t bytes, Write write)
{
	parts_.push_back({ bytes_, std::move(write) });
	bytes_ += (bytes + alignment - 1) / alignment * alignment;
	return parts_.back().at;
}

std::uint64_t CheckpointParts::add(std::string bytes)
{
	const std::uint64_t length = bytes.size();
	return add(length, [words = std::move(bytes)](const FilePlace& place) {
		PartedFile file(place.path, PartedFile::For::writing, place.end);
		file.write(words.data(), words.size(), place.at);
		file.close();
		return file.sum().value();
	});
}

std::uint64_t CheckpointParts::write(const FilePlace& first) const
{
	PartSum sum;
	for (const Part& part : parts_)
		sum.add(part.write(first.after(part.at)));
	return sum.value();
}

} // namespace talik
