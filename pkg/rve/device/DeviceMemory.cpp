// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <pkg/rve/device/DeviceMemory.hpp>

namespace talik {

DeviceMemory::DeviceMemory(std::shared_ptr<SampleDevice> device, std::function<void(const std::string&)> tells)
        : of(std::move(device))
        , say(std::move(tells))
{}

void DeviceMemory::tell(const std::string& sentence)
{
	if (said.insert(sentence).second && say) say(sentence);
}

void DeviceMemory::lose(const DeviceFailure& failure)
{
	failed = true;
	tell(std::string(failure.what()) + " The run goes on on the processor, from the last good state of every sample and with the same bits.");
}

DeviceMemory::~DeviceMemory()
{
	for (const auto piece : pieces)
		of->release(piece);
	for (const auto& buffer : buffers)
		release(buffer);
}

void DeviceMemory::release(const Buffer& buffer)
{
	if (buffer.address) of->release(buffer.address);
	if (buffer.host) of->releaseOnHost(buffer.host);
}

void DeviceMemory::reserve(std::size_t size, std::size_t wanted)
{
	std::vector<std::uint64_t>& places = free[size];
	if (places.size() >= wanted) return;
	const std::size_t there = of->freeMemory(), fit = there > leftFree ? (there - leftFree) / size : 0;
	const std::size_t more = std::min(wanted - places.size(), fit);
	if (more == 0) return;
	const std::uint64_t piece = of->allocate(more * size);
	pieces.push_back(piece);
	for (std::size_t k = more; k-- > 0;)
		places.push_back(piece + k * size);
}

std::uint64_t DeviceMemory::take(const PlaceLayout& layout)
{
	std::vector<std::uint64_t>& places = free[sizeOf(layout)];
	if (places.empty()) return 0;
	const std::uint64_t place = places.back();
	places.pop_back();
	return place;
}

void DeviceMemory::giveBack(const PlaceLayout& layout, std::uint64_t place)
{
	const std::lock_guard<std::mutex> alone(giving);
	free[sizeOf(layout)].push_back(place);
}

const DeviceMemory::Buffer& DeviceMemory::buffer(std::size_t which, std::size_t bytes)
{
	if (buffers.size() <= which) buffers.resize(which + 1);
	Buffer& kept = buffers[which];
	if (kept.bytes >= bytes) return kept;
	release(kept);
	kept         = {};
	kept.address = of->allocate(bytes + bytes / 4);
	kept.host    = of->allocateOnHost(bytes + bytes / 4);
	kept.bytes   = bytes + bytes / 4;
	return kept;
}

} // namespace talik
