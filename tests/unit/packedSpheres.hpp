// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cmath>
#include <fstream>
#include <pkg/rve/packed/PackedSample.hpp>
#include <stdexcept>
#include <string>
#include <vector>

/// What stock YADE 2023.02a made of a sample of spheres (tests/yade/make_packed_spheres_reference.py).
namespace packedSpheres {

using State  = talik::PackedState<3>;
using Matrix = State::Matrix;

struct Contact {
	int             first, second, c[3];
	Eigen::Vector3d normal, shear;
};

struct Frame {
	Matrix                             hSize, trsf, stress;
	std::vector<std::array<double, 9>> grains;
	std::vector<Contact>               contacts;
};

struct Reference {
	double              dt, damping, friction, stiffnessRatio, young, density;
	Matrix              velGrad;
	std::vector<double> radii;
	std::vector<Frame>  frames; ///< initial, then after 1, 100 and 500 steps

	State state() const
	{
		const Frame& f = frames.at(0);
		State        s;
		s.dt = dt, s.damping = damping, s.friction = friction, s.stiffnessRatio = stiffnessRatio, s.density = density;
		s.ice.young = young;
		s.hSize = s.prevHSize = f.hSize;
		s.trsf                = f.trsf;
		s.stress              = f.stress;
		auto grains           = std::make_shared<talik::PackedGrains>();
		for (std::size_t g = 0; g < radii.size(); ++g) {
			const double radius = radii[g], mass = density * 4. / 3. * M_PI * radius * radius * radius;
			grains->radius.push_back(radius);
			grains->mass.push_back(mass);
			grains->inertia.push_back(0.4 * mass * radius * radius);
			grains->id.push_back(int(g));
			s.position.emplace_back(f.grains[g][0], f.grains[g][1], f.grains[g][2]);
			s.velocity.emplace_back(f.grains[g][3], f.grains[g][4], f.grains[g][5]);
			s.angularVelocity.emplace_back(f.grains[g][6], f.grains[g][7], f.grains[g][8]);
		}
		s.grains = grains;
		for (const Contact& c : f.contacts) {
			s.contacts.first.push_back(std::uint16_t(c.first));
			s.contacts.second.push_back(std::uint16_t(c.second));
			s.contacts.cellDist.push_back({ std::int8_t(c.c[0]), std::int8_t(c.c[1]), std::int8_t(c.c[2]) });
			s.contacts.shear.push_back(c.shear);
		}
		return s;
	}
};

inline Matrix readMatrix(std::istream& in)
{
	std::string name;
	Matrix      m;
	in >> name;
	for (int k = 0; k < 9; ++k)
		in >> m(k / 3, k % 3);
	return m;
}

inline Reference read(const std::string& file)
{
	std::ifstream in(file);
	if (!in) throw std::runtime_error("reference file not found: " + file);
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
}

#ifdef TALIK_TEST_DATA
inline const Reference& sample()
{
	static const Reference reference = read(TALIK_TEST_DATA "/packed_spheres_reference.txt");
	return reference;
}
#endif

} // namespace packedSpheres
