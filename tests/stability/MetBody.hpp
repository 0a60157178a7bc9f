// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "Watch.hpp"

#include <pkg/mpm/effects/RigidContact.hpp>

#include <cmath>

namespace talik::stability {

/// A rigid body that meets the ground without turning; driven at constant speed if its mass is infinite.
template <int D> struct MetBody {
	RigidContact<D>* contact = nullptr;  ///< whose first body it is
	double           mass    = INFINITY; ///< [kg]
	Vec<D>           taken {};           ///< impulse that it has taken from the contact [N s]

	/// Takes the impulse received and moves.
	void advance(double dt)
	{
		RigidBody<D>& body = contact->bodies[0];
		for (int a = 0; a < D; ++a) {
			body.velocity[a] += (body.impulse[a] - taken[a]) / mass;
			body.position[a] += dt * body.velocity[a];
		}
		taken = body.impulse;
	}

	/// That its contacts stand [s].
	double longestStep() const { return std::isinf(mass) ? INFINITY : RigidContact<D>::timeStep(mass, contact->gripOn(contact->bodies[0])); }

	/// Kinetic, or what its driver received [J].
	double energy() const
	{
		const RigidBody<D>& body = contact->bodies[0];
		double              sum  = 0.0;
		for (int a = 0; a < D; ++a)
			sum += body.velocity[a] * (std::isinf(mass) ? body.impulse[a] : 0.5 * mass * body.velocity[a]);
		return sum;
	}

	Outside outside()
	{
		return { [this](double dt) { advance(dt); }, [this] { return energy(); }, [this] { return longestStep(); } };
	}
};

} // namespace talik::stability
