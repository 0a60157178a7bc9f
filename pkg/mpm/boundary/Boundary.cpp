// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/mpm/boundary/Boundary.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace talik {

namespace {
	template <int D> std::string text(const Vec<D>& v)
	{
		std::ostringstream out;
		out << "(";
		for (int a = 0; a < D; ++a)
			out << (a ? ", " : "") << v[a];
		out << ")";
		return out.str();
	}
} // namespace

Side sideFromName(const std::string& name, int dimensions)
{
	const std::vector<std::string> names = sideNames(dimensions);
	std::string                    known;
	for (int k = 0; k < 2 * dimensions; ++k) {
		if (name == names[k]) return { k / 2, k % 2 == 1 };
		known += (known.empty() ? "" : ", ") + names[k];
	}
	throw std::invalid_argument("side = '" + name + "': choose one of " + known);
}

std::vector<std::string> sideNames(int dimensions)
{
	if (dimensions == 2) return { "left", "right", "bottom", "top" };
	return { "left", "right", "front", "back", "bottom", "top" };
}

std::string nameOf(const Side& side, int dimensions) { return sideNames(dimensions)[2 * side.axis + (side.upper ? 1 : 0)]; }

template <int D> bool Region<D>::holds(const Vec<D>& x, double tolerance) const
{
	for (int a = 0; a < D; ++a)
		if (x[a] < boxLower[a] - tolerance || x[a] > boxUpper[a] + tolerance) return false;
	if (!round) return true;
	double sum = 0.0;
	for (int a = 0; a < D; ++a) {
		const double r = (2.0 * x[a] - boxLower[a] - boxUpper[a]) / (boxUpper[a] - boxLower[a] + 2.0 * tolerance);
		sum += r * r;
	}
	return sum <= 1.0;
}

template <int D> std::string Region<D>::describe() const
{
	if (kind == Kind::bodies) {
		std::string list = ids.size() == 1 ? "body" : "bodies";
		for (std::size_t k = 0; k < ids.size(); ++k)
			list += (k ? ", " : " ") + std::to_string(ids[k]);
		return list;
	}
	const bool  limited = std::isfinite(boxLower[0]) || std::isfinite(boxUpper[0]);
	std::string name    = kind == Kind::side ? "side " + nameOf(on, D)
	           : kind == Kind::freeSurface   ? (cavities ? "surface of cavities" : "free surface")
	           : round                       ? (D == 2 ? "disc" : "ball")
	                                         : "node box";
	if (limited) name += " within " + text<D>(boxLower) + " - " + text<D>(boxUpper);
	return name;
}

template <int D>
MotionConstraints<D>::MotionConstraints(const Grid<D>& grid)
        : flags_(grid.nodeCount(), 0)
{}

template <int D> void MotionConstraints<D>::mirror(int ghost, int inner, const Vec<D>& sign)
{
	for (const Mirror& m : mirrors_)
		if (m.ghost == ghost && m.inner == inner) return;
	Mirror added;
	added.ghost  = ghost;
	added.inner  = inner;
	added.sign   = sign;
	added.moving = wall_;
	mirrors_.push_back(added);
}

template <int D> void MotionConstraints<D>::fixSolid(int node, int axis)
{
	const bool fixed = solidFixed(node, axis);
	flags_[node] |= bit(axis, 0);
	if (wall_ < 0) return;
	const auto same = [&](const Carried& c) { return c.node == node && c.axis == axis; };
	const auto held = fixed ? std::find_if(carried_.begin(), carried_.end(), same) : carried_.end();
	if (held != carried_.end()) held->moving = wall_;
	else {
		carried_.emplace_back();
		carried_.back().node   = node;
		carried_.back().axis   = axis;
		carried_.back().moving = wall_;
	}
}

template <int D> void MotionConstraints<D>::releaseLiquid(const Grid<D>& grid, const Region<D>& region)
{
	const Side side   = region.on;
	const int  inward = side.upper ? -grid.nodeStride(side.axis) : grid.nodeStride(side.axis);
	for (int node : wallNodes(grid, region)) {
		releaseLiquid(node, side.axis);
		releaseLiquid(node - inward, side.axis);
	}
}

