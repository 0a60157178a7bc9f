// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <pkg/icebond/IceBond.hpp>

/// What host and kernels of a card say to each other. Plain data, laid out alike by every compiler.
namespace talik {

/// Images of the cell that the pairs of a sample may reach; samples that need more stay on the processor.
constexpr int mostImages = 40;

/// Where a sample lies in its place on the card: numbers of grains and pairs row by row, then what is no double.
struct PlaceLayout {
	std::int32_t grains, pairs;                         ///< lengths of the rows
	std::int32_t dimension, bonded, hertz;              ///< hertz: grains of Hertz and Mindlin
	std::int32_t index, incidence, start, bond, images; ///< [bytes]
	std::int32_t bytes;

	/// Rows of grains: motion (discs x y v w angle, spheres x v w), then -1/m, 1/I with the sign that the kernels want, r, 1/slack^2,
	/// r_0.
	constexpr std::int32_t motionRows() const { return dimension == 2 ? 6 : 9; }
	constexpr std::int32_t grainRows() const { return motionRows() + 5; }
	constexpr std::int32_t shearRows() const { return dimension == 2 ? 1 : 3; }
	/// Rows of pairs: shear forces, sum of radii, stiffness (of Hertz's grains H), spheres (r_1 - r_2)/2; bonded: shear forces of the ice, offset,
	/// floor, cohesion, share of the ice, k_g, area, u_grain, u_ice.
	constexpr std::int32_t pairRows() const { return shearRows() + dimension + (bonded ? shearRows() + 8 : 0); }

	static constexpr PlaceLayout of(int dimension, int grains, int pairs, bool bonded, bool hertz)
	{
		PlaceLayout l {};
		l.grains    = grains;
		l.pairs     = pairs;
		l.dimension = dimension;
		l.bonded    = bonded;
		l.hertz     = hertz;
		l.index     = std::int32_t(sizeof(double)) * (l.grainRows() * grains + l.pairRows() * pairs);
		l.incidence = l.index + 4 * pairs;
		l.start     = l.incidence + 4 * pairs;
		l.bond      = l.start + 2 * (grains + 1);
		l.images    = l.bond + (bonded ? pairs : 0);
		l.bytes     = (l.images + mostImages * dimension + 255) / 256 * 256;
		return l;
	}
	bool operator==(const PlaceLayout& o) const
	{
		return dimension == o.dimension && bonded == o.bonded && hertz == o.hertz && grains == o.grains && pairs == o.pairs;
	}
};

/// Which grains a pair joins, and which image of the cell, in 32 bits.
struct PairCode {
	static constexpr int mostGrains = 1 << 12;
	/// image: number of the row in the table of images, or -1 inside the cell.
	static constexpr std::uint32_t of(std::uint32_t first, std::uint32_t second, int image)
	{
		return first | second << 12 | std::uint32_t(image + 1) << 24;
	}
	static constexpr std::uint32_t first(std::uint32_t code) { return code & 0xfff; }
	static constexpr std::uint32_t second(std::uint32_t code) { return code >> 12 & 0xfff; }
	static constexpr int           image(std::uint32_t code) { return int(code >> 24) - 1; }
};

/// A part of a change of ice: what holds from it on.
struct IcePart {
	double       iceRatio, tensileStrength, shearStrength;
	double       radiusFactor, largestRadius, smallestRadius, meanRadius;
	double       bondSkin;      ///< least skin of the lists that bonds form from
	std::int32_t melted, forms; ///< no ice is left; new bonds form
};

/// Parts that go with a call at most.
constexpr int mostIceParts = 8;

/// One sample and all its steps: `moving` with the velocity gradient, the first of which brings it into force, then `resting` ones. Of a change of ice
/// all steps are at rest, and each part comes before `stepsOfIce` of them.
struct SampleCall {
	std::uint64_t place;       ///< address
	std::uint64_t formerPlace; ///< whence it is to be brought first, or 0
	double        velGrad[9];
	double        hSize[9], trsf[9];
	double        norm, strainRate; ///< of the velocity gradient [1/s]
	double        dt, damping, friction, stiffnessRatio;
	double        iceRatio, tensileStrength, shearStrength, thickness;
	double        skin, travel, stretch, largestRadius, smallestRadius; ///< see PackedListUse
	double        meanRadius, young, bondAreaFactor, bondRange;         ///< for new lists and bonds
	HertzMindlin  elasticity;
	std::int32_t  grains, pairs, inside, images, moving, resting, thawed, tangent; ///< images >= 1: the first one moves the cell
	std::int32_t  iceParts, stepsOfIce;
	std::int32_t  carries;      ///< the processor would carry bonds, intact, broken or gone
	std::int32_t  bondsOutlast; ///< their ice
	std::int32_t  formerPairs;  ///< length of the rows of the former place, which is bonded where this one is not
	std::int32_t  unused;
};

/// What came of it.
struct SampleAnswer {
	double        forces[9]; ///< sum of G (x) x: stress times volume [N m]
	double        hSize[9], prevHSize[9], trsf[9];
	double        skin, travel, stretch;
	std::uint32_t steps; ///< done: fewer than asked for where new lists of neighbours are for the host
	std::uint32_t brokenInTension, brokenInShear;
	std::uint32_t lists;                 ///< built on the way
	std::int32_t  pairs, inside, images; ///< of the lists of now
	std::uint32_t bonds;                 ///< pairs that are or were bonded
	std::uint32_t unsound;               ///< numbers that are not finite, or overlaps of more than a radius
	std::uint32_t bondsFormed, bondsMelted;
	std::uint32_t carries;     ///< as in the call, afterwards
	std::uint32_t awaitsBonds; ///< bonds of the last part of the ice are for the host to form
};

/// Sums of (13.4) that make a tangent: of second order, then of fourth order.
constexpr int tangentSums(int dimension) { return dimension == 2 ? 3 + 6 : 6 + 21; }

/// A launch: `order` names the calls of its blocks. The sums of a tangent are written where a call asks for it.
struct KernelArguments {
	const SampleCall*    calls;
	const IcePart*       ice; ///< mostIceParts of each call; nullptr where no ice changes
	SampleAnswer*        answers;
	double*              tangents;
	const std::uint32_t* order;
	PlaceLayout          layout;
	std::int32_t         count;
};

/// A kernel as host and card name it: so many threads, each with so many grains and pairs.
struct KernelShape {
	const char*  name;
	std::int32_t dimension, threads, grainsEach, pairsEach, bonded, hertz;
	bool         holds(const PlaceLayout& l) const
	{
		return dimension == l.dimension && bonded == l.bonded && hertz == l.hertz && threads * grainsEach >= l.grains && threads * pairsEach >= l.pairs;
	}
};

} // namespace talik
