// SPDX-License-Identifier: GPL-2.0-or-later
#include "packedReference.hpp"
#include "packedSpheres.hpp"
#include <cstdio>
#include <gtest/gtest.h>
#include <pkg/multiscale/samples/PackedStore.hpp>
#include <pkg/rve/packed/CellSlip.hpp>

using namespace talik;
using packedReference::matrix;
using packedReference::Matrix;

namespace {

const Matrix alongTheLattice = matrix(1e-3, 0, 0, -1e-3 / (1 + 1e-3)), diagonal = matrix(0, 1e-3, 1e-3, 0);

/// The sample of stock YADE at 100 kPa.
PackedState<2> atRest()
{
	PackedSample<2> s(packedReference::sample().state());
	EXPECT_TRUE(s.servo({}));
	return s.state();
}

double lattice(const PackedState<2>& state) { return cellCompactness<2>(state.hSize); }

struct Course {
	double        thinnest = 1, friction = 0, porosity = 0; ///< least compactness; means over the second half [-]
	std::uint64_t slips = 0;
	std::string   blowUp;
};

Course shear(PackedSample<2>& s, const Matrix& increment, double strain, const PackedUpdateOptions& options = {})
{
	Course     course;
	const long updates = std::lround(strain / increment.cwiseAbs().maxCoeff());
	double     q = 0, p = 0, change = 0;
	for (long k = 0; k < updates; ++k) {
		const auto result = s.apply(increment + change * Matrix::Identity(), 0, options);
		if (result.blewUp) {
			course.blowUp = result.reason;
			break;
		}
		const double pressure = -result.stress.trace() / 2;
		change                = std::max(-5e-4, std::min(5e-4, (pressure - 1e5) / 4e7)); // holds 100 kPa
		course.thinnest       = std::min(course.thinnest, lattice(s.state()));
		if (k < updates / 2) continue;
		q += std::hypot((result.stress(0, 0) - result.stress(1, 1)) / 2, result.stress(0, 1));
		p += pressure;
		course.porosity += s.statistics().porosity / double(updates - updates / 2);
	}
	course.friction = q / p;
	course.slips    = s.state().cellSlips;
	return course;
}

} // namespace

TEST(CellSlip, compactnessIsThatOfTheLatticeWhateverItsVectors)
{
	const Matrix square = Matrix::Identity(), sheared = matrix(1, 3, 0, 1), hexagonal = matrix(1, 0.5, 0, std::sqrt(0.75)), thin = matrix(4, 0, 0, 1);
	std::printf(
	        "square %.6f, the same by other vectors %.6f, hexagonal %.6f (%.6f), 4 to 1 %.6f (0.5)\n", cellCompactness<2>(square),
	        cellCompactness<2>(sheared), cellCompactness<2>(hexagonal), std::pow(0.75, -0.25), cellCompactness<2>(thin));
	EXPECT_NEAR(cellCompactness<2>(square), 1, 1e-12);
	EXPECT_NEAR(cellCompactness<2>(sheared), 1, 1e-12);
	EXPECT_NEAR(cellCompactness<2>(hexagonal), std::pow(0.75, -0.25), 1e-12);
	EXPECT_NEAR(cellCompactness<2>(thin), 0.5, 1e-12);
	Eigen::Matrix3d space = Eigen::Matrix3d::Identity();
	space(0, 2)           = -2;
	EXPECT_NEAR(cellCompactness<3>(space), 1, 1e-12);
}

TEST(CellSlip, cellsInPureShearStayCompactWithTheirGrainsAndTheirFriction)
{
	for (const bool turned : { false, true }) {
		PackedSample<2> s(atRest());
		const auto      before = s.state();
		const Course    course = shear(s, turned ? diagonal : alongTheLattice, 2);
		std::printf(
		        "pure shear %s to 2: %d slips, compactness at least %.3f (%.2f), q/p %.3f (0.22 to 0.42), porosity %.3f %s\n",
		        turned ? "at 45 deg" : "along the lattice", int(course.slips), course.thinnest, leastCompactness<2>, course.friction, course.porosity,
		        course.blowUp.c_str());
		EXPECT_EQ(course.blowUp, "");
		EXPECT_GE(course.slips, 1u);
		EXPECT_LE(course.slips, 4u);
		EXPECT_GT(course.thinnest, 0.98 * leastCompactness<2>);
		EXPECT_GT(course.friction, 0.22);
		EXPECT_LT(course.friction, 0.42);
		EXPECT_EQ(s.state().grains, before.grains);
		EXPECT_GT(s.state().cellSlipStrain, 0);
	}
}

