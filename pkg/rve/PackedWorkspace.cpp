// SPDX-License-Identifier: GPL-2.0-or-later
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <pkg/rve/CellReduction.hpp>
#include <pkg/rve/PackedWorkspace.hpp>

namespace talik {

namespace {

	/// Skin of the neighbour lists over the mean radius: rebuilds against pairs carried along in vain.
	constexpr double skinOverRadius = 0.04;
	/// Force that is different from zero and far too small to matter: marks a lane to be watched.
	constexpr double watched = 1e-300;

	constexpr std::uint8_t bondNone = std::uint8_t(BondState::NONE), bondBonded = std::uint8_t(BondState::BONDED), bondBroken = std::uint8_t(BondState::BROKEN);

	template <int Dim> void copyMatrix(const Eigen::Matrix<double, Dim, Dim>& from, double* to)
	{
		for (int i = 0; i < Dim; ++i)
			for (int j = 0; j < Dim; ++j)
				to[i * Dim + j] = from(i, j);
	}

	template <int Dim> void copyMatrix(const double* from, Eigen::Matrix<double, Dim, Dim>& to)
	{
		for (int i = 0; i < Dim; ++i)
			for (int j = 0; j < Dim; ++j)
				to(i, j) = from[i * Dim + j];
	}

	template <int Dim> void multiply(const double* a, const double* b, double* c)
	{
		for (int i = 0; i < Dim; ++i)
			for (int j = 0; j < Dim; ++j) {
				double sum = 0;
				for (int k = 0; k < Dim; ++k)
					sum += a[i * Dim + k] * b[k * Dim + j];
				c[i * Dim + j] = sum;
			}
	}

	template <int Dim> double frobenius(const double* a)
	{
		double square = 0;
		for (int k = 0; k < Dim * Dim; ++k)
			square += a[k] * a[k];
		return std::sqrt(square);
	}

	/// Largest rate of shortening of any length, bounded from above.
	template <int Dim> double strainRate(const double* a)
	{
		double square = 0;
		for (int i = 0; i < Dim; ++i)
			for (int j = 0; j < Dim; ++j) {
				const double s = 0.5 * (a[i * Dim + j] + a[j * Dim + i]);
				square += s * s;
			}
		return std::sqrt(square);
	}

	bool avx2Usable()
	{
#if defined(__x86_64__) && defined(__GNUC__)
		return avx2KernelBuilt() && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
		return false;
#endif
	}

	template <int Dim> PackedKernel<Dim> chooseKernel(bool bonded, bool portable)
	{
		if constexpr (Dim == 2)
			if (!portable && avx2Usable()) return avx2Kernel(bonded);
		(void)portable;
		return portableKernel<Dim>(bonded);
	}

