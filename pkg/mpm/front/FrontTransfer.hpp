// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/effects/AffineVelocity.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/front/FrontNodes.hpp>
#include <pkg/mpm/front/FrontRecords.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>

#include <optional>

namespace talik {

/// Transfer between the points of both sides and the front nodes.
template <int D> class FrontTransfer {
public:
	/// The points as their effects have them: solid, water (null in ground without) and content of the pores by place; masses [kg], porosity [-].
	/// gather() corrects velocity, position, displacement and gradient of the solid, and the velocity of the water.
	struct Points {
		SolidMotion<D>& motion;
		PoreWater<D>*   water;
		const double *  waterMass, *iceMass, *porosity;
		double          liquidMass(int place) const { return waterMass[place] - iceMass[place]; }
	};
	explicit FrontTransfer(const FrontConstants& constants)
	        : constants_(constants)
	{}
	/// slip: path of each point along the front [m], which gather() adds to.
	void bind(const FrontNodes<D>& nodes, FrontRecords<D>& records, double* slip, int points, bool water);
	/// Only points of this part are used from now on.
	void keepOnly(int firstPoint, int endPoint);

	/// Strength of a thawed point near the front; none where its law states none.
	void setStrength(int place, const std::optional<ShearStrength>& strength);

	/// Adds what the points of a block near the front bring; affine may be null.
	void map(const StepContext<D>& step, const WeightBlock<D>& w, const Points& points, const AffineVelocity<D>* affine);
	/// Adds a force [N] on point k of a block that its stress does not contain.
	void push(const WeightBlock<D>& w, int k, const Vec<D>& force);
	void pushNode(int place, int node, const Vec<D>& force);
	/// Adds the weight of the frozen side; call before mirrors are folded.
	void addGravity(const Vec<D>& gravity);
	/// Gives the frozen side its part, by mass, of a load on a front node of this mass [N]; call before mirrors are folded.
	void addLoad(int slot, double mass, const Vec<D>& force);
	/// What map() and push() add to.
	void shareMapped(const std::vector<int>& rowStarts, HaloExchange& rows);
	/// Corrects velocity, position, displacement and displacement gradient of a block; affine may be null.
	void gather(const StepContext<D>& step, const WeightBlock<D>& w, const Points& points, const AffineVelocity<D>* affine);
	/// Correction of the velocity [m/s] with which a point moves at a node; null for none.
	const double* correction(int node, int place) const;

private:
	using Loops                          = NodeLoops<D>;
	using R                              = FrontRecords<D>;
	using Frozen                         = typename R::Frozen;
	using Thawed                         = typename R::Thawed;
	template <class Columns> using Share = typename Loops::template Shares<Columns>::Share;

	void   bringFrozen(const Points& points, int place, Share<Frozen>& share) const;
	void   bringThawed(const Points& points, int place, Share<Thawed>& share) const;
	void   bringPores(const Points& points, int place, Share<typename R::Pores>& share) const;
	void   bringAffine(const Grid<D>& grid, const WeightBlock<D>& w, int k, double mass, const AffineVelocity<D>& affine);
	void   move(const Points& points, int place, double dt, const typename Loops::FrontSums& sums) const;
	double fullMass(const Points& points, int place) const;

	FrontConstants       constants_;
	const FrontNodes<D>* nodes_   = nullptr;
	FrontRecords<D>*     records_ = nullptr;
	double*              slip_    = nullptr;
	PagedArray<double>   friction_, cohesion_; ///< by place, of thawed points near the front [-], [Pa]
	PagedArray<double>   mappedLiquid_;        ///< by place, liquid mass of points near the front when it was mapped [kg]
};

} // namespace talik
