// SPDX-License-Identifier: GPL-2.0-or-later
// Rigid surfaces and their contact with the ground, in two and three dimensions.
#include <pkg/mpm/effects/RigidContact.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <cstdio>
#include <cstring>

using namespace talik;

namespace {

template <int D> Vec<D> filledWith(double value)
{
	Vec<D> v;
	v.fill(value);
	return v;
}

template <int D> RigidBody<D> bodyAt(const RigidShape<D>& shape, const Vec<D>& size, const Vec<D>& position)
{
	RigidBody<D> body;
	body.id = body.group = 0;
	body.shape           = &shape;
	body.size            = size;
	body.position        = position;
	for (int a = 0; a < D; ++a)
		body.axes[a][a] = 1.0;
	return body;
}

/// A free cube of ground in the middle of an empty box.
template <int D> Ground<D> freeCube(int parallelFrom = 1 << 30)
{
	GroundSettings<D> s;
	s.lower        = filledWith<D>(0.0);
	s.upper        = filledWith<D>(2.0);
	s.gridSpacing  = 0.2;
	s.parallelFrom = parallelFrom;
	s.motion.emplace();
	s.bodies.emplace();
	auto skeleton   = std::make_shared<ElasticSkeleton<D>>();
	skeleton->young = 1e6;
	s.skeletons.push_back(skeleton);
	Ground<D>          ground(s);
	std::array<int, D> i {};
	for (int a = 0; a < D;) {
		PointInput<D> p;
		p.volume = std::pow(0.1, D);
		for (int b = 0; b < D; ++b)
			p.position[b] = 0.65 + 0.1 * i[b];
		ground.addPoint(p);
		for (a = 0; a < D && ++i[a] == 7; ++a)
			i[a] = 0;
	}
	ground.initialise();
	return ground;
}

/// A heavy ball meets the cube aslant. Returns the largest difference of momentum gained and given, over the momentum given.
template <int D> double momentumLost(Ground<D>& ground)
{
	Vec<D> at               = filledWith<D>(1.0);
	at[D - 1]               = 1.3 + 0.31;
	RigidBody<D> ball       = bodyAt<D>(rigidBall<D>(), filledWith<D>(0.3), at);
	ball.friction           = 0.5;
	ball.velocity[0]        = 1.0;
	ball.velocity[D - 1]    = -2.0;
	ground.bodies()->bodies = { ball };
	RigidBody<D>& body      = ground.bodies()->bodies[0];
	double        worst     = 0.0;
	for (int step = 0; step < 70; ++step) {
		const double dt = ground.stableTimeStep().step;
		ground.step(dt);
		for (int a = 0; a < D; ++a)
			body.position[a] += dt * body.velocity[a];
		const Balance<D> b = ground.balance();
		for (int a = 0; a < D; ++a)
			worst = std::max(worst, std::abs(b.momentum[a] + body.impulse[a]));
	}
	return worst / std::abs(body.impulse[D - 1]);
}

} // namespace

TEST(RigidShapes, distances_are_those_of_elementary_geometry)
{
	const auto ball = rigidBall<3>().nearest({ 3.0, 4.0, 0.0 }, { 2.0, 2.0, 2.0 }, 1);
	EXPECT_DOUBLE_EQ(ball.distance, 3.0);
	EXPECT_DOUBLE_EQ(ball.normal[0], 0.6);
	const auto face = rigidBox<2>().nearest({ 0.2, 1.5 }, { 2.0, 1.0 }, 1);
	EXPECT_DOUBLE_EQ(face.distance, 0.5);
	EXPECT_DOUBLE_EQ(face.normal[1], 1.0);
	const auto corner = rigidBox<2>().nearest({ -2.3, -1.4 }, { 2.0, 1.0 }, 1);
	EXPECT_DOUBLE_EQ(corner.distance, 0.5);
	EXPECT_NEAR(corner.normal[0], -0.6, 1e-15);
	const auto inside = rigidBox<2>().nearest({ 1.9, 0.0 }, { 2.0, 1.0 }, 1);
	EXPECT_NEAR(inside.distance, -0.1, 1e-15);
	EXPECT_DOUBLE_EQ(inside.normal[0], 1.0);
	EXPECT_DOUBLE_EQ(rigidPlane<2>().nearest({ -0.7, 9.0 }, {}, -1).distance, 0.7);
	EXPECT_DOUBLE_EQ(rigidPlate<2>().nearest({ 0.3, 0.9 }, { 0.0, 1.0 }, 1).distance, 0.3);
	EXPECT_DOUBLE_EQ(rigidPlate<2>().nearest({ 0.3, 1.4 }, { 0.0, 1.0 }, 1).distance, 0.5);
}

TEST(RigidContact, a_ball_and_free_ground_exchange_momentum_without_loss_in_two_dimensions)
{
	auto         ground = freeCube<2>();
	const double lost   = momentumLost(ground);
	std::printf("momentum lost over momentum exchanged: %.2e\n", lost);
	EXPECT_LT(lost, 1e-12);
}

TEST(RigidContact, a_ball_and_free_ground_exchange_momentum_without_loss_in_three_dimensions)
{
	auto         ground = freeCube<3>();
	const double lost   = momentumLost(ground);
	std::printf("momentum lost over momentum exchanged: %.2e\n", lost);
	EXPECT_LT(lost, 1e-12);
}

TEST(RigidContact, results_are_the_same_bits_with_one_and_with_three_threads)
{
	std::vector<double> results[2];
	for (int k = 0; k < 2; ++k) {
		omp_set_num_threads(k == 0 ? 1 : 3);
		auto ground = freeCube<2>(1);
		momentumLost(ground);
		results[k].resize(ground.points().count());
		ground.copyById("velocity", 1, results[k].data());
		for (double v : ground.bodies()->bodies[0].impulse)
			results[k].push_back(v);
	}
	EXPECT_EQ(std::memcmp(results[0].data(), results[1].data(), results[0].size() * sizeof(double)), 0);
}

TEST(RigidContact, ground_without_bodies_has_nothing_of_them)
{
	GroundSettings<2> s;
	s.upper       = { 1.0, 1.0 };
	s.gridSpacing = 0.5;
	s.motion.emplace();
	s.skeletons.push_back(std::make_shared<ElasticSkeleton<2>>());
	Ground<2>     ground(s);
	PointInput<2> p;
	p.position = { 0.5, 0.5 };
	p.volume   = 0.01;
	ground.addPoint(p);
	ground.initialise();
	EXPECT_EQ(ground.bodies(), nullptr);
	for (const FieldInfo& f : ground.fields())
		EXPECT_NE(f.owner, "bodies") << f.name;
	for (const TimeStepLimit& limit : ground.stableTimeStep().limits)
		EXPECT_NE(limit.name, "contact");
}
