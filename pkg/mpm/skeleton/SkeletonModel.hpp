// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Vector.hpp>
#include <pkg/mpm/points/PointFields.hpp>

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace talik {

class SlabDecomposition;

/// Thrown by a skeleton model that has given every point a stress and wants the run to stop: Ground ends the step first and passes
/// it on from updateEffectiveStress().
class StopAfterStep : public std::runtime_error {
public:
	using std::runtime_error::runtime_error;
};

/// How much time passes in the step that a law is asked about.
struct StepTime {
	double motion   = 0; ///< Delta t [s]: a rate of strain is the strain of the step over it
	double calendar = 0; ///< Delta t_c [s], physical time of slow processes such as heat and creep: Delta t times the scale of the calendar
};

/// The material points that share one skeleton model. All arrays are indexed by the place of a point, i.e. volume[place[k]] for
/// k < count; places change when points are sorted, id[place] never does.
struct SkeletonPoints {
	int           count         = 0;
	const int*    place         = nullptr; ///< ascending
	const int*    id            = nullptr; ///< indexed by place: the number the user knows
	const double* iceSaturation = nullptr; ///< S_i [-] of the new state; nullptr in ground that does not freeze
	const double* volume        = nullptr; ///< current volume [m^D]
	const double* temperature   = nullptr; ///< [degC]; nullptr in ground without heat
	StepTime      time;
	int           strip = 0; ///< whose points these are, for a model that sees strips
	/// Gives all of them one value, by place.
	void fill(double* values, double value) const
	{
		for (int k = 0; k < count; ++k)
			values[place[k]] = value;
	}
};

/// What the model of some points reads and writes besides.
template <int D> struct SkeletonBatch : SkeletonPoints {
	/// Displacement gradient of this step, Delta t dv_i/dx_j at [i*D+j] [-], with B-bar: the divergence is
	/// the volume-weighted mean of the cell. F_new = (1 + gradient) F_old.
	std::array<const double*, D * D> gradient {};
	/// Direct strain of this step around the axis, component zz, in a plane that turns; null: zero.
	const double* hoop = nullptr;
	const double* hoopFrom(int first) const { return hoop ? hoop + first : nullptr; }
	/// Effective Cauchy stress [Pa], tension positive, to be updated in place; order of stressIndex<D>().
	std::array<double*, stressSize<D>> stress {};
};

/// Shear stress that ground carries when it fails in simple shear: cohesion and friction times the effective normal stress.
struct ShearStrength {
	double friction; ///< [-], >= 0
	double cohesion; ///< [Pa], >= 0
};

/// Law that turns strain and ice saturation into effective stress. Each point has one; a scene may use several.
template <int D> class SkeletonModel {
public:
	virtual ~SkeletonModel() = default;

	virtual std::string name() const = 0;

	/// Throws std::invalid_argument naming attribute, value and remedy.
	virtual void validate() const {}

	/// False if stress is never limited by strength: such ground does not slip.
	virtual bool canFail() const { return true; }

	/// Strength in simple shear at an ice saturation. None: at the thaw front such ground stays together with frozen ground.
	virtual std::optional<ShearStrength> shearStrength(double iceSaturation) const
	{
		(void)iceSaturation;
		return {};
	}

	/// False if it takes the strain around the axis of a turned plane for zero.
	virtual bool knowsHoopStrain() const { return false; }

	/// Declares fields of its own on the points (they are sorted and checkpointed with the rest); prefix makes names unique.
	virtual void declareFields(PointFields&, const std::string& prefix) { (void)prefix; }

	/// Called once, after the fields exist and initial stresses are set.
	virtual void initialise(const SkeletonBatch<D>&) {}
	/// In slabs it has to see the points of all ranks there, of which only the ice saturation is that of its rank; it sets those of this one.
	virtual bool beginsWithAll() const { return false; }

	/// Points have divided: those with the next ids are halves of these, whose state they have. What the model keeps by id is for them, too. The same on
	/// all ranks.
	virtual void divide(const std::vector<int>& parents) { (void)parents; }

	/// In a ground in slabs, when they were cut: by the ids of the points of all ranks in the order of places it knows whose they are. What it
	/// keeps behind points goes with them to their rank. moved: false where all ranks have the same, or what they have is replaced next; true in
	/// a run, and then collective.
	virtual void followSlabs(SlabDecomposition&, const int* ids, bool moved)
	{
		(void)ids;
		(void)moved;
	}

	/// updateStress() is called for the points of one strip after the other, as it is on any number of ranks, and may throw on one of them.
	virtual bool seesStrips() const { return false; }

	/// Adds what these points have cost beyond the ground itself since it was asked last, in steps of a point of the ground: slabs follow the cost.
	virtual void addCost(const SkeletonPoints&, double* costByPlace) { (void)costByPlace; }

	/// Step 3 of the paper: effective stress from the strain of the step and the ice saturation. Runs its own threads. In slabs every rank is
	/// asked for its own points, also where it has none, and all of them throw or none.
	virtual void updateStress(const SkeletonBatch<D>&) = 0;

	/// Tangent oedometer modulus M_t [Pa] of every point of the batch, to modulus[place]; for the stable time step.
	virtual void tangentModulus(const SkeletonBatch<D>&, double* modulus) const = 0;
};

} // namespace talik
