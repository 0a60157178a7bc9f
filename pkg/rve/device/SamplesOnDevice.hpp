// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <functional>
#include <memory>
#include <mutex>
#include <pkg/rve/device/DeviceMemory.hpp>
#include <pkg/rve/device/SampleDevice.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>
#include <string>
#include <vector>

namespace talik {

/// A sample on a device. The host keeps the state that it had when it was last here, and the updates since then: what the device alone knows
/// can be computed again, with the same bits.
template <int Dim> class SampleOnDevice {
public:
	using Compact = std::shared_ptr<const CompactSample<Dim>>;

	SampleOnDevice(std::shared_ptr<DeviceMemory> memory, Compact base);
	~SampleOnDevice();
	SampleOnDevice(const SampleOnDevice&)            = delete;
	SampleOnDevice& operator=(const SampleOnDevice&) = delete;

	/// Parameters of now.
	const PackedParameters<Dim>& parameters() const { return now; }
	/// The state of now: fetched, or where the device is lost computed again. It stays on the device.
	Compact home();
	/// Bytes that the host keeps.
	std::size_t bytes() const { return base->bytes(); }

private:
	template <int> friend class SamplesOnDevice;
	struct Update {
		typename PackedTypes<Dim>::Matrix displacementGradient;
		double                            iceSaturation;
		PackedUpdateOptions               options;
	};
	double longestTimeStep();                              ///< as PackedWorkspace has it, of now
	bool   fetch(std::vector<unsigned char>& bytes) const; ///< false where the device does not know it any more
	void   takeInto(PackedSample<Dim>& sample, const std::vector<unsigned char>& bytes);
	/// The state of now, from the bytes of its place or computed again where there are none. Samples that shared a state may ask at once.
	Compact broughtHome(SampleWorker<Dim>& worker, const std::vector<unsigned char>& bytes);
	Compact settled(SampleWorker<Dim>& worker, const std::vector<unsigned char>& bytes);
	Compact computedAgain(SampleWorker<Dim>& worker);

	std::shared_ptr<DeviceMemory>       memory;
	Compact                             base;
	std::vector<Update>                 since; ///< updates after `base`
	PackedParameters<Dim>               now;
	PackedListUse<Dim>                  use {};
	PlaceLayout                         layout {};
	SampleCall                          common {}; ///< what its calls have in common
	double                              meanRadius = 0;
	double                              stepOfIce = -1, stepKnown = 0; ///< longest time step, of the ice saturation that it is known for
	bool                                bonded  = false;               ///< some pairs are or were bonded
	bool                                carries = false;               ///< the processor would carry bonds in the update of now, of which all may be gone
	std::shared_ptr<const PackedGrains> grains;
	std::uint64_t                       place = 0; ///< 0: none yet
	PlaceLayout                         formerLayout {};
	std::uint64_t                       formerPlace = 0; ///< whence a call under way brings it
	std::mutex                          settling;
	bool                                spoiled = false; ///< the device holds another state than that of now
};

/// Updates of samples on a device, those that it can do with the bits of the processor.
template <int Dim> class SamplesOnDevice {
public:
	using Compact = std::shared_ptr<const CompactSample<Dim>>;
	using Away    = std::shared_ptr<SampleOnDevice<Dim>>;

	/// say: gets each sentence for the user once.
	SamplesOnDevice(std::shared_ptr<SampleDevice> device, std::function<void(const std::string&)> say);
	~SamplesOnDevice();

	/// A request and the sample that it is for, at home or away. There are many, each seen several times in an update: what few of them need
	/// stands aside.
	struct Task {
		const PackedRequest<Dim>* request = nullptr;
		PackedUpdateResult<Dim>*  result  = nullptr; ///< where it goes
		Compact                   home;
		Away                      away;
		/// ice: its change is under way, motion comes after it; halted: it, or what comes after it, is for the host to end.
		enum Stage : std::uint8_t { processor, ice, halted, begun, done } stage = processor;
		bool mayChange                                                          = false; ///< nobody else has the state of a sample that is away
		bool underWay() const { return stage == ice || stage == halted || stage == begun; }

		// while it is under way
		struct Aside {
			std::vector<unsigned char> bytes; ///< of its place
			std::string                refusal;
			PlaceLayout                next {}; ///< of the place that it is brought to
		};
		bool                   isNew        = false;        ///< on the device
		bool                   settles      = false;        ///< the host is to keep its state of now
		bool                   changesPlace = false;        ///< bonds come, or all are gone
		std::int32_t           partsDone = 0, partsAll = 0; ///< of the change of its ice
		std::int32_t           iceSteps   = 0;              ///< that the last of them has still to do
		double                 iceFrom    = 0;
		std::uint32_t          lists      = 0; ///< built there
		std::uint64_t          stepBefore = 0;
		SampleCall*            call       = nullptr; ///< among those of its update
		IcePart*               parts      = nullptr; ///< for its call
		const SampleAnswer*    answer     = nullptr; ///< nullptr while there is none
		const double*          tangent    = nullptr;
		std::unique_ptr<Aside> aside;
		Aside&                 rare()
		{
			if (!aside) aside = std::make_unique<Aside>();
			return *aside;
		}
		bool hasBytes() const { return aside && !aside->bytes.empty(); }
	};
	/// The tasks of an update, to be filled in and to be cleared at its end: their memory is used again.
	std::vector<Task>& tasks() { return kept; }
	/// Begins what the device can do. What it leaves to the processor has its state at home.
	void begin(std::vector<Task>& tasks, const PackedUpdateOptions& options, int threads);
	/// Waits for it. What is done has its result and its sample; the rest goes to the processor, its state at home.
	void             end(std::vector<Task>& tasks, int threads);
	bool             lost() const;
	const DeviceUse& use() const { return went; }

private:
	using Worker = SampleWorker<Dim>;
	/// Calls of one kernel.
	struct Launch {
		PlaceLayout                layout;
		std::vector<std::uint32_t> calls;
	};
	using Buffer = DeviceMemory::Buffer;
	/// Some of the tasks: the device does one part while the host makes the calls of the next.
	struct Part {
		std::size_t number, begin, end;
	};
	std::vector<Part> partsOf(std::size_t tasks) const;
	static Part       all(const std::vector<Task>& tasks) { return { 0, 0, tasks.size() }; }
	using Tangent = double[tangentSums(Dim)];
	std::string                             reasonAgainst(const PackedRequest<Dim>&, const PackedUpdateOptions&) const;
	void                                    plan(Task&, Worker&);
	bool                                    makeAway(Task&, Worker&);
	bool                                    planCall(Task&);
	SampleCall&                             newCall(Task&);
	bool                                    planIce(Task&);
	bool                                    planMotion(Task&);
	void                                    placeAll(std::vector<Task>& tasks, Part);
	bool                                    findPlace(Task&);
	bool                                    launchAll(std::vector<Task>& tasks, Part, typename Task::Stage stage);
	void                                    awaitAll(std::vector<Task>& tasks, Part, typename Task::Stage stage);
	void                                    absorbIce(Task&);
	void                                    absorb(Task&);
	void                                    absorbParts(Task&);
	double                                  iceAfter(const Task&, long part) const;
	void                                    fetch(Task&);
	void                                    forgetBytes(Task&, bool spoiled);
	void                                    leaveToProcessor(Task&, Worker&);
	void                                    bringHome(std::vector<Task>& tasks, int threads);
	void                                    settle(std::vector<Task>& tasks, int threads);
	void                                    take(Task&);
	void                                    finish(Task&, Worker&);
	Worker&                                 worker(int member) { return *workers[std::size_t(member)]; }
	template <class Which, class Work> void inParallel(std::vector<Task>& tasks, Part, int threads, Which which, Work work);

	std::shared_ptr<DeviceMemory>        memory;
	std::vector<std::unique_ptr<Worker>> workers;
	std::vector<Task>                    kept;
	std::vector<Task*>                   chosen;
	std::vector<Launch>                  launches; ///< the first `launched` are under way
	std::size_t                          launched = 0;
	PackedUpdateOptions                  given; ///< of the update under way
	Buffer                               calls, answers, tangents, order, ice;
	std::vector<Part>                    parts; ///< under way
	DeviceUse                            went;
	bool                                 toldOfMemory = false;
};

} // namespace talik
