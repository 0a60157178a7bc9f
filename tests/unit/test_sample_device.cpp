// SPDX-License-Identifier: GPL-2.0-or-later
// Packed samples on a device, held against those on the processor to the last bit. The device is the twin of a card.
#include "packedStarts.hpp"

#include <pkg/multiscale/samples/PackedStore.hpp>
#include <pkg/rve/device/SampleDevice.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>
#include <tests/card/SampleReplay.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

using namespace talik;
using namespace packedStarts;

namespace {

template <int Dim> PackedState<Dim> frozen(double iceSaturation) { return frozenOf<Dim>(thawed<Dim>(), iceSaturation, 20); }

/// A shear with a swing of its volume, in the plane x y.
template <int Dim> typename PackedTypes<Dim>::Matrix increment(double shear, double swing)
{
	typename PackedTypes<Dim>::Matrix m = PackedTypes<Dim>::Matrix::Zero();
	m(0, 0)                             = swing;
	m(0, 1)                             = shear;
	m(1, 1)                             = -2 * swing;
	return m;
}

template <int Dim> bool sameBits(const PackedState<Dim>& a, const PackedState<Dim>& b) { return a.toBytes() == b.toBytes(); }

template <int Dim> void expectSame(const PackedUpdateResult<Dim>& a, const PackedUpdateResult<Dim>& b, const std::string& where)
{
	EXPECT_EQ(std::memcmp(a.stress.data(), b.stress.data(), sizeof(double) * Dim * Dim), 0) << where << ": stress";
	EXPECT_EQ(a.steps, b.steps) << where;
	EXPECT_EQ(a.movingSteps, b.movingSteps) << where;
	EXPECT_EQ(a.flipped, b.flipped) << where;
	EXPECT_EQ(a.slipped, b.slipped) << where;
	EXPECT_EQ(a.blewUp, b.blewUp) << where;
	EXPECT_EQ(a.reason, b.reason) << where;
	EXPECT_TRUE(a.tangent == b.tangent) << where << ": tangent";
}

/// What a run does to its samples in a round: shear and swing [-], ice saturation.
struct Round {
	double shear, swing, ice;
};

using Said = std::vector<std::string>;

/// Two pools go through the rounds, one with a device; its samples are read now and then, which must not matter.
template <int Dim>
DeviceUse expectSameRun(
        const std::vector<PackedState<Dim>>& starts, int rounds, std::shared_ptr<SampleDevice> device, const std::function<Round(int round, int sample)>& of,
        const std::string& title, int readEvery, std::size_t leastDone, int deviceEvery = 0, Said* heard = nullptr)
{
	SamplePool<Dim> processor, away;
	Said            said;
	const auto      say = [&](const std::string& sentence) { said.push_back(sentence); };
	away.useDevice(device, say);
	for (const auto& start : starts)
		for (SamplePool<Dim>* pool : { &processor, &away })
			pool->add(start);
	PackedUpdateOptions options;
	options.maxInertialNumber = 2e-2;
	options.maxStrainPerStep  = 1e-4;
	options.tangent           = true;
	long steps                = 0;
	for (int round = 0; round < rounds; ++round) {
		if (deviceEvery && round > 0 && round % deviceEvery == 0) away.useDevice(round / deviceEvery % 2 ? nullptr : device, say);
		std::vector<PackedRequest<Dim>> requests;
		for (std::size_t s = 0; s < starts.size(); ++s) {
			const Round asked = of(round, int(s));
			requests.push_back({ s, increment<Dim>(asked.shear, asked.swing), asked.ice });
		}
		const auto a = processor.update(requests, options, 1), b = away.update(requests, options, 3);
		for (std::size_t s = 0; s < starts.size(); ++s) {
			expectSame<Dim>(a[s], b[s], title + ", round " + std::to_string(round) + ", sample " + std::to_string(s));
			steps += a[s].steps;
		}
		if (readEvery && round % readEvery == readEvery - 1) {
			for (std::size_t s = 0; s < starts.size(); ++s)
				EXPECT_TRUE(sameBits<Dim>(processor.state(s), away.state(s))) << title << ", round " << round << ", sample " << s;
		}
		if (::testing::Test::HasFailure()) {
			ADD_FAILURE() << title << ", round " << round;
			return away.deviceUse();
		}
	}
	unsigned long broken = 0;
	for (std::size_t s = 0; s < starts.size(); ++s) {
		EXPECT_TRUE(sameBits<Dim>(processor.state(s), away.state(s))) << title << ", sample " << s;
		const auto state = processor.state(s);
		broken += (unsigned long)(state.bondsBrokenInTension + state.bondsBrokenInShear);
	}
	for (const auto& sentence : said)
		std::printf("said: %s\n", sentence.c_str());
	if (heard) *heard = said;
	const DeviceUse use = away.deviceUse();
	std::printf(
	        "%s: %d updates of %zu samples, %ld steps, %lu bonds broken: bit-equal with and without %s; %zu updates and %zu neighbour lists there, "
	        "%zu of them ended on the processor, %zu left to it\n",
	        title.c_str(), rounds, starts.size(), steps, broken, device->name().c_str(), use.done + use.ended, use.lists, use.ended, use.left);
	EXPECT_GE(use.done + use.ended, leastDone);
	return use;
}

template <int Dim> void expectSameWhateverHappens(const std::shared_ptr<SampleDevice>& device)
{
	const std::vector<PackedState<Dim>> two { thawed<Dim>(), thawed<Dim>() }, ofIce { frozen<Dim>(0.1), frozen<Dim>(0.2) };
	expectSameRun<Dim>(
	        two, 30, device,
	        [](int r, int s) {
		        return Round { 2e-3 * (s + 1), 1e-4 * std::sin(r), 0 };
	        },
	        "thawed", 7, 20);
	expectSameRun<Dim>(
	        ofIce, 30, device,
	        [](int r, int s) {
		        return Round { 1e-3, 3e-4 * std::sin(r), s ? 0.2 : 0.1 };
	        },
	        "frozen, bonds breaking", 11, 20);
	const auto melting = expectSameRun<Dim>(
	        ofIce, 40, device,
	        [](int r, int s) {
		        const double from = s ? 0.2 : 0.1,
		                     ice  = r < 8 ? from
		                 : r < 16         ? from * (15 - r) / 8.
		                 : r < 24         ? 0
		                 : r < 32         ? from * (r - 23) / 8.
		                                  : from;
		        return Round { r % 4 ? 5e-4 : 0., r % 4 ? 1e-4 * std::sin(r) : 0., ice };
	        },
	        "thawing and refreezing", 13, 20);
	constexpr std::size_t nothingAsked = 12; // at rest, with the ice as it is
	std::printf("thawing and refreezing: %zu updates left or ended, of which nothing was asked in %zu\n", melting.left + melting.ended, nothingAsked);
	EXPECT_EQ(melting.left + melting.ended, nothingAsked) << "bonds melt and form on the device";
	expectSameRun<Dim>(
	        ofIce, 24, device,
	        [](int r, int s) {
		        return Round { r % 5 ? 3e-4 : 0., r % 5 ? 1e-4 * std::sin(r) : 0., (s ? 0.2 : 0.1) + 0.008 * std::sin(r) };
	        },
	        "ice that comes and goes a little", 7, 40);
	expectSameRun<Dim>(
	        ofIce, 24, device,
	        [](int r, int s) {
		        return Round { 1e-3, 3e-4 * std::sin(r), s ? 0.2 : 0.1 };
	        },
	        "device changed every third time", 0, 0, 3);
	expectSameRun<Dim>(
	        two, Dim == 2 ? 40 : 20, device,
	        [](int r, int s) {
		        return Round { 3e-2, (s ? 1e-2 : 1e-3) * std::cos(r), 0 };
	        },
	        "cells that turn and become thin", 0, 0);
	std::vector<PackedState<Dim>> swelling { frozen<Dim>(0.3) };
	swelling[0].thawStrain.thawStrain = 0.1;
	const auto shrinking              = expectSameRun<Dim>(
                swelling, 30, device,
                [](int r, int) {
                        return Round { 5e-4, 0, std::max(0., 0.3 - 0.02 * (r / 2)) };
                },
                "grains that shrink on thaw", 0, 5);
	EXPECT_EQ(shrinking.left, 0u) << "grains shrink on the device";
	std::vector<PackedState<Dim>> wild { thawed<Dim>(), thawed<Dim>() };
	wild[0].dt *= 40;
	SamplePool<Dim> processor, away;
	away.useDevice(device, nullptr);
	for (SamplePool<Dim>* pool : { &processor, &away }) {
		pool->add(wild[0]);
		pool->add(wild[1]);
	}
	const std::vector<PackedRequest<Dim>> requests { { 0, increment<Dim>(1e-3, 0), 0. }, { 1, increment<Dim>(1e-3, 0), 0. } };
	const auto                            a = processor.update(requests, {}, 1), b = away.update(requests, {}, 1);
	for (int s = 0; s < 2; ++s)
		expectSame<Dim>(a[s], b[s], "a sample that blows up beside another");
	EXPECT_TRUE(a[0].blewUp);
	EXPECT_TRUE(sameBits<Dim>(processor.state(0), away.state(0)));
}

bool speaksOf(const Said& said, const std::string& words)
{
	return std::any_of(said.begin(), said.end(), [&](const std::string& sentence) { return sentence.find(words) != std::string::npos; });
}

/// The driver of the tests, which does what it is told to.
std::shared_ptr<SampleDevice> stub(const std::string& wishes)
{
	setenv("TALIK_CUDA_DRIVER", TALIK_STUB_DRIVER_FILE, 1);
	setenv("TALIK_STUB_DRIVER", wishes.c_str(), 1);
	return openCard();
}

std::string refusal(const std::string& wishes)
{
	try {
		stub(wishes);
	} catch (const DeviceFailure& failure) {
		std::printf("%s: %s\n", wishes.c_str(), failure.what());
		return failure.what();
	}
	return "";
}

} // namespace

