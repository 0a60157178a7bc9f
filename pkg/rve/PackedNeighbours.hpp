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

	std::uint64_t  encode() const;
	static PairKey decode(std::uint64_t key);
	bool           crossesCell() const;
};

/// Periodic search for all pairs closer than r_1 + r_2 + skin. Keeps its buffers.
template <int Dim> class NeighbourSearch {
public:
	/// positions: `grains` rows of `stride` doubles, unwrapped; hSize row-major with cell vectors in columns.
	/// Keys of pairs inside the cell (c = 0) and across it, each sorted. Throws std::runtime_error when a cell distance leaves -127..127.
	void build(const double* positions, std::size_t stride, const double* radii, std::size_t grains, const double* hSize, double skin,
	           std::vector<std::uint64_t>& inner, std::vector<std::uint64_t>& periodic);

private:
	struct Grid {
		std::array<int, Dim> bins;
		bool                 usable;
	};
	void wrap(const double* positions, std::size_t stride, std::size_t grains, const double* hSize);
	Grid chooseGrid(const double* hSize, double reach) const;
	void fillBins(const Grid& grid, std::size_t grains);
	void searchBins(const Grid& grid, const double* radii, const double* hSize, double skin);
	void searchAll(const double* radii, std::size_t grains, const double* hSize, double skin, double reach);
	void testPair(std::uint32_t a, std::uint32_t b, const std::array<int, Dim>& image, const std::array<double, Dim>& shift, const double* radii, double skin);

	std::array<double, Dim * Dim>        inverse {};
	std::vector<std::array<double, Dim>> wrapped, reduced;
	std::vector<std::array<int, Dim>>    image;
	std::vector<std::uint32_t>           binStart, binGrains, binOf;
	std::vector<std::uint64_t>*          inner = nullptr;
	std::vector<std::uint64_t>*          periodic = nullptr;
};

/// Sorts keys; buffers are kept by the caller.
void sortPairKeys(std::vector<std::uint64_t>& keys, std::vector<std::uint64_t>& buffer, std::vector<std::uint32_t>& counts);

} // namespace talik
