// SPDX-License-Identifier: GPL-2.0-or-later
// One point of a ground in space with a sample of spheres behind it.
#include "packedSpheres.hpp"
#include <algorithm>
#include <cstdio>
#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <pkg/multiscale/samples/PackedStore.hpp>
#include <pkg/multiscale/samples/SampleSkeleton.hpp>

using namespace talik;
using packedSpheres::Matrix;

namespace {

struct Point {
	std::shared_ptr<PackedStore<3>> store;
	SampleSkeleton<3>               law;
	PointFields                     fields;
	double                          gradient[9] = {}, stress[6] = {}, ice, volume = 1;
	int                             place = 0, id = 0;

	Point(const SampleScheduling& scheduling, double iceSaturation)
	        : store(std::make_shared<PackedStore<3>>(
	                std::vector<PackedStore<3>::StatePointer> { std::make_shared<PackedState<3>>(packedSpheres::sample().state()) }))
	        , law(store, { 0 }, scheduling)
	        , ice(iceSaturation)
	{
		law.declareFields(fields, "");
		fields.allocate(1);
		law.initialise(batch());
	}
	SkeletonBatch<3> batch()
	{
		SkeletonBatch<3> b;
		b.count = 1;
		b.place = &place;
		b.id    = &id;
		for (int c = 0; c < 9; ++c)
			b.gradient[c] = &gradient[c];
		for (int c = 0; c < 6; ++c)
			b.stress[c] = &stress[c];
		b.iceSaturation = &ice;
		b.volume        = &volume;
		return b;
	}
	void step(const Matrix& displacementGradient)
	{
		for (int c = 0; c < 9; ++c)
			gradient[c] = displacementGradient(c / 3, c % 3);
		law.updateStress(batch());
	}
	Matrix tensor() const
	{
		Matrix s;
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j)
				s(i, j) = stress[stressIndex<3>(std::min(i, j), std::max(i, j))];
		return s;
	}
};

SampleScheduling askAlways()
{
	SampleScheduling s;
	s.strainTolerance = s.saturationTolerance = 0;
	return s;
}

SampleScheduling askNever()
{
	SampleScheduling s;
	s.strainTolerance = 1e9;
	s.stressTolerance = 0;
	return s;
}

Matrix increment()
{
	Matrix h;
	h << 3e-5, 1e-5, -2e-5, 4e-5, -5e-5, 1e-5, 2e-5, -1e-5, 1e-5;
	return h;
}

/// Stress that a tangent gives to the symmetric part of a displacement gradient, symmetrised.
Matrix elasticStress(const PackedTangent<3>& c, const Matrix& h)
{
	const Matrix strain  = 0.5 * (h + h.transpose());
	Matrix       elastic = Matrix::Zero();
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
			for (int k = 0; k < 3; ++k)
				for (int l = 0; l < 3; ++l)
					elastic(i, j) += c[((i * 3 + j) * 3 + k) * 3 + l] * strain(k, l);
	return 0.5 * (elastic + elastic.transpose());
}

} // namespace

TEST(SampleSkeleton, APointInSpaceCarriesTheStressOfItsSpheres)
{
	Point           point(askAlways(), 0.3);
	PackedSample<3> sample(packedSpheres::sample().state());
	sample.apply(Matrix::Zero(), 0.3);
	for (int k = 0; k < 3; ++k) {
		point.ice -= 0.05;
		point.step(increment());
		sample.apply(increment(), point.ice);
	}
	std::printf("sigma_yz %.6g Pa of the point, %.6g Pa of the sample\n", point.tensor()(1, 2), sample.stress()(1, 2));
	EXPECT_TRUE(point.tensor() == sample.stress());
	EXPECT_TRUE(point.store->state(0)->toBytes() == sample.state().toBytes());
}

TEST(SampleSkeleton, StressTurnsWithAPointInSpaceBetweenTwoCalls)
{
	Point           point(askNever(), 0.3);
	PackedSample<3> sample(packedSpheres::sample().state());
	sample.apply(Matrix::Zero(), 0.3);
	const Matrix before = point.tensor(), turn = Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
	const Matrix h = turn - Matrix::Identity();
	point.step(h);
	const Matrix expected = turn * before * turn.transpose() + elasticStress(sample.tangent(), h); // the strain of a turn is of second order
	const double error    = (point.tensor() - expected).norm() / expected.norm();
	std::printf("turned by 0.5 rad about (1, 2, 3): off by %.1e\n", error);
	EXPECT_LT(error, 1e-13);
}

TEST(SampleSkeleton, ThePredictionInSpaceIsTheTangentOfTheContacts)
{
	Point           point(askNever(), 0.3);
	PackedSample<3> sample(packedSpheres::sample().state());
	sample.apply(Matrix::Zero(), 0.3);
	const Matrix h = increment(), before = point.tensor();
	const Matrix spin     = 0.5 * (h - h.transpose());
	Matrix       expected = before + spin * before - before * spin; // to first order
	expected += elasticStress(sample.tangent(), h);
	point.step(h);
	const double error = (point.tensor() - expected).norm() / (expected - before).norm();
	std::printf("change of stress by %.4g Pa predicted, off by %.1e of it\n", (point.tensor() - before).norm(), error);
	EXPECT_LT(error, 1e-5);
}

TEST(SampleSkeleton, TheModulusOfSpheresIsAnUpperBoundThawedAndFrozen)
{
	for (const double ice : { 0., 1. }) {
		Point  point(askNever(), ice);
		double modulus = 0, largest = 0;
		point.law.tangentModulus(point.batch(), &modulus);
		PackedSample<3> sample(*point.store->state(0));
		const auto      c = sample.tangent();
		for (int i = 0; i < 3; ++i)
			largest = std::max(largest, c[((i * 3 + i) * 3 + i) * 3 + i]);
		std::printf("S_i = %g: %.3g Pa given, %.3g Pa from the contacts\n", ice, modulus, largest);
		EXPECT_GT(modulus, largest);
		EXPECT_LT(modulus, 4 * largest);
	}
}

TEST(SampleSkeleton, ARunInSpaceThatIsSavedGoesOnAlike)
{
	Point through(askAlways(), 0.3), restored(askAlways(), 0.3);
	through.step(increment());
	const std::string states = through.store->states();
	restored.law.restore(through.law.save(through.store->layout()), [&](std::uint64_t at, std::uint64_t length) { return states.substr(at, length); });
	std::copy(std::begin(through.stress), std::end(through.stress), restored.stress);
	for (int k = 0; k < 3; ++k) {
		through.step(increment());
		restored.step(increment());
	}
	EXPECT_TRUE(through.store->state(0)->toBytes() == restored.store->state(0)->toBytes());
	EXPECT_TRUE(through.tensor() == restored.tensor());
}
