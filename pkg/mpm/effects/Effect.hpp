// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/points/PointFields.hpp>
#include <pkg/mpm/points/PointsInMotion.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <limits>
#include <string>

namespace talik {

template <int D> struct GroundSettings;

/// An effect of moving ground that a scene may have, beside those that Ground calls by name; see "How to add an effect" in pkg/mpm/how-to.md.
/// It overrides what it needs. Loops over strips call it from several threads, each with points of its own.
template <int D> class Effect {
public:
	virtual ~Effect() = default;

	/// Also of its line in Ground::cost() and of its limit of the time step.
	virtual std::string name() const = 0;
	/// Throws std::invalid_argument naming attribute, value and remedy.
	virtual void validate(const GroundSettings<D>&) const {}

	/// Declares fields of its own on the points; persistent ones are sorted, go from rank to rank and into checkpoints.
	virtual void declareFields(PointFields&) {}
	/// Once, when the points of this rank, first to last - 1, have their fields and initial values. Arrays of its own fields stay where they are.
	virtual void start(PointFields& fields, int first, int last) { (void)fields, (void)first, (void)last; }

	/// True if addStress() does anything.
	virtual bool addsStress() const { return false; }
	/// p2g: changes the stress with which points first to last - 1 enter the momentum balance, points.addedStress.
	virtual void addStress(const StepContext<D>& step, const PointsInMotion<D>& points, int first, int last) const
	{
		(void)step, (void)points, (void)first, (void)last;
	}

	/// updateStrainAndPressure: displacement gradient and volume of points first to last - 1 are those of the step. Work that the effect has done on
	/// this strain is booked in account.
	virtual void followStrain(const StepContext<D>& step, const PointsInMotion<D>& points, int first, int last, StepAccount<D>& account)
	{
		(void)step, (void)points, (void)first, (void)last, (void)account;
	}

	/// Largest stable step for a point [s] on a grid of this spacing [m].
	virtual double largestStep(const PointsInMotion<D>& points, int place, double spacing) const
	{
		(void)points, (void)place, (void)spacing;
		return std::numeric_limits<double>::infinity();
	}
	virtual bool limitsStep() const { return false; }
};

} // namespace talik
