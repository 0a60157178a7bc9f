// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <atomic>
#include <core/GlobalEngine.hpp>
#include <map>
#include <memory>
#include <pkg/base/SavedBytes.hpp>
#include <pkg/mpm/AnyGround.hpp>
#include <pkg/multiscale/bodies/BodyContact.hpp>
#include <pkg/multiscale/engine/GroundOfScene.hpp>
#include <pkg/multiscale/engine/PointTable.hpp>
#include <pkg/multiscale/settings/GroundBoundaries.hpp>
#include <pkg/multiscale/settings/GroundEffect.hpp>
#include <pkg/multiscale/settings/GroundEffects.hpp>
#include <pkg/multiscale/settings/GroundVector.hpp>
#include <pkg/multiscale/settings/SkeletonLaws.hpp>
#include <pkg/multiscale/view/GroundPicture.hpp>
#include <pkg/python/ScriptValues.hpp>
#include <set>

namespace yade {

/// Material point method for saturated, freezing ground in plane strain or in space, as an engine of the main scene. The ground itself
/// (talik::Ground) knows no YADE; this class gives it YADE's attributes and time step. What Python sees of it is in GroundViews.cpp, its
/// archive in GroundArchive.cpp, all that depends on the dimension in GroundOfScene.
class MpmEngine : public GlobalEngine {
public:
	void action() override;

	/// Positional and named arguments of the function of Python, see talik._points.
	void addPoints(const ::boost::python::object& positional, const ::boost::python::dict& named);
	/// Checks every setting and sets the initial state; done by the first step otherwise.
	void initialise();
	bool isInitialised() const { return ground != nullptr; }
	/// 2 or 3: as the points have it, without points as the settings say. Throws std::invalid_argument if they contradict each other.
	int usedDimension() const;
	/// A step was taken, or the state changed by hand: settings that the ground was built with stay from then on. Until then a change of
	/// them makes the ground anew from its inputs.
	bool hasBegun() const;
	/// A script has changed some setting: grounds that have not begun are made anew when they are next asked.
	static void settingChanged() { ++settingsChanged; }
	double      stableTimeStep();

	::boost::python::dict   timeStepLimits();
	::boost::python::list   fieldNames();
	::boost::python::list   fields();
	::boost::python::object field(const string& name);
	::boost::python::object storedField(const string& name); ///< None if there is none
	void                    watch(::boost::python::object ids, Real interval, ::boost::python::object names);
	::boost::python::dict   history(int id) const;
	/// O shows one of the samples: the ground does not step.
	bool                    inspected = false;
	bool                    stepping  = false; ///< a step is under way, which a function of Python may have been called by
	::boost::python::dict   balance();
	::boost::python::dict   cost();
	::boost::python::object grid();
	::boost::python::object estimatedError();
	int                     pointCount() const;
	::boost::python::list   skeletonNumbers() const;
	::boost::python::list   pointMaterials() const;
	double                  groundTime() const;
	::boost::python::dict   calendar();
	::boost::python::list   events();
	void                    setDay(Real day);
	double                  skemptonB();
	::boost::python::dict   addedPoints() const { return points.arrays(); }
	/// Sentences about settings that are valid and hardly meant.
	::boost::python::list doubts();
	void                  resetDisplacement();
	void                  setTemperature(::boost::python::object values);
	/// Gives points other skeleton laws between two steps; on an exception the ground is as before.
	void exchangeSkeletons(const vector<shared_ptr<SkeletonLaw>>& laws, const ::boost::python::object& skeletonOf);

	/// Python waits for the end of the run under way and learns there of an error.
	static std::atomic<bool> runWaitedFor;

	void preLoad(MpmEngine&);
	void preSave(MpmEngine&);
	void postSave(MpmEngine&);

