// SPDX-License-Identifier: GPL-2.0-or-later
#include "packedSpheres.hpp"
#include <algorithm>
#include <cstdio>
#include <gtest/gtest.h>
#include <pkg/rve/packed/PackedSample.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>
#include <pkg/rve/packed/PackedWorkspace.hpp>

using namespace talik;
using packedSpheres::Frame;
using packedSpheres::Matrix;
using packedSpheres::State;

namespace {
const packedSpheres::Reference& reference() { return packedSpheres::sample(); }
State                           initial() { return reference().state(); }
} // namespace

namespace {

void followStock(bool portable)
{
	PackedSample<3>::forcePortable(portable);
	PackedSample<3> sample(initial());
	PackedSample<3>::forcePortable(false);
	const long   checkpoints[] = { 1, 100, 500 };
	const double tolerance[]   = { 1e-12, 1e-10, 1e-9 };
	long         done          = 0;
	for (int k = 0; k < 3; ++k) {
		sample.advance(reference().velGrad, checkpoints[k] - done);
		done                  = checkpoints[k];
		const State  s        = sample.state();
		const Frame& f        = reference().frames[k + 1];
		double       position = 0, velocity = 0, spin = 0, largestVelocity = 0, largestSpin = 0;
		for (std::size_t g = 0; g < s.size(); ++g)
			for (int d = 0; d < 3; ++d) {
				position        = std::max(position, std::fabs(s.position[g][d] - f.grains[g][d]) / f.hSize(0, 0));
				velocity        = std::max(velocity, std::fabs(s.velocity[g][d] - f.grains[g][3 + d]));
				spin            = std::max(spin, std::fabs(s.angularVelocity[g][d] - f.grains[g][6 + d]));
				largestVelocity = std::max(largestVelocity, std::fabs(f.grains[g][3 + d]));
				largestSpin     = std::max(largestSpin, std::fabs(f.grains[g][6 + d]));
			}
		const double stress = (s.stress - f.stress).norm() / f.stress.norm();
		std::printf(
		        "%s, %ld steps against stock YADE: stress %.1e position %.1e velocity %.1e spin %.1e (%zu contacts)\n", sample.path(), done, stress,
		        position, velocity / largestVelocity, spin / largestSpin, s.contacts.size());
		EXPECT_LT(std::max({ stress, position, velocity / largestVelocity, spin / largestSpin }), tolerance[k]);
	}
}

State frozen(double iceSaturation)
{
	PackedSample<3> sample(initial());
	for (int k = 1; k <= 20; ++k) {
		sample.setIceSaturation(iceSaturation * k / 20);
		sample.advance(5);
	}
	return sample.state();
}

} // namespace

TEST(PackedSpheres, followStockYadeOnThePortablePath) { followStock(true); }
TEST(PackedSpheres, followStockYadeOnTheFastestPathOfThisProcessor) { followStock(false); }

TEST(PackedSpheres, vectorsAndPortablePathAgreeWhileBondsBreak)
{
	const State     start = frozen(0.1);
	PackedSample<3> fast(start);
	PackedSample<3>::forcePortable(true);
	PackedSample<3> portable(start);
	PackedSample<3>::forcePortable(false);
	const Matrix velGrad = 150 * reference().velGrad;
	fast.advance(velGrad, 300);
	portable.advance(velGrad, 300);
	const State  a = fast.state(), b = portable.state();
	const double difference = (fast.stress() - portable.stress()).norm() / portable.stress().norm();
	std::printf(
	        "%s against %s, 300 steps, %lu and %lu bonds broken: stress differs by %.1e\n", fast.path(), portable.path(),
	        (unsigned long)(a.bondsBrokenInTension + a.bondsBrokenInShear), (unsigned long)(b.bondsBrokenInTension + b.bondsBrokenInShear), difference);
	EXPECT_GT(a.bondsBrokenInTension + a.bondsBrokenInShear, 5u);
	EXPECT_EQ(a.bondsBrokenInTension, b.bondsBrokenInTension);
	EXPECT_EQ(a.bondsBrokenInShear, b.bondsBrokenInShear);
	EXPECT_LT(difference, 1e-9);
}