template <int D> void MotionConstraints<D>::close()
{
	for (const Mirror& m : mirrors_)
		for (Carried& c : carried_)
			if (c.node == m.wall() && c.moving == m.moving && m.sign[c.axis] < 0.0) c.inner = m.inner;
	constrained_.clear();
	for (std::size_t n = 0; n < flags_.size(); ++n)
		if (flags_[n]) constrained_.push_back(int(n));
}

template <int D> void Boundary<D>::validate(const Grid<D>& grid) const
{
	const Region<D>& r = region_;
	for (int a = 0; a < D; ++a)
		requireSetting(
		        r.boxLower[a] <= r.boxUpper[a], name() + ".region", r.describe(), "the box must have lower corner <= upper corner, none of them NaN");
	if (r.kind == Region<D>::Kind::freeSurface || r.kind == Region<D>::Kind::bodies) return;
	if (r.round)
		for (int a = 0; a < D; ++a)
			requireSetting(
			        std::isfinite(r.boxLower[a]) && std::isfinite(r.boxUpper[a]) && r.boxLower[a] < r.boxUpper[a], name() + ".region", r.describe(),
			        std::string(D == 2 ? "a disc" : "a ball") + " needs lower and upper, and room between them");
	requireSetting(
	        !wallNodes(grid, r).empty() || (takesVolumes() && !nodeShares(grid, r).empty()), name() + ".region", r.describe(),
	        "holds no node of the grid; boxes must reach at least one node");
}

template <int D> void Boundary<D>::requireRegion(bool possible, const char* remedy) const
{
	requireSetting(possible, name_ + ".region", region_.describe(), remedy);
}

template <int D> void Boundary<D>::requireTemperatures(const TimeTable& temperature) const
{
	temperature.validate(name_ + ".temperature");
	for (double t : temperature.values())
		requireSetting(t > -100.0 && t < 100.0, name_ + ".temperature", t, "must lie between -100 and 100 degC");
}

template <int D> double Boundary<D>::away(const Vec<D>& path) const { return onSide() ? std::abs(path[region_.on.axis]) : lengthOf<D>(path); }

template <int D> double Boundary<D>::ahead(const Vec<D>& path) const
{
	return onSide() ? (region_.on.upper ? -path[region_.on.axis] : path[region_.on.axis]) : 0.0;
}

template <int D> std::vector<int> wallNodes(const Grid<D>& grid, const Region<D>& region)
{
	using Kind = typename Region<D>::Kind;
	std::vector<int> found;
	if (region.kind == Kind::freeSurface || region.kind == Kind::bodies) return found;
	const double tolerance = 1e-6 * grid.spacing();
	const int    wall      = region.on.upper ? grid.cells(region.on.axis) + 1 : 1;
	for (int index = 0; index < grid.nodeCount(); ++index) {
		const std::array<int, D> node = grid.nodeOf(index);
		if (region.kind == Kind::side && node[region.on.axis] != wall) continue;
		Vec<D> x;
		for (int a = 0; a < D; ++a) {
			x[a] = grid.nodePosition(a, node[a]);
			// ghost nodes at the ends of a side belong to its last node
			if (region.kind == Kind::side) x[a] = std::min(std::max(x[a], grid.lower()[a]), grid.upper()[a]);
		}
		if (region.holds(x, tolerance)) found.push_back(index);
	}
	return found;
}

