// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/mpm/effects/RigidContact.hpp>
#include <pkg/mpm/front/ThawFront.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace talik {

namespace {
	// ground laid against a body touches it, give or take round-off
	constexpr double laidAgainst = 1.01;

	/// work(node, S) for the nodes of the face of a point, see ShapeFunction::moveToFace. Leaves the weights of the face in w.
	template <int D, class Work>
	void overFace(
	        const Grid<D>& grid, const ShapeFunction<D>& shape, const MaterialPoints<D>& points, int p, const Vec<D>& toFace, WeightBlock<D>& w,
	        Work&& work)
	{
		shape.evaluate(grid, points.positions(), p, 1, w);
		shape.moveToFace(grid, toFace, 0, w);
		overNodes<D>(w, 0, [&](int node, double s, const Vec<D>&) { work(node, s); });
	}

	/// Largest step of a mass on a spring with a dashpot, stepped by symplectic Euler: k dt^2/m + 2 c dt/m < 4. A body and two contacts
	/// of a point share the four. Never more than half of what the spring alone would stand.
	double stepOf(double mass, double spring, double dashpot)
	{
		constexpr double share = 1.2;
		return std::min(std::sqrt(mass / spring), (std::sqrt(dashpot * dashpot + share * spring * mass) - dashpot) / spring);
	}
} // namespace

void RigidContactSettings::validate() const
{
	requireSetting(
	        std::isnan(stiffness) || (std::isfinite(stiffness) && stiffness > 0.0), "BodyContact.stiffness", stiffness,
	        "must be positive, in Pa/m; NaN: chosen");
	requireSetting(shearRatio > 0.0 && shearRatio <= 1.0, "BodyContact.shearRatio", shearRatio, "must lie in (0, 1]");
	requireSetting(damping >= 0.0 && damping < 1.0, "BodyContact.damping", damping, "must lie in [0, 1)");
}

template <int D>
RigidContact<D>::RigidContact(PointFields& fields, const RigidContactSettings& settings)
        : settings_(settings)
        , stiffness_(settings.stiffness)
{
	fields.declare("bodyContact", "bodies", "-, m", memory_);
}

template <int D> void RigidContact<D>::bind(MaterialPoints<D>& points, const SolidMotion<D>& motion)
{
	points_   = &points;
	velocity_ = motion.velocity;
	mass_     = motion.mass;
	motion_   = &motion;
}

template <int D> void RigidContact<D>::chooseStiffness(double modulus, double spacing)
{
	if (std::isnan(settings_.stiffness)) stiffness_ = modulus / spacing;
	for (int p = 0; p < points_->count(); ++p) {
		largestSize_        = std::max(largestSize_, 2.0 * halfSize(p));
		largestMassPerArea_ = std::max(largestMassPerArea_, mass_[p] / area(p));
	}
}

template <int D> double RigidContact<D>::halfSize(int p) const
{
	const double volume = points_->volume()[p];
	return 0.5 * (D == 2 ? std::sqrt(volume) : std::cbrt(volume));
}

template <int D> double RigidContact<D>::area(int p) const { return points_->volume()[p] / (2.0 * halfSize(p)); }

template <int D> double RigidContact<D>::dashpot(double spring, double mass) const { return 2.0 * settings_.damping * std::sqrt(spring * mass); }

template <int D> double RigidContact<D>::timeStep(int p) const
{
	const double spring = stiffness_ * area(p);
	return stepOf(mass_[p], spring, dashpot(spring, mass_[p]));
}

template <int D> typename RigidContact<D>::Grip RigidContact<D>::gripOn(const RigidBody<D>& body) const
{
	const Vec<D> reach = body.shape->reach(body.size);
	const double width = std::max(largestSize_, 2.0 * *std::max_element(reach.begin(), reach.end()));
	const double area  = D == 2 ? width : width * width;
	return { stiffness_ * area, area * dashpot(stiffness_, largestMassPerArea_) };
}

template <int D> double RigidContact<D>::timeStep(double mass, const Grip& grip) { return stepOf(mass, grip.spring, grip.dashpot); }

template <int D> typename RigidContact<D>::Memory RigidContact<D>::recall(int p, int slot) const
{
	double* const* from = memory_.data() + slot * memorySize;
	Memory         m;
	m.key    = int(from[0][p]);
	m.radius = from[1][p];
	for (int a = 0; a < D; ++a) {
		m.anchor[a] = from[2 + a][p];
		m.offset[a] = from[2 + D + a][p];
	}
	return m;
}

template <int D> void RigidContact<D>::remember(int p, int slot, const Memory& m)
{
	double* const* to = memory_.data() + slot * memorySize;
	to[0][p]          = m.key;
	to[1][p]          = m.radius;
	for (int a = 0; a < D; ++a) {
		to[2 + a][p]     = m.anchor[a];
		to[2 + D + a][p] = m.offset[a];
	}
}