TEST(SampleDevice, discsHaveTheBitsOfTheProcessorThawedFrozenBreakingAndRefreezing) { expectSameWhateverHappens<2>(makeTwin()); }

namespace {
template <int Dim> void expectSameOfHertz(const std::shared_ptr<SampleDevice>& device)
{
	const auto start = hertzian<Dim>(thawed<Dim>());
	const auto of    = [](int r, int s) {
                const double ice = s == 0 || r < 6 ? 0 : r < 12 ? 0.05 * (r - 5) : r < 18 ? 0.05 * (17 - r) : 0;
                return Round { 1e-3, 3e-4 * std::sin(r), ice };
	};
	const auto use = expectSameRun<Dim>({ start, start }, 30, device, of, "grains of Hertz and Mindlin, thawed, freezing and thawing", 5, 40);
	EXPECT_EQ(use.left, 0u);
	EXPECT_GT(use.lists, std::size_t(10));
}
} // namespace

TEST(SampleDevice, grainsOfHertzAndMindlinHaveTheBitsOfTheProcessorThroughFreezingAndThawing)
{
	expectSameOfHertz<2>(makeTwin());
	expectSameOfHertz<3>(makeTwin());
}

TEST(SampleDevice, spheresHaveTheBitsOfTheProcessorThawedFrozenBreakingAndRefreezing) { expectSameWhateverHappens<3>(makeTwin()); }

