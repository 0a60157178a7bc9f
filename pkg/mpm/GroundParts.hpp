// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// What a ground consists of; shared by the files that implement Ground.

#include <pkg/mpm/Calendar.hpp>
#include <pkg/mpm/CostMeter.hpp>
#include <pkg/mpm/effects/BBar.hpp>
#include <pkg/mpm/effects/DeformationRecord.hpp>
#include <pkg/mpm/effects/Effect.hpp>
#include <pkg/mpm/effects/HeatTransfer.hpp>
#include <pkg/mpm/effects/IceSegregation.hpp>
#include <pkg/mpm/effects/ImplicitPressure.hpp>
#include <pkg/mpm/effects/MomentumSolver.hpp>
#include <pkg/mpm/effects/NodeColumns.hpp>
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
#include <pkg/mpm/grid/CellMeans.hpp>
#include <pkg/mpm/grid/FreeSurface.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/points/AffineVelocity.hpp>
#include <pkg/mpm/points/ArraysAhead.hpp>
#include <pkg/mpm/points/ConcernedPoints.hpp>
#include <pkg/mpm/skeleton/SkeletonSet.hpp>
#include <pkg/mpm/StepContext.hpp>
#include <pkg/mpm/StepLedger.hpp>
#include <pkg/thm/ProcessorVersions.hpp>

#include <algorithm>
#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>

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
	double        time = 0.0;
	double        dt   = 0.0;
	CalendarState calendar;
	long          steps       = 0;
	long          lastSort    = 0;
	long          sortWanted  = 0;
	long          halfDone    = 0; ///< points have moved and the step has not ended
	double        initialMass = 0.0;
	RunAccount<D> account; ///< of the run; one for all effects
	ActiveRange   range;
};

