// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <pkg/base/Dimensions.hpp>
#include <pkg/rve/packed/CellInverse.hpp>
#include <pkg/rve/packed/PackedNeighbours.hpp>
#include <stdexcept>
#include <string>

namespace talik {

namespace {

	std::int8_t cellDistance(int c)
	{
		if (c < -127 || c > 127)
			throw std::runtime_error(
			        "packed sample: cell distance " + std::to_string(c) + " of a pair is outside -127..127; flip the cell or wrap the grains");
		return std::int8_t(c);
	}

	/// Shift of the cell vectors times the integers.
	template <int Dim> std::array<double, Dim> shiftOf(const double* hSize, const std::array<int, Dim>& cells)
	{
		std::array<double, Dim> shift {};
		for (int d = 0; d < Dim; ++d)
			for (int e = 0; e < Dim; ++e)
				shift[d] += hSize[d * Dim + e] * cells[e];
		return shift;
	}

} // namespace

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

template <int Dim> void NeighbourSearch<Dim>::wrap(const double* positions, std::size_t stride, const double* radii, std::size_t grains, const double* hSize)
{
	invert(hSize, inverse);
	wrapped.resize(grains);
	reduced.resize(grains);
	for (std::size_t g = 0; g < grains; ++g) {
		const double* x = positions + g * stride;
		Wrapped&      w = wrapped[g];
		w.radius        = radii[g];
		w.grain         = std::uint32_t(g);
		for (int d = 0; d < Dim; ++d) {
			double xi = 0;
			for (int e = 0; e < Dim; ++e)
				xi += inverse[d * Dim + e] * x[e];
			if (!(std::fabs(xi) < 1e6))
				throw std::runtime_error("packed sample: grain " + std::to_string(g) + " has flown out of reach of its cell");
			const int cell = int(xi) - (xi < 0);
			w.image[d]     = cell;
			reduced[g][d]  = xi - cell;
		}
		const std::array<double, Dim> shift = shiftOf<Dim>(hSize, w.image);
		for (int d = 0; d < Dim; ++d)
			w.x[d] = x[d] - shift[d];
	}
}

template <int Dim> typename NeighbourSearch<Dim>::Grid NeighbourSearch<Dim>::chooseGrid(double reach) const
{
	constexpr double roundOff = 1e-9; // of reduced coordinates
	Grid             grid;
	for (int d = 0; d < Dim; ++d) {
		double square = 0;
		for (int e = 0; e < Dim; ++e)
			square += inverse[d * Dim + e] * inverse[d * Dim + e];
		const double part = std::sqrt(square) * reach; // over the distance of opposite sides
		grid.bins[d]      = std::max(1, std::min(256, int(1 / part)));
		grid.range[d]     = std::max(1, int(std::ceil(part * grid.bins[d] + roundOff)));
	}
	return grid;
}

/// Grains in the order of their bins.
template <int Dim> void NeighbourSearch<Dim>::fillBins(const Grid& grid)
{
	const std::size_t grains = wrapped.size();
	std::size_t       bins   = 1;
	for (int d = 0; d < Dim; ++d)
		bins *= std::size_t(grid.bins[d]);
	binStart.assign(bins + 2, 0);
	binOf.resize(grains);
	binned.resize(grains);
	for (std::size_t g = 0; g < grains; ++g) {
		int bin = 0;
		for (int d = Dim - 1; d >= 0; --d)
			bin = bin * grid.bins[d] + std::max(0, std::min(grid.bins[d] - 1, int(reduced[g][d] * grid.bins[d])));
		binOf[g] = std::uint32_t(bin);
		++binStart[std::size_t(bin) + 2];
	}
	for (std::size_t b = 2; b < binStart.size(); ++b)
		binStart[b] += binStart[b - 1];
	// entry bin + 1 runs from the start of its bin to its end, where the next bin starts
	for (std::size_t g = 0; g < grains; ++g)
		binned[binStart[binOf[g] + 1]++] = wrapped[g];
}

template <int Dim> void NeighbourSearch<Dim>::keepPair(const Wrapped& a, const Wrapped& b, const std::array<int, Dim>& cells)
{
	PairKey<Dim> pair { a.grain, b.grain, {} };
	const int    sign = a.grain < b.grain ? 1 : -1;
	if (sign < 0) std::swap(pair.first, pair.second);
	for (int d = 0; d < Dim; ++d)
		pair.cellDist[d] = cellDistance(sign * (cells[d] + a.image[d] - b.image[d]));
	(pair.crossesCell() ? periodic : inner)->push_back(pair.encode());
}

template <int Dim>
inline void NeighbourSearch<Dim>::testPair(const Wrapped& a, const Wrapped& b, const std::array<int, Dim>& cells, const std::array<double, Dim>& shift)
{
	double square = 0;
	for (int d = 0; d < Dim; ++d) {
		const double branch = b.x[d] + shift[d] - a.x[d];
		square += branch * branch;
	}
	const double limit = a.radius + b.radius;
	if (square <= limit * limit) keepPair(a, b, cells);
}

/// Each bin with half of those around it, itself first: the others come from there. In a cell of few bins some are met in several images.
template <int Dim> void NeighbourSearch<Dim>::searchBins(const Grid& grid, const double* hSize)
{
	int directions = 1;
	for (const int range : grid.range)
		directions *= 2 * range + 1;
	std::array<int, Dim> at {};
	const std::size_t    bins = binStart.size() - 2;
	for (std::size_t bin = 0; bin < bins; ++bin) {
		const Wrapped *begin = binned.data() + binStart[bin], *end = binned.data() + binStart[bin + 1];
		for (int code = directions / 2; begin != end && code < directions; ++code) {
			std::array<int, Dim>    cells {};
			std::array<double, Dim> shift {};
			int                     place[Dim], other = 0;
			bool                    crosses = false;
			for (int d = 0, rest = code; d < Dim; ++d) {
				const int width = 2 * grid.range[d] + 1;
				place[d]        = at[d] + rest % width - grid.range[d];
				rest /= width;
				for (; place[d] < 0; place[d] += grid.bins[d])
					--cells[d];
				for (; place[d] >= grid.bins[d]; place[d] -= grid.bins[d])
					++cells[d];
				crosses |= cells[d] != 0;
			}
			for (int d = Dim - 1; d >= 0; --d)
				other = other * grid.bins[d] + place[d];
			if (crosses) shift = shiftOf<Dim>(hSize, cells);
			const Wrapped *from = binned.data() + binStart[other], *to = binned.data() + binStart[other + 1];
			for (const Wrapped* p = begin; p != end; ++p)
				for (const Wrapped* q = code == directions / 2 ? p + 1 : from; q != to; ++q)
					if (p != q) testPair(*p, *q, cells, shift); // no grain meets an image of itself
		}
		for (int d = 0; d < Dim; ++d) {
			if (++at[d] < grid.bins[d]) break;
			at[d] = 0;
		}
	}
}

template <int Dim>
void NeighbourSearch<Dim>::build(
        const double* positions, std::size_t stride, const double* radii, std::size_t grains, const double* hSize, std::vector<std::uint64_t>& innerKeys,
        std::vector<std::uint64_t>& periodicKeys)
{
	inner    = &innerKeys;
	periodic = &periodicKeys;
	inner->clear();
	periodic->clear();
	wrap(positions, stride, radii, grains, hSize);
	const Grid grid = chooseGrid(2 * *std::max_element(radii, radii + grains));
	fillBins(grid);
	searchBins(grid, hSize);
}

TALIK_IN_PLANE_AND_SPACE(NeighbourSearch);

} // namespace talik
