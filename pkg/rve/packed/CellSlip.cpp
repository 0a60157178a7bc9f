// SPDX-License-Identifier: GPL-2.0-or-later
// Cells that a sample's deformation has made thin: images slip along lattice planes.
#include <algorithm>
#include <cmath>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <pkg/rve/packed/CellSlip.hpp>

namespace talik {

namespace {

	constexpr int divisions[] = { 64, 16 }; ///< shifts along a cell vector that are tried, of discs and of spheres

	// How grains part: sweeps over all pairs, then steps with strong damping, without which a third of the bonds that hold would break.
	constexpr int    sweeps        = 400;
	constexpr long   stepsAtRest   = 1000;
	constexpr double dampingAtRest = 0.7;

	// How the sample carries its stress again: to this part of the largest component, in so many steps at most.
	constexpr double carriedAgain = 0.05;
	constexpr long   mostSteps    = 10000;

	template <int Dim> double side(const typename PackedTypes<Dim>::Matrix& h)
	{
		const double volume = std::fabs(h.determinant());
		return Dim == 2 ? std::sqrt(volume) : std::cbrt(volume);
	}

	template <int Dim> typename PackedTypes<Dim>::Matrix symmetricPart(const typename PackedTypes<Dim>::Matrix& m) { return 0.5 * (m + m.transpose()); }

	/// Grows by one where a cell has become thinner by a tenth; below 0 no slip is due.
	template <int Dim> int thinness(double compactness) { return int(std::floor(std::log(leastCompactness<Dim> / compactness) / 0.1)); }

	/// Which lattice, and along which of its planes: columns of hSize (1 + shift) are the new cell vectors.
	template <int Dim> struct Slip {
		typename PackedTypes<Dim>::Matrix shift = PackedTypes<Dim>::Matrix::Zero();
		/// Whether a pair so many cells apart is divided by one of the planes.
		bool divides(const typename PackedTypes<Dim>::CellDist& cells) const
		{
			for (int d = 0; d < Dim; ++d)
				if (!shift.col(d).isZero(0) && cells[std::size_t(d)] != 0) return true;
			return false;
		}
	};

