// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/ThawFront.hpp>
#include <pkg/mpm/ThreadTeam.hpp>
#include <pkg/thm/Errors.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

namespace {
	constexpr unsigned char thawedBit = 1, frozenBit = 2, bothBits = 3;

	/// A side with less of a node's mass than this has no velocity of its own there: the quotient would be round-off.
	constexpr double smallestMassShare = 1e-9;
	/// Least |sum_F V grad S| h over the smaller of both volumes at a node: 1.5 and more along a plane front, about 1 for a single point.
	/// Below, the front has no direction and both sides move together.
	constexpr double smallestDefinition = 0.3;
	/// Least thickness over h of the thawed ground that takes up the slip.
	constexpr double leastThickness = 0.25;
	/// The traction of the points is scaled to the reaction up to this factor; beyond, it is round-off.
	constexpr double largestScale = 1e3;
	/// Coefficient of friction beyond which the law of the thawed points states none.
	constexpr double largestFriction = 1e3;
	/// Normal stress of the thawed points over the reaction per area beyond which it is led back, within some steps.
	constexpr double leastPressure = 0.5, mostPressure = 1.1, leadingSteps = 5.0;
	/// Slip that thawed points take as strain in a step, as stress over the reaction per area, where their normal stress is far from that:
	/// stress would jump past it.
	constexpr double settlingStress = 1.0;
	constexpr double unlimited      = 1e30;
	/// Coefficient of friction of thawed ground whose law states none: sin(phi) of samples of discs is 0.40 to 0.44.
	constexpr double usualFriction = 0.4;
	/// Strain of a step with which pressure is led back at most.
	constexpr double largestLeading = 1e-2;
	/// Strain with which pressure is led back altogether, as stress over the reaction per area. It makes up for pressure that shear moves
	/// between the axes, which is of the reaction's size. Without a bound it would undo compression that the nodes go on with, until
	/// the pores of the point are crushed.
	constexpr double mostLed = 2.0;
	/// Normal force that ties the sides outside frozen ground, over the one with which they press at the nodes beside, in ground without water.
	constexpr double mostTied = 3.0;
	/// Part of what the shear force takes from the motion of the sides that the normal force may give back. With all of it a layer on the front made energy
	/// in one of 8000 random scenes, with less than half a layer of two cells is held back over its foot.
	constexpr double mostReturned = 0.5;
	/// Part of gravity along the normal from which on thawed ground lies on frozen ground.
	constexpr double leastWeight = 0.5;
	/// Slip of thawed points over h from which on the sides of a cell strain each on their own.
	constexpr double leastSlip = 1e-2;
	/// Part of a node's volume that frozen ground fills from which on the node lies inside it.
	constexpr double insideShare = 0.25;
	/// Water over what the pores hold, from which on they begin to be full, and from which on they are.
	constexpr double nearlyFull = 0.97, full = 0.99;
	/// Part of the thawed volume at the front that nodes of thawed ground alone hold, from which on its own stress is that of a layer. A single row of
	/// points is held by front nodes alone, and nothing keeps its stress.
	constexpr double heldShare = 0.04;
} // namespace

void ThawFrontSettings::validate() const
{
	requireSetting(thawedBelow >= 0.0 && thawedBelow < 1.0, "thawFront.thawedBelow", thawedBelow, "must lie in [0, 1)");
	requireSetting(frozenAbove > thawedBelow && frozenAbove <= 1.0, "thawFront.frozenAbove", frozenAbove, "must lie above thawedBelow, up to 1");
}

template <int D>
ThawFront<D>::ThawFront(PointFields& fields, const ThawFrontSettings& settings)
        : settings_(settings)
        , sideField_(fields.declare("frozenSide", "thaw front", "-", 1))
        , slipField_(fields.declare("slip", "thaw front", "m", 1))
        , ledField_(fields.declare("ledStrain", "thaw front", "-", 1))
        , strainField_(fields.declare("slipStrain", "thaw front", "-", D * D, false))
{}

template <int D>
void ThawFront<D>::bind(
        MaterialPoints<D>& points, const Grid<D>& grid, SolidMotion<D>& motion, PoreWater<D>* water, const double* iceSaturation, const double* waterMass,
        const double* iceMass, const double* porosity)
{
	points_        = &points;
	motion_        = &motion;
	water_         = water;
	iceSaturation_ = iceSaturation;
	waterMass_     = waterMass;
	iceMass_       = iceMass;
	porosity_      = porosity;
	spacing_       = grid.spacing();
	side_          = points.fields().component(sideField_);
	slip_          = points.fields().component(slipField_);
	led_           = points.fields().component(ledField_);
	for (int c = 0; c < D * D; ++c)
		strain_[c] = points.fields().component(strainField_, c);
	margin_ = 0;
	reach_.assign(1, 0);
	beside_.assign(1, 0);
	for (int a = 0; a < D; ++a) {
		margin_ += 2 * grid.nodeStride(a);
		std::vector<int> wider;
		for (const int from : reach_)
			for (int step = -2; step <= 1; ++step)
				wider.push_back(from + step * grid.nodeStride(a));
		reach_ = wider;
		wider.clear();
		for (const int from : beside_)
			for (int step = -1; step <= 1; ++step)
				wider.push_back(from + step * grid.nodeStride(a));
		beside_ = wider;
	}
	// a node on a wall has half a cell, one in a corner a quarter
	volume_.assign(grid.nodeCount(), grid.cellVolume());
	for (int i = 0; i < grid.nodeCount(); ++i)
		for (int a = 0; a < D; ++a) {
			const int at = grid.nodeOf(i)[a];
			if (at == 1 || at == grid.cells(a) + 1) volume_[i] *= 0.5;
		}
	const std::size_t size = grid.nodeCount() + 2 * margin_;
	cell_.reset(points.count());
	for (auto* values : { &modulus_, &friction_, &cohesion_ })
		values->reset(points.count());
	if (water) mappedLiquid_.reset(points.count());
	sides_.assign(size, 0);
	slid_.assign(size, 0);
	reached_.assign(size, 0);
	near_.assign(size, 0);
	slot_.assign(grid.nodeCount(), -1);
	nodes_.clear();
}

template <int D> void ThawFront<D>::start(int first, int end)
{
	for (int p = first; p < end; ++p)
		side_[p] = iceSaturation_[p] > settings_.thawedBelow ? 1.0 : 0.0;
}

template <int D> void ThawFront<D>::keepOnly(int firstPoint, int endPoint)
{
	cell_.keepOnly(firstPoint, endPoint);
	for (auto* values : { &modulus_, &friction_, &cohesion_, &mappedLiquid_ })
		values->keepOnly(firstPoint, endPoint);
}