namespace {

/// Shear until lists are used up many times and the cell is flipped.
template <int Dim> void expectSameThroughManyLists(const std::shared_ptr<SampleDevice>& device, double shear, int rounds, std::size_t leastLists)
{
	const auto of  = [shear](int r, int s) { return Round { shear, 0.1 * shear * std::sin(r), s < 2 ? 0. : 0.1 }; };
	const auto use = expectSameRun<Dim>(
	        { thawed<Dim>(), tiled<Dim>(thawed<Dim>(), { 2, 1, 1 }), frozen<Dim>(0.1) }, rounds, device, of, "lists built many times", 9, 1);
	std::printf(
	        "sheared by %.2g: %.3g lists an update, %.3g of the updates ended on the processor (flips, thin cells, lists that outgrow their place; "
	        "0.15 allowed)\n",
	        shear * rounds, double(use.lists) / double(use.done + use.ended), double(use.ended) / double(use.done + use.ended));
	EXPECT_GE(use.lists, leastLists);
	EXPECT_LT(double(use.ended), 0.15 * double(use.done + use.ended));
}

/// Bonds that do not break are stretched wider than the lists reach.
template <int Dim> void expectSameWhereBondsStretch(const std::shared_ptr<SampleDevice>& device)
{
	PackedState<Dim> strong       = frozen<Dim>(0.3);
	strong.ice.iceTensileStrength = strong.ice.iceShearStrength = 1e12;
	const auto use                                              = expectSameRun<Dim>(
                { strong }, 6, device,
                [](int, int) {
                        return Round { 1e-3, 5e-3, 0.3 };
                },
                "bonds stretched beyond the lists", 2, 1);
	EXPECT_GT(use.lists, std::size_t(1));
}

} // namespace

