// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/common/Box.hpp>
#include <pkg/common/Facet.hpp>
#include <pkg/common/Sphere.hpp>
#include <pkg/common/Wall.hpp>
#include <pkg/multiscale/bodies/BodyContact.hpp>

#include <limits>

namespace yade {
namespace {
	using InPlane = talik::RigidBody<2>;
	using InSpace = talik::RigidBody<3>;

	constexpr int  facetGroup = -2; // all facets are one surface: neighbours share edges
	constexpr Real outOfPlane = 1e-6;

	template <int D> talik::Vec<D> componentsOf(const Vector3r& v)
	{
		talik::Vec<D> c;
		for (int a = 0; a < D; ++a)
			c[a] = v[a];
		return c;
	}

	/// Angle about z; axes of a body that turned about z only lie in the plane.
	Real angleAboutZ(const Quaternionr& q) { return std::atan2(2 * (q.w() * q.z() + q.x() * q.y()), 1 - 2 * (q.y() * q.y() + q.z() * q.z())); }

	void pose(const State& state, InPlane& shown)
	{
		const Real angle = angleAboutZ(state.se3.orientation), c = std::cos(angle), s = std::sin(angle);
		shown.axes = { { { c, s }, { -s, c } } };
		shown.spin = { state.angVel[2] };
	}
	void pose(const State& state, InSpace& shown)
	{
		for (int a = 0; a < 3; ++a)
			shown.axes[a] = componentsOf<3>(state.se3.orientation * Vector3r::Unit(a));
		shown.spin = componentsOf<3>(state.angVel);
	}

	void turn(const InPlane& from, Real time, InPlane& to)
	{
		const Real angle = from.spin[0] * time, c = std::cos(angle), s = std::sin(angle);
		for (int a = 0; a < 2; ++a)
			to.axes[a] = { c * from.axes[a][0] - s * from.axes[a][1], s * from.axes[a][0] + c * from.axes[a][1] };
	}
	void turn(const InSpace& from, Real time, InSpace& to)
	{
		const Vector3r spin(from.spin[0], from.spin[1], from.spin[2]);
		const Real     speed = spin.norm();
		if (speed == 0) return;
		const Eigen::AngleAxis<Real> turned(speed * time, spin / speed);
		for (int a = 0; a < 3; ++a)
			to.axes[a] = componentsOf<3>(turned * Vector3r(from.axes[a][0], from.axes[a][1], from.axes[a][2]));
	}

	// Each returns why a surface cannot be met, or nothing; without a shape shown it is one that the ground does not meet.
	template <int D> string showSphere(const Body&, const Sphere& sphere, talik::RigidBody<D>& shown)
	{
		shown.shape = &talik::rigidBall<D>();
		shown.size.fill(sphere.radius);
		return "";
	}

	template <int D> string showBox(const Body& body, const Box& box, talik::RigidBody<D>& shown)
	{
		const Quaternionr& q = body.state->se3.orientation;
		if (D == 2 && (std::abs(q.x()) > outOfPlane || std::abs(q.y()) > outOfPlane))
			return "its axis z does not point along z, but ground in plane strain meets sections across z: turn boxes about z only, "
			       "blockedDOFs='zXY'";
		shown.shape = &talik::rigidBox<D>();
		shown.size  = componentsOf<D>(box.extents);
		return "";
	}

	string showWall(const Body&, const Wall& wall, InPlane& shown)
	{
		if (wall.axis == 2) return "";
		shown.shape = &talik::rigidPlane<2>();
		shown.side  = wall.sense;
		shown.axes  = wall.axis == 0 ? decltype(shown.axes) { { { 1, 0 }, { 0, 1 } } } : decltype(shown.axes) { { { 0, 1 }, { -1, 0 } } };
		return "";
	}
	string showWall(const Body&, const Wall& wall, InSpace& shown)
	{
		shown.shape = &talik::rigidPlane<3>();
		shown.side  = wall.sense;
		for (int a = 0; a < 3; ++a)
			shown.axes[a] = componentsOf<3>(Vector3r::Unit((wall.axis + a) % 3));
		return "";
	}

	/// Seen along z a facet is its edge.
	string showFacet(const Body& body, const Facet& facet, InPlane& shown)
	{
		const Se3r& at     = body.state->se3;
		Vector3r    normal = at.orientation * (facet.vertices[1] - facet.vertices[0]).cross(facet.vertices[2] - facet.vertices[0]);
		normal.normalize();
		if (std::abs(normal[2]) > 1 - 1e-3) return "";
		if (std::abs(normal[2]) > 1e-3) return "it is neither along nor across z, but ground in plane strain meets surfaces along z only";
		const Vector2r along = Vector2r(-normal[1], normal[0]).normalized();
		Real           low = std::numeric_limits<Real>::infinity(), high = -low;
		for (const Vector3r& vertex : facet.vertices) {
			const Vector3r corner = at.orientation * vertex;
			const Real     t      = corner[0] * along[0] + corner[1] * along[1];
			low                   = std::min(low, t);
			high                  = std::max(high, t);
		}
		const Vector3r corner = at.orientation * facet.vertices[0];
		const Vector2r foot   = Vector2r(corner[0], corner[1]) - (corner[0] * along[0] + corner[1] * along[1]) * along;
		shown.shape           = &talik::rigidPlate<2>();
		shown.size            = { 0, (high - low) / 2 };
		for (int a = 0; a < 2; ++a)
			shown.position[a] += foot[a] + (low + high) / 2 * along[a];
		shown.axes = { { { along[1], -along[0] }, { along[0], along[1] } } };
		return "";
	}
	string showFacet(const Body& body, const Facet& facet, InSpace& shown)
	{
		const Quaternionr& turned = body.state->se3.orientation;
		const Vector3r     first = turned * (facet.vertices[1] - facet.vertices[0]), second = turned * (facet.vertices[2] - facet.vertices[0]);
		const Vector3r     across = first.cross(second);
		if (!(across.norm() > 1e-12 * first.norm() * second.norm())) return "its corners lie on one line";
		const Vector3r normal = across.normalized(), along = first.normalized(), third = normal.cross(along);
		shown.shape           = &talik::rigidTriangle();
		shown.size            = { first.norm(), second.dot(along), second.dot(third) };
		const Vector3r corner = turned * facet.vertices[0];
		for (int a = 0; a < 3; ++a)
			shown.position[a] += corner[a];
		shown.axes = { componentsOf<3>(normal), componentsOf<3>(along), componentsOf<3>(third) };
		return "";
	}