template <int D> std::vector<NodeShare> nodeShares(const Grid<D>& grid, const Region<D>& region)
{
	using Kind = typename Region<D>::Kind;
	std::vector<NodeShare> found;
	if (region.kind != Kind::nodeBox) return found;
	constexpr int perCell = D == 2 ? 16 : 6, samples = 3 * perCell;
	for (int a = 0; a < D; ++a)
		if (!(region.boxUpper[a] - region.boxLower[a] > 1e-6 * grid.spacing())) return found;
	const auto spline = [](double x) {
		const double r = std::abs(x);
		return r < 0.5 ? 0.75 - r * r : r < 1.5 ? 0.5 * (1.5 - r) * (1.5 - r) : 0.0;
	};
	for (int index = 0; index < grid.nodeCount(); ++index) {
		const std::array<int, D> node = grid.nodeOf(index);
		Vec<D>                   at;
		bool                     near = true, inside = !region.round;
		for (int a = 0; a < D; ++a) {
			at[a]  = grid.nodePosition(a, node[a]);
			near   = near && at[a] > region.boxLower[a] - 1.5 * grid.spacing() && at[a] < region.boxUpper[a] + 1.5 * grid.spacing();
			inside = inside && at[a] >= region.boxLower[a] + 1.5 * grid.spacing() && at[a] <= region.boxUpper[a] - 1.5 * grid.spacing();
		}
		if (!near) continue;
		if (inside) {
			found.push_back({ index, 1.0 });
			continue;
		}
		double             all = 0.0, held = 0.0;
		std::array<int, D> k {};
		while (true) {
			double weight = 1.0;
			Vec<D> x;
			bool   there = true;
			for (int a = 0; a < D; ++a) {
				const double offset = (k[a] + 0.5) / perCell - 1.5;
				weight *= spline(offset);
				x[a]  = at[a] + offset * grid.spacing();
				there = there && x[a] > grid.lower()[a] && x[a] < grid.upper()[a];
			}
			weight *= grid.measureAt(x[0]);
			if (there) {
				all += weight;
				if (region.holds(x, 0.0)) held += weight;
			}
			int a = 0;
			while (a < D && ++k[a] == samples)
				k[a] = 0, ++a;
			if (a == D) break;
		}
		if (held > 0.0) found.push_back({ index, held / all });
	}
	return found;
}

double TimeTable::at(double time) const
{
	if (time <= times_.front()) return values_.front();
	if (time >= times_.back()) return values_.back();
	const auto        next = std::upper_bound(times_.begin(), times_.end(), time);
	const std::size_t i    = std::size_t(next - times_.begin());
	const double      s    = (time - times_[i - 1]) / (times_[i] - times_[i - 1]);
	return values_[i - 1] + s * (values_[i] - values_[i - 1]);
}

bool TimeTable::isZero() const
{
	return std::all_of(values_.begin(), values_.end(), [](double v) { return v == 0.0; });
}

void TimeTable::validate(const std::string& owner) const
{
	if (times_.empty() || times_.size() != values_.size())
		throw std::invalid_argument(
		        owner + ": table with " + std::to_string(times_.size()) + " times and " + std::to_string(values_.size())
		        + " values; give one value for each time, at least one");
	for (std::size_t i = 0; i < times_.size(); ++i) {
		if (!std::isfinite(times_[i]) || !std::isfinite(values_[i]))
			throw std::invalid_argument(owner + ": entry " + std::to_string(i) + " of the table is not finite; give finite times and values");
		if (i == 0 || times_[i] > times_[i - 1]) continue;
		std::ostringstream text;
		text << owner << ": entry " << i << " of the table is at " << times_[i] << " s, day " << times_[i] / secondsPerDay << ", the one before it at "
		     << times_[i - 1] << " s, day " << times_[i - 1] / secondsPerDay << "; times must increase";
		throw std::invalid_argument(text.str());
	}
}

template struct Region<2>;
template struct Region<3>;
TALIK_IN_PLANE_AND_SPACE(MotionConstraints);
TALIK_IN_PLANE_AND_SPACE(Boundary);
template std::vector<NodeShare> nodeShares<2>(const Grid<2>&, const Region<2>&);
template std::vector<NodeShare> nodeShares<3>(const Grid<3>&, const Region<3>&);
template std::vector<int>       wallNodes<2>(const Grid<2>&, const Region<2>&);
template std::vector<int>       wallNodes<3>(const Grid<3>&, const Region<3>&);

} // namespace talik