// ---- where both sides meet -------------------------------------------------------------------------------------------------

template <int D> void ThawFront<D>::updateSides(int first, int last)
{
	for (int p = first; p < last; ++p)
		side_[p] = iceSaturation_[p] >= settings_.frozenAbove ? 1.0 : iceSaturation_[p] <= settings_.thawedBelow ? 0.0 : side_[p];
}

template <int D> void ThawFront<D>::markCells(const Grid<D>& grid, int first, int last)
{
	std::array<const double*, D> x;
	for (int a = 0; a < D; ++a)
		x[a] = points_->position(a);
	for (int p = first; p < last; ++p) {
		int lower = margin_;
		for (int a = 0; a < D; ++a)
			lower += (std::min(int((x[a][p] - grid.lower()[a]) * grid.inverseSpacing()), grid.cells(a) - 1) + 1) * grid.nodeStride(a);
		cell_[p] = lower;
		sides_[lower] |= frozen(p) ? frozenBit : thawedBit;
		slid_[lower] |= !frozen(p) && slip_[p] > leastSlip * spacing_;
	}
}

template <int D> void ThawFront<D>::markNodes(const ActiveRange& range, const Mirrors& mirrors, const std::vector<int>& freeLiquid)
{
	const int first = range.firstNode + margin_, last = range.lastNode + margin_;
	std::fill(reached_.begin(), reached_.end(), 0);
	for (const int step : reach_) {
		const unsigned char* const from = sides_.data() + step;
		unsigned char* const       to   = reached_.data();
		for (int i = first; i < last; ++i)
			to[i] |= from[i];
	}
	const auto join = [&](const auto& m) {
		unsigned char &ghost = reached_[m.ghost + margin_], &inner = reached_[m.inner + margin_];
		ghost = inner = ghost | inner;
	};
	std::for_each(mirrors.begin(), mirrors.end(), join);
	std::for_each(mirrors.rbegin(), mirrors.rend(), join);
	// where the sides part in front of a wall that has left its nodes, each has a velocity of its own on them too
	for (const auto& m : mirrors)
		if (m.lead != 0.0 && reached_[m.inner + margin_] == bothBits) reached_[m.wall() + margin_] = bothBits;
	// the liquid of a ghost that stays free of the wall belongs to no side of the node that its solid is folded into
	for (const int node : freeLiquid)
		reached_[node + margin_] = 0;
	for (const int node : nodes_)
		slot_[node] = -1;
	nodes_.clear();
	for (int i = first; i < last; ++i)
		if (reached_[i] == bothBits) {
			slot_[i - margin_] = int(nodes_.size());
			nodes_.push_back(i - margin_);
		}
}

template <int D> void ThawFront<D>::markNear()
{
	std::fill(near_.begin(), near_.end(), 0);
	for (const int node : nodes_)
		for (const int step : reach_)
			near_[node + margin_ + step] = 1;
}

template <int D> void ThawFront<D>::find(const Grid<D>& grid, const ActiveRange& range, const Mirrors& mirrors, const std::vector<int>& freeLiquid)
{
	std::fill(sides_.begin(), sides_.end(), 0);
	std::fill(slid_.begin(), slid_.end(), 0);
	points_->strips().scatter(
	        [&](int, int first, int last) {
		        updateSides(first, last);
		        markCells(grid, first, last);
	        },
	        [&](SharedRows& rows) {
		        rows.beyond = true;
		        rows.cellsByNode(sides_.data() + margin_);
		        rows.cellsByNode(slid_.data() + margin_);
	        });
	markNodes(range, mirrors, freeLiquid);
	markNear();
	meetings_.resize(nodes_.size());
	records_.assign(nodes_.size(), {});
	results_.assign(nodes_.size(), {});
	normals_.assign(nodes_.size(), {});
	for (Result& result : results_)
		for (const int side : { 0, sideSize })
			result.number[side + Side::present] = 1.0;
	work_.assign(nodes_.size(), 0.0);
}

template <int D> void ThawFront<D>::shareMapped(const Grid<D>& grid, SharedRows& rows)
{
	const int row = grid.nodeStride(grid.slowAxis()), count = grid.nodes(grid.slowAxis());
	rowStarts_.resize(count + 1);
	for (int r = 0; r <= count; ++r)
		rowStarts_[r] = int(std::lower_bound(nodes_.begin(), nodes_.end(), r * row) - nodes_.begin());
	rows.someNodes(records_.empty() ? nullptr : records_[0].number, recordSize, rowStarts_);
}

template <int D> void ThawFront<D>::exceptFromMeans(CellMeans<D>& cells, int first, int last) const
{
	const double* volume = points_->volume();
	for (int p = first; p < last; ++p)
		if (water_) cells.setApart(p, near(p) && frozen(p) && slid_[cell_[p]], volume[p]);
		else cells.leaveOut(p, near(p));
}

template <int D> const std::vector<int>& ThawFront<D>::thawedNear(const std::vector<int>& places)
{
	chosen_.clear();
	for (const int p : places)
		if (near(p) && !frozen(p)) chosen_.push_back(p);
	return chosen_;
}

template <int D> void ThawFront<D>::setStrength(int place, const std::optional<ShearStrength>& strength)
{
	friction_[place] = strength ? strength->friction : unlimited;
	cohesion_[place] = strength ? strength->cohesion : 0.0;
}

// ---- to the nodes ----------------------------------------------------------------------------------------------------------

template <int D> void ThawFront<D>::map(const Grid<D>& grid, const WeightBlock<D>& w, const AffineVelocity<D>* affine)
{
	if (!present()) return;
	typename Loops::template Shares<Frozen> frozenShares;
	typename Loops::template Shares<Thawed> thawedShares;
	typename Loops::template Shares<Pores>  poreShares;
	for (int k = 0; k < w.count; ++k) {
		const int p = w.first + k;
		if (!near(p)) continue;
		if (water_) mappedLiquid_[p] = liquidMass(p);
		if (frozen(p)) bringFrozen(p, frozenShares.next(k));
		else {
			bringThawed(p, thawedShares.next(k));
			if (water_) bringPores(w, k, poreShares.next(k));
		}
		if (!affine) continue;
		const int at = frozen(p) ? momentumAt : thawedMomentumAt;
		affine->overMomenta(grid, w, k, motion_->mass[p], [&](int node, const Vec<D>& momentum) {
			if (slot_[node] < 0) return;
			for (int i = 0; i < D; ++i)
				record(slot_[node])[at + i] += momentum[i];
		});
	}
	const typename Loops::template SomeRecords<double> records { slot_.data(), records_[0].number, recordSize };
	nodeLoops<D>().mapFrozen(w, frozenShares, records);
	nodeLoops<D>().mapThawed(w, thawedShares, records);
	nodeLoops<D>().mapPores(w, poreShares, records);
}

