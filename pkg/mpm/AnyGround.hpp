// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Calendar.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/PointFields.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>
#include <pkg/ranks/Communicator.hpp>
#include <pkg/ranks/PartedFile.hpp>

#include <string>
#include <utility>
#include <vector>

namespace talik {

/// What whoever steps and looks at a ground needs to know of it, whether it lies in the plane or in space.
class AnyGround {
public:
	virtual ~AnyGround() = default;

	virtual int dimension() const = 0; ///< 2 or 3

	/// Before initialise(): the ranks, which run the same scene, share out its strips in slabs. Every rank has arrays for all points, and looking
	/// at them brings those of the others. What slabs do not serve is refused by initialise() where they are `required`; else each rank
	/// computes the whole ground then.
	virtual void distribute(std::shared_ptr<Communicator> communicator, bool required = true) = 0;
	virtual bool inSlabs() const                                                              = 0; ///< after initialise()
	/// Checks everything, allocates all fields and sets the initial state. Throws std::invalid_argument naming attribute, value
	/// and remedy.
	virtual void initialise()        = 0;
	virtual bool initialised() const = 0;

	/// Settings without direction. What may change while the ground runs: the fractions of the time step.
	virtual SettingsOfAnyDimension&       commonSettings()       = 0;
	virtual const SettingsOfAnyDimension& commonSettings() const = 0;
	/// nullptr if the ground is rigid. localDamping and picTime may change while the ground runs.
	virtual MotionOfAnyDimension* motionSettings() = 0;

	// ---- one step: Ground::step ---------------------------------------------------------------------------------------
	virtual void beginStep(double dt)      = 0; ///< sets the length of the step, sorts points if needed
	virtual void p2g()                     = 0; ///< mass, momentum, internal force, enthalpy
	virtual void solveNodes()              = 0; ///< heat flows, temperature; nodal forces, node-implicit drag, seepage fluxes; boundaries
	virtual void g2p()                     = 0; ///< velocity, displacement, position, received heat and water
	virtual void updateStrainAndPressure() = 0; ///< strain, volume, porosity, temperature, ice saturation, pore pressure
	virtual void updateEffectiveStress()   = 0; ///< asks the skeleton models; ends the step

	/// Largest stable step with the present state and which limit governs it. Prints nothing, changes nothing.
	virtual StableTimeStep stableTimeStep() const = 0;

	/// Wall time spent since the start by effect [s]: name and seconds of every effect that the scene has, in a fixed order. Passes
	/// that serve several effects are shared out by samples; the whole costs less than a hundredth of a step.
	virtual std::vector<std::pair<std::string, double>> cost() const = 0;

	// ---- time --------------------------------------------------------------------------------------------------------------
	virtual double time() const  = 0; ///< [s]
	virtual double dt() const    = 0; ///< of the present or last step [s]
	virtual long   steps() const = 0; ///< done so far
	/// Calendar time, scale of the last step, what the next one follows from; an event if one goes on.
	virtual const CalendarState& calendar() const            = 0;
	virtual double               seepageScale() const        = 0; ///< f_H in the last step [-]; 1 without water
	virtual double               largestConductivity() const = 0; ///< up to which seepage is accelerated [m/s], see PoreWater; infinite without water
	/// Between two steps: the calendar says this time [s] from now on, and events are counted anew.
	virtual void setCalendar(double time) = 0;
	/// Events that ended so far, and the one that goes on as the last if there is one. Empty unless the scale follows the motion.
	virtual std::vector<MotionEvent>        events() const                                         = 0;
	virtual const std::vector<MotionEvent>& endedEvents() const                                    = 0;
	virtual void                            setEndedEvents(const std::vector<MotionEvent>& events) = 0; ///< for a run that goes on

	// ---- state -------------------------------------------------------------------------------------------------------------
	/// All fields that exist, of points and nodes.
	virtual std::vector<FieldInfo> fields() const        = 0;
	virtual PointFields&           pointFields()         = 0; ///< arrays by place
	virtual int                    placeOf(int id) const = 0; ///< of a point, until points are sorted
	virtual int                    idAt(int place) const = 0;
	virtual int*                   skeletonNumbers()     = 0; ///< by place

	/// Points that have divided, one for each that came of it: those have the ids that follow the given ones, in this order.
	virtual const std::vector<int>& divisions() const = 0;
	/// After initialise(), before a state is restored: divides points as they were divided before that was saved.
	virtual void repeatDivisions(const std::vector<int>& parents) = 0;

	/// One component of a point field in the order of ids, to out[0..count). Throws std::invalid_argument listing the fields.
	virtual void copyById(const std::string& field, int component, double* out) const = 0;

	/// Points of one skeleton model, and what the model says of them.
	virtual SkeletonPoints skeletonPoints(int skeleton) const                         = 0;
	virtual void           startSkeleton(int skeleton)                                = 0; ///< sets its initial state anew
	virtual void           tangentModulus(int skeleton, double* modulusByPlace) const = 0;

	/// Sets the temperature [degC] and pressure [Pa] of a point (by id), with masses and enthalpy to match.
	virtual void setThermalState(int id, double temperature, double pressure) = 0;

	/// Complete state: everything that has to be written and read back, in this order, for a run to continue bit for bit. Call on
	/// an initialised ground with the same settings and points.
	virtual std::vector<StateArray> state() = 0;
	/// To be called after the arrays of state() were overwritten.
	virtual void stateRestored() = 0;

	// The same where the arrays of points lie in a file and each rank has to do with its own points only:
	/// Those arrays of state() that are numbers of points by place, the first of it, with what is there of other ranks' points. Then the rest.
	virtual std::vector<StateArray> pointState()  = 0;
	virtual std::vector<StateArray> commonState() = 0;
	/// Writes pointState() of all ranks, array by array; one rank may call it. Returns what it adds to the sum of the file. Throws
	/// std::runtime_error with the rank and the reason.
	virtual std::uint64_t writePoints(const FilePlace&) = 0;
	/// After the arrays of commonState() were overwritten, in place of stateRestored(): each rank reads what it computes.
	virtual void readPoints(const PartedFile&, std::uint64_t at) = 0;

protected:
	AnyGround()                                = default;
	AnyGround(AnyGround&&) noexcept            = default;
	AnyGround& operator=(AnyGround&&) noexcept = default;
};

} // namespace talik