template <int D> struct Ground<D>::Parts {
	GroundSettings<D>                    settings;
	std::vector<PointInput<D>>           inputs;
	int                                  given = 0; ///< points, and each of them
	std::function<PointInput<D>(int id)> point;
	bool                                 ready = false;

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
	std::vector<int>                        stressingEffects; ///< numbers of those that add stress
	PointsInMotion<D>                       inMotion {};

	StateDependentBoundaries<D> stateDependent;

	SkeletonSet<D>             skeletons;            ///< only with motion
	std::shared_ptr<RankTalk>  talk;                 ///< of the ranks that share out this ground; null: there is one
	bool                       bandsRequired = true; ///< what bands do not serve is an error
	std::unique_ptr<Bands>     bands;                ///< the same, from initialise() on
	std::vector<double>        pointFill;            ///< pore fill by id; empty if it is that of the settings everywhere
	Clock<D>                   clock {};
	ActiveRange                reached;     ///< rows that the points of this rank may touch
	ActiveRange                around;      ///< and as many beyond as it has to know to solve there
	StepLedger<D>              ledger;      ///< of the step
	Clock<D>                   clockBefore; ///< the clock at the beginning of the step, to which a step goes back that is refused before points move
	PositionCheck<D>           positions;
	std::vector<int>           impossible; ///< per strip: place of the first point whose state cannot be, or -1
	mutable PagedArray<double> scratch;
	mutable CostMeter          cost;
	/// What the passes over blocks read of the points.
	struct {
		ArraysAhead toGrid, flows, seepage, toPoints;
	} read;
	bool heatRests      = false; ///< in this step
	bool waterRests     = false; ///< in this step no water moved through the skeleton
	bool contentSettled = false; ///< the content of resting rigid ground was updated and stayed as it was

	// ---- setting up -----------------------------------------------------------------------------------------------------
	void             declareFields();
	void             listEffects();
	void             placePoints();
	void             bindEffects();
	SkeletonBatch<D> arraysOfSkeletons() const;
	void             listReadArrays();
	void             fillPoints();
	void             beginSkeletons();
	/// Changes the stress of the points by as little as it takes for the ground to rest.
	void   balanceStart();
	void   requireBalancedStress(const std::vector<double>& vertical) const;
	void   findForcesAtRest();
	void   findStrains(const NodeField<D>& displacement, std::array<std::vector<double>, stressSize<D>>& strain);
	void   findReactions(const std::array<std::vector<double>, stressSize<D>>& stress, NodeField<D>& force);
	double initialMass() const;
	void   fillPoint(int place, const PointInput<D>& in, double poreFill);
	void   shareRecords();
	void   checkFreeSurface();
	double fillOf(int id) const { return pointFill.empty() ? settings.usedPoreFill() : pointFill[id]; }
	/// True if a boundary acts where the ground faces bodies.
	bool facesBodies() const;
	bool hasContent() const { return settings.heat || settings.water; }
	bool hasFront() const;
	bool hasThawStrain() const;
	bool hasCompression() const;
	/// Points at the front are exceptions from the means of cells in dry ground whose cells share no thaw strain.
	bool frontHasOwnMeans() const { return front && !water && !thawStrain; }
	/// The effects whose points the content of the pores changes.
	typename PoreContent<D>::Effects contentOf() const { return { motion.get(), heat.get(), water.get() }; }
	bool                             averaging() const { return motion && motion->settings->bBar; }
	const CellMeans<D>*              averagingCells() const { return averaging() ? cells.get() : nullptr; }

	// ---- loops ----------------------------------------------------------------------------------------------------------
	/// work(block) for all points, with weights at their positions; never two neighbouring strips at once.
	/// share(rows): names the arrays to which work adds; ahead: those of the points that it reads.
	template <class Work, class Share> void scatter(const ArraysAhead& ahead, Work&& work, Share&& share)
	{
		points->strips().scatter([&](int, int first, int last) { overBlocks(ahead, first, last, work); }, share);
	}
	/// The parts of a pass in turn for each block of points, with weights at their positions and an array for what one part leaves to a later one.
	/// finish(strip, firstPoint, lastPoint): when a strip's blocks are done.
	template <class Share, class Finish, class... Work>
	void inBlocks(const ArraysAhead& ahead, Share&& share, Finish&& finish, const PassPart<Work>&... parts)
	{
		points->strips().scatter(
		        [&](int strip, int first, int last) {
			        CostMeter::Sample sample = cost.sample(strip);
			        double            left[blockSize];
			        overBlocks(ahead, first, last, [&](const WeightBlock<D>& w) {
				        sample.beginBlock();
				        (parts.run(sample, w, left), ...);
			        });
			        finish(strip, first, last);
		        },
		        share);
		cost.lapShared();
	}
	/// The parts of a pass in turn for each strip of points: work(strip, firstPoint, lastPoint, sample). share: empty where they add to no array that
	/// strips share.
	template <class... Work> void inStrips(const std::function<void(SharedRows&)>& share, const PassPart<Work>&... parts)
	{
		const auto work = [&](int strip, int first, int last) {
			CostMeter::Sample sample = cost.sample(strip);
			sample.begin();
			(parts.run(sample, strip, first, last, sample), ...);
		};
		if (share) points->strips().scatter(work, share);
		else points->strips().gather(work);
		cost.lapShared();
	}
	template <class Work> void overBlocks(const ArraysAhead& ahead, int first, int last, Work&& work)
	{
		WeightBlock<D>               w;
		std::array<const double*, D> x;
		for (int a = 0; a < D; ++a)
			x[a] = points->position(a);
		for (int p = first; p < last; p += blockSize) {
			shape->evaluate(grid, x, p, std::min(blockSize, last - p), w);
			ahead.fetch(p + blockSize);
			work(w);
		}
	}

	// ---- ranks ----------------------------------------------------------------------------------------------------------
	void startBands();
	/// Numbers by place become known to all ranks, for sums in the order of one; until keepOwnPoints().
	template <class... Arrays> void showAll(Arrays*... arrays) const
	{
		if (bands) (void)std::initializer_list<int> { (arrays ? bands->shareByPoint(arrays) : void(), 0)... };
	}
	/// The first words that any rank has; empty if none has.
	std::string wordsOfAny(const std::string& own) { return context().firstWords(own); }
	std::string refusalOfBands() const;
	void        cutBands();
	/// What skeleton laws keep behind points goes where these are; moved: see SkeletonModel.
	void followBands(bool moved);
	/// The rows that this rank computes.
	void chooseRows();
	/// All numbers of the points, array by array.
	template <class Work> void overArrays(Work&& work) const
	{
		PointFields& f = points->fields();
		for (std::size_t k = 0; k < f.list().size(); ++k)
			for (int c = 0; c < f.list()[k].components; ++c)
				work(f.component(int(k), c));
	}
	/// At the beginning of a step: waits for the other ranks; collective.
	void meetRanks();
	/// Of points, nodes and cells only what this rank computes takes memory.
	void          keepOwnPart();
	void          keepOwnPoints() const;
	const double* costOfPoints() const;
	/// Sorts the points of all ranks, and cuts new bands; those that cross go from rank to rank. Collective.
	void sortInBands();
	/// All points become current here; the other ranks help when they come to their next step.
	void        bringPoints() const;
	std::string answer(const std::string& question) const;
	std::string ownPoints() const;
	void        writeOwnPoints(const FilePlace& place, PartSum& sum) const;
	void        takePoints(const std::vector<std::string>& byRank) const;
	/// The limits of this rank's points; in words instead if something is wrong.
	StableTimeStep limitsOfPoints() const;
	StableTimeStep limitsOfRanks() const;

	/// Of the step that goes on.
	StepContext<D> context()
	{
		return { clock.dt, clock.calendar.scale * clock.dt, calendarEnd(), grid, reached, around, points->strips(), bands.get(), ledger };
	}

	// ---- pieces of a step -----------------------------------------------------------------------------------------------
	void clearNodes();
	void clearNodes(int first, int last);
	void afterReordering(bool pointsMoved = false);
	void locateInCells();
	void findKeptFractions();
	void openStep(double dt);
	bool heatMayRest();
	void settleHeat();
	/// What the step has added to the accounts of the run; collective.
	void bookStep();
	/// Calendar time at the end of the step.
	double calendarEnd() const { return clock.calendar.time + clock.calendar.scale * clock.dt; }
	void   useScale();
	/// Velocities of moving walls in this step. Throws, with the ground as it was before the step, if one leaves its nodes.
	void moveWalls();
	bool allRests() const { return heatRests && !motion; }
	void findFrontStrength();
	void findFront();
	void mapToGrid();
	void addStress(const WeightBlock<D>& w, CostMeter::Sample& sample);
	void followStrain(int strip, int first, int last, CostMeter::Sample& sample);
	void collectSurfaces();
	void findNodalPressure();
	void findFlows();
	void exchangeHeat();
	void finishTemperature();
	void updateTemperature();
	void evaluateBoundaries();
	void pushByBoundaries();
	void solveMomentum();
	void seep();
	void feedWater();
	void findImplicitPressure();
	void gatherFromGrid();
	void finishPaths();
	void levelCells();
	void segregate();
	int  updateContent(int first, int last, const CellMeans<D>* cells, CostMeter::Sample& sample);
	void findCellPressure();
	void closeThawStrain();
	void compressThawed();
	void checkCompression();
	/// What a skeleton law throws to end the run after this step, or null.
	std::exception_ptr updateSkeletons();
	void               measureMotion();
	double             signalSpeed(int place, double modulus) const;
	double             advectionStep(int place) const;
	/// Throws, with the ground as it was before the step, if a point is about to leave the grid's box.
	void              requirePathsInside();
	[[noreturn]] void refuseToLeave(bool stable);
	void              checkPositions();
	void              refuseImpossibleStates();
	bool              pays(CostMeter::Entry entry) const;
	/// Pore pressure is known per cell at both ends of a step.
	bool cellPressure() const { return water && averaging() && settings.water->state.massCoefficient == MassCoefficient::exact; }
	/// Work of pore pressure is taken half with the pressure at the start and half with that at the end of a step, if both are known.
	double startShare() const { return implicit ? 0.0 : cellPressure() ? 0.5 : 1.0; }
	void   sort();

	StepTime             stepTime() const { return { clock.dt, clock.calendar.scale * clock.dt }; }
	double               largestModulus() const;
	double               liquidDensity() const { return settings.mixtureOf(0).liquid.density; }
	CostMeter::Entry     base() const { return motion ? CostMeter::motion : CostMeter::heat; } ///< who pays for what any ground needs
	LiquidOfGround       liquid() const { return { liquidDensity(), enthalpyModel() }; }
	const EnthalpyModel* enthalpyModel() const { return heat ? &content->enthalpyModel() : nullptr; }
};

} // namespace talik
