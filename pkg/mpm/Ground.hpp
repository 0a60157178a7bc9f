// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/AnyGround.hpp>
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
template <int D> class Ground final : public AnyGround {
public:
	Ground();
	explicit Ground(const GroundSettings<D>& settings);
	~Ground() override;
	Ground(Ground&&) noexcept;
	Ground& operator=(Ground&&) noexcept;

	int dimension() const override { return D; }

	/// To be changed before initialise() only, except gravity, localDamping, flip fractions, time step fractions.
	GroundSettings<D>&            settings();
	const GroundSettings<D>&      settings() const;
	SettingsOfAnyDimension&       commonSettings() override { return settings(); }
	const SettingsOfAnyDimension& commonSettings() const override { return settings(); }
	MotionOfAnyDimension*         motionSettings() override { return settings().motion ? &*settings().motion : nullptr; }

	/// Adds a point and returns its id, which counts from 0 and never changes.
	int addPoint(const PointInput<D>& point);
	/// All points in place of these, each of which initialise() asks for: a rank in slabs holds its own only.
	void takePoints(int count, std::function<PointInput<D>(int id)> point);

	void distribute(std::shared_ptr<Communicator> communicator, bool required = true) override;
	bool inSlabs() const override;
	void initialise() override;
	bool initialised() const override;

	/// Advances by dt [s] > 0: all calls below in turn.
	void step(double dt);
	void beginStep(double dt) override;
	void p2g() override;
	void solveNodes() override;
	void g2p() override;
	void updateStrainAndPressure() override;
	void updateEffectiveStress() override;

	StableTimeStep stableTimeStep() const override;

	/// Sums and logged exchanges. Costs a pass over the points.
	Balance<D> balance() const;

	std::vector<std::pair<std::string, double>> cost() const override;

	// ---- time --------------------------------------------------------------------------------------------------------------
	double                          time() const override;
	double                          dt() const override;
	long                            steps() const override;
	const CalendarState&            calendar() const override;
	double                          seepageScale() const override;
	double                          largestConductivity() const override;
	void                            setCalendar(double time) override;
	std::vector<MotionEvent>        events() const override;
	const std::vector<MotionEvent>& endedEvents() const override;
	void                            setEndedEvents(const std::vector<MotionEvent>& events) override;

	// ---- state -------------------------------------------------------------------------------------------------------------
	const Grid<D>&           grid() const;
	MaterialPoints<D>&       points();
	const MaterialPoints<D>& points() const;

	/// Contact with rigid bodies; nullptr in a scene without. Call on an initialised ground.
	RigidContact<D>* bodies();

	std::vector<FieldInfo>  fields() const override;
	PointFields&            pointFields() override;
	int                     placeOf(int id) const override { return points().place(id); }
	int                     idAt(int place) const override { return points().id(place); }
	int*                    skeletonNumbers() override { return points().skeletons(); }
	const std::vector<int>& divisions() const override;
	void                    repeatDivisions(const std::vector<int>& parents) override;
	void                    copyById(const std::string& field, int component, double* out) const override;

	/// Points of one skeleton model as the model sees them.
	SkeletonBatch<D> skeletonBatch(int skeleton) const;
	SkeletonPoints   skeletonPoints(int skeleton) const override { return skeletonBatch(skeleton); }
	void             startSkeleton(int skeleton) override;
	void             tangentModulus(int skeleton, double* modulusByPlace) const override
	{
		settings().skeletons[skeleton]->tangentModulus(skeletonBatch(skeleton), modulusByPlace);
	}

	void                    setThermalState(int id, double temperature, double pressure) override;
	std::vector<StateArray> state() override;
	void                    stateRestored() override;
	std::vector<StateArray> pointState() override;
	std::vector<StateArray> commonState() override;
	std::uint64_t           writePoints(const FilePlace&) override;
	void                    readPoints(const PartedFile&, std::uint64_t at) override;

private:
	struct Parts;
	std::unique_ptr<Parts> parts_;
};

} // namespace talik
