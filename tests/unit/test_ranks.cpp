// SPDX-License-Identifier: GPL-2.0-or-later
// Samples shared out among ranks, which are threads of this process here.
#include "packedSpheres.hpp"
#include "threadRanks.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numeric>
#include <pkg/multiscale/samples/PackedStore.hpp>
#include <pkg/multiscale/samples/SampleStore.hpp>
#include <pkg/multiscale/samples/SlabStore.hpp>

using namespace talik;
using packedSpheres::Matrix;

namespace {

std::vector<PackedStore<3>::StatePointer> prototypes() { return { std::make_shared<PackedState<3>>(packedSpheres::sample().state()) }; }

constexpr int samples = 9;

/// Update number `turn`: samples 0, 2, 3 and 4 in each, the others now and then; 5 and 6 always by the same request, so that they share a state.
std::vector<PackedRequest<3>> requestsOf(int turn)
{
	std::vector<PackedRequest<3>> requests;
	for (int s = 0; s < samples; ++s) {
		if ((s == 1 || s > 4) && turn % 4 != 0) continue;
		const int        kind = s == 6 ? 5 : s;
		PackedRequest<3> request;
		request.sample               = std::size_t(s);
		request.displacementGradient = Matrix::Constant(1e-6 * (kind + 1)) - Matrix::Identity() * 4e-6 * (turn % 3);
		request.iceSaturation        = 0.3 - 0.01 * (turn % 20);
		requests.push_back(request);
	}
	return requests;
}

/// Updates of the samples of one rank whose points go from rank to rank every seventh turn; on one rank, of all.
struct InSlabs {
	explicit InSlabs(std::shared_ptr<Communicator> others)
	        : communicator(std::move(others))
	{}
	void prepare(SampleStoreOf<3>& store) const
	{
		for (int s = 0; s < samples; ++s)
			store.add(0, 0.3, {});
		if (communicator) static_cast<SlabStore<3>&>(store).own(owners(0));
	}
	void follow(SampleStoreOf<3>& store, int from, int to, std::vector<double>& numbers) const
	{
		for (int turn = from; turn < to; ++turn) {
			auto        requests = requestsOf(turn);
			auto* const slabs    = communicator ? static_cast<SlabStore<3>*>(&store) : nullptr;
			if (slabs) {
				if (turn % 7 == 0) slabs->deal(owners(turn / 7));
				slabs->beginStep();
				requests.erase(
				        std::remove_if(
				                requests.begin(), requests.end(),
				                [&](const auto& request) { return owners(turn / 7)[request.sample] != communicator->rank(); }),
				        requests.end());
			}
			store.update(requests, {}, 1);
			if (turn % 5) continue;
			for (const auto& row : store.measureAll("fabric"))
				numbers.insert(numbers.end(), row.begin(), row.end());
			numbers.push_back(store.measure(std::size_t(turn / 5 % samples), "coordinationNumber")[0]);
			if (communicator) communicator->meet("all have looked");
		}
	}
	std::vector<int> owners(int time) const
	{
		std::vector<int> ownerOf;
		for (int s = 0; s < samples; ++s)
			ownerOf.push_back((s + time * (1 + s % 2)) / 3 % communicator->count());
		return ownerOf;
	}
	std::shared_ptr<Communicator> communicator;
};

/// The states of all samples in a file: one rank plans it, and each writes its own. Returns the bytes where their sum is what it says, else nothing.
std::string writtenBy(const SampleStore& store, const std::string& path)
{
	const auto layout = store.layout();
	std::ofstream(path, std::ios::binary) << "begun";
	constexpr std::uint64_t at  = 8;
	const std::uint64_t     end = at + layout.bytes();
	std::filesystem::resize_file(path, end);
	PartSum sum;
	sum.add(store.writeStates(layout, { path, at, end }));
	std::ifstream     file(path, std::ios::binary);
	const std::string bytes(std::istreambuf_iterator<char>(file), {});
	Checksum          begun, whole;
	begun.process_bytes(bytes.data(), 5);
	whole.process_bytes(bytes.data(), bytes.size());
	return sum.checksum(begun.checksum(), end - 5) == whole.checksum() ? bytes : "";
}

/// How the states are shared, and what they are.
std::string savedBy(const SampleStore& store)
{
	ByteWriter writer;
	store.layout().save(writer);
	writer.block(store.states());
	return writer.bytes();
}

} // namespace

