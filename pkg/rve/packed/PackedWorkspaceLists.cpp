// SPDX-License-Identifier: GPL-2.0-or-later
// Neighbour lists and the lanes that they fill; contacts in and out of the lanes.
#include <algorithm>
#include <cmath>
#include <Eigen/LU>
#include <numeric>
#include <pkg/rve/packed/ListSkins.hpp>
#include <pkg/rve/packed/PackedWorkspace.hpp>

namespace talik {

// ---------------------------------------------------------------------------------------------- lanes

template <int Dim> void PackedWorkspace<Dim>::Lanes::resize(std::size_t number, bool crosses, PackedContactKind kind)
{
	const std::size_t blocks = (number + packedWidth - 1) / packedWidth;
	pairs                    = number;
	// zero is left in the last block, where lanes may stay free
	const auto fit = [](auto& array, std::size_t length, std::size_t last) {
		array.resize(length);
		std::fill(array.end() - long(std::min(last, length)), array.end(), typename std::decay_t<decltype(array)>::value_type());
	};
	fit(block, blocks, 1);
	fit(shift, crosses ? packedWidth * blocks : 0, packedWidth);
	fit(ice, kind.bonded ? blocks : 0, 1);
	fit(rolling, kind.rolling ? blocks : 0, 1);
	fit(moments, kind.moments ? blocks : 0, 1);
	bond.resize(kind.bonded ? number : 0);
}

template <int Dim> void PackedWorkspace<Dim>::takeHistory(Lanes& lanes, std::size_t lane, const Lanes& from, std::size_t at) const
{
	forMemory([&](bool kept, auto blocks, auto rows, auto) {
		if (!kept) return;
		const auto former = laneShear<Dim>((from.*blocks)[at / packedWidth].*rows, at % packedWidth);
		setLaneShear<Dim>((lanes.*blocks)[lane / packedWidth].*rows, lane % packedWidth, former);
	});
	if (carriesBonds) lanes.bond[lane] = from.bond[at];
}

template <int Dim> void PackedWorkspace<Dim>::forgetHistory(Lanes& lanes, std::size_t lane) const
{
	Shear none;
	clearShear(none);
	forMemory([&](bool kept, auto blocks, auto rows, auto) {
		if (kept) setLaneShear<Dim>((lanes.*blocks)[lane / packedWidth].*rows, lane % packedWidth, none);
	});
	if (carriesBonds) lanes.bond[lane] = IceBond();
}

/// History goes where a rebuild expects it: into the lanes of the "previous" list.
template <int Dim> void PackedWorkspace<Dim>::loadContacts(const PackedState<Dim>& state)
{
	const PackedContacts<Dim>&                         c = state.contacts;
	std::vector<std::pair<std::uint64_t, std::size_t>> order[2];
	for (std::size_t k = 0; k < c.size(); ++k) {
		const PairKey<Dim> pair { c.first[k], c.second[k], c.cellDist[k] };
		order[pair.crossesCell()].emplace_back(pair.encode(), k);
	}
	for (const bool crosses : { false, true }) {
		auto& sorted = order[crosses];
		if (!std::is_sorted(sorted.begin(), sorted.end())) std::sort(sorted.begin(), sorted.end());
		Lanes& lanes = lanesOf(crosses);
		lanes.resize(sorted.size(), crosses, contactKind());
		lanes.keys.resize(sorted.size());
		for (std::size_t lane = 0; lane < sorted.size(); ++lane) {
			lanes.keys[lane] = sorted[lane].first;
			takeContact(lanes, lane, c, sorted[lane].second);
		}
	}
}

template <int Dim> void PackedWorkspace<Dim>::takeContact(Lanes& lanes, std::size_t lane, const PackedContacts<Dim>& c, std::size_t k) const
{
	forMemory([&](bool kept, auto blocks, auto rows, auto array) {
		if (kept) setLaneShear<Dim>((lanes.*blocks)[lane / packedWidth].*rows, lane % packedWidth, (c.*array)[k]);
	});
	if (carriesBonds) lanes.bond[lane] = c.iceBond(k);
}

/// Lists as they were stored: nothing is searched, sorted or compared.
template <int Dim> void PackedWorkspace<Dim>::loadListed(const PackedContacts<Dim>& contacts, const PackedLists<Dim>& lists)
{
	use            = lists;
	slack          = lists.slack;
	referenceKnown = false;
	adoptSlack();
	shiftCell.clear();
	std::size_t k = 0, contact = 0;
	for (const bool crosses : { false, true }) {
		Lanes&            lanes = lanesOf(crosses);
		const std::size_t pairs = crosses ? lists.size() - lists.inside : lists.inside;
		lanes.keys.clear();
		lanes.resize(pairs, crosses, contactKind());
		for (std::size_t lane = 0; lane < pairs; ++lane, ++k) {
			const bool   known = lists.contact(k);
			PairKey<Dim> pair { lists.first[k], lists.second[k], {} };
			if (!known) std::swap(pair.first, pair.second);
			if (crosses) pair.cellDist = lists.cellDist[lane];
			setPair(lanes, lane, pair, crosses);
			if (known) takeContact(lanes, lane, contacts, contact++);
			else forgetHistory(lanes, lane);
		}
		setResponses(lanes);
		fillUp(lanes);
	}
	lanesChanged();
}

/// A pair that touches, or remembers a force or a bond.
template <int Dim> bool PackedWorkspace<Dim>::carriesHistory(const Lanes& lanes, std::size_t lane) const
{
	if (shearNorm(laneShear<Dim>(lanes.block[lane / packedWidth].shear, lane % packedWidth)) != 0) return true;
	if (resistsRolling && shearNorm(laneShear<Dim>(lanes.rolling[lane / packedWidth].moment, lane % packedWidth)) != 0) return true;
	if (carriesBonds && lanes.bond[lane].state != BondState::NONE) return true;
	double       branch[Dim];
	const double reach = lanes.block[lane / packedWidth].sumRadius[lane % packedWidth];
	return pairBranch(view, pairRows(view, &lanes == &periodicLanes ? view.periodic : view.inner, lane), branch) <= reach * reach;
}

template <int Dim> void PackedWorkspace<Dim>::storeContacts(PackedContacts<Dim>& c, PackedLists<Dim>* lists) const
{
	thread_local std::vector<std::uint32_t> kept[2]; // its memory is kept
	for (const bool crosses : { false, true }) {
		const Lanes& lanes = crosses ? periodicLanes : innerLanes;
		kept[crosses].resize(lanes.pairs);
		std::size_t number = 0;
		for (std::size_t lane = 0; lane < lanes.pairs; ++lane) {
			kept[crosses][number] = std::uint32_t(lane);
			number += carriesHistory(lanes, lane);
		}
		kept[crosses].resize(number);
	}
	const std::size_t count = kept[0].size() + kept[1].size();
	const auto        fit   = [count](auto& array, bool wanted) { array.resize(wanted ? count : 0); };
	fit(c.first, true);
	fit(c.second, true);
	fit(c.cellDist, true);
	fit(c.iceReference, carriesBonds);
	fit(c.grainReference, carriesBonds);
	fit(c.bond, carriesBonds);
	forMemory([&](bool kept, auto, auto, auto array) { fit(c.*array, kept); });
	std::size_t k = 0;
	for (const bool crosses : { false, true }) {
		const Lanes& lanes = crosses ? periodicLanes : innerLanes;
		for (const std::uint32_t lane : kept[crosses]) {
			const std::size_t b = lane / packedWidth, l = lane % packedWidth;
			c.first[k]  = std::uint16_t(rowOf(lanes.block[b].first[l]));
			c.second[k] = std::uint16_t(rowOf(lanes.block[b].second[l]));
			for (int d = 0; d < Dim; ++d)
				c.cellDist[k][d] = crosses ? shiftCell[rowOf(lanes.shift[lane]) * Dim + d] : std::int8_t(0);
			forMemory([&](bool kept, auto blocks, auto rows, auto array) {
				if (kept) (c.*array)[k] = laneShear<Dim>((lanes.*blocks)[b].*rows, l);
			});
			if (carriesBonds) {
				const IceBond& bond = lanes.bond[lane];
				c.iceReference[k]   = bond.uIce;
				c.grainReference[k] = bond.uGrain;
				c.bond[k]           = c.encode(bond);
			}
			++k;
		}
	}
	if (lists) storeLists(*lists, kept);
}

template <int Dim> void PackedWorkspace<Dim>::storeLists(PackedLists<Dim>& lists, const std::vector<std::uint32_t> (&kept)[2]) const
{
	static_cast<PackedListUse<Dim>&>(lists) = use;
	lists.slack                             = slack;
	lists.inside                            = innerLanes.pairs;
	lists.first.resize(innerLanes.pairs + periodicLanes.pairs);
	lists.second.resize(lists.first.size());
	lists.cellDist.resize(periodicLanes.pairs);
	std::size_t k = 0;
	for (const bool crosses : { false, true }) {
		const Lanes& lanes = crosses ? periodicLanes : innerLanes;
		for (std::size_t lane = 0; lane < lanes.pairs; ++lane) {
			lists.first[k + lane]  = std::uint16_t(rowOf(lanes.block[lane / packedWidth].second[lane % packedWidth]));
			lists.second[k + lane] = std::uint16_t(rowOf(lanes.block[lane / packedWidth].first[lane % packedWidth]));
			for (int d = 0; crosses && d < Dim; ++d)
				lists.cellDist[lane][d] = shiftCell[rowOf(lanes.shift[lane]) * Dim + d];
		}
		for (const std::uint32_t lane : kept[crosses])
			std::swap(lists.first[k + lane], lists.second[k + lane]);
		k += lanes.pairs;
	}
}

// ---------------------------------------------------------------------------------------------- neighbour lists

/// The cell as the next evaluation of forces will see it.
template <int Dim> void PackedWorkspace<Dim>::predictedCell(double* h) const
{
	multiply<Dim>(view.velGrad, view.hSize, h);
	for (int k = 0; k < Dim * Dim; ++k)
		h[k] = view.hSize[k] + view.dt * h[k];
}

// A pair outside the list was farther apart than r_1 + r_2 + (slack_1 + slack_2) skin. Since then the cell has shortened no length by more
// than the factor 1 - stretch, and no grain has left the affine motion by more than slack times `travel`; both are bounds, so no contact is
// ever missed and results cannot depend on when the list was built. Of all pairs the largest radii with a slack of one come first.
template <int Dim> bool PackedWorkspace<Dim>::listsExhausted() const { return !(use.travel + (largestRadius + use.skin) * use.stretch * 1.01 < use.skin); }

template <int Dim> void PackedWorkspace<Dim>::accumulateTravel()
{
	const double dt = view.dt;
	use.travel += dt * (frobenius<Dim>(view.velGrad) * use.travel + std::sqrt(view.maxFluctuationSquare)) * (1 + 1e-12);
	use.stretch += dt * strainRate<Dim>(view.velGrad);
}

/// Largest deviation from the affine motion since the lists were built, over the slack, exactly.
template <int Dim> double PackedWorkspace<Dim>::measuredTravel() const
{
	Matrix now, before;
	double h[Dim * Dim];
	predictedCell(h);
	copyMatrix<Dim>(h, now);
	copyMatrix<Dim>(use.referenceCell, before);
	const Matrix  deformation = now * before.inverse();
	double        largest     = 0;
	const double* x0          = reference.data()->value;
	// positions are ahead of the cell by one step of the velocity gradient
	for (std::size_t g = 0; g < grainCount; ++g) {
		double square = 0;
		for (int d = 0; d < Dim; ++d) {
			double u = view.position(g)[d];
			for (int e = 0; e < Dim; ++e)
				u -= deformation(d, e) * x0[4 * g + e];
			square += u * u;
		}
		largest = std::max(largest, square * view.inverseSlackSquare[g]);
	}
	return std::sqrt(largest);
}

template <int Dim> void PackedWorkspace<Dim>::refreshLists()
{
	if (listsValid && !listsExhausted()) return;
	if (listsValid && referenceKnown) {
		const double measured = measuredTravel();
		if (measured < use.travel && measured + (largestRadius + use.skin) * use.stretch * 1.01 < 0.7 * use.skin) {
			use.travel = measured * (1 + 1e-9);
			return;
		}
	}
	rebuildLists();
}

/// leastSkin: gap up to which pairs are wanted in the list right now [m].
template <int Dim> void PackedWorkspace<Dim>::rebuildLists(double leastSkin)
{
	checkHealth();
	formKeys(false);
	formKeys(true);
	predictedCell(use.referenceCell);
	chooseSkins(leastSkin);
	std::swap(innerLanes, oldInner);
	std::swap(periodicLanes, oldPeriodic);
	findPairs();
	adoptKeys();
	for (std::size_t g = 0; g < grainCount; ++g)
		for (int d = 0; d < Dim; ++d)
			reference.data()->value[4 * g + d] = view.position(g)[d];
	referenceKnown = true;
	use.travel = use.stretch = 0;
}

/// Speed at which a grain leaves the affine motion [m/s].
template <int Dim> double PackedWorkspace<Dim>::fluctuation(std::size_t grain) const
{
	double square = 0;
	for (int d = 0; d < Dim; ++d) {
		double v = view.velocity(grain)[d];
		for (int e = 0; e < Dim; ++e)
			v -= view.velGrad[d * Dim + e] * view.position(grain)[e];
		square += v * v;
	}
	return std::sqrt(square);
}

/// The skin follows the strain rate, the slack of a grain its speed: the few that fly about between others make no lists longer.
template <int Dim> void PackedWorkspace<Dim>::chooseSkins(double leastSkin)
{
	using Skins       = ListSkins;
	const double time = Skins::stepsOfLists * view.dt, largest = Skins::largestOverRadius * averageRadius;
	const double strained = time * largestRadius * std::max(strainRate<Dim>(view.velGrad), strainRate<Dim>(view.nextVelGrad));
	use.skin              = std::max(std::min(std::max(strained, Skins::leastOverRadius * averageRadius), largest), 0.5 * leastSkin);
	slack.resize(grainCount);
	for (std::size_t g = 0; g < grainCount; ++g) {
		const double wanted = std::min(use.skin + Skins::stepsOfGrain * view.dt * fluctuation(g), Skins::largestOfGrain * averageRadius);
		slack[g]            = 0;
		for (double skin = use.skin; skin < wanted && slack[g] < PackedLists<Dim>::largestSlack; skin *= 2)
			++slack[g];
	}
	adoptSlack();
}

template <int Dim> void PackedWorkspace<Dim>::adoptSlack()
{
	for (std::size_t g = 0; g < grainCount; ++g)
		inverseSlackSquare.data()->value[g] = 1. / double(1u << 2 * slack[g]);
}

/// Keys of the pairs within reach, and of bonds that have opened wider.
template <int Dim> void PackedWorkspace<Dim>::findPairs()
{
	reach.resize(grainCount);
	for (std::size_t g = 0; g < grainCount; ++g)
		reach[g] = view.radius[g] + use.skin * double(1u << slack[g]);
	search.build(view.place, 4, reach.data(), grainCount, use.referenceCell, innerLanes.keys, periodicLanes.keys);
	for (const bool crosses : { false, true }) {
		std::vector<std::uint64_t>& keys = lanesOf(crosses).keys;
		sortPairKeys(keys, sortBuffer, sortCounts);
		const std::size_t found = keys.size();
		if (carriesBonds) keepDistantBonds(crosses ? oldPeriodic : oldInner, keys, keys);
		if (keys.size() > found) sortPairKeys(keys, sortBuffer, sortCounts);
	}
}

/// Lanes for the keys, with the history of the previous ones.
template <int Dim> void PackedWorkspace<Dim>::adoptKeys()
{
	shiftCell.clear();
	fillLanes(innerLanes, oldInner, false);
	fillLanes(periodicLanes, oldPeriodic, true);
	lanesChanged();
}

template <int Dim> void PackedWorkspace<Dim>::lanesChanged()
{
	const std::size_t shifts = shiftCell.size() / Dim;
	shiftPlace.resize((shifts * 4 + packedWidth - 1) / packedWidth);
	shiftSpeed.resize(Dim == 3 ? shifts * 8 / packedWidth : 0);
	shiftForce.resize((shifts * PackedLayout<Dim>::row + packedWidth - 1) / packedWidth);
	// sums over shifts go in the order of their cells: that of the rows depends on which pairs that do not touch are in the lists
	shiftOrder.resize(shifts);
	std::iota(shiftOrder.begin(), shiftOrder.end(), 0u);
	std::sort(shiftOrder.begin(), shiftOrder.end(), [&](std::uint32_t a, std::uint32_t b) {
		const auto cell = [&](std::uint32_t k) { return shiftCell.begin() + k * Dim; };
		return std::lexicographical_compare(cell(a), cell(a) + Dim, cell(b), cell(b) + Dim);
	});
	bind();
	updateShiftRows();
	listsValid = true;
}

/// A bond may open wider than the skin while it stretches: it stays in the list whatever the distance.
template <int Dim> void PackedWorkspace<Dim>::keepDistantBonds(const Lanes& old, const std::vector<std::uint64_t>& keys, std::vector<std::uint64_t>& kept) const
{
	std::size_t       at    = 0;
	const std::size_t found = keys.size();
	for (std::size_t lane = 0; lane < old.bond.size(); ++lane) {
		while (at < found && keys[at] < old.keys[lane])
			++at;
		const bool listed = at < found && keys[at] == old.keys[lane];
		if (!listed && old.bond[lane].hasIceSpring()) kept.push_back(old.keys[lane]);
	}
}

template <int Dim> unsigned PackedWorkspace<Dim>::shiftIndex(const std::array<std::int8_t, Dim>& c)
{
	const std::size_t count = shiftCell.size() / Dim;
	for (std::size_t k = 0; k < count; ++k)
		if (std::equal(c.begin(), c.end(), shiftCell.begin() + k * Dim)) return unsigned(k);
	shiftCell.insert(shiftCell.end(), c.begin(), c.end());
	return unsigned(count);
}

template <int Dim> void PackedWorkspace<Dim>::formKeys(bool crosses)
{
	Lanes& lanes = lanesOf(crosses);
	if (lanes.keys.size() == lanes.pairs) return;
	lanes.keys.resize(lanes.pairs);
	for (std::size_t lane = 0; lane < lanes.pairs; ++lane) {
		const PackedBlock<Dim>& block = lanes.block[lane / packedWidth];
		PairKey<Dim>            pair { rowOf(block.first[lane % packedWidth]), rowOf(block.second[lane % packedWidth]), {} };
		for (int d = 0; crosses && d < Dim; ++d)
			pair.cellDist[d] = shiftCell[rowOf(lanes.shift[lane]) * Dim + d];
		lanes.keys[lane] = pair.encode();
	}
}

template <int Dim> void PackedWorkspace<Dim>::setPair(Lanes& lanes, std::size_t lane, const PairKey<Dim>& pair, bool crosses)
{
	lanes.block[lane / packedWidth].first[lane % packedWidth]  = PackedLayout<Dim>::row * pair.first;
	lanes.block[lane / packedWidth].second[lane % packedWidth] = PackedLayout<Dim>::row * pair.second;
	if (crosses) lanes.shift[lane] = PackedLayout<Dim>::row * shiftIndex(pair.cellDist);
}

/// Old lanes and new ones are walked together: both are in the order of their keys.
template <int Dim> void PackedWorkspace<Dim>::fillLanes(Lanes& lanes, const Lanes& old, bool crosses)
{
	lanes.resize(lanes.keys.size(), crosses, contactKind());
	std::size_t at = 0;
	for (std::size_t lane = 0; lane < lanes.pairs; ++lane) {
		setPair(lanes, lane, PairKey<Dim>::decode(lanes.keys[lane]), crosses);
		while (at < old.pairs && old.keys[at] < lanes.keys[lane])
			++at;
		if (at < old.pairs && old.keys[at] == lanes.keys[lane]) takeHistory(lanes, lane, old, at);
		else forgetHistory(lanes, lane);
	}
	setResponses(lanes);
	fillUp(lanes);
}

/// The last block's free lanes hold a pair of rows that never meet.
template <int Dim> void PackedWorkspace<Dim>::fillUp(Lanes& lanes)
{
	for (std::size_t lane = lanes.pairs; lane < packedWidth * lanes.block.size(); ++lane) {
		lanes.block[lane / packedWidth].first[lane % packedWidth]  = std::uint32_t(PackedLayout<Dim>::row * rowCount);
		lanes.block[lane / packedWidth].second[lane % packedWidth] = std::uint32_t(PackedLayout<Dim>::row * (rowCount + 1));
	}
}

#define TALIK_LISTS_OF(Dim)                                                                                  \
	template void PackedWorkspace<Dim>::loadContacts(const PackedState<Dim>&);                           \
	template void PackedWorkspace<Dim>::loadListed(const PackedContacts<Dim>&, const PackedLists<Dim>&); \
	template void PackedWorkspace<Dim>::storeContacts(PackedContacts<Dim>&, PackedLists<Dim>*) const;    \
	template bool PackedWorkspace<Dim>::listsExhausted() const;                                          \
	template void PackedWorkspace<Dim>::accumulateTravel();                                              \
	template void PackedWorkspace<Dim>::refreshLists();                                                  \
	template void PackedWorkspace<Dim>::rebuildLists(double);
TALIK_LISTS_OF(2)
TALIK_LISTS_OF(3)
#undef TALIK_LISTS_OF

} // namespace talik
