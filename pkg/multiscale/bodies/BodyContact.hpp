// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Body.hpp>
#include <functional>
#include <lib/serialization/Serializable.hpp>
#include <memory>
#include <pkg/mpm/effects/RigidContact.hpp>
#include <pkg/mpm/GroundSettings.hpp>

namespace yade {

/// Bodies of the scene as a ground meets them: in the plane their sections across z, in space themselves. Vectors given and taken are
/// those of the scene.
class SceneBodies {
public:
	virtual ~SceneBodies() = default;
	static std::unique_ptr<SceneBodies> of(talik::RigidContact<2>& contact);
	static std::unique_ptr<SceneBodies> of(talik::RigidContact<3>& contact);

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

class Engine;

/// Bodies of the main scene among the material points. The contact itself (talik::RigidContact) knows no YADE; this class shows it
/// the bodies and brings back their forces, and lets ground and bodies keep steps of different length.
class BodyContact : public Serializable {
public:
	talik::RigidContactSettings build(int dimension) const;

	/// The next collect() compares bodies with all points of the ground.
	bool hasNewBodies(const Scene& scene) const;
	/// Shows the bodies of a scene to the ground, as they are now. Throws if one of them cannot be met.
	void collect(const Scene& scene, const Engine& mpm, SceneBodies& met);
	/// Takes what the ground gave during its last `interval` [s].
	void take(SceneBodies& met, Real interval);
	/// Adds the share of the scene's step to O.forces.
	void deliver(Scene& scene);

	/// O.dt [s] that ground and bodies stand, with their mass on the contact springs and, where they meet each other, the wave in
	/// the smallest sphere. A time stepper in O.engines has the last word, the contact apart: the ground then takes sub-steps.
	Real timeStep(const Scene& scene, const SceneBodies& met, Real stableStep) const;
	/// The next step of the ground [s], as long as the bodies' step or a multiple of it.
	Real groundStep(const Scene& scene, Real stableStep) const;
	/// Time since the end of the ground's step, negative while the ground is ahead [s].
	Real due(const Scene& scene) const;

private:
	void              checkEngines(const Scene& scene, const Engine& mpm);
	Real              frictionOf(const Body& body) const;
	void              limitByContact(const Scene& scene, const SceneBodies& met);
	[[noreturn]] void refuse(const Body& body, const string& reason) const;
	void              refuseOverlap(const Scene& scene, const SceneBodies& met) const;

	vector<SceneBodies::Grip> grips; ///< by body that moves: of all its contacts, at most
	Real                      contactLimit   = 0;
	bool                      enginesChecked = false;
	size_t                    bodiesChecked  = 0;

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(BodyContact,Serializable,"Effect: the ground pushes the bodies of the scene and is pushed by them, with friction. Spheres, boxes, "
			"facets, walls and clumps of them. In space they are met as they are, a facet as its triangle. In plane strain a sphere is a disc of its radius "
			"through the whole thickness, a box its section (its axis z stays z), a "
			"facet along z its edge, and walls or facets across z are not met. Put the engine behind ForceResetter and before NewtonIntegrator; the force on a body is "
			"O.forces.f(id). Sum of momentum over ground (in the plane per metre, times thickness) and bodies is conserved to round-off. Water does not "
			"cross into bodies, nor heat unless a BodyTemperature says so, and a body shades what it touches from air, rain and load on the free surface. "
			"What touches a body in the first step "
			"bears the stress that the ground was given, later contacts begin without force. Where O.dt is shorter than the ground's stable step, one step of "
			"the ground covers up to 100 of the bodies, its force spread evenly over them. Example: mpm.bodies=BodyContact(); "
			"O.bodies.append(utils.box((2,3,0),(1,0.5,0.5))); O.engines=[ForceResetter(),mpm,NewtonIntegrator(gravity=(0,-9.81,0))].",
		((Real,thickness,1,,"In plane strain: thickness of the slice of ground that the bodies meet [m], > 0 (in space 1): forces on them are those per metre "
				"times it. A body keeps its mass: a "
				"sphere of radius R weighs as much as its disc if this is 4R/3, a box if it is the box's edge along z. May be changed while running."))
		((Real,frictionAngle,NaN,,"Angle of friction between ground and bodies [deg], 0 or from 1.58 to below 90 (as in MohrCoulombSkeleton, while FrictMat of YADE "
				"has radians); NaN: that of each body's material. May be changed while running."))
		((Real,stiffness,NaN,,"Pressure over penetration of a contact [Pa/m], > 0, half of it along the surface; NaN: oedometer modulus of the stiffest point "
				"at the start over the grid spacing, so that a body sinks in as far as one cell of that ground gives way. Stiffer contacts shorten the time step."))
		((Real,damping,0.1,,"Viscous part of a contact over the critical one [-], in [0,1)."))
		((int,mask,0,,"Bodies with (body.mask & mask) != 0 are met; 0: all. May be changed while running."))
		((Real,ahead,0,Attr::hidden,"Time by which the ground is ahead of the scene [s]."))
		((vector<Real>,pending,,Attr::hidden,"Impulses not yet delivered: id, x, y, z [N s] and about x, y, z [N m s], seven numbers per body."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(BodyContact);

} // namespace yade
