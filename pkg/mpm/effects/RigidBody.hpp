// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Vector.hpp>

#include <string>

namespace talik {

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

} // namespace talik
