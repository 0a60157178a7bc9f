// SPDX-License-Identifier: GPL-2.0-or-later
// Cells that a sample's deformation has made thin: images slip along lattice planes.
#include <algorithm>
#include <cmath>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <pkg/rve/packed/CellSlip.hpp>

namespace talik {

namespace {

	// Which lattice: chosen for so much stretch to come, looked at so often in a stretch of one.
	constexpr double horizon = 3, stationsPerStrain = 5;
	constexpr int    divisions[]   = { 64, 16 }; ///< shifts along a cell vector that are tried, of discs and of spheres
	constexpr double nearlyBest    = 0.95;       ///< least compactness over the best that is as good
	constexpr double gain          = 1.2;        ///< the same over that of the lattice as it is, which a slip has to reach
	constexpr double compactEnough = 0.65;       ///< spheres slip across a second plane only where one does not reach it

	// Where: places of a plane, and lattices of those nearly best, that are compared by the contacts lost and the overlaps made.
	constexpr int offsets = 32, lattices = 24;

	// How grains part: sweeps over all pairs, and of them on one list of neighbours; then steps with strong damping.
	constexpr int    sweeps = 400, sweepsOfList = 20;
	constexpr long   stepsAtRest   = 1000;
	constexpr double dampingAtRest = 0.7;

	// How the sample carries its stress again. Parts are those of the largest component of the stress from before.
	constexpr long   interval    = 20;                       ///< steps between two looks at the stress
	constexpr long   stepsToStop = 60;                       ///< before a look at rest
	constexpr double leastShear = 0.02, largestShear = 0.1;  ///< strain in which it does [-]
	constexpr double carriedAgain = 0.05, worthALook = 0.02; ///< part that may be missing; part by which a look at rest has to promise more
	constexpr double farFromIt = 0.5, largestDilation = 0.1; ///< part from which on volume changes, too; by how much at most [-]

	template <int Dim> typename PackedTypes<Dim>::Matrix reduced(const typename PackedTypes<Dim>::Matrix& h)
	{
		return h * cellReduction<Dim>(h, 0.5).template cast<double>();
	}

	template <int Dim> double side(const typename PackedTypes<Dim>::Matrix& h)
	{
		const double volume = std::fabs(h.determinant());
		return Dim == 2 ? std::sqrt(volume) : std::cbrt(volume);
	}

	template <int Dim> typename PackedTypes<Dim>::Matrix symmetricPart(const typename PackedTypes<Dim>::Matrix& m) { return 0.5 * (m + m.transpose()); }

	template <int Dim> typename PackedTypes<Dim>::Matrix deviator(const typename PackedTypes<Dim>::Matrix& m)
	{
		return m - m.trace() / Dim * PackedTypes<Dim>::Matrix::Identity();
	}

	template <class M> M exponential(const M& generator)
	{
		M sum = M::Identity(), term = M::Identity();
		for (int k = 1; k <= 16; ++k) {
			term = (term * generator / double(k)).eval();
			sum += term;
		}
		return sum;
	}

	/// Grows by one where a cell has become thinner by a tenth; below 0 no slip is due.
	template <int Dim> int thinness(double compactness) { return int(std::floor(std::log(leastCompactness<Dim> / compactness) / 0.1)); }

	/// Which lattice, and along which of its planes: columns of hSize (1 + shift) are the new cell vectors.
	template <int Dim> struct Slip {
		typename PackedTypes<Dim>::Matrix shift  = PackedTypes<Dim>::Matrix::Zero();
		double                            rating = 0;
		bool                              across(int d) const { return !shift.col(d).isZero(0); }
		/// Whether a pair so many cells apart is divided by one of the planes.
		bool divides(const typename PackedTypes<Dim>::CellDist& cells) const
		{
			for (int d = 0; d < Dim; ++d)
				if (across(d) && cells[std::size_t(d)] != 0) return true;
			return false;
		}
	};

