// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cmath>
#include <pkg/rve/packed/PackedNeighbours.hpp>
#include <pkg/rve/packed/PackedStepView.hpp>
#include <pkg/rve/SampleUpdate.hpp>
#include <stdexcept>
#include <vector>

namespace talik {

/// A sample that left the range of what the contact law can mean.
struct PackedBlowUp : std::runtime_error {
	using std::runtime_error::runtime_error;
};

/// The running form of one sample: rows of grains, pairs in blocks, neighbour lists. Takes a state, advances it, gives it back.
/// A thread needs one of them for any number of samples; buffers are kept.
template <int Dim> class PackedWorkspace {
public:
	using Vector = typename PackedTypes<Dim>::Vector;
	using Matrix = typename PackedTypes<Dim>::Matrix;
	using Shear  = typename PackedTypes<Dim>::Shear;

	explicit PackedWorkspace(bool portable);
	PackedWorkspace(const PackedWorkspace&)            = delete;
	PackedWorkspace& operator=(const PackedWorkspace&) = delete;

	/// lists: those that were stored with exactly this state, or nullptr to build them.
	void load(const PackedState<Dim>& state, const PackedLists<Dim>* lists = nullptr);
	void store(PackedState<Dim>& state, PackedLists<Dim>* lists = nullptr) const;

	/// Velocity gradient that comes into force in the integrator of the next step [1/s].
	void setNextVelGrad(const Matrix& velGrad);
	/// Steps; the stress is that of the last step, or the mean over the last `averaged` steps if that is more than one.
	/// Throws PackedBlowUp when lists are due and the sample is not healthy.
	void run(long steps, long averaged = 1);

	double timeStep() const { return view.dt; }
	/// Time step that the sample bears with the ice of now, whose stiffness is iceStiffness times that of the material [s]: as much longer
	/// than that of its state as contacts are softer than in full ice, and no longer than samples are prepared with.
	double longestTimeStep(double iceStiffness) const;
	/// Until a state is loaded.
	void   setTimeStep(double seconds) { view.dt = seconds; }
	Matrix velGrad() const { return parameters().velGrad; }

	static constexpr long leastStepsOfIce = 0; ///< that a change of ice saturation takes
	static constexpr bool hasIce() { return true; }
	double                iceSaturation() const { return base.iceSaturation; }
	/// At once and at fixed geometry: bonds, strengths, stiffness, radii. Limits are checked in the next step.
	void setIceSaturation(double iceSaturation);
	/// Of intact ice bonds, from now on and for every state that is loaded.
	void setStrengthFactors(const BondStrengthFactors& factors);
	/// Of the ice over that of the material [-]; forces stay. A state is loaded with 1 and to be stored with 1.
	void setIceStiffness(double factor);
	/// Of the ice bonds, at the overlaps of now.
	void creep(const BondCreep& creep);
	/// Bonds every frictional pair with gap <= ice.bondRange R_min, stress-free, whatever the history of ice saturation. Returns their number.
	std::size_t bondAll();
	/// Flips the cell to its shortest equivalent vectors if a skew exceeds `skew`; physics unchanged. True if it flipped.
	bool flip(double skew = 0.5);

	/// Throws PackedBlowUp when a number is not finite or grains overlap by more than a radius. Lists are checked before they are built;
	/// whoever runs steps checks once more when it is done.
	void checkHealth() const;

	/// Of the last steps that were run, tension positive, not symmetrised [Pa].
	const Matrix&         lastStress() const { return base.stress; }
	PackedStatistics<Dim> statistics() const;
	PackedTangent<Dim>    tangent() const;
	Matrix                hSize() const;
	/// Distance of a grain's next image over the mean diameter [-].
	double cellThickness() const;
	/// What its steps run on: the vectors in use as Highway names them, such as "AVX2", "AVX3" or "AVX3_DL" (AVX-512) or "NEON", or "portable".
	const char* path() const { return kernel.name; }
	bool        portableOnly() const { return portable; }
	/// State without arrays of grains and contacts: parameters, cell, step count.
	const PackedParameters<Dim>& parameters() const;
	double                       meanRadius() const { return averageRadius; }
	/// Upper bound of the moduli of the sample as it stands, from its grains and its contacts [Pa].
	double      largestModulus() const;
	std::size_t size() const { return grainCount; }

private:
	template <int> friend class SampleImage; ///< the same on a device, see pkg/rve/device
	struct alignas(packedAlignment) Numbers {
		double value[packedWidth];
	};
	using Rows = std::vector<Numbers>;
	struct Lanes {
		std::size_t                          pairs = 0;
		std::vector<std::uint64_t>           keys; ///< of the pairs, or empty: then they are formed when lists are built the next time
		std::vector<PackedBlock<Dim>>        block;
		std::vector<PackedIceBlock<Dim>>     ice;
		std::vector<std::uint32_t>           shift;
		std::vector<IceBond>                 bond;
		std::vector<PackedRollingBlock<Dim>> rolling;
		std::vector<PackedMomentBlock<Dim>>  moments;
		void                                 resize(std::size_t number, bool periodic, PackedContactKind kind);
	};
	struct Geometry {
		PackedPairRows<Dim> rows;
		double              n[Dim], distance, sumRadius, overlap;
	};

	void loadGrains(const PackedState<Dim>& state);
	void loadContacts(const PackedState<Dim>& state);
	void loadListed(const PackedContacts<Dim>& contacts, const PackedLists<Dim>& lists);
	/// Forces and moments that pairs remember, of each kind: visit(whether contacts have it, its blocks in Lanes, its rows there, its array in contacts).
	template <class Visitor> void forMemory(Visitor visit) const
	{
		visit(true, &Lanes::block, &PackedBlock<Dim>::shear, &PackedContacts<Dim>::shear);
		visit(resistsRolling, &Lanes::rolling, &PackedRollingBlock<Dim>::moment, &PackedContacts<Dim>::moment);
		visit(carriesBonds, &Lanes::ice, &PackedIceBlock<Dim>::iceShear, &PackedContacts<Dim>::iceShear);
		visit(carriesBonds && bondsCarryMoments, &Lanes::moments, &PackedMomentBlock<Dim>::moment, &PackedContacts<Dim>::bondMoment);
	}
	void takeHistory(Lanes& lanes, std::size_t lane, const Lanes& from, std::size_t at) const;
	void forgetHistory(Lanes& lanes, std::size_t lane) const;
	void takeContact(Lanes& lanes, std::size_t lane, const PackedContacts<Dim>& contacts, std::size_t k) const;
	void storeContacts(PackedContacts<Dim>& contacts, PackedLists<Dim>* lists) const;
	void storeLists(PackedLists<Dim>& lists, const std::vector<std::uint32_t> (&kept)[2]) const;
	bool carriesHistory(const Lanes& lanes, std::size_t lane) const;
	/// Of the same sample at another time: without its arrays.
	void scaleRadii();
	void spinRim(std::size_t grain);
	void bind();

	void     refreshLists();
	void     rebuildLists(double leastSkin = 0);
	void     chooseSkins(double leastSkin);
	void     findPairs();
	void     adoptSlack();
	double   fluctuation(std::size_t grain) const;
	void     adoptKeys();
	void     lanesChanged();
	void     formKeys(bool periodic);
	void     keepDistantBonds(const Lanes& old, const std::vector<std::uint64_t>& keys, std::vector<std::uint64_t>& kept) const;
	void     fillLanes(Lanes& lanes, const Lanes& old, bool periodic);
	void     setPair(Lanes& lanes, std::size_t lane, const PairKey<Dim>& pair, bool periodic);
	void     fillUp(Lanes& lanes);
	void     setResponse(Lanes& lanes, std::size_t lane);
	void     setResponses(Lanes& lanes);
	void     setRolling(Lanes& lanes, std::size_t lane, double shearStiffness);
	void     setMoments(Lanes& lanes, std::size_t lane, const ContactStiffness& k);
	void     updateShiftRows();
	unsigned shiftIndex(const std::array<std::int8_t, Dim>& cellDist);
	void     predictedCell(double* hSize) const;
	double   measuredTravel() const;
	bool     listsExhausted() const;
	void     accumulateTravel();

	void step();
	void moveCell();
	void finishStress(Matrix& stress) const;

	void settleBond(PackedBondEvent<Dim>& event);

	void                 changeIceOfBonds(double newRatio, bool melted);
	void                 keepMoments(Lanes& lanes, double share);
	bool                 formBond(Lanes& lanes, std::size_t lane);
	bool                 anyBond() const;
	void                 setStrengths();
	void                 selectKernel();
	void                 carryBonds(bool carry);
	PackedContactKind    contactKind() const { return { carriesBonds, resistsRolling, carriesBonds && bondsCarryMoments, grains && grains->hertz.acts() }; }
	static std::uint32_t rowOf(std::uint32_t offset) { return offset / PackedLayout<Dim>::row; }
	Lanes&               lanesOf(bool periodic) { return periodic ? periodicLanes : innerLanes; }

	Geometry         geometry(const Lanes& lanes, std::size_t lane) const;
	void             blockGeometry(const PackedPairs<Dim>& pairs, std::size_t block, Geometry (&result)[packedWidth], double (&square)[packedWidth]) const;
	ContactStiffness stiffness(const Lanes& lanes, std::size_t lane, double ratio) const;
	BondStrength     strength(const Lanes& lanes, std::size_t lane) const;
	template <class Visitor> void forContacts(Visitor&& visit) const;

	mutable PackedParameters<Dim>       base; ///< its cell matrices are brought up to date from the view on request
	std::shared_ptr<const PackedGrains> grains;
	std::size_t                         grainCount = 0, rowCount = 0;
	double                              largestRadius = 0, smallestRadius = 0, averageRadius = 0;

	Rows                       place, speed, force, turning, rim, angle, minusInverseMass, inverseInertia, radius, inverseSlackSquare, reference;
	Rows                       shiftPlace, shiftSpeed, shiftForce;
	std::vector<std::int8_t>   shiftCell;
	std::vector<std::uint32_t> shiftOrder; ///< rows of shifts in the order of their cells
	Lanes                      innerLanes, periodicLanes, oldInner, oldPeriodic;
	bool                       carriesBonds = false, resistsRolling = false, bondsCarryMoments = false, portable;
	double                     iceRatio = 0, tensileStrength = 0, shearStrength = 0; ///< k_ice/k_g [-] and strengths of bonds [Pa] at present

	NeighbourSearch<Dim>       search;
	std::vector<std::uint8_t>  slack;
	std::vector<double>        reach; ///< radii with the skins
	std::vector<std::uint64_t> sortBuffer;
	std::vector<std::uint32_t> sortCounts;
	bool                       listsValid = false, referenceKnown = false;
	PackedListUse<Dim>         use;

	BondStrengthFactors strengthFactors;
	double              iceStiffness = 1; ///< stiffness of ice over that of the material [-]
	PackedKernel<Dim>   kernel;
	PackedStepView<Dim> view;
};

} // namespace talik

