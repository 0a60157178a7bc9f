// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/mpm/effects/FreeSurface.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/grid/Vector.hpp>
#include <pkg/mpm/StepContext.hpp>
#include <string>
#include <vector>

namespace talik {

template <int D> class ThawFront;

/// Angular velocity or torque: about z in 2-D, a vector in 3-D.
template <int D> using Spin = Vec<D == 2 ? 1 : 3>;

/// omega x r.
inline Vec<2> cross(const Vec<1>& omega, const Vec<2>& r) { return { -omega[0] * r[1], omega[0] * r[0] }; }
inline Vec<3> cross(const Vec<3>& a, const Vec<3>& b) { return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] }; }
/// r x f.
inline Vec<1> moment(const Vec<2>& r, const Vec<2>& f) { return { r[0] * f[1] - r[1] * f[0] }; }
inline Vec<3> moment(const Vec<3>& r, const Vec<3>& f) { return cross(r, f); }

/// The part of a rigid surface that is nearest to a place, in the frame of the body.
template <int D> struct NearestSurface {
	double distance; ///< [m], negative inside
	Vec<D> normal;   ///< outward unit vector
};

/// A kind of rigid surface, in the frame of its body. It has no state: the measures are the body's. A new kind is one class in
/// RigidShapes.cpp, its line here and, for bodies of YADE, its line in BodyContact.cpp.
template <int D> class RigidShape {
public:
	virtual ~RigidShape() = default;

	virtual std::string name() const = 0;
	/// side: of a thin surface, the sign of the first coordinate on the side that pushes.
	virtual NearestSurface<D> nearest(const Vec<D>& x, const Vec<D>& size, int side) const = 0;
	/// Half edges of a box around the origin that holds the surface [m]; infinity where it has no end.
	virtual Vec<D> reach(const Vec<D>& size) const = 0;
	/// Area of the surface over that of the surface parallel to it at a distance [m].
	virtual double areaWithin(double distance, const Vec<D>& size) const
	{
		(void)distance, (void)size;
		return 1.0;
	}
	/// A surface without volume: a point stays on the side from which it came.
	virtual bool thin() const { return false; }
};

template <int D> const RigidShape<D>& rigidBall();  ///< size[0]: radius
template <int D> const RigidShape<D>& rigidBox();   ///< size: half edges
template <int D> const RigidShape<D>& rigidPlane(); ///< thin, without end; its normal is the first axis
template <int D> const RigidShape<D>& rigidPlate(); ///< thin; half edges size[1..], its normal is the first axis
/// Thin; its normal is the first axis, one corner is the origin, the others lie at size[0] on the second axis and at (size[1], size[2]) of
/// second and third, size[0] and size[2] > 0.
const RigidShape<3>& rigidTriangle();

/// A rigid body as the ground meets it. Forces and torques are those per metre of thickness in 2-D.
template <int D> struct RigidBody {
	int                  id    = -1; ///< >= 0, by which contacts remember it
	int                  group = -1; ///< bodies of one group are one surface: a point touches that of them in which it is deepest
	const RigidShape<D>* shape = nullptr;
	Vec<D>               size {};        ///< measures of the shape [m]
	int                  side     = 0;   ///< of a thin surface that pushes on one side only: the sign of that side; 0: both
	double               friction = 0.0; ///< tan phi between body and ground [-], >= 0

	Vec<D>                position {}; ///< [m]
	std::array<Vec<D>, D> axes {};     ///< unit vectors of the body's frame
	Vec<D>                velocity {}; ///< [m/s]
	Spin<D>               spin {};     ///< [rad/s]

	// received from the ground, added up until somebody takes it
	Vec<D>  impulse {};        ///< [N s]
	Spin<D> angularImpulse {}; ///< about the position [N m s]

	Vec<D> toFrame(const Vec<D>& x) const
	{
		Vec<D> local {};
		for (int a = 0; a < D; ++a)
			for (int i = 0; i < D; ++i)
				local[a] += axes[a][i] * (x[i] - position[i]);
		return local;
	}
	Vec<D> turned(const Vec<D>& local) const
	{
		Vec<D> v {};
		for (int a = 0; a < D; ++a)
			for (int i = 0; i < D; ++i)
				v[i] += axes[a][i] * local[a];
		return v;
	}
};

