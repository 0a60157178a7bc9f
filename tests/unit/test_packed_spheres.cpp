// SPDX-License-Identifier: GPL-2.0-or-later
#include <cstdio>
#include <fstream>
#include <gtest/gtest.h>
#include <pkg/rve/packed/PackedSample.hpp>

using namespace talik;
using State  = PackedState<3>;
using Matrix = State::Matrix;

namespace {

struct Contact {
	int             first, second, c[3];
	Eigen::Vector3d normal, shear;
};

struct Frame {
	Matrix                             hSize, trsf, stress;
	std::vector<std::array<double, 9>> grains;
	std::vector<Contact>               contacts;
};

/// What stock YADE made of a sample of spheres (tests/yade/make_packed_spheres_reference.py).
struct Reference {
	double              dt, damping, friction, stiffnessRatio, young, density;
	Matrix              velGrad;
	std::vector<double> radii;
	std::vector<Frame>  frames;
};

Matrix readMatrix(std::istream& in)
{
	std::string name;
	Matrix      m;
	in >> name;
	for (int k = 0; k < 9; ++k)
		in >> m(k / 3, k % 3);
	return m;
}

const Reference& reference()
{
	static const Reference stored = [] {
		std::ifstream in(TALIK_TEST_DATA "/packed_spheres_reference.txt");
		if (!in) throw std::runtime_error("packed_spheres_reference.txt not found");
		Reference   r;
		std::string line, word;
		std::size_t count;
		std::getline(in, line);
		in >> word >> r.dt >> word >> r.damping >> word >> r.friction >> word >> r.stiffnessRatio >> word >> r.young >> word >> r.density;
		r.velGrad = readMatrix(in);
		in >> word >> count;
		r.radii.resize(count);
		for (double& radius : r.radii)
			in >> radius;
		std::getline(in, line);
		while (std::getline(in, line)) {
			Frame f;
			f.hSize  = readMatrix(in);
			f.trsf   = readMatrix(in);
			f.stress = readMatrix(in);
			in >> word >> count;
			f.grains.resize(count);
			for (auto& g : f.grains)
				for (double& value : g)
					in >> value;
			in >> word >> count;
			f.contacts.resize(count);
			for (Contact& c : f.contacts) {
				in >> c.first >> c.second >> c.c[0] >> c.c[1] >> c.c[2];
				for (int d = 0; d < 3; ++d)
					in >> c.normal[d];
				for (int d = 0; d < 3; ++d)
					in >> c.shear[d];
				if (c.first < c.second) continue;
				std::swap(c.first, c.second);
				for (int& component : c.c)
					component = -component;
				c.normal = -c.normal;
				c.shear  = -c.shear;
			}
			std::getline(in, line);
			r.frames.push_back(f);
		}
		return r;
	}();
	return stored;
}

State initial()
{
	const Reference& r = reference();
	const Frame&     f = r.frames.at(0);
	State            s;
	s.dt = r.dt, s.damping = r.damping, s.friction = r.friction, s.stiffnessRatio = r.stiffnessRatio, s.density = r.density;
	s.ice.grainYoung = r.young;
	s.hSize = s.prevHSize = f.hSize;
	s.trsf                = f.trsf;
	s.stress              = f.stress;
	auto grains           = std::make_shared<PackedGrains>();
	for (std::size_t g = 0; g < r.radii.size(); ++g) {
		const double radius = r.radii[g], mass = r.density * 4. / 3. * M_PI * radius * radius * radius;
		grains->radius.push_back(radius);
		grains->mass.push_back(mass);
		grains->inertia.push_back(0.4 * mass * radius * radius);
		grains->id.push_back(int(g));
		s.position.emplace_back(f.grains[g][0], f.grains[g][1], f.grains[g][2]);
		s.velocity.emplace_back(f.grains[g][3], f.grains[g][4], f.grains[g][5]);
		s.angularVelocity.emplace_back(f.grains[g][6], f.grains[g][7], f.grains[g][8]);
		s.orientation.push_back({ 1, 0, 0, 0 });
	}
	s.grains = grains;
	for (const Contact& c : f.contacts) {
		s.contacts.first.push_back(std::uint16_t(c.first));
		s.contacts.second.push_back(std::uint16_t(c.second));
		s.contacts.cellDist.push_back({ std::int8_t(c.c[0]), std::int8_t(c.c[1]), std::int8_t(c.c[2]) });
		s.contacts.normal.push_back(c.normal);
		s.contacts.shear.push_back(c.shear);
	}
	return s;
}

} // namespace

TEST(PackedSpheres, followStockYade)
{
	PackedSample<3> sample(initial());
	const long      checkpoints[] = { 1, 100, 500 };
	const double    tolerance[]   = { 1e-11, 1e-9, 1e-8 };
	long            done          = 0;
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
		        "%ld steps against stock YADE: stress %.1e position %.1e velocity %.1e spin %.1e (%zu contacts)\n", done, stress, position,
		        velocity / largestVelocity, spin / largestSpin, s.contacts.size());
		EXPECT_LT(std::max({ stress, position, velocity / largestVelocity, spin / largestSpin }), tolerance[k]);
	}
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
