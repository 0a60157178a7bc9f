// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <pkg/rve/packed/PackedNeighbours.hpp>
#include <pkg/rve/packed/PackedSample.hpp>
#include <pkg/rve/packed/PackedState.hpp>
#include <string>
#include <vector>

namespace talik {

class SampleDevice;
/// How updates of samples went that a device was there for: done on it, ended on the processor, left to the processor.
struct DeviceUse {
	std::size_t done = 0, ended = 0, left = 0;
	std::size_t lists = 0; ///< of neighbours that it has built
	/// Time of the updates on the host [s]: calls are made and sent, the device is waited for, its answers are received and taken.
	double making = 0, sending = 0, waiting = 0, receiving = 0, taking = 0;
};
template <int Dim> class SampleOnDevice;
template <int Dim> class SamplesOnDevice;

/// A sample between two updates: its state, exactly, and the neighbour lists it was left with, in one block of memory. Never changes.
/// Contacts stand in the lists too: which grains they join is held once.
template <int Dim> class CompactSample {
public:
	/// lists: those stored with exactly this state, or nullptr. They are dropped where they do not name the contacts of the state.
	explicit CompactSample(const PackedState<Dim>& state, const PackedLists<Dim>* lists = nullptr);

	/// The state, to the last bit.
	void expand(PackedState<Dim>& state) const;
	/// The lists along with it; false if it has none.
	bool expand(PackedState<Dim>& state, PackedLists<Dim>& lists) const;

	const PackedParameters<Dim>& withoutArrays() const { return parameters; }

	/// Bytes held, the constants of the grains excluded (they are shared).
	std::size_t bytes() const { return sizeof(*this) + capacity; }

private:
	template <class Stream, class State, class Lists> void stream(Stream& stream, State& state, Lists& lists) const;

	PackedParameters<Dim>               parameters;
	std::shared_ptr<const PackedGrains> grains;
	PackedListUse<Dim>                  use {};
	std::uint32_t                       grainCount, contacts, contactsInside = 0, pairs = 0, pairsInside = 0, gaps = 0;
	bool                                bonded, listed;
	std::size_t                         capacity = 0;
	std::unique_ptr<unsigned char[]>    block;
};

/// One sample to be updated.
template <int Dim> struct PackedRequest : IceOfUpdate {
	using Matrix = typename PackedTypes<Dim>::Matrix;
	PackedRequest(std::size_t of = 0, const Matrix& gradient = Matrix::Zero(), double ice = 0)
	        : sample(of)
	        , displacementGradient(gradient)
	        , iceSaturation(ice)
	{}
	std::size_t sample;
	Matrix      displacementGradient;
	double      iceSaturation;
	double      inertialNumber = 0; ///< > 0: bounds the strain of a DEM step of this request in place of the option's [-]
	/// Also follow the request with finer steps, keep that state, and report by how much the coarser one differs: see rateError.
	bool compareRates = false;
	/// Options of this request where these are those of all.
	PackedUpdateOptions options(PackedUpdateOptions ofAll) const
	{
		static_cast<IceOfUpdate&>(ofAll) = *this;
		if (inertialNumber > 0) ofAll.maxInertialNumber = inertialNumber;
		return ofAll;
	}
	/// Calls visit(data, bytes) for all that an update of a sample follows from, but its state.
	template <class Visitor> void forBytes(Visitor&& visit) const
	{
		visit(displacementGradient.data(), sizeof(double) * Dim * Dim);
		visit(&iceSaturation, sizeof(double));
		visit(&inertialNumber, sizeof(double));
		visit(static_cast<const IceOfUpdate*>(this), sizeof(IceOfUpdate)); // numbers, without padding
		visit(&compareRates, sizeof(bool));
	}
};

/// What a thread works with: kept, and decides nothing.
template <int Dim> struct SampleWorker {
	std::unique_ptr<PackedSample<Dim>> sample;
	PackedState<Dim>                   state;
	PackedLists<Dim>                   lists;

	PackedSample<Dim>& ready()
	{
		if (!sample || sample->onOtherPath()) sample = std::make_unique<PackedSample<Dim>>();
		return *sample;
	}
	/// `state` is its state from now on.
	PackedSample<Dim>& load(const CompactSample<Dim>& compact)
	{
		const bool listed = compact.expand(state, lists);
		ready().load(state, listed ? &lists : nullptr);
		return *sample;
	}
	/// The sample as it is now.
	std::shared_ptr<const CompactSample<Dim>> compact()
	{
		sample->store(state, &lists);
		return std::make_shared<const CompactSample<Dim>>(state, &lists);
	}
};

/// Thousands of samples. Samples that were never asked since they were prepared share one state; the first update detaches them.
template <int Dim> class SamplePool {
public:
	using Compact = std::shared_ptr<const CompactSample<Dim>>;

	SamplePool();
	~SamplePool();
	SamplePool(const SamplePool& other);
	SamplePool& operator=(const SamplePool& other);

	/// Adds a sample of this state, which it shares with every other sample it is given to; returns its index.
	std::size_t add(Compact compact);
	/// Adds a sample with a state of its own. Throws std::invalid_argument when the state is unusable.
	std::size_t      add(const PackedState<Dim>& state);
	std::size_t      size() const { return samples.size(); }
	PackedState<Dim> state(std::size_t sample) const;
	/// The same for samples that share one state.
	Compact compact(std::size_t sample) const;
	/// What a state has beside arrays; it asks no device.
	const PackedParameters<Dim>& parameters(std::size_t sample) const;
	void                         setState(std::size_t sample, const PackedState<Dim>& state);
	/// Lets a sample share another's compact state; its own is given up.
	void share(std::size_t sample, Compact compact);
	/// Samples are advanced on a device from now on, those whose bits are the same there; nullptr: on the processor. say: gets sentences for the
	/// user, each once.
	void useDevice(std::shared_ptr<SampleDevice> device, std::function<void(const std::string&)> say);
	/// Since it was chosen; all zero where there is none.
	DeviceUse deviceUse() const;
	/// Bytes of a sample's state on the host.
	std::size_t bytes(std::size_t sample) const;
	void        clear() { samples.clear(); }

	/// Measures of a sample, formed once for each of its states.
	const PackedStatistics<Dim>& statistics(std::size_t sample) const;

	/// Each request's sample, at most once per call. Runs over `threads` OpenMP threads (0: OpenMP's default), each sample whole on
	/// one thread: the results do not depend on their number. Requests that agree bit for bit on the same shared state are computed once
	/// and stay shared. A sample that blows up keeps its last good state. Never more than one state per thread is held twice.
	/// An increment that a sample cannot follow is a blow-up of that sample. Throws std::invalid_argument on an unknown or repeated
	/// sample and on an impossible ice saturation, before anything has changed.
	std::vector<PackedUpdateResult<Dim>> update(const std::vector<PackedRequest<Dim>>& requests, const PackedUpdateOptions& options, int threads = 0);

	/// Distinct states held, and the bytes they and their neighbour lists hold.
	std::size_t distinctStates() const;
	std::size_t bytes() const;

private:
	struct Worker;
	struct Measured {
		std::weak_ptr<const CompactSample<Dim>> of;
		PackedStatistics<Dim>                   statistics;
	};

	/// A sample is at home, or away on a device.
	struct Held {
		Compact                              home;
		std::shared_ptr<SampleOnDevice<Dim>> away;
		const void*                          identity() const { return away ? static_cast<const void*>(away.get()) : home.get(); }
		bool                                 isAlone() const { return (away ? away.use_count() : home.use_count()) == 1; }
	};

	const Held&                           held(std::size_t sample) const;
	std::vector<Held>                     samples;
	std::unique_ptr<SamplesOnDevice<Dim>> device;
	std::vector<std::unique_ptr<Worker>>  workers;
	mutable std::vector<Measured>         measured; ///< empty until somebody asks
	mutable std::unique_ptr<Worker>       measurer;
};

} // namespace talik