/// Effect: the ground and rigid bodies push each other, with friction.
///
/// Contact is between material points and surfaces. A point is as large as its volume, r = V^(1/D)/2, and is pushed by
///   f_n = A max(0, k delta - c v_n),  |f_t| <= mu f_n,  A = V^((D-1)/D),
/// where delta is its penetration and the tangential spring k_t = shearRatio k remembers where on the surface it sticks. The force
/// on a point goes to the nodes with the weights of the point's face, whose sum is one (see ShapeFunction::moveToFace), and its
/// opposite to the body: the ground is loaded as evenly as the points are, and momentum is conserved to round-off, on any grid and for bodies of any size, and
/// nothing is felt at a distance, as it would be were
/// velocities of body and ground matched on nodes (Bardenhagen et al. 2000). The torque on the body is that of the force at its
/// surface. The price: a penetration of stress over k, and a couple f_t r that the points, which do not turn, do not take.
///
/// A contact is born without force, except in the first step of the ground, when it bears the stress that the ground was given: a wall
/// is there from the beginning, and ground that leaned on it would else have to give way first. A point keeps its size while it
/// touches anything, so that it passes from one facet to the next without a jump. A point touches at most two groups of
/// bodies at a time, those in which it is deepest.
template <int D> class RigidContact {
public:
	static constexpr int contactsPerPoint = 2;

	RigidContact(PointFields& fields, const RigidContactSettings& settings);
	void bind(MaterialPoints<D>& points, const SolidMotion<D>& motion);
	/// Sets the stiffness that the settings leave open: modulus over h, the ground's own on one cell. modulus: largest in the ground [Pa].
	void chooseStiffness(double modulus, double spacing);

	/// What the ground can do to a body at most, by all the points that it touches at a time.
	struct Grip {
		double spring  = 0.0; ///< [N/m]
		double dashpot = 0.0; ///< [N s/m]
	};
	Grip gripOn(const RigidBody<D>& body) const;
	/// Largest stable time step of a free body [s]; mass [kg].
	static double timeStep(double mass, const Grip& grip);

	/// The bodies; whoever steps the ground puts them in their places before a step and takes the impulses after it.
	std::vector<RigidBody<D>> bodies;

	/// Adds the contact forces to the nodes and to the bodies' impulses, and their sum to impulse [N s].
	/// front, if not null, hears which of its sides was pushed. atStart: in the first step of the ground.
	void push(
	        const StepContext<D>& step, const ShapeFunction<D>& shape, bool atStart, NodeField<SolidMotion<D>::Record::size>& nodes, ThawFront<D>* front,
	        Vec<D>& impulse);

	/// Takes the faces that touch a body off the surface of the ground: no air, rain or load reaches them.
	void cover(const StepContext<D>& step, const ShapeFunction<D>& shape, FreeSurface<D>& surface) const;

	void allocateFaces(const Grid<D>& grid);
	/// Lists the nodes of the ground that faces the bodies of these ids or groups, with the area of the bodies' surface: of points whose
	/// middles lie nearer than they are wide. That is one layer of them, wherever the surface runs between them.
	void collectFaces(const StepContext<D>& step, const ShapeFunction<D>& shape, const std::vector<int>& ids, SurfacePatch<D>& patch);

	/// Only nodes [first, last) are used from now on; all others are zero and take no memory.
	void keepOnly(int first, int last) { faces_.keepOnly(first, last); }

	double stiffness() const { return stiffness_; } ///< k [Pa/m]
	int    contacts() const { return contacts_; }   ///< points that touch, in the last step
	/// Largest stable time step of the contact of the point at a place [s].
	double timeStep(int place) const;

	/// A point whose middle lies inside a body.
	struct Overlap {
		int    body  = -1; ///< index in bodies, -1: none
		int    place = -1;
		double depth = 0.0; ///< [m]
	};
	/// The deepest of them: to refuse bodies that are put into the ground.
	Overlap deepestOverlap() const;

private:
	/// What a point remembers of a contact.
	struct Memory {
		int    key    = 0;   ///< id + 1 of the body, with the sign of the side of a thin surface; 0: no contact
		double radius = 0.0; ///< of the point in this contact: contact is born without force [m]
		Vec<D> anchor {};    ///< where on the surface the point sticks, in the frame of the body [m]
		Vec<D> offset {};    ///< of the point from there when neither spring nor slip had moved it [m]
	};
	static constexpr int memorySize = 2 * D + 2;
	using Memories                  = std::array<Memory, contactsPerPoint>;

	struct Candidate {
		int               body = -1;
		int               side = 0;
		NearestSurface<D> surface {};
		Memory            memory;
	};
	using Candidates = std::array<Candidate, contactsPerPoint>;
	/// What a point receives at its face, and a body from it.
	struct Touch {
		int     place;
		Vec<D>  force, toFace; ///< on the ground [N]; from the point's middle to where it acts [m]
		int     body;
		Vec<D>  impulse;
		Spin<D> angularImpulse;
	};

	double halfSize(int place) const;
	double area(int place) const;
	double dashpot(double spring, double mass) const;
	Memory recall(int place, int slot) const;
	void   remember(int place, int slot, const Memory& memory);
	/// Bodies within reach of some points, in half sizes of a point.
	void findNear(int first, int count, double reach, std::vector<int>& near) const;
	/// Of the bodies near a point, what it faces of those named: the surface and the body's own area that belongs to the point [m^(D-1)].
	struct Facing {
		Vec<D> normal;
		double area = 0.0;
	};
	Facing faced(int place, const std::vector<int>& near, const std::vector<int>& ids) const;
	bool   meets(int place, int body, const Memories& before, Candidate& candidate) const;
	void   keepDeepest(const Candidate& candidate, Candidates& found, int& count) const;
	void   press(int place, Candidate& contact, double dt, std::vector<Touch>& touches) const;
	void   pushPoint(int place, const std::vector<int>& near, double dt, std::vector<Touch>& touches);
	double pressureOn(int place, const Vec<D>& normal) const;
	void   boxBodies();
	void   shareTouches(SlabDecomposition& slabs);
	void   deliver(Vec<D>& impulse);

	RigidContactSettings  settings_;
	double                stiffness_   = 0.0;
	double                largestSize_ = 0.0, largestMassPerArea_ = 0.0; ///< of a point at the start [m], [kg/m^(D-1)]
	MaterialPoints<D>*    points_   = nullptr;
	const double*         mass_     = nullptr;
	const SolidMotion<D>* motion_   = nullptr;
	bool                  atStart_  = false;
	int                   contacts_ = 0;

	std::array<double*, memorySize * contactsPerPoint> memory_ {};
	std::array<double*, D>                             velocity_ {};
	std::vector<Vec<D>>                                lower_, upper_; ///< boxes around the bodies
	std::vector<std::vector<Touch>>                    touches_;       ///< per strip
	std::vector<std::vector<int>>                      near_;          ///< per strip
	NodeField<1>                                       faces_;         ///< area of bodies that nodes face [m^(D-1)]
};

} // namespace talik