TEST(CellSlip, thinCellsThatDoNotSlipBecomePillarsAndSayWhy)
{
	PackedSample<2>     s(atRest());
	PackedUpdateOptions options;
	options.flipSkew    = 0;
	const Course course = shear(s, alongTheLattice, 2.4, options);
	std::printf("without slips: q/p %.2f, thinnest %.2f; %s\n", course.friction, course.thinnest, course.blowUp.c_str());
	EXPECT_EQ(course.slips, 0u);
	EXPECT_LT(s.statistics().cellThickness, 3);
	EXPECT_TRUE(course.friction > 0.5 || course.blowUp.find("mean diameters thin") != std::string::npos);
	EXPECT_NE(ofThinCell(1.9).find("1.90 mean diameters thin"), std::string::npos);
	EXPECT_EQ(ofThinCell(5), "");
}

TEST(CellSlip, simpleShearNeedsNoSlip)
{
	PackedSample<2> s(atRest());
	const Course    course = shear(s, matrix(0, 1e-3, 0, 0), 1);
	std::printf("simple shear to 1: %d slips (0), compactness at least %.3f\n", int(course.slips), course.thinnest);
	EXPECT_EQ(course.slips, 0u);
	EXPECT_EQ(course.blowUp, "");
}

namespace {

/// Four samples sheared at different rates until all have slipped; saved and restored after so many updates.
std::string bytesOfFour(const PackedState<2>& start, int threads, int savedAfter)
{
	const auto make = [&] {
		return std::make_unique<PackedStore<2>>(std::vector<PackedStore<2>::StatePointer> { std::make_shared<PackedState<2>>(start) });
	};
	auto store = make();
	for (int k = 0; k < 4; ++k)
		store->add(0, start.iceSaturation, {});
	for (int update = 0; update < 725; ++update) {
		std::vector<PackedRequest<2>> requests(4);
		for (std::size_t k = 0; k < 4; ++k) {
			requests[k].sample               = k;
			requests[k].displacementGradient = (1 + 0.1 * double(k)) * alongTheLattice;
		}
		store->update(requests, {}, threads);
		if (update != savedAfter) continue;
		const auto        layout = store->layout();
		const std::string states = store->states();
		store                    = make();
		store->restore(layout, [&](std::uint64_t at, std::uint64_t length) { return states.substr(at, length); });
	}
	ByteWriter all;
	for (std::size_t k = 0; k < 4; ++k) {
		EXPECT_GE(store->measure(k, "cellSlips").front(), 1);
		store->saveState(all, k);
	}
	return all.bytes();
}

} // namespace

TEST(CellSlip, slipsAreTheSameBitsWithAnyThreadsAndThroughACheckpoint)
{
	const PackedState<2> start = atRest();
	const std::string    one = bytesOfFour(start, 1, -1), three = bytesOfFour(start, 3, -1);
	const std::string    before = bytesOfFour(start, 2, 450), between = bytesOfFour(start, 2, 650);
	std::printf(
	        "three threads: %s; saved before the slips: %s; between them: %s\n", three == one ? "the same bytes" : "other bytes",
	        before == one ? "the same" : "others", between == one ? "the same" : "others");
	EXPECT_EQ(three, one);
	EXPECT_EQ(before, one);
	EXPECT_EQ(between, one);
}

TEST(CellSlip, bondsAcrossThePlanesBreakAndAreCounted)
{
	PackedSample<2> s(packedReference::frozen(1));
	bool            slipped = false;
	for (int k = 0; k < 800 && !slipped; ++k) {
		const auto result = s.apply(alongTheLattice, 1);
		ASSERT_FALSE(result.blewUp) << result.reason;
		slipped = result.slipped;
	}
	const auto after      = s.state();
	const auto statistics = s.statistics();
	std::printf(
	        "%d bonds formed, %d intact, %d broken in tension, %d in shear, %d melted\n", int(after.bondsFormed), int(statistics.bondsIntact),
	        int(after.bondsBrokenInTension), int(after.bondsBrokenInShear), int(after.bondsMelted));
	EXPECT_TRUE(slipped);
	EXPECT_EQ(after.bondsFormed, statistics.bondsIntact + after.bondsBrokenInTension + after.bondsBrokenInShear + after.bondsMelted);
}

TEST(CellSlip, cellsOfSpheresInPureShearStayCompact)
{
	PackedSample<3> s(packedSpheres::sample().state());
	ASSERT_TRUE(s.servo({}));
	Eigen::Matrix3d increment = Eigen::Vector3d(1e-3, 0, -1e-3).asDiagonal();
	double          thinnest = 1, change = 0;
	for (int k = 0; k < 1200; ++k) {
		const auto result = s.apply(increment + change * Eigen::Matrix3d::Identity(), 0);
		ASSERT_FALSE(result.blewUp) << result.reason;
		change   = std::max(-5e-4, std::min(5e-4, (-result.stress.trace() / 3 - 1e5) / 1e8));
		thinnest = std::min(thinnest, cellCompactness<3>(s.state().hSize));
	}
	std::printf("spheres, pure shear to 1.2: %d slips, compactness at least %.3f (%.2f)\n", int(s.state().cellSlips), thinnest, leastCompactness<3>);
	EXPECT_GE(s.state().cellSlips, 1u);
	EXPECT_GT(thinnest, 0.98 * leastCompactness<3>);
}
