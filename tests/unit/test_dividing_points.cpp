// SPDX-License-Identifier: GPL-2.0-or-later
// Points that divide in a run: what both halves have, and runs that go on from a state in which points had divided.
#include "slopeScenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

using namespace talik;

namespace {

/// Largest of |b - a| over the size of what it is a part of; energies over their sum of sizes.
template <int D> double drift(const Balance<D>& a, const Balance<D>& b)
{
	const auto part = [](double before, double after, double size) { return std::abs(after - before) / size; };
	double     most = 0.0;
	for (const auto& [before, after] : { std::pair<double, double> { a.solidMass, b.solidMass },
	                                     { a.waterMass, b.waterMass },
	                                     { a.iceMass, b.iceMass },
	                                     { a.enthalpy, b.enthalpy },
	                                     { a.kineticEnergy, b.kineticEnergy },
	                                     { a.gravityEnergy, b.gravityEnergy } })
		most = std::max(most, part(before, after, std::abs(before)));
	for (int c = 0; c < D; ++c)
		most = std::max(most, part(a.momentum[c], b.momentum[c], std::abs(a.momentum[0])));
	return most;
}

template <int D> double volumeOf(const Ground<D>& ground)
{
	double sum = 0.0;
	for (int p = 0; p < ground.points().count(); ++p)
		sum += ground.points().volume()[p];
	return sum;
}

template <int D> void expectNothingLost(int steps)
{
	const auto ground = slope<D>(dividing, nullptr);
	const int  given  = ground->points().count();
	double     most   = 0.0;
	for (int k = 0; k < steps; ++k) {
		const int    count  = ground->points().count();
		const auto   before = ground->balance();
		const double volume = volumeOf(*ground);
		ground->beginStep(2e-4); // points divide here, and nothing else happens
		if (ground->points().count() > count) most = std::max({ most, drift(before, ground->balance()), std::abs(volumeOf(*ground) / volume - 1.0) });
		ground->p2g();
		ground->solveNodes();
		ground->g2p();
		ground->updateStrainAndPressure();
		ground->updateEffectiveStress();
	}
	std::printf(
	        "%d-D: %d points became %d; mass, water, ice, volume, momentum, heat, kinetic and potential energy change by %.2g where they divide (1e-13)\n",
	        D, given, ground->points().count(), most);
	EXPECT_GT(ground->points().count(), given + 20);
	EXPECT_LT(most, 1e-13);
	EXPECT_EQ(int(ground->divisions().size()), ground->points().count() - given);
}

} // namespace

TEST(DividingPoints, LoseNoMassWaterHeatMomentumOrEnergy)
{
	expectNothingLost<2>(260);
	expectNothingLost<3>(130);
}

TEST(DividingPoints, GoOnFromAStateInWhichSomeHaveDividedWithTheSameBits)
{
	const auto first = slope<2>(dividing, nullptr), second = slope<2>(dividing, nullptr);
	const auto march = [](Ground<2>& ground, int steps) {
		for (int k = 0; k < steps; ++k)
			ground.step(2e-4);
	};
	march(*first, 150);
	const std::size_t divided = first->divisions().size();
	const auto        kept    = copyOf(first->state());
	second->repeatDivisions(first->divisions());
	std::size_t k = 0;
	for (const StateArray& array : second->state()) {
		ASSERT_EQ(kept[k].size(), array.bytes) << array.name;
		std::copy(kept[k].begin(), kept[k].end(), static_cast<char*>(array.data)), ++k;
	}
	second->stateRestored();
	march(*first, 110);
	march(*second, 110);
	std::printf("%zu points had divided, and %zu at the end\n", divided, first->divisions().size());
	EXPECT_GT(divided, 5u);
	EXPECT_GT(first->divisions().size(), divided);
	EXPECT_EQ(first->divisions(), second->divisions());
	EXPECT_EQ(copyOf(first->state()), copyOf(second->state()));
}
