// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Body.hpp>
#include <functional>
#include <memory>
#include <pkg/mpm/effects/RigidContact.hpp>

namespace yade {

/// Bodies of the scene as a ground meets them: in the plane their sections across z, in space themselves. Vectors given and taken are
/// those of the scene.
class MetBodies {
public:
	virtual ~MetBodies() = default;
	static std::unique_ptr<MetBodies> of(talik::RigidContact<2>& contact);
	static std::unique_ptr<MetBodies> of(talik::RigidContact<3>& contact);

	virtual void clear() = 0;
	/// Returns why the body cannot be met; empty if it can, or is none that this ground meets. friction: tan phi, asked if it is met.
	virtual string add(const Body& body, const std::function<Real(const Body&)>& friction) = 0;
	/// Shows all that were added to the ground, as they are now.
	virtual void show() = 0;

	virtual size_t     count() const        = 0;
	virtual Body::id_t id(size_t met) const = 0;
	/// Whether a body moves where forces of the ground push it.
	virtual bool movesFreely(const State& state) const = 0;

	/// What the ground can do to it at most [N/m, N s/m], per metre of thickness in the plane.
	struct Grip {
		Real spring = 0, dashpot = 0;
	};
	virtual Grip gripOn(size_t met) const                    = 0;
	virtual Real timeStep(Real mass, const Grip& grip) const = 0; ///< largest of a free body [s]
	struct Overlap {
		int  met   = -1; ///< -1: none
		Real depth = 0;
	};
	virtual Overlap deepestOverlap() const = 0;

	/// Moves them along their velocities, time [s] after show().
	virtual void place(Real time) = 0;
	struct Received {
		Vector3r impulse = Vector3r::Zero(), angularImpulse = Vector3r::Zero(); ///< about the body's position
	};
	/// What the ground gave since the last call.
	virtual Received take(size_t met) = 0;
};

} // namespace yade