template <int D> void ThawFront<D>::bringFrozen(int p, typename Loops::template Shares<Frozen>::Share& share) const
{
	const double m = motion_->mass[p], ml = water_ ? liquidMass(p) : 0.0, volume = motion_->volume[p];
	const double added              = motion_->addedStress ? motion_->addedStress[p] : 0.0;
	share.value[Frozen::mass]       = m;
	share.value[Frozen::liquidMass] = ml;
	share.value[Frozen::volume]     = volume;
	for (int i = 0; i < D; ++i) {
		share.value[Frozen::momentum + i] = m * motion_->velocity[i][p];
		if (water_) share.value[Frozen::liquidMomentum + i] = ml * water_->velocity[i][p];
		for (int a = 0; a < D; ++a)
			share.slope[a][Frozen::force - Frozen::straight + i] = -volume * (motion_->stress[stressIndex<D>(i, a)][p] + (i == a ? added : 0.0));
		share.slope[i][Frozen::area - Frozen::straight + i] = volume;
	}
}

template <int D> void ThawFront<D>::bringThawed(int p, typename Loops::template Shares<Thawed>::Share& share) const
{
	const double volume = motion_->volume[p], m = motion_->mass[p], pressure = water_ ? water_->pressure[p] : 0.0;
	share.value[Thawed::volume] = volume;
	share.value[Thawed::mass]   = m;
	for (int i = 0; i < D; ++i)
		share.value[Thawed::momentum + i] = m * motion_->velocity[i][p];
	share.value[Thawed::liquidMass] = water_ ? liquidMass(p) : 0.0;
	share.value[Thawed::friction]   = volume * friction_[p];
	share.value[Thawed::cohesion]   = volume * cohesion_[p];
	share.value[Thawed::pressure]   = volume * pressure;
	share.value[Thawed::modulus]    = volume * modulus_[p];
	for (int c = 0; c < stressSize<D>; ++c)
		share.value[Thawed::stress + c] = volume * (motion_->stress[c][p] - (c < D ? pressure : 0.0));
}

/// Mass of water that fills the volume of a thawed point where its pores are full [kg]: what it would bear of its weight if it were still.
template <int D> double ThawFront<D>::fullMass(int p) const
{
	const double liquid = liquidMass(p), fraction = water_->liquidFraction[p];
	if (!(liquid > 0.0) || !(fraction > 0.0)) return 0.0;
	const double fill = fraction * waterMass_[p] / (liquid * porosity_[p]);
	return liquid / fraction * std::clamp((fill - nearlyFull) / (full - nearlyFull), 0.0, 1.0);
}

/// Part of a point that front nodes hold.
template <int D> double ThawFront<D>::frontShare(const WeightBlock<D>& w, int k) const
{
	const int* const slots = slot_.data() + w.base[k];
	double           share = 0.0;
	for (int row = 0; row < supportRows<D>; ++row) {
		double along = 0.0;
		for (int n = 0; n < supportNodes; ++n)
			along += slots[w.offset[row * supportNodes + n]] < 0 ? 0.0 : w.value[0][n][k];
		share += w.row(0, row)[k] * along;
	}
	return share;
}

template <int D> void ThawFront<D>::bringPores(const WeightBlock<D>& w, int k, typename Loops::template Shares<Pores>::Share& share) const
{
	const int p                    = w.first + k;
	share.value[Pores::fullMass]   = fullMass(p);
	share.value[Pores::heldVolume] = motion_->volume[p] * (1.0 - frontShare(w, k));
	for (int a = 0; a < D; ++a)
		share.slope[a][Pores::force + a] = motion_->volume[p] * water_->pressure[p];
}

template <int D> void ThawFront<D>::push(const WeightBlock<D>& w, int k, const Vec<D>& force)
{
	if (!present() || !near(w.first + k) || !frozen(w.first + k)) return;
	overNodes<D>(w, k, [&](int node, double s, const Vec<D>&) {
		if (slot_[node] < 0) return;
		for (int i = 0; i < D; ++i)
			record(slot_[node])[forceAt + i] += s * force[i];
	});
}

template <int D> void ThawFront<D>::addGravity()
{
	for (int slot = 0; slot < nodeCount(); ++slot) {
		double*      r    = record(slot);
		const double mass = r[massAt] + r[liquidMassAt];
		for (int a = 0; a < D; ++a)
			r[forceAt + a] += mass * motion_->settings->gravity[a];
	}
}

template <int D> void ThawFront<D>::addLoad(int node, const Vec<D>& force)
{
	if (!present() || slot_[node] < 0) return;
	double*      r     = record(slot_[node]);
	const double share = r[massAt] / motion_->nodes[node][SolidMotion<D>::massAt];
	for (int a = 0; a < D; ++a)
		r[forceAt + a] += share * force[a];
}

// ---- contact ---------------------------------------------------------------------------------------------------------------

template <int D> void ThawFront<D>::fold(const Mirrors& mirrors, double dt)
{
	folded_.assign(mirrors.size(), {});
	for (std::size_t k = 0; k < mirrors.size(); ++k) {
		const auto& m = mirrors[k];
		if (slot_[m.ghost] < 0 || slot_[m.inner] < 0) continue;
		double* ghost = record(slot_[m.ghost]);
		double* inner = record(slot_[m.inner]);
		folded_[k]    = { ghost[massAt], ghost[thawedMassAt], ghost[liquidMassAt], ghost[thawedLiquidMassAt] };
		for (const int at : { massAt, liquidMassAt, volumeAt, thawedVolumeAt, thawedMassAt, thawedLiquidMassAt, frictionAt, cohesionAt, pressureAt,
		                      modulusAt, fullMassAt, heldVolumeAt })
			inner[at] += ghost[at];
		for (int a = 0; a < D; ++a) {
			for (const int at : { momentumAt, liquidMomentumAt, thawedMomentumAt, forceAt, areaAt, poreForceAt })
				inner[at + a] += m.sign[a] * ghost[at + a];
			inner[momentumAt + a] += m.added(a, ghost[massAt] * m.velocity[a]);
			inner[thawedMomentumAt + a] += m.added(a, ghost[thawedMassAt] * m.velocity[a]);
			inner[liquidMomentumAt + a] += m.added(a, ghost[liquidMassAt] * m.velocity[a]);
			inner[forceAt + a] += m.added(a, (ghost[massAt] + ghost[liquidMassAt]) * m.change[a] / dt);
		}
		for (int a = 0; a < D; ++a)
			for (int b = a; b < D; ++b)
				inner[stressAt + stressIndex<D>(a, b)] += m.sign[a] * m.sign[b] * ghost[stressAt + stressIndex<D>(a, b)];
		std::fill(ghost, ghost + recordSize, 0.0);
	}
}