TEST(PackedSpheres, resultsDoNotDependOnSavesAndLoads)
{
	PackedSample<3> sample(initial());
	for (int k = 1; k <= 10; ++k) {
		sample.setIceSaturation(0.01 * k);
		sample.advance(3);
	}
	EXPECT_GT(sample.statistics().bondsIntact, 100u);
	const Matrix    velGrad = 150 * reference().velGrad;
	PackedSample<3> interrupted(sample.state());
	sample.advance(velGrad, 600);
	for (int k = 0; k < 20; ++k) {
		interrupted.advance(velGrad, 30);
		interrupted.setState(State::fromBytes(interrupted.state().toBytes()));
	}
	const State s = sample.state();
	std::printf("600 steps, %lu bonds broken in tension, %lu in shear\n", (unsigned long)s.bondsBrokenInTension, (unsigned long)s.bondsBrokenInShear);
	EXPECT_GT(s.bondsBrokenInTension + s.bondsBrokenInShear, 5u);
	EXPECT_TRUE(s.toBytes() == interrupted.state().toBytes());
}

/// Lists that last, with skins by the speed of each grain, against lists built anew in every step.
TEST(PackedSpheres, grainThatFliesAboutMeetsAllOthers)
{
	State state       = initial();
	state.velocity[7] = Eigen::Vector3d(6, 4, -5); // half a radius in 200 steps
	PackedWorkspace<3> lasting(false), anew(false);
	lasting.load(state);
	lasting.setNextVelGrad(reference().velGrad);
	std::size_t most = 0, least = state.contacts.size();
	for (int step = 0; step < 200; ++step) {
		anew.load(state);
		anew.setNextVelGrad(reference().velGrad);
		anew.run(1);
		anew.store(state);
		lasting.run(1);
		most  = std::max(most, state.contacts.size());
		least = std::min(least, state.contacts.size());
	}
	State carried;
	lasting.store(carried);
	EXPECT_TRUE(carried.toBytes() == state.toBytes());
	EXPECT_GT(most, least + 2);
}

// The slip that YADE's conventions give spheres in a turn by theta per step is of second order in theta, so that the error of a given
// turn falls with the number of steps; for discs it vanishes.
TEST(PackedSpheres, stressTurnsWithTheSampleTheBetterTheMoreSteps)
{
	Matrix turn;
	turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
	PackedSample<3> start(initial());
	start.advance(Matrix::Zero(), 2000);
	double error[2];
	for (int k = 0; k < 2; ++k) {
		PackedSample<3>     sample(start.state());
		PackedUpdateOptions options;
		options.steps    = k == 0 ? 4000 : 40000;
		options.flipSkew = 0;
		sample.apply(turn - Matrix::Identity(), 0, options);
		error[k] = (sample.stress() - turn * start.stress() * turn.transpose()).norm() / start.stress().norm();
		std::printf("90 degrees in %ld steps: R sigma R^T off by %.1e\n", options.steps, error[k]);
	}
	EXPECT_LT(error[1], 1e-2);
	EXPECT_GT(error[0] / error[1], 5);
}

TEST(PackedSpheres, flippedCellCarriesTheSameSample)
{
	PackedSample<3>     sample(initial());
	PackedUpdateOptions options;
	Matrix              shear = Matrix::Zero();
	shear(0, 2)               = 0.7;
	options.steps             = 5000;
	options.flipSkew          = 0;
	sample.apply(shear, 0, options);
	PackedSample<3> flipped(sample.state());
	ASSERT_TRUE(flipped.flip());
	sample.advance(1);
	flipped.advance(1);
	const double after = (flipped.stress() - sample.stress()).norm() / sample.stress().norm();
	std::printf("stress after the flip off by %.1e\n", after);
	EXPECT_LT(after, 1e-10);
}

TEST(PackedSpheres, aPoolGivesTheSameBitsForAnyNumberOfThreads)
{
	SamplePool<3>                 one, many;
	std::vector<PackedRequest<3>> requests;
	PackedUpdateOptions           options;
	options.steps = 20;
	for (std::size_t k = 0; k < 4; ++k) {
		one.add(initial());
		many.add(initial());
		requests.push_back({ k, reference().velGrad * 1e-4 * double(k + 1), 0.0 });
	}
	for (int round = 0; round < 3; ++round) {
		const auto a = one.update(requests, options, 1), b = many.update(requests, options, 2);
		for (std::size_t k = 0; k < requests.size(); ++k) {
			EXPECT_EQ(a[k].stress, b[k].stress);
			EXPECT_TRUE(one.state(k).toBytes() == many.state(k).toBytes());
		}
	}
}
