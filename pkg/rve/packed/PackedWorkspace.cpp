// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <cstring>
#include <Eigen/LU>
#include <pkg/icebond/IceChange.hpp>
#include <pkg/icebond/IceLaws.hpp>
#include <pkg/rve/packed/PackedWorkspace.hpp>

namespace talik {

template <int Dim>
PackedWorkspace<Dim>::PackedWorkspace(bool portableOnly)
        : portable(portableOnly)
{
	std::memset(&view, 0, sizeof(view));
	view.owner     = this;
	view.bondEvent = [](void* owner, PackedBondEvent<Dim>* event) { static_cast<PackedWorkspace*>(owner)->settleBond(*event); };
	selectKernel();
}

// ---------------------------------------------------------------------------------------------- in and out

namespace {
	/// What the cell is and how it moves, from parameters to the view of the kernels or back.
	template <int Dim, class From, class To> void copyMatrices(const From& from, To& to)
	{
		copyMatrix<Dim>(from.hSize, to.hSize);
		copyMatrix<Dim>(from.prevHSize, to.prevHSize);
		copyMatrix<Dim>(from.trsf, to.trsf);
		copyMatrix<Dim>(from.velGrad, to.velGrad);
		copyMatrix<Dim>(from.prevVelGrad, to.prevVelGrad);
		copyMatrix<Dim>(from.nextVelGrad, to.nextVelGrad);
	}
} // namespace

template <int Dim> void PackedWorkspace<Dim>::load(const PackedState<Dim>& state, const PackedLists<Dim>* lists)
{
	static_cast<PackedParameters<Dim>&>(base) = state;
	grains                                    = state.grains;
	grainCount                                = state.size();
	resistsRolling                            = state.resistsRolling();
	bondsCarryMoments                         = state.bondsCarryMoments();
	rowCount                                  = (grainCount + packedWidth - 1) / packedWidth * packedWidth;
	copyMatrices<Dim>(base, view);
	view.dt             = base.dt;
	view.damping        = base.damping;
	view.friction       = base.friction;
	view.stiffnessRatio = base.stiffnessRatio;
	iceRatio            = base.ice.iceStiffnessRatio(base.iceSaturation);
	iceStiffness        = 1;
	setStrengths();
	loadGrains(state);
	carriesBonds = std::any_of(state.contacts.bond.begin(), state.contacts.bond.end(), [](std::uint8_t b) { return b != std::uint8_t(BondState::NONE); });
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
	const std::size_t rows  = rowCount + packedWidth; // two of the last ones are partners of idle lanes, far from each other
	const auto        clear = [rows](std::size_t length, std::initializer_list<Rows*> all) {
                for (Rows* some : all)
                        some->assign(length * rows / packedWidth, Numbers {});
	};
	clear(4, { &place, &reference });
	clear(Dim == 3 ? 8 : 0, { &speed });
	clear(PackedLayout<Dim>::row, { &force });
	clear(Dim == 2 ? 1 : 0, { &turning, &rim, &angle });
	clear(1, { &minusInverseMass, &inverseInertia, &radius, &inverseSlackSquare });
	bind();
	for (std::size_t g = 0; g < grainCount; ++g) {
		for (int d = 0; d < Dim; ++d) {
			view.position(g)[d] = state.position[g][d];
			view.velocity(g)[d] = state.velocity[g][d];
		}
		if constexpr (Dim == 2) {
			view.spin(g, 0) = state.angularVelocity[g];
			view.angle[g]   = state.orientation[g];
		} else {
			for (int d = 0; d < 3; ++d)
				view.spin(g, d) = state.angularVelocity[g][d];
		}
		minusInverseMass.data()->value[g] = -1 / grains->mass[g];
		inverseInertia.data()->value[g]   = (Dim == 2 ? 1 : -1) / grains->inertia[g];
	}
	view.position(rowCount + 1)[0] = 1e6;
	scaleRadii();
}

/// Time step of the motion, eq. (13.8).
template <int Dim> double PackedWorkspace<Dim>::longestTimeStep(double iceFactor) const
{
	return talik::longestTimeStep<Dim>(base, *grains, { view.radius, largestRadius, smallestRadius }, iceFactor);
}

template <int Dim> double longestTimeStep(const PackedParameters<Dim>& parameters, const PackedGrains& grains, const PackedRadii& radii, double iceFactor)
{
	const IceBondModel& ice  = parameters.ice;
	const double        full = ice.iceStiffnessRatio(1), now = ice.iceStiffnessRatio(parameters.iceSaturation) * iceFactor;
	const bool          rolls     = grains.rolling.acts();
	const double        ofMoments = grains.section.acts() ? GrainStiffening::momentsOf(grains.section, ice.bondAreaFactor, parameters.stiffnessRatio) : 0;
	const double        ofRolling = rolls ? grains.rolling.alphaKr * radii.largest : 0;
	const double        ofGrains  = overLinear(parameters, grains, radii.smallest);
	double              mass = 1, stiffness = 0; // of the grain with the smallest m/k [kg, N/m]
	for (std::size_t g = 0; g < grains.size(); ++g) {
		const double own = radii.now[g] * GrainStiffening { rolls ? ofRolling / radii.now[g] : 0, ofMoments, ofGrains }.total(now);
		if (grains.mass[g] * stiffness >= mass * own) continue;
		mass      = grains.mass[g];
		stiffness = own;
	}
	const GrainStiffening ofSmallest { ofRolling / radii.smallest, ofMoments, ofGrains };
	return std::min(
	        timeStepOverPeriod * std::sqrt(mass / (ice.young * stiffness)), parameters.dt * std::sqrt(ofSmallest.total(full) / ofSmallest.total(now)));
}

/// Radii follow the thaw strain; peripheral velocities follow the radii.
template <int Dim> void PackedWorkspace<Dim>::scaleRadii()
{
	double* r = radius.data()->value;
	for (std::size_t g = 0; g < grainCount; ++g) {
		r[g] = grains->radius[g] * base.radiusFactor;
		spinRim(g);
	}
	const PackedRadiiInAll all = radiiInAll(*grains, base.radiusFactor);
	largestRadius              = all.largest;
	smallestRadius             = all.smallest;
	averageRadius              = all.mean;
}

PackedRadiiInAll radiiInAll(const PackedGrains& grains, double factor)
{
	PackedRadiiInAll all { 0, grains.radius[0] * factor, 0 };
	for (const double own : grains.radius) {
		const double r = own * factor;
		all.largest    = std::max(all.largest, r);
		all.smallest   = std::min(all.smallest, r);
		all.mean += r;
	}
	all.mean /= double(grains.size());
	return all;
}

/// Velocity of a grain's rim, w r.
template <int Dim> void PackedWorkspace<Dim>::spinRim(std::size_t g)
{
	if constexpr (Dim == 2) {
		view.rim[g] = view.spin(g, 0) * view.radius[g];
	} else {
		view.position(g)[3] = view.spin(g, 0) * view.radius[g];
		view.velocity(g)[3] = view.spin(g, 1) * view.radius[g];
		view.velocity(g)[7] = view.spin(g, 2) * view.radius[g];
	}
}

template <int Dim> void PackedWorkspace<Dim>::bind()
{
	const auto numbersOf = [](Rows& rows) { return rows.empty() ? nullptr : rows.data()->value; };
	const auto pairsOf   = [](Lanes& lanes, bool crosses) {
                PackedPairs<Dim> pairs;
                pairs.block   = lanes.block.data();
                pairs.ice     = lanes.ice.data();
                pairs.shift   = crosses ? lanes.shift.data() : nullptr;
                pairs.blocks  = lanes.block.size();
                pairs.rolling = lanes.rolling.data();
                pairs.moments = lanes.moments.data();
                return pairs;
	};
	view.place              = numbersOf(place);
	view.speed              = numbersOf(speed);
	view.force              = numbersOf(force);
	view.turning            = numbersOf(turning);
	view.rim                = numbersOf(rim);
	view.angle              = numbersOf(angle);
	view.minusInverseMass   = numbersOf(minusInverseMass);
	view.inverseInertia     = numbersOf(inverseInertia);
	view.radius             = numbersOf(radius);
	view.inverseSlackSquare = numbersOf(inverseSlackSquare);
	view.grains             = rowCount;
	view.inner              = pairsOf(innerLanes, false);
	view.periodic           = pairsOf(periodicLanes, true);
	view.shiftPlace         = numbersOf(shiftPlace);
	view.shiftSpeed         = numbersOf(shiftSpeed);
	view.shiftForce         = numbersOf(shiftForce);
	view.shiftCell          = shiftCell.data();
	view.shifts             = shiftCell.size() / Dim;
}

template <int Dim> void PackedWorkspace<Dim>::store(PackedState<Dim>& state, PackedLists<Dim>* lists) const
{
	static_cast<PackedParameters<Dim>&>(state) = parameters();
	state.grains                               = grains;
	state.position.resize(grainCount);
	state.velocity.resize(grainCount);
	state.angularVelocity.resize(grainCount);
	state.orientation.resize(Dim == 2 ? grainCount : 0);
	for (std::size_t g = 0; g < grainCount; ++g) {
		for (int d = 0; d < Dim; ++d) {
			state.position[g][d] = view.position(g)[d];
			state.velocity[g][d] = view.velocity(g)[d];
		}
		if constexpr (Dim == 2) {
			state.angularVelocity[g] = view.spin(g, 0);
			state.orientation[g]     = view.angle[g];
		} else {
			for (int d = 0; d < 3; ++d)
				state.angularVelocity[g][d] = view.spin(g, d);
		}
	}
	storeContacts(state.contacts, lists);
}

template <int Dim> const PackedParameters<Dim>& PackedWorkspace<Dim>::parameters() const
{
	copyMatrices<Dim>(view, base);
	return base;
}

template <int Dim> typename PackedWorkspace<Dim>::Matrix PackedWorkspace<Dim>::hSize() const
{
	Matrix h;
	copyMatrix<Dim>(view.hSize, h);
	return h;
}

template <int Dim> void PackedWorkspace<Dim>::setNextVelGrad(const Matrix& velGrad) { copyMatrix<Dim>(velGrad, view.nextVelGrad); }

template <int Dim> void PackedWorkspace<Dim>::setStrengths()
{
	// what is left of a bond without ice is no ice
	const BondStrengthFactors factors = base.ice.melted(base.iceSaturation) ? BondStrengthFactors() : strengthFactors;

	tensileStrength = factors.tensile * base.ice.tensileStrengthAt(base.iceSaturation);
	shearStrength   = factors.shear * base.ice.shearStrengthAt(base.iceSaturation);
}

template <int Dim> void PackedWorkspace<Dim>::selectKernel() { kernel = stepKernel<Dim>(contactKind(), portable); }

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
	Matrix     sum   = Matrix::Zero();
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

/// Eq. (13.3), from the virial of the grains and of their images.
template <int Dim> void PackedWorkspace<Dim>::finishStress(Matrix& stress) const
{
	copyMatrix<Dim>(view.virial, stress);
	for (const std::size_t k : shiftOrder)
		for (int i = 0; i < Dim; ++i)
			for (int j = 0; j < Dim; ++j)
				stress(i, j) -= view.shiftForce[k * PackedLayout<Dim>::row + i] * view.shiftPlace[4 * k + j];
	stress /= parameters().volume();
}

namespace {
	/// Of a multiple of packedWidth numbers.
	bool allFinite(const double* numbers, std::size_t count)
	{
		double sum[packedWidth] {};
		for (std::size_t k = 0; k < count; k += packedWidth)
			for (std::size_t l = 0; l < packedWidth; ++l)
				sum[l] += numbers[k + l] * 0;
		return std::all_of(sum, sum + packedWidth, [](double zero) { return zero == 0; });
	}
} // namespace

template <int Dim> void PackedWorkspace<Dim>::checkHealth() const
{
	if (!allFinite(view.place, 4 * rowCount) || (Dim == 3 && !allFinite(view.speed, 8 * rowCount)))
		throw PackedBlowUp("a grain's position or velocity is not finite");
	if (!listsValid) return;
	for (const Lanes* lanes : { &innerLanes, &periodicLanes })
		for (std::size_t lane = 0; lane < lanes->pairs; ++lane) {
			const std::size_t         b = lane / packedWidth, l = lane % packedWidth;
			const PackedPairRows<Dim> rows = pairRows(view, lanes == &innerLanes ? view.inner : view.periodic, lane);
			double                    branch[Dim];
			const double              square  = pairBranch(view, rows, branch);
			const double              allowed = lanes->block[b].sumRadius[l] - smallestRadius;
			if (square >= allowed * allowed) continue;
			const double smaller = std::min(view.radius[rows.first], view.radius[rows.second]);
			if (lanes->block[b].sumRadius[l] - std::sqrt(square) > smaller)
				throw PackedBlowUp(
				        "the overlap of grains " + std::to_string(rows.first) + " and " + std::to_string(rows.second) + " exceeds a radius");
		}
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
	state.hSize                                     = before * combination.template cast<double>();
	state.prevHSize                                 = state.prevHSize * combination.template cast<double>();
	const Eigen::Matrix<int, Dim, Dim>      unwind  = integerInverse<Dim>(combination);
	const Matrix                            inverse = state.hSize.inverse();
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

// ---------------------------------------------------------------------------------------------- constants of pairs

namespace {
	/// k_g of grains with such radii [N/m].
	double grainStiffness(double young, double a, double b) { return 2 * young * a * b / (a + b); }
} // namespace

template <int Dim> ContactStiffness PackedWorkspace<Dim>::stiffness(const Lanes& lanes, std::size_t lane, double ratio) const
{
	const PackedBlock<Dim>& block = lanes.block[lane / packedWidth];
	const double            a = grains->radius[rowOf(block.first[lane % packedWidth])], b = grains->radius[rowOf(block.second[lane % packedWidth])];
	return { grainStiffness(base.ice.young, a, b), base.stiffnessRatio, ratio, grains->hertz.stiffness(a, b) };
}

template <int Dim> BondStrength PackedWorkspace<Dim>::strength(const Lanes& lanes, std::size_t lane) const
{
	const PackedBlock<Dim>& block = lanes.block[lane / packedWidth];
	const double            area  = base.ice.bondArea(
	                    std::min(grains->radius[rowOf(block.first[lane % packedWidth])], grains->radius[rowOf(block.second[lane % packedWidth])]));
	return { tensileStrength * area, shearStrength * area };
}

/// setResponse() of all pairs. Grains without bonds and rolling need radii and stiffness only.
template <int Dim> void PackedWorkspace<Dim>::setResponses(Lanes& lanes)
{
	if (Dim == 3 || carriesBonds || resistsRolling || grains->hertz.acts()) {
		for (std::size_t lane = 0; lane < lanes.pairs; ++lane)
			setResponse(lanes, lane);
		return;
	}
	const double *const now = view.radius, *const own = grains->radius.data();
	const double young = base.ice.young;
	for (std::size_t lane = 0; lane < lanes.pairs; ++lane) {
		PackedBlock<Dim>&   block = lanes.block[lane / packedWidth];
		const std::size_t   l     = lane % packedWidth;
		const std::uint32_t first = rowOf(block.first[l]), second = rowOf(block.second[l]);
		block.sumRadius[l] = now[first] + now[second];
		block.stiffness[l] = grainStiffness(young, own[first], own[second]);
	}
}

/// Radii, stiffness and bond of a pair into its lane.
template <int Dim> void PackedWorkspace<Dim>::setResponse(Lanes& lanes, std::size_t lane)
{
	PackedBlock<Dim>&      block = lanes.block[lane / packedWidth];
	const std::size_t      l     = lane % packedWidth;
	const ContactStiffness k     = stiffness(lanes, lane, iceRatio);
	const double           first = view.radius[rowOf(block.first[l])], second = view.radius[rowOf(block.second[l])];
	block.sumRadius[l] = first + second;
	if constexpr (Dim == 3) block.halfDifference[l] = 0.5 * (first - second);
	block.stiffness[l] = k.withoutIce();
	if (resistsRolling) setRolling(lanes, lane, k.shearRatio * k.withoutIce());
	if (!carriesBonds) return;
	const IceBond&                bond    = lanes.bond[lane];
	const ContactResponse<double> contact = bond.response(k, strength(lanes, lane));
	block.stiffness[l]                    = contact.stiffness;
	PackedIceBlock<Dim>& ice              = lanes.ice[lane / packedWidth];
	ice.offset[l]                         = contact.offset;
	ice.floor[l]                          = contact.floor;
	ice.cohesion[l]                       = contact.cohesion;
	ice.iceShare[l]                       = contact.iceShare;
	if (bondsCarryMoments) setMoments(lanes, lane, k);
	if (bond.hasIceSpring()) return;
	Shear none;
	clearShear(none);
	setLaneShear<Dim>(ice.iceShear, l, none);
}

template <int Dim> void PackedWorkspace<Dim>::setRolling(Lanes& lanes, std::size_t lane, double shearStiffness)
{
	const std::size_t        l     = lane % packedWidth;
	const std::uint32_t      first = rowOf(lanes.block[lane / packedWidth].first[l]), second = rowOf(lanes.block[lane / packedWidth].second[l]);
	const double             r1 = grains->radius[first], r2 = grains->radius[second];
	PackedRollingBlock<Dim>& block = lanes.rolling[lane / packedWidth];
	block.stiffness[l]             = grains->rolling.stiffness(shearStiffness, r1, r2);
	block.lever[l]                 = grains->rolling.lever(r1, r2);
	block.inverseFirst[l]          = 1 / view.radius[first];
	block.inverseSecond[l]         = 1 / view.radius[second];
}

/// Only an intact bond carries moments.
template <int Dim> void PackedWorkspace<Dim>::setMoments(Lanes& lanes, std::size_t lane, const ContactStiffness& k)
{
	const std::size_t       l     = lane % packedWidth;
	const std::uint32_t     first = rowOf(lanes.block[lane / packedWidth].first[l]), second = rowOf(lanes.block[lane / packedWidth].second[l]);
	const double            area      = base.ice.bondArea(std::min(grains->radius[first], grains->radius[second]));
	const bool              intact    = lanes.bond[lane].intact();
	const MomentStiffness   stiffness = grains->section.stiffness(area, intact ? k.ice() : 0., k.shearRatio);
	PackedMomentBlock<Dim>& block     = lanes.moments[lane / packedWidth];
	block.bending[l]                  = stiffness.bending;
	block.twisting[l]                 = stiffness.twisting;
	block.edgeOverMoment[l]           = grains->section.edgeOverMoment(area);
	block.inverseFirst[l]             = 1 / view.radius[first];
	block.inverseSecond[l]            = 1 / view.radius[second];
	if (intact) return;
	Shear none;
	clearShear(none);
	setLaneShear<Dim>(block.moment, l, none);
}

template <int Dim> void PackedWorkspace<Dim>::updateShiftRows()
{
	double speed[Dim * Dim];
	multiply<Dim>(view.velGrad, view.prevHSize, speed);
	for (std::size_t k = 0; k < view.shifts; ++k) {
		double* place    = view.shiftPlace + 4 * k;
		double* velocity = Dim == 2 ? place + 2 : view.shiftSpeed + 8 * k;
		for (int d = 0; d < Dim; ++d) {
			double x = 0, v = 0;
			for (int e = 0; e < Dim; ++e) {
				x += view.hSize[d * Dim + e] * view.shiftCell[k * Dim + e];
				v += speed[d * Dim + e] * view.shiftCell[k * Dim + e];
			}
			place[d]    = x;
			velocity[d] = v;
		}
		for (int d = 4; Dim == 3 && d < 8; ++d)
			velocity[d] = -0.; // what is added to spins: it leaves every number as it is
		std::fill_n(view.shiftForce + k * PackedLayout<Dim>::row, PackedLayout<Dim>::row, 0.);
	}
}

// ---------------------------------------------------------------------------------------------- bonds of ice: their failure, and how they follow it

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

/// Eq. (14.5).
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
	const double young = base.ice.young * ((grains->hertz.acts() ? 0 : 1) + iceRatio);
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

// ---------------------------------------------------------------------------------------------- measures, from geometry and forces of contacts

template <int Dim> typename PackedWorkspace<Dim>::Geometry PackedWorkspace<Dim>::geometry(const Lanes& lanes, std::size_t lane) const
{
	Geometry pair;
	pair.rows      = pairRows(view, &lanes == &periodicLanes ? view.periodic : view.inner, lane);
	pair.distance  = std::sqrt(pairBranch(view, pair.rows, pair.n));
	pair.sumRadius = lanes.block[lane / packedWidth].sumRadius[lane % packedWidth];
	pair.overlap   = pair.sumRadius - pair.distance;
	for (double& component : pair.n)
		component /= pair.distance;
	return pair;
}

/// Geometry of all pairs of a block; square: of their distances [m2].
template <int Dim>
void PackedWorkspace<Dim>::blockGeometry(const PackedPairs<Dim>& pairs, std::size_t b, Geometry (&result)[packedWidth], double (&square)[packedWidth]) const
{
	double                  branch[Dim][packedWidth], distance[packedWidth];
	const PackedBlock<Dim>& block = pairs.block[b];
	for (std::size_t l = 0; l < packedWidth; ++l) {
		double n[Dim];
		result[l].rows = pairRows(view, pairs, b * packedWidth + l);
		square[l]      = pairBranch(view, result[l].rows, n);
		for (int d = 0; d < Dim; ++d)
			branch[d][l] = n[d];
	}
	for (std::size_t l = 0; l < packedWidth; ++l) {
		distance[l] = std::sqrt(square[l]);
		for (int d = 0; d < Dim; ++d)
			branch[d][l] /= distance[l];
	}
	for (std::size_t l = 0; l < packedWidth; ++l) {
		result[l].distance  = distance[l];
		result[l].sumRadius = block.sumRadius[l];
		result[l].overlap   = block.sumRadius[l] - distance[l];
		for (int d = 0; d < Dim; ++d)
			result[l].n[d] = branch[d][l];
	}
}

/// Calls visitor(geometry, normal spring, shear, bond) for every contact that bears or could bear a force.
template <int Dim> template <class Visitor> void PackedWorkspace<Dim>::forContacts(Visitor&& visit) const
{
	const bool hertz = grains->hertz.acts();
	for (const Lanes* lanes : { &innerLanes, &periodicLanes })
		for (std::size_t b = 0; b < lanes->block.size(); ++b) {
			const PackedBlock<Dim>& block = lanes->block[b];
			Geometry                pairs[packedWidth];
			double                  square[packedWidth];
			blockGeometry(lanes == &periodicLanes ? view.periodic : view.inner, b, pairs, square);
			for (std::size_t l = 0; l < std::min(packedWidth, lanes->pairs - b * packedWidth); ++l) {
				const Geometry& now = pairs[l];
				if (!carriesBonds) {
					if (square[l] > now.sumRadius * now.sumRadius || now.overlap < 0) continue;
					const ContactStiffness k { block.stiffness[l], 0, 0, hertz ? block.stiffness[l] : 0 };
					visit(now, k.grainSpring(now.overlap), laneShear<Dim>(block.shear, l), IceBond());
					continue;
				}
				const std::size_t lane = b * packedWidth + l;
				const IceBond     bond = lanes->bond[lane].relaxed(now.overlap);
				if (now.overlap < 0 && !bond.intact()) continue;
				const ContactStiffness k = stiffness(*lanes, lane, iceRatio);
				visit(now, k.spring(bond.response(k, strength(*lanes, lane)), now.overlap), laneShear<Dim>(block.shear, l), bond);
			}
		}
}

template <int Dim> PackedStatistics<Dim> PackedWorkspace<Dim>::statistics() const
{
	PackedStatistics<Dim> result;
	std::vector<Vector>   net(grainCount, Vector::Zero());
	double                forces = 0, overlaps = 0;
	forContacts([&](const Geometry& now, const NormalSpring& spring, const Shear& shear, const IceBond& bond) {
		double       force[Dim];
		const double normalForce = spring.force;
		const double norm        = shearNorm(shear);
		pairForce<Dim>(now.n, normalForce, shear, force);
		for (int d = 0; d < Dim; ++d) {
			net[now.rows.first][d] -= force[d];
			net[now.rows.second][d] += force[d];
			for (int e = 0; e < Dim; ++e)
				result.fabric(d, e) += now.n[d] * now.n[e];
		}
		forces += std::sqrt(normalForce * normalForce + norm * norm);
		++result.contacts;
		result.bondsIntact += bond.intact();
		result.bondsBroken += bond.state == BondState::BROKEN;
		if (now.overlap <= 0) return;
		overlaps += now.overlap / now.sumRadius;
		result.maxOverlapRatio = std::max(result.maxOverlapRatio, now.overlap / std::min(view.radius[now.rows.first], view.radius[now.rows.second]));
	});
	double solid = 0, imbalance = 0;
	for (std::size_t g = 0; g < grainCount; ++g) {
		const double* x      = view.position(g);
		const double  r      = view.radius[g];
		double        square = 0, spinSquare = 0;
		for (int d = 0; d < Dim; ++d) {
			double v = view.velocity(g)[d];
			for (int e = 0; e < Dim; ++e)
				v -= view.prevVelGrad[d * Dim + e] * x[e];
			square += v * v;
		}
		for (int d = 0; d < PackedLayout<Dim>::angular; ++d) {
			const double w = view.spin(g, d);
			spinSquare += w * w;
		}
		result.kineticEnergy += 0.5 * (grains->mass[g] * square + grains->inertia[g] * spinSquare);
		solid += Dim == 2 ? M_PI * r * r * base.thickness : 4. / 3. * M_PI * r * r * r;
		imbalance += net[g].norm();
	}
	result.porosity           = 1 - solid / parameters().volume();
	result.coordinationNumber = 2. * double(result.contacts) / double(grainCount);
	result.cellThickness      = cellThickness();
	if (result.contacts > 0) {
		result.fabric /= double(result.contacts);
		result.meanOverlapRatio = overlaps / double(result.contacts);
	}
	if (forces > 0) result.unbalancedForce = (imbalance / double(grainCount)) / (forces / double(result.contacts));
	return result;
}

template <int Dim> double PackedWorkspace<Dim>::cellThickness() const { return shortestImage<Dim>(hSize()) / (2 * averageRadius); }

template <int Dim> PackedTangent<Dim> tangentFromSums(const double* second, const double* fourth, double stiffnessRatio)
{
	constexpr int products = Dim * (Dim + 1) / 2;
	const auto    product  = [](int j, int l) {
                const auto [smaller, larger] = std::minmax({ j, l });
                return smaller * (2 * Dim - smaller - 1) / 2 + larger;
	};
	PackedTangent<Dim> result {};
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j)
			for (int k = 0; k < Dim; ++k)
				for (int l = 0; l < Dim; ++l) {
					const auto [first, last]                    = std::minmax({ product(i, j), product(k, l) });
					result[((i * Dim + j) * Dim + k) * Dim + l] = (1 - stiffnessRatio) * fourth[first * products + last]
					        + (i == k ? stiffnessRatio * second[product(j, l)] : 0.);
				}
	return result;
}

template <int Dim> PackedTangent<Dim> PackedWorkspace<Dim>::tangent() const
{
	// C = (1 - ratio) sum f n n n n + ratio sum f delta_ik n_j n_l with f = d^2 k_n/V
	constexpr int products = Dim * (Dim + 1) / 2; // n_j n_l with j <= l, row by row
	double        fourth[products][products] {}, second[products] {};
	const double  volume = parameters().volume();
	forContacts([&](const Geometry& now, const NormalSpring& spring, const Shear&, const IceBond&) {
		const double factor = now.distance * now.distance * spring.tangent / volume;
		double       pairs[products];
		for (int j = 0, k = 0; j < Dim; ++j)
			for (int l = j; l < Dim; ++l)
				pairs[k++] = now.n[j] * now.n[l];
		for (int k = 0; k < products; ++k) {
			const double weighted = factor * pairs[k];
			second[k] += weighted;
			for (int l = k; l < products; ++l)
				fourth[k][l] += weighted * pairs[l];
		}
	});
	return tangentFromSums<Dim>(second, &fourth[0][0], base.stiffnessRatio);
}

template <int Dim> double PackedWorkspace<Dim>::largestModulus() const
{
	const PackedTangent<Dim> c       = tangent();
	double                   largest = base.ice.young * overLinear(base, *grains, averageRadius) * (Dim == 2 ? averageRadius / base.thickness : 1);
	for (int d = 0; d < Dim; ++d)
		largest = std::max(largest, c[std::size_t(((d * Dim + d) * Dim + d) * Dim + d)]);
	return largest;
}

#define TALIK_FUNCTIONS_OF(Dim)                                                                                                          \
	template double             longestTimeStep<Dim>(const PackedParameters<Dim>&, const PackedGrains&, const PackedRadii&, double); \
	template bool               grainsShrink<Dim>(PackedThawStrain&, double&, double, double);                                       \
	template PackedTangent<Dim> tangentFromSums<Dim>(const double*, const double*, double);
TALIK_FUNCTIONS_OF(2)
TALIK_FUNCTIONS_OF(3)
#undef TALIK_FUNCTIONS_OF
TALIK_IN_PLANE_AND_SPACE(PackedWorkspace);

} // namespace talik
