// SPDX-License-Identifier: GPL-2.0-or-later
// A thawed layer on a frozen face of 45 degrees that ends on level ground: it moves as fast as its foot lets it shear out, against limit analysis.
#include "LayerOverFoot.hpp"
#include "Report.hpp"

#include <gtest/gtest.h>

using namespace talik;
using namespace talik::validation;

namespace {

void expectToLeave(double cellsThick, double tolerance)
{
	citing("limit analysis; Davis 1968");
	const Face face;
	char       text[160];
	std::snprintf(text, sizeof(text), "thawed layer that leaves a face of 45 degrees over its foot: X/h = %.0f, acceleration [m/s^2]", cellsThick);
	expectRelative(text, acceleration(face, face.thickness / cellsThick, 0.5), accelerationOverFoot, tolerance);
}

} // namespace

// The layer shears through itself at the foot, across two cells or more. Four cells over its thickness leave room for such a band; with two cells, whose
// best field begins to move by 1.41 m/s^2, it moves by 1.12.
TEST(LayerOverFoot, AcceleratesAsRigidPlasticGroundDoes) { expectToLeave(4.0, 0.1); }

TEST(LayerOverFoot, AcceleratesAsRigidPlasticGroundDoesOnAFineGrid_slow) { expectToLeave(8.0, 0.12); }
