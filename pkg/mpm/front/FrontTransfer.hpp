// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/effects/AffineVelocity.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/front/FrontNodes.hpp>
#include <pkg/mpm/front/FrontRecords.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>

#include <algorithm>
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
	void bind(const FrontNodes<D>& nodes, FrontRecords<D>& records, double* slip, int points, bool water)
	{
		nodes_   = &nodes;
		records_ = &records;
		slip_    = slip;
		friction_.reset(points);
		cohesion_.reset(points);
		if (water) mappedLiquid_.reset(points);
	}
	/// Only points of this part are used from now on.
	void keepOnly(int firstPoint, int endPoint)
	{
		for (auto* values : { &friction_, &cohesion_, &mappedLiquid_ })
			values->keepOnly(firstPoint, endPoint);
	}

	/// Strength of a thawed point near the front; none where its law states none.
	void setStrength(int place, const std::optional<ShearStrength>& strength)
	{
		friction_[place] = strength ? strength->friction : R::unlimited;
		cohesion_[place] = strength ? strength->cohesion : R::unlimited;
	}

	/// Adds what the points of a block near the front bring; affine may be null.
	void map(const StepContext<D>& step, const WeightBlock<D>& w, const Points& points, const AffineVelocity<D>* affine)
	{
		if (nodes_->empty()) return;
		typename Loops::template Shares<Frozen>            frozenShares;
		typename Loops::template Shares<Thawed>            thawedShares;
		typename Loops::template Shares<typename R::Pores> poreShares;
		for (int k = 0; k < w.count; ++k) {
			const int p = w.first + k;
			if (!nodes_->near(p)) continue;
			if (points.water) mappedLiquid_[p] = points.liquidMass(p);
			if (nodes_->frozen(p)) bringFrozen(points, p, frozenShares.next(k));
			else {
				bringThawed(points, p, thawedShares.next(k));
				if (points.water) bringPores(points, p, poreShares.next(k));
			}
			if (affine) bringAffine(step.grid, w, k, points.motion.mass[p], *affine);
		}
		const typename Loops::template SparseRecords<double> records { nodes_->slots(), records_->firstSums(), R::sumsSize };
		nodeLoops<D>().mapFrozen(w, frozenShares, records);
		nodeLoops<D>().mapThawed(w, thawedShares, records);
		nodeLoops<D>().mapPores(w, poreShares, records);
	}
	/// Adds a force [N] on point k of a block that its stress does not contain.
	void push(const WeightBlock<D>& w, int k, const Vec<D>& force)
	{
		overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) { pushNode(w.first + k, node, s * force); });
	}
	void pushNode(int p, int node, const Vec<D>& force)
	{
		if (nodes_->empty() || !nodes_->near(p) || !nodes_->frozen(p) || nodes_->slot(node) < 0) return;
		addTo<D>(records_->sums(nodes_->slot(node)) + R::forceAt, force);
	}
	/// Adds the weight of the frozen side; call before mirrors are folded.
	void addGravity(const Vec<D>& gravity)
	{
		for (int slot = 0; slot < nodes_->count(); ++slot) {
			double* sums = records_->sums(slot);
			addTo<D>(sums + R::forceAt, (sums[R::massAt] + sums[R::liquidMassAt]) * gravity);
		}
	}
	/// Gives the frozen side its part, by mass, of a load on a front node of this mass [N]; call before mirrors are folded.
	void addLoad(int slot, double mass, const Vec<D>& force)
	{
		double* sums = records_->sums(slot);
		addTo<D>(sums + R::forceAt, sums[R::massAt] / mass * force);
	}
	/// What map() and push() add to.
	void shareMapped(const std::vector<int>& rowStarts, HaloExchange& rows)
	{
		rows.someNodes(records_->firstSums(), R::sumsSize, rowStarts, nodes_->slots());
	}
	/// Corrects velocity, position, displacement and displacement gradient of a block; affine may be null.
	void gather(const StepContext<D>& step, const WeightBlock<D>& w, const Points& points, const AffineVelocity<D>* affine)
	{
		if (nodes_->empty()) return;
		const typename Loops::template SparseRecords<const double> records { nodes_->slots(), records_->firstAnswer(), R::answerSize };
		for (int k = 0; k < w.count; ++k) {
			const int p = w.first + k;
			if (!nodes_->near(p)) continue;
			typename Loops::FrontSums sums;
			if (nodes_->frozen(p)) nodeLoops<D>().gatherFrozen(w, k, records, sums);
			else {
				nodeLoops<D>().gatherThawed(w, k, records, sums);
				slip_[p] += step.dt * lengthOf<D>(vectorAt<D>(sums.slip + R::Slip::velocity));
			}
			move(points, p, step.dt, sums);
			if (affine) affine->addGradient(step.grid, w, k, [&](int node) { return correction(node, p); });
		}
	}
	/// Correction of the velocity [m/s] with which a point moves at a node; null for none.
	const double* correction(int node, int p) const
	{
		if (nodes_->empty() || !nodes_->near(p) || nodes_->slot(node) < 0) return nullptr;
		return records_->answer(nodes_->slot(node)) + (nodes_->frozen(p) ? 0 : R::sideSize) + R::velocityAt;
	}

