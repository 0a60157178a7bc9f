// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace talik {

/// A pair of grains and its cell distance in one integer whose order is the order of all sums: fixed for a pair, unrelated to when
/// lists were built, and such that neighbouring pairs hardly ever share a grain.
template <int Dim> struct PairKey {
	std::uint32_t                first, second; ///< first < second
	std::array<std::int8_t, Dim> cellDist;

	// An odd factor makes the product a bijection of 64-bit integers; the second is the inverse of the first modulo 2^64.
	static constexpr std::uint64_t scramble = 0x9E3779B97F4A7C15ull, unscramble = 0xF1DE83E19937733Dull;
	static_assert(scramble * unscramble == 1ull, "modular inverse");

	std::uint64_t encode() const
	{
		std::uint64_t code = (std::uint64_t(first) << 48) | (std::uint64_t(second) << 32);
		for (int d = 0; d < Dim; ++d)
			code |= std::uint64_t(std::uint8_t(cellDist[d])) << (24 - 8 * d);
		return code * scramble;
	}
	static PairKey decode(std::uint64_t key)
	{
		const std::uint64_t code = key * unscramble;
		PairKey             pair { std::uint32_t(code >> 48), std::uint32_t(code >> 32) & 0xffffu, {} };
		for (int d = 0; d < Dim; ++d)
			pair.cellDist[d] = std::int8_t(std::uint8_t(code >> (24 - 8 * d)));
		return pair;
	}
	bool crossesCell() const
	{
		int any = 0;
		for (int d = 0; d < Dim; ++d)
			any |= cellDist[d];
		return any != 0;
	}
};

/// How much of the skin of neighbour lists is used up.
template <int Dim> struct PackedListUse {
	double referenceCell[Dim * Dim]; ///< cell vectors in columns when the lists were built, row-major [m]
	double skin    = 0;              ///< of a grain whose slack is one [m]
	double travel  = 0;              ///< bound of any grain's deviation from the affine motion since then, over its slack [m]
	double stretch = 0;              ///< bound of any length's relative shortening since then [-]
};

/// Neighbour lists that outlive a stay in a workspace: pairs inside the cell, then pairs across it, each in the order of their keys.
/// The contacts of the state are among them in the same order: a pair that is no contact has its grains exchanged, first > second.
template <int Dim> struct PackedLists : PackedListUse<Dim> {
	std::vector<std::uint8_t>                 slack; ///< of each grain, exponent of two: 2^slack skins lie around it
	std::vector<std::uint16_t>                first, second;
	std::vector<std::array<std::int8_t, Dim>> cellDist;   ///< of the pairs across the cell: entry k - inside for pair k
	std::size_t                               inside = 0; ///< number of pairs that do not cross the cell

	static constexpr unsigned largestSlack = 15; ///< parked in four bits

	std::size_t size() const { return first.size(); }
	bool        contact(std::size_t k) const { return first[k] < second[k]; }
};

/// Periodic search for all pairs closer than r_1 + r_2. Keeps its buffers.
template <int Dim> class NeighbourSearch {
public:
	/// positions: `grains` rows of `stride` doubles, unwrapped; radii with the skins; hSize row-major with cell vectors in columns.
	/// Keys of pairs inside the cell (c = 0) and across it, each sorted. Throws std::runtime_error when a cell distance leaves -127..127.
	void build(
	        const double* positions, std::size_t stride, const double* radii, std::size_t grains, const double* hSize, std::vector<std::uint64_t>& inner,
	        std::vector<std::uint64_t>& periodic);

private:
	/// Bins along each cell vector, and how many of them a pair reaches across.
	struct Grid {
		std::array<int, Dim> bins, range;
	};
	/// A grain wrapped into the cell.
	struct Wrapped {
		std::array<double, Dim> x;
		double                  radius;
		std::array<int, Dim>    image;
		std::uint32_t           grain;
	};
	void wrap(const double* positions, std::size_t stride, const double* radii, std::size_t grains, const double* hSize);
	Grid chooseGrid(double reach) const;
	void fillBins(const Grid& grid);
	void searchBins(const Grid& grid, const double* hSize);
	void testPair(const Wrapped& a, const Wrapped& b, const std::array<int, Dim>& cells, const std::array<double, Dim>& shift);
	void keepPair(const Wrapped& a, const Wrapped& b, const std::array<int, Dim>& cells);

	double                               inverse[Dim * Dim] = {};
	std::vector<Wrapped>                 wrapped, binned;
	std::vector<std::array<double, Dim>> reduced;
	std::vector<std::uint32_t>           binStart, binOf;
	std::vector<std::uint64_t>*          inner    = nullptr;
	std::vector<std::uint64_t>*          periodic = nullptr;
};

/// Sorts keys; buffers are kept by the caller.
void sortPairKeys(std::vector<std::uint64_t>& keys, std::vector<std::uint64_t>& buffer, std::vector<std::uint32_t>& counts);

} // namespace talik