	template <class T> const double* shearData(const T& shear)
	{
		if constexpr (std::is_same<T, double>::value) return &shear;
		else return shear.data();
	}
	template <class T> double* shearData(T& shear)
	{
		if constexpr (std::is_same<T, double>::value) return &shear;
		else return shear.data();
	}

} // namespace

template <int Dim> PackedWorkspace<Dim>::PackedWorkspace(bool portableOnly) : portable(portableOnly)
{
	std::memset(&view, 0, sizeof(view));
	view.owner     = this;
	view.bondEvent = &PackedWorkspace::onBondEvent;
	selectKernel();
}

// ---------------------------------------------------------------------------------------------- in and out

template <int Dim> void PackedWorkspace<Dim>::load(const PackedState<Dim>& state, const PackedLists<Dim>* lists)
{
	static_cast<PackedParameters<Dim>&>(base) = state;
	grains     = state.grains;
	grainCount = state.size();
	rowCount   = (grainCount + 3) / 4 * 4;
	copyMatrix<Dim>(base.hSize, view.hSize);
	copyMatrix<Dim>(base.prevHSize, view.prevHSize);
	copyMatrix<Dim>(base.trsf, view.trsf);
	copyMatrix<Dim>(base.velGrad, view.velGrad);
	copyMatrix<Dim>(base.prevVelGrad, view.prevVelGrad);
	copyMatrix<Dim>(base.nextVelGrad, view.nextVelGrad);
	view.dt             = base.dt;
	view.damping        = base.damping;
	view.friction       = base.friction;
	view.stiffnessRatio = base.stiffnessRatio;
	iceRatio            = base.ice.iceStiffnessRatio(base.iceSaturation);
	setStrengths();
	loadGrains(state);
	carriesBonds = std::any_of(state.contacts.bond.begin(), state.contacts.bond.end(), [](std::uint8_t b) { return b != bondNone; });
	selectKernel();
	listsValid = false;
	if (lists) {
		loadListed(state.contacts, *lists);
	} else {
		loadContacts(state);
		rebuildLists();
	}
}

template <int Dim> void PackedWorkspace<Dim>::loadGrains(const PackedState<Dim>& state)
{
	using Layout           = PackedLayout<Dim>;
	const std::size_t rows = rowCount + 4; // two of the last four are partners of idle lanes, far from each other
	const Quad        zero { { 0, 0, 0, 0 } };
	motion.assign(rows * Layout::motion / 4, zero);
	spin.assign((rows * Layout::spin + 3) / 4, zero);
	force.assign(rows * Layout::force / 4, zero);
	angular.assign((rows * Layout::angular + 3) / 4, zero);
	orientation.assign((rows * Layout::orientation + 3) / 4, zero);
	minusInverseMass.assign(rows / 4, zero);
	inverseInertia.assign(rows / 4, zero);
	radius.assign(rows / 4, zero);
	reference.assign(rows, zero);
	bind();
	double* m = motion.data()->value;
	double* w = angular.data()->value;
	double* q = orientation.data()->value;
	for (std::size_t g = 0; g < grainCount; ++g) {
		for (int d = 0; d < Dim; ++d) {
			m[g * Layout::motion + d]       = state.position[g][d];
			m[g * Layout::motion + Dim + d] = state.velocity[g][d];
		}
		if constexpr (Dim == 2) {
			w[g] = state.angularVelocity[g];
			q[g] = state.orientation[g];
		} else {
			for (int d = 0; d < 3; ++d)
				w[3 * g + d] = state.angularVelocity[g][d];
			for (int d = 0; d < 4; ++d)
				q[4 * g + d] = state.orientation[g][d];
		}
		minusInverseMass.data()->value[g] = -1 / grains->mass[g];
		inverseInertia.data()->value[g]   = 1 / grains->inertia[g];
	}
	m[(rowCount + 1) * Layout::motion] = 1e6;
	scaleRadii();
}

/// Radii follow the thaw strain; peripheral velocities follow the radii.
template <int Dim> void PackedWorkspace<Dim>::scaleRadii()
{
	double *r = radius.data()->value, *s = spin.data()->value;
	largestRadius  = 0;
	averageRadius  = 0;
	smallestRadius = grains->radius[0] * base.radiusFactor;
	for (std::size_t g = 0; g < grainCount; ++g) {
		r[g] = grains->radius[g] * base.radiusFactor;
		if constexpr (Dim == 2) {
			s[g] = view.angular[g] * r[g];
		} else {
			for (int d = 0; d < 3; ++d)
				s[4 * g + d] = view.angular[3 * g + d];
			s[4 * g + 3] = r[g];
		}
		largestRadius  = std::max(largestRadius, r[g]);
		smallestRadius = std::min(smallestRadius, r[g]);
		averageRadius += r[g];
	}
	averageRadius /= double(grainCount);
}

template <int Dim> void PackedWorkspace<Dim>::bind()
{
	const auto pairsOf = [](Lanes& lanes, bool crosses) {
		PackedPairs<Dim> pairs;
		pairs.block   = lanes.block.data();
		pairs.normals = lanes.normals.data();
		pairs.ice     = lanes.ice.data();
		pairs.shift   = crosses ? lanes.shift.data() : nullptr;
		pairs.blocks  = lanes.block.size();
		return pairs;
	};
	view.motion           = motion.data()->value;
	view.spin             = spin.data()->value;
	view.force            = force.data()->value;
	view.angular          = angular.data()->value;
	view.orientation      = orientation.data()->value;
	view.minusInverseMass = minusInverseMass.data()->value;
	view.inverseInertia   = inverseInertia.data()->value;
	view.radius           = radius.data()->value;
	view.grains           = rowCount;
	view.inner            = pairsOf(innerLanes, false);
	view.periodic         = pairsOf(periodicLanes, true);
	view.shiftMotion      = shiftMotion.empty() ? nullptr : shiftMotion.data()->value;
	view.shiftForce       = shiftForce.empty() ? nullptr : shiftForce.data()->value;
	view.shiftCell        = shiftCell.data();
	view.shifts           = shiftCell.size() / Dim;
}

template <int Dim> void PackedWorkspace<Dim>::Lanes::resize(std::size_t number, bool crosses, bool bonded)
{
	const std::size_t blocks = (number + 3) / 4;
	pairs = number;
	block.resize(blocks);
	normals.resize(Dim == 3 ? blocks : 0);
	shift.resize(crosses ? 4 * blocks : 0);
	ice.resize(bonded ? blocks : 0);
	memory.resize(bonded ? number : 0);
}

template <int Dim> void PackedWorkspace<Dim>::Lanes::takeHistory(std::size_t lane, const Lanes& from, std::size_t at)
{
	for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
		block[lane / 4].shear[d][lane % 4] = from.block[at / 4].shear[d][at % 4];
	if constexpr (Dim == 3)
		for (int d = 0; d < 3; ++d)
			normals[lane / 4].n[d][lane % 4] = from.normals[at / 4].n[d][at % 4];
	if (ice.empty()) return;
	for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
		ice[lane / 4].iceShear[d][lane % 4] = from.ice[at / 4].iceShear[d][at % 4];
	memory[lane] = from.memory[at];
}

template <int Dim> void PackedWorkspace<Dim>::Lanes::forgetHistory(std::size_t lane)
{
	for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
		block[lane / 4].shear[d][lane % 4] = 0;
	if constexpr (Dim == 3)
		for (int d = 0; d < 3; ++d)
			normals[lane / 4].n[d][lane % 4] = 0;
	if (ice.empty()) return;
	for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
		ice[lane / 4].iceShear[d][lane % 4] = 0;
	if (lane < pairs) memory[lane] = BondMemory();
}

/// History goes where a rebuild expects it: into the lanes of the "previous" list.
template <int Dim> void PackedWorkspace<Dim>::loadContacts(const PackedState<Dim>& state)
{
	const PackedContacts<Dim>& c = state.contacts;
	std::vector<std::pair<std::uint64_t, std::size_t>> order[2];
	for (std::size_t k = 0; k < c.size(); ++k) {
		const PairKey<Dim> pair { c.first[k], c.second[k], c.cellDist[k] };
		order[pair.crossesCell()].emplace_back(pair.encode(), k);
	}
	for (const bool crosses : { false, true }) {
		auto& sorted = order[crosses];
		if (!std::is_sorted(sorted.begin(), sorted.end())) std::sort(sorted.begin(), sorted.end());
		Lanes& lanes = lanesOf(crosses);
		lanes.resize(sorted.size(), crosses, carriesBonds);
		lanes.keys.resize(sorted.size());
		for (std::size_t lane = 0; lane < sorted.size(); ++lane) {
			lanes.keys[lane] = sorted[lane].first;
			takeContact(lanes, lane, c, sorted[lane].second);
		}
	}
}

template <int Dim>
void PackedWorkspace<Dim>::takeContact(Lanes& lanes, std::size_t lane, const PackedContacts<Dim>& c, std::size_t k) const
{
	const std::size_t b = lane / 4, l = lane % 4;
	for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
		lanes.block[b].shear[d][l] = shearData(c.shear[k])[d];
	if constexpr (Dim == 3)
		for (int d = 0; d < 3; ++d)
			lanes.normals[b].n[d][l] = c.normal[k][d];
	if (!carriesBonds) return;
	for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
		lanes.ice[b].iceShear[d][l] = shearData(c.iceShear[k])[d];
	lanes.memory[lane] = { c.iceReference[k], c.grainReference[k], c.bond[k] };
}

/// Lists as they were stored: nothing is searched, sorted or compared.
template <int Dim> void PackedWorkspace<Dim>::loadListed(const PackedContacts<Dim>& contacts, const PackedLists<Dim>& lists)
{
	use            = lists;
	referenceKnown = false;
	shiftCell.clear();
	std::size_t k = 0, contact = 0;
	for (const bool crosses : { false, true }) {
		Lanes&            lanes = lanesOf(crosses);
		const std::size_t pairs = crosses ? lists.size() - lists.inside : lists.inside;
		lanes.keys.clear();
		lanes.resize(pairs, crosses, carriesBonds);
		for (std::size_t lane = 0; lane < pairs; ++lane, ++k) {
			const bool   known = lists.contact(k);
			PairKey<Dim> pair { lists.first[k], lists.second[k], {} };
			if (!known) std::swap(pair.first, pair.second);
			if (crosses) pair.cellDist = lists.cellDist[lane];
			setPair(lanes, lane, pair, crosses);
			if (known) takeContact(lanes, lane, contacts, contact++);
			else lanes.forgetHistory(lane);
			dressLane(lanes, lane);
		}
		fillUp(lanes, crosses);
	}
	lanesChanged();
}

template <int Dim> void PackedWorkspace<Dim>::store(PackedState<Dim>& state, PackedLists<Dim>* lists) const
{
	using Layout = PackedLayout<Dim>;
	static_cast<PackedParameters<Dim>&>(state) = parameters();
	state.grains = grains;
	state.position.resize(grainCount);
	state.velocity.resize(grainCount);
	state.angularVelocity.resize(grainCount);
	state.orientation.resize(grainCount);
	for (std::size_t g = 0; g < grainCount; ++g) {
		for (int d = 0; d < Dim; ++d) {
			state.position[g][d] = view.motion[g * Layout::motion + d];
			state.velocity[g][d] = view.motion[g * Layout::motion + Dim + d];
		}
		if constexpr (Dim == 2) {
			state.angularVelocity[g] = view.angular[g];
			state.orientation[g]     = view.orientation[g];
		} else {
			for (int d = 0; d < 3; ++d)
				state.angularVelocity[g][d] = view.angular[3 * g + d];
			for (int d = 0; d < 4; ++d)
				state.orientation[g][d] = view.orientation[4 * g + d];
		}
	}
	storeContacts(state.contacts, lists);
}

/// A pair that touches, or remembers a force or a bond.
template <int Dim> bool PackedWorkspace<Dim>::carriesHistory(const Lanes& lanes, std::size_t lane) const
{
	for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
		if (lanes.block[lane / 4].shear[d][lane % 4] != 0) return true;
	if (carriesBonds && lanes.memory[lane].bond != bondNone) return true;
	double       branch[Dim];
	const double reach = lanes.block[lane / 4].sumRadius[lane % 4];
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
	fit(c.shear, true);
	fit(c.normal, Dim == 3);
	fit(c.iceShear, carriesBonds);
	fit(c.iceReference, carriesBonds);
	fit(c.grainReference, carriesBonds);
	fit(c.bond, carriesBonds);
	std::size_t k = 0;
	for (const bool crosses : { false, true }) {
		const Lanes& lanes = crosses ? periodicLanes : innerLanes;
		for (const std::uint32_t lane : kept[crosses]) {
			const std::size_t b = lane / 4, l = lane % 4;
			c.first[k]    = std::uint16_t(lanes.block[b].first[l] / 4);
			c.second[k]   = std::uint16_t(lanes.block[b].second[l] / 4);
			for (int d = 0; d < Dim; ++d)
				c.cellDist[k][d] = crosses ? shiftCell[lanes.shift[lane] / 4 * Dim + d] : std::int8_t(0);
			for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
				shearData(c.shear[k])[d] = lanes.block[b].shear[d][l];
			if constexpr (Dim == 3)
				for (int d = 0; d < 3; ++d)
					c.normal[k][d] = lanes.normals[b].n[d][l];
			if (carriesBonds) {
				for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
					shearData(c.iceShear[k])[d] = lanes.ice[b].iceShear[d][l];
				const BondMemory& memory = lanes.memory[lane];
				c.iceReference[k]        = memory.iceReference;
				c.grainReference[k]      = memory.grainReference;
				c.bond[k]                = memory.bond;
			}
			++k;
		}
	}
	if (lists) storeLists(*lists, kept);
}

template <int Dim> void PackedWorkspace<Dim>::storeLists(PackedLists<Dim>& lists, const std::vector<std::uint32_t> (&kept)[2]) const
{
	static_cast<PackedListUse<Dim>&>(lists) = use;
	lists.inside                            = innerLanes.pairs;
	lists.first.resize(innerLanes.pairs + periodicLanes.pairs);
	lists.second.resize(lists.first.size());
	lists.cellDist.resize(periodicLanes.pairs);
	std::size_t k = 0;
	for (const bool crosses : { false, true }) {
		const Lanes& lanes = crosses ? periodicLanes : innerLanes;
		for (std::size_t lane = 0; lane < lanes.pairs; ++lane) {
			lists.first[k + lane]  = std::uint16_t(lanes.block[lane / 4].second[lane % 4] / 4);
			lists.second[k + lane] = std::uint16_t(lanes.block[lane / 4].first[lane % 4] / 4);
			for (int d = 0; crosses && d < Dim; ++d)
				lists.cellDist[lane][d] = shiftCell[lanes.shift[lane] / 4 * Dim + d];
		}
		for (const std::uint32_t lane : kept[crosses])
			std::swap(lists.first[k + lane], lists.second[k + lane]);
		k += lanes.pairs;
	}
}

template <int Dim> const PackedParameters<Dim>& PackedWorkspace<Dim>::parameters() const
{
	copyMatrix<Dim>(view.hSize, base.hSize);
	copyMatrix<Dim>(view.prevHSize, base.prevHSize);
	copyMatrix<Dim>(view.trsf, base.trsf);
	copyMatrix<Dim>(view.velGrad, base.velGrad);
	copyMatrix<Dim>(view.prevVelGrad, base.prevVelGrad);
	copyMatrix<Dim>(view.nextVelGrad, base.nextVelGrad);
	return base;
}

template <int Dim> typename PackedWorkspace<Dim>::Matrix PackedWorkspace<Dim>::hSize() const
{
	Matrix h;
	copyMatrix<Dim>(view.hSize, h);
	return h;
}

template <int Dim> void PackedWorkspace<Dim>::setNextVelGrad(const Matrix& velGrad) { copyMatrix<Dim>(velGrad, view.nextVelGrad); }

template <int Dim> void PackedWorkspace<Dim>::setFriction(double tangent)
{
	base.friction = view.friction = tangent;
	setStrengths();
}

template <int Dim> void PackedWorkspace<Dim>::setStrengths()
{
	tensileStrength   = base.ice.tensileStrength(base.iceSaturation);
	shearStrength     = base.ice.shearStrength(base.iceSaturation);
	view.bondFriction = base.ice.cohesionDisablesFriction ? 0 : view.friction;
}

template <int Dim> void PackedWorkspace<Dim>::selectKernel() { kernel = chooseKernel<Dim>(carriesBonds, portable); }

// ---------------------------------------------------------------------------------------------- neighbour lists

/// The cell as the next evaluation of forces will see it.
template <int Dim> void PackedWorkspace<Dim>::predictedCell(double* h) const
{
	multiply<Dim>(view.velGrad, view.hSize, h);
	for (int k = 0; k < Dim * Dim; ++k)
		h[k] = view.hSize[k] + view.dt * h[k];
}

// A pair outside the list was farther apart than r_1 + r_2 + skin. Since then the cell has shortened no length by more than the
// factor 1 - stretch, and no grain has left the affine motion by more than `travel`; both are bounds, so no contact is ever missed and
// results cannot depend on when the list was built.
template <int Dim> bool PackedWorkspace<Dim>::listsExhausted() const
{
	return !(2 * use.travel + (2 * largestRadius + use.skin) * use.stretch * 1.01 < use.skin);
}

template <int Dim> void PackedWorkspace<Dim>::accumulateTravel()
{
	const double dt = view.dt;
	use.travel += dt * (frobenius<Dim>(view.velGrad) * use.travel + std::sqrt(view.maxFluctuationSquare)) * (1 + 1e-12);
	use.stretch += dt * strainRate<Dim>(view.velGrad);
}

/// Largest deviation from the affine motion since the lists were built, exactly.
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
			double u = view.motion[g * PackedLayout<Dim>::motion + d];
			for (int e = 0; e < Dim; ++e)
				u -= deformation(d, e) * x0[4 * g + e];
			square += u * u;
		}
		largest = std::max(largest, square);
	}
	return std::sqrt(largest);
}