// What the files that implement PackedWorkspace share.

namespace talik {

template <int Dim> inline void copyMatrix(const Eigen::Matrix<double, Dim, Dim>& from, double* to)
{
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j)
			to[i * Dim + j] = from(i, j);
}

template <int Dim> inline void copyMatrix(const double* from, Eigen::Matrix<double, Dim, Dim>& to)
{
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j)
			to(i, j) = from[i * Dim + j];
}

template <int Dim> inline void multiply(const double* a, const double* b, double* c)
{
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j) {
			double sum = 0;
			for (int k = 0; k < Dim; ++k)
				sum += a[i * Dim + k] * b[k * Dim + j];
			c[i * Dim + j] = sum;
		}
}

template <int Dim> inline double frobenius(const double* a)
{
	double square = 0;
	for (int k = 0; k < Dim * Dim; ++k)
		square += a[k] * a[k];
	return std::sqrt(square);
}

/// Radii of the grains at present [m].
struct PackedRadii {
	const double* now;
	double        largest, smallest;
};

/// Of all grains at present.
struct PackedRadiiInAll {
	double largest, smallest, mean; ///< [m]
};
PackedRadiiInAll radiiInAll(const PackedGrains& grains, double radiusFactor);

/// Thaw strain after a change of ice saturation; true if the factor of the radii has become smaller.
template <int Dim> bool grainsShrink(PackedThawStrain& thaw, double& radiusFactor, double iceBefore, double iceNow);

/// Gap that lists must reach across where bonds form [m].
inline double bondingReach(const IceBondModel& ice, double largestRadius) { return 1.01 * ice.bondRange * largestRadius; }

/// See PackedWorkspace::longestTimeStep.
template <int Dim> double longestTimeStep(const PackedParameters<Dim>& parameters, const PackedGrains& grains, const PackedRadii& radii, double iceStiffness);

/// (13.4) from its sums over the contacts: of f n_j n_l and of f n_i n_j n_k n_l with f = d^2 k_n/V, each product once, j <= l, row by row.
template <int Dim> PackedTangent<Dim> tangentFromSums(const double* second, const double* fourth, double stiffnessRatio);

/// Largest rate of shortening of any length, bounded from above.
template <int Dim> inline double strainRate(const double* a)
{
	double square = 0;
	for (int i = 0; i < Dim; ++i)
		for (int j = 0; j < Dim; ++j) {
			const double s = 0.5 * (a[i * Dim + j] + a[j * Dim + i]);
			square += s * s;
		}
	return std::sqrt(square);
}

} // namespace talik
