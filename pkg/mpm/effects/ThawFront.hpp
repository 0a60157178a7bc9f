// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/boundary/Boundary.hpp>
#include <pkg/mpm/effects/NodeColumns.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/grid/ActiveRange.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/kernels/NodeLoops.hpp>
#include <pkg/mpm/points/AffineVelocity.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>
#include <pkg/mpm/StepLedger.hpp>

#include <optional>
#include <vector>

namespace talik {

/// Effect: ground that ice holds (F) and ground that it does not (T) have velocities of their own on the nodes that both reach, the
/// front nodes. With one velocity a thawed layer thinner than the reach of the shape functions moves with its frozen base.
///
/// The solved velocity of a node is that of both sides together. Here each side's balance without the other gives the velocity at
/// which it would move, eq. (20.1), and the force between the sides changes it: M_F d_F + M_T d_T = 0 are the corrections that the points of
/// each side see. At a front node with normal n (from F to T) and area A, both from sum_F V grad S,
///   normal:     the sides share their normal velocity where they press, R >= 0 being the reaction; they part when they move away from
///               each other faster than the unloading of R/A moves their surfaces, R/(A Z) with Z the impedance of the thawed points,
///               and are then held back by no more than the tension that the thawed points carry there. Thawed ground that rests on
///               frozen ground and loses volume shares its normal velocity both ways;
///   tangential: Coulomb friction and cohesion of the thawed ground in simple shear at the effective part of R, eq. (20.2), and no more than
///               what makes the tangential velocities equal; where the law of the thawed points states no strength, their shear stress at
///               the reaction in place of their own normal stress, eq. (20.2a).
/// To points whose law states no strength the jump [v] of the tangential velocity goes back as strain, eq. (20.3): the sample of the thawed
/// points decides the slip, and feels it. The liquid of a side jumps as far as drag takes it along within the step, eq. (20.1); temperature,
/// pressure and the velocity of the water through the grains have one value on a node.
/// Multi-field contact after Bardenhagen et al. (2000), with the friction taken from the points in place of a coefficient.
template <int D> class ThawFront {
public:
	using Mirrors = std::vector<typename MotionConstraints<D>::Mirror>;

	ThawFront(PointFields& fields, const ThawFrontSettings& settings);
	/// iceSaturation, waterMass, iceMass and porosity are whole arrays of the pore content; water may be null.
	void bind(
	        MaterialPoints<D>& points, const Grid<D>& grid, SolidMotion<D>& motion, PoreWater<D>* water, const double* iceSaturation,
	        const double* waterMass, const double* iceMass, const double* porosity);
	/// In ground that loses volume as it thaws: thawed ground that rests on frozen ground moves with it along the normal.
	void settleTogether() { settles_ = true; }
	/// Sides of all points at the start of the scene.
	void start(int first, int end);
	/// Only points of this part are used from now on; all others are zero and take no memory.
	void keepOnly(int firstPoint, int endPoint);

	/// Takes the sides of the points from their ice saturation and finds the front nodes. mirrors, in the order in which
	/// they are folded: a node and its mirror image belong together. freeLiquid: nodes where the sides move together, as the liquid of a
	/// ghost is not folded there.
	void find(const Grid<D>& grid, const ActiveRange& range, const Mirrors& mirrors, const std::vector<int>& freeLiquid);
	/// Points near the front are exceptions from the means of cells. In ground without water they keep their own values: what shears and dilates
	/// there would otherwise strain the rows beside it, and the normal force between the sides would swing. In saturated ground, whose pressure
	/// is that of cells, the frozen points of a cell whose thawed points have slid along the front have a mean of their own. What these strain is
	/// not strain of the frozen ones, which at thirty times their stiffness would answer with stress that the front then lacks. Sides that have
	/// not slid share their strain: thawed rows would not close again after a winter without the rest of their cell.
	void exceptFromMeans(CellMeans<D>& cells, int first, int last) const;
	/// True if there are front nodes in this step.
	bool present() const { return !nodes_.empty(); }
	int  nodeCount() const { return int(nodes_.size()); }

	/// Thawed points near the front among some places, ascending.
	const std::vector<int>& thawedNear(const std::vector<int>& places);
	/// Their tangent modulus [Pa], by place; to be set before gather().
	double* modulus() { return modulus_.data(); }
	/// Sets the strength of one, or that its law states none.
	void setStrength(int place, const std::optional<ShearStrength>& strength);

	/// Adds what the points of a block near the front bring to the front nodes; affine may be null.
	void map(const Grid<D>& grid, const WeightBlock<D>& w, const AffineVelocity<D>* affine);
	/// Adds a force [N] on point k of a block to the front nodes: one that the mapped stress does not contain.
	void push(const WeightBlock<D>& w, int k, const Vec<D>& force);
	/// Adds the weight of the frozen side; call before mirrors are folded.
	void addGravity();
	/// Gives the frozen side its part, by mass, of a surface load on a node [N]; call before mirrors are folded.
	void addLoad(int node, const Vec<D>& force);
	/// Corrections of the solved velocities; call when mirrors are folded and before they are unfolded. Books what the force between the
	/// sides takes from their slip, and what walls give to the sides apart.
	void solve(const MotionConstraints<D>& constraints, const Mirrors& mirrors, const ActiveRange& range, double dt, StepLedger<D>& ledger);
	/// Corrects velocity, displacement, position and displacement gradient of a block; affine may be null.
	void gather(const Grid<D>& grid, const WeightBlock<D>& w, double dt, const AffineVelocity<D>* affine);
	/// What map() and push() add to.
	void shareMapped(const Grid<D>& grid, SharedRows& rows);
	/// Adds the slip of points first .. last to their displacement gradient.
	void addSlip(int first, int last);
	/// Work of stress on the slip of points first .. last with the present stress [J]; after addSlip().
	double stressWork(int first, int last) const;
	/// Fastest velocity of either side at the front nodes, per axis [m/s].
	double fastest() const { return fastest_; }
	/// Correction of the velocity [m/s] with which a point of the given place moves at a node.
	const double* correction(int node, int place) const;

private:
	using Loops      = NodeLoops<D>;
	using Columns    = NodeColumns<D>;
	using Frozen     = typename Columns::Frozen;
	using Thawed     = typename Columns::Thawed;
	using Pores      = typename Columns::Pores;
	using Side       = typename Columns::Side;
	using Slip       = typename Columns::Slip;
	using SlipStrain = typename Columns::SlipStrain;
	/// Of the frozen side: mass, momentum, liquid mass, liquid momentum, force, volume, area vector; of the thawed: volume, mass, momentum, liquid
	/// mass, and volume times friction, cohesion, pore pressure, tangent modulus and total stress; in ground with water also the mass of water that
	/// fills it where its pores are full, the force of pore pressure, and the volume that nodes of thawed ground alone hold. Momenta contain those of
	/// affine velocities: the sides would otherwise hand them to each other in every step, and slide faster than friction lets them.
	static constexpr int massAt = Frozen::mass, momentumAt = Frozen::momentum, liquidMassAt = Frozen::liquidMass, liquidMomentumAt = Frozen::liquidMomentum,
	                     forceAt = Frozen::force, volumeAt = Frozen::volume, areaAt = Frozen::area, thawedVolumeAt = Thawed::at + Thawed::volume,
	                     thawedMassAt = Thawed::at + Thawed::mass, thawedMomentumAt = Thawed::at + Thawed::momentum,
	                     thawedLiquidMassAt = Thawed::at + Thawed::liquidMass, frictionAt = Thawed::at + Thawed::friction,
	                     cohesionAt = Thawed::at + Thawed::cohesion, pressureAt = Thawed::at + Thawed::pressure, modulusAt = Thawed::at + Thawed::modulus,
	                     stressAt = Thawed::at + Thawed::stress, fullMassAt = Pores::at + Pores::fullMass, poreForceAt = Pores::at + Pores::force,
	                     heldVolumeAt = Pores::at + Pores::heldVolume;
	/// Of each side, frozen first, what NodeColumns::Side names, then Slip and SlipStrain.
	static constexpr int velocityAt = Side::velocity, gainAt = Side::gain, liquidGainAt = Side::liquidGain, sideSize = Side::size;
	struct alignas(64) Record {
		double number[Pores::at + Pores::size];
	};
	struct alignas(64) Result {
		double number[SlipStrain::at + SlipStrain::size];
	};
	static constexpr int recordSize = sizeof(Record) / sizeof(double), resultSize = sizeof(Result) / sizeof(double);
	/// Both sides at a front node.
	struct Meeting {
		std::array<double, 2> solid {}, liquid {}; ///< masses of the frozen and the thawed side [kg]
		bool                  meets    = false;    ///< both have mass, and there is a direction between them
		bool                  inside   = false;    ///< the node lies in frozen ground, or next to it
		bool                  resting  = false;    ///< the thawed side lies on the frozen one and does not slide
		bool                  together = false;    ///< the sides have one normal velocity
		bool                  bound    = false;    ///< they have, here or at a node beside
		Vec<D>                normal {};           ///< from frozen to thawed
		double                area         = 0.0;  ///< [m^(D-1)]
		double                frozenVolume = 0.0;  ///< [m^D]
		double                follows      = 0.0;  ///< part of a jump of the solid that drag gives to the liquid within the step [-]
		std::array<double, 2> moved {};            ///< mass of a side that jumps: its solid, and its liquid as far as it follows [kg]
		double                reducedMass = 0.0;   ///< of these [kg]
		Vec<D>                jump {};             ///< velocity of the thawed side less that of the frozen one [m/s]
		Vec<D>                traction {};         ///< of the thawed points on the front [Pa]
		double                friction  = 0.0;     ///< of the thawed points [-]; larger than any where their law states no strength
		double                cohesion  = 0.0;     ///< [Pa]
		double                pressure  = 0.0;     ///< of pore water [Pa]
		double                impedance = 0.0;     ///< of the thawed points [Pa s/m]
		double                pressing  = 0.0;     ///< force along the normal that would give both the same acceleration [N]
		double                reaction  = 0.0;     ///< normal force between the sides [N]
		double                buoyancy  = 0.0;     ///< the part of it that still pore water of the thawed side would bear [N]
		double                held      = 0.0;     ///< part of the thawed volume that nodes of thawed ground alone hold [-]
		double                impulse   = 0.0;     ///< along the normal, on the thawed side [N s]
	};

	double*       record(int slot) { return records_[slot].number; }
	const double* record(int slot) const { return records_[slot].number; }
	double*       result(int slot) { return results_[slot].number; }
	const double* result(int slot) const { return results_[slot].number; }
	bool          near(int place) const { return near_[cell_[place]]; }
	bool          frozen(int place) const { return side_[place] != 0.0; }
	double        liquidMass(int place) const { return waterMass_[place] - iceMass_[place]; }
	void          updateSides(int first, int last);
	void          markCells(const Grid<D>& grid, int first, int last);
	void          markNodes(const ActiveRange& range, const Mirrors& mirrors, const std::vector<int>& freeLiquid);
	void          markNear();
	void          bringFrozen(int place, typename Loops::template Shares<Frozen>::Share& share) const;
	void          bringThawed(int place, typename Loops::template Shares<Thawed>::Share& share) const;
	void          bringPores(const WeightBlock<D>& w, int k, typename Loops::template Shares<Pores>::Share& share) const;
	void          fold(const Mirrors& mirrors, double dt);
	void          unfold(const Mirrors& mirrors, StepLedger<D>& ledger);
	bool          leads(const typename Mirrors::value_type& mirror) const;
	void          pushAhead(const Mirrors& mirrors, double dt);
	void          leadWalls(const Mirrors& mirrors, StepLedger<D>& ledger);
	double        followingLiquid(int node, double dt) const;
	double        jumpByDrag(int slot, int axis, double dt) const;
	void          prepare(int slot, const MotionConstraints<D>& constraints, double dt);
	bool          findFront(int slot, const MotionConstraints<D>& constraints);
	void          moveApart(int slot, const MotionConstraints<D>& constraints, double dt);
	void          takeThawedMeans(int slot, const MotionConstraints<D>& constraints);
	bool          rests(const Meeting& meeting, double dt) const;
	void          press(int slot, double dt);
	void          pressAsBeside(int slot, double dt);
	static double takenBy(const Meeting& m, const Vec<D>& shear, const Vec<D>& slip);
	static double passive(const Meeting& m, double opening, const Vec<D>& shear, const Vec<D>& slip);
	Vec<D>        areaAround(int node, const Vec<D>& own, const MotionConstraints<D>& constraints) const;
	static bool   statesStrength(const Meeting& meeting);
	double        fullMass(int place) const;
	double        frontShare(const WeightBlock<D>& w, int k) const;
	double        buoyancyOf(int slot) const;
	double        poreShare(int slot) const;
	double        effectiveReaction(int slot) const;
	double        strengthOf(int slot, double dt) const;
	double        strengthUnderRoof(const Meeting& meeting) const;
	Vec<D>        carriedShear(int slot, const Vec<D>& slip, double dt) const;
	double        slide(int slot, double dt);
	double        lackingPressure(const Meeting& meeting) const;
	void          correct(int slot);
	void          giveSlip(int slot);
	void          takeSlip(int place, double dt, const typename Loops::FrontSums& sums);
	void          lead(int place, double dt, const typename Loops::FrontSums& sums, double (&slip)[D][D]);

	template <class Work> void overBeside(int node, Work&& work) const;

	ThawFrontSettings          settings_;
	PointFields::Handle        sideField_, slipField_, ledField_, strainField_;
	SolidMotion<D>*            motion_        = nullptr;
	PoreWater<D>*              water_         = nullptr;
	MaterialPoints<D>*         points_        = nullptr;
	const double *             iceSaturation_ = nullptr, *waterMass_ = nullptr, *iceMass_ = nullptr, *porosity_ = nullptr;
	double*                    side_ = nullptr; ///< 1: held by ice, 0: thawed
	double*                    slip_ = nullptr; ///< path of the thawed ground along the front [m]
	double*                    led_  = nullptr; ///< sum of the strains that led the pressure of the point back [-]
	std::array<double*, D * D> strain_ {};      ///< slip of the step as displacement gradient
	bool                       settles_ = false;
	double                     fastest_ = 0.0;
	double                     spacing_ = 0.0;
	int                        margin_  = 0; ///< of the arrays by node below, so that a reach never leaves them

	PagedArray<int>                    cell_;      ///< by place: node at the lower corner of the point's cell, counted with the margin
	std::vector<unsigned char>         sides_;     ///< by that node: sides of the points in the cell
	std::vector<unsigned char>         slid_;      ///< by that node: its thawed points have slid along the front
	std::vector<unsigned char>         reached_;   ///< by node: sides that may reach it
	std::vector<unsigned char>         near_;      ///< by the lower node of a cell: its points reach front nodes
	std::vector<int>                   reach_;     ///< from a node to the lower nodes of the cells whose points may touch it
	std::vector<int>                   slot_;      ///< by node: place in the list of front nodes, or -1
	std::vector<int>                   nodes_;     ///< front nodes, ascending
	std::vector<int>                   rowStarts_; ///< place in it of the first node of each row
	std::vector<int>                   beside_;    ///< from a node to those around it and itself
	std::vector<double>                volume_;    ///< of full ground, by node
	std::vector<Meeting>               meetings_;
	std::vector<int>                   chosen_;
	PagedArray<double>                 modulus_, friction_, cohesion_; ///< by place, of thawed points near the front [Pa], [-], [Pa]
	std::vector<std::array<double, 4>> folded_;       ///< by mirror: masses that went from a ghost to its image, frozen, thawed, and their liquids [kg]
	PagedArray<double>                 mappedLiquid_; ///< by place, liquid mass of points near the front when it was mapped [kg]
	std::vector<Record>                records_;
	std::vector<Result>                results_;
	std::vector<Vec<D>>                normals_;         ///< by front node
	bool                               strains_ = false; ///< thawed points get slip as strain
	std::vector<double>                work_;
};

extern template class ThawFront<2>;
extern template class ThawFront<3>;

} // namespace talik
