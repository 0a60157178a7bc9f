// SPDX-License-Identifier: GPL-2.0-or-later
// The recipe of pkg/icebond/how-to.md, compiled with the changes that it shows: one line in the list of parameters and one formula make a law that
// packed samples compute, archive and check.
#include <cmath>
#include <cstdio>
#include <pkg/icebond/BondTable.hpp>
#include <pkg/rve/packed/PackedState.hpp>
#include <stdexcept>
#include <string>

using namespace talik;

namespace {

PackedState<2> twoDiscs(double threshold)
{
	auto grains    = std::make_shared<PackedGrains>();
	grains->radius = grains->mass = grains->inertia = { 1., 1. };
	grains->id                                      = { 0, 1 };
	PackedState<2> s;
	s.grains                = grains;
	s.hSize                 = 10 * s.hSize;
	s.position              = { { 0., 0. }, { 2., 0. } };
	s.velocity              = { { 0., 0. }, { 0., 0. } };
	s.angularVelocity       = { 0., 0. };
	s.orientation           = { 0., 0. };
	s.ice.strengthThreshold = threshold;
	return s;
}

bool held(const char* what, double measured, double reference, double tolerance)
{
	const bool holds = std::fabs(measured - reference) <= tolerance * std::fabs(reference);
	std::printf("%s: %.9g, reference %.9g, tolerance %.0e of it: %s\n", what, measured, reference, tolerance, holds ? "holds" : "FAILS");
	return holds;
}

std::string refusalOf(double threshold)
{
	try {
		twoDiscs(threshold).check();
	} catch (const std::invalid_argument& refusal) {
		return refusal.what();
	}
	return "";
}

} // namespace

int main()
{
	const auto back    = PackedState<2>::fromBytes(twoDiscs(0.4).toBytes());
	bool       holds   = held("archived parameter", back.ice.strengthThreshold, 0.4, 0);
	const auto refused = refusalOf(1.5);
	std::printf("refusal: %s\n", refused.c_str());
	holds = holds && refused.find("ice.strengthThreshold") != std::string::npos;
	// (0.7 - 0.4)/(1 - 0.4) = 1/2 and phi(1/2) = 1 - (1 - 1/4)^2 = 7/16
	holds            = held("tensile strength at S_i = 0.7", back.ice.tensileStrengthAt(0.7), 1e6 + 50e6 * 7 / 16, 1e-14) && holds;
	holds            = held("tensile strength at S_i = 0.3", back.ice.tensileStrengthAt(0.3), 1e6, 0) && holds;
	const auto other = mixed(IceBondModel(), back.ice);
	return held("of two materials the larger threshold", other.strengthThreshold, 0.4, 0) && holds ? 0 : 1;
}