template <int D> void RigidContact<D>::findNear(int first, int count, double reach, std::vector<int>& near) const
{
	Vec<D> low, high;
	double margin = 0.0;
	for (int a = 0; a < D; ++a) {
		const double* x = points_->position(a) + first;
		low[a]          = *std::min_element(x, x + count);
		high[a]         = *std::max_element(x, x + count);
	}
	for (int p = first; p < first + count; ++p) {
		margin = std::max(margin, reach * halfSize(p));
		for (int slot = 0; slot < contactsPerPoint; ++slot) // what is touched already may be farther
			if (memory_[slot * memorySize][p] != 0.0) margin = std::max(margin, memory_[slot * memorySize + 1][p]);
	}
	near.clear();
	for (std::size_t b = 0; b < bodies.size(); ++b) {
		bool apart = false;
		for (int a = 0; a < D; ++a)
			apart = apart || low[a] - margin > upper_[b][a] || high[a] + margin < lower_[b][a];
		if (!apart) near.push_back(int(b));
	}
}

template <int D> bool RigidContact<D>::meets(int p, int b, const Memories& before, Candidate& c) const
{
	const RigidBody<D>& body  = bodies[b];
	const Vec<D>        x     = points_->at(p);
	const Vec<D>        local = body.toFrame(x);
	c.body                    = b;
	c.memory                  = {};
	for (const Memory& m : before)
		if (std::abs(m.key) == body.id + 1) c.memory = m;
	const bool thin = body.shape->thin(), known = c.memory.key != 0;
	c.side    = !thin ? 1 : known ? (c.memory.key > 0 ? 1 : -1) : body.side != 0 ? body.side : local[0] < 0.0 ? -1 : 1;
	c.surface = body.shape->nearest(local, body.size, c.side);
	if (known && c.memory.radius > c.surface.distance) return true;
	// a new contact; behind a surface that pushes on one side only nothing is felt
	const double size = halfSize(p) * (atStart_ ? laidAgainst : 1.0);
	if (c.surface.distance >= size || (thin && c.surface.distance < -size)) return false;
	double radius = 0.0;
	for (const Memory& m : before)
		if (m.key != 0 && std::abs(m.key) != body.id + 1) radius = std::max(radius, m.radius);
	c.memory        = {};
	c.memory.radius = radius > 0.0 ? radius : c.surface.distance;
	return c.memory.radius >= c.surface.distance;
}

template <int D> void RigidContact<D>::keepDeepest(const Candidate& c, Candidates& found, int& count) const
{
	int at = 0;
	while (at < count && bodies[found[at].body].group != bodies[c.body].group)
		++at;
	if (at == count && count < contactsPerPoint) {
		found[count++] = c;
		return;
	}
	if (at == count)
		for (int k = at = 0; k < count; ++k)
			if (found[k].surface.distance > found[at].surface.distance) at = k;
	if (c.surface.distance < found[at].surface.distance) found[at] = c;
}

template <int D> void RigidContact<D>::press(int p, Candidate& c, double dt, std::vector<Touch>& touches) const
{
	const RigidBody<D>& body   = bodies[c.body];
	const Vec<D>        normal = body.turned(c.surface.normal), x = points_->at(p);
	const Vec<D>        touched  = x - c.surface.distance * normal;
	const Vec<D>        arm      = touched - body.position;
	const Vec<D>        slipping = ofPoint<D>(velocity_, p) - body.velocity - cross(body.spin, arm);

	const double spring  = stiffness_ * area(p);
	const double dashpot = this->dashpot(spring, mass_[p]);
	if (atStart_ && c.memory.key == 0) c.memory.radius += std::max(0.0, pressureOn(p, normal)) / stiffness_;
	// normal force, eq. (22.1)
	const double depth    = c.memory.radius - c.surface.distance;
	const double pressing = std::max(0.0, spring * depth - dashpot * dot<D>(slipping, normal));

	Memory& m = c.memory;
	if (m.key == 0) {
		m.key    = c.side * (body.id + 1);
		m.anchor = body.toFrame(touched);
		m.offset = x - touched;
	}
	const auto   alongSurface = [&](const Vec<D>& v) { return v - dot<D>(v, normal) * normal; };
	const Vec<D> anchor       = body.position + body.turned(m.anchor);
	const double shear        = settings_.shearRatio * spring;
	Vec<D>       friction     = -shear * alongSurface(x - anchor - m.offset) - std::sqrt(settings_.shearRatio) * dashpot * alongSurface(slipping);
	const double most = body.friction * pressing, wanted = lengthOf<D>(friction);
	if (wanted > most) {
		friction = most / wanted * friction;
		m.anchor = body.toFrame(touched);
		m.offset = x - touched + 1.0 / shear * friction;
	}
	const Vec<D> onPoint = friction + pressing * normal, impulse = -dt * onPoint;
	touches.push_back({ p, onPoint, -halfSize(p) * normal, c.body, impulse, moment(arm, impulse) });
}

