// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Calendar.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace talik {

template <int D> class RigidContact;

/// Ground as a two-phase thermo-hydro-mechanical material point model, composed of the effects that the scene has.
///
/// Use: fill settings(), add points, initialise(), then step(dt) again and again, or the calls that it consists of. The step
/// is the cycle of Yu & Zhao, section 2.3, cut so that stress and pressure at its end belong to the velocities just solved.
/// Results are bit-identical for any number of threads.
template <int D> class Ground {
public:
	Ground();
	explicit Ground(const GroundSettings<D>& settings);
	~Ground();
	Ground(Ground&&) noexcept;
	Ground& operator=(Ground&&) noexcept;

	/// To be changed before initialise() only, except gravity, localDamping, flip fractions, time step fractions and resting.
	GroundSettings<D>&       settings();
	const GroundSettings<D>& settings() const;

	/// Adds a point and returns its id, which counts from 0 and never changes.
	int addPoint(const PointInput<D>& point);

	/// Checks everything, allocates all fields and sets the initial state. Throws std::invalid_argument naming attribute, value
	/// and remedy.
	void initialise();
	bool initialised() const;

	// ---- one step, in the order of the paper -------------------------------------------------------------------------------
	/// Advances by dt [s] > 0: all calls below in turn.
	void step(double dt);
	void beginStep(double dt);      ///< sets the length of the step, sorts points if needed
	void p2g();                     ///< mass, momentum, internal force, enthalpy (step 1)
	void solveNodes();              ///< heat flows, temperature; nodal forces, node-implicit drag, seepage fluxes; boundaries (step 4)
	void g2p();                     ///< velocity, displacement, position, received heat and water (step 5)
	void updateStrainAndPressure(); ///< strain, volume, porosity, temperature, ice saturation, pore pressure (step 2 of the next cycle)
	void updateEffectiveStress();   ///< asks the skeleton models (step 3 of the next cycle); ends the step

	/// Largest stable step with the present state and which limit governs it. Prints nothing, changes nothing.
	StableTimeStep stableTimeStep() const;

	/// Sums and logged exchanges. Costs a pass over the points.
	Balance<D> balance() const;

	/// Wall time spent since the start by effect [s]: name and seconds of every effect that the scene has, in a fixed order. Passes
	/// that serve several effects are shared out by samples; the whole costs less than a hundredth of a step.
	std::vector<std::pair<std::string, double>> cost() const;

	/// True if heat had nothing to do in the last step and rested.
	bool heatRests() const;
	/// True if no water moved through the skeleton in the last step, so that nothing seeped.
	bool waterRests() const;

	// ---- state -------------------------------------------------------------------------------------------------------------
	double time() const;  ///< [s]
	long   steps() const; ///< done so far
	/// Calendar time, scale of the last step, what the next one follows from; an event if one goes on.
	const CalendarState& calendar() const;
	double               seepageScale() const;        ///< f_H in the last step [-]; 1 without water
	double               largestConductivity() const; ///< up to which seepage is hastened [m/s], see PoreWater; infinite without water
	/// Between two steps: the calendar says this time [s] from now on, and events are counted anew.
	void setCalendar(double time);
	/// Events that ended so far, and the one that goes on as the last if there is one. Empty unless the scale follows the motion.
	std::vector<MotionEvent>        events() const;
	const std::vector<MotionEvent>& endedEvents() const;
	void                            setEndedEvents(const std::vector<MotionEvent>& events); ///< for a run that goes on
	double                          dt() const;                                             ///< of the present or last step [s]

	const Grid<D>&           grid() const;
	MaterialPoints<D>&       points();
	const MaterialPoints<D>& points() const;

	/// Contact with rigid bodies; nullptr in a scene without. Call on an initialised ground.
	RigidContact<D>* bodies();

	/// All fields that exist, of points and nodes.
	std::vector<FieldInfo> fields() const;

	/// One component of a point field in the order of ids, to out[0..count). Throws std::invalid_argument listing the fields.
	void copyById(const std::string& field, int component, double* out) const;

	/// Points of one skeleton model as the model sees them.
	SkeletonBatch<D> skeletonBatch(int skeleton) const;

	/// Sets the temperature [degC] and pressure [Pa] of a point (by id), with masses and enthalpy to match.
	void setThermalState(int id, double temperature, double pressure);

	/// Complete state: everything that has to be written and read back, in this order, for a run to continue bit for bit. Call on
	/// an initialised ground with the same settings and points.
	std::vector<StateArray> state();
	/// To be called after the arrays of state() were overwritten.
	void stateRestored();

private:
	struct Parts;
	std::unique_ptr<Parts> parts_;
};

extern template class Ground<2>;
extern template class Ground<3>;

} // namespace talik
