// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Grid.hpp>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace talik {

constexpr double secondsPerDay = 86400;

/// A value that changes with time: piecewise linear between the given instants, constant before the first and after the last.
class TimeTable {
public:
	TimeTable(double constant = 0.0)
	        : times_ { 0.0 }
	        , values_ { constant }
	{}
	/// times [s] strictly increasing, as many as values; checked by validate().
	TimeTable(std::vector<double> times, std::vector<double> values)
	        : times_(std::move(times))
	        , values_(std::move(values))
	{}

	double at(double time) const;
	bool   isZero() const;

	/// Throws std::invalid_argument naming owner if the table is empty, not finite or its instants do not increase.
	void validate(const std::string& owner) const;

	const std::vector<double>& times() const { return times_; }
	const std::vector<double>& values() const { return values_; }

private:
	std::vector<double> times_;
	std::vector<double> values_;
};

/// One side of the grid's box.
struct Side {
	int  axis  = 0;     ///< 0 = x, 1 = y, 2 = z
	bool upper = false; ///< false: lower side
};

/// In the plane "left", "right" (x), "bottom", "top" (y); in space "left", "right" (x), "front", "back" (y), "bottom", "top" (z): the last
/// axis points upwards. Throws std::invalid_argument for other names.
Side                     sideFromName(const std::string& name, int dimensions);
std::string              nameOf(const Side& side, int dimensions);
std::vector<std::string> sideNames(int dimensions);

/// Where a boundary condition acts: on a side of the grid's box, on the moving free surface of the ground as far as the air outside
/// reaches it, on the surface of cavities inside the ground, on all nodes inside a box, or where the ground faces rigid bodies, wherever they
/// are; the first three may be limited to a box.
template <int D> struct Region {
	enum class Kind { side, freeSurface, nodeBox, bodies };

	Kind             kind = Kind::side;
	Side             on {};
	bool             round    = false; ///< nodeBox: the ellipse (ellipsoid) that fits into the box, in place of the box
	bool             cavities = false; ///< freeSurface: of hollows that no air from outside reaches, in place of the rest
	std::vector<int> ids {};           ///< bodies: their numbers, or those of their groups
	Vec<D>           boxLower = filled(-std::numeric_limits<double>::infinity()); ///< [m]
	Vec<D>           boxUpper = filled(std::numeric_limits<double>::infinity());  ///< [m]

	static Region side(const std::string& name) { return { Kind::side, sideFromName(name, D) }; }
	static Region freeSurface() { return { Kind::freeSurface }; }
	static Region cavitySurface() { return { Kind::freeSurface, {}, false, true }; }
	static Region nodeBox(const Vec<D>& lower, const Vec<D>& upper) { return Region { Kind::nodeBox }.within(lower, upper); }
	static Region disc(const Vec<D>& lower, const Vec<D>& upper) { return Region { Kind::nodeBox, {}, true }.within(lower, upper); }
	static Region facing(const std::vector<int>& bodies) { return { Kind::bodies, {}, false, false, bodies }; }
	/// The same region limited to a box [m].
	Region within(const Vec<D>& lower, const Vec<D>& upper) const { return { kind, on, round, cavities, ids, lower, upper }; }

	bool        holds(const Vec<D>& x, double tolerance) const;
	std::string describe() const;

	static Vec<D> filled(double value)
	{
		Vec<D> v;
		v.fill(value);
		return v;
	}
};

/// A node of a surface and the part of the surface that belongs to it.
template <int D> struct SurfaceNode {
	int    node;
	Vec<D> area; ///< outward area vector [m^(D-1)]
};

/// Heat that enters through a surface per unit area: flux + coefficient (ambient - T_surface).
struct SurfaceHeat {
	double flux        = 0.0;   ///< into the ground [W/m^2]
	double coefficient = 0.0;   ///< [W/(m^2 K)]; prescribed surface temperature: atSurface = true instead
	double ambient     = 0.0;   ///< [degC]
	bool   atSurface   = false; ///< ambient is the temperature of the surface itself: coefficient = 4 kappa f_T/h of the ground there
};

