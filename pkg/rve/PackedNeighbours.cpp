// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <pkg/rve/PackedNeighbours.hpp>
#include <stdexcept>
#include <string>

namespace talik {

namespace {

	// An odd factor makes the product a bijection of 64-bit integers; the second is the inverse of the first modulo 2^64.
	constexpr std::uint64_t scramble = 0x9E3779B97F4A7C15ull;
	constexpr std::uint64_t inverseOf(std::uint64_t a)
	{
		std::uint64_t x = a;
		for (int k = 0; k < 6; ++k)
			x *= 2 - a * x;
		return x;
	}
	constexpr std::uint64_t unscramble = inverseOf(scramble);
	static_assert(scramble * unscramble == 1ull, "modular inverse");

	std::array<double, 4> invert(const double* h, std::integral_constant<int, 2>)
	{
		const double det = h[0] * h[3] - h[1] * h[2];
		return { h[3] / det, -h[1] / det, -h[2] / det, h[0] / det };
	}
	std::array<double, 9> invert(const double* h, std::integral_constant<int, 3>)
	{
		std::array<double, 9> inverse;
		double                det = 0;
		for (int k = 0; k < 3; ++k) {
			const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
			det += h[k] * (h[3 + k1] * h[6 + k2] - h[3 + k2] * h[6 + k1]);
			for (int l = 0; l < 3; ++l) {
				const int l1 = (l + 1) % 3, l2 = (l + 2) % 3;
				inverse[l * 3 + k] = h[k1 * 3 + l1] * h[k2 * 3 + l2] - h[k1 * 3 + l2] * h[k2 * 3 + l1];
			}
		}
		for (double& value : inverse)
			value /= det;
		return inverse;
	}

