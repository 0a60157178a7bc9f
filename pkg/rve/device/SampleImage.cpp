// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <cstring>
#include <pkg/rve/device/SampleDevice.hpp>
#include <pkg/rve/device/SampleImage.hpp>

namespace talik {

namespace {
	/// Pairs come and go: the lists of dense grains fit the place of the former ones.
	constexpr int                       pairStep      = 64;
	constexpr double                    sparePairs    = 0.1;
	template <int Dim> constexpr double pairsOfAGrain = Dim == 2 ? 2.25 : 2.5;

	/// Rows of a place, as the kernels have them (Place in SampleKernels.hpp).
	template <int Dim, class Byte> class Rows {
	public:
		Rows(const PlaceLayout& l, Byte* bytes)
		        : layout(l)
		        , base(bytes)
		{}
		auto& motion(int row, std::size_t g) const { return numbers()[std::size_t(row) * layout.grains + g]; }
		auto& constant(int row, std::size_t g) const { return motion(layout.motionRows() + row, g); }
		auto& pair(int row, std::size_t p) const { return numbers()[layout.grainRows() * layout.grains + std::size_t(row) * layout.pairs + p]; }
		template <class T> auto* at(std::int32_t offset) const { return reinterpret_cast<Same<T>*>(base + offset); }
		static constexpr int     shear = 0, shears = Dim == 2 ? 1 : 3, sumRadius = shears, stiffness = sumRadius + 1, halfDifference = stiffness + 1;
		static constexpr int iceShear = sumRadius + Dim, offset = iceShear + shears, floor = offset + 1, cohesion = offset + 2, iceShare = offset + 3;
		static constexpr int grainStiffness = offset + 4, area = offset + 5, uGrain = offset + 6, uIce = offset + 7;

	private:
		template <class T> using Same = std::conditional_t<std::is_const<Byte>::value, const T, T>;
		auto*              numbers() const { return at<double>(0); }
		const PlaceLayout& layout;
		Byte*              base;
	};

	bool fuses(const char* path) { return std::strncmp(path, "AVX2", 4) == 0 || std::strncmp(path, "AVX3", 4) == 0; }

