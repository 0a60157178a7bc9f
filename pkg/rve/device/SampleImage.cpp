// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <cstring>
#include <pkg/rve/device/SampleDevice.hpp>
#include <pkg/rve/device/SampleImage.hpp>
#include <pkg/rve/device/SampleMemory.hpp>

namespace talik {

namespace {
	/// Pairs come and go: the lists of dense grains fit the place of the former ones.
	constexpr int                       pairStep      = 64;
	constexpr double                    sparePairs    = 0.1;
	template <int Dim> constexpr double pairsOfAGrain = Dim == 2 ? 2.25 : 2.5;

	/// The rows of a place, with bonds or without: those of bonds are the last ones.
	template <int Dim> N_ONE::Place<Dim, true> rowsOf(const PlaceLayout& l, const unsigned char* bytes)
	{
		return { reinterpret_cast<std::uint64_t>(bytes), l };
	}

	bool fuses(const char* path) { return std::strncmp(path, "AVX2", 4) == 0 || std::strncmp(path, "AVX3", 4) == 0; }
} // namespace

template <int Dim> template <class Visitor> void SampleImage<Dim>::forPairs(Visitor&& visit) const
{
	int p = 0;
	for (auto* lanes : { &workspace.innerLanes, &workspace.periodicLanes })
		for (std::size_t lane = 0; lane < lanes->pairs; ++lane)
			visit(p++, *lanes, lane, lanes == &workspace.periodicLanes);
}

/// Images go in the order of the sums over them.
template <int Dim> std::vector<int> SampleImage<Dim>::imageNumbers() const
{
	std::vector<int> numbers(workspace.shiftOrder.size());
	for (std::size_t k = 0; k < numbers.size(); ++k)
		numbers[workspace.shiftOrder[k]] = int(k);
	return numbers;
}

template <int Dim> std::string SampleImage<Dim>::reasonAgainst() const
{
	if (workspace.resistsRolling) return "grains that resist rolling";
	if (workspace.bondsCarryMoments) return "bonds that carry moments";
	if (!fuses(workspace.path()))
		return "the vectors of this processor, " + std::string(workspace.path()) + ", which round otherwise (AVX2 or later is needed)";
	if (workspace.grainCount >= std::size_t(PairCode::mostGrains)) return "more than 1000 grains, or 2560 pairs of neighbours";
	if (workspace.shiftOrder.size() > std::size_t(mostImages)) return "thin cells";
	const PlaceLayout l       = layout();
	const auto&       kernels = sampleKernels();
	if (std::none_of(kernels.begin(), kernels.end(), [&](const KernelShape& k) { return k.holds(l); }))
		return "more than 1000 grains, or 2560 pairs of neighbours";
	return "";
}

template <int Dim> PlaceLayout SampleImage<Dim>::layout() const
{
	return layoutOf(
	        int(workspace.grainCount), int(workspace.innerLanes.pairs + workspace.periodicLanes.pairs), workspace.carriesBonds,
	        workspace.grains->hertz.acts());
}

template <int Dim> PlaceLayout SampleImage<Dim>::layoutOf(int grains, int pairs, bool bonded, bool hertz)
{
	const int   wanted  = int(std::max((1 + sparePairs) * pairs, pairsOfAGrain<Dim> * grains)) / pairStep + 1;
	const auto& kernels = sampleKernels();
	const auto  roomy   = PlaceLayout::of(Dim, grains, wanted * pairStep, bonded, hertz);
	if (std::any_of(kernels.begin(), kernels.end(), [&](const KernelShape& k) { return k.holds(roomy); })) return roomy;
	return PlaceLayout::of(Dim, grains, (pairs / pairStep + 1) * pairStep, bonded, hertz);
}

template <int Dim> void SampleImage<Dim>::write(const PlaceLayout& l, std::vector<unsigned char>& bytes) const
{
	using In = N_ONE::Place<Dim, true>;
	bytes.assign(std::size_t(l.bytes), 0);
	const auto  rows = rowsOf<Dim>(l, bytes.data());
	const auto& view = workspace.view;
	for (int g = 0; g < l.grains; ++g) {
		for (int d = 0; d < Dim; ++d) {
			rows.motion(d, g)       = view.position(g)[d];
			rows.motion(Dim + d, g) = view.velocity(g)[d];
		}
		for (int d = 0; d < PackedLayout<Dim>::angular; ++d)
			rows.motion(2 * Dim + d, g) = view.spin(g, d);
		if (Dim == 2) rows.motion(5, g) = view.angle[g];
		rows.motion(In::motionRows + In::minusInverseMass, g)   = view.minusInverseMass[g];
		rows.motion(In::motionRows + In::inverseInertia, g)     = view.inverseInertia[g];
		rows.motion(In::motionRows + In::radius, g)             = view.radius[g];
		rows.motion(In::motionRows + In::inverseSlackSquare, g) = view.inverseSlackSquare[g];
		rows.motion(In::motionRows + In::ownRadius, g)          = workspace.grains->radius[g];
	}
	const std::vector<int>                  images = imageNumbers();
	std::vector<std::vector<std::uint16_t>> ends(workspace.grainCount);
	forPairs([&](int p, const auto& lanes, std::size_t lane, bool crosses) {
		const auto&         block = lanes.block[lane / packedWidth];
		const std::size_t   at    = lane % packedWidth;
		const std::uint32_t first = workspace.rowOf(block.first[at]), second = workspace.rowOf(block.second[at]);
		rows.setIndex(p, PairCode::of(first, second, crosses ? images[workspace.rowOf(lanes.shift[lane])] : -1));
		ends[first].push_back(std::uint16_t(p));
		ends[second].push_back(std::uint16_t(p | 1u << 15));
		for (int d = 0; d < In::shearRows; ++d)
			rows.pair(In::shear + d, p) = block.shear[d][at];
		rows.pair(In::sumRadius, p) = block.sumRadius[at];
		rows.pair(In::stiffness, p) = block.stiffness[at];
		if constexpr (Dim == 3) rows.pair(In::halfDifference, p) = block.halfDifference[at];
		if (!l.bonded) return;
		const auto&    ice  = lanes.ice[lane / packedWidth];
		const IceBond& bond = lanes.bond[lane];
		for (int d = 0; d < In::shearRows; ++d)
			rows.pair(In::iceShear + d, p) = ice.iceShear[d][at];
		rows.pair(In::offset, p)         = ice.offset[at];
		rows.pair(In::floorForce, p)     = ice.floor[at];
		rows.pair(In::cohesion, p)       = ice.cohesion[at];
		rows.pair(In::iceShare, p)       = ice.iceShare[at];
		rows.pair(In::grainStiffness, p) = workspace.stiffness(lanes, lane, workspace.iceRatio).grain;
		rows.pair(In::area, p)           = workspace.base.ice.bondArea(std::min(workspace.grains->radius[first], workspace.grains->radius[second]));
		rows.setBond(p, bond);
	});
	int at = 0;
	for (std::size_t g = 0; g < ends.size(); ++g) {
		rows.setStart(int(g), std::uint16_t(at));
		for (const std::uint16_t end : ends[g])
			rows.setIncidence(at++, end);
	}
	rows.setStart(int(ends.size()), std::uint16_t(at));
	for (std::size_t k = 0; k < images.size(); ++k)
		for (int d = 0; d < Dim; ++d)
			rows.setImage(images[k] * Dim + d, workspace.shiftCell[k * Dim + std::size_t(d)]);
}

template <int Dim> SampleCall SampleImage<Dim>::call() const
{
	SampleCall  c {};
	const auto& view = workspace.view;
	std::copy_n(view.hSize, Dim * Dim, c.hSize);
	std::copy_n(view.trsf, Dim * Dim, c.trsf);
	c.dt              = view.dt;
	c.damping         = view.damping;
	c.friction        = view.friction;
	c.stiffnessRatio  = view.stiffnessRatio;
	c.iceRatio        = workspace.iceRatio;
	c.tensileStrength = workspace.tensileStrength;
	c.shearStrength   = workspace.shearStrength;
	c.thickness       = workspace.base.thickness;
	c.skin            = workspace.use.skin;
	c.travel          = workspace.use.travel;
	c.stretch         = workspace.use.stretch;
	c.largestRadius   = workspace.largestRadius;
	c.smallestRadius  = workspace.smallestRadius;
	c.meanRadius      = workspace.averageRadius;
	c.young           = workspace.base.ice.young;
	c.elasticity      = workspace.grains->hertz;
	c.bondAreaFactor  = workspace.base.ice.bondAreaFactor;
	c.bondRange       = workspace.base.ice.bondRange;
	c.bondsOutlast    = workspace.base.ice.bondsOutlastIce();
	c.grains          = std::int32_t(workspace.grainCount);
	c.inside          = std::int32_t(workspace.innerLanes.pairs);
	c.pairs           = c.inside + std::int32_t(workspace.periodicLanes.pairs);
	c.images          = std::max(1, std::int32_t(workspace.shiftOrder.size()));
	c.thawed          = workspace.base.ice.melted(workspace.base.iceSaturation);
	return c;
}

template <int Dim>
void SampleImage<Dim>::take(
        const PlaceLayout& l, const std::vector<unsigned char>& bytes, const SampleCall& call, const PackedParameters<Dim>& parameters,
        std::shared_ptr<const PackedGrains> grains, const PackedListUse<Dim>& use, bool carriesBonds)
{
	const auto       rows = rowsOf<Dim>(l, bytes.data());
	PackedState<Dim> state;
	PackedLists<Dim> lists;
	static_cast<PackedParameters<Dim>&>(state) = parameters;
	static_cast<PackedListUse<Dim>&>(lists)    = use;
	state.grains                               = std::move(grains);
	takeGrains(rows, l.grains, state, lists);
	takePairs(rows, l, call, state.contacts, lists);
	workspace.setStrengthFactors({});
	workspace.load(state, &lists);
	workspace.carryBonds(carriesBonds); // they may all be gone: the next update finds out
}

template <int Dim> template <class Out> void SampleImage<Dim>::takeGrains(const Out& rows, int grains, PackedState<Dim>& state, PackedLists<Dim>& lists)
{
	const std::size_t count = std::size_t(grains);
	state.position.resize(count);
	state.velocity.resize(count);
	state.angularVelocity.resize(count);
	state.orientation.resize(Dim == 2 ? count : 0);
	lists.slack.resize(count);
	for (int g = 0; g < grains; ++g) {
		for (int d = 0; d < Dim; ++d) {
			state.position[g][d] = rows.motion(d, g);
			state.velocity[g][d] = rows.motion(Dim + d, g);
		}
		if constexpr (Dim == 2) {
			state.angularVelocity[g] = rows.motion(4, g);
			state.orientation[g]     = rows.motion(5, g);
		} else {
			for (int d = 0; d < 3; ++d)
				state.angularVelocity[g][d] = rows.motion(6 + d, g);
		}
		lists.slack[g] = std::uint8_t(-std::ilogb(rows.constant(Out::inverseSlackSquare, g)) / 2);
	}
}

/// All pairs come as contacts: those that remember nothing are told apart when they are stored.
template <int Dim>
template <class Out>
void SampleImage<Dim>::takePairs(const Out& rows, const PlaceLayout& l, const SampleCall& call, PackedContacts<Dim>& c, PackedLists<Dim>& lists)
{
	const std::size_t pairs = std::size_t(call.pairs), bonds = l.bonded ? pairs : 0;
	lists.inside = std::size_t(call.inside);
	lists.first.resize(pairs);
	lists.second.resize(pairs);
	lists.cellDist.resize(pairs - lists.inside);
	c.cellDist.assign(pairs, {});
	c.shear.resize(pairs);
	c.iceShear.resize(bonds);
	c.iceReference.resize(bonds);
	c.grainReference.resize(bonds);
	c.bond.resize(bonds);
	const auto shearOf = [&](int row, int p) {
		typename PackedTypes<Dim>::Shear s;
		if constexpr (Dim == 2) s = rows.pair(row, p);
		else
			for (int d = 0; d < 3; ++d)
				s[d] = rows.pair(row + d, p);
		return s;
	};
	for (int p = 0; p < call.pairs; ++p) {
		const std::uint32_t code = rows.index(p);
		lists.first[p]           = std::uint16_t(PairCode::first(code));
		lists.second[p]          = std::uint16_t(PairCode::second(code));
		if (PairCode::image(code) >= 0) {
			for (int d = 0; d < Dim; ++d)
				c.cellDist[p][d] = rows.image(Dim * PairCode::image(code) + d);
			lists.cellDist[std::size_t(p) - lists.inside] = c.cellDist[p];
		}
		c.shear[p] = shearOf(Out::shear, p);
		if (!l.bonded) continue;
		const IceBond bond  = rows.iceBond(p);
		c.iceShear[p]       = shearOf(Out::iceShear, p);
		c.iceReference[p]   = bond.uIce;
		c.grainReference[p] = bond.uGrain;
		c.bond[p]           = c.encode(bond);
	}
	c.first  = lists.first;
	c.second = lists.second;
}

TALIK_IN_PLANE_AND_SPACE(SampleImage);

} // namespace talik