TEST(SampleDevice, neighbourListsAreBuiltThereAndTheBitsAreThoseOfTheProcessor)
{
	expectSameThroughManyLists<2>(makeTwin(), 1e-2, 80, 300); // cells are flipped, and the host keeps a state
	expectSameThroughManyLists<3>(makeTwin(), 1e-2, 20, 60);
	expectSameWhereBondsStretch<2>(makeTwin());
	expectSameWhereBondsStretch<3>(makeTwin());
}

TEST(SampleDevice, cardThatIsAbsentTooOldOrHiddenIsRefusedByASentenceWithARemedy)
{
	EXPECT_NE(refusal("none").find("CUDA_ERROR_NO_DEVICE"), std::string::npos);
	EXPECT_NE(refusal("none").find("nvidia-smi"), std::string::npos);
	EXPECT_NE(refusal("capability 52").find("compute capability 5.2; the kernels need 7.0"), std::string::npos);
	EXPECT_NE(refusal("fail cuModuleLoadDataEx 1 222").find("install a newer nvidia-driver"), std::string::npos);
	EXPECT_NE(refusal("fail cuDevicePrimaryCtxRetain 1 46").find("Another program has it for itself"), std::string::npos);
	setenv("TALIK_CUDA_DRIVER", "/nowhere/libcuda.so.1", 1);
	Said said;
	EXPECT_EQ(deviceNamed("gpu", [&](const std::string& sentence) { said.push_back(sentence); }), nullptr);
	ASSERT_EQ(said.size(), 1u);
	std::printf("no driver: %s\n", said[0].c_str());
	EXPECT_TRUE(speaksOf(said, "nvidia-driver")) << said[0];
	EXPECT_TRUE(speaksOf(said, "The run goes on on the processor"));
	EXPECT_EQ(deviceNamed("auto", [&](const std::string& sentence) { said.push_back(sentence); }), nullptr);
	EXPECT_EQ(deviceNamed("cpu", nullptr), nullptr);
	EXPECT_EQ(said.size(), 1u) << "auto says nothing where there is no card";
	EXPECT_THROW(deviceNamed("cuda", nullptr), std::invalid_argument);
}

TEST(SampleDevice, cardThatFailsAtAnyCallOfItsDriverLeavesTheRunItsBits)
{
	const std::vector<PackedState<2>> starts { frozen<2>(0.1), thawed<2>(), frozen<2>(0.2), thawed<2>(), frozen<2>(0.1), thawed<2>() };
	const auto of = [](int r, int s) { return Round { 1e-3, 3e-4 * std::sin(r), s % 2 ? 0. : s == 2 ? 0.2 - 0.01 * (r % 4) : 0.1 + 0.01 * (r % 3) }; };
	expectSameRun<2>(starts, 12, stub(""), of, "driver that works", 5, 20);
	for (const char* function : { "cuMemGetInfo_v2", "cuMemAlloc_v2", "cuMemHostAlloc", "cuMemcpyHtoD_v2", "cuMemcpyHtoDAsync_v2", "cuLaunchKernel",
	                              "cuMemcpyDtoHAsync_v2", "cuStreamCreate", "cuStreamSynchronize", "cuMemcpyDtoH_v2" })
		for (const int at : { 1, 2, 5, 16 }) {
			const std::string wishes = "fail " + std::string(function) + " " + std::to_string(at) + " 719";
			Said              said;
			expectSameRun<2>(starts, 12, stub(wishes), of, wishes, 5, 0, 0, &said);
			EXPECT_TRUE(at > 1 || speaksOf(said, "CUDA_ERROR_LAUNCH_FAILED")) << wishes;
			EXPECT_TRUE(at > 1 || speaksOf(said, "The run goes on on the processor")) << wishes;
			EXPECT_LE(said.size(), 1u) << "said once";
		}
}

