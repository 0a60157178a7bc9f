// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cmath>

namespace talik {

/// Stiffness against rotation of one bond [N m].
struct MomentStiffness {
	double bending, twisting;
};

/// Section of the bonds that carry moments: of the area A_b, its edge at R_b = radiusFactor sqrt(A_b/pi), I = A_b R_b^2/4 and J = A_b R_b^2/2;
/// with the factor 1 a circle. Moments add to the stress at the edge (parallel bond, Potyondy & Cundall 2004).
struct BondSection {
	double radiusFactor = 0; ///< R_b over the radius of a circle of the bond's area [-], >= 0; 0: bonds carry no moments
	double contribution = 1; ///< beta, share of the moments in the stress at the edge [-], 0 to 1 (Potyondy 2011)

	bool   acts() const { return radiusFactor > 0; }
	double radius(double area) const { return radiusFactor * std::sqrt(area / M_PI); }
	/// Of a bond whose ice has the normal stiffness k_ice [N/m].
	MomentStiffness stiffness(double area, double iceStiffness, double shearRatio) const
	{
		const double square = radius(area) * radius(area);
		return { 0.25 * iceStiffness * square, 0.5 * shearRatio * iceStiffness * square };
	}
	/// Force over the area that has the stress of a bending moment at the edge, over that moment [1/m]; half of it for a twisting moment.
	double edgeOverMoment(double area) const { return 4 * contribution / radius(area); }
	bool   operator==(const BondSection& other) const { return radiusFactor == other.radiusFactor && contribution == other.contribution; }
};

/// Stress that moments add at the edge of a bond's section, times the area of the bond [N].
template <class Number> struct EdgeForces {
	Number tension, shear;
};

/// Bonds that carry no moments.
struct NoMoments {};

} // namespace talik
