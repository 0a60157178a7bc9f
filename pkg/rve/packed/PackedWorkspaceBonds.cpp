// SPDX-License-Identifier: GPL-2.0-or-later
// Bonds of ice: their failure, and how they follow ice saturation.
#include <algorithm>
#include <cmath>
#include <pkg/rve/packed/PackedWorkspaceParts.hpp>

namespace talik {

namespace {

	template <int Dim> void clearShear(double* shear)
	{
		for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
			shear[d] = 0;
	}

	/// Coulomb's limit; the ice's share shrinks with the rest.
	template <int Dim> void limitShear(PackedBondEvent<Dim>& event, double limit)
	{
		const double norm = shearNorm<Dim>(event.shear);
		if (norm <= limit) return;
		for (int d = 0; d < PackedLayout<Dim>::shear; ++d) {
			event.shear[d] *= limit / norm;
			event.iceShear[d] *= limit / norm;
		}
	}

} // namespace

template <int Dim> void PackedWorkspace<Dim>::onBondEvent(void* owner, PackedBondEvent<Dim>* event)
{
	static_cast<PackedWorkspace*>(owner)->settleBond(*event);
}

template <int Dim> void PackedWorkspace<Dim>::settleBond(PackedBondEvent<Dim>& event)
{
	Lanes&            lanes  = lanesOf(event.periodic != 0);
	BondMemory&       memory = lanes.memory[event.lane];
	const std::size_t b = event.lane / 4, l = event.lane % 4;
	const double      grain = grainStiffness(lanes.block[b].first[l] / 4, lanes.block[b].second[l] / 4);
	if (memory.bond == bondBonded) failBond(event, memory, grain);
	else relaxBond(event, memory, grain);
	dressLane(lanes, event.lane);
}

/// An intact bond at its limit: tension first, then shear.
template <int Dim> void PackedWorkspace<Dim>::failBond(PackedBondEvent<Dim>& event, BondMemory& memory, double grain)
{
	const Lanes&      lanes = lanesOf(event.periodic != 0);
	const std::size_t b = event.lane / 4, l = event.lane % 4;
	const bool        thawed = base.ice.melted(base.iceSaturation); // a bond that has outlasted its ice leaves a frictional contact
	if (event.normalForce < lanes.ice[b].floor[l]) {
		++base.bondsBrokenInTension;
		memory            = BondMemory();
		memory.bond       = event.overlap > 0 && !thawed ? bondBroken : bondNone;
		event.normalForce = 0;
		clearShear<Dim>(event.shear);
		clearShear<Dim>(event.iceShear);
		return;
	}
	++base.bondsBrokenInShear;
	if (event.overlap < 0) { // nothing holds or pushes across a gap any more
		memory            = BondMemory();
		event.normalForce = 0;
		clearShear<Dim>(event.shear);
		clearShear<Dim>(event.iceShear);
		return;
	}
	const double push     = thawed ? 0. : grain * iceRatio * std::max(event.overlap - memory.iceReference, 0.);
	event.normalForce     = push + grain * std::max(event.overlap, 0.);
	memory.grainReference = 0;
	limitShear<Dim>(event, view.friction * event.normalForce);
	if (push > 0) {
		memory.bond = bondBroken | PackedContacts<Dim>::iceSpringUncut;
	} else {
		memory      = BondMemory();
		memory.bond = thawed ? bondNone : bondBroken;
		clearShear<Dim>(event.iceShear);
	}
}

/// A broken bond below its floor: it opened and is forgotten, or its ice spring is relaxed and cut for good.
template <int Dim> void PackedWorkspace<Dim>::relaxBond(PackedBondEvent<Dim>& event, BondMemory& memory, double grain)
{
	if (event.overlap < 0) {
		memory            = BondMemory();
		event.normalForce = 0;
		clearShear<Dim>(event.shear);
		clearShear<Dim>(event.iceShear);
		return;
	}
	const bool uncut = memory.bond & PackedContacts<Dim>::iceSpringUncut;
	event.normalForce = grain * event.overlap;
	if (uncut && event.overlap > memory.iceReference) {
		event.normalForce += grain * iceRatio * (event.overlap - memory.iceReference);
	} else if (uncut) {
		for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
			event.shear[d] += event.increment[d] * (iceRatio / (1 + iceRatio));
		memory      = BondMemory();
		memory.bond = bondBroken;
		clearShear<Dim>(event.iceShear);
	}
	limitShear<Dim>(event, view.friction * event.normalForce);
}

template <int Dim> void PackedWorkspace<Dim>::carryBonds(bool carry)
{
	if (carry == carriesBonds) return;
	carriesBonds = carry;
	for (const bool crosses : { false, true }) {
		Lanes& lanes = lanesOf(crosses);
		lanes.ice.assign(carry ? lanes.block.size() : 0, PackedIceBlock<Dim>());
		lanes.memory.assign(carry ? lanes.pairs : 0, BondMemory());
	}
	bind();
	selectKernel();
}

/// Stiffness of bonds follows the ice; shear and reference overlaps of one contact under the stiffness rule in force.
template <int Dim>
void PackedWorkspace<Dim>::rescaleBond(Lanes& lanes, std::size_t lane, double oldRatio, double newRatio, double* shear, double* iceShear)
{
	BondMemory&  memory  = lanes.memory[lane];
	const double overlap = geometry(lanes, lane).overlap;
	const auto   scale   = [](double* values, double factor) {
        for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
            values[d] *= factor;
	};
	switch (base.ice.rule) {
		case StiffnessRule::parallel:
			if (newRatio >= oldRatio) {
				if (newRatio > 0) memory.iceReference = overlap - oldRatio / newRatio * (overlap - memory.iceReference);
			} else {
				const double kept = newRatio / oldRatio;
				for (int d = 0; d < PackedLayout<Dim>::shear; ++d) {
					shear[d] -= iceShear[d] * (1 - kept);
					iceShear[d] *= kept;
				}
			}
			break;
		case StiffnessRule::forceContinuous: {
			const double kept = (1 + oldRatio) / (1 + newRatio);
			if (memory.bond == bondBonded)
				memory.iceReference = memory.grainReference = overlap - kept * (overlap - memory.iceReference);
			else if (newRatio > 0)
				memory.iceReference = overlap - oldRatio / newRatio * (overlap - memory.iceReference);
			break;
		}
		case StiffnessRule::secant:
			scale(shear, (1 + newRatio) / (1 + oldRatio));
			scale(iceShear, (1 + newRatio) / (1 + oldRatio));
			break;
	}
}

/// melted: only bonds that outlast the ice are left with any of it.
template <int Dim> void PackedWorkspace<Dim>::rescaleBonds(double oldRatio, double newRatio, bool melted)
{
	for (const bool crosses : { false, true }) {
		Lanes& lanes = lanesOf(crosses);
		for (std::size_t lane = 0; lane < lanes.memory.size(); ++lane) {
			const std::uint8_t bond = lanes.memory[lane].bond;
			if (bond != bondBonded && !(bond & PackedContacts<Dim>::iceSpringUncut)) continue;
			const std::size_t b = lane / 4, l = lane % 4;
			double            shear[PackedLayout<Dim>::shear], iceShear[PackedLayout<Dim>::shear];
			for (int d = 0; d < PackedLayout<Dim>::shear; ++d) {
				shear[d]    = lanes.block[b].shear[d][l];
				iceShear[d] = lanes.ice[b].iceShear[d][l];
			}
			rescaleBond(lanes, lane, oldRatio, melted && !outlasts(bond) ? 0. : newRatio, shear, iceShear);
			for (int d = 0; d < PackedLayout<Dim>::shear; ++d) {
				lanes.block[b].shear[d][l]  = shear[d];
				lanes.ice[b].iceShear[d][l] = iceShear[d];
			}
		}
	}
}

template <int Dim> void PackedWorkspace<Dim>::removeBonds()
{
	for (Lanes* lanes : { &innerLanes, &periodicLanes })
		for (BondMemory& memory : lanes->memory) {
			if (outlasts(memory.bond)) continue;
			base.bondsMelted += memory.bond == bondBonded;
			memory = BondMemory();
		}
	carryBonds(anyBond());
}

template <int Dim> bool PackedWorkspace<Dim>::anyBond() const
{
	const auto carries = [](const BondMemory& m) { return m.bond != bondNone; };
	return std::any_of(innerLanes.memory.begin(), innerLanes.memory.end(), carries) || std::any_of(periodicLanes.memory.begin(), periodicLanes.memory.end(), carries);
}

template <int Dim> void PackedWorkspace<Dim>::shrinkGrains(double saturationBefore)
{
	PackedThawStrain& thaw = base.thawStrain;
	if (thaw.thawStrain == 0) return;
	thaw.frozenSaturation = std::max({ thaw.frozenSaturation, saturationBefore, base.iceSaturation });
	const double lost   = thaw.thawStrain * (1 - base.iceSaturation / thaw.frozenSaturation);
	const double factor = Dim == 2 ? std::sqrt(1 - lost) : std::cbrt(1 - lost);
	if (factor >= base.radiusFactor) return;
	base.radiusFactor = factor;
	scaleRadii();
}

template <int Dim> void PackedWorkspace<Dim>::setIceSaturation(double saturation)
{
	if (!(saturation >= 0 && saturation <= 1))
		throw std::invalid_argument("packed sample: ice saturation " + std::to_string(saturation) + " must lie in 0..1");
	if (saturation == base.iceSaturation) return;
	const double newRatio = base.ice.iceStiffnessRatio(saturation);
	const bool   melted = base.ice.melted(saturation), births = !melted && base.ice.formsBonds(base.iceSaturation, saturation);
	if (carriesBonds) rescaleBonds(iceRatio, newRatio, melted);
	if (melted && carriesBonds) removeBonds();
	const double before = base.iceSaturation;
	base.iceSaturation  = saturation;
	iceRatio            = newRatio;
	setStrengths();
	shrinkGrains(before);
	for (Lanes* lanes : { &innerLanes, &periodicLanes })
		for (std::size_t lane = 0; lane < lanes->pairs; ++lane)
			dressLane(*lanes, lane);
	if (births) bondAll();
}

template <int Dim> std::size_t PackedWorkspace<Dim>::bondAll()
{
	if (base.ice.melted(base.iceSaturation) || !base.ice.formsBondsEver()) return 0;
	std::size_t formed = 0;
	carryBonds(true);
	rebuildLists(1.01 * base.ice.bondRange * largestRadius);
	for (const bool crosses : { false, true }) {
		Lanes& lanes = lanesOf(crosses);
		for (std::size_t lane = 0; lane < lanes.memory.size(); ++lane) {
			BondMemory& memory = lanes.memory[lane];
			if (memory.bond != bondNone) continue;
			const Geometry now     = geometry(lanes, lane);
			const double   smaller = std::min(view.radius[now.rows.first / 4], view.radius[now.rows.second / 4]);
			if (now.overlap < -base.ice.bondRange * smaller) continue;
			memory.bond           = bondBonded;
			memory.iceReference   = now.overlap;
			memory.grainReference = std::min(now.overlap, 0.);
			if (base.ice.rule == StiffnessRule::secant) memory.iceReference = memory.grainReference = 0;
			if (base.ice.rule == StiffnessRule::forceContinuous)
				memory.iceReference = memory.grainReference = now.overlap - std::max(now.overlap, 0.) / (1 + iceRatio);
			for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
				lanes.ice[lane / 4].iceShear[d][lane % 4] = 0;
			if constexpr (Dim == 3)
				if (now.overlap < 0)
					for (int d = 0; d < 3; ++d)
						lanes.normals[lane / 4].n[d][lane % 4] = now.n[d];
			dressLane(lanes, lane);
			++formed;
		}
	}
	base.bondsFormed += formed;
	if (formed == 0) carryBonds(anyBond());
	return formed;
}

template void PackedWorkspace<2>::onBondEvent(void*, PackedBondEvent<2>*);
template void PackedWorkspace<2>::setIceSaturation(double);
template std::size_t PackedWorkspace<2>::bondAll();
template void PackedWorkspace<3>::onBondEvent(void*, PackedBondEvent<3>*);
template void PackedWorkspace<3>::setIceSaturation(double);
template std::size_t PackedWorkspace<3>::bondAll();

} // namespace talik