TEST(SampleDevice, samplesThatStayLongAreKeptByTheHostNowAndThenAndSurviveTheLossOfTheCard)
{
	const auto of = [](int r, int s) { return Round { 1e-5, 1e-6 * std::sin(r), s ? 0.1 : 0. }; };
	for (const char* wishes : { "", "fail cuLaunchKernel 200 719" }) {
		const auto use = expectSameRun<2>({ thawed<2>(), frozen<2>(0.1) }, 140, stub(wishes), of, "samples that stay", 0, 100);
		EXPECT_EQ(use.ended, 0u);
	}
}

TEST(SampleDevice, thousandsOfSamplesGoInSeveralPartsWithTheBitsOfTheProcessor)
{
	const std::vector<PackedState<2>> starts(2100, thawed<2>());
	const auto                        of = [](int r, int s) { return Round { 1e-6 * (s % 7), 1e-7 * r, 0 }; };
	expectSameRun<2>(starts, 1, makeTwin(), of, "two parts", 0, 1500);
	expectSameRun<2>(starts, 2, stub("fail cuStreamSynchronize 4 719"), of, "two parts, the last of which is lost", 0, 2000);
}

TEST(SampleDevice, cardWithTooLittleMemoryTakesWhatFitsAndSaysSo)
{
	std::vector<PackedState<2>> starts;
	for (int s = 0; s < 6; ++s)
		starts.push_back(thawed<2>());
	Said said;
	// 256 MiB stay free for the driver and others; a place of these samples takes some 10 KiB
	expectSameRun<2>(
	        starts, 8, stub("memory " + std::to_string((std::size_t(256) << 20) + 70000)),
	        [](int r, int s) {
		        return Round { 1e-3 + 1e-4 * s, 1e-4 * std::sin(r), 0 };
	        },
	        "memory for a few samples", 3, 4, 0, &said);
	EXPECT_TRUE(speaksOf(said, "find no memory on the device"));
	EXPECT_EQ(said.size(), 1u);
}

TEST(SampleDevice, samplesThatCardsKnowNoLawOfStayOnTheProcessorWhichIsSaidOnce)
{
	SamplePool<2> processor, away;
	Said          said;
	away.useDevice(makeTwin(), [&](const std::string& sentence) { said.push_back(sentence); });
	PackedState<2> rolling = thawed<2>();
	auto           grains  = std::make_shared<PackedGrains>(*rolling.grains);
	grains->rolling        = { 0.5, 0.3 };
	rolling.grains         = grains;
	rolling.contacts.moment.assign(rolling.contacts.size(), 0.);
	for (SamplePool<2>* pool : { &processor, &away }) {
		pool->add(rolling);
		pool->add(frozen<2>(0.2));
	}
	for (int round = 0; round < 4; ++round) {
		std::vector<PackedRequest<2>> requests { { 0, increment<2>(1e-3, 0), 0. }, { 1, increment<2>(1e-3, 0), 0.2 } };
		if (round % 2) requests[1].creep = { 1e-13, 3. };
		if (round == 2) requests[1].strength = { 1.1, 1.2 };
		const auto a = processor.update(requests, {}, 1), b = away.update(requests, {}, 1);
		for (int s = 0; s < 2; ++s) {
			expectSame<2>(a[s], b[s], "round " + std::to_string(round) + ", sample " + std::to_string(s));
			EXPECT_TRUE(sameBits<2>(processor.state(s), away.state(s)));
		}
	}
	for (const auto& sentence : said)
		std::printf("said: %s\n", sentence.c_str());
	EXPECT_TRUE(speaksOf(said, "grains that resist rolling"));
	EXPECT_TRUE(speaksOf(said, "ice that creeps"));
	EXPECT_TRUE(speaksOf(said, "follows temperature or rate"));
	EXPECT_EQ(said.size(), 3u);
}