/// Mechanical conditions on nodes, collected once from all boundaries.
template <int D> class MotionConstraints {
public:
	MotionConstraints() = default;
	explicit MotionConstraints(const Grid<D>& grid);

	/// From here on nodes and ghosts are those of this moving wall, counted from 0, or (-1) of walls at rest.
	void beginWall(int moving) { wall_ = moving; }
	/// v_s along axis is that of the wall. Nodes of several walls take the velocity of the one that moves, of the last if several do.
	void fixSolid(int node, int axis);
	/// v_l = v_s along axis (impermeable); 0 where the solid is fixed.
	void tieLiquid(int node, int axis) { flags_[node] |= bit(axis, 1); }
	/// The liquid may cross: undoes tieLiquid of other boundaries along axis.
	void releaseLiquid(int node, int axis) { flags_[node] |= bit(axis, 2); }
	/// The same on all nodes of a side and on the ghost nodes behind them.
	void releaseLiquid(const Grid<D>& grid, const Region<D>& side);
	/// Ghost node behind a wall mirrors the node in front of it, per component and relative to the wall, eq. (8.4). The wall node lies
	/// in the middle between the two.
	void mirror(int ghost, int inner, const Vec<D>& sign);

	bool solidFixed(int node, int axis) const { return flags_[node] & bit(axis, 0); }
	bool liquidTied(int node, int axis) const { return (flags_[node] & bit(axis, 1)) && !(flags_[node] & bit(axis, 2)); }

	struct Mirror {
		int    ghost, inner;
		Vec<D> sign;
		int    moving = -1; ///< number of the moving wall, -1: at rest
		Vec<D> velocity {}; ///< of the wall at the start of the step [m/s]
		Vec<D> change {};   ///< of this velocity in the step [m/s]
		double lead = 0.0;  ///< lambda of eq. (8.5), of a moving wall that has left its nodes
		int    wall() const { return (ghost + inner) / 2; }
		/// What mirroring adds to the ghost's quantity that the wall has with this value per mass.
		double added(int axis, double ofWall) const { return (1.0 - sign[axis]) * ofWall; }
	};
	const std::vector<Mirror>& mirrors() const { return mirrors_; }
	/// A component of a node that has the velocity of a moving wall.
	struct Carried {
		int node, axis, moving;
		int inner = -1; ///< node in front of the wall, -1: a box of nodes has none
	};
	const std::vector<Carried>& carried() const { return carried_; }
	/// Nodes with any condition, ascending.
	const std::vector<int>& constrainedNodes() const { return constrained_; }
	void                    close();

private:
	static unsigned             bit(int axis, int kind) { return 1u << (3 * axis + kind); }
	std::vector<unsigned short> flags_;
	std::vector<Mirror>         mirrors_;
	std::vector<int>            constrained_;
	std::vector<Carried>        carried_;
	int                         wall_ = -1;
};

/// Nodes with prescribed temperature, collected once from all boundaries.
struct TemperatureNode {
	int node;
	int ghost;    ///< node behind the wall, or -1
	int inner;    ///< node in front of the wall, or -1
	int axis;     ///< normal of the wall
	int boundary; ///< index of the boundary that prescribes
};

/// State of the nodes of a boundary that asks for it, in this step; only those that have ground.
template <int D> struct BoundaryNodes {
	std::size_t         slots = 0;   ///< nodes of the surface or volume of the boundary, those without ground included; of this rank
	std::vector<int>    slot;        ///< which of them a node is; -1 for one that another rank computes
	std::vector<Vec<D>> position;    ///< [m]
	std::vector<Vec<D>> normal;      ///< outward, of unit length; empty in a volume
	std::vector<Vec<D>> velocity;    ///< of the grains, at the beginning of the step [m/s]; empty in ground at rest
	std::vector<double> temperature; ///< [degC]; empty in ground without heat
	std::vector<double> pressure;    ///< of pore water [Pa]; empty in ground without
	double              time = 0.0;  ///< of the calendar at the end of the step [s]
};