template <int D> void ThawFront<D>::unfold(const Mirrors& mirrors, StepLedger<D>& ledger)
{
	for (std::size_t k = mirrors.size(); k-- > 0;) {
		const auto& m = mirrors[k];
		if (slot_[m.ghost] < 0 || slot_[m.inner] < 0) continue;
		const std::array<double, 4>& mass    = folded_[k];
		const double*                inner   = result(slot_[m.inner]);
		StepAccount<D>&              account = ledger.ofNode(m.inner);
		// what the sides gain cancels out on a node and its image together; a wall turns the part of the image round
		for (int a = 0; a < D; ++a) {
			const double turned = (m.sign[a] - 1.0)
			        * (mass[0] * inner[gainAt + a] + mass[1] * inner[sideSize + gainAt + a] + mass[2] * inner[liquidGainAt + a]
			           + mass[3] * inner[sideSize + liquidGainAt + a]);
			account.impulse[a] += turned;
			account.wallWork += turned * (m.velocity[a] + m.change[a]);
		}
		double* const ghost = result(slot_[m.ghost]);
		for (int a = 0; a < D; ++a) {
			for (const int at : { velocityAt, gainAt, liquidGainAt })
				for (const int side : { 0, sideSize })
					ghost[side + at + a] = m.sign[a] * inner[side + at + a];
			for (const int at : { SlipStrain::at + SlipStrain::slip, SlipStrain::at + SlipStrain::lacking })
				for (int b = 0; b < D; ++b)
					ghost[at + a * D + b] = m.sign[a] * m.sign[b] * inner[at + a * D + b];
			normals_[slot_[m.ghost]][a] = m.sign[a] * normals_[slot_[m.inner]][a];
		}
		ghost[Slip::at + Slip::limit] = inner[Slip::at + Slip::limit];
	}
}

/// The wall of the mirror has left its nodes, and the sides have velocities of their own in front of it.
template <int D> bool ThawFront<D>::leads(const typename Mirrors::value_type& m) const
{
	using M = SolidMotion<D>;
	return m.lead != 0.0 && slot_[m.inner] >= 0 && slot_[m.wall()] >= 0 && motion_->nodes[m.inner][M::massAt] > 0.0
	        && motion_->nodes[m.wall()][M::massAt] > 0.0;
}

/// The frozen side's part of what the solver pushes ahead of such walls, eq. (8.5). The face of frozen ground on the wall is no front.
template <int D> void ThawFront<D>::pushAhead(const Mirrors& mirrors, double dt)
{
	for (const auto& m : mirrors) {
		if (!leads(m)) continue;
		const double* on    = record(slot_[m.wall()]);
		double*       inner = record(slot_[m.inner]);
		for (int a = 0; a < D; ++a) {
			if (m.sign[a] > 0.0) continue;
			inner[forceAt + a] += m.lead * ((on[massAt] + on[liquidMassAt]) * m.change[a] / dt - on[forceAt + a]);
			inner[areaAt + a] -= m.lead * on[areaAt + a];
		}
	}
}

/// Both sides move with such a wall where it stands, as v_0 of eq. (8.5) has it for their common velocity.
template <int D> void ThawFront<D>::leadWalls(const Mirrors& mirrors, StepLedger<D>& ledger)
{
	for (const auto& m : mirrors) {
		if (!leads(m)) continue;
		const double*   on      = record(slot_[m.wall()]);
		const double*   inner   = result(slot_[m.inner]);
		double*         wall    = result(slot_[m.wall()]);
		StepAccount<D>& account = ledger.ofNode(m.wall());
		const double    follows = meetings_[slot_[m.inner]].follows;
		const double    mass[2] = { on[massAt] + follows * on[liquidMassAt], on[thawedMassAt] + follows * on[thawedLiquidMassAt] };
		for (int side = 0; side < 2; ++side)
			for (int a = 0; a < D; ++a) {
				if (m.sign[a] > 0.0) continue;
				const int    at = side * sideSize + a;
				const double v  = -m.lead * inner[at + velocityAt];
				wall[at + velocityAt] += v;
				wall[at + gainAt] += v;
				if (water_) wall[at + liquidGainAt] += follows * v;
				account.impulse[a] += mass[side] * v;
				account.wallWork += mass[side] * v * (m.velocity[a] + m.change[a]);
			}
	}
}

/// work(node, slot) for the front nodes around a node, and itself if it is one.
template <int D> template <class Work> void ThawFront<D>::overBeside(int node, Work&& work) const
{
	for (const int step : beside_) {
		const int other = node + step;
		if (other >= 0 && other < int(slot_.size()) && slot_[other] >= 0) work(other, slot_[other]);
	}
}

/// Sum of the areas around a node that face as its own does (own: without fixed axes). It gives the direction of the front: the areas of single
/// nodes follow the steps between rows of points, and sides that slide along such steps catch on them.
template <int D> Vec<D> ThawFront<D>::areaAround(int node, const Vec<D>& own, const MotionConstraints<D>& constraints) const
{
	Vec<D> sum {};
	overBeside(node, [&](int other, int slot) {
		const double* area = record(slot) + areaAt;
		Vec<D>        free {};
		double        same = 0.0;
		for (int a = 0; a < D; ++a) {
			if (constraints.solidFixed(node, a) || constraints.solidFixed(other, a)) continue;
			free[a] = area[a];
			same += own[a] * area[a];
		}
		if (!(same > 0.0)) return;
		for (int a = 0; a < D; ++a)
			sum[a] += free[a];
	});
	return sum;
}

/// Part of a change of the solid's velocity that implicit drag gives to the liquid of a node within the step. Liquid that drag does not
/// hold flows on: if it jumped with the solid, its flow along the front would do work on the jump that nobody gave.
template <int D> double ThawFront<D>::followingLiquid(int node, double dt) const
{
	if (!water_) return 0.0;
	const double drag = dt * water_->nodes[node][PoreWater<D>::dragAt], sum = drag + water_->nodes[node][PoreWater<D>::massAt];
	return sum > 0.0 ? drag / sum : 0.0;
}

/// What the liquid of the sides does to the jump of their solids, eq. (20.1). The force that drives the liquid of the node is divided by mass.
template <int D> double ThawFront<D>::jumpByDrag(int slot, int axis, double dt) const
{
	const Meeting& m      = meetings_[slot];
	const int      node   = nodes_[slot];
	const double*  all    = water_->nodes[node];
	const double   frozen = record(slot)[liquidMomentumAt + axis], thawed = all[PoreWater<D>::momentumAt + axis] - frozen;
	const double   mass    = m.liquid[0] + m.liquid[1];
	const double   flowing = mass > 0.0 ? (1.0 - m.follows) * dt * water_->force[node][axis] / mass : 0.0;
	return (m.follows * thawed - m.liquid[1] * flowing) / m.moved[1] - (m.follows * frozen - m.liquid[0] * flowing) / m.moved[0];
}