TEST(SampleDevice, samplesThatShareAStatePartOnTheDeviceAsTheyDoOnTheProcessor)
{
	const auto    shared = std::make_shared<const CompactSample<2>>(frozen<2>(0.1));
	SamplePool<2> processor, away;
	away.useDevice(makeTwin(), nullptr);
	for (SamplePool<2>* pool : { &processor, &away })
		for (int s = 0; s < 6; ++s)
			pool->add(shared);
	for (int round = 0; round < 9; ++round) {
		std::vector<PackedRequest<2>> requests;
		for (std::size_t s = 0; s < 6; ++s)
			if (round < 3 || s != 2)
				requests.push_back({ s, increment<2>(s < 3 || round < 2 ? 1e-3 : 2e-3, round < 6 ? 0 : 1e-5 * double(s)), 0.1 });
		const auto a = processor.update(requests, {}, 2), b = away.update(requests, {}, 2);
		for (std::size_t r = 0; r < requests.size(); ++r)
			expectSame<2>(a[r], b[r], "round " + std::to_string(round));
		EXPECT_EQ(processor.distinctStates(), away.distinctStates()) << "round " << round;
	}
	for (std::size_t s = 0; s < 6; ++s)
		EXPECT_TRUE(sameBits<2>(processor.state(s), away.state(s))) << "sample " << s;
}

TEST(SampleDevice, stressesTangentsAndFabricsOfManyUpdatesHaveTheBitsOfTheProcessor)
{
	constexpr std::size_t samples = 7;
	const auto            store   = [](const std::shared_ptr<SampleDevice>& device) {
                auto held = std::make_shared<PackedStore<2>>(std::vector<PackedStore<2>::StatePointer> { std::make_shared<PackedState<2>>(thawed<2>()) });
                held->useDevice(device, nullptr);
                return held;
	};
	const auto follow = [](SampleStoreOf<2>& all) {
		std::vector<double> numbers;
		PackedUpdateOptions options;
		options.tangent = true;
		for (std::size_t s = 0; s < samples; ++s)
			all.add(0, s % 2 ? 0.3 : 0., options);
		for (int turn = 0; turn < 25; ++turn) {
			std::vector<PackedRequest<2>> requests;
			for (std::size_t s = 0; s < samples; ++s)
				if (turn % 3 == 0 || s < 4)
					requests.push_back({ s, increment<2>(1e-4 * double(s + 1), 1e-5 * std::sin(turn)), s % 2 ? 0.3 : 0. });
			for (const auto& result : all.update(requests, options, 1)) {
				numbers.insert(numbers.end(), result.stress.data(), result.stress.data() + 4);
				numbers.insert(numbers.end(), result.tangent.begin(), result.tangent.end());
			}
		}
		for (const auto& row : all.measureAll("fabric"))
			numbers.insert(numbers.end(), row.begin(), row.end());
		return numbers;
	};
	const std::vector<double> one   = follow(*store(nullptr));
	const auto                alone = store(makeTwin());
	EXPECT_TRUE(follow(*alone) == one);
	std::printf("%zu numbers of one processor, and of one device (%zu calls there)\n", one.size(), alone->deviceUse().done);
	EXPECT_GT(alone->deviceUse().done, 10u);
}