template <int D> void RigidContact<D>::pushPoint(int p, const std::vector<int>& near, double dt, std::vector<Touch>& touches)
{
	Memories before;
	for (int slot = 0; slot < contactsPerPoint; ++slot)
		before[slot] = recall(p, slot);
	Candidates found;
	Candidate  candidate;
	int        count = 0;
	for (int b : near)
		if (meets(p, b, before, candidate)) keepDeepest(candidate, found, count);
	for (int slot = 0; slot < contactsPerPoint; ++slot) {
		if (slot < count) press(p, found[slot], dt, touches);
		if (slot < count || before[slot].key != 0) remember(p, slot, slot < count ? found[slot].memory : Memory());
	}
}

/// Of the stress that the momentum balance uses.
template <int D> double RigidContact<D>::pressureOn(int p, const Vec<D>& normal) const
{
	double sum = motion_->addedStress ? motion_->addedStress[p] : 0.0;
	for (int i = 0; i < D; ++i)
		for (int j = 0; j < D; ++j)
			sum += normal[i] * motion_->stress[stressIndex<D>(i, j)][p] * normal[j];
	return -sum;
}

template <int D> void RigidContact<D>::boxBodies()
{
	lower_.resize(bodies.size());
	upper_.resize(bodies.size());
	for (std::size_t b = 0; b < bodies.size(); ++b) {
		const Vec<D> reach = bodies[b].shape->reach(bodies[b].size);
		for (int i = 0; i < D; ++i) {
			double half = 0.0;
			for (int a = 0; a < D; ++a)
				if (bodies[b].axes[a][i] != 0.0) half += std::abs(bodies[b].axes[a][i]) * reach[a];
			lower_[b][i] = bodies[b].position[i] - half;
			upper_[b][i] = bodies[b].position[i] + half;
		}
	}
}

/// All ranks come to know the contacts of all strips, which they sum up in one order.
template <int D> void RigidContact<D>::shareTouches(SlabDecomposition& slabs)
{
	std::string own;
	for (int s = slabs.firstStrip(); s < slabs.endStrip(); ++s) {
		const std::size_t count = touches_[s].size();
		own.append(reinterpret_cast<const char*>(&count), sizeof count);
		own.append(reinterpret_cast<const char*>(touches_[s].data()), count * sizeof(Touch));
	}
	std::string all;
	for (const std::string& part : slabs.say(own))
		all += part;
	const char* from = all.data();
	for (std::vector<Touch>& touches : touches_) {
		std::size_t count = 0;
		std::memcpy(&count, from, sizeof count);
		touches.resize(count);
		if (count > 0) std::memcpy(touches.data(), from + sizeof count, count * sizeof(Touch)); // no bytes into no array: undefined in C++
		from += sizeof count + count * sizeof(Touch);
	}
}

template <int D> void RigidContact<D>::deliver(Vec<D>& impulse)
{
	contacts_ = 0;
	for (const std::vector<Touch>& touches : touches_)
		for (const Touch& t : touches) {
			RigidBody<D>& body = bodies[t.body];
			++contacts_;
			body.impulse += t.impulse;
			body.angularImpulse += t.angularImpulse;
			impulse += -1.0 * t.impulse;
		}
}

template <int D>
void RigidContact<D>::push(
        const StepContext<D>& step, const ShapeFunction<D>& shape, bool atStart, NodeField<SolidMotion<D>::Record::size>& nodes, ThawFront<D>* front,
        Vec<D>& impulse)
{
	atStart_ = atStart;
	boxBodies();
	const Grid<D>& grid   = step.grid;
	const Strips&  strips = step.strips;
	touches_.resize(strips.count());
	near_.resize(strips.count());
	strips.scatter(
	        [&](int strip, int first, int last) {
		        std::vector<Touch>& touches = touches_[strip];
		        touches.clear();
		        WeightBlock<D> w;
		        for (int begin = first; begin < last; begin += blockSize) {
			        const int count = std::min(blockSize, last - begin);
			        findNear(begin, count, laidAgainst, near_[strip]);
			        for (int k = 0; k < count; ++k)
				        pushPoint(begin + k, near_[strip], step.dt, touches);
		        }
		        for (const Touch& t : touches) {
			        overFace<D>(grid, shape, *points_, t.place, t.toFace, w, [&](int node, double s) {
				        addTo<D>(nodes[node] + SolidMotion<D>::forceAt, s * t.force);
			        });
			        if (front) front->push(w, 0, t.force);
		        }
	        },
	        [&](HaloExchange& rows) {
		        rows.beyond = true;
		        rows.nodes(nodes);
		        if (front) front->shareMapped(grid, rows);
	        });
	if (step.slabs) shareTouches(*step.slabs);
	deliver(impulse);
}