	/// The running ground; throws if there is none yet.
	talik::AnyGround& runningGround();
	/// For views that are drawn by other threads.
	talik::GroundPicture picture;
	/// Materials in use: those listed, or the single one.
	vector<shared_ptr<GroundMaterial>> activeMaterials() const;
	/// As the ground takes them; empty if one material has nothing that the scene has not. Throws std::invalid_argument.
	vector<talik::SoilMaterial> soils() const;
	/// Skeletons in use: those listed, or the single one.
	vector<shared_ptr<SkeletonLaw>> activeSkeletons() const;

private:
	static std::atomic<std::uint64_t> settingsChanged; ///< how often, by scripts, in all scenes

	void                            checkPresence();
	void                            checkEngines() const;
	void                            checkChangeable() const;
	bool                            isAsSet() const;
	void                            discardGround();
	void                            dropGround();
	void                            followInputs();
	void                            restoreSavedState();
	void                            restoreArrays(talik::ByteReader& reader, const vector<talik::StateArray>& arrays) const;
	void                            checkExchange(const vector<shared_ptr<SkeletonLaw>>& laws, const vector<int>& skeletonOf) const;
	void                            takeOver(const vector<shared_ptr<SkeletonLaw>>& before, const std::map<string, string>& state);
	void                            followAttributes();
	void                            followTolerance();
	void                            followHeat();
	void                            warnOfCalendar();
	void                            stopAtTheDay(double before);
	void                            sayGraveDoubts();
	vector<string>                  foundHardlyMeant(const char* which);
	void                            say(const string& sentence);
	void                            shareAmongRanks();
	bool                            mayBeInSlabs() const;
	string                          notInSlabs() const;
	void                            sayHowRanksShare();
	void                            meetBefore(const string& change) const;
	void                            compareRanks();
	bool                            leadsTimeStep() const;
	Real                            timeStepOfOthers();
	Real                            wantedStep();
	bool                            watchStableStep();
	int                             findStableStep();
	int                             subSteps(double dt) const;
	void                            advanceAlone(bool newLimit);
	void                            advanceAmongBodies();
	void                            collectBodies();
	void                            stepGround();
	void                            advance(double dt);
	vector<shared_ptr<SkeletonLaw>> lawsMeasuring(const string& name) const;
	vector<string>                  existingFields();
	vector<Real>                    valueAt(const string& name, int id);
	void                            recordWatched();