namespace {

/// Samples of every size that has a kernel.
template <int Dim> void expectSameAtAllSizes(const std::shared_ptr<SampleDevice>& device, int rounds)
{
	const std::vector<std::array<int, 3>> discs { { 1, 1, 1 }, { 2, 1, 1 }, { 2, 2, 1 } };
	const std::vector<std::array<int, 3>> spheres { { 1, 1, 1 }, { 2, 1, 1 }, { 2, 2, 1 }, { 3, 2, 1 }, { 2, 2, 2 } };
	for (const auto& times : Dim == 2 ? discs : spheres) {
		const PackedState<Dim> start = tiled<Dim>(thawed<Dim>(), times);
		expectSameRun<Dim>(
		        { start, frozenOf<Dim>(start, 0.2) }, rounds, device,
		        [](int r, int s) {
			        return Round { 1e-3, 1e-4 * std::sin(r), s ? 0.2 : 0. };
		        },
		        std::to_string(start.size()) + (Dim == 2 ? " discs" : " spheres"), 3, 1);
	}
}

} // namespace

TEST(SampleDevice, samplesOfEverySizeThatHasAKernelHaveTheBitsOfTheProcessor)
{
	expectSameAtAllSizes<2>(makeTwin(), 4);
	expectSameAtAllSizes<3>(makeTwin(), 3);
}

namespace {

template <class Number> void put(std::ofstream& file, Number number) { file.write(reinterpret_cast<const char*>(&number), sizeof(number)); }

/// As scripts/benchmarks/cardreplay.py writes it: two samples, three steps of the ground, the first of which asks none.
std::string recordOfTwoSamples()
{
	std::string   path = ::testing::TempDir() + "talik_replay.bin";
	std::ofstream file(path, std::ios::binary);
	put(file, std::uint64_t(2));
	put(file, 2e-2);
	for (const double ice : { 0., 0.1 }) {
		const std::string bytes = (ice > 0 ? frozen<3>(ice) : thawed<3>()).toBytes();
		put(file, std::uint64_t(bytes.size()));
		file << bytes;
	}
	const std::vector<std::vector<std::pair<std::uint64_t, double>>> asked { {}, { { 0, 0. }, { 1, 0.05 } }, { { 1, 0. } } }; // sample, ice
	for (const auto& step : asked) {
		put(file, std::uint64_t(step.size()));
		for (const auto& [sample, ice] : step) {
			put(file, sample);
			for (int k = 0; k < 9; ++k)
				put(file, k == 1 ? 1e-4 : 0.);
			put(file, ice);
		}
	}
	return path;
}

} // namespace

TEST(SampleDevice, recordOfAGroundIsReplayedForMorePointsWithTheBitsOfTheProcessor)
{
	SampleReplay<3>       record(recordOfTwoSamples());
	constexpr std::size_t points = 100, updates = 150;
	const auto            a = record.run(points, nullptr, 2), b = record.run(points, makeTwin(), 2);
	std::printf(
	        "%zu points, %zu steps of the ground: %zu updates (%zu asked), %ld steps of grains; %zu on the device, %zu left\n", points,
	        record.stepsOfGround(), b.updates, updates, b.steps, b.use.done, b.use.left);
	EXPECT_EQ(record.stepsOfGround(), 3u);
	EXPECT_EQ(a.updates, updates);
	EXPECT_EQ(b.updates, updates);
	EXPECT_EQ(a.steps, b.steps);
	EXPECT_EQ(b.use.left, 0u);
	EXPECT_TRUE(a.bytes == b.bytes);
}

/// On a machine with a card: ctest -L gpu.
TEST(SampleDevice, graphicsCardHasTheBitsOfTheProcessor_gpu)
{
	unsetenv("TALIK_CUDA_DRIVER");
	std::shared_ptr<SampleDevice> card;
	try {
		card = openCard();
	} catch (const DeviceFailure& failure) {
		GTEST_SKIP() << "not measured, no graphics card: " << failure.what();
	}
	expectSameThroughManyLists<2>(card, 1e-2, 60, 300);
	expectSameThroughManyLists<3>(card, 1e-2, 60, 300);
	expectSameWhereBondsStretch<2>(card);
	expectSameWhereBondsStretch<3>(card);
	expectSameWhateverHappens<2>(card);
	expectSameWhateverHappens<3>(card);
	expectSameAtAllSizes<2>(card, 12);
	expectSameAtAllSizes<3>(card, 12);
}