template <int Dim> void PackedWorkspace<Dim>::refreshLists()
{
	if (listsValid && !listsExhausted()) return;
	if (listsValid && referenceKnown) {
		const double measured = measuredTravel();
		if (measured < use.travel && 2 * measured + (2 * largestRadius + use.skin) * use.stretch * 1.01 < 0.7 * use.skin) {
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
	use.skin = std::max(skinOverRadius * averageRadius, leastSkin);
	std::swap(innerLanes, oldInner);
	std::swap(periodicLanes, oldPeriodic);
	search.build(view.motion, PackedLayout<Dim>::motion, view.radius, grainCount, use.referenceCell, use.skin, innerLanes.keys, periodicLanes.keys);
	for (const bool crosses : { false, true }) {
		std::vector<std::uint64_t>& keys = lanesOf(crosses).keys;
		sortPairKeys(keys, sortBuffer, sortCounts);
		const std::size_t found = keys.size();
		if (carriesBonds) keepDistantBonds(crosses ? oldPeriodic : oldInner, keys, keys);
		if (keys.size() > found) sortPairKeys(keys, sortBuffer, sortCounts);
	}
	adoptKeys();
	for (std::size_t g = 0; g < grainCount; ++g)
		for (int d = 0; d < Dim; ++d)
			reference[g].value[d] = view.motion[g * PackedLayout<Dim>::motion + d];
	referenceKnown = true;
	use.travel = use.stretch = 0;
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
	shiftMotion.resize(shifts * PackedLayout<Dim>::motion / 4);
	shiftForce.resize(shifts * PackedLayout<Dim>::force / 4);
	bind();
	updateShiftRows();
	listsValid = true;
}

/// A bond may open wider than the skin while it stretches: it stays in the list whatever the distance.
template <int Dim>
void PackedWorkspace<Dim>::keepDistantBonds(const Lanes& old, const std::vector<std::uint64_t>& keys, std::vector<std::uint64_t>& kept) const
{
	std::size_t       at    = 0;
	const std::size_t found = keys.size();
	for (std::size_t lane = 0; lane < old.memory.size(); ++lane) {
		while (at < found && keys[at] < old.keys[lane])
			++at;
		const bool listed = at < found && keys[at] == old.keys[lane];
		const bool holds  = old.memory[lane].bond == bondBonded || (old.memory[lane].bond & PackedContacts<Dim>::iceSpringUncut);
		if (!listed && holds) kept.push_back(old.keys[lane]);
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
		const PackedBlock<Dim>& block = lanes.block[lane / 4];
		PairKey<Dim>            pair { block.first[lane % 4] / 4, block.second[lane % 4] / 4, {} };
		for (int d = 0; crosses && d < Dim; ++d)
			pair.cellDist[d] = shiftCell[lanes.shift[lane] / 4 * Dim + d];
		lanes.keys[lane] = pair.encode();
	}
}

template <int Dim> void PackedWorkspace<Dim>::setPair(Lanes& lanes, std::size_t lane, const PairKey<Dim>& pair, bool crosses)
{
	lanes.block[lane / 4].first[lane % 4]  = 4 * pair.first;
	lanes.block[lane / 4].second[lane % 4] = 4 * pair.second;
	if (crosses) lanes.shift[lane] = 4 * shiftIndex(pair.cellDist);
}

/// Old lanes and new ones are walked together: both are in the order of their keys.
template <int Dim> void PackedWorkspace<Dim>::fillLanes(Lanes& lanes, const Lanes& old, bool crosses)
{
	lanes.resize(lanes.keys.size(), crosses, carriesBonds);
	std::size_t at = 0;
	for (std::size_t lane = 0; lane < lanes.pairs; ++lane) {
		setPair(lanes, lane, PairKey<Dim>::decode(lanes.keys[lane]), crosses);
		while (at < old.pairs && old.keys[at] < lanes.keys[lane])
			++at;
		if (at < old.pairs && old.keys[at] == lanes.keys[lane]) lanes.takeHistory(lane, old, at);
		else lanes.forgetHistory(lane);
		dressLane(lanes, lane);
	}
	fillUp(lanes, crosses);
}

/// The last block's free lanes hold a pair of rows that never meet.
template <int Dim> void PackedWorkspace<Dim>::fillUp(Lanes& lanes, bool crosses)
{
	for (std::size_t lane = lanes.pairs; lane < 4 * lanes.block.size(); ++lane) {
		PackedBlock<Dim>& block = lanes.block[lane / 4];
		const std::size_t l     = lane % 4;
		block.first[l]          = std::uint32_t(4 * rowCount);
		block.second[l]         = std::uint32_t(4 * (rowCount + 1));
		block.sumRadius[l] = block.stiffness[l] = 0;
		if (crosses) lanes.shift[lane] = 0;
		lanes.forgetHistory(lane);
		if (!carriesBonds) continue;
		PackedIceBlock<Dim>& ice = lanes.ice[lane / 4];
		ice.offset[l] = ice.floor[l] = ice.cohesion[l] = ice.iceShare[l] = 0;
	}
}

template <int Dim> double PackedWorkspace<Dim>::grainStiffness(std::uint32_t first, std::uint32_t second) const
{
	const double a = grains->radius[first], b = grains->radius[second];
	return 2 * base.ice.grainYoung * a * b / (a + b);
}

template <int Dim> double PackedWorkspace<Dim>::bondArea(std::uint32_t first, std::uint32_t second) const
{
	return base.ice.bondArea(std::min(grains->radius[first], grains->radius[second]));
}

/// Radii, stiffness and bond of a pair into its lane.
template <int Dim> void PackedWorkspace<Dim>::dressLane(Lanes& lanes, std::size_t lane)
{
	PackedBlock<Dim>&   block = lanes.block[lane / 4];
	const std::size_t   l     = lane % 4;
	const std::uint32_t first = block.first[l] / 4, second = block.second[l] / 4;
	const double        k     = grainStiffness(first, second);
	block.sumRadius[l]        = view.radius[first] + view.radius[second];
	block.stiffness[l]        = k;
	if (!carriesBonds) return;
	PackedIceBlock<Dim>& ice    = lanes.ice[lane / 4];
	const BondMemory&    memory = lanes.memory[lane];
	ice.offset[l] = ice.floor[l] = ice.cohesion[l] = ice.iceShare[l] = 0;
	if (memory.bond == bondBonded) {
		const double area  = bondArea(first, second);
		block.stiffness[l] = k + k * iceRatio;
		ice.offset[l]      = k * memory.grainReference + k * iceRatio * memory.iceReference;
		ice.floor[l]       = -std::max(watched, tensileStrength * area);
		ice.cohesion[l]    = shearStrength * area;
		ice.iceShare[l]    = iceRatio / (1 + iceRatio);
	} else if (memory.bond == bondBroken) {
		ice.floor[l] = watched;
	} else if (memory.bond & PackedContacts<Dim>::iceSpringUncut) {
		// its ice spring is relaxed, or it opens, where the force is this
		const double release = memory.iceReference > 0 ? k * memory.iceReference : -k * iceRatio * memory.iceReference;
		block.stiffness[l]   = k + k * iceRatio;
		ice.offset[l]        = k * iceRatio * memory.iceReference;
		ice.floor[l]         = std::max(watched, release);
		ice.iceShare[l]      = iceRatio / (1 + iceRatio);
	}
	if (memory.bond == bondNone || memory.bond == bondBroken)
		for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
			ice.iceShear[d][l] = 0;
}

template <int Dim> void PackedWorkspace<Dim>::updateShiftRows()
{
	double speed[Dim * Dim];
	multiply<Dim>(view.velGrad, view.prevHSize, speed);
	for (std::size_t k = 0; k < view.shifts; ++k) {
		double* row = view.shiftMotion + k * PackedLayout<Dim>::motion;
		double* sum = view.shiftForce + k * PackedLayout<Dim>::force;
		for (int d = 0; d < Dim; ++d) {
			double x = 0, v = 0;
			for (int e = 0; e < Dim; ++e) {
				x += view.hSize[d * Dim + e] * view.shiftCell[k * Dim + e];
				v += speed[d * Dim + e] * view.shiftCell[k * Dim + e];
			}
			row[d]       = x;
			row[Dim + d] = v;
		}
		for (int d = 0; d < PackedLayout<Dim>::force; ++d)
			sum[d] = 0;
	}
}

// ---------------------------------------------------------------------------------------------- steps

template <int Dim> void PackedWorkspace<Dim>::moveCell()
{
	double rate[Dim * Dim];
	std::memcpy(view.prevHSize, view.hSize, sizeof(view.hSize));
	multiply<Dim>(view.velGrad, view.prevHSize, rate);
	for (int k = 0; k < Dim * Dim; ++k)
		view.hSize[k] += view.dt * rate[k];
	multiply<Dim>(view.velGrad, view.trsf, rate);
	for (int k = 0; k < Dim * Dim; ++k)
		view.trsf[k] += view.dt * rate[k];
}

template <int Dim> void PackedWorkspace<Dim>::step()
{
	moveCell();
	updateShiftRows();
	kernel.contacts(&view);
	kernel.integrate(&view);
	std::memcpy(view.velGrad, view.nextVelGrad, sizeof(view.velGrad));
	std::memcpy(view.prevVelGrad, view.nextVelGrad, sizeof(view.velGrad));
	accumulateTravel();
	++base.step;
}

template <int Dim> void PackedWorkspace<Dim>::run(long steps, long averaged)
{
	Matrix    sum   = Matrix::Zero();
	const long first = steps - std::max(1l, std::min(averaged, steps));
	for (long k = 0; k < steps; ++k) {
		if (listsExhausted()) refreshLists();
		view.sampleStress = k >= first;
		step();
		if (view.sampleStress) {
			Matrix stress;
			finishStress(stress);
			sum += stress;
		}
	}
	if (steps > 0) base.stress = sum / double(steps - first);
}

template <int Dim> void PackedWorkspace<Dim>::finishStress(Matrix& stress) const
{
	copyMatrix<Dim>(view.virial, stress);
	for (std::size_t k = 0; k < view.shifts; ++k)
		for (int i = 0; i < Dim; ++i)
			for (int j = 0; j < Dim; ++j)
				stress(i, j) -= view.shiftForce[k * PackedLayout<Dim>::force + i] * view.shiftMotion[k * PackedLayout<Dim>::motion + j];
	stress /= parameters().volume();
}

template <int Dim> void PackedWorkspace<Dim>::checkHealth() const
{
	double sum = 0;
	for (std::size_t g = 0; g < grainCount * PackedLayout<Dim>::motion; ++g)
		sum += view.motion[g] * 0;
	if (!(sum == 0)) throw PackedBlowUp("a grain's position or velocity is not finite");
	if (!listsValid) return;
	for (const Lanes* lanes : { &innerLanes, &periodicLanes })
		for (std::size_t lane = 0; lane < lanes->pairs; ++lane) {
			const std::size_t         b = lane / 4, l = lane % 4;
			const PackedPairRows<Dim> rows = pairRows(view, lanes == &innerLanes ? view.inner : view.periodic, lane);
			double                    branch[Dim];
			const double              square  = pairBranch(view, rows, branch);
			const double              allowed = lanes->block[b].sumRadius[l] - smallestRadius;
			if (square >= allowed * allowed) continue;
			const double smaller = std::min(view.radius[rows.first / 4], view.radius[rows.second / 4]);
			if (lanes->block[b].sumRadius[l] - std::sqrt(square) > smaller)
				throw PackedBlowUp("the overlap of grains " + std::to_string(rows.first / 4) + " and " + std::to_string(rows.second / 4) + " exceeds a radius");
		}
}

// ---------------------------------------------------------------------------------------------- bonds

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
	if (event.normalForce < lanes.ice[b].floor[l]) {
		++base.bondsBrokenInTension;
		memory            = BondMemory();
		memory.bond       = event.overlap > 0 ? bondBroken : bondNone;
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
	const double push     = grain * iceRatio * std::max(event.overlap - memory.iceReference, 0.);
	event.normalForce     = push + grain * std::max(event.overlap, 0.);
	memory.grainReference = 0;
	limitShear<Dim>(event, view.friction * event.normalForce);
	if (push > 0) {
		memory.bond = bondBroken | PackedContacts<Dim>::iceSpringUncut;
	} else {
		memory      = BondMemory();
		memory.bond = bondBroken;
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

template <int Dim> void PackedWorkspace<Dim>::rescaleBonds(double oldRatio, double newRatio)
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
			rescaleBond(lanes, lane, oldRatio, newRatio, shear, iceShear);
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
			base.bondsMelted += memory.bond == bondBonded;
			memory = BondMemory();
		}
	carryBonds(false);
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
	if (carriesBonds) rescaleBonds(iceRatio, melted ? 0. : newRatio);
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
	if (base.ice.melted(base.iceSaturation)) return 0;
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
	if (formed == 0)
		carryBonds(std::any_of(innerLanes.memory.begin(), innerLanes.memory.end(), [](const BondMemory& m) { return m.bond != bondNone; })
		           || std::any_of(periodicLanes.memory.begin(), periodicLanes.memory.end(), [](const BondMemory& m) { return m.bond != bondNone; }));
	return formed;
}

// ---------------------------------------------------------------------------------------------- flip

// Grains are wrapped into the new cell at the same time, so that cell distances stay small in endless shear.
template <int Dim> bool PackedWorkspace<Dim>::flip(double skew)
{
	const Matrix                       before      = hSize();
	const Eigen::Matrix<int, Dim, Dim> combination = cellReduction<Dim>(before, std::max(skew, 0.5));
	if (combination == Eigen::Matrix<int, Dim, Dim>::Identity()) return false;
	PackedState<Dim> state;
	store(state);
	state.hSize                                = before * combination.template cast<double>();
	state.prevHSize                            = state.prevHSize * combination.template cast<double>();
	const Eigen::Matrix<int, Dim, Dim> unwind  = integerInverse<Dim>(combination);
	const Matrix                       inverse = state.hSize.inverse();
	std::vector<Eigen::Matrix<int, Dim, 1>> image(grainCount);
	for (std::size_t g = 0; g < grainCount; ++g) {
		const Vector reduced = inverse * state.position[g];
		Vector       cells;
		for (int d = 0; d < Dim; ++d) {
			cells[d]    = std::floor(reduced[d]);
			image[g][d] = int(cells[d]);
		}
		const Vector shift = state.hSize * cells;
		state.position[g] -= shift;
		state.velocity[g] -= state.prevVelGrad * shift;
	}
	PackedContacts<Dim>& c = state.contacts;
	for (std::size_t k = 0; k < c.size(); ++k) {
		Eigen::Matrix<int, Dim, 1> cells;
		for (int d = 0; d < Dim; ++d)
			cells[d] = c.cellDist[k][d];
		cells = (unwind * cells + image[c.second[k]] - image[c.first[k]]).eval();
		for (int d = 0; d < Dim; ++d)
			c.cellDist[k][d] = std::int8_t(cells[d]);
	}
	load(state);
	return true;
}

// ---------------------------------------------------------------------------------------------- measures

template <int Dim> typename PackedWorkspace<Dim>::Geometry PackedWorkspace<Dim>::geometry(const Lanes& lanes, std::size_t lane) const
{
	Geometry result;
	result.rows      = pairRows(view, &lanes == &periodicLanes ? view.periodic : view.inner, lane);
	result.sumRadius = lanes.block[lane / 4].sumRadius[lane % 4];
	result.distance  = std::sqrt(pairBranch(view, result.rows, result.n));
	result.overlap   = result.sumRadius - result.distance;
	for (int d = 0; d < Dim; ++d)
		result.n[d] /= result.distance;
	return result;
}

/// Calls visitor(geometry, normal stiffness, normal force, shear, bond) for every contact that bears or could bear a force.
template <int Dim> template <class Visitor> void PackedWorkspace<Dim>::forContacts(Visitor&& visit) const
{
	for (const Lanes* lanes : { &innerLanes, &periodicLanes })
		for (std::size_t lane = 0; lane < lanes->pairs; ++lane) {
			const Geometry     now  = geometry(*lanes, lane);
			const std::uint8_t bond = carriesBonds ? lanes->memory[lane].bond : bondNone;
			if (now.overlap < 0 && bond != bondBonded) continue;
			double stiffness = lanes->block[lane / 4].stiffness[lane % 4], normalForce = stiffness * now.overlap;
			double shear[PackedLayout<Dim>::shear];
			for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
				shear[d] = lanes->block[lane / 4].shear[d][lane % 4];
			if (bond & PackedContacts<Dim>::iceSpringUncut && now.overlap <= lanes->memory[lane].iceReference) {
				stiffness /= 1 + iceRatio;
				normalForce = stiffness * now.overlap;
			} else if (carriesBonds) {
				normalForce -= lanes->ice[lane / 4].offset[lane % 4];
			}
			visit(now, stiffness, normalForce, shear, bond);
		}
}

template <int Dim> PackedStatistics<Dim> PackedWorkspace<Dim>::statistics() const
{
	PackedStatistics<Dim> result;
	std::vector<Vector>   net(grainCount, Vector::Zero());
	double                forces = 0, overlaps = 0;
	forContacts([&](const Geometry& now, double, double normalForce, const double* shear, std::uint8_t bond) {
		double       force[Dim];
		const double norm = shearNorm<Dim>(shear);
		pairForce<Dim>(now.n, normalForce, shear, force);
		for (int d = 0; d < Dim; ++d) {
			net[now.rows.first / 4][d] -= force[d];
			net[now.rows.second / 4][d] += force[d];
			for (int e = 0; e < Dim; ++e)
				result.fabric(d, e) += now.n[d] * now.n[e];
		}
		forces += std::sqrt(normalForce * normalForce + norm * norm);
		++result.contacts;
		result.bondsIntact += bond == bondBonded;
		result.bondsBroken += (bond & bondBroken) != 0;
		if (now.overlap <= 0) return;
		overlaps += now.overlap / now.sumRadius;
		result.maxOverlapRatio
		        = std::max(result.maxOverlapRatio, now.overlap / std::min(view.radius[now.rows.first / 4], view.radius[now.rows.second / 4]));
	});
	double solid = 0, imbalance = 0;
	for (std::size_t g = 0; g < grainCount; ++g) {
		const double* x = view.motion + g * PackedLayout<Dim>::motion;
		const double  r = view.radius[g];
		double        square = 0, spinSquare = 0;
		for (int d = 0; d < Dim; ++d) {
			double v = x[Dim + d];
			for (int e = 0; e < Dim; ++e)
				v -= view.prevVelGrad[d * Dim + e] * x[e];
			square += v * v;
		}
		for (int d = 0; d < PackedLayout<Dim>::angular; ++d) {
			const double w = view.angular[g * PackedLayout<Dim>::angular + d];
			spinSquare += w * w;
		}
		result.kineticEnergy += 0.5 * (grains->mass[g] * square + grains->inertia[g] * spinSquare);
		solid += Dim == 2 ? M_PI * r * r * base.thickness : 4. / 3. * M_PI * r * r * r;
		imbalance += net[g].norm();
	}
	result.porosity           = 1 - solid / parameters().volume();
	result.coordinationNumber = 2. * double(result.contacts) / double(grainCount);
	if (result.contacts > 0) {
		result.fabric /= double(result.contacts);
		result.meanOverlapRatio = overlaps / double(result.contacts);
	}
	if (forces > 0) result.unbalancedForce = (imbalance / double(grainCount)) / (forces / double(result.contacts));
	return result;
}

template <int Dim> PackedTangent<Dim> PackedWorkspace<Dim>::tangent() const
{
	// C = (1 - ratio) sum f n n n n + ratio sum f delta_ik n_j n_l with f = d^2 k_n/V
	PackedTangent<Dim> result {};
	Matrix             second = Matrix::Zero();
	const double       volume = parameters().volume();
	forContacts([&](const Geometry& now, double stiffness, double, const double*, std::uint8_t) {
		const double factor = now.distance * now.distance * stiffness / volume;
		double       pairs[Dim * Dim], weighted[Dim * Dim];
		for (int k = 0; k < Dim * Dim; ++k) {
			pairs[k]    = now.n[k / Dim] * now.n[k % Dim];
			weighted[k] = factor * pairs[k];
			second(k / Dim, k % Dim) += weighted[k];
		}
		for (int k = 0; k < Dim * Dim; ++k)
			for (int l = 0; l < Dim * Dim; ++l)
				result[k * Dim * Dim + l] += weighted[k] * pairs[l];
	});
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j)
			for (int k = 0; k < Dim; ++k)
				for (int l = 0; l < Dim; ++l) {
					double& c = result[((i * Dim + j) * Dim + k) * Dim + l];
					c         = (1 - base.stiffnessRatio) * c + (i == k ? base.stiffnessRatio * second(j, l) : 0.);
				}
	return result;
}

template class PackedWorkspace<2>;
template class PackedWorkspace<3>;

} // namespace talik