TEST(Ranks, SamplesOfBandsGoWithTheirPointsAndHaveTheBitsOfOneRank)
{
	const auto          one = std::make_shared<PackedStore<3>>(prototypes());
	std::vector<double> wanted, wantedLater;
	const InSlabs       alone(nullptr);
	alone.prepare(*one);
	alone.follow(*one, 0, 60, wanted);
	const std::string half = savedBy(*one), file = testing::TempDir() + "states", inFile = writtenBy(*one, file + "0");
	alone.follow(*one, 60, 80, wantedLater);
	const std::string whole = savedBy(*one);
	for (const int ranks : { 2, 3 }) {
		std::vector<int>           same(std::size_t(ranks), 0);
		std::vector<std::uint64_t> owned(same.size()), moved(same.size());
		asRanks(ranks, [&](const std::shared_ptr<Communicator>& communicator) {
			const InSlabs       ofSlabs(communicator);
			SlabStore<3>        store(prototypes(), communicator);
			std::vector<double> numbers, later;
			ofSlabs.prepare(store);
			ofSlabs.follow(store, 0, 60, numbers);
			const bool halfSame = savedBy(store) == half;
			const auto store60  = store.layout();
			const auto ofRanks  = file + std::to_string(ranks);
			const bool fileSame = communicator->rank() != 1 || writtenBy(store, ofRanks) == inFile;
			communicator->meet("rank 1 has planned the file, and all have written it");
			ofSlabs.follow(store, 60, 80, later);
			const bool wholeSame = savedBy(store) == whole;

			SlabStore<3> resumed(prototypes(), communicator); // by each rank what is its own
			ofSlabs.prepare(resumed);
			resumed.own(ofSlabs.owners(60 / 7));
			ByteReader        reader(half);
			const auto        layout = SampleStore::Layout::from(reader);
			const std::string states = reader.block();
			resumed.restore(layout, [&](std::uint64_t at, std::uint64_t length) { return states.substr(at, length); });
			std::vector<double> again, fromFile;
			ofSlabs.follow(resumed, 60, 80, again);
			SlabStore<3> read(prototypes(), communicator);
			ofSlabs.prepare(read);
			read.own(ofSlabs.owners(60 / 7));
			const PartedFile written(ofRanks, PartedFile::For::reading);
			read.restore(store60, [&](std::uint64_t at, std::uint64_t length) {
				std::string state(length, '\0');
				written.read(&state[0], length, 8 + at);
				return state;
			});
			ofSlabs.follow(read, 60, 80, fromFile);
			const auto rank = std::size_t(communicator->rank());
			same[rank]      = halfSame + 2 * wholeSame + 4 * (numbers == wanted) + 8 * (later == wantedLater) + 16 * (again == wantedLater)
			        + 32 * (savedBy(resumed) == whole) + 64 * fileSame + 128 * (fromFile == wantedLater);
			owned[rank] = store.sharing()->samples;
			moved[rank] = store.sharing()->moved;
		});
		std::printf(
		        "%d ranks: %zu numbers and %zu bytes as on one, also resumed; %llu samples went to another rank\n", ranks, wanted.size(), whole.size(),
		        static_cast<unsigned long long>(moved[0]));
		for (const int all : same)
			EXPECT_EQ(all, 255);
		EXPECT_EQ(std::accumulate(owned.begin(), owned.end(), std::uint64_t(0)), std::uint64_t(samples));
		EXPECT_GT(moved[0], 20u);
	}
}

TEST(Ranks, PartsOfAFileInAnyOrderHaveTheChecksumOfTheWhole)
{
	std::string bytes(10007, '\0');
	for (std::size_t k = 0; k < bytes.size(); ++k)
		bytes[k] = char(k * k % 251 ^ k / 7);
	const std::size_t borders[] = { 1234, 1234, 1235, 5000, 9999, bytes.size() };
	Checksum          begun, whole;
	begun.process_bytes(bytes.data(), borders[0]);
	whole.process_bytes(bytes.data(), bytes.size());
	PartSum sum;
	for (const int part : { 3, 0, 4, 2, 1 })
		sum.add(bytes.data() + borders[part], borders[part + 1] - borders[part], bytes.size() - borders[part + 1]);
	std::printf(
	        "%s, and of the whole %s\n", hexadecimal(sum.checksum(begun.checksum(), bytes.size() - borders[0])).c_str(),
	        hexadecimal(whole.checksum()).c_str());
	EXPECT_EQ(sum.checksum(begun.checksum(), bytes.size() - borders[0]), whole.checksum());
}