/// Normal, area and the motion that each side would have without the other.
template <int D> void ThawFront<D>::prepare(int slot, const MotionConstraints<D>& constraints, double dt)
{
	Meeting& m = meetings_[slot];
	m          = Meeting();
	if (!(m.meets = findFront(slot, constraints))) return;
	moveApart(slot, constraints, dt);
	m.resting = settles_ && rests(m, dt);
	takeThawedMeans(slot, constraints);
}

/// Masses, area and normal of a node; false where the sides do not meet.
template <int D> bool ThawFront<D>::findFront(int slot, const MotionConstraints<D>& constraints)
{
	const int     node = nodes_[slot];
	const double *all = motion_->nodes[node], *r = record(slot);
	const double  mass = all[SolidMotion<D>::massAt];
	Meeting&      m    = meetings_[slot];
	if (!(mass > 0.0)) return false; // a ghost, folded into its image
	m.solid  = { r[massAt], r[thawedMassAt] };
	m.liquid = { r[liquidMassAt], r[thawedLiquidMassAt] };
	for (const double solid : m.solid)
		if (!(solid > smallestMassShare * mass)) return false;
	if (!(r[thawedVolumeAt] > 0.0)) return false;
	Vec<D> own {};
	for (int a = 0; a < D; ++a)
		if (!constraints.solidFixed(node, a)) own[a] = r[areaAt + a];
	m.area = lengthOf<D>(own);
	if (!(m.area * spacing_ > smallestDefinition * std::min(r[volumeAt], r[thawedVolumeAt]))) return false;
	m.friction     = r[frictionAt] / r[thawedVolumeAt];
	m.frozenVolume = r[volumeAt];
	m.inside       = r[volumeAt] >= insideShare * volume_[node];
	// the stress of samples feels the steps, too, and the mean over a corner would part a pocket of them from its roof
	m.normal            = statesStrength(m) ? areaAround(node, own, constraints) : own;
	const double length = lengthOf<D>(m.normal);
	if (!(length > 0.0)) return false;
	for (double& component : m.normal)
		component /= length;
	return true;
}

/// Jump between the sides, and the force with which they press, if neither felt the other.
template <int D> void ThawFront<D>::moveApart(int slot, const MotionConstraints<D>& constraints, double dt)
{
	using M            = SolidMotion<D>;
	const int     node = nodes_[slot];
	const double *all = motion_->nodes[node], *r = record(slot);
	Meeting&      m        = meetings_[slot];
	const double  mass[2]  = { m.solid[0] + m.liquid[0], m.solid[1] + m.liquid[1] };
	const double  together = mass[0] * mass[1] / (mass[0] + mass[1]);
	m.follows              = followingLiquid(node, dt);
	for (int side = 0; side < 2; ++side)
		m.moved[side] = m.solid[side] + m.follows * m.liquid[side];
	m.reducedMass = m.moved[0] * m.moved[1] / (m.moved[0] + m.moved[1]);
	for (int a = 0; a < D; ++a) {
		if (constraints.solidFixed(node, a)) continue;
		const double force[2] = { r[forceAt + a], all[M::forceAt + a] - r[forceAt + a] };
		const double parting  = force[1] / mass[1] - force[0] / mass[0];
		m.jump[a]             = (r[thawedMomentumAt + a] + dt * force[1]) / m.moved[1] - (r[momentumAt + a] + dt * force[0]) / m.moved[0];
		if (water_) m.jump[a] += jumpByDrag(slot, a, dt);
		m.pressing -= together * parting * m.normal[a];
	}
}

/// What the thawed points bring to the contact, by their volume.
template <int D> void ThawFront<D>::takeThawedMeans(int slot, const MotionConstraints<D>& constraints)
{
	const double* r      = record(slot);
	const double  volume = r[thawedVolumeAt];
	Meeting&      m      = meetings_[slot];
	m.cohesion           = r[cohesionAt] / volume;
	m.pressure           = r[pressureAt] / volume;
	if (water_) {
		m.held     = r[heldVolumeAt] / volume;
		m.buoyancy = buoyancyOf(slot);
	}
	m.impedance = std::sqrt(r[modulusAt] * (m.solid[1] + m.liquid[1])) / volume;
	for (int i = 0; i < D; ++i) {
		if (constraints.solidFixed(nodes_[slot], i)) continue; // a wall takes it
		for (int j = 0; j < D; ++j)
			m.traction[i] += r[stressAt + stressIndex<D>(i, j)] * m.normal[j] / volume;
	}
}

/// Thawed ground that rests and loses volume settles with one normal velocity at all front nodes. Forces bounded by their mean would let it sink
/// into frozen ground, and a tie that holds one way only would lift it. Ground slides where its slip is faster than what it moves along the normal
/// and than gravity moves it in a step.
template <int D> bool ThawFront<D>::rests(const Meeting& m, double dt) const
{
	const Vec<D>& gravity = motion_->settings->gravity;
	const double  weight = lengthOf<D>(gravity), along = dot<D>(m.jump, m.normal), slipping = dot<D>(m.jump, m.jump) - along * along;
	return -dot<D>(gravity, m.normal) > leastWeight * weight && slipping <= std::max(along * along, weight * weight * dt * dt);
}

/// Inside frozen ground the sides share their normal velocity where they press. The reaction is that of forces alone: what a side's velocity
/// differs from the other's is mostly the slope of one velocity field.
template <int D> void ThawFront<D>::press(int slot, double dt)
{
	Meeting& m = meetings_[slot];
	if (!m.meets || !m.inside) return;
	const double opening = dot<D>(m.jump, m.normal), carried = m.area * std::max(0.0, dot<D>(m.traction, m.normal));
	const double together = -m.reducedMass * opening;
	m.together            = m.resting || opening <= std::max(0.0, m.pressing + carried) / (m.area * m.impedance) || -together <= dt * carried;
	m.reaction            = m.together ? std::max(m.pressing, -carried) : -carried;
	m.impulse             = m.together ? together : -dt * carried;
	m.bound               = m.together;
}

namespace {
	/// Force [N] between sides that would need `tie` for one velocity, where those beside press with `beside` per area. No more than what ties them, as the
	/// area at the end of a block of frozen ground is that of the block alone. Ground that rests needs a little more than that at some nodes and less at
	/// others; pore pressure bears the difference by itself.
	double tying(double tie, double beside, bool water) { return tie <= (water ? 1.0 : mostTied) * beside ? tie : beside; }
} // namespace