	std::shared_ptr<GroundOfScene> groundOfScene;
	talik::AnyGround*              ground          = nullptr; ///< that of groundOfScene
	long                           stepsUntilLimit = 0, stepsAtStart = 0;
	long                           nextComparison = 0;     ///< step from which on the ranks compare their ground again
	bool                           bodiesNamed    = false; ///< boundaries have found the bodies that they name
	bool                           begun = false, watchesDefault = false;
	std::uint64_t                  settingsWhenMade = 0;     ///< count of `settingsChanged` when the ground was made
	bool                           silent           = false; ///< the ground is made to see whether the first step would refuse it
	string                         failure;
	std::set<string>               said;
	long                           failures         = 0;
	double                         stableStep       = 0;
	double                         toleranceInForce = 0;
	bool                           worthSlabs       = false; ///< however small the ground is
	talik::CheckpointParts::Source parts;                    ///< of a state that was read and has not begun

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(MpmEngine,GlobalEngine,"Thawing and freezing ground by the material point method, Yu & Zhao section 2.3. Each effect (heat, "
			"freezing, water, bodies) is an object that a scene may have, and every material point has a skeleton law. In plane strain (x, y, with y "
			"upwards), all quantities per metre of thickness, or in space (x, y, z, with z upwards): see dimension. SI units, degrees Celsius; stress positive in "
			"tension, pressure positive in compression. Example: "
			"mpm=MpmEngine(gridSpacing=0.2,lower=(0,0),upper=(10,5),gravity=(0,-9.81),skeleton=ElasticSkeleton()); "
			"talik.geometry.fill(mpm,[(0,0),(10,0),(10,1),(0,1)]); O.engines=[mpm]; O.run(100,True).",
		((Real,gridSpacing,NaN,,"Spacing h of the grid of squares or cubes [m], > 0."))
		((int,dimension,0,,"2: plane strain, points (n,2), y upwards. 3: space, points (n,3), z upwards. 0: as the points have it, which set it; a lower, upper or "
				"gravity of three components says 3 to talik.geometry.fill."))
		((bool,axisymmetric,false,,"The plane turns about x=0: x is the radius, y the axis, and all quantities are those of a radian. The box lies at x >= 0; where "
				"it reaches the axis a RollerBoundary is there. The volume of a point is that in the plane [m^2], in addPoints, talik.geometry.fill and field volume; the "
				"engine multiplies it by the radius. field('strain') has six components, as in space. Refused with thawFront, segregation, "
				"pointsDivide, bodies, effects and RveSkeleton."))
		((GroundVector,lower,NaN,,"Lower corner of the grid's box [m], two components, three in space; its sides are where boundaries act. NaN: around the points."))
		((GroundVector,upper,NaN,,"Upper corner of the grid's box [m], a whole number of spacings away. NaN: around the points."))
		((bool,motion,true,,"Effect: the ground moves. False: it is rigid, and only heat limits the time step."))
		((GroundVector,gravity,0,,"Body force per mass [m/s^2]: (0,-9.81), in space (0,0,-9.81). May be changed while running."))
		((Real,damping,0,,"Local non-viscous damping of the mixture force [-], 0 to below 1: 0.3 to 0.7 to reach equilibrium, 0 to 0.05 in failure. May be changed "
				"while running."))
		((string,transfer,"flip",,"How points get the velocity of the solid from the grid. flip: they keep their velocity and add the grid's acceleration; apic: "
				"they take the grid's velocity and its first moment, which conserves angular momentum to round-off; tpic: the grid's "
				"velocity and its gradient. apic and tpic add the field affineVelocity [1/s], zero at the start. picTime sets how fast the difference to the grid's "
				"velocity decays; water has its own, PoreWater.picTime."))
		((Real,picTime,NaN,,"Time in which the difference between a point's velocity and that of the grid decays [s], >= 0: in each step the fraction "
				"exp(-dt/picTime) of it is kept. 0: nothing (PIC; apic and tpic as published), inf: all of it (FLIP). NaN: with transfer='flip' sqrt(h/g), in which a "
				"body falls by half a cell (g at least 9.81 m/s^2), 0 with apic and tpic. May be changed while running."))
		((bool,bBar,true,,"B-bar: mean of div v over each cell and, transposed, of the mean stress. False: nearly incompressible ground locks."))
		((string,shapeFunction,"quadraticBSpline",,"Shape functions of the grid: quadraticBSpline, or gimp (uniform, points a quarter of a cell in half-width)."))
		((shared_ptr<GroundMaterial>,material,shared_ptr<GroundMaterial>(new GroundMaterial),,"Phases of the ground."))
		((vector<shared_ptr<GroundMaterial>>,materials,,,"Materials of a ground of several soils, in place of material; addPoints(material=i), or its name, says "
				"which a point has."))
		((shared_ptr<HeatTransfer>,heat,,,"Effect: heat. None: there is no temperature."))
		((shared_ptr<FreezingCurve>,freezing,,,"Effect: pore water freezes; needs heat."))
		((shared_ptr<ThawFront>,thawFront,shared_ptr<ThawFront>(new ThawFront),,"Effect: frozen and thawed ground have separate velocities where they meet, so "
				"that thin thawed layers slide. It needs freezing, motion and a skeleton that can fail, and is absent without them. None: one velocity for all."))
		((shared_ptr<PoreWater>,water,,,"Effect: pore water flows and carries pressure; needs motion. None: pore water, if any, moves with the grains and carries "
				"no pressure."))
		((shared_ptr<IceSegregation>,segregation,,,"Effect: frost heave by ice segregation, where ground freezes; needs water and freezing. "
				"None: freezing ground draws no water."))
		((shared_ptr<BodyContact>,bodies,,,"Effect: bodies of the scene (walls, facets, boxes, spheres, clumps) and the ground push each other; needs motion. None: "
				"they have no contact with the ground."))
		((shared_ptr<SkeletonLaw>,skeleton,,,"Skeleton law of all points, unless skeletons lists several."))
		((vector<shared_ptr<SkeletonLaw>>,skeletons,,,"Skeleton laws; addPoints(skeleton=i) says which a point has."))
		((vector<shared_ptr<GroundBoundary>>,boundaries,,,"Conditions on sides, free surface or boxes of nodes."))
		((vector<shared_ptr<GroundEffect>>,effects,,,"Further effects of moving ground, such as BulkViscosity."))
		((Real,poreFill,NaN,,"Part of the pores that holds water or ice [-]; NaN: 1 with heat or water, 0 in a dry scene."))
		((bool,automaticTimeStep,true,,"Set O.dt to the stable time step; otherwise O.dt is kept and divided into sub-steps where it exceeds the limit. Of several "
				"grounds in O.engines the first sets it, to the smallest of their steps. May be changed while running."))
		((Real,courantNumber,0.4,,"Courant number: time step over h/(c+|v|) [-], in (0,1]; lowered to what is stable wherever the points lie: 0.408 with "
				"quadraticBSpline, 0.327 with gimp. May be changed while running."))
		((Real,heatFraction,0.9,,"Time step over the explicit limit of conduction [-], in (0,1]. May be changed while running."))
		((bool,pointsDivide,false,,"A point that a stretch or an ice lens makes longer than 1.25 cells becomes two where a cell beside it is left without points, so "
				"that slides do not tear into lumps. Both halves have half of its mass, volume, heat and water, all else, and a copy of its sample. The new point "
				"has the next id, at the end of the arrays of field(). Points do not merge. Needs motion."))
		((Real,tolerance,0,,"Relative error of effective stress that samples behind points may cause [-], e.g. 0.03: strain tolerance and inertial number of every "
				"point follow the errors measured in its own sample, in place of RveSkeleton.strainTolerance, stressTolerance and maxInertialNumber; see "
				"estimatedError. 0: those attributes count. From 1e-4 to 0.5. May be changed while running, but not to or from 0. Needs packed samples."))
		((Real,stopAtDay,std::numeric_limits<Real>::infinity(),,"O stops once, after the step in which the calendar reaches this day [d], as at O.stopAtTime. "
				"May be changed while running."))
		((string,distribute,"automatic",,"What the ranks of mpirun divide; results are identical to those of one rank. ground: slab decomposition; each "
				"rank owns a slab of at least two strips of four rows of cells, with its samples, and exchanges halo rows with its neighbours; slabs follow the "
				"cost of points and samples. Samples have to be packed; a law in Python is called for the points of one strip after the other. Bodies of YADE are "
				"on all ranks. none: every rank computes everything. automatic: ground if there are packed samples or 100 000 points, no law in Python, no "
				"PeriodicBoundary and strips enough; else none, with a message. Without mpirun it affects only laws in Python."))
		((bool,energyLedger,false,,"Compute the balance of mechanical work and dissipation, see balance()."))
		((shared_ptr<PointWatch>,watched,,Attr::readonly,"Histories of watched points; None while none is. See watch()."))
		((talik::PointTable,points,,Attr::hidden,"Points as they were added."))
		((string,saved,"",Attr::hidden,"State of a running ground in an archive."))
		,/*ctor*/ talik::GroundVector::registerOnce(); talik::SequenceConverter<GroundMaterial>::registerOnce(); ,
		/*py*/
		.def("addPoints",::boost::python::raw_function(&MpmEngine::pyAddPoints,2),"addPoints(position, volume, porosity=0.4, temperature=0, pressure=0, skeleton=0, "
				"stress=(0,0,0,0), velocity=(0,0), poreFill=nan, material=0): add material points before the first step. position (n,2) or, in space, "
				"(n,3) [m], volume [m^2 per metre; m^3], temperature [degC], pressure [Pa], effective stress (n,4) xx yy zz xy or (n,6) "
				"xx yy zz yz xz xy [Pa] as field('stress') gives it, not of points with samples, velocity as position [m/s], poreFill: part of the "
				"pores that holds water or ice [-], nan: that of the engine, material: name or number of one of materials; all but position "
				"may be scalars. ValueError names what is wrong.")
		.def("addedPoints",&MpmEngine::addedPoints,"Dictionary of arrays: the points as they were added, by the names of addPoints().")
		.def("initialise",&MpmEngine::initialise,"Check all settings and set the initial state now rather than in the first step. ValueError names attribute, value "
				"and remedy.")
		.def("stableTimeStep",&MpmEngine::stableTimeStep,"Largest stable time step with the present state [s].")
		.def("timeStepLimits",&MpmEngine::timeStepLimits,"Dictionary of all limits of the time step [s] and, under 'governing', the name of the smallest.")
		.def("fieldNames",&MpmEngine::fieldNames,"Names of the fields that exist on the points, for field().")
		.def("fields",&MpmEngine::fields,"Every field on points and nodes: a list of dictionaries with name, owner (effect), unit, place, components, bytes.")
		.def("field",&MpmEngine::field,(::boost::python::arg("name")),"A field of the points as a NumPy array (n,) or (n,components), in the order of the points' "
				"ids; stress has the components xx, yy, zz, xy, in space xx, yy, zz, yz, xz, xy. Beside the stored fields: strain, the logarithmic strain since the start "
				"(xx, yy, xy; in space as stress); deviatoricStrain, sqrt(2/3 e:e) of it; the measures of the samples, see RveSkeleton.values.")
		.def("_storedField",&MpmEngine::storedField,(::boost::python::arg("name")))
		.def("watch",&MpmEngine::watch,(::boost::python::arg("ids"),::boost::python::arg("interval")=0.,::boost::python::arg("fields")=::boost::python::list()),
				"Record the histories of some points from now on: fields (default: all that say something of soil or sample) every interval seconds, 0 for every step. "
						"Saved with the scene; see history(). A second call begins anew, watch([]) deletes all records.")
		.def("history",&MpmEngine::history,(::boost::python::arg("id")),"Records of a watched point: a dictionary of NumPy arrays by instant, time [s] and the "
				"fields.")
		.def_readwrite("inspected",&MpmEngine::inspected,"True while O shows one of the samples: the ground does not step then. Set by inspect() and back().")
		.def("balance",&MpmEngine::balance,"Dictionary: masses, momentum, enthalpy and energies now, and all that crossed the boundary since the start. heatIn is "
				"positive into the ground, waterOut, enthalpyOut and waterEnergyOut (of that water, by its height) out of it; impulse is that on the "
				"ground; skeletonWork and porePressureWork are done on skeleton and pore content, loadWork by SurfaceLoad, wallWork by MovingBoundary, slipWork by the "
				"force at the thaw front, segregationWork by suction on the water that freezing ground has drawn, waterDrawn [kg].")
		.def("cost",&MpmEngine::cost,"Wall time spent since this engine started [s], a dictionary with an entry for every effect that the scene has and no other: "
				"motion, transfer (apic, tpic), bodies, heat, freezing, water, 'conduction and pore pressure' (the pass that serves both), 'cell averages', 'free "
				"surface', boundaries, 'thaw strain', 'energy ledger', sorting, 'time step limits', 'deformation record' and others of effects, each skeleton by name and "
				"number; beside them steps, their number. Time of passes that serve several effects is divided among them by sampling. Not kept in archives.")
		.def("skemptonB",&MpmEngine::skemptonB,"Skempton's B with the bulk modulus of water in use [-]: of the softest point, by the oedometer modulus of its "
				"skeleton, with its pores full of liquid.")
		.def("doubts",&MpmEngine::doubts,"Warnings about settings that are valid but probably a mistake; talik.check(mpm) prints them, and the first step "
				"prints those that make the results meaningless.")
		.def("setTemperature",&MpmEngine::setTemperature,(::boost::python::arg("temperature")),"Set the temperature of all points (scalar or array by id) [degC], "
				"with enthalpy to match.")
		.def("exchangeSkeletons",&MpmEngine::exchangeSkeletons,(::boost::python::arg("skeletons"),::boost::python::arg("skeletonOf")),"Between two steps: give the "
				"ground a new list of skeleton laws and each point (by id) the number of its law. Points that keep their law keep its history. Stress stays, except that "
				"points given a new RveSkeleton take the stress of their samples. After an error the ground is as before. See talik.refine and talik.coarsen.")
		.def("resetDisplacement",&MpmEngine::resetDisplacement,"Count displacement and deformation from now on; positions, velocities and stresses stay.")
		.add_property("estimatedError",&MpmEngine::estimatedError,"Estimated error of effective stress that the samples have caused since the start: root mean "
				"square over points and steps, over that of the stress itself [-]: from the differences between predicted and sampled stress and between two rates of "
				"strain, as they were measured. None without tolerance. Error of grid and time step is not in it.")
		.add_property("pointCount",&MpmEngine::pointCount,"Number of material points.")
		.add_property("skeletonOf",&MpmEngine::skeletonNumbers,"List: the number of each point's skeleton law, by id.")
		.add_property("materialOf",&MpmEngine::pointMaterials,"List: the number of each point's material in materials, by id.")
		.add_property("time",&MpmEngine::groundTime,"Time of motion of the ground [s]; see calendar for that of heat, weather and seepage.")
		.add_property("calendar",&MpmEngine::calendar,"Dictionary: day, calendar time in days, at which tables of boundaries are read; scale, calendar time per "
				"time of motion in the last step [-]; followsMotion; speed of the fastest ground, the largest mean velocity of the points of a cell [m/s], and moving, "
				"whether an event goes on (both with followsMotion only); seepageScale, the acceleration of seepage and rain [-]; largestConductivity, the limit "
				"up to which it acts [m/s], None without water.")
		.def("events",&MpmEngine::events,"Times in which the ground moved, with HeatTransfer.followsMotion: a list of dictionaries with day, duration in seconds of "
				"motion, days of the calendar that passed meanwhile, volume of the points displaced by more than 2 cm [m^2 per metre; m^3], largest "
				"displacement [m], goesOn. An event begins when the fastest ground passes both HeatTransfer.motionTolerance and, in calendar time, "
				"1e-5 m/s (a metre a day, a moderate landslide), and ends when all have been below half of that for 0.2 s. Events in which no point moves "
				"by 2 cm are left out.")
		.def("setDay",&MpmEngine::setDay,(::boost::python::arg("day")),"Between two steps: the calendar says this day from now on, and events are counted anew.")
		.def_readonly("failure",&MpmEngine::failure,"Why the last step failed; empty after a step that did not.")
		.def_readonly("failures",&MpmEngine::failures,"Steps that failed since the engine started.")
		.add_property("initialised",&MpmEngine::isInitialised,"True once the initial state is set.")
		.add_property("begun",&MpmEngine::hasBegun,"True once a step was taken or the state was changed by hand (setTemperature, setDay, exchangeSkeletons, "
				"replaceSample). Until then every setting may be changed, also after fields were read.")
		.def("settingChanged",&MpmEngine::settingChanged,"Grounds whose fields were read but that have not begun are made anew from their settings when they are "
				"next asked. Done by every change of an attribute.").staticmethod("settingChanged")
	);
	// clang-format on
	static ::boost::python::object pyAddPoints(::boost::python::tuple args, ::boost::python::dict keywords);
};
REGISTER_SERIALIZABLE(MpmEngine);

} // namespace yade
