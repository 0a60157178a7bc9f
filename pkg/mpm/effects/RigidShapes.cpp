// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/RigidContact.hpp>

#include <algorithm>
#include <limits>

namespace talik {

namespace {
	constexpr double infinity = std::numeric_limits<double>::infinity();

	/// Away from a place; along the first axis where the two coincide.
	template <int D> NearestSurface<D> awayFrom(const Vec<D>& offset, double radius)
	{
		const double      d = lengthOf<D>(offset);
		NearestSurface<D> s { d - radius, {} };
		if (d > 0.0) s.normal = offset / d;
		else s.normal[0] = 1.0;
		return s;
	}

	/// The side of a thin surface across the first axis.
	template <int D> NearestSurface<D> across(const Vec<D>& x, int side)
	{
		NearestSurface<D> s { side * x[0], {} };
		s.normal[0] = side;
		return s;
	}

	template <int D> class Ball final : public RigidShape<D> {
	public:
		std::string       name() const override { return "ball"; }
		NearestSurface<D> nearest(const Vec<D>& x, const Vec<D>& size, int) const override { return awayFrom<D>(x, size[0]); }
		Vec<D>            reach(const Vec<D>& size) const override
		{
			Vec<D> r;
			r.fill(size[0]);
			return r;
		}
		double areaWithin(double distance, const Vec<D>& size) const override
		{
			const double share = size[0] / (size[0] + distance);
			return D == 2 ? share : share * share;
		}
	};

	template <int D> class Box final : public RigidShape<D> {
	public:
		std::string       name() const override { return "box"; }
		NearestSurface<D> nearest(const Vec<D>& x, const Vec<D>& size, int) const override
		{
			Vec<D> beyond;
			int    face = 0;
			for (int a = 0; a < D; ++a) {
				beyond[a] = std::abs(x[a]) - size[a];
				if (beyond[a] > beyond[face]) face = a;
			}
			if (beyond[face] <= 0.0) {
				NearestSurface<D> s { beyond[face], {} };
				s.normal[face] = x[face] < 0.0 ? -1.0 : 1.0;
				return s;
			}
			Vec<D> offset;
			for (int a = 0; a < D; ++a)
				offset[a] = beyond[a] > 0.0 ? std::copysign(beyond[a], x[a]) : 0.0;
			return awayFrom<D>(offset, 0.0);
		}
		Vec<D> reach(const Vec<D>& size) const override { return size; }
	};

	template <int D> class Plane final : public RigidShape<D> {
	public:
		std::string       name() const override { return "plane"; }
		NearestSurface<D> nearest(const Vec<D>& x, const Vec<D>&, int side) const override { return across<D>(x, side); }
		Vec<D>            reach(const Vec<D>&) const override
		{
			Vec<D> r;
			r.fill(infinity);
			r[0] = 0.0;
			return r;
		}
		bool thin() const override { return true; }
	};

	template <int D> class Plate final : public RigidShape<D> {
	public:
		std::string       name() const override { return "plate"; }
		NearestSurface<D> nearest(const Vec<D>& x, const Vec<D>& size, int side) const override
		{
			Vec<D> offset {};
			bool   beside = false;
			offset[0]     = x[0];
			for (int a = 1; a < D; ++a) {
				const double beyond = std::abs(x[a]) - size[a];
				if (beyond <= 0.0) continue;
				offset[a] = std::copysign(beyond, x[a]);
				beside    = true;
			}
			return beside ? awayFrom<D>(offset, 0.0) : across<D>(x, side);
		}
		Vec<D> reach(const Vec<D>& size) const override
		{
			Vec<D> r = size;
			r[0]     = 0.0;
			return r;
		}
		bool thin() const override { return true; }
	};

	class Triangle final : public RigidShape<3> {
	public:
		std::string       name() const override { return "triangle"; }
		NearestSurface<3> nearest(const Vec<3>& x, const Vec<3>& size, int side) const override
		{
			const std::array<InPlane, 3> corners { { { 0.0, 0.0 }, { size[0], 0.0 }, { size[1], size[2] } } };
			const InPlane                at { x[1], x[2] };
			bool                         inside  = true;
			double                       nearest = infinity;
			Vec<3>                       offset {};
			for (int k = 0; k < 3; ++k) {
				const InPlane &from = corners[k], &to = corners[(k + 1) % 3];
				const InPlane  edge = to - from, way = at - from;
				inside               = inside && edge[0] * way[1] - edge[1] * way[0] >= 0.0; // corners run counter-clockwise
				const double  share  = dot<2>(edge, way) / dot<2>(edge, edge);
				const InPlane from0  = way - std::min(1.0, std::max(0.0, share)) * edge;
				const double  square = dot<2>(from0, from0);
				if (square < nearest) nearest = square, offset = { x[0], from0[0], from0[1] };
			}
			return inside ? across<3>(x, side) : awayFrom<3>(offset, 0.0);
		}
		Vec<3> reach(const Vec<3>& size) const override { return { 0.0, std::max({ size[0], std::abs(size[1]), size[2] }), size[2] }; }
		bool   thin() const override { return true; }

	private:
		using InPlane = std::array<double, 2>;
	};

	template <class Shape> const Shape& theOnly()
	{
		static const Shape shape;
		return shape;
	}
} // namespace

template <int D> const RigidShape<D>& rigidBall() { return theOnly<Ball<D>>(); }
template <int D> const RigidShape<D>& rigidBox() { return theOnly<Box<D>>(); }
template <int D> const RigidShape<D>& rigidPlane() { return theOnly<Plane<D>>(); }
template <int D> const RigidShape<D>& rigidPlate() { return theOnly<Plate<D>>(); }

const RigidShape<3>& rigidTriangle() { return theOnly<Triangle>(); }

template const RigidShape<2>& rigidBall<2>();
template const RigidShape<2>& rigidBox<2>();
template const RigidShape<2>& rigidPlane<2>();
template const RigidShape<2>& rigidPlate<2>();
template const RigidShape<3>& rigidBall<3>();
template const RigidShape<3>& rigidBox<3>();
template const RigidShape<3>& rigidPlane<3>();
template const RigidShape<3>& rigidPlate<3>();

} // namespace talik
