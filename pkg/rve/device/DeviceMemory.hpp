// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <pkg/rve/device/SampleDevice.hpp>
#include <set>
#include <string>
#include <vector>

namespace talik {

/// Places of samples in the memory of a device, which come from pieces for many, and are used again; and whether the device still answers.
class DeviceMemory {
public:
	/// say: gets each sentence for the user once.
	DeviceMemory(std::shared_ptr<SampleDevice> device, std::function<void(const std::string&)> say);
	~DeviceMemory();
	DeviceMemory(const DeviceMemory&)            = delete;
	DeviceMemory& operator=(const DeviceMemory&) = delete;

	SampleDevice& device() { return *of; }
	bool          lost() const { return failed; }
	void          lose(const DeviceFailure&);
	void          tell(const std::string& sentence);

	/// Size of the place of a sample [bytes]: they come in few, so that the one that a sample leaves fits the next.
	static std::size_t sizeOf(const PlaceLayout& l) { return (std::size_t(l.bytes) + sizeStep - 1) / sizeStep * sizeStep; }
	/// So many free places of this size, or as many as there is memory for.
	void reserve(std::size_t size, std::size_t wanted);
	/// 0: there is none. Taken by one thread; places are given back by any.
	std::uint64_t take(const PlaceLayout&);
	void          giveBack(const PlaceLayout&, std::uint64_t place);

	/// Memory of the device with its like on the host.
	struct Buffer {
		std::uint64_t address = 0;
		void*         host    = nullptr;
		std::size_t   bytes   = 0;

		template <class Item> std::uint64_t at(std::size_t k) const { return address + k * sizeof(Item); }
		template <class Item> Item*         hostAt(std::size_t k) const { return static_cast<Item*>(host) + k; }
	};
	/// For calls or answers, kept until it is asked for anew; which: its number.
	const Buffer& buffer(std::size_t which, std::size_t bytes);

private:
	/// What other programs may need while a run goes on, and what the driver needs itself.
	static constexpr std::size_t leftFree = std::size_t(256) << 20;
	static constexpr std::size_t sizeStep = 16384;
	void                         release(const Buffer&);

	std::shared_ptr<SampleDevice>                     of;
	std::function<void(const std::string&)>           say;
	std::set<std::string>                             said;
	bool                                              failed = false;
	std::map<std::size_t, std::vector<std::uint64_t>> free; ///< by size
	std::mutex                                        giving;
	std::vector<std::uint64_t>                        pieces;
	std::vector<Buffer>                               buffers;
};

} // namespace talik
