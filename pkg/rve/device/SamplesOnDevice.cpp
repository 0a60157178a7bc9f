// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <pkg/base/ThreadPool.hpp>
#include <pkg/rve/device/DeviceMemory.hpp>
#include <pkg/rve/device/SampleImage.hpp>
#include <pkg/rve/device/SamplesOnDevice.hpp>
#include <pkg/rve/packed/CellSlip.hpp>

namespace talik {

namespace {
	/// Updates that are computed again at most where a device is lost.
	constexpr std::size_t mostSince = 64;

	/// Time that passes between two readings.
	class Stopwatch {
	public:
		void restart() { last = Clock::now(); }
		void add(double& seconds)
		{
			const auto now = Clock::now();
			seconds += std::chrono::duration<double>(now - last).count();
			last = now;
		}

	private:
		using Clock            = std::chrono::steady_clock;
		Clock::time_point last = Clock::now();
	};

	template <int Dim> typename PackedTypes<Dim>::Matrix matrixOf(const double* numbers)
	{
		typename PackedTypes<Dim>::Matrix m;
		copyMatrix<Dim>(numbers, m);
		return m;
	}

	/// Its bonds are as strong as their material says.
	template <int Dim> PackedSample<Dim>& load(SampleWorker<Dim>& worker, const CompactSample<Dim>& compact)
	{
		worker.ready().setStrengthFactors({});
		return worker.load(compact);
	}
} // namespace

// ---------------------------------------------------------------------------------------------- one sample

template <int Dim>
SampleOnDevice<Dim>::SampleOnDevice(std::shared_ptr<DeviceMemory> of, Compact state)
        : memory(std::move(of))
        , base(std::move(state))
        , now(base->withoutArrays())
{}

template <int Dim> SampleOnDevice<Dim>::~SampleOnDevice()
{
	if (place) memory->giveBack(layout, place);
	if (formerPlace) memory->giveBack(formerLayout, formerPlace);
}

template <int Dim> bool SampleOnDevice<Dim>::fetch(std::vector<unsigned char>& bytes) const
{
	if (spoiled || !place || memory->lost()) return false;
	try {
		bytes.resize(std::size_t(layout.bytes));
		memory->device().copyOut(bytes.data(), place, bytes.size());
		return true;
	} catch (const DeviceFailure& failure) {
		memory->lose(failure);
		bytes.clear();
		return false;
	}
}

template <int Dim> void SampleOnDevice<Dim>::takeInto(PackedSample<Dim>& sample, const std::vector<unsigned char>& bytes)
{
	SampleImage<Dim>(sample).take(layout, bytes, common, now, grains, use, carries);
}

template <int Dim> typename SampleOnDevice<Dim>::Compact SampleOnDevice<Dim>::settled(SampleWorker<Dim>& worker, const std::vector<unsigned char>& bytes)
{
	takeInto(worker.ready(), bytes);
	base = worker.compact();
	since.clear();
	return base;
}

template <int Dim> typename SampleOnDevice<Dim>::Compact SampleOnDevice<Dim>::computedAgain(SampleWorker<Dim>& worker)
{
	load<Dim>(worker, *base);
	for (const Update& update : since)
		worker.sample->update(worker.state, update.displacementGradient, update.iceSaturation, update.options);
	if (!since.empty()) base = worker.compact();
	since.clear();
	now     = base->withoutArrays();
	spoiled = true; // its place holds what nobody knows
	return base;
}

template <int Dim> typename SampleOnDevice<Dim>::Compact SampleOnDevice<Dim>::broughtHome(SampleWorker<Dim>& worker, const std::vector<unsigned char>& bytes)
{
	const std::lock_guard<std::mutex> alone(settling);
	if (since.empty()) return base;
	return bytes.empty() ? computedAgain(worker) : settled(worker, bytes);
}

template <int Dim> double SampleOnDevice<Dim>::longestTimeStep()
{
	if (stepOfIce == now.iceSaturation && !grains->hertz.acts()) return stepKnown;
	thread_local std::vector<double> radii; // its memory is kept
	radii.resize(grains->size());
	std::transform(grains->radius.begin(), grains->radius.end(), radii.begin(), [this](double r) { return r * now.radiusFactor; });
	stepOfIce = now.iceSaturation;
	stepKnown = talik::longestTimeStep<Dim>(now, *grains, { radii.data(), common.largestRadius, common.smallestRadius }, 1);
	return stepKnown;
}

template <int Dim> typename SampleOnDevice<Dim>::Compact SampleOnDevice<Dim>::home()
{
	{
		const std::lock_guard<std::mutex> alone(settling);
		if (since.empty()) return base;
	}
	SampleWorker<Dim>          worker;
	std::vector<unsigned char> bytes;
	fetch(bytes);
	return broughtHome(worker, bytes);
}

// ---------------------------------------------------------------------------------------------- begin

template <int Dim>
SamplesOnDevice<Dim>::SamplesOnDevice(std::shared_ptr<SampleDevice> device, std::function<void(const std::string&)> say)
        : memory(std::make_shared<DeviceMemory>(std::move(device), std::move(say)))
{}
template <int Dim> SamplesOnDevice<Dim>::~SamplesOnDevice() = default;
template <int Dim> bool SamplesOnDevice<Dim>::lost() const { return memory->lost(); }

/// A part is large enough to fill a card.
template <int Dim> std::vector<typename SamplesOnDevice<Dim>::Part> SamplesOnDevice<Dim>::partsOf(std::size_t tasks) const
{
	constexpr std::size_t mostParts = 4, leastOfPart = 1000;
	const std::size_t     number = std::max<std::size_t>(1, std::min(mostParts, tasks / leastOfPart));
	std::vector<Part>     all;
	for (std::size_t k = 0; k < number; ++k)
		all.push_back({ k, tasks * k / number, tasks * (k + 1) / number });
	return all;
}

template <int Dim>
template <class Which, class Work>
void SamplesOnDevice<Dim>::inParallel(std::vector<Task>& tasks, Part part, int threads, Which which, Work work)
{
	chosen.clear();
	for (std::size_t t = part.begin; t < part.end; ++t)
		if (which(tasks[t])) chosen.push_back(&tasks[t]);
	if (chosen.empty()) return;
	const int count = int(chosen.size()), wanted = std::max(1, std::min(threads > 0 ? threads : ThreadPool::threads(), count));
	while (workers.size() < std::size_t(wanted))
		workers.push_back(std::make_unique<Worker>());
	constexpr int piecesOfThread = 16, mostOfPiece = 64; // a piece takes longer than to get it
	const int     each = std::max(1, std::min(mostOfPiece, count / (piecesOfThread * wanted)));
	ThreadPool::run((count + each - 1) / each, wanted, [&](int piece, int member) {
		for (int k = piece * each; k < std::min(count, (piece + 1) * each); ++k)
			work(*chosen[std::size_t(k)], worker(member));
	});
}

/// What is left to the processor and said.
template <int Dim> std::string SamplesOnDevice<Dim>::reasonAgainst(const PackedRequest<Dim>& request, const PackedUpdateOptions& options) const
{
	if (request.creep.acts()) return "ice that creeps";
	if (!(request.strength == BondStrengthFactors()) || request.iceStiffness != 1) return "bonds whose strength or stiffness follows temperature or rate";
	if (options.relaxSteps > 0) return "steps of relaxation";
	return "";
}

template <int Dim> bool SamplesOnDevice<Dim>::makeAway(Task& task, Worker& worker)
{
	PackedSample<Dim>& sample = load<Dim>(worker, *task.home);
	SampleImage<Dim>   image(sample);
	if (auto reason = image.reasonAgainst(); !reason.empty()) {
		task.rare().refusal = std::move(reason);
		return false;
	}
	task.away                 = std::make_shared<SampleOnDevice<Dim>>(memory, task.home);
	SampleOnDevice<Dim>& away = *task.away;
	away.bonded               = image.carriesBonds();
	if (away.now.ice.formsBonds(away.now.iceSaturation, task.request->iceSaturation)) image.makeRoomForBonds();
	away.use        = image.listUse();
	away.layout     = image.layout();
	away.common     = image.call();
	away.grains     = worker.state.grains;
	away.meanRadius = sample.meanRadius();
	task.isNew      = true;
	if (!planCall(task)) return false;
	image.write(away.layout, task.rare().bytes);
	return true;
}

/// Ice saturation after a part of its change.
template <int Dim> double SamplesOnDevice<Dim>::iceAfter(const Task& task, long part) const
{
	return iceAfterPart(task.iceFrom, task.request->iceSaturation, part, task.partsAll);
}

template <int Dim> bool SamplesOnDevice<Dim>::planCall(Task& task)
{
	SampleOnDevice<Dim>& away   = *task.away;
	const double         target = task.request->iceSaturation;
	task.iceFrom                = away.now.iceSaturation;
	task.stepBefore             = away.now.step;
	const long parts            = partsOfIce(task.iceFrom, target, given.saturationIncrement);
	if (parts > 0 ? given.stepsPerSaturation < 1 : task.request->displacementGradient.isZero(0)) return false;
	task.partsAll    = std::int32_t(parts);
	away.carries     = away.bonded;
	const bool bonds = away.bonded || away.now.ice.formsBonds(task.iceFrom, target);
	if (!task.isNew && bonds != (away.layout.bonded != 0)) {
		task.changesPlace = true;
		task.rare().next  = SampleImage<Dim>::layoutOf(away.common.grains, away.common.pairs, bonds, away.layout.hertz != 0);
	}
	return parts > 0 ? planIce(task) : planMotion(task);
}

/// The sample as it is now, without steps.
template <int Dim> SampleCall& SamplesOnDevice<Dim>::newCall(Task& task)
{
	const SampleOnDevice<Dim>& away = *task.away;
	SampleCall&                call = *task.call;
	call                            = away.common;
	call.place                      = away.place;
	copyMatrix<Dim>(away.now.hSize, call.hSize);
	copyMatrix<Dim>(away.now.trsf, call.trsf);
	call.travel  = away.use.travel;
	call.stretch = away.use.stretch;
	call.carries = away.carries;
	return call;
}

/// The next parts of a change of ice, as PackedWorkspace::setIceSaturation has them.
template <int Dim> bool SamplesOnDevice<Dim>::planIce(Task& task)
{
	const SampleOnDevice<Dim>& away   = *task.away;
	const IceBondModel&        model  = away.now.ice;
	PackedThawStrain           thaw   = away.now.thawStrain;
	double                     factor = away.now.radiusFactor, before = away.now.iceSaturation;
	PackedRadiiInAll           radii { away.common.largestRadius, away.common.smallestRadius, away.meanRadius };
	const int                  parts = std::min(mostIceParts, task.partsAll - task.partsDone);
	for (int k = 0; k < parts; ++k) {
		const double now = iceAfter(task, task.partsDone + k + 1);
		if (grainsShrink<Dim>(thaw, factor, before, now)) radii = radiiInAll(*away.grains, factor);
		IcePart& part        = task.parts[k];
		part.iceRatio        = model.iceStiffnessRatio(now);
		part.tensileStrength = model.tensileStrengthAt(now);
		part.shearStrength   = model.shearStrengthAt(now);
		part.radiusFactor    = factor;
		part.largestRadius   = radii.largest;
		part.smallestRadius  = radii.smallest;
		part.meanRadius      = radii.mean;
		part.bondSkin        = 0.5 * bondingReach(model, radii.largest);
		part.melted          = model.melted(now);
		part.forms           = !part.melted && model.formsBondsEver() && model.formsBonds(before, now);
		before               = now;
	}
	const bool  last = task.partsDone + parts == task.partsAll, moves = !task.request->displacementGradient.isZero(0);
	SampleCall& call = newCall(task);
	call.dt          = away.now.dt;
	call.iceParts    = parts;
	call.stepsOfIce  = std::int32_t(given.stepsPerSaturation);
	call.resting     = parts * call.stepsOfIce;
	call.tangent     = given.tangent && last && !moves;
	task.stage       = last && !moves ? Task::begun : Task::ice;
	return true;
}

/// Velocity gradient and steps as SampleUpdate has them.
template <int Dim> bool SamplesOnDevice<Dim>::planMotion(Task& task)
{
	auto&                             away     = *task.away;
	const auto&                       h        = task.request->displacementGradient;
	const double                      rest     = away.now.dt;
	PackedUpdateOptions               ofMotion = task.request->options(given);
	const double                      dt       = ofMotion.timeStepFollowsIce ? timeStepOfMotion(rest, away.longestTimeStep()) : rest;
	typename PackedTypes<Dim>::Matrix rate;
	long                              moving;
	ofMotion.maxStrainPerStep *= dt / rest;
	try {
		moving = movingSteps<Dim>(away.now, dt, away.meanRadius, h, ofMotion);
		rate   = matrixRootIncrement<Dim>(h, moving) / dt;
	} catch (const std::invalid_argument&) {
		return false; // which says so
	}
	SampleCall& call = newCall(task);
	copyMatrix<Dim>(rate, call.velGrad);
	call.norm       = frobenius<Dim>(call.velGrad);
	call.strainRate = strainRate<Dim>(call.velGrad);
	call.dt         = dt;
	call.moving     = std::int32_t(moving);
	call.resting    = std::int32_t(stepsToRest(rest, dt));
	call.tangent    = given.tangent;
	task.stage      = Task::begun;
	return true;
}

template <int Dim> void SamplesOnDevice<Dim>::plan(Task& task, Worker& worker)
{
	const PackedParameters<Dim>& now = task.away ? task.away->now : task.home->withoutArrays();
	if (auto reason = reasonAgainst(*task.request, given); !reason.empty()) {
		task.rare().refusal = std::move(reason);
		return;
	}
	if (task.request->compareRates) return;
	if (task.request->displacementGradient.isZero(0) && task.request->iceSaturation == now.iceSaturation) return;
	if (!now.velGrad.isZero(0) || !now.prevVelGrad.isZero(0) || !now.nextVelGrad.isZero(0)) return;
	const bool stays = task.away && task.mayChange && task.away->place && !task.away->spoiled;
	if (task.away && !stays) return; // it comes home first, and may leave again with the next update
	if (stays ? planCall(task) : makeAway(task, worker)) return;
	if (task.isNew) task.away.reset();
}

/// A place for a sample that is new, or that is brought from its former one by its call. One without bonds may stay where it is.
template <int Dim> bool SamplesOnDevice<Dim>::findPlace(Task& task)
{
	SampleOnDevice<Dim>& away = *task.away;
	const PlaceLayout    next = task.isNew ? away.layout : task.aside->next;
	if (memory->device().memoryOfBlock() < memoryOfBlock(next)) {
		task.rare().refusal = "more grains than a block of this card has memory for";
		return false;
	}
	const auto place = memory->take(next);
	if (!place) return !task.isNew && !next.bonded;
	if (task.isNew) {
		memory->device().copyIn(place, task.aside->bytes.data(), task.aside->bytes.size());
		task.aside->bytes.clear();
	} else {
		away.formerLayout      = away.layout;
		away.formerPlace       = away.place;
		task.call->formerPlace = away.formerPlace;
		task.call->formerPairs = away.formerLayout.pairs;
		away.layout            = next;
	}
	away.place = task.call->place = place;
	return true;
}

template <int Dim> void SamplesOnDevice<Dim>::placeAll(std::vector<Task>& tasks, Part part)
{
	std::map<std::size_t, std::size_t> wanted; // by size
	const auto layoutWanted = [](const Task& task) -> const PlaceLayout& { return task.isNew ? task.away->layout : task.aside->next; };
	const auto needsPlace   = [](const Task& task) { return task.underWay() && (task.isNew || task.changesPlace); };
	for (std::size_t t = part.begin; t < part.end; ++t)
		if (needsPlace(tasks[t])) ++wanted[DeviceMemory::sizeOf(layoutWanted(tasks[t]))];
	for (const auto& [size, number] : wanted)
		memory->reserve(size, number);
	std::size_t without = 0, each = 0;
	for (std::size_t t = part.begin; t < part.end; ++t) {
		Task& task = tasks[t];
		if (!needsPlace(task) || findPlace(task)) continue;
		if (task.rare().refusal.empty()) {
			++without;
			each = std::max(each, std::size_t(layoutWanted(task).bytes));
		}
		task.stage = Task::processor;
		if (task.isNew) task.away.reset();
	}
	if (without && !toldOfMemory)
		memory->tell(
		        std::to_string(without) + " samples find no memory on the device (" + memory->device().name() + "): each takes "
		        + std::to_string(each / 1024)
		        + " KiB. They stay on the processor; end other programs on the card, or take smaller samples or a larger card.");
	toldOfMemory |= without > 0;
}

/// A launch for each layout. Calls and answers lie in the order of the tasks.
template <int Dim> bool SamplesOnDevice<Dim>::launchAll(std::vector<Task>& tasks, Part part, typename Task::Stage stage)
{
	launched           = 0;
	std::size_t number = 0, last = 0;
	bool        iceChanges = false;
	for (std::size_t t = part.begin; t < part.end; ++t) {
		Task& task = tasks[t];
		if (task.stage != stage) continue;
		task.answer = nullptr;
		iceChanges |= task.call->iceParts > 0;
		const PlaceLayout& layout = task.away->layout;
		if (launched == 0 || !(launches[last].layout == layout))
			for (last = 0; last < launched && !(launches[last].layout == layout);)
				++last;
		if (last == launched) {
			if (launched == launches.size()) launches.emplace_back();
			launches[launched].layout = layout;
			launches[launched++].calls.clear();
		}
		launches[last].calls.push_back(std::uint32_t(t));
		++number;
	}
	if (number == 0) return false;
	const std::size_t size = part.end - part.begin;
	std::size_t       at   = part.begin;
	for (std::size_t k = 0; k < launched; ++k)
		for (const std::uint32_t call : launches[k].calls)
			static_cast<std::uint32_t*>(order.host)[at++] = call;
	memory->device().useQueue(part.number);
	memory->device().copyInLater(calls.at<SampleCall>(part.begin), calls.hostAt<SampleCall>(part.begin), size * sizeof(SampleCall));
	if (iceChanges)
		memory->device().copyInLater(
		        ice.at<IcePart>(part.begin * mostIceParts), ice.hostAt<IcePart>(part.begin * mostIceParts), size * mostIceParts * sizeof(IcePart));
	memory->device().copyInLater(order.at<std::uint32_t>(part.begin), order.hostAt<std::uint32_t>(part.begin), number * sizeof(std::uint32_t));
	at = part.begin;
	for (std::size_t k = 0; k < launched; ++k) {
		const Launch&   launch = launches[k];
		KernelArguments arguments {};
		arguments.calls    = reinterpret_cast<const SampleCall*>(calls.address);
		arguments.ice      = reinterpret_cast<const IcePart*>(ice.address);
		arguments.answers  = reinterpret_cast<SampleAnswer*>(answers.address);
		arguments.tangents = reinterpret_cast<double*>(tangents.address);
		arguments.order    = reinterpret_cast<const std::uint32_t*>(order.address) + at;
		arguments.layout   = launch.layout;
		arguments.count    = std::int32_t(launch.calls.size());
		at += launch.calls.size();
		const auto& kernels = sampleKernels();
		const auto  kernel  = std::find_if(kernels.begin(), kernels.end(), [&](const KernelShape& shape) { return shape.holds(launch.layout); });
		memory->device().launch(*kernel, arguments);
	}
	memory->device().copyOutLater(answers.hostAt<SampleAnswer>(part.begin), answers.at<SampleAnswer>(part.begin), size * sizeof(SampleAnswer));
	if (given.tangent) memory->device().copyOutLater(tangents.hostAt<Tangent>(part.begin), tangents.at<Tangent>(part.begin), size * sizeof(Tangent));
	return true;
}

/// The state that a sample has now, on the host.
template <int Dim> void SamplesOnDevice<Dim>::leaveToProcessor(Task& task, Worker& worker)
{
	static const std::vector<unsigned char> none;
	task.stage = Task::processor;
	if (!task.away) return;
	SampleOnDevice<Dim>& away = *task.away;
	task.home                 = away.broughtHome(worker, task.hasBytes() ? task.aside->bytes : none);
	task.away.reset();
}

template <int Dim> void SamplesOnDevice<Dim>::fetch(Task& task)
{
	if (!task.away->fetch(task.rare().bytes)) task.aside->bytes.clear();
}

/// spoiled: what the device holds is worth nothing.
template <int Dim> void SamplesOnDevice<Dim>::forgetBytes(Task& task, bool spoiled)
{
	task.away->spoiled |= spoiled;
	if (task.aside) task.aside->bytes.clear();
}

template <int Dim> void SamplesOnDevice<Dim>::bringHome(std::vector<Task>& tasks, int threads)
{
	const auto stays = [](const Task& task) { return task.stage == Task::processor && task.away; };
	for (Task& task : tasks)
		if (stays(task) && !task.away->since.empty()) fetch(task);
	inParallel(tasks, all(tasks), threads, stays, [this](Task& task, Worker& worker) { leaveToProcessor(task, worker); });
}

/// The host keeps the state of samples that have had many updates on the device, where they stay.
template <int Dim> void SamplesOnDevice<Dim>::settle(std::vector<Task>& tasks, int threads)
{
	for (Task& task : tasks)
		if (task.settles) fetch(task);
	inParallel(
	        tasks, all(tasks), threads, [](const Task& task) { return task.settles && task.hasBytes(); },
	        [](Task& task, Worker& worker) { task.away->settled(worker, task.aside->bytes); });
}

template <int Dim> void SamplesOnDevice<Dim>::awaitAll(std::vector<Task>& tasks, Part part, typename Task::Stage stage)
{
	Stopwatch watch;
	bool      any = false;
	for (std::size_t t = part.begin; t < part.end; ++t) {
		if (tasks[t].stage != stage) continue;
		if (!any) memory->device().waitFor(part.number);
		if (!any) watch.add(went.waiting);
		any              = true;
		tasks[t].answer  = answers.hostAt<SampleAnswer>(t);
		tasks[t].tangent = *tangents.hostAt<Tangent>(t);
	}
	watch.add(went.receiving);
}

/// Parts of a change of ice are done, or have come to a halt. After the last one the motion is planned, with the stress of now.
template <int Dim> void SamplesOnDevice<Dim>::absorbIce(Task& task)
{
	task.stage = Task::halted;
	absorb(task);
	if (task.answer->unsound || task.answer->awaitsBonds || task.iceSteps > 0) return;
	if (task.partsDone < task.partsAll) planIce(task);
	else planMotion(task);
}

template <int Dim> void SamplesOnDevice<Dim>::begin(std::vector<Task>& tasks, const PackedUpdateOptions& options, int threads)
{
	given = options;
	try {
		if (!memory->lost()) {
			Stopwatch         watch;
			const std::size_t count = tasks.size();
			calls                   = memory->buffer(0, count * sizeof(SampleCall));
			answers                 = memory->buffer(1, count * sizeof(SampleAnswer));
			tangents                = memory->buffer(2, given.tangent ? count * sizeof(Tangent) : sizeof(Tangent));
			order                   = memory->buffer(3, count * sizeof(std::uint32_t));
			ice                     = memory->buffer(4, count * mostIceParts * sizeof(IcePart));
			for (std::size_t t = 0; t < count; ++t) {
				tasks[t].call  = calls.hostAt<SampleCall>(t);
				tasks[t].parts = ice.hostAt<IcePart>(t * mostIceParts);
			}
			// changes of ice come first: a part with some waits for them
			parts                 = partsOf(count);
			const auto changesIce = [](const Task& task) { return task.stage == Task::ice; };
			for (const Part& part : parts) {
				inParallel(
				        tasks, part, threads, [](const Task&) { return true; }, [this](Task& task, Worker& worker) { plan(task, worker); });
				watch.add(went.making);
				placeAll(tasks, part);
				while (launchAll(tasks, part, Task::ice)) {
					watch.add(went.sending);
					awaitAll(tasks, part, Task::ice);
					watch.restart();
					inParallel(tasks, part, threads, changesIce, [this](Task& task, Worker&) { absorbIce(task); });
					watch.add(went.making);
				}
				launchAll(tasks, part, Task::begun);
				watch.add(went.sending);
			}
		}
	} catch (const DeviceFailure& failure) {
		memory->lose(failure);
		for (Task& task : tasks)
			if (task.underWay()) {
				task.stage = Task::processor;
				forgetBytes(task, true);
			}
	}
	for (const Task& task : tasks)
		if (task.aside && !task.aside->refusal.empty()) memory->tell("Samples with " + task.aside->refusal + " stay on the processor.");
	bringHome(tasks, threads);
}

// ---------------------------------------------------------------------------------------------- end

/// The parts of a change of ice that have come into force, all of them or those before the device left the rest to the host.
template <int Dim> void SamplesOnDevice<Dim>::absorbParts(Task& task)
{
	SampleOnDevice<Dim>&   away  = *task.away;
	PackedParameters<Dim>& now   = away.now;
	const SampleCall&      call  = *task.call;
	const auto             steps = std::int32_t(task.answer->steps), parts = std::min(call.iceParts, steps / call.stepsOfIce + 1);
	for (int k = 0; k < parts; ++k) {
		const double before = now.iceSaturation;
		now.iceSaturation   = iceAfter(task, ++task.partsDone);
		if (grainsShrink<Dim>(now.thawStrain, now.radiusFactor, before, now.iceSaturation)) away.stepOfIce = -1;
	}
	task.iceSteps               = parts * call.stepsOfIce - steps;
	const IcePart& last         = task.parts[parts - 1];
	away.common.iceRatio        = last.iceRatio;
	away.common.tensileStrength = last.tensileStrength;
	away.common.shearStrength   = last.shearStrength;
	away.common.thawed          = last.melted;
	away.common.largestRadius   = last.largestRadius;
	away.common.smallestRadius  = last.smallestRadius;
	away.common.meanRadius = away.meanRadius = last.meanRadius;
}

/// Parameters and use of the lists as the device has left them.
template <int Dim> void SamplesOnDevice<Dim>::absorb(Task& task)
{
	SampleOnDevice<Dim>&   away   = *task.away;
	const SampleAnswer&    answer = *task.answer;
	const SampleCall&      call   = *task.call;
	PackedParameters<Dim>& now    = away.now;
	using Matrix                  = typename PackedTypes<Dim>::Matrix;
	const long done = long(answer.steps), total = call.moving + call.resting;
	now.hSize     = matrixOf<Dim>(answer.hSize);
	now.prevHSize = matrixOf<Dim>(answer.prevHSize);
	now.trsf      = matrixOf<Dim>(answer.trsf);
	now.step += answer.steps;
	now.bondsBrokenInTension += answer.brokenInTension;
	now.bondsBrokenInShear += answer.brokenInShear;
	task.lists += answer.lists;
	away.use.skin = away.common.skin = answer.skin;
	away.use.travel                  = answer.travel;
	away.use.stretch                 = answer.stretch;
	away.common.pairs                = answer.pairs;
	away.common.inside               = answer.inside;
	away.common.images               = answer.images;
	now.bondsFormed += answer.bondsFormed;
	now.bondsMelted += answer.bondsMelted;
	away.bonded  = answer.bonds > 0;
	away.carries = answer.carries != 0;
	if (away.formerPlace) memory->giveBack(away.formerLayout, away.formerPlace);
	away.formerPlace = 0;
	if (call.iceParts > 0) absorbParts(task);
	if (done < total) {
		now.velGrad = now.prevVelGrad = done > 0 && done - 1 < call.moving ? matrixOf<Dim>(call.velGrad) : Matrix(Matrix::Zero());
		return;
	}
	Matrix stress = matrixOf<Dim>(answer.forces), sum = Matrix::Zero();
	stress /= now.volume();
	sum += stress; // as PackedWorkspace::run sums them
	now.stress = sum / 1.;
}

/// Takes the answer of the device; the task is done where nothing is left to do.
template <int Dim> void SamplesOnDevice<Dim>::take(Task& task)
{
	SampleOnDevice<Dim>&         away   = *task.away;
	const SampleAnswer&          answer = *task.answer;
	const PackedParameters<Dim>& now    = away.now;
	PackedUpdateResult<Dim>&     result = *task.result;
	absorb(task);
	if (long(answer.steps) < task.call->moving + task.call->resting) return;
	if (flipIsDue<Dim>(now.hSize, given.flipSkew) || !isCompact<Dim>(now.hSize)) return;
	const typename PackedTypes<Dim>::Matrix transposed = now.stress.transpose();
	result.stress                                      = 0.5 * (now.stress + transposed);
	result.steps                                       = long(now.step - task.stepBefore);
	result.movingSteps                                 = task.call->moving;
	if (given.tangent) {
		constexpr int products = Dim * (Dim + 1) / 2;
		double        fourth[products * products] {};
		for (int k = 0, at = products; k < products; ++k)
			for (int l = k; l < products; ++l)
				fourth[k * products + l] = task.tangent[at++];
		result.tangent = tangentFromSums<Dim>(task.tangent, fourth, now.stiffnessRatio);
	}
	if (away.since.empty()) away.since.reserve(mostSince);
	away.since.push_back({ task.request->displacementGradient, task.request->iceSaturation, task.request->options(given) });
	task.settles = away.since.size() >= mostSince;
	task.stage   = Task::done;
}

/// What the device leaves to the host: lists that outgrow their place and the steps after them, a flip, a slip.
template <int Dim> void SamplesOnDevice<Dim>::finish(Task& task, Worker& worker)
{
	SampleOnDevice<Dim>&      away    = *task.away;
	PackedSample<Dim>&        sample  = worker.ready();
	const SampleCall&         call    = *task.call;
	const PackedUpdateOptions options = task.request->options(given);
	using Matrix                      = typename PackedTypes<Dim>::Matrix;
	if (!task.hasBytes() || task.answer->unsound) {
		forgetBytes(task, true);
		leaveToProcessor(task, worker);
		return;
	}
	PackedUpdateResult<Dim> result;
	try {
		away.takeInto(sample, task.aside->bytes);
		const long done = long(task.answer->steps), total = call.moving + call.resting;
		long       moving = call.moving;
		if (call.iceParts > 0) {
			if (task.answer->awaitsBonds) sample.bondAll();
			sample.run(task.iceSteps);
			while (task.partsDone < task.partsAll) {
				sample.setIceSaturation(iceAfter(task, ++task.partsDone));
				sample.run(given.stepsPerSaturation);
			}
			moving = SampleUpdate<PackedSample<Dim>>(sample, options).perform(task.request->displacementGradient, sample.iceSaturation());
		} else if (done < total) {
			sample.setTimeStep(call.dt);
			if (done < moving) {
				sample.setNextVelGrad(matrixOf<Dim>(call.velGrad));
				sample.run(moving - done);
			}
			sample.setNextVelGrad(Matrix::Zero());
			sample.run(total - std::max(done, moving));
			sample.setTimeStep(away.now.dt);
		}
		result = sample.conclude(options, moving, task.stepBefore);
	} catch (const std::exception&) { // it has blown up: the processor finds out how
		forgetBytes(task, true);
		leaveToProcessor(task, worker);
		return;
	}
	slipWhereThin<Dim>(sample, task.request->displacementGradient, options, result);
	*task.result = std::move(result);
	task.home    = worker.compact();
	task.away.reset();
	task.stage = Task::done;
}

template <int Dim> void SamplesOnDevice<Dim>::end(std::vector<Task>& tasks, int threads)
{
	const auto underWay = [](const Task& task) { return task.underWay(); };
	if (std::none_of(tasks.begin(), tasks.end(), underWay)) {
		went.left += tasks.size();
		return;
	}
	Stopwatch watch;
	try {
		for (const Part& part : parts) {
			if (memory->lost()) break;
			awaitAll(tasks, part, Task::begun);
			watch.restart();
			inParallel(
			        tasks, part, threads, [](const Task& task) { return task.stage == Task::begun; },
			        [this](Task& task, Worker&) {
				        if (!task.answer->unsound) take(task);
			        });
			watch.add(went.taking);
		}
	} catch (const DeviceFailure& failure) {
		memory->lose(failure);
	}
	watch.restart();
	bool anySettles = false;
	for (Task& task : tasks) {
		anySettles |= task.settles;
		went.done += task.stage == Task::done;
		went.lists += task.lists;
		if (!task.underWay()) continue;
		forgetBytes(task, false);
		if (!memory->lost() && !task.answer->unsound) fetch(task);
	}
	if (anySettles) settle(tasks, threads);
	if (std::any_of(tasks.begin(), tasks.end(), underWay)) {
		inParallel(tasks, all(tasks), threads, underWay, [this](Task& task, Worker& worker) { finish(task, worker); });
		for (const Task& task : tasks)
			went.ended += task.stage == Task::done && !task.away;
	}
	for (const Task& task : tasks)
		went.left += task.stage == Task::processor;
	watch.add(went.taking);
}

TALIK_IN_PLANE_AND_SPACE(SampleOnDevice);
TALIK_IN_PLANE_AND_SPACE(SamplesOnDevice);

} // namespace talik
