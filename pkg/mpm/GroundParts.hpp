// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// What a ground consists of; shared by the files that implement Ground.

#include <algorithm>
#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/mpm/Calendar.hpp>
#include <pkg/mpm/CostMeter.hpp>
#include <pkg/mpm/effects/AffineVelocity.hpp>
#include <pkg/mpm/effects/BBar.hpp>
#include <pkg/mpm/effects/DeformationRecord.hpp>
#include <pkg/mpm/effects/DividingPoints.hpp>
#include <pkg/mpm/effects/Effect.hpp>
#include <pkg/mpm/effects/FreeSurface.hpp>
#include <pkg/mpm/effects/HeatTransfer.hpp>
#include <pkg/mpm/effects/IceSegregation.hpp>
#include <pkg/mpm/effects/ImplicitPressure.hpp>
#include <pkg/mpm/effects/MappedBack.hpp>
#include <pkg/mpm/effects/MomentumSolver.hpp>
#include <pkg/mpm/effects/PoreContent.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/PositionCheck.hpp>
#include <pkg/mpm/effects/RigidContact.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/effects/StateDependentBoundaries.hpp>
#include <pkg/mpm/effects/StrainWork.hpp>
#include <pkg/mpm/effects/ThawedCompression.hpp>
#include <pkg/mpm/effects/ThawStrain.hpp>
#include <pkg/mpm/front/ThawFront.hpp>
#include <pkg/mpm/grid/NodeColumns.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/GroundRanks.hpp>
#include <pkg/mpm/points/CellMeans.hpp>
#include <pkg/mpm/points/ConcernedPoints.hpp>
#include <pkg/mpm/points/PointPasses.hpp>
#include <pkg/mpm/skeleton/SkeletonSet.hpp>
#include <pkg/mpm/StepContext.hpp>
#include <pkg/mpm/StepLedger.hpp>
#include <stdexcept>

#include <exception>
#include <functional>
#include <memory>

