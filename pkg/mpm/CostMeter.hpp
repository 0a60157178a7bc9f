// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <chrono>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace talik {

/// Wall time that a running ground has spent, by effect. Time stamps are taken between the phases of a step; of a pass that serves
/// several effects at once, some blocks are stamped by the thread that works on them, and the time of the pass is shared out in
/// proportion. What one vector instruction does for two effects is counted for the first.
class CostMeter {
public:
	/// Those from `entries` on are of effects that stand in files of their own, in their order.
	enum Entry : int {
		sorting,
		motion,
		transfer,
		front,
		bodies,
		cells,
		heat,
		freezing,
		water,
		flows,
		surface,
		boundaries,
		thawStrain,
		segregation,
		ledger,
		calendar,
		limits,
		entries
	};

	using Moment = std::chrono::steady_clock::time_point;
	static Moment now() { return std::chrono::steady_clock::now(); }

	/// Samples of one thread's work on one strip.
	class Sample {
	public:
		explicit Sample(std::vector<double>& sums)
		        : sums_(sums)
		{}
		/// Before work that is always stamped.
		void begin()
		{
			weight_ = 1.0;
			last_   = now();
		}
		/// Before one of many blocks: one in sixteen is stamped.
		void beginBlock()
		{
			weight_ = blocks_++ % 16 == 0 ? 16.0 : 0.0;
			if (weight_ > 0.0) last_ = now();
		}
		void lap(Entry e)
		{
			if (weight_ == 0.0) return;
			const Moment t = now();
			sums_[e] += weight_ * std::chrono::duration<double>(t - last_).count();
			last_ = t;
		}

	private:
		std::vector<double>& sums_;
		Moment               last_ {};
		int                  blocks_ = 0;
		double               weight_ = 0.0;
	};

	void allocate(int strips, int skeletons, int effects)
	{
		seconds_.resize(entries + effects);
		samples_.assign(strips, std::vector<double>(seconds_.size()));
		skeletons_.assign(skeletons, 0.0);
	}
	static Entry ofEffect(int number) { return Entry(entries + number); }
	/// What happened since the last lap is not counted.
	void start() { last_ = now(); }
	/// Does work; its time, and what went before it since the last lap, belong to an effect, or to a skeleton.
	template <class Work> void time(Entry e, Work&& work)
	{
		work();
		seconds_[e] += sinceLast();
	}
	template <class Work> void timeSkeleton(int k, Work&& work)
	{
		work();
		skeletons_[k] += sinceLast();
	}
	/// Samples of a strip in the present pass.
	Sample sample(int strip) { return Sample(samples_[strip]); }
	/// What happened since the last lap was a pass with samples.
	void lapShared()
	{
		double all = 0.0;
		sums_.assign(seconds_.size(), 0.0);
		for (auto& strip : samples_)
			for (std::size_t e = 0; e < strip.size(); ++e) {
				sums_[e] += strip[e];
				all += std::exchange(strip[e], 0.0);
			}
		const double pass = sinceLast();
		for (std::size_t e = 0; e < sums_.size() && all > 0.0; ++e)
			seconds_[e] += pass * sums_[e] / all;
	}

	double seconds(Entry e) const { return seconds_[e]; }
	double secondsOfSkeleton(int k) const { return skeletons_[k]; }

private:
	double sinceLast()
	{
		const Moment t       = now();
		const double elapsed = std::chrono::duration<double>(t - last_).count();
		last_                = t;
		return elapsed;
	}

	std::vector<double>              seconds_ = std::vector<double>(entries);
	std::vector<double>              skeletons_, sums_;
	std::vector<std::vector<double>> samples_; ///< by strip
	Moment                           last_ {};
};

/// What one effect does in a pass over blocks or strips of points: whether it takes part, who pays, and its work. Work that takes the samples as its
/// last argument may lap them for several effects.
template <class Work> struct PassPart {
	bool             present;
	CostMeter::Entry pays;
	Work             work;

	template <class... Given> void run(CostMeter::Sample& sample, Given&&... given) const
	{
		if (!present) return;
		if constexpr (std::is_invocable_v<const Work&, Given..., CostMeter::Sample&>) work(given..., sample);
		else work(given...);
		sample.lap(pays);
	}
};
template <class Work> PassPart(bool, CostMeter::Entry, Work) -> PassPart<Work>;

} // namespace talik