/// Outside frozen ground its shape functions only trail: to tie the sides there would hold the thawed ground at a distance. They press as they do at
/// the nodes beside, per area. Where dry thawed ground lies on frozen ground they are not tied at all, so that a layer may bend and shear through
/// itself there.
template <int D> void ThawFront<D>::pressAsBeside(int slot, double dt)
{
	Meeting& m = meetings_[slot];
	if (!m.meets || m.inside) return;
	double force = 0.0, area = 0.0;
	overBeside(nodes_[slot], [&](int, int other) {
		const Meeting& beside = meetings_[other];
		if (!beside.meets || !beside.inside) return;
		force += beside.reaction;
		area += beside.area;
		m.bound |= beside.together;
	});
	if (!(area > 0.0)) return;
	const double both = -m.reducedMass * dot<D>(m.jump, m.normal), tie = std::max(0.0, both), beside = dt * force / area * m.area;
	const bool   liesOnFrozen = !water_ && dot<D>(motion_->settings->gravity, m.normal) < 0.0;
	// forces may part the sides no faster than ground falls: a trace of one side would be driven away
	const double parting = dt * (m.pressing + m.reducedMass * lengthOf<D>(motion_->settings->gravity));
	const double pressed = std::max(0.0, liesOnFrozen ? std::min(beside, std::max(tie, parting)) : tying(tie, beside, water_));
	m.impulse            = m.resting ? both : pressed;
	m.reaction           = pressed / dt;
}

/// Whether the law of the thawed points states its strength.
template <int D> bool ThawFront<D>::statesStrength(const Meeting& m) { return m.friction < largestFriction; }

/// Part of the reaction that pore water of the thawed side bears if it does not flow along the normal [N]: what keeps it from moving through the
/// frozen side, by the balance of its own forces, as R is by those of all.
template <int D> double ThawFront<D>::buoyancyOf(int slot) const
{
	const Meeting& m     = meetings_[slot];
	const double*  r     = record(slot);
	const double*  all   = motion_->nodes[nodes_[slot]];
	const double   sum   = m.solid[0] + m.solid[1] + m.liquid[0] + m.liquid[1];
	double         force = 0.0;
	for (int a = 0; a < D; ++a)
		force -= m.normal[a] * (r[fullMassAt] * (motion_->settings->gravity[a] - all[SolidMotion<D>::forceAt + a] / sum) + r[poreForceAt + a]);
	return force;
}

/// Pore pressure over the normal stress between the sides, eq. (20.2). That of the points, which lie away from the front: both rise with depth in
/// one ratio. Points that front nodes alone hold have no stress to tell it; their water bears what it would at rest.
template <int D> double ThawFront<D>::poreShare(int slot) const
{
	double buoyancy = 0.0, reaction = 0.0, held = 0.0;
	overBeside(nodes_[slot], [&](int, int other) {
		const Meeting& beside = meetings_[other];
		if (!beside.meets) return;
		held = std::max(held, beside.held);
		if (!beside.inside) return;
		buoyancy += beside.buoyancy;
		reaction += beside.reaction;
	});
	const Meeting& m      = meetings_[slot];
	const double   normal = -dot<D>(m.traction, m.normal), told = std::min(1.0, held / heldShare);
	const double   bearing = normal > 0.0 ? normal : m.reaction / m.area;
	const double   points  = m.pressure > 0.0 ? std::min(1.0, m.pressure / bearing) : 0.0;
	const double   still   = reaction > 0.0 ? std::clamp(buoyancy / reaction, 0.0, 1.0) : 0.0;
	return told * points + (1.0 - told) * still;
}

/// Normal force between the sides that grains carry [N].
template <int D> double ThawFront<D>::effectiveReaction(int slot) const
{
	const Meeting& m = meetings_[slot];
	return water_ ? m.reaction * (1.0 - poreShare(slot)) : m.reaction;
}

/// Impulse against the slip that friction and cohesion can give: the strength of the thawed ground, eq. (20.2).
template <int D> double ThawFront<D>::strengthOf(int slot, double dt) const
{
	const Meeting& m = meetings_[slot];
	return m.bound ? std::max(0.0, m.cohesion * m.area + m.friction * effectiveReaction(slot)) * dt : 0.0;
}

/// The same where frozen ground lies on thawed ground whose law states no strength. A row of points between that and its own base shears one way
/// above and the other way below; its stress, the mean of both, would hold neither.
template <int D> double ThawFront<D>::strengthUnderRoof(const Meeting& m) const
{
	const Vec<D>& gravity = motion_->settings->gravity;
	const bool    carries = dot<D>(gravity, m.normal) > leastWeight * lengthOf<D>(gravity);
	return carries && m.impulse > 0.0 ? usualFriction * m.impulse : 0.0;
}

/// Impulse of the shear stress that the thawed points carry, eq. (20.2a), where their law states no strength. They lie away from the front and
/// have a normal stress of their own; both stresses rise with depth in one ratio.
template <int D> Vec<D> ThawFront<D>::carriedShear(int slot, const Vec<D>& slip, double dt) const
{
	const Meeting& m        = meetings_[slot];
	const double   pressure = -dot<D>(m.traction, m.normal), reaction = m.reaction / m.area;
	const double   ratio = pressure > 0.0 ? std::clamp(reaction / pressure, 0.0, largestScale) : reaction < 0.0 ? 1.0 : 0.0;
	Vec<D>         shear;
	double         held = 0.0, slipping = 0.0, square = 0.0;
	for (int i = 0; i < D; ++i) {
		shear[i] = -dt * m.area * ratio * (m.traction[i] + pressure * m.normal[i]);
		held -= shear[i] * slip[i];
		slipping += slip[i] * slip[i];
		square += shear[i] * shear[i];
	}
	// Against the slip never more than what stops it. Stress that springs back, or acts across the slip, pushes; where a node has only a trace of
	// thawed ground, that ground cannot push with the area of the front.
	const double stopping = m.reducedMass * slipping, thickness = record(slot)[thawedVolumeAt] / m.area;
	double       share = held > stopping ? stopping / held : 1.0;
	if (share * square > 2.0 * held * m.reducedMass) share = std::min(share, thickness / (leastThickness * spacing_));
	for (int i = 0; i < D; ++i)
		shear[i] *= share;
	return shear;
}

/// What a shear force between the sides takes from their motion in the step [J].
template <int D> double ThawFront<D>::takenBy(const Meeting& m, const Vec<D>& shear, const Vec<D>& slip)
{
	double taken = 0.0;
	for (int i = 0; i < D; ++i)
		taken -= shear[i] * (slip[i] + 0.5 * shear[i] / m.reducedMass);
	return taken;
}

