// SPDX-License-Identifier: GPL-2.0-or-later
// Bonds of ice: their failure, and how they follow ice saturation.
#include <algorithm>
#include <cmath>
#include <pkg/icebond/IceChange.hpp>
#include <pkg/icebond/IceLaws.hpp>
#include <pkg/rve/packed/PackedWorkspace.hpp>

namespace talik {

template <int Dim> void PackedWorkspace<Dim>::onBondEvent(void* owner, PackedBondEvent<Dim>* event)
{
	static_cast<PackedWorkspace*>(owner)->settleBond(*event);
}

template <int Dim> void PackedWorkspace<Dim>::settleBond(PackedBondEvent<Dim>& event)
{
	Lanes&            lanes   = lanesOf(event.periodic != 0);
	IceBond&          bond    = lanes.bond[event.lane];
	const bool        thawed  = base.ice.melted(base.iceSaturation);
	const BondFailure failure = bond.settle(stiffness(lanes, event.lane, iceRatio), strength(lanes, event.lane), view.friction, thawed, event.forces);
	base.bondsBrokenInTension += failure == BondFailure::tension;
	base.bondsBrokenInShear += failure == BondFailure::shear;
	if (event.forces.overlap < 0) bond = IceBond(); // a contact that has opened is forgotten
	setResponse(lanes, event.lane);
}

template <int Dim> void PackedWorkspace<Dim>::carryBonds(bool carry)
{
	if (carry == carriesBonds) return;
	carriesBonds = carry;
	for (const bool crosses : { false, true }) {
		Lanes& lanes = lanesOf(crosses);
		lanes.ice.assign(carry ? lanes.block.size() : 0, PackedIceBlock<Dim>());
		lanes.bond.assign(carry ? lanes.pairs : 0, IceBond());
		lanes.moments.assign(contactKind().moments ? lanes.block.size() : 0, PackedMomentBlock<Dim>());
	}
	bind();
	selectKernel();
}

/// Bonds follow the stiffness of the ice; where the ice has melted only bonds that outlast it are left.
template <int Dim> void PackedWorkspace<Dim>::changeIceOfBonds(double newRatio, bool melted)
{
	const IceChange change { melted, base.ice.bondsOutlastIce() };
	for (const bool crosses : { false, true }) {
		Lanes& lanes = lanesOf(crosses);
		for (std::size_t lane = 0; lane < lanes.bond.size(); ++lane) {
			const std::size_t b = lane / packedWidth, l = lane % packedWidth;
			IceBond&          bond     = lanes.bond[lane];
			auto              shear    = laneShear<Dim>(lanes.block[b].shear, l);
			auto              iceShear = laneShear<Dim>(lanes.ice[b].iceShear, l);
			const auto        overlap  = [&] { return geometry(lanes, lane).overlap; };
			base.bondsMelted += change.apply(bond, stiffness(lanes, lane, iceRatio), stiffness(lanes, lane, newRatio), overlap, shear, iceShear);
			setLaneShear<Dim>(lanes.block[b].shear, l, shear);
			setLaneShear<Dim>(lanes.ice[b].iceShear, l, iceShear);
		}
	}
	if (newRatio < iceRatio)
		for (Lanes* lanes : { &innerLanes, &periodicLanes })
			keepMoments(*lanes, newRatio / iceRatio);
	if (melted) carryBonds(anyBond());
}

/// Melting ice takes its share of the moments away.
template <int Dim> void PackedWorkspace<Dim>::keepMoments(Lanes& lanes, double share)
{
	for (auto& block : lanes.moments)
		for (auto& component : block.moment)
			for (double& moment : component)
				moment *= share;
}

template <int Dim> bool PackedWorkspace<Dim>::anyBond() const
{
	const auto carries = [](const IceBond& bond) { return bond.state != BondState::NONE; };
	return std::any_of(innerLanes.bond.begin(), innerLanes.bond.end(), carries)
	        || std::any_of(periodicLanes.bond.begin(), periodicLanes.bond.end(), carries);
}

template <int Dim> bool grainsShrink(PackedThawStrain& thaw, double& radiusFactor, double iceBefore, double iceNow)
{
	if (thaw.thawStrain == 0) return false;
	thaw.frozenSaturation = std::max({ thaw.frozenSaturation, iceBefore, iceNow });
	const double lost     = thaw.thawStrain * (1 - iceNow / thaw.frozenSaturation);
	const double factor   = Dim == 2 ? std::sqrt(1 - lost) : std::cbrt(1 - lost);
	if (factor >= radiusFactor) return false;
	radiusFactor = factor;
	return true;
}

template <int Dim> void PackedWorkspace<Dim>::setIceSaturation(double saturation)
{
	if (!(saturation >= 0 && saturation <= 1))
		throw std::invalid_argument("packed sample: ice saturation " + std::to_string(saturation) + " must lie in 0..1");
	if (saturation == base.iceSaturation) return;
	const double newRatio = iceStiffness * base.ice.iceStiffnessRatio(saturation);
	const bool   melted = base.ice.melted(saturation), births = !melted && base.ice.formsBonds(base.iceSaturation, saturation);
	if (carriesBonds) changeIceOfBonds(newRatio, melted);
	const double before = base.iceSaturation;
	base.iceSaturation  = saturation;
	iceRatio            = newRatio;
	setStrengths();
	if (grainsShrink<Dim>(base.thawStrain, base.radiusFactor, before, saturation)) scaleRadii();
	setResponses(innerLanes);
	setResponses(periodicLanes);
	if (births) bondAll();
}

template <int Dim> void PackedWorkspace<Dim>::setStrengthFactors(const BondStrengthFactors& factors)
{
	if (factors == strengthFactors) return;
	strengthFactors = factors;
	setStrengths();
	if (!carriesBonds) return;
	setResponses(innerLanes);
	setResponses(periodicLanes);
}

template <int Dim> void PackedWorkspace<Dim>::setIceStiffness(double factor)
{
	if (factor == iceStiffness) return;
	const double stiffer = factor / iceStiffness;
	iceStiffness         = factor;
	iceRatio             = factor * base.ice.iceStiffnessRatio(base.iceSaturation);
	if (!carriesBonds) return;
	for (Lanes* lanes : { &innerLanes, &periodicLanes })
		for (std::size_t lane = 0; lane < lanes->bond.size(); ++lane) {
			if (!lanes->bond[lane].hasIceSpring()) continue;
			lanes->bond[lane].stiffenIce(stiffer, geometry(*lanes, lane).overlap);
			setResponse(*lanes, lane);
		}
}

template <int Dim> void PackedWorkspace<Dim>::creep(const BondCreep& creep)
{
	if (bondsCarryMoments) throw std::invalid_argument(momentsDoNotCreep);
	if (!carriesBonds || base.ice.melted(base.iceSaturation)) return;
	const double young = base.ice.young * (1 + iceRatio);
	for (Lanes* lanes : { &innerLanes, &periodicLanes })
		for (std::size_t lane = 0; lane < lanes->bond.size(); ++lane) {
			const std::size_t b = lane / packedWidth, l = lane % packedWidth;
			IceBond&          bond = lanes->bond[lane];
			if (!bond.hasIceSpring()) continue;
			const Geometry now      = geometry(*lanes, lane);
			auto           shear    = laneShear<Dim>(lanes->block[b].shear, l);
			auto           iceShear = laneShear<Dim>(lanes->ice[b].iceShear, l);
			const double   area     = base.ice.bondArea(std::min(grains->radius[now.rows.first], grains->radius[now.rows.second]));
			relaxIce(bond, creep, { stiffness(*lanes, lane, iceRatio), young, area, view.friction, now.overlap }, shear, iceShear);
			setLaneShear<Dim>(lanes->block[b].shear, l, shear);
			setLaneShear<Dim>(lanes->ice[b].iceShear, l, iceShear);
			setResponse(*lanes, lane);
		}
}

template <int Dim> std::size_t PackedWorkspace<Dim>::bondAll()
{
	if (base.ice.melted(base.iceSaturation) || !base.ice.formsBondsEver()) return 0;
	std::size_t formed = 0;
	carryBonds(true);
	rebuildLists(bondingReach(base.ice, largestRadius));
	for (const bool crosses : { false, true }) {
		Lanes& lanes = lanesOf(crosses);
		for (std::size_t lane = 0; lane < lanes.bond.size(); ++lane)
			formed += formBond(lanes, lane);
	}
	base.bondsFormed += formed;
	if (formed == 0) carryBonds(anyBond());
	return formed;
}

/// True if a bond was formed: the contact had none and its grains are near.
template <int Dim> bool PackedWorkspace<Dim>::formBond(Lanes& lanes, std::size_t lane)
{
	IceBond& bond = lanes.bond[lane];
	if (bond.state != BondState::NONE) return false;
	const Geometry now      = geometry(lanes, lane);
	const double   smaller  = std::min(view.radius[now.rows.first], view.radius[now.rows.second]);
	auto           iceShear = laneShear<Dim>(lanes.ice[lane / packedWidth].iceShear, lane % packedWidth);
	if (!formWithin(bond, now.overlap, base.ice.bondRange * smaller, iceShear)) return false;
	setLaneShear<Dim>(lanes.ice[lane / packedWidth].iceShear, lane % packedWidth, iceShear);
	setResponse(lanes, lane);
	return true;
}

#define TALIK_BONDS_OF(Dim)                                                                        \
	template void        PackedWorkspace<Dim>::onBondEvent(void*, PackedBondEvent<Dim>*);      \
	template void        PackedWorkspace<Dim>::setIceSaturation(double);                       \
	template void        PackedWorkspace<Dim>::setStrengthFactors(const BondStrengthFactors&); \
	template void        PackedWorkspace<Dim>::setIceStiffness(double);                        \
	template void        PackedWorkspace<Dim>::creep(const BondCreep&);                        \
	template std::size_t PackedWorkspace<Dim>::bondAll();                                      \
	template bool        grainsShrink<Dim>(PackedThawStrain&, double&, double, double);
TALIK_BONDS_OF(2)
TALIK_BONDS_OF(3)
#undef TALIK_BONDS_OF

} // namespace talik
