// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/mpm/skeleton/SkeletonModel.hpp>
#include <pkg/multiscale/samples/PointSamples.hpp>
#include <pkg/multiscale/samples/SlabStore.hpp>

namespace talik {

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
	void divide(const std::vector<int>& parents) override;
	void tangentModulus(const SkeletonBatch<Dim>&, double* modulus) const override;

	ErrorSquares errorSquares(const SkeletonPoints&) const override;

	void followSlabs(SlabDecomposition&, const int* ids, bool moved) override;
	void addCost(const SkeletonPoints&, double* costByPlace) override;

private:
	using Matrix = typename PackedTypes<Dim>::Matrix;
	using Record = SampleRecord<Dim>;
	SampleScheduler<Dim>            scheduler() const { return { schedule, bool(accuracy) }; }
	Asked                           ask(const SkeletonBatch<Dim>&, const std::vector<int>& due, const Record&);
	void                            askInSlabs(const SkeletonBatch<Dim>&, const std::vector<int>& due, const Record&);
	Asked                           ofAllRanks(const Asked& own, const std::string& failure);
	std::vector<int>                owners(std::size_t samples) const;
	void                            beginWithOwners() override;
	std::vector<PackedRequest<Dim>> requests(const SkeletonBatch<Dim>&, const std::vector<int>& due, const Record&) const;
	void                            steer(int place, double predictionError, const PackedUpdateResult<Dim>&, const Record&);
	void                            flagChanged(const SkeletonBatch<Dim>&);

	std::shared_ptr<SampleStoreOf<Dim>> store;
	std::shared_ptr<SlabStore<Dim>>     ofSlabs;         ///< the same, where ranks may have slabs of the ground
	SlabDecomposition*                  slabs = nullptr; ///< they have
	const int*                          idAt  = nullptr; ///< ids of the points of all slabs, by place
	Record                              record;
	std::vector<int>                    dueScratch;
	std::vector<char>                   flagScratch;
};

} // namespace talik