TEST(Ranks, ARankThatLooksBeforeAllReplaceASampleSeesItAsItWas)
{
	std::vector<double> before(2, -1), wanted(2, -2);
	asRanks(2, [&](const std::shared_ptr<Communicator>& communicator) {
		const InSlabs       ofSlabs(communicator);
		SlabStore<3>        store(prototypes(), communicator);
		std::vector<double> numbers;
		ofSlabs.prepare(store);
		ofSlabs.follow(store, 0, 9, numbers);
		const std::size_t sample = 8; // of rank 1
		const auto        look   = [&] { return store.measure(sample, "coordinationNumber")[0] + store.measure(sample, "fabric")[0]; };
		if (communicator->rank() == 1) wanted[1] = look();
		communicator->meet("rank 1 has looked alone");
		if (communicator->rank() == 0) before[0] = look();
		store.beforeReplacing(sample);
		store.release(sample);
		store.replaced(sample);
		communicator->meet("the end");
	});
	std::printf("rank 0 saw %.6f, and rank 1 before %.6f\n", before[0], wanted[1]);
	EXPECT_EQ(before[0], wanted[1]);
}

TEST(Ranks, ARankThatAsksForWhatAnotherHasDroppedIsToldSo)
{
	std::string said;
	asRanks(2, [&](const std::shared_ptr<Communicator>& communicator) {
		const InSlabs ofSlabs(communicator);
		auto          store = std::make_unique<SlabStore<3>>(prototypes(), communicator);
		ofSlabs.prepare(*store);
		if (communicator->rank() == 1) store.reset();
		else try {
				store->measureAll("fabric");
			} catch (const std::runtime_error& problem) {
				said = problem.what();
			}
		communicator->meet("the end");
	});
	std::printf("%s\n", said.c_str());
	EXPECT_NE(said.find("rank 1 has dropped"), std::string::npos);
}

TEST(Ranks, ARankMayAskWhileTheOthersGoOn)
{
	int answered = 0;
	asRanks(3, [&](const std::shared_ptr<Communicator>& communicator) {
		const InSlabs       ofSlabs(communicator);
		SlabStore<3>        store(prototypes(), communicator);
		std::vector<double> numbers;
		ofSlabs.prepare(store);
		for (int turn = 0; turn < 6; ++turn) {
			ofSlabs.follow(store, turn, turn + 1, numbers);
			if (communicator->rank() == turn % 3) {
				const auto rows = store.measureAll("bondsIntact");
				if (communicator->rank() == 0) answered += rows.size() == samples && rows[8] == store.measure(8, "bondsIntact");
			}
			communicator->meet("turn");
		}
	});
	std::printf("rank 0 asked twice and was answered %d times while the others were on their way\n", answered);
	EXPECT_EQ(answered, 2);
}

TEST(Ranks, ARankWithAnotherGroundAndOneAtAnotherPlaceAreNamedOnAllRanks)
{
	std::vector<std::string> said(6);
	asRanks(3, [&](const std::shared_ptr<Communicator>& communicator) {
		const auto attempt = [&](std::size_t first, auto&& meeting) {
			try {
				meeting();
			} catch (const std::runtime_error& problem) {
				said[first + std::size_t(communicator->rank())] = problem.what();
			}
		};
		attempt(0, [&] { communicator->meet("update 7", communicator->rank() == 2 ? 5 : 4); });
		attempt(3, [&] { communicator->meet(communicator->rank() == 1 ? "the end" : "update 8"); });
	});
	std::printf("%s\n%s\n", said[0].c_str(), said[3].c_str());
	for (int k : { 1, 2 })
		EXPECT_EQ(said[std::size_t(k)], said[0]);
	for (int k : { 4, 5 })
		EXPECT_EQ(said[std::size_t(k)], said[3]);
	EXPECT_NE(said[0].find("rank 2"), std::string::npos);
	EXPECT_EQ(said[0].find("rank 1"), std::string::npos);
	EXPECT_NE(said[3].find("rank 1 at 'the end'"), std::string::npos);
}
