// SPDX-License-Identifier: GPL-2.0-or-later
#include "packedReference.hpp"
#include <algorithm>
#include <cstdio>
#include <gtest/gtest.h>
#include <map>

using namespace talik;
using packedReference::Frame;
using packedReference::Matrix;
using packedReference::State;

namespace {

/// Largest differences from stock YADE, each over the largest value of its kind.
struct Difference {
	double stress = 0, position = 0, velocity = 0, spin = 0, shear = 0, normal = 0, cell = 0;
	double worst() const { return std::max({ stress, position, velocity, spin, shear, normal, cell }); }
};

void add(double& difference, double scale, double a, double b) { difference = std::max(difference, std::fabs(a - b) / scale); }

double normalForce(const State& s, const std::vector<State::Vector>& positions, std::size_t k)
{
	const PackedContacts<2>& c = s.contacts;
	const double             a = s.grains->radius[c.first[k]], b = s.grains->radius[c.second[k]];
	const State::Vector      shift(c.cellDist[k][0], c.cellDist[k][1]);
	const double             overlap = a + b - (positions[c.second[k]] + s.hSize * shift - positions[c.first[k]]).norm();
	return 2 * s.ice.young * a * b / (a + b) * overlap;
}

/// `before`: positions at the evaluation of the forces, one step earlier than those of `s`.
Difference compare(const State& s, const std::vector<State::Vector>& before, const Matrix& stress, const Frame& f)
{
	Difference d;
	double     largestVelocity = 0, largestSpin = 0, largestForce = 0;
	for (const auto& g : f.grains) {
		largestVelocity = std::max({ largestVelocity, std::fabs(g[2]), std::fabs(g[3]) });
		largestSpin     = std::max(largestSpin, std::fabs(g[4]));
	}
	for (const auto& c : f.contacts)
		largestForce = std::max(largestForce, c.normal);
	for (std::size_t g = 0; g < s.size(); ++g) {
		for (int k = 0; k < 2; ++k) {
			add(d.position, f.hSize(0, 0), s.position[g][k], f.grains[g][k]);
			add(d.velocity, largestVelocity, s.velocity[g][k], f.grains[g][2 + k]);
		}
		add(d.spin, largestSpin, s.angularVelocity[g], f.grains[g][4]);
	}
	for (int k = 0; k < 4; ++k) {
		add(d.stress, f.stress.norm(), stress(k / 2, k % 2), f.stress(k / 2, k % 2));
		add(d.cell, f.hSize.norm(), s.hSize(k / 2, k % 2), f.hSize(k / 2, k % 2));
		add(d.cell, 1, s.trsf(k / 2, k % 2), f.trsf(k / 2, k % 2));
	}
	std::map<std::pair<int, int>, std::size_t> index;
	for (std::size_t k = 0; k < s.contacts.size(); ++k)
		index[{ s.contacts.first[k], s.contacts.second[k] }] = k;
	for (const auto& c : f.contacts) {
		const auto found = index.find({ c.first, c.second });
		add(d.shear, largestForce, found == index.end() ? 0. : s.contacts.shear[found->second], c.shear);
		add(d.normal, largestForce, found == index.end() ? 0. : normalForce(s, before, found->second), c.normal);
	}
	return d;
}

void followStock(bool portable)
{
	PackedSample<2>::forcePortable(portable);
	const auto&     reference = packedReference::sample();
	PackedSample<2> sample(reference.state());
	PackedSample<2>::forcePortable(false);
	const long   checkpoints[] = { 1, 100, 500 };
	const double tolerance[]   = { 1e-11, 1e-9, 1e-8 };
	long         done          = 0;
	for (int k = 0; k < 3; ++k) {
		if (checkpoints[k] - 1 > done) sample.advance(reference.velGrad, checkpoints[k] - 1 - done);
		const auto before = sample.state().position;
		sample.advance(reference.velGrad, 1);
		done               = checkpoints[k];
		const State      s = sample.state();
		const Difference d = compare(s, before, s.stress, reference.frames[k + 1]);
		std::printf(
		        "%s, %ld steps against stock YADE: stress %.1e position %.1e velocity %.1e spin %.1e shear force %.1e normal force %.1e cell %.1e\n",
		        sample.path(), done, d.stress, d.position, d.velocity, d.spin, d.shear, d.normal, d.cell);
		EXPECT_LT(d.worst(), tolerance[k]);
	}
}

} // namespace

TEST(PackedSample, followsStockYadeOnThePortablePath) { followStock(true); }

TEST(PackedSample, followsStockYadeOnTheFastestPathOfThisProcessor) { followStock(false); }
