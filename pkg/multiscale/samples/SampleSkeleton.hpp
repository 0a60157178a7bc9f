// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/mpm/skeleton/SkeletonModel.hpp>
#include <pkg/multiscale/samples/BandStore.hpp>
#include <pkg/multiscale/samples/SampleAccuracy.hpp>

#include <functional>
#include <map>
#include <optional>
#include <set>

namespace talik {

/// When a sample is asked and how, eq. (15.2): increments accumulate until one of the tolerances is passed.
struct SampleScheduling {
	double              strainTolerance     = 2e-5; ///< largest accumulated component of the displacement gradient [-]; 0: ask in every step
	double              saturationTolerance = 0.01; ///< largest accumulated change of ice saturation [-]; 0: ask in every step
	bool                prediction          = true; ///< a tangent stands in between two calls; false: the last stress is held
	double              stressTolerance = 0.05; ///< relative error of the prediction that the strain tolerance of a point is steered to; 0: fixed tolerance
	bool                steersTolerance() const { return stressTolerance > 0 && strainTolerance > 0; }
	bool                stopOnBlowUp = true; ///< the run stops when the step has ended; false: the point keeps its last stress from then on
	int                 threads      = 0;    ///< 0: OpenMP's default
	PackedUpdateOptions update;
	/// How the strength of ice bonds follows temperature and strain rate; absent: it is that of the samples.
	std::optional<IceStrengthLaw> iceStrength;
	/// How ice bonds creep in calendar time, and after how much of it a sample is asked at the latest [s]; absent: they do not.
	std::optional<IceCreepLaw> iceCreep;
	double                     creepInterval = 0;
	bool                       followsTime() const { return iceStrength || iceCreep; }
	/// Strength with which points slip at the thaw front; absent: it is measured, see PointSamples::measureSlip.
	std::optional<ShearStrength> slipStrength;
};

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

	std::string save() const;
	void        restore(const std::string& bytes);
	/// The same with the states of the samples in a file of parts, where they take layout.bytes().
	std::string saveBeside(const SampleStore::Layout& layout) const;
	void        restoreBeside(const std::string& bytes, const PartedFile& file, std::uint64_t at);

protected:
	std::optional<ShearStrength> slip() const;
	/// What came of the samples that were asked in a step: of this rank, and then of all in the order of their points.
	struct Asked {
		struct BlownUp {
			int         id;
			std::string reason;
		};
		std::uint64_t                     calls = 0, steps = 0;
		std::vector<BlownUp>              blownUp;
		std::vector<SampleAccuracy::Term> errors;
	};
	/// Takes it into the books. Throws StopAfterStep where a sample blew up and the run has to stop.
	void book(const Asked&);
	/// Before states are restored: who gets them, where ranks have bands of the ground.
	virtual void beginWithOwners() {}

	std::vector<int>                prototypeOf, sampleOf;
	SampleScheduling                schedule;
	SampleCounters                  count;
	std::unique_ptr<SampleAccuracy> accuracy; ///< only with a tolerance
	std::map<int, std::string>      failures;
	std::set<int>                   changed;
	std::set<int>                   isolated; ///< ids of points that keep their last stress since their sample blew up

private:
	void saveBooks(ByteWriter&) const;
	void restoreBooks(ByteReader&);
	void restoreNumbers(ByteReader&);

	mutable std::optional<ShearStrength> measuredSlip;

	std::shared_ptr<SampleStore> anyStore;
};

/// Effective stress from one periodic sample behind each material point, Yu & Zhao section 2.3, step 3: discs behind points in the plane,
/// spheres behind points in space. Samples keep their history; those never asked share one state.
template <int Dim> class SampleSkeleton final : public SkeletonModel<Dim>, public PointSamples {
public:
	SampleSkeleton(std::shared_ptr<SampleStoreOf<Dim>> store, std::vector<int> prototypeOf, const SampleScheduling& scheduling);

	std::string name() const override { return "RveSkeleton"; }

	std::optional<ShearStrength> shearStrength(double) const override { return slip(); }

	void declareFields(PointFields&, const std::string& prefix) override;
	void initialise(const SkeletonBatch<Dim>&) override;
	bool beginsWithAll() const override { return true; } // samples are numbered alike on all ranks
	void updateStress(const SkeletonBatch<Dim>&) override;
	void tangentModulus(const SkeletonBatch<Dim>&, double* modulus) const override;

	ErrorSquares errorSquares(const SkeletonPoints&) const override;

	void followBands(Bands&, const int* ids, bool moved) override;
	void addCost(const SkeletonPoints&, double* costByPlace) override;

private:
	using Matrix = typename PackedTypes<Dim>::Matrix;
	struct Arrays;
	Arrays                          arrays() const;
	bool                            isDue(const Arrays&, int place, const Matrix& gradient, const Matrix& change, double iceSaturation) const;
	Asked                           ask(const SkeletonBatch<Dim>&, const std::vector<int>& due, const Arrays&);
	void                            askInBands(const SkeletonBatch<Dim>&, const std::vector<int>& due, const Arrays&);
	Asked                           ofAllRanks(const Asked& own, const std::string& failure);
	std::vector<int>                owners(std::size_t samples) const;
	void                            beginWithOwners() override;
	std::vector<PackedRequest<Dim>> requests(const SkeletonBatch<Dim>&, const std::vector<int>& due, const Arrays&) const;
	SampleAccuracy::Term            steer(const SkeletonBatch<Dim>&, int place, double predictionError, const PackedUpdateResult<Dim>&, const Arrays&);
	void                            flagChanged(const SkeletonBatch<Dim>&);
	void                            passTime(const SkeletonBatch<Dim>&) const;
	bool                            hasCrept(const SkeletonBatch<Dim>&, int place) const;
	BondCreep                       creep(const SkeletonBatch<Dim>&, int place) const;
	BondStrengthFactors             strengthFactors(const SkeletonBatch<Dim>&, int place, const Matrix& gradient) const;

	std::shared_ptr<SampleStoreOf<Dim>> store;
	std::shared_ptr<BandStore<Dim>>     banded;           ///< the same, where ranks may have bands of the ground
	Bands*                              bands  = nullptr; ///< they have
	const int*                          idAt   = nullptr; ///< ids of the points of all bands, by place
	PointFields*                        fields = nullptr;
	PointFields::Handle gradientField = -1, stressField = -1, saturationField = -1, tangentField = -1, ratioField = -1, toleranceField = -1, timeField = -1;
	std::vector<int>    dueScratch;
	std::vector<char>   flagScratch;
};

} // namespace talik