/// A condition on part of the surface of the ground. A new one is a class in the files of its kind that overrides what it needs;
/// see "How to add a boundary" in pkg/mpm/how-to.md.
template <int D> class Boundary {
public:
	virtual ~Boundary() = default;

	const std::string& name() const { return name_; }
	/// Effect that must be present: "motion", "heat" or "water"; "": it acts on any.
	const std::string& effect() const { return effect_; }
	/// Throws std::invalid_argument naming attribute, value and remedy.
	virtual void validate(const Grid<D>& grid) const;

	const Region<D>& region() const { return region_; }

	virtual void constrainMotion(const Grid<D>&, MotionConstraints<D>&) const {}
	/// True if it joins its side with the opposite one.
	virtual bool joinsSides() const { return false; }
	/// True if its nodes have a prescribed velocity other than zero, velocity(time) [m/s].
	virtual bool   moves() const { return false; }
	virtual Vec<D> velocity(double) const { return Vec<D> {}; }
	/// Path that has led the wall to where it stands at the start [m].
	virtual Vec<D> pathBefore() const { return Vec<D> {}; }
	/// Part of a path of the wall that leads it away from its nodes [m].
	virtual double away(const Vec<D>& path) const;
	/// Part of a path of the wall that leads it from its side into the ground [m]; a box of nodes has no such direction.
	virtual double ahead(const Vec<D>& path) const;

	/// True if the boundary prescribes the temperature of nodes.
	virtual bool prescribesTemperature() const { return false; }
	/// Prescribed nodal temperature at a time [degC].
	virtual double temperature(double) const { return 0.0; }

	/// Force per area on the surface with the given outward unit normal [Pa].
	virtual Vec<D> traction(double, const Vec<D>&) const { return Vec<D> {}; }
	virtual bool   loads() const { return false; }
	/// Heat through the surface.
	virtual SurfaceHeat heat(double) const { return {}; }
	virtual bool        heats() const { return false; }
	/// True if heat is produced in the volume of a box or disc, power(time) [W/m^3] of ground.
	virtual bool   producesHeat() const { return false; }
	virtual double power(double) const { return 0.0; }
	/// True if water may cross the surface; pressure outside is pressure(time) [Pa].
	virtual bool   drains() const { return false; }
	virtual double pressure(double) const { return 0.0; }
	/// False: water only leaves.
	virtual bool recharges() const { return true; }
	/// True if water enters at a prescribed rate inflow(time) [m/s], with a temperature [degC] of its own or (NaN) that of the ground.
	virtual bool   feeds() const { return false; }
	virtual double inflow(double) const { return 0.0; }
	virtual double inflowTemperature() const { return std::numeric_limits<double>::quiet_NaN(); }

	/// True if what it gives follows the state of each node: evaluate() comes before heat and loads in each step.
	virtual bool usesNodes() const { return false; }
	virtual void evaluate(const BoundaryNodes<D>&) {}
	/// Of what came of it, where that may differ between ranks that see the same.
	virtual std::uint64_t digest() const { return 0; }
	/// What it gives to node k of its surface or volume.
	virtual SurfaceHeat heatAt(double time, std::size_t) const { return heat(time); }
	virtual double      temperatureAt(double time, std::size_t) const { return temperature(time); }
	virtual double      powerAt(double time, std::size_t) const { return power(time); }
	virtual Vec<D>      tractionAt(double time, const Vec<D>& normal, std::size_t) const { return traction(time, normal); }
	/// True if it accelerates the mass of nodes in a box or disc, by accelerationAt(k) [m/s^2].
	virtual bool   accelerates() const { return false; }
	virtual Vec<D> accelerationAt(std::size_t) const { return Vec<D> {}; }

	/// The boundary acts in the volume of a box or disc, by the share of each node that lies in it.
	bool takesVolumes() const { return prescribesTemperature() || producesHeat() || accelerates(); }
	/// The nodal areas of the region are needed in each step.
	bool usesSurface() const { return loads() || heats() || drains() || feeds(); }

protected:
	Boundary(const Region<D>& region, const char* name, const char* effect)
	        : region_(region)
	        , name_(name)
	        , effect_(effect)
	{}
	bool onSide() const { return region_.kind == Region<D>::Kind::side; }
	/// From a node on its side to the one in front of it.
	int inward(const Grid<D>& grid) const { return region_.on.upper ? -grid.nodeStride(region_.on.axis) : grid.nodeStride(region_.on.axis); }
	/// Throws with this remedy unless its region is possible.
	void requireRegion(bool possible, const char* remedy) const;
	/// Throws unless all temperatures lie between -100 and 100 degC.
	void requireTemperatures(const TimeTable& temperature) const;

	Region<D> region_;

private:
	std::string name_, effect_;
};

/// A node and the share of its shape function's integral that lies in a region.
struct NodeShare {
	int    node;
	double share; ///< in (0, 1]
};

/// Shares of the nodes in a box or disc that is not flat; nodes without share are left out. Empty for other regions.
template <int D> std::vector<NodeShare> nodeShares(const Grid<D>& grid, const Region<D>& region);

/// Nodes of a region as they stand on the grid (sides and node boxes): on a side the nodes of the wall line.
template <int D> std::vector<int> wallNodes(const Grid<D>& grid, const Region<D>& region);

} // namespace talik
