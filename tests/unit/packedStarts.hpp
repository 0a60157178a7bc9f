// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include "packedReference.hpp"
#include "packedSpheres.hpp"
#include <array>
#include <memory>

/// Samples of stock YADE as they are, larger, and frozen: what tests and benchmarks of packed samples begin with.
namespace packedStarts {

using namespace talik;

#ifdef TALIK_TEST_DATA
template <int Dim> PackedState<Dim> thawed()
{
	if constexpr (Dim == 2) return packedReference::sample().state();
	else return packedSpheres::sample().state();
}
#endif

/// So many times the sample in every direction, with its contacts new: larger kernels advance it.
template <int Dim> PackedState<Dim> tiled(const PackedState<Dim>& one, const std::array<int, 3>& times)
{
	PackedState<Dim> all(one);
	auto             grains = std::make_shared<PackedGrains>();
	for (int d = 0; d < Dim; ++d) {
		all.hSize.col(d) *= times[std::size_t(d)];
		all.prevHSize.col(d) *= times[std::size_t(d)];
	}
	all.contacts = {};
	all.position.clear();
	all.velocity.clear();
	all.angularVelocity.clear();
	all.orientation.clear();
	for (int k = 0; k < times[0] * times[1] * times[2]; ++k)
		for (std::size_t g = 0; g < one.size(); ++g) {
			typename PackedTypes<Dim>::Vector cells;
			cells[0] = k % times[0];
			cells[1] = k / times[0] % times[1];
			if (Dim == 3) cells[Dim - 1] = k / times[0] / times[1];
			all.position.push_back(one.position[g] + one.hSize * cells);
			all.velocity.push_back(PackedTypes<Dim>::Vector::Zero());
			all.angularVelocity.push_back(one.angularVelocity[g]);
			if (Dim == 2) all.orientation.push_back(one.orientation[g]);
			grains->radius.push_back(one.grains->radius[g] * (1 - 1e-4 * (k % 5)));
			grains->mass.push_back(one.grains->mass[g]);
			grains->inertia.push_back(one.grains->inertia[g]);
			grains->id.push_back(int(grains->id.size()));
		}
	all.grains = grains;
	PackedSample<Dim> settled(all);
	settled.advance(PackedTypes<Dim>::Matrix::Zero(), 300);
	return settled.state();
}

/// The same with grains of Hertz and Mindlin, which are about as stiff there as the linear springs.
constexpr double                    youngOfGrains = 2e10, poissonOfGrains = 0.2;
template <int Dim> PackedState<Dim> hertzian(PackedState<Dim> s)
{
	auto grains      = std::make_shared<PackedGrains>(*s.grains);
	grains->hertz    = HertzMindlin::of(youngOfGrains, poissonOfGrains, youngOfGrains, poissonOfGrains);
	s.ice.young      = youngOfGrains;
	s.stiffnessRatio = grains->hertz.shearRatio;
	s.grains         = grains;
	s.dt *= 0.5;
	return s;
}

/// With bonds that form and stiffen in so many parts.
template <int Dim> PackedState<Dim> frozenOf(const PackedState<Dim>& start, double iceSaturation, int parts = 1)
{
	PackedSample<Dim> sample(start);
	for (int k = 1; k <= parts; ++k) {
		sample.setIceSaturation(iceSaturation * k / parts);
		sample.advance(parts > 1 ? 5 : 20);
	}
	return sample.state();
}

} // namespace packedStarts
