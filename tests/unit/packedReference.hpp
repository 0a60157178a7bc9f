// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cmath>
#include <fstream>
#include <pkg/rve/packed/PackedSample.hpp>
#include <stdexcept>
#include <string>
#include <vector>

/// What stock YADE 2023.02a made of a sample of discs (tests/yade/make_packed_reference.py).
namespace packedReference {

using State  = talik::PackedState<2>;
using Matrix = State::Matrix;

struct Contact {
	int    first, second, c[2];
	double shear, normal;
};

struct Frame {
	std::string                        title;
	Matrix                             hSize, trsf, stress;
	std::vector<std::array<double, 5>> grains; ///< x y vx vy w
	std::vector<Contact>               contacts;
};

struct Reference {
	double              dt, damping, thickness, friction, stiffnessRatio, young, density;
	Matrix              velGrad;
	std::vector<double> radii;
	std::vector<Frame>  frames; ///< initial, then after 1, 100 and 500 steps

	State state(std::size_t frame = 0) const
	{
		const Frame& f = frames.at(frame);
		State        s;
		s.dt = dt, s.damping = damping, s.thickness = thickness, s.friction = friction, s.stiffnessRatio = stiffnessRatio, s.density = density;
		s.ice.young = young;
		s.hSize = s.prevHSize = f.hSize;
		s.trsf                = f.trsf;
		s.stress              = f.stress;
		auto grains           = std::make_shared<talik::PackedGrains>();
		for (std::size_t g = 0; g < radii.size(); ++g) {
			const double r = radii[g], mass = density * thickness * M_PI * r * r;
			grains->radius.push_back(r);
			grains->mass.push_back(mass);
			grains->inertia.push_back(0.5 * mass * r * r);
			grains->id.push_back(int(g));
			s.position.emplace_back(f.grains[g][0], f.grains[g][1]);
			s.velocity.emplace_back(f.grains[g][2], f.grains[g][3]);
			s.angularVelocity.push_back(f.grains[g][4]);
			s.orientation.push_back(0);
		}
		s.grains = grains;
		for (const Contact& c : f.contacts) {
			s.contacts.first.push_back(std::uint16_t(c.first));
			s.contacts.second.push_back(std::uint16_t(c.second));
			s.contacts.cellDist.push_back({ std::int8_t(c.c[0]), std::int8_t(c.c[1]) });
			s.contacts.shear.push_back(c.shear);
		}
		return s;
	}
};

inline Matrix readMatrix(std::istream& in)
{
	std::string name;
	Matrix      m;
	in >> name >> m(0, 0) >> m(0, 1) >> m(1, 0) >> m(1, 1);
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
	in >> word >> r.dt >> word >> r.damping >> word >> r.thickness >> word >> r.friction >> word >> r.stiffnessRatio >> word >> r.young >> word
	        >> r.density;
	r.velGrad = readMatrix(in);
	in >> word >> count;
	r.radii.resize(count);
	for (double& radius : r.radii)
		in >> radius;
	std::getline(in, line);
	while (std::getline(in, line)) {
		Frame f;
		f.title  = line;
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
			in >> c.first >> c.second >> c.c[0] >> c.c[1] >> c.shear >> c.normal;
			if (c.first < c.second) continue;
			std::swap(c.first, c.second);
			c.c[0] = -c.c[0];
			c.c[1] = -c.c[1];
		}
		if (!in) throw std::runtime_error("reference file is damaged: " + file);
		std::getline(in, line);
		r.frames.push_back(f);
	}
	return r;
}

#ifdef TALIK_TEST_DATA
inline const Reference& sample()
{
	static const Reference reference = read(TALIK_TEST_DATA "/packed_reference.txt");
	return reference;
}

/// The sample of stock YADE with bonds, frozen in twenty parts.
inline State frozen(double iceSaturation)
{
	talik::PackedSample<2> frozen(sample().state());
	for (int k = 1; k <= 20; ++k) {
		frozen.setIceSaturation(iceSaturation * k / 20);
		frozen.advance(5);
	}
	return frozen.state();
}
#endif

inline Matrix matrix(double xx, double xy, double yx, double yy)
{
	Matrix m;
	m << xx, xy, yx, yy;
	return m;
}

} // namespace packedReference
