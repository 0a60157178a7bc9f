// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cstring>
#include <Eigen/LU>
#include <pkg/rve/packed/PackedWorkspace.hpp>
#include <pkg/rve/SampleUpdate.hpp>

namespace talik {

template <int Dim>
PackedWorkspace<Dim>::PackedWorkspace(bool portableOnly)
        : portable(portableOnly)
{
	std::memset(&view, 0, sizeof(view));
	view.owner     = this;
	view.bondEvent = &PackedWorkspace::onBondEvent;
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
	double              mass = 1, stiffness = 0; // of the grain with the smallest m/k [kg, N/m]
	for (std::size_t g = 0; g < grains.size(); ++g) {
		const double own = radii.now[g] * GrainStiffening { rolls ? ofRolling / radii.now[g] : 0, ofMoments }.total(now);
		if (grains.mass[g] * stiffness >= mass * own) continue;
		mass      = grains.mass[g];
		stiffness = own;
	}
	const GrainStiffening ofSmallest { ofRolling / radii.smallest, ofMoments };
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

template <int Dim> void PackedWorkspace<Dim>::setFriction(double tangent)
{
	base.friction = view.friction = tangent;
	setStrengths();
}

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

template double longestTimeStep<2>(const PackedParameters<2>&, const PackedGrains&, const PackedRadii&, double);
template double longestTimeStep<3>(const PackedParameters<3>&, const PackedGrains&, const PackedRadii&, double);
TALIK_IN_PLANE_AND_SPACE(PackedWorkspace);

} // namespace talik