	template <int Dim> class CellSlip {
		using Vector = typename PackedTypes<Dim>::Vector;
		using Matrix = typename PackedTypes<Dim>::Matrix;

	public:
		explicit CellSlip(PackedSample<Dim>& sample)
		        : workspace(sample)
		        , state(sample.state())
		        , target(symmetricPart<Dim>(state.stress))
		        , meanOverlap(sample.statistics().meanOverlapRatio)
		{}

		/// False: no lattice would be better, and nothing has changed. Throws PackedBlowUp.
		bool perform()
		{
			const Slip<Dim> slip = choose();
			if (slip.shift.isZero(0)) return false;
			const Matrix trsf = state.trsf;
			cut(slip);
			separate();
			comeToRest();
			state.cellSlipStrain += carryAgain();
			state.cellSlipStress = std::max(state.cellSlipStress, (symmetricPart<Dim>(state.stress) - target).norm());
			++state.cellSlips;
			state.trsf = trsf;
			workspace.load(state);
			workspace.flip(0.5);
			return true;
		}

	private:
		// ---- which lattice ------------------------------------------------------------------------------------------------------

		/// That which stays most compact when the stretch that made the cell thin comes once more. Discs slip along lines, spheres across one plane
		/// or two that share a cell vector.
		Slip<Dim> choose() const
		{
			constexpr int n           = divisions[Dim - 2];
			const Matrix  h           = state.hSize;
			const Matrix  stretch     = Eigen::SelfAdjointEigenSolver<Matrix>(Matrix(h * h.transpose())).operatorSqrt() / side<Dim>(h);
			const auto    compactness = [&](const Matrix& lattice) {
                                return std::min(cellCompactness<Dim>(lattice), cellCompactness<Dim>(stretch * lattice));
			};
			Slip<Dim>  best;
			double     most     = compactness(h);
			const auto consider = [&](int row, int column, int otherRow, int otherColumn, int k) {
				Slip<Dim> slip;
				slip.shift(row, column) = (k % n + 0.5) / n;
				if (Dim == 3) slip.shift(otherRow, otherColumn) = (k / n + 0.5) / n;
				const double compact = compactness(h * (Matrix::Identity() + slip.shift));
				if (!(compact > most)) return;
				most = compact;
				best = slip;
			};
			for (int d = 0; d < Dim; ++d)
				for (int k = 0, next = (d + 1) % Dim, last = (d + 2) % Dim; k < (Dim == 2 ? n : n * n); ++k) {
					consider(next, d, last, d, k);
					if (Dim == 3) consider(d, next, d, last, k);
				}
			return best;
		}

		// ---- the cut ------------------------------------------------------------------------------------------------------------

		/// Grains go into the cell, contacts across the planes are lost, then the cell vectors shift.
		void cut(const Slip<Dim>& slip)
		{
			const Matrix        inverse = state.hSize.inverse();
			std::vector<Vector> cell;
			for (Vector& x : state.position) {
				cell.push_back((inverse * x).array().floor());
				x -= state.hSize * cell.back();
			}
			PackedContacts<Dim>& c = state.contacts;
			std::vector<char>    kept(c.size());
			for (std::size_t k = 0; k < c.size(); ++k) {
				for (int d = 0; d < Dim; ++d)
					c.cellDist[k][std::size_t(d)] += std::int8_t(cell[c.second[k]][d] - cell[c.first[k]][d]);
				kept[k] = !slip.divides(c.cellDist[k]);
				state.bondsBrokenInShear += !kept[k] && state.bonded() && c.iceBond(k).intact();
			}
			const auto keep = [&](auto&... arrays) {
				const auto keepOf = [&](auto& array) {
					auto to = array.begin();
					for (std::size_t k = 0; k < array.size(); ++k)
						if (kept[k]) *to++ = array[k];
					array.erase(to, array.end());
				};
				(keepOf(arrays), ...);
			};
			keep(c.first, c.second, c.cellDist, c.shear, c.moment, c.iceShear, c.iceReference, c.grainReference, c.bondMoment, c.bond);
			state.hSize     = (state.hSize * (Matrix::Identity() + slip.shift)).eval();
			state.prevHSize = state.hSize;
			std::fill(state.velocity.begin(), state.velocity.end(), Vector::Zero());
			for (auto& spin : state.angularVelocity)
				clearShear(spin);
		}

		// ---- overlaps -----------------------------------------------------------------------------------------------------------

		struct Pair {
			std::size_t first, second;
			Vector      shift; ///< of the image of the second
		};

		double radiusOf(std::size_t g) const { return state.grains->radius[g] * state.radiusFactor; }

		std::vector<Pair> pairsThatTouch() const
		{
			std::vector<double>        radii;
			std::vector<std::uint64_t> keys[2];
			double                     h[Dim * Dim];
			for (std::size_t g = 0; g < state.size(); ++g)
				radii.push_back(radiusOf(g));
			copyMatrix<Dim>(state.hSize, h);
			NeighbourSearch<Dim>().build(state.position.front().data(), Dim, radii.data(), state.size(), h, keys[0], keys[1]);
			std::vector<Pair> pairs;
			for (auto& of : keys) {
				std::sort(of.begin(), of.end());
				for (const std::uint64_t key : of) {
					const PairKey<Dim> pair = PairKey<Dim>::decode(key);
					Vector             cells;
					for (int d = 0; d < Dim; ++d)
						cells[d] = pair.cellDist[std::size_t(d)];
					pairs.push_back({ pair.first, pair.second, state.hSize * cells });
				}
			}
			return pairs;
		}

		/// Grains that overlap by more than those that touched before did on average move apart.
		void separate()
		{
			for (int sweep = 0; sweep < sweeps; ++sweep) {
				double largest = 0;
				for (const Pair& pair : pairsThatTouch()) {
					Vector &     one = state.position[pair.first], &other = state.position[pair.second];
					Vector       branch   = other + pair.shift - one;
					const double distance = branch.norm(), size = radiusOf(pair.first) + radiusOf(pair.second);
					const double excess = (1 - meanOverlap) * size - distance;
					if (!(excess > 0)) continue;
					if (!(distance > 0)) throw PackedBlowUp("two grains of a cell that slipped stand in one place");
					const double a = state.grains->mass[pair.first], b = state.grains->mass[pair.second];
					branch *= excess / distance / (a + b);
					one -= b * branch;
					other += a * branch;
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
			workspace.run(stepsAtRest, 20);
			workspace.checkHealth();
			workspace.store(state);
			state.damping = damping;
			workspace.load(state);
		}

		/// Strains the sample towards the stress from before. Returns the strain.
		double carryAgain()
		{
			const Matrix              before = state.hSize;
			PackedServoOptions<Dim>   options;
			const PackedUpdateOptions ordinary;
			options.stress            = target;
			options.stressTolerance   = carriedAgain;
			options.pressureFloor     = ordinary.pressureFloor;
			options.maxInertialNumber = ordinary.maxInertialNumber;
			options.unbalancedLimit   = INFINITY;
			options.maxSteps          = mostSteps;
			workspace.strainTowards(options);
			workspace.store(state);
			return (state.hSize * before.inverse() - Matrix::Identity()).cwiseAbs().maxCoeff();
		}

		PackedSample<Dim>& workspace;
		PackedState<Dim>   state;
		const Matrix       target;
		const double       meanOverlap; ///< over the sum of radii, of grains that touched before [-]
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
		if (!CellSlip<Dim>(workspace).perform()) return;
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
