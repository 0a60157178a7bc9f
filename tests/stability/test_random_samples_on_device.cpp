// SPDX-License-Identifier: GPL-2.0-or-later
// Samples on a device under random sequences of ice, strain and thaw strain, held against the same on the processor to the last bit. They go
// through bytes, as checkpoints do, and change between device and processor. The device is the twin of a card.
#include "Dice.hpp"
#include "Report.hpp"
#include "StockSamples.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <pkg/rve/device/SampleDevice.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>

using namespace talik;
using namespace talik::stability;
using namespace talik::validation;

namespace {

/// Three samples in two pools, one of which has a device now and then.
template <int D> class RandomRun {
	using State                          = PackedState<D>;
	using Matrix                         = typename State::Matrix;
	static constexpr std::size_t samples = 3;

public:
	RandomRun(std::uint64_t seed, std::shared_ptr<SampleDevice> chosen)
	        : dice_(seed)
	        , device_(std::move(chosen))
	{
		const State start = drawState();
		for (SamplePool<D>* pool : { &processor_, &away_ })
			for (std::size_t s = 0; s < samples; ++s)
				pool->add(start);
		away_.useDevice(device_, nullptr);
	}

	void run()
	{
		const int updates = dice_.count("updates", 4, 14);
		for (int k = 0; k < updates && wrong_.empty(); ++k)
			update();
		count();
		for (std::size_t s = 0; s < samples; ++s) {
			const State last = processor_.state(s);
			formed += double(last.bondsFormed);
			melted += double(last.bondsMelted);
			shrunk += last.radiusFactor < 1;
			if (last.toBytes() != away_.state(s).toBytes()) wrong_ += " state of sample " + std::to_string(s) + ";";
		}
	}

	const std::string& wrong() const { return wrong_; }
	std::string        described() const { return dice_.text(); }
	DeviceUse          use {};
	double             formed = 0, melted = 0, shrunk = 0;

private:
	State drawState()
	{
		State s          = ofStock<D>();
		s.friction       = dice_.between("mu", 0.0, 1.0);
		s.stiffnessRatio = dice_.between("ks/kn", 0.1, 1.0);
		s.damping        = dice_.between("damping", 0.1, 0.8);
		s.dt *= std::sqrt(s.ice.youngAt(0.0) / s.ice.youngAt(1.0));
		s.ice.tensileStrength = s.ice.shearStrength = dice_.decades("C0", 1e3, 1e7);
		s.ice.iceTensileStrength = s.ice.iceShearStrength = dice_.decades("C1", 1e5, 1e9);
		s.ice.bondRange                                   = dice_.between("range", 0.0, 0.2);
		if (dice_.chance("outlasts", 0.3)) s.ice.thawedStrength = dice_.decades("thawed", 1e3, 1e6);
		if (dice_.chance("shrinks", 0.5)) s.thawStrain.thawStrain = dice_.between("thawStrain", 0.0, 0.3);
		return s;
	}

	double drawIce(double now)
	{
		const std::string how = dice_.oneOf<std::string>("ice", { "as it is", "0", "1", "any", "near bonds", "little" });
		if (how == "as it is") return now;
		if (how == "near bonds") return dice_.between("Si", 0.0, 0.1);
		if (how == "little") return std::min(1.0, std::max(0.0, now + dice_.between("dSi", -0.04, 0.04)));
		return how == "any" ? dice_.between("Si", 0.0, 1.0) : std::stod(how);
	}

	void update()
	{
		changePlace();
		PackedUpdateOptions options;
		options.maxInertialNumber   = dice_.decades("I", 1e-3, 1e-1);
		options.maxStrainPerStep    = 1e-4;
		options.saturationIncrement = dice_.decades("dSi", 0.02, 0.3);
		options.stepsPerSaturation  = dice_.count("stepsPerSi", 1, 3);
		options.tangent             = dice_.chance("tangent", 0.5);
		std::vector<PackedRequest<D>> requests;
		for (std::size_t s = 0; s < samples; ++s) {
			if (dice_.chance("notAsked", 0.1)) continue;
			Matrix       increment = Matrix::Zero();
			const double strain    = dice_.decades("strain", 1e-6, 1e-2);
			if (!dice_.chance("atRest", 0.3))
				for (int k = 0; k < D * D; ++k)
					increment(k / D, k % D) = strain * dice_.uniform(-1.0, 1.0);
			requests.push_back({ s, increment, drawIce(processor_.parameters(s).iceSaturation) });
		}
		const auto a = processor_.update(requests, options, 1), b = away_.update(requests, options, 1);
		for (std::size_t r = 0; r < requests.size(); ++r)
			compare(a[r], b[r]);
		if (dice_.chance("read", 0.3))
			for (std::size_t s = 0; s < samples; ++s)
				if (processor_.state(s).toBytes() != away_.state(s).toBytes()) wrong_ += " state that is read;";
	}

	void compare(const PackedUpdateResult<D>& a, const PackedUpdateResult<D>& b)
	{
		if (std::memcmp(a.stress.data(), b.stress.data(), sizeof(double) * D * D)) wrong_ += " stress;";
		if (a.tangent != b.tangent) wrong_ += " tangent;";
		if (a.steps != b.steps || a.movingSteps != b.movingSteps || a.flipped != b.flipped || a.slipped != b.slipped || a.blewUp != b.blewUp)
			wrong_ += " steps, flips or blow-up;";
	}

	/// From the device to the processor or back, or through bytes into a new pool.
	void changePlace()
	{
		if (dice_.chance("otherPlace", 0.15)) {
			count();
			onDevice_ = !onDevice_;
			away_.useDevice(onDevice_ ? device_ : nullptr, nullptr);
		}
		if (!dice_.chance("checkpoint", 0.15)) return;
		count();
		onDevice_ = dice_.chance("toDevice", 0.7);
		SamplePool<D> processor, away;
		for (std::size_t s = 0; s < samples; ++s) {
			processor.add(State::fromBytes(processor_.state(s).toBytes()));
			away.add(State::fromBytes(away_.state(s).toBytes()));
		}
		processor_ = processor;
		away_      = away;
		away_.useDevice(onDevice_ ? device_ : nullptr, nullptr);
	}

	/// A pool counts from when its device was chosen.
	void count()
	{
		const DeviceUse now = away_.deviceUse();
		use.done += now.done;
		use.ended += now.ended;
		use.left += now.left;
		use.lists += now.lists;
	}

	Dice                          dice_;
	std::shared_ptr<SampleDevice> device_;
	SamplePool<D>                 processor_, away_;
	bool                          onDevice_ = true;
	std::string                   wrong_;
};

template <int D> void search(const std::string& kind, std::uint64_t draws)
{
	citing("packed samples on the processor");
	const std::uint64_t first  = firstSeed();
	const auto          device = makeTwin();
	int                 failed = 0;
	DeviceUse           use;
	double              formed = 0, melted = 0, shrunk = 0;
	for (std::uint64_t seed = first; seed < first + draws; ++seed) {
		RandomRun<D> run(seed, device);
		run.run();
		use.done += run.use.done;
		use.ended += run.use.ended;
		use.left += run.use.left;
		use.lists += run.use.lists;
		formed += run.formed;
		melted += run.melted;
		shrunk += run.shrunk;
		if (run.wrong().empty()) continue;
		++failed;
		ADD_FAILURE() << "seed " << seed << ":" << run.wrong() << "\n  run:" << run.described();
	}
	std::printf(
	        "seeds %llu to %llu: %zu updates on the device, %zu ended and %zu left to the processor; %zu lists there; %.0f bonds formed, %.0f melted, "
	        "grains of %.0f samples shrunk\n",
	        static_cast<unsigned long long>(first), static_cast<unsigned long long>(first + draws - 1), use.done, use.ended, use.left, use.lists, formed,
	        melted, shrunk);
	expectSmall("random ice and strain of " + kind + " on a device, " + std::to_string(draws) + " draws: runs with other bits", failed, 0.0);
}

} // namespace

TEST(RandomSearch, DiscsOnADeviceHaveTheBitsOfTheProcessorWhateverTheirIceAndStrain) { search<2>("discs", (drawsAskedFor() + 9) / 10); }

TEST(RandomSearch, SpheresOnADeviceHaveTheBitsOfTheProcessorWhateverTheirIceAndStrain) { search<3>("spheres", (drawsAskedFor() + 39) / 40); }

TEST(RandomSearch, ManySamplesOnADeviceHaveTheBitsOfTheProcessorWhateverTheirIceAndStrain_slow)
{
	search<2>("discs, many", 5 * drawsAskedFor());
	search<3>("spheres, many", drawsAskedFor());
}