	template <class Shape, int D>
	bool showAs(string (*how)(const Body&, const Shape&, talik::RigidBody<D>&), const Body& body, talik::RigidBody<D>& shown, string& reason)
	{
		const auto* shape = dynamic_cast<const Shape*>(body.shape.get());
		if (shape) reason = how(body, *shape, shown);
		return shape;
	}

	// the shapes that can be met; a new one adds its line
	template <int D> string showShape(const Body& body, talik::RigidBody<D>& shown)
	{
		string reason = "it is none of Sphere, Box, Wall, Facet or a clump of these";
		showAs<Sphere>(&showSphere<D>, body, shown, reason) || showAs<Box>(&showBox<D>, body, shown, reason)
		        || showAs<Wall, D>(&showWall, body, shown, reason) || showAs<Facet, D>(&showFacet, body, shown, reason);
		return reason;
	}

	template <int D> bool isFacet(const talik::RigidBody<D>& shown)
	{
		if constexpr (D == 2) return shown.shape == &talik::rigidPlate<2>();
		else return shown.shape == &talik::rigidTriangle();
	}

	template <int D> class InDimension final : public SceneBodies {
	public:
		explicit InDimension(talik::RigidContact<D>& contact)
		        : contact(contact)
		{}

		void clear() override
		{
			collected.clear();
			leverArms.clear();
		}

		string add(const Body& body, const std::function<Real(const Body&)>& friction) override
		{
			const State&        state = *body.state;
			talik::RigidBody<D> shown;
			shown.id       = body.id;
			shown.position = componentsOf<D>(state.se3.position);
			shown.velocity = componentsOf<D>(state.vel);
			pose(state, shown);
			const string reason = showShape<D>(body, shown);
			if (!reason.empty() || !shown.shape) return reason;
			shown.group    = body.clumpId >= 0 ? body.clumpId : isFacet<D>(shown) ? facetGroup : body.id;
			shown.friction = friction(body);
			// the shown surface turns with the body about the body's position
			talik::Vec<D> arm;
			for (int a = 0; a < D; ++a)
				arm[a] = shown.position[a] - state.se3.position[a];
			const talik::Vec<D> turning = talik::cross(shown.spin, arm);
			for (int a = 0; a < D; ++a)
				shown.velocity[a] += turning[a];
			leverArms.push_back(arm);
			collected.push_back(shown);
			return "";
		}

		void       show() override { contact.bodies = collected; }
		size_t     count() const override { return collected.size(); }
		Body::id_t id(size_t met) const override { return collected[met].id; }

		bool movesFreely(const State& state) const override
		{
			const unsigned directions = State::DOF_X | State::DOF_Y | (D == 3 ? State::DOF_Z : 0);
			return state.mass > 0 && (~state.blockedDOFs & directions);
		}

		Grip gripOn(size_t met) const override
		{
			const auto grip = contact.gripOn(collected[met]);
			return { grip.spring, grip.dashpot };
		}
		Real timeStep(Real mass, const Grip& grip) const override { return talik::RigidContact<D>::timeStep(mass, { grip.spring, grip.dashpot }); }

		Overlap deepestOverlap() const override
		{
			const auto overlap = contact.deepestOverlap();
			return { overlap.body, overlap.depth };
		}

		void place(Real time) override
		{
			for (size_t b = 0; b < collected.size(); ++b) {
				talik::RigidBody<D>& to = contact.bodies[b];
				for (int a = 0; a < D; ++a)
					to.position[a] = collected[b].position[a] + time * collected[b].velocity[a];
				turn(collected[b], time, to);
			}
		}

		Received take(size_t met) override
		{
			talik::RigidBody<D>& body = contact.bodies[met];
			const auto &         arm = leverArms[met], &p = body.impulse;
			Received             all;
			for (int a = 0; a < D; ++a)
				all.impulse[a] = p[a];
			for (int axis = D == 2 ? 2 : 0; axis < 3; ++axis) {
				const int i = (axis + 1) % 3, j = (axis + 2) % 3;
				all.angularImpulse[axis] = body.angularImpulse[D == 2 ? 0 : axis] + arm[i] * p[j] - arm[j] * p[i];
			}
			body.impulse        = {};
			body.angularImpulse = {};
			return all;
		}

	private:
		talik::RigidContact<D>&     contact;
		vector<talik::RigidBody<D>> collected;
		vector<talik::Vec<D>>       leverArms; ///< from the body's position to that of what is shown
	};
} // namespace

std::unique_ptr<SceneBodies> SceneBodies::of(talik::RigidContact<2>& contact) { return std::make_unique<InDimension<2>>(contact); }
std::unique_ptr<SceneBodies> SceneBodies::of(talik::RigidContact<3>& contact) { return std::make_unique<InDimension<3>>(contact); }

} // namespace yade