/// Impulse along the normal that parts the sides no faster than they met, but for what adds a part of the energy to their motion that the shear force
/// takes from it: the normal force adds no more.
template <int D> double ThawFront<D>::passive(const Meeting& m, double opening, const Vec<D>& shear, const Vec<D>& slip)
{
	const double tie = -m.reducedMass * opening;
	if (!(m.impulse > 2.0 * std::max(0.0, tie))) return m.impulse;
	const double returned = mostReturned * std::max(0.0, takenBy(m, shear, slip));
	return std::min(m.impulse, std::max(0.0, tie + std::sqrt(tie * tie + 2.0 * m.reducedMass * returned)));
}

/// Friction between the sides, and the jump that is left. Returns the work that the force between the sides takes up.
template <int D> double ThawFront<D>::slide(int slot, double dt)
{
	Meeting& m = meetings_[slot];
	if (!m.meets) return 0.0;
	const double opening = dot<D>(m.jump, m.normal);
	Vec<D>       slip;
	for (int i = 0; i < D; ++i)
		slip[i] = m.jump[i] - opening * m.normal[i];
	const double speed = lengthOf<D>(slip), strength = statesStrength(m) ? strengthOf(slot, dt) : strengthUnderRoof(m);
	const double held = speed > 0.0 ? std::min(1.0, strength / (m.reducedMass * speed)) : 0.0;
	Vec<D>       shear {};
	if (held > 0.0 || statesStrength(m))
		for (int i = 0; i < D; ++i)
			shear[i] = -held * m.reducedMass * slip[i];
	else shear = carriedShear(slot, slip, dt);
	m.impulse   = passive(m, opening, shear, slip);
	double work = 0.0;
	for (int i = 0; i < D; ++i) {
		const double impulse = shear[i] + m.impulse * m.normal[i];
		m.jump[i] += impulse / m.reducedMass;
		work -= impulse * m.jump[i];
	}
	return work;
}

/// Normal stress that the thawed points lack against the reaction [Pa]. Where all nodes of a thin layer are front nodes nothing else holds
/// it, and without it they have no friction; ground that shears at constant volume gains or loses it.
template <int D> double ThawFront<D>::lackingPressure(const Meeting& m) const
{
	const double reaction = m.reaction / m.area, pressure = -dot<D>(m.traction, m.normal);
	if (!m.inside || !m.together || !(reaction > 0.0)) return 0.0;
	return pressure < leastPressure * reaction ? leastPressure * reaction - pressure : std::min(0.0, mostPressure * reaction - pressure);
}

/// Corrections for both sides from the jump between them.
template <int D> void ThawFront<D>::correct(int slot)
{
	const Meeting& m = meetings_[slot];
	if (!m.meets) return;
	const int     node = nodes_[slot];
	const double* r    = record(slot);
	double*       out  = result(slot);
	const double  kept = motion_->kept, keptLiquid = water_ ? water_->kept : 0.0;
	Vec<D>        departure[2], liquidDeparture[2];
	for (int a = 0; a < D; ++a) {
		const double common   = (r[momentumAt + a] + r[thawedMomentumAt + a]) / (m.solid[0] + m.solid[1]);
		const double start[2] = { r[momentumAt + a] / m.solid[0], r[thawedMomentumAt + a] / m.solid[1] };
		for (int side = 0; side < 2; ++side) {
			departure[side][a]       = start[side] - common;
			liquidDeparture[side][a] = 0.0;
			if (!water_ || !(m.liquid[side] > smallestMassShare * (m.liquid[0] + m.liquid[1]))) continue;
			const double momentum    = side == 0 ? r[liquidMomentumAt + a]
			                                     : water_->nodes[node][PoreWater<D>::momentumAt + a] - r[liquidMomentumAt + a];
			liquidDeparture[side][a] = momentum / m.liquid[side] - water_->start[node][a];
		}
	}
	for (int side = 0; side < 2; ++side) {
		double*      s     = out + side * sideSize;
		const double share = (side == 0 ? -m.moved[1] : m.moved[0]) / (m.moved[0] + m.moved[1]);
		// along the normal of sides that stay together points take the acceleration of the node, as anywhere else
		const double along       = m.together ? dot<D>(departure[side], m.normal) : 0.0;
		const double liquidAlong = m.together ? dot<D>(liquidDeparture[side], m.normal) : 0.0;
		for (int a = 0; a < D; ++a) {
			s[velocityAt + a] = share * m.jump[a];
			s[gainAt + a]     = s[velocityAt + a] - kept * (departure[side][a] - along * m.normal[a]);
			// what drag does not give to the liquid of a side it keeps of its own
			const double liquidAcross = liquidDeparture[side][a] - liquidAlong * m.normal[a];
			if (water_) s[liquidGainAt + a] = m.follows * s[velocityAt + a] + (1.0 - m.follows - keptLiquid) * liquidAcross;
		}
	}
	const double opened = dot<D>(m.jump, m.normal), perThickness = 1.0 / std::max(r[thawedVolumeAt] / m.area, leastThickness * spacing_);
	// sides that do not press do not shear each other
	const bool   strains = !statesStrength(m);
	const double fed = strains && m.inside && m.reaction > 0.0 ? perThickness : 0.0, lacking = strains ? lackingPressure(m) : 0.0;
	normals_[slot]              = m.normal;
	out[Slip::at + Slip::limit] = lacking == 0.0 ? unlimited : settlingStress * m.reaction / m.area;
	double* const strain        = out + SlipStrain::at;
	for (int i = 0; i < D; ++i)
		for (int j = 0; j < D; ++j) {
			strain[SlipStrain::slip + i * D + j]    = (m.jump[i] - opened * m.normal[i]) * fed * m.normal[j];
			strain[SlipStrain::lacking + i * D + j] = lacking * m.normal[i] * m.normal[j];
		}
}

/// Velocity of the thawed side along the front.
template <int D> void ThawFront<D>::giveSlip(int slot)
{
	double* const out = result(slot);
	Vec<D>        jump;
	for (int a = 0; a < D; ++a)
		jump[a] = out[sideSize + velocityAt + a] - out[velocityAt + a];
	const double opened = dot<D>(jump, normals_[slot]);
	for (int a = 0; a < D; ++a)
		out[Slip::at + Slip::velocity + a] = jump[a] - opened * normals_[slot][a];
}