namespace talik {

/// Takes the place of an effect in code that is built without it: it is false at compile time, so that the compiler removes all that asks for it.
template <class T> struct AbsentEffect {
	AbsentEffect&      operator=(std::unique_ptr<T>) { return *this; }
	constexpr explicit operator bool() const { return false; }
	constexpr T*       get() const { return nullptr; }
	constexpr T*       operator->() const { return nullptr; }
	constexpr T&       operator*() const { return *get(); }
};

/// An effect that a scene may have; empty if it has not. With TALIK_DRY_GROUND the ground is built with motion alone:
/// scripts/bench compares with it what effects cost that are switched off.
#ifdef TALIK_DRY_GROUND
template <class T> using EffectPart = AbsentEffect<T>;
#else
template <class T> using EffectPart = std::unique_ptr<T>;
#endif

/// Numbers that change from step to step, kept together so that a checkpoint holds them all.
template <int D> struct Clock {
	double         time = 0.0;
	double         dt   = 0.0;
	CalendarState  calendar;
	long           steps       = 0;
	long           lastSort    = 0;
	long           sortWanted  = 0;
	long           halfDone    = 0; ///< points have moved and the step has not ended
	double         initialMass = 0.0;
	StepAccount<D> account; ///< of the run; one for all effects
	ActiveRange    range;
};

/// The points that a scene gives to a ground.
template <int D> struct GivenPoints {
	std::vector<PointInput<D>>           list; ///< one by one, until initialise()
	int                                  count = 0;
	std::function<PointInput<D>(int id)> at;   ///< until initialise() has ended
	std::vector<double>                  fill; ///< of the pores, by id; empty if it is that of the settings everywhere
};

template <int D> struct Ground<D>::Parts {
	GroundSettings<D> settings;
	GivenPoints<D>    given;
	bool              ready = false;

	Grid<D>                            grid;
	std::unique_ptr<MaterialPoints<D>> points;
	std::unique_ptr<ShapeFunction<D>>  shape;

	// effects; empty if the scene does not have them
	std::unique_ptr<SolidMotion<D>>    motion;
	std::unique_ptr<MomentumSolver<D>> momentum;
	EffectPart<AffineVelocity<D>>      affine;
	EffectPart<HeatTransfer<D>>        heat;
	EffectPart<PoreWater<D>>           water;
	EffectPart<ImplicitPressure<D>>    implicit; ///< pressure of the water at the end of the step
	EffectPart<PoreContent<D>>         content;
	EffectPart<FreeSurface<D>>         surface;
	EffectPart<MappedBack<D>>          mappedBack;
	EffectPart<CellMeans<D>>           cells;
	BBar<D>                            bBar;
	StrainWork<D>                      strainWork;
	EffectPart<RigidContact<D>>        bodies;
	EffectPart<ThawFront<D>>           front;
	EffectPart<ThawStrain<D>>          thawStrain;
	EffectPart<IceSegregation<D>>      segregation;
	EffectPart<ThawedCompression<D>>   compression; ///< only with thawStrain
	EffectPart<Calendar<D>>            calendar;    ///< whose scale follows the motion
	/// Those that stand in files of their own, and the points as they see them.
	std::vector<std::shared_ptr<Effect<D>>> effects;
	std::shared_ptr<DividingPoints<D>>      division;         ///< one of them
	std::vector<int>                        parents;          ///< of the points that came of division, in the order of ids
	std::vector<int>                        stressingEffects; ///< numbers of those that add stress
	PointsInMotion<D>                       inMotion {};

	StateDependentBoundaries<D> stateDependent;

	SkeletonSet<D>             skeletons; ///< only with motion
	GroundRanks<D>             ranks;
	Clock<D>                   clock {};
	Clock<D>                   clockBefore; ///< the clock at the beginning of the step, to which a step goes back that is refused before points move
	StepLedger<D>              ledger;      ///< of the step
	PositionCheck<D>           positions;
	std::vector<int>           impossible; ///< per strip: place of the first point whose state cannot be, or -1
	mutable PagedArray<double> scratch;
	mutable CostMeter          cost;
	PointPasses<D>             passes;
	bool                       fillsCells = false; ///< points have more than half of the volume of a cell

	// ---- setting up -----------------------------------------------------------------------------------------------------
	void             declareFields();
	void             listEffects();
	void             placePoints();
	void             bindEffects();
	SkeletonBatch<D> arraysOfSkeletons() const;
	void             listReadArrays();
	void             fillPoints();
	void             beginSkeletons();
	double           initialMass() const;
	void             fillPoint(int place, const PointInput<D>& in, double poreFill);
	void             shareRecords();
	void             checkFreeSurface();
	double           fillOf(int id) const { return given.fill.empty() ? settings.usedPoreFill() : given.fill[id]; }
	/// True if a boundary acts where the ground faces bodies.
	bool facesBodies() const;
	bool hasContent() const { return settings.heat || settings.water; }
	bool hasFront() const;
	bool hasThawStrain() const;
	bool hasCompression() const;
	/// Points at the front are exceptions from the means of cells in dry ground whose cells share no thaw strain.
	bool frontHasOwnMeans() const { return front && !water && !thawStrain; }
	/// What the content of the pores reads and writes of the points of other effects.
	typename PoreContent<D>::PointArrays contentOf() const;
	/// The points as the thaw front sees them.
	typename ThawFront<D>::Points pointsOfFront() const { return { *motion, water.get(), content->waterMass, content->iceMass, content->porosity }; }
	/// Why the point at a place is in a state that cannot be.
	std::string         whyImpossible(int place) const { return content->whyImpossible(place, contentOf().heat.temperature, contentOf().heat.enthalpy); }
	ConductingPoints    conducting() const { return { heat->heatCapacity, heat->conductivity }; }
	bool                averaging() const { return motion && motion->settings->bBar; }
	const CellMeans<D>* averagingCells() const { return averaging() ? cells.get() : nullptr; }

	/// work(boundary, number) for the boundaries of which acts is true, such as &Boundary<D>::drains.
	template <class Work> void overBoundaries(bool (Boundary<D>::*acts)() const, Work&& work) const
	{
		for (std::size_t b = 0; b < settings.boundaries.size(); ++b)
			if (((*settings.boundaries[b]).*acts)()) work(*settings.boundaries[b], b);
	}
	/// work(boundary, patch) with the part of the free surface that each of them has.
	template <class Work> void overSurfaces(bool (Boundary<D>::*acts)() const, Work&& work)
	{
		overBoundaries(acts, [&](const Boundary<D>& boundary, std::size_t b) { work(boundary, surface->patch(b)); });
	}

	// ---- ranks ----------------------------------------------------------------------------------------------------------
	/// Why this scene is not divided among ranks; empty where it is.
	std::string refusalOfRanks() const;
	/// What skeleton laws keep behind points goes where these are; moved: see SkeletonModel.
	void followSlabs(bool moved);
	/// Of points, nodes and cells only what this rank computes takes memory.
	void          keepOwnPart();
	const double* costOfPoints() const;
	/// Sorts the points of all ranks, and cuts new slabs; those that cross go from rank to rank. costKnown: that of strips is as at the last cut.
	/// Collective.
	void sortInSlabs(bool costKnown);
	/// The limits of this rank's points; in words instead if something is wrong.
	StableTimeStep limitsOfPoints() const;
	StableTimeStep limitsOfRanks() const;
	std::string    ownLimits() const;

	/// Of the step that goes on.
	StepContext<D> context()
	{
		return { clock.dt,
			 clock.calendar.scale,
			 clock.calendar.scale * clock.dt,
			 calendarEnd(),
			 grid,
			 ranks.owned(),
			 ranks.halo(),
			 points->strips(),
			 ranks.slabs(),
			 ledger };
	}

	// ---- pieces of a step: beginStep ------------------------------------------------------------------------------------
	void openStep(double dt);
	void useScale();
	/// Velocities of moving walls in this step. Throws, with the ground as it was before the step, if one leaves its nodes.
	void moveWalls();
	void findKeptFractions();
	void setReferenceOfHeat();
	void sort();
	void takePlaces(bool costKnown);
	void followDivision(const std::vector<int>& divided);
	void afterReordering(bool pointsMoved = false);

	// ---- p2g ------------------------------------------------------------------------------------------------------------
	void clearNodes();
	void clearNodes(int first, int last);
	void findFront(const StepContext<D>& step);
	void findFrontStrength();
	void locateInCells();
	void mapToGrid(const StepContext<D>& step);
	void addStress(const StepContext<D>& step, const WeightBlock<D>& w, CostMeter::Sample& sample);
	void mapWeight(const WeightBlock<D>& w);
	void collectSurfaces(const StepContext<D>& step);
	void mapSurface(const WeightBlock<D>& w)
	{
		surface->map(w);
		if (!settings.axisymmetric) return;
		const WeightBlock<D> mean = meanOfFaces(w); // what the radius adds to the area, eq. (29.4)
		for (int k = 0; k < w.count; ++k)
			overNodes<D>(mean, k, [&](int node, double s, const Vec<D>&) { surface->nodes[node][0] += s * planeArea(w.first + k); });
	}
	double         planeArea(int p) const { return points->volume()[p] / points->position(0)[p]; } ///< about an axis [m^2]
	WeightBlock<D> meanOfFaces(const WeightBlock<D>& w) const
	{
		return shape->meanOfFaces(
		        grid, [&](int p) { return planeArea(p); }, w);
	}

	// ---- solveNodes -----------------------------------------------------------------------------------------------------
	void findFlows(const StepContext<D>& step);
	void findNodalPressure(const StepContext<D>& step);
	void evaluateBoundaries(const StepContext<D>& step);
	void exchangeHeat(const StepContext<D>& step);
	void finishTemperature(const StepContext<D>& step);
	void solveMomentum(const StepContext<D>& step);
	void mapBack(const StepContext<D>& step);
	void pushByBoundaries(const StepContext<D>& step);
	void seep(const StepContext<D>& step);
	void feedWater(const StepContext<D>& step);
	void findImplicitPressure(const StepContext<D>& step);

	// ---- g2p ------------------------------------------------------------------------------------------------------------
	void gatherFromGrid(const StepContext<D>& step);
	void checkPositions(const StepContext<D>& step);

	// ---- updateStrainAndPressure ----------------------------------------------------------------------------------------
	void segregate(const StepContext<D>& step);
	void stabiliseCells(const StepContext<D>& step);
	void updatePoints(const StepContext<D>& step);
	void receiveWater(const StepContext<D>& step, int strip, int first, int last);
	void followStrain(const StepContext<D>& step, int strip, int first, int last, CostMeter::Sample& sample);
	int  updateContent(const StepContext<D>& step, int first, int last, CostMeter::Sample& sample);
	void findCellPressure(const StepContext<D>& step);
	void refuseImpossibleStates(const StepContext<D>& step);

	// ---- updateEffectiveStress ------------------------------------------------------------------------------------------
	void findStrainOfSoil(const StepContext<D>& step);
	void closeThawStrain(const StepContext<D>& step);
	void compressThawed(const StepContext<D>& step);
	void checkCompression();
	/// What a skeleton law throws to end the run after this step, or null.
	std::exception_ptr updateSkeletons(const StepContext<D>& step);
	void               restoreStrainOfGround();
	/// What the step has added to the accounts of the run; collective.
	void bookStep();
	void advanceClock();
	void measureMotion(const StepContext<D>& step);

	// ---- what holds in a step -------------------------------------------------------------------------------------------
	/// Calendar time at the end of the step.
	double calendarEnd() const { return clock.calendar.time + clock.calendar.scale * clock.dt; }
	bool   weighs() const { return lengthOf<D>(motion->settings->gravity) > 0.0; }
	bool   booksEnergy() const { return motion && settings.energyLedger; }
	/// Cells with the water that they exchange; null: water does not move by cells.
	const CellMeans<D>* exchangingCells() const { return water ? averagingCells() : nullptr; }
	/// Pore pressure is known per cell at both ends of a step.
	bool cellPressure() const { return water && averaging() && settings.water->state.massCoefficient == MassCoefficient::exact; }
	/// Work of pore pressure is taken half with the pressure at the start and half with that at the end of a step, if both are known.
	double startShare() const { return implicit ? 0.0 : cellPressure() ? 0.5 : 1.0; }
	double signalSpeed(int place, double modulus) const;
	double advectionStep(int place) const;

	StepTime         stepTime() const { return { clock.dt, clock.calendar.scale * clock.dt }; }
	double           largestModulus() const;
	CostMeter::Entry base() const { return motion ? CostMeter::motion : CostMeter::heat; } ///< who pays for what any ground needs
};

} // namespace talik
