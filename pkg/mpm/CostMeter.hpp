// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace talik {

/// Wall time that a running ground has spent, by effect. Time stamps are taken between the phases of a step; of a pass that serves
/// several effects at once, some blocks are stamped by the thread that works on them, and the time of the pass is shared out in
/// proportion. What one vector instruction does for two effects is counted for the first.
class CostMeter {
public:
	enum Entry {
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
		record,
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
		explicit Sample(std::array<double, entries>& sums)
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
		std::array<double, entries>& sums_;
		Moment                       last_ {};
		int                          blocks_ = 0;
		double                       weight_ = 0.0;
	};

	void allocate(int strips, int skeletons)
	{
		samples_.assign(strips, {});
		skeletons_.assign(skeletons, 0.0);
	}
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
		std::array<double, entries> sums {};
		double                      all = 0.0;
		for (auto& strip : samples_) {
			for (int e = 0; e < entries; ++e) {
				sums[e] += strip[e];
				all += strip[e];
			}
			strip.fill(0.0);
		}
		const double pass = sinceLast();
		for (int e = 0; e < entries && all > 0.0; ++e)
			seconds_[e] += pass * sums[e] / all;
	}

	double             seconds(Entry e) const { return seconds_[e]; }
	double             secondsOfSkeleton(int k) const { return skeletons_[k]; }
	static const char* nameOf(Entry e)
	{
		static constexpr const char* names[entries] = {
			"sorting",       "motion",     "transfer",           "thaw front",  "bodies",
			"cell averages", "heat",       "freezing",           "water",       "conduction and pore pressure",
			"free surface",  "boundaries", "deformation record", "thaw strain", "ice segregation",
			"energy ledger", "calendar",   "time step limits"
		};
		return names[e];
	}

private:
	double sinceLast()
	{
		const Moment t       = now();
		const double elapsed = std::chrono::duration<double>(t - last_).count();
		last_                = t;
		return elapsed;
	}

	std::array<double, entries>              seconds_ {};
	std::vector<double>                      skeletons_;
	std::vector<std::array<double, entries>> samples_;
	Moment                                   last_ {};
};

/// What one effect does in a pass over blocks or strips of points: whether it takes part, who pays, and its work.
template <class Work> struct PassPart {
	bool             present;
	CostMeter::Entry pays;
	Work             work;

	template <class... Given> void run(CostMeter::Sample& sample, Given&&... given) const
	{
		if (!present) return;
		work(given...);
		sample.lap(pays);
	}
};
template <class Work> PassPart(bool, CostMeter::Entry, Work) -> PassPart<Work>;

} // namespace talik