template <int D>
void ThawFront<D>::solve(const MotionConstraints<D>& constraints, const Mirrors& mirrors, const ActiveRange& range, double dt, StepLedger<D>& ledger)
{
	fastest_ = 0.0;
	if (!present()) return;
	fold(mirrors, dt);
	pushAhead(mirrors, dt);
	const int     count     = nodeCount();
	constexpr int piece     = 64;
	const auto    overSlots = [&](auto&& work) {
                ThreadTeam::run((count + piece - 1) / piece, range.parallel ? ThreadTeam::threads() : 1, [&](int i, int) {
                        for (int slot = i * piece; slot < std::min(count, (i + 1) * piece); ++slot)
                                work(slot);
                });
	};
	overSlots([&](int slot) {
		prepare(slot, constraints, dt);
		press(slot, dt);
	});
	overSlots([&](int slot) {
		pressAsBeside(slot, dt);
		work_[slot] = slide(slot, dt);
		correct(slot);
	});
	leadWalls(mirrors, ledger);
	unfold(mirrors, ledger);
	strains_ = std::any_of(meetings_.begin(), meetings_.end(), [](const Meeting& m) { return m.meets && !statesStrength(m); });
	overSlots([&](int slot) { giveSlip(slot); });
	for (int slot = 0; slot < count; ++slot)
		for (int side = 0; side < 2; ++side)
			for (int a = 0; a < D; ++a) {
				const double v = result(slot)[side * sideSize + velocityAt + a];
				fastest_       = std::abs(v) <= fastest_ ? fastest_ : std::abs(v); // keeps what is not a number
			}
	for (int slot = 0; slot < count; ++slot)
		ledger.ofNode(nodes_[slot]).slipWork += work_[slot];
}

// ---- to the points ---------------------------------------------------------------------------------------------------------

template <int D> const double* ThawFront<D>::correction(int node, int p) const
{
	if (!present() || !near(p) || slot_[node] < 0) return nullptr;
	return result(slot_[node]) + (frozen(p) ? 0 : sideSize) + velocityAt;
}

namespace {
	/// Scales a strain down to a largest size.
	template <int D> void limitStrain(double (&strain)[D][D], double largest)
	{
		double square = 0.0;
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D; ++j)
				square += strain[i][j] * strain[i][j];
		if (!(square > largest * largest)) return;
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D; ++j)
				strain[i][j] *= largest / std::sqrt(square);
	}
} // namespace

template <int D> void ThawFront<D>::gather(const Grid<D>& grid, const WeightBlock<D>& w, double dt, const AffineVelocity<D>* affine)
{
	if (!present()) return;
	const typename Loops::template SomeRecords<const double> records { slot_.data(), results_[0].number, resultSize };
	for (int k = 0; k < w.count; ++k) {
		const int p = w.first + k;
		if (!near(p)) continue;
		const bool                thawed = !frozen(p);
		typename Loops::FrontSums sums;
		if (thawed) nodeLoops<D>().gatherThawed(w, k, records, strains_, sums);
		else nodeLoops<D>().gatherFrozen(w, k, records, sums);
		for (int i = 0; i < D; ++i) {
			const double velocity = sums.side[velocityAt + i];
			motion_->velocity[i][p] += sums.side[gainAt + i];
			// water that came by seepage since has diluted the momentum
			if (water_) water_->velocity[i][p] += sums.side[liquidGainAt + i] * (mappedLiquid_[p] / liquidMass(p));
			motion_->position[i][p] += dt * velocity;
			motion_->displacement[i][p] += dt * velocity;
			for (int j = 0; j < D; ++j)
				motion_->gradient[i * D + j][p] += dt * sums.gradient[j][i];
		}
		if (thawed) takeSlip(p, dt, sums);
		if (affine)
			affine->addGradient(
			        grid, w, k, [&](int node) { return slot_[node] < 0 ? nullptr : result(slot_[node]) + (thawed ? sideSize : 0) + velocityAt; });
	}
}

/// Path of a thawed point along the front, and the strain that it gets for it.
template <int D> void ThawFront<D>::takeSlip(int p, double dt, const typename Loops::FrontSums& sums)
{
	Vec<D> slipping;
	for (int i = 0; i < D; ++i)
		slipping[i] = sums.slip[Slip::velocity + i];
	slip_[p] += dt * lengthOf<D>(slipping);
	double slip[D][D] = {};
	if (strains_) {
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D; ++j)
				slip[i][j] = sums.strain[SlipStrain::slip + i * D + j];
		limitStrain(slip, sums.slip[Slip::limit] / (sums.side[Side::present] * modulus_[p] * dt));
		// water holds the normal stress by itself; what grains gained would be taken off its pressure
		if (!water_) lead(p, dt, sums, slip);
	}
	for (int i = 0; i < D; ++i)
		for (int j = 0; j < D; ++j)
			strain_[i * D + j][p] = dt * slip[i][j];
}

/// Strain along the normal that brings what the points lack in pressure, no more than they slip: what stands has no need of it.
template <int D> void ThawFront<D>::lead(int p, double dt, const typename Loops::FrontSums& sums, double (&slip)[D][D])
{
	const double        settling = sums.slip[Slip::limit] / sums.side[Side::present]; // settlingStress times the reaction per area [Pa]
	const double* const lacking  = sums.strain + SlipStrain::lacking;
	double              pressure = 0.0, square = 0.0;
	for (int i = 0; i < D; ++i) {
		pressure += lacking[i * D + i];
		for (int j = 0; j < D; ++j)
			square += slip[i][j] * slip[i][j];
	}
	const double rate = std::abs(pressure) / (modulus_[p] * leadingSteps * dt); // of the strain [1/s]
	if (!(rate > 0.0)) return;
	const double wanted = std::copysign(std::min(rate * dt, std::min(std::sqrt(square) * dt, largestLeading)), -pressure);
	const double most   = mostLed * settling / (settlingStress * modulus_[p]);
	const double strain = wanted > 0.0 ? std::min(wanted, std::max(0.0, most - led_[p])) : std::max(wanted, std::min(0.0, -most - led_[p]));
	led_[p] += strain;
	for (int i = 0; i < D; ++i)
		for (int j = 0; j < D; ++j)
			slip[i][j] += strain * lacking[i * D + j] / (pressure * dt);
}

template <int D> void ThawFront<D>::addSlip(int first, int last)
{
	if (!present()) return;
	for (int p = first; p < last; ++p)
		if (near(p) && !frozen(p))
			for (int c = 0; c < D * D; ++c)
				motion_->gradient[c][p] += strain_[c][p];
}

template <int D> double ThawFront<D>::stressWork(int first, int last) const
{
	double work = 0.0;
	if (!present()) return work;
	for (int p = first; p < last; ++p) {
		if (!near(p) || frozen(p)) continue;
		double density = 0.0;
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D; ++j)
				density += motion_->stress[stressIndex<D>(i, j)][p] * strain_[i * D + j][p];
		work += motion_->volume[p] * density;
	}
	return work;
}

template class ThawFront<2>;
template class ThawFront<3>;

} // namespace talik