	std::uint8_t encode(const IceBond& b) { return std::uint8_t(int(b.state) | (b.iceCut ? 4 : 0)); }
} // namespace

template <int Dim> template <class Visitor> void SampleImage<Dim>::forPairs(Visitor&& visit) const
{
	std::size_t p = 0;
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
	return layoutOf(int(workspace.grainCount), int(workspace.innerLanes.pairs + workspace.periodicLanes.pairs), workspace.carriesBonds);
}

template <int Dim> PlaceLayout SampleImage<Dim>::layoutOf(int grains, int pairs, bool bonded)
{
	const int   wanted  = int(std::max((1 + sparePairs) * pairs, pairsOfAGrain<Dim> * grains)) / pairStep + 1;
	const auto& kernels = sampleKernels();
	const auto  roomy   = PlaceLayout::of(Dim, grains, wanted * pairStep, bonded);
	if (std::any_of(kernels.begin(), kernels.end(), [&](const KernelShape& k) { return k.holds(roomy); })) return roomy;
	return PlaceLayout::of(Dim, grains, (pairs / pairStep + 1) * pairStep, bonded);
}

template <int Dim> void SampleImage<Dim>::write(const PlaceLayout& l, std::vector<unsigned char>& bytes) const
{
	using In = Rows<Dim, unsigned char>;
	bytes.assign(std::size_t(l.bytes), 0);
	const In    rows(l, bytes.data());
	const auto& view = workspace.view;
	for (std::size_t g = 0; g < workspace.grainCount; ++g) {
		for (int d = 0; d < Dim; ++d) {
			rows.motion(d, g)       = view.position(g)[d];
			rows.motion(Dim + d, g) = view.velocity(g)[d];
		}
		for (int d = 0; d < PackedLayout<Dim>::angular; ++d)
			rows.motion(2 * Dim + d, g) = view.spin(g, d);
		if (Dim == 2) rows.motion(5, g) = view.angle[g];
		rows.constant(0, g) = view.minusInverseMass[g];
		rows.constant(1, g) = view.inverseInertia[g];
		rows.constant(2, g) = view.radius[g];
		rows.constant(3, g) = view.inverseSlackSquare[g];
		rows.constant(4, g) = workspace.grains->radius[g];
	}
	const std::vector<int>                  images = imageNumbers();
	std::vector<std::vector<std::uint16_t>> ends(workspace.grainCount);
	auto* const                             index = rows.template at<std::uint32_t>(l.index);
	forPairs([&](std::size_t p, const auto& lanes, std::size_t lane, bool crosses) {
		const auto&         block = lanes.block[lane / packedWidth];
		const std::size_t   at    = lane % packedWidth;
		const std::uint32_t first = workspace.rowOf(block.first[at]), second = workspace.rowOf(block.second[at]);
		index[p] = PairCode::of(first, second, crosses ? images[workspace.rowOf(lanes.shift[lane])] : -1);
		ends[first].push_back(std::uint16_t(p));
		ends[second].push_back(std::uint16_t(p | 1u << 15));
		for (int d = 0; d < In::shears; ++d)
			rows.pair(In::shear + d, p) = block.shear[d][at];
		rows.pair(In::sumRadius, p) = block.sumRadius[at];
		rows.pair(In::stiffness, p) = block.stiffness[at];
		if constexpr (Dim == 3) rows.pair(In::halfDifference, p) = block.halfDifference[at];
		if (!l.bonded) return;
		const auto&    ice  = lanes.ice[lane / packedWidth];
		const IceBond& bond = lanes.bond[lane];
		for (int d = 0; d < In::shears; ++d)
			rows.pair(In::iceShear + d, p) = ice.iceShear[d][at];
		rows.pair(In::offset, p)         = ice.offset[at];
		rows.pair(In::floor, p)          = ice.floor[at];
		rows.pair(In::cohesion, p)       = ice.cohesion[at];
		rows.pair(In::iceShare, p)       = ice.iceShare[at];
		rows.pair(In::grainStiffness, p) = workspace.stiffness(lanes, lane, workspace.iceRatio).grain;
		rows.pair(In::area, p)           = workspace.base.ice.bondArea(std::min(workspace.grains->radius[first], workspace.grains->radius[second]));
		rows.pair(In::uGrain, p)         = bond.uGrain;
		rows.pair(In::uIce, p)           = bond.uIce;
		rows.template at<std::uint8_t>(l.bond)[p] = encode(bond);
	});
	auto* const   start     = rows.template at<std::uint16_t>(l.start);
	auto*         incidence = rows.template at<std::uint16_t>(l.incidence);
	std::uint16_t at        = 0;
	for (std::size_t g = 0; g < ends.size(); ++g) {
		start[g]  = at;
		incidence = std::copy(ends[g].begin(), ends[g].end(), incidence);
		at        = std::uint16_t(at + ends[g].size());
	}
	start[ends.size()] = at;
	for (std::size_t k = 0; k < images.size(); ++k)
		std::copy_n(workspace.shiftCell.begin() + std::ptrdiff_t(k * Dim), Dim, rows.template at<std::int8_t>(l.images) + images[k] * Dim);
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
	const Rows<Dim, const unsigned char> rows(l, bytes.data());
	PackedState<Dim>                     state;
	PackedLists<Dim>                     lists;
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
	for (std::size_t g = 0; g < count; ++g) {
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
		lists.slack[g] = std::uint8_t(-std::ilogb(rows.constant(3, g)) / 2);
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
	const auto shearOf = [&](int row, std::size_t p) {
		typename PackedTypes<Dim>::Shear s;
		if constexpr (Dim == 2) s = rows.pair(row, p);
		else
			for (int d = 0; d < 3; ++d)
				s[d] = rows.pair(row + d, p);
		return s;
	};
	const auto* const images = rows.template at<std::int8_t>(l.images);
	for (std::size_t p = 0; p < pairs; ++p) {
		const std::uint32_t code = rows.template at<std::uint32_t>(l.index)[p];
		lists.first[p]           = std::uint16_t(PairCode::first(code));
		lists.second[p]          = std::uint16_t(PairCode::second(code));
		if (PairCode::image(code) >= 0) {
			std::copy_n(images + Dim * PairCode::image(code), Dim, c.cellDist[p].begin());
			lists.cellDist[p - lists.inside] = c.cellDist[p];
		}
		c.shear[p] = shearOf(Out::shear, p);
		if (!l.bonded) continue;
		const std::uint8_t bond = rows.template at<std::uint8_t>(l.bond)[p];
		c.iceShear[p]           = shearOf(Out::iceShear, p);
		c.iceReference[p]       = rows.pair(Out::uIce, p);
		c.grainReference[p]     = rows.pair(Out::uGrain, p);
		c.bond[p]               = c.encode({ BondState(bond & 3), (bond & 4) != 0, 0, 0 });
	}
	c.first  = lists.first;
	c.second = lists.second;
}

TALIK_IN_PLANE_AND_SPACE(SampleImage);

} // namespace talik
