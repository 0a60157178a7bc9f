// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <pkg/multiscale/samples/SampleAccuracy.hpp>
#include <pkg/multiscale/samples/SampleScheduler.hpp>
#include <pkg/multiscale/samples/SampleStore.hpp>
#include <set>
#include <string>
#include <vector>

namespace talik {

/// Sums over all samples since the start.
struct SampleCounters {
	std::uint64_t calls = 0, steps = 0, points = 0;
	double        seconds = 0; ///< wall time inside the samples [s]
};

/// Which sample stands behind which point, and how the calls went.
class PointSamples {
public:
	/// store: holds the prototypes; prototypeOf[id]: which one a point takes, -1 for points of another skeleton.
	PointSamples(std::shared_ptr<SampleStore> store, std::vector<int> prototypeOf, const SampleScheduling& scheduling);
	virtual ~PointSamples() = default;

	/// Steers strain tolerance and inertial number of each point by the relative error of effective stress that they cause, in place of
	/// the scheduling's. Before the fields are declared, or to another tolerance > 0 at any time.
	void setTolerance(double tolerance);
	/// Of the estimated error since the start.
	virtual ErrorSquares errorSquares(const SkeletonPoints&) const = 0;
	bool                 steered() const { return bool(accuracy); }

	SampleScheduling& scheduling() { return schedule; }
	/// Called with the point's id for every sample that blew up and is in its last good state again; says whether the run has to stop.
	/// Without it stopOnBlowUp decides.
	std::function<bool(int)> onBlowUp;
	/// Measures the strength with which points slip at the thaw front, when that asks for it first and the scheduling states none.
	std::function<ShearStrength()> measureSlip;
	const SampleCounters&          counters() const { return count; }

	bool has(int id) const { return id >= 0 && id < int(sampleOf.size()) && sampleOf[id] >= 0; }
	/// Number of a point's sample in the store. Throws std::invalid_argument for a point without one.
	std::size_t        sampleNumber(int id) const;
	int                prototype(int id) const { return prototypeOf.at(id); }
	int                points() const { return int(sampleOf.size()); }
	const SampleStore& samples() const { return *anyStore; }
	/// The next update asks this point's sample, however small its increments: something was done to it from outside.
	void askNext(int id)
	{
		changed.insert(id);
		anyStore->replaced(sampleNumber(id));
	}
	/// Before the state behind a point is read: another rank may own it.
	void                              bring(int id) const { anyStore->bring(sampleNumber(id)); }
	void                              beforeReplacing(int id) const { anyStore->beforeReplacing(sampleNumber(id)); }
	const std::map<int, std::string>& blownUp() const { return failures; } ///< by point id

	/// Gives up the samples of points that are not among these.
	void keepOnly(const SkeletonPoints&);

	/// All but the states of the samples, which take layout.bytes() elsewhere; states(at, length) reads them.
	std::string save(const SampleStore::Layout& layout) const;
	void        restore(const std::string& bytes, const std::function<std::string(std::uint64_t at, std::uint64_t length)>& states);

protected:
	std::optional<ShearStrength> slip() const;
	/// What came of the samples that were asked in a step: of this rank, and then of all in the order of their points.
	struct Asked {
		struct BlownUp {
			int         id;
			std::string reason;
		};
		std::uint64_t        calls = 0, steps = 0;
		std::vector<BlownUp> blownUp;
	};
	/// Takes it into the books. Throws StopAfterStep where a sample blew up and the run has to stop.
	void book(const Asked&);
	/// Before states are restored: who gets them, where ranks have slabs of the ground.
	virtual void beginWithOwners() {}

	std::vector<int>                prototypeOf, sampleOf;
	SampleScheduling                schedule;
	SampleCounters                  count;
	std::unique_ptr<SampleAccuracy> accuracy; ///< only with a tolerance
	std::map<int, std::string>      failures;
	std::set<int>                   changed;
	std::set<int>                   isolated; ///< ids of points that keep their last stress since their sample blew up

private:
	void restoreBooks(ByteReader&);

	mutable std::optional<ShearStrength> measuredSlip;

	std::shared_ptr<SampleStore> anyStore;
};

} // namespace talik