private:
	using Loops                          = NodeLoops<D>;
	using R                              = FrontRecords<D>;
	using Frozen                         = typename R::Frozen;
	using Thawed                         = typename R::Thawed;
	template <class Columns> using Share = typename Loops::template Shares<Columns>::Share;

	void bringFrozen(const Points& points, int p, Share<Frozen>& share) const
	{
		const double m = points.motion.mass[p], ml = points.water ? points.liquidMass(p) : 0.0, volume = points.motion.volume[p];
		const double added              = points.motion.addedStress ? points.motion.addedStress[p] : 0.0;
		share.value[Frozen::mass]       = m;
		share.value[Frozen::liquidMass] = ml;
		share.value[Frozen::volume]     = volume;
		for (int i = 0; i < D; ++i) {
			share.value[Frozen::momentum + i] = m * points.motion.velocity[i][p];
			if (points.water) share.value[Frozen::liquidMomentum + i] = ml * points.water->velocity[i][p];
			for (int a = 0; a < D; ++a)
				share.slope[a][Frozen::force - Frozen::straight + i] = -volume
				        * (points.motion.stress[stressIndex<D>(i, a)][p] + (i == a ? added : 0.0));
			share.slope[i][Frozen::area - Frozen::straight + i] = volume;
		}
	}
	void bringThawed(const Points& points, int p, Share<Thawed>& share) const
	{
		const double volume = points.motion.volume[p], m = points.motion.mass[p], pressure = points.water ? points.water->pressure[p] : 0.0;
		share.value[Thawed::volume] = volume;
		share.value[Thawed::mass]   = m;
		for (int i = 0; i < D; ++i)
			share.value[Thawed::momentum + i] = m * points.motion.velocity[i][p];
		share.value[Thawed::liquidMass] = points.water ? points.liquidMass(p) : 0.0;
		share.value[Thawed::friction]   = volume * friction_[p];
		share.value[Thawed::cohesion]   = volume * cohesion_[p];
		for (int c = 0; c < stressSize<D>; ++c)
			share.value[Thawed::stress + c] = volume * (points.motion.stress[c][p] - (c < D ? pressure : 0.0));
		for (int a = 0; a < D; ++a)
			share.slope[a][Thawed::area - Thawed::straight + a] = volume;
	}
	void bringPores(const Points& points, int p, Share<typename R::Pores>& share) const
	{
		using Columns                  = typename R::Pores;
		share.value[Columns::fullMass] = fullMass(points, p);
		for (int a = 0; a < D; ++a)
			share.slope[a][Columns::force + a] = points.motion.volume[p] * points.water->pressure[p];
	}
	void bringAffine(const Grid<D>& grid, const WeightBlock<D>& w, int k, double mass, const AffineVelocity<D>& affine)
	{
		const int p = w.first + k, at = nodes_->frozen(p) ? R::momentumAt : R::thawedMomentumAt;
		affine.overMomenta(grid, w, k, mass, [&](int node, const Vec<D>& momentum) {
			if (nodes_->slot(node) >= 0) addTo<D>(records_->sums(nodes_->slot(node)) + at, momentum);
		});
	}
	void move(const Points& points, int p, double dt, const typename Loops::FrontSums& sums) const
	{
		SolidMotion<D>& motion = points.motion;
		for (int i = 0; i < D; ++i) {
			const double velocity = sums.side[R::velocityAt + i];
			motion.velocity[i][p] += sums.side[R::gainAt + i];
			// water that came by seepage since has diluted the momentum
			if (points.water) points.water->velocity[i][p] += sums.side[R::liquidGainAt + i] * (mappedLiquid_[p] / points.liquidMass(p));
			motion.position[i][p] += dt * velocity;
			motion.displacement[i][p] += dt * velocity;
			for (int j = 0; j < D; ++j)
				motion.gradient[i * D + j][p] += dt * sums.gradient[j][i];
		}
	}
	/// Mass of water that fills the volume of a thawed point where its pores are full [kg]: what it would bear of its weight if it were still.
	double fullMass(const Points& points, int p) const
	{
		const double liquid = points.liquidMass(p), fraction = points.water->liquidFraction[p];
		if (!(liquid > 0.0) || !(fraction > 0.0)) return 0.0;
		const double fill = fraction * points.waterMass[p] / (liquid * points.porosity[p]);
		return liquid / fraction * std::clamp((fill - constants_.nearlyFull) / (constants_.full - constants_.nearlyFull), 0.0, 1.0);
	}

	FrontConstants       constants_;
	const FrontNodes<D>* nodes_   = nullptr;
	FrontRecords<D>*     records_ = nullptr;
	double*              slip_    = nullptr;
	PagedArray<double>   friction_, cohesion_; ///< by place, of thawed points near the front [-], [Pa]
	PagedArray<double>   mappedLiquid_;        ///< by place, liquid mass of points near the front when it was mapped [kg]
};

} // namespace talik