	std::int8_t cellDistance(int c)
	{
		if (c < -127 || c > 127)
			throw std::runtime_error("packed sample: cell distance " + std::to_string(c) + " of a pair is outside -127..127; flip the cell or wrap the grains");
		return static_cast<std::int8_t>(c);
	}

} // namespace

template <int Dim> std::uint64_t PairKey<Dim>::encode() const
{
	std::uint64_t code = (std::uint64_t(first) << 48) | (std::uint64_t(second) << 32);
	for (int d = 0; d < Dim; ++d)
		code |= std::uint64_t(std::uint8_t(cellDist[d])) << (24 - 8 * d);
	return code * scramble;
}

template <int Dim> PairKey<Dim> PairKey<Dim>::decode(std::uint64_t key)
{
	const std::uint64_t code = key * unscramble;
	PairKey             pair;
	pair.first  = std::uint32_t(code >> 48);
	pair.second = std::uint32_t(code >> 32) & 0xffffu;
	for (int d = 0; d < Dim; ++d)
		pair.cellDist[d] = static_cast<std::int8_t>(std::uint8_t(code >> (24 - 8 * d)));
	return pair;
}

template <int Dim> bool PairKey<Dim>::crossesCell() const
{
	return std::any_of(cellDist.begin(), cellDist.end(), [](std::int8_t c) { return c != 0; });
}

// Keys are as good as random in their leading bits: one pass into buckets leaves them almost sorted.
void sortPairKeys(std::vector<std::uint64_t>& keys, std::vector<std::uint64_t>& buffer, std::vector<std::uint32_t>& counts)
{
	int bits = 4;
	while ((std::size_t(1) << bits) < keys.size())
		++bits;
	const int shift = 64 - bits;
	counts.assign((std::size_t(1) << bits) + 1, 0);
	buffer.resize(keys.size());
	for (const std::uint64_t key : keys)
		++counts[(key >> shift) + 1];
	for (std::size_t k = 1; k < counts.size(); ++k)
		counts[k] += counts[k - 1];
	for (const std::uint64_t key : keys)
		buffer[counts[key >> shift]++] = key;
	for (std::size_t k = 1; k < buffer.size(); ++k) {
		const std::uint64_t key = buffer[k];
		std::size_t         l   = k;
		for (; l > 0 && buffer[l - 1] > key; --l)
			buffer[l] = buffer[l - 1];
		buffer[l] = key;
	}
	keys.swap(buffer);
}

template <int Dim> void NeighbourSearch<Dim>::wrap(const double* positions, std::size_t stride, std::size_t grains, const double* hSize)
{
	inverse = invert(hSize, std::integral_constant<int, Dim>());
	wrapped.resize(grains);
	reduced.resize(grains);
	image.resize(grains);
	for (std::size_t g = 0; g < grains; ++g) {
		const double* x = positions + g * stride;
		for (int d = 0; d < Dim; ++d) {
			double xi = 0;
			for (int e = 0; e < Dim; ++e)
				xi += inverse[d * Dim + e] * x[e];
			if (!(std::fabs(xi) < 1e6)) throw std::runtime_error("packed sample: grain " + std::to_string(g) + " has flown out of reach of its cell");
			const double cell = std::floor(xi);
			image[g][d]       = int(cell);
			reduced[g][d]     = xi - cell;
		}
		for (int d = 0; d < Dim; ++d) {
			double shift = 0;
			for (int e = 0; e < Dim; ++e)
				shift += hSize[d * Dim + e] * image[g][e];
			wrapped[g][d] = x[d] - shift;
		}
	}
}

template <int Dim> typename NeighbourSearch<Dim>::Grid NeighbourSearch<Dim>::chooseGrid(const double*, double reach) const
{
	Grid grid { {}, true };
	for (int d = 0; d < Dim; ++d) {
		double square = 0;
		for (int e = 0; e < Dim; ++e)
			square += inverse[d * Dim + e] * inverse[d * Dim + e];
		grid.bins[d] = std::min(256, int(1 / (std::sqrt(square) * reach)));
		if (grid.bins[d] < 3) grid.usable = false;
	}
	return grid;
}

template <int Dim> void NeighbourSearch<Dim>::fillBins(const Grid& grid, std::size_t grains)
{
	std::size_t bins = 1;
	for (int d = 0; d < Dim; ++d)
		bins *= std::size_t(grid.bins[d]);
	binStart.assign(bins + 1, 0);
	binOf.resize(grains);
	binGrains.resize(grains);
	for (std::size_t g = 0; g < grains; ++g) {
		int bin = 0;
		for (int d = Dim - 1; d >= 0; --d)
			bin = bin * grid.bins[d] + std::min(grid.bins[d] - 1, int(reduced[g][d] * grid.bins[d]));
		binOf[g] = std::uint32_t(bin);
		++binStart[bin + 1];
	}
	for (std::size_t b = 1; b <= bins; ++b)
		binStart[b] += binStart[b - 1];
	for (std::size_t g = grains; g-- > 0;)
		binGrains[--binStart[binOf[g] + 1]] = std::uint32_t(g);
	// the loop above moved every start one entry down
	for (std::size_t b = 0; b < bins; ++b)
		binStart[b] = binStart[b + 1];
	binStart[bins] = std::uint32_t(grains);
}

template <int Dim>
void NeighbourSearch<Dim>::testPair(
        std::uint32_t a, std::uint32_t b, const std::array<int, Dim>& cells, const std::array<double, Dim>& shift, const double* radii, double skin)
{
	double square = 0;
	for (int d = 0; d < Dim; ++d) {
		const double branch = wrapped[b][d] + shift[d] - wrapped[a][d];
		square += branch * branch;
	}
	const double limit = radii[a] + radii[b] + skin;
	if (square > limit * limit) return;
	PairKey<Dim> pair { a, b, {} };
	const int    sign = a < b ? 1 : -1;
	if (sign < 0) std::swap(pair.first, pair.second);
	bool crosses = false;
	for (int d = 0; d < Dim; ++d) {
		const int c       = sign * (cells[d] + image[a][d] - image[b][d]);
		pair.cellDist[d] = cellDistance(c);
		crosses |= c != 0;
	}
	(crosses ? periodic : inner)->push_back(pair.encode());
}

template <int Dim> void NeighbourSearch<Dim>::searchBins(const Grid& grid, const double* radii, const double* hSize, double skin)
{
	// half of the neighbouring bins, the bin itself first
	std::vector<std::array<int, Dim>> stencil;
	for (int code = (Dim == 2 ? 9 : 27) / 2; code < (Dim == 2 ? 9 : 27); ++code) {
		std::array<int, Dim> offset;
		for (int d = 0, rest = code; d < Dim; ++d, rest /= 3)
			offset[d] = rest % 3 - 1;
		stencil.push_back(offset);
	}
	std::array<int, Dim> at {};
	for (std::size_t bin = 0; bin + 1 < binStart.size(); ++bin) {
		for (std::size_t s = 0; s < stencil.size(); ++s) {
			std::array<int, Dim>    cells {};
			std::array<double, Dim> shift {};
			int                     other = 0;
			for (int d = Dim - 1; d >= 0; --d) {
				int k = at[d] + stencil[s][d];
				if (k < 0) { cells[d] = -1; k += grid.bins[d]; }
				if (k >= grid.bins[d]) { cells[d] = 1; k -= grid.bins[d]; }
				other = other * grid.bins[d] + k;
			}
			for (int d = 0; d < Dim; ++d)
				for (int e = 0; e < Dim; ++e)
					shift[d] += hSize[d * Dim + e] * cells[e];
			for (std::uint32_t p = binStart[bin]; p < binStart[bin + 1]; ++p)
				for (std::uint32_t q = s == 0 ? p + 1 : binStart[other]; q < binStart[other + 1]; ++q)
					testPair(binGrains[p], binGrains[q], cells, shift, radii, skin);
		}
		for (int d = 0; d < Dim; ++d) {
			if (++at[d] < grid.bins[d]) break;
			at[d] = 0;
		}
	}
}

// For cells of a few grains: every pair in every image that can reach.
template <int Dim> void NeighbourSearch<Dim>::searchAll(const double* radii, std::size_t grains, const double* hSize, double skin, double reach)
{
	std::array<int, Dim> range, cells;
	for (int d = 0; d < Dim; ++d) {
		double square = 0;
		for (int e = 0; e < Dim; ++e)
			square += inverse[d * Dim + e] * inverse[d * Dim + e];
		range[d] = 1 + int(std::sqrt(square) * reach);
		cells[d] = -range[d];
	}
	for (;;) {
		std::array<double, Dim> shift {};
		for (int d = 0; d < Dim; ++d)
			for (int e = 0; e < Dim; ++e)
				shift[d] += hSize[d * Dim + e] * cells[e];
		for (std::uint32_t a = 0; a < grains; ++a)
			for (std::uint32_t b = a + 1; b < grains; ++b)
				testPair(a, b, cells, shift, radii, skin);
		int d = 0;
		for (; d < Dim; ++d) {
			if (++cells[d] <= range[d]) break;
			cells[d] = -range[d];
		}
		if (d == Dim) return;
	}
}

template <int Dim>
void NeighbourSearch<Dim>::build(
        const double* positions, std::size_t stride, const double* radii, std::size_t grains, const double* hSize, double skin,
        std::vector<std::uint64_t>& innerKeys, std::vector<std::uint64_t>& periodicKeys)
{
	inner    = &innerKeys;
	periodic = &periodicKeys;
	inner->clear();
	periodic->clear();
	wrap(positions, stride, grains, hSize);
	double largest = 0;
	for (std::size_t g = 0; g < grains; ++g)
		largest = std::max(largest, radii[g]);
	const double reach = 2 * largest + skin;
	const Grid   grid  = chooseGrid(hSize, reach);
	if (grid.usable) {
		fillBins(grid, grains);
		searchBins(grid, radii, hSize, skin);
	} else {
		searchAll(radii, grains, hSize, skin, reach);
	}
}

template struct PairKey<2>;
template struct PairKey<3>;
template class NeighbourSearch<2>;
template class NeighbourSearch<3>;

} // namespace talik
