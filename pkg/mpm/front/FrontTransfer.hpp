// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/front/FrontNodes.hpp>
#include <pkg/mpm/front/FrontRecords.hpp>
#include <pkg/mpm/points/AffineVelocity.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>

#include <optional>

namespace talik {

/// Transfer between the points of both sides and the front nodes.
template <int D> class FrontTransfer {
public:
	/// Content of the pores by place; waterMass and iceMass [kg], porosity [-].
	struct Pores {
		const double *waterMass, *iceMass, *porosity;
	};
	explicit FrontTransfer(const FrontConstants& constants)
	        : constants_(constants)
	{}
	/// water: null in ground without. slip: path of each point along the front [m], which gather() adds to.
	void bind(
	        const FrontNodes<D>& nodes, FrontRecords<D>& records, SolidMotion<D>& motion, PoreWater<D>* water, const Pores& pores, double* slip,
	        int points);
	/// Only points of this part are used from now on.
	void keepOnly(int firstPoint, int endPoint);

	/// Strength of a thawed point near the front; none where its law states none.
	void setStrength(int place, const std::optional<ShearStrength>& strength);

	/// Adds what the points of a block near the front bring; affine may be null.
	void map(const Grid<D>& grid, const WeightBlock<D>& w, const AffineVelocity<D>* affine);
	/// Adds a force [N] on point k of a block that its stress does not contain.
	void push(const WeightBlock<D>& w, int k, const Vec<D>& force);
	/// Adds the weight of the frozen side; call before mirrors are folded.
	void addGravity();
	/// Gives the frozen side its part, by mass, of a load on a front node [N]; call before mirrors are folded.
	void addLoad(int slot, const Vec<D>& force);
	/// What map() and push() add to.
	void shareMapped(const std::vector<int>& rowStarts, SharedRows& rows);
	/// Corrects velocity, position, displacement and displacement gradient of a block; affine may be null.
	void gather(const Grid<D>& grid, const WeightBlock<D>& w, double dt, const AffineVelocity<D>* affine);
	/// Correction of the velocity [m/s] with which a point moves at a node; null for none.
	const double* correction(int node, int place) const;

private:
	using Loops                          = NodeLoops<D>;
	using R                              = FrontRecords<D>;
	using Frozen                         = typename R::Frozen;
	using Thawed                         = typename R::Thawed;
	template <class Columns> using Share = typename Loops::template Shares<Columns>::Share;

	void   bringFrozen(int place, Share<Frozen>& share) const;
	void   bringThawed(int place, Share<Thawed>& share) const;
	void   bringPores(int place, Share<typename R::Pores>& share) const;
	void   bringAffine(const Grid<D>& grid, const WeightBlock<D>& w, int k, const AffineVelocity<D>& affine);
	void   move(int place, double dt, const typename Loops::FrontSums& sums);
	double liquidMass(int place) const { return pores_.waterMass[place] - pores_.iceMass[place]; }
	double fullMass(int place) const;

	FrontConstants       constants_;
	const FrontNodes<D>* nodes_   = nullptr;
	FrontRecords<D>*     records_ = nullptr;
	SolidMotion<D>*      motion_  = nullptr;
	PoreWater<D>*        water_   = nullptr;
	Pores                pores_ {};
	double*              slip_ = nullptr;
	PagedArray<double>   friction_, cohesion_; ///< by place, of thawed points near the front [-], [Pa]
	PagedArray<double>   mappedLiquid_;        ///< by place, liquid mass of points near the front when it was mapped [kg]
};

extern template class FrontTransfer<2>;
extern template class FrontTransfer<3>;

} // namespace talik
