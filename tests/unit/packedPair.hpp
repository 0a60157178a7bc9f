// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cmath>
#include <pkg/rve/packed/PackedSample.hpp>

/// Two equal discs on the x axis, so heavy that no force moves them: displacement and slip are prescribed through their velocities.
namespace packedPair {

using State = talik::PackedState<2>;

constexpr double radius = 5e-3;

inline State make(double overlap, double iceSaturation)
{
	State s;
	s.hSize = s.prevHSize = State::Matrix::Identity() * 0.1;
	s.iceSaturation       = iceSaturation;
	auto grains           = std::make_shared<talik::PackedGrains>();
	for (int g = 0; g < 2; ++g) {
		grains->radius.push_back(radius);
		grains->mass.push_back(1e25);
		grains->inertia.push_back(1e25);
		grains->id.push_back(g);
		s.position.emplace_back(g * (2 * radius - overlap), 0.);
		s.velocity.emplace_back(0., 0.);
		s.angularVelocity.push_back(0);
		s.orientation.push_back(0);
	}
	s.grains = grains;
	return s;
}

/// The same with an intact bond whose springs are free at zero overlap.
inline State bonded(double overlap, double iceSaturation)
{
	State s                   = make(overlap, iceSaturation);
	s.contacts.first          = { 0 };
	s.contacts.second         = { 1 };
	s.contacts.cellDist       = { { 0, 0 } };
	s.contacts.shear          = { 0 };
	s.contacts.iceShear       = { 0 };
	s.contacts.iceReference   = { 0 };
	s.contacts.grainReference = { 0 };
	s.contacts.bond           = { std::uint8_t(talik::BondState::BONDED) };
	return s;
}

inline double overlap(const State& s) { return 2 * radius - (s.position[1] - s.position[0]).norm(); }

inline double normalForce(const State& s) { return -s.stress(0, 0) * s.volume() / (s.position[1] - s.position[0]).norm(); }

inline double shearForce(const State& s) { return s.contacts.size() ? s.contacts.shear[0] : 0.; }

inline bool intact(const State& s) { return s.bonded() && s.contacts.bond[0] == std::uint8_t(talik::BondState::BONDED); }

/// Spin of both discs that adds `slip` [m] to the shear displacement (positive: shear force grows) in every step.
inline void setSlip(State& s, double slip)
{
	for (double& w : s.angularVelocity)
		w = slip / (2 * radius * s.dt);
}

/// One step at the given overlap and slip; returns the state after it.
inline State step(State s, double newOverlap, double slip)
{
	s.position[1][0] = s.position[0][0] + 2 * radius - newOverlap;
	setSlip(s, slip);
	talik::PackedSample<2> sample(s);
	sample.advance(1);
	return sample.state();
}

} // namespace packedPair