	template <int Dim> class CellSlip {
		using Vector = typename PackedTypes<Dim>::Vector;
		using Matrix = typename PackedTypes<Dim>::Matrix;

	public:
		CellSlip(PackedSample<Dim>& sample, const Matrix& displacementGradient)
		        : workspace(sample)
		        , target(symmetricPart<Dim>(sample.lastStress()))
		{
			workspace.store(state);
			chooseMotions(displacementGradient);
		}

		/// False: no lattice would be better, and nothing has changed. Throws PackedBlowUp.
		bool perform()
		{
			const Slip<Dim> slip = choose();
			if (!(slip.rating > 0)) return false;
			const Matrix trsf = state.trsf;
			cut(slip);
			separate(slip);
			comeToRest();
			double strain = shearOn();
			if (missing() > farFromIt) strain += strainTowards();
			workspace.checkHealth();
			workspace.store(state);
			state.trsf = trsf;
			++state.cellSlips;
			state.cellSlipStrain += strain;
			state.cellSlipStress = std::max(state.cellSlipStress, (symmetricPart<Dim>(workspace.lastStress()) - target).norm());
			const Matrix stress  = workspace.lastStress();
			workspace.load(state);
			workspace.setLastStress(stress);
			workspace.flip(0.5);
			return true;
		}

	private:
		// ---- which lattice ------------------------------------------------------------------------------------------------------

		/// Motions that the sample may be asked for from now on, at a stretch of one: the last one, and the one that made its cell thin.
		void chooseMotions(const Matrix& displacementGradient)
		{
			const auto add = [this](const Matrix& rate) {
				const Matrix strain = symmetricPart<Dim>(rate);
				const double size   = deviator<Dim>(strain).norm();
				if (!(size > 1e-6 * rate.norm())) return;
				const bool turns = rate.norm() > 4 * size; // a turn alone thins no cell
				motions.push_back(exponential<Matrix>(deviator<Dim>(turns ? strain : rate) * (std::sqrt(2.) / size / stationsPerStrain)));
			};
			add(displacementGradient);
			const Eigen::SelfAdjointEigenSolver<Matrix> form(Matrix(state.hSize * state.hSize.transpose()));
			add(form.eigenvectors() * form.eigenvalues().array().log().matrix().asDiagonal() * form.eigenvectors().transpose());
		}

		/// Least compactness of a lattice up to the horizon.
		double rating(const Matrix& hSize, double enough) const
		{
			double least = cellCompactness<Dim>(hSize);
			for (const Matrix& motion : motions) {
				Matrix h = hSize;
				for (int k = 0; k < int(horizon * stationsPerStrain) && least > enough; ++k) {
					h     = reduced<Dim>(motion * h);
					least = std::min(least, shortestImage<Dim>(h) / side<Dim>(h));
				}
			}
			return least;
		}

		void rate(Slip<Dim>& slip, std::vector<Slip<Dim>>& all, double& best) const
		{
			slip.rating = rating(state.hSize * (Matrix::Identity() + slip.shift), nearlyBest * best);
			best        = std::max(best, slip.rating);
			all.push_back(slip);
		}

		/// Slips across one plane; of spheres, where those do not suffice, across two that share a cell vector.
		std::vector<Slip<Dim>> ratedSlips(double& best) const
		{
			constexpr int          n = divisions[Dim - 2];
			std::vector<Slip<Dim>> all;
			const auto             part = [](int k) { return (k + 0.5) / n; };
			for (int d = 0; d < Dim; ++d)
				for (int k = 0; k < (Dim == 2 ? n : n * n); ++k) {
					Slip<Dim> slip;
					slip.shift((d + 1) % Dim, d) = part(k % n);
					if (Dim == 3) slip.shift((d + 2) % Dim, d) = part(k / n);
					rate(slip, all, best);
				}
			if (Dim == 2 || best > compactEnough) return all;
			for (int d = 0; d < Dim; ++d)
				for (int k = 0; k < n * n; ++k) {
					Slip<Dim> slip;
					slip.shift(d, (d + 1) % Dim) = part(k % n);
					slip.shift(d, (d + 2) % Dim) = part(k / n);
					rate(slip, all, best);
				}
			return all;
		}

		/// Of the lattices that stay compact for long that whose grains overlap least.
		Slip<Dim> choose() const
		{
			double                 best = gain * rating(state.hSize, 0);
			std::vector<Slip<Dim>> all  = ratedSlips(best);
			all.erase(std::remove_if(all.begin(), all.end(), [&](const Slip<Dim>& slip) { return slip.rating < nearlyBest * best; }), all.end());
			Slip<Dim>         chosen;
			double            least = INFINITY;
			const std::size_t every = std::max<std::size_t>(1, all.size() / lattices);
			for (std::size_t k = 0; k < all.size(); k += every) {
				PackedState<Dim> copy = state;
				const double     lost = double(applyTo(copy, all[k]));
				const double     cost = lost + overlapsOf(copy);
				if (cost >= least) continue;
				least  = cost;
				chosen = all[k];
			}
			return chosen;
		}

		// ---- the cut ------------------------------------------------------------------------------------------------------------

		/// Cells that a contact crosses in direction d when the cell begins at so much of its vector.
		static int crossed(const PackedContacts<Dim>& c, std::size_t k, int d, double from, const std::vector<Vector>& place)
		{
			return c.cellDist[k][std::size_t(d)] + int(std::floor(place[c.second[k]][d] - from) - std::floor(place[c.first[k]][d] - from));
		}

		static std::vector<Vector> placesOf(const PackedState<Dim>& s)
		{
			const Matrix        inverse = s.hSize.inverse();
			std::vector<Vector> places;
			for (const Vector& x : s.position)
				places.push_back(inverse * x);
			return places;
		}

		/// Where the plane cuts the fewest contacts.
		static double bestPlane(const PackedState<Dim>& s, int d, const std::vector<Vector>& place)
		{
			double      best  = 0;
			std::size_t least = s.contacts.size() + 1;
			for (int m = 0; m < offsets; ++m) {
				std::size_t cut = 0;
				for (std::size_t k = 0; k < s.contacts.size(); ++k)
					cut += crossed(s.contacts, k, d, double(m) / offsets, place) != 0;
				if (cut >= least) continue;
				least = cut;
				best  = double(m) / offsets;
			}
			return best;
		}

		/// Grains go into the cell that begins at its planes, contacts across these are lost, then the cell vectors shift. Returns how many.
		static std::size_t applyTo(PackedState<Dim>& s, const Slip<Dim>& slip)
		{
			const std::vector<Vector> place = placesOf(s);
			PackedContacts<Dim>&      c     = s.contacts;
			std::vector<char>         kept(c.size(), 1);
			for (int d = 0; d < Dim; ++d) {
				if (!slip.across(d)) continue;
				const double from = bestPlane(s, d, place);
				for (std::size_t k = 0; k < c.size(); ++k) {
					const int cells               = crossed(c, k, d, from, place);
					c.cellDist[k][std::size_t(d)] = std::int8_t(cells);
					if (cells != 0) kept[k] = 0;
				}
				for (std::size_t g = 0; g < s.size(); ++g)
					s.position[g] -= std::floor(place[g][d] - from) * s.hSize.col(d);
			}
			const std::size_t before = c.size();
			for (std::size_t k = 0; k < before; ++k)
				if (!kept[k] && s.bonded() && c.iceBond(k).intact()) ++s.bondsBrokenInShear;
			const auto keep = [&](auto& array) {
				if (array.empty()) return;
				std::size_t to = 0;
				for (std::size_t k = 0; k < before; ++k)
					if (kept[k]) array[to++] = array[k];
				array.resize(to);
			};
			keep(c.first);
			keep(c.second);
			keep(c.cellDist);
			keep(c.shear);
			keep(c.moment);
			keep(c.iceShear);
			keep(c.iceReference);
			keep(c.grainReference);
			keep(c.bondMoment);
			keep(c.bond);
			s.hSize     = (s.hSize * (Matrix::Identity() + slip.shift)).eval();
			s.prevHSize = s.hSize;
			return before - c.size();
		}

		void cut(const Slip<Dim>& slip)
		{
			const double contacts = double(std::max<std::size_t>(1, state.contacts.size()));
			meanOverlap           = overlapsOf(state) / contacts;
			applyTo(state, slip);
			std::fill(state.velocity.begin(), state.velocity.end(), Vector::Zero());
			for (auto& spin : state.angularVelocity)
				clearShear(spin);
		}

		// ---- overlaps -----------------------------------------------------------------------------------------------------------

		struct Pair {
			PairKey<Dim> key;
			Vector       shift;
			double       allowed; ///< overlap [m]
		};

		static double radiusOf(const PackedState<Dim>& s, std::size_t g) { return s.grains->radius[g] * s.radiusFactor; }

		/// Pairs with a gap of less than the skin on either grain.
		static std::vector<Pair> pairsOf(const PackedState<Dim>& s, double skin)
		{
			std::vector<double>        radii;
			std::vector<std::uint64_t> keys[2];
			double                     h[Dim * Dim];
			for (std::size_t g = 0; g < s.size(); ++g)
				radii.push_back(radiusOf(s, g) + skin);
			copyMatrix<Dim>(s.hSize, h);
			NeighbourSearch<Dim>().build(s.position.front().data(), Dim, radii.data(), s.size(), h, keys[0], keys[1]);
			std::vector<Pair> pairs;
			for (auto& of : keys) {
				std::sort(of.begin(), of.end());
				for (const std::uint64_t key : of) {
					const PairKey<Dim> pair = PairKey<Dim>::decode(key);
					Vector             cells;
					for (int d = 0; d < Dim; ++d)
						cells[d] = pair.cellDist[std::size_t(d)];
					pairs.push_back({ pair, s.hSize * cells, 0 });
				}
			}
			return pairs;
		}

		static double overlapOf(const PackedState<Dim>& s, const Pair& pair, Vector& branch)
		{
			branch = s.position[pair.key.second] + pair.shift - s.position[pair.key.first];
			return radiusOf(s, pair.key.first) + radiusOf(s, pair.key.second) - branch.norm();
		}

		/// Sum over pairs of overlap over radii.
		static double overlapsOf(const PackedState<Dim>& s)
		{
			double sum = 0;
			Vector branch;
			for (const Pair& pair : pairsOf(s, 0))
				sum += std::max(0., overlapOf(s, pair, branch)) / (radiusOf(s, pair.key.first) + radiusOf(s, pair.key.second));
			return sum;
		}

		/// Grains that overlap by more than they did, or across the planes by more than others do on average, move apart.
		void separate(const Slip<Dim>& slip)
		{
			double radii = 0;
			for (std::size_t g = 0; g < state.size(); ++g)
				radii += radiusOf(state, g);
			const double           skin   = 0.1 * radii / double(state.size());
			const PackedState<Dim> before = state;
			std::vector<Pair>      pairs;
			Vector                 branch;
			for (int sweep = 0; sweep < sweeps; ++sweep) {
				if (sweep % sweepsOfList == 0) {
					pairs = pairsOf(state, skin);
					for (Pair& pair : pairs) {
						const double size = radiusOf(state, pair.key.first) + radiusOf(state, pair.key.second);
						pair.allowed      = meanOverlap * size;
						if (!slip.divides(pair.key.cellDist)) pair.allowed = std::max(pair.allowed, overlapOf(before, pair, branch));
					}
				}
				double largest = 0;
				for (const Pair& pair : pairs) {
					const double excess = overlapOf(state, pair, branch) - pair.allowed;
					if (!(excess > 0)) continue;
					const double distance = branch.norm(), size = radiusOf(state, pair.key.first) + radiusOf(state, pair.key.second);
					const double a = state.grains->mass[pair.key.first], b = state.grains->mass[pair.key.second];
					if (!(distance > 0)) throw PackedBlowUp("two grains of a cell that slipped stand in one place");
					branch *= 0.8 * excess / distance / (a + b);
					state.position[pair.key.first] -= b * branch;
					state.position[pair.key.second] += a * branch;
					largest = std::max(largest, excess / size);
				}
				if (largest < 0.5 * meanOverlap) return;
			}
		}

		// ---- stress -------------------------------------------------------------------------------------------------------------

		void comeToRest()
		{
			const double damping = state.damping;
			state.damping        = dampingAtRest;
			workspace.load(state);
			workspace.flip(0.5);
			workspace.run(stepsAtRest, interval);
			workspace.checkHealth();
			const Matrix stress = workspace.lastStress();
			workspace.store(state);
			state.damping = damping;
			workspace.load(state);
			workspace.setLastStress(stress);
		}

		/// Largest component of the stress from before less that of now, over the scale.
		double missing() const { return (target - symmetricPart<Dim>(workspace.lastStress())).cwiseAbs().maxCoeff() / scale(); }
		double scale() const { return std::max(target.cwiseAbs().maxCoeff(), PackedUpdateOptions().pressureFloor); }

		/// Strain of a step, eq. (13.1), at the stress from before.
		double strainOfStep() const
		{
			const PackedUpdateOptions ordinary;
			PackedParameters<Dim>     p = workspace.parameters();
			p.stress                    = -scale() * Matrix::Identity();
			return std::min(
			        ordinary.maxStrainPerStep,
			        strainPerStep<Dim>(p, p.dt, workspace.meanRadius(), ordinary.maxInertialNumber, ordinary.pressureFloor));
		}

		void stop()
		{
			workspace.setNextVelGrad(Matrix::Zero());
			workspace.run(stepsToStop, interval);
		}

		/// Shears the sample on along its stress, at its volume, and leaves it where it carries at rest most nearly what it did. Returns the strain.
		double shearOn()
		{
			const Matrix along = deviator<Dim>(target);
			const double size = along.cwiseAbs().maxCoeff(), perInterval = strainOfStep() * double(interval);
			if (!(size > carriedAgain * scale())) return 0;
			const Matrix     rate  = strainOfStep() / workspace.timeStep() / size * along;
			double           least = INFINITY, taken = 0;
			PackedState<Dim> best, moving;
			workspace.store(best);
			workspace.setNextVelGrad(rate);
			for (double sheared = perInterval; sheared < largestShear && least > carriedAgain; sheared += perInterval) {
				workspace.run(interval, interval);
				if (sheared < leastShear || missing() + worthALook > least) continue;
				workspace.store(moving);
				stop();
				if (missing() < least) {
					least = missing();
					taken = sheared;
					workspace.store(best);
				}
				workspace.load(moving);
			}
			workspace.load(best);
			return taken;
		}

		/// Where much is missing: towards the stress from before, in volume and shear. Returns the strain.
		double strainTowards()
		{
			const double perStep = strainOfStep(), limit = perStep / workspace.timeStep();
			const double share  = 0.2 / (workspace.largestModulus() * double(interval) * workspace.timeStep()),
			             volume = std::log(workspace.parameters().volume());
			double strained     = 0;
			for (; strained < largestShear && missing() > carriedAgain; strained += perStep * double(interval)) {
				if (std::fabs(std::log(workspace.parameters().volume()) - volume) > largestDilation) break;
				const Matrix rate = share * (target - symmetricPart<Dim>(workspace.lastStress()));
				workspace.setNextVelGrad(rate.unaryExpr([limit](double r) { return std::max(-limit, std::min(limit, r)); }));
				workspace.run(interval, interval);
			}
			stop();
			return strained;
		}

		PackedSample<Dim>&  workspace;
		PackedState<Dim>    state;
		const Matrix        target;
		std::vector<Matrix> motions;
		double              meanOverlap = 0; ///< over the sum of radii, of grains that touched before [-]
	};

} // namespace

template <int Dim> double cellCompactness(const typename PackedTypes<Dim>::Matrix& hSize) { return shortestImage<Dim>(hSize) / side<Dim>(hSize); }

template <int Dim> bool isCompact(const typename PackedTypes<Dim>::Matrix& h)
{
	const double shortest = h.colwise().squaredNorm().minCoeff(), volume = h.determinant();
	const double wanted = leastCompactness<Dim> * leastCompactness<Dim>;
	return Dim == 2 ? shortest > wanted * std::fabs(volume) : shortest * shortest * shortest > wanted * wanted * wanted * volume * volume;
}

template <int Dim>
void slipWhereThin(
        PackedSample<Dim>& workspace, const typename PackedTypes<Dim>::Matrix& displacementGradient, const PackedUpdateOptions& options,
        PackedUpdateResult<Dim>& result)
{
	using Matrix   = typename PackedTypes<Dim>::Matrix;
	const Matrix h = workspace.hSize();
	if (isCompact<Dim>(h)) return;
	if (!(options.flipSkew > 0) || displacementGradient.isZero(0)) return;
	const Matrix before = (Matrix::Identity() + displacementGradient).inverse() * h;
	const int    due    = thinness<Dim>(cellCompactness<Dim>(h));
	if (due < 0 || due <= thinness<Dim>(cellCompactness<Dim>(before))) return;
	PackedState<Dim> state;
	workspace.store(state);
	try {
		if (!CellSlip<Dim>(workspace, displacementGradient).perform()) return;
	} catch (const std::runtime_error&) {
		workspace.load(state); // it stays thin until it has become thinner by a tenth
		return;
	}
	result.slipped = true;
	result.stress  = symmetricPart<Dim>(workspace.lastStress());
	result.steps += long(workspace.parameters().step - state.step);
	if (options.tangent) result.tangent = workspace.tangent();
}

std::string ofThinCell(double thickness)
{
	constexpr double wide = 3; // pkg/rve/README.md
	if (!(thickness < wide)) return "";
	return "; the likely cause: the periodic cell was stretched until it was " + std::to_string(thickness).substr(0, 4)
	        + " mean diameters thin, where grains meet images of themselves; take samples with more grains";
}

#define TALIK_CELL_SLIP_OF(Dim)                                                \
	template double cellCompactness<Dim>(const PackedTypes<Dim>::Matrix&); \
	template bool   isCompact<Dim>(const PackedTypes<Dim>::Matrix&);       \
	template void   slipWhereThin<Dim>(PackedSample<Dim>&, const PackedTypes<Dim>::Matrix&, const PackedUpdateOptions&, PackedUpdateResult<Dim>&);
TALIK_CELL_SLIP_OF(2)
TALIK_CELL_SLIP_OF(3)
#undef TALIK_CELL_SLIP_OF

} // namespace talik