template <int D> void RigidContact<D>::cover(const StepContext<D>& step, const ShapeFunction<D>& shape, FreeSurface<D>& surface) const
{
	points_->strips().scatter(
	        [&](int, int first, int last) {
		        WeightBlock<D> w;
		        for (int p = first; p < last; ++p)
			        for (int slot = 0; slot < contactsPerPoint; ++slot) {
				        if (memory_[slot * memorySize][p] == 0.0) continue;
				        const Memory m = recall(p, slot);
				        const auto   b = std::find_if(
				                  bodies.begin(), bodies.end(), [&](const RigidBody<D>& body) { return body.id + 1 == std::abs(m.key); });
				        if (b == bodies.end()) continue;
				        const NearestSurface<D> touched = b->shape->nearest(b->toFrame(points_->at(p)), b->size, m.key > 0 ? 1 : -1);
				        if (touched.distance > m.radius) continue;
				        const Vec<D> normal = b->turned(touched.normal);
				        const double face   = area(p);
				        overFace<D>(step.grid, shape, *points_, p, -halfSize(p) * normal, w, [&](int node, double s) {
					        addTo<D>(surface.nodes[node], s * face * normal);
				        });
			        }
	        },
	        [&](HaloExchange& rows) {
		        rows.beyond = true;
		        rows.nodes(surface.nodes);
	        });
}

template <int D> void RigidContact<D>::allocateFaces(const Grid<D>& grid) { faces_.allocate(grid.nodeCount()); }

template <int D> typename RigidContact<D>::Facing RigidContact<D>::faced(int p, const std::vector<int>& near, const std::vector<int>& ids) const
{
	const double size    = 2.0 * halfSize(p);
	double       nearest = size;
	Facing       found;
	const Vec<D> x = points_->at(p);
	for (int b : near) {
		const RigidBody<D>& body = bodies[b];
		if (std::none_of(ids.begin(), ids.end(), [&](int id) { return id == body.id || id == body.group; })) continue;
		const Vec<D>            local   = body.toFrame(x);
		const int               side    = !body.shape->thin() ? 1 : body.side != 0 ? body.side : local[0] < 0.0 ? -1 : 1;
		const NearestSurface<D> surface = body.shape->nearest(local, body.size, side);
		if (surface.distance >= nearest || (body.shape->thin() && surface.distance < -size)) continue;
		nearest = surface.distance;
		found   = { body.turned(surface.normal), area(p) * body.shape->areaWithin(std::max(0.0, surface.distance), body.size) };
	}
	return found;
}

template <int D>
void RigidContact<D>::collectFaces(const StepContext<D>& step, const ShapeFunction<D>& shape, const std::vector<int>& ids, SurfacePatch<D>& patch)
{
	const ActiveRange& range = step.halo;
	boxBodies();
	range.overNodes([&](int, int first, int last) { faces_.clear(first, last); });
	const Strips& strips = points_->strips();
	near_.resize(strips.count());
	strips.scatter(
	        [&](int strip, int first, int last) {
		        WeightBlock<D> w;
		        for (int begin = first; begin < last; begin += blockSize) {
			        const int count = std::min(blockSize, last - begin);
			        findNear(begin, count, 2.0, near_[strip]);
			        for (int p = begin; p < begin + count && !near_[strip].empty(); ++p) {
				        const Facing facing = faced(p, near_[strip], ids);
				        if (facing.area == 0.0) continue;
				        overFace<D>(step.grid, shape, *points_, p, -halfSize(p) * facing.normal, w, [&](int node, double s) {
					        faces_[node][0] += s * facing.area;
				        });
			        }
		        }
	        },
	        [&](HaloExchange& rows) {
		        rows.beyond = true;
		        rows.nodes(faces_);
	        });
	patch.nodes.clear();
	for (int node = range.firstNode; node < range.lastNode; ++node) {
		if (!(faces_[node][0] > 0.0)) continue;
		SurfaceNode<D> n { node, {} };
		n.area[0] = faces_[node][0];
		patch.nodes.push_back(n);
	}
}

template <int D> typename RigidContact<D>::Overlap RigidContact<D>::deepestOverlap() const
{
	Overlap deepest;
	for (std::size_t b = 0; b < bodies.size(); ++b) {
		if (bodies[b].shape->thin()) continue;
		for (int p = 0; p < points_->count(); ++p) {
			const Vec<D> x     = points_->at(p);
			const double depth = -bodies[b].shape->nearest(bodies[b].toFrame(x), bodies[b].size, 1).distance;
			if (depth > deepest.depth) deepest = { int(b), p, depth };
		}
	}
	return deepest;
}

TALIK_IN_PLANE_AND_SPACE(RigidContact);

} // namespace talik
