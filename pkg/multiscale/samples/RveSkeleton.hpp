// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Scene.hpp>
#include <pkg/icebond/IceStrengthAndCreep.hpp>
#include <pkg/multiscale/samples/OpenStore.hpp>
#include <pkg/multiscale/samples/PackedStore.hpp>
#include <pkg/multiscale/samples/RveSample.hpp>
#include <pkg/multiscale/samples/SampleSkeleton.hpp>
#include <pkg/multiscale/settings/SkeletonLaws.hpp>
#include <pkg/python/ScriptValues.hpp>
#include <variant>

namespace yade {

/// Skeleton law of Yu & Zhao: one periodic sample of grains behind every material point.
class RveSkeleton : public SkeletonLaw {
public:
	Model<2>            build(const Places<2>& places) override;
	Model<3>            build(const Places<3>& places) override;
	bool                sourcesChanged() const override;
	bool                beginsWithOwnStress() const override { return true; }
	bool                changedByHand() const override { return byHand; }
	string              saved(talik::CheckpointParts* beside) const override;
	void                restore(const string& bytes, const talik::CheckpointParts::Source* beside) override;
	void                followAttributes() override;
	bool                admitsPoints() const override { return !model; }
	void                setTolerance(Real tolerance) override { running().setTolerance(tolerance); }
	talik::ErrorSquares errorSquares(const talik::SkeletonPoints& points) const override { return running().errorSquares(points); }
	void                keepOnly(const talik::SkeletonPoints& points) override { running().keepOnly(points); }
	string              notInSlabs(int dimension) const override;
	bool                shareAmongRanks(const string& what) override
	{
		sharedOut = what != "none";
		return true;
	}

	/// The model of a ground in the plane (Dim 2, samples of discs) or in space (Dim 3, spheres); sampleOf as below, by point id.
	template <int Dim> std::shared_ptr<talik::SampleSkeleton<Dim>> makeModel(const vector<int>& numbers);

	/// Numbers of the samples, 0 to samples-1, that points at these places [m] (n,2) or (n,3) take by chance.
	static ::boost::python::list deal(const ::boost::python::object& position, int samples, int seed);
	/// The sample of a point as it is now, a copy: packed, or as a scene.
	shared_ptr<RveSample>   sample(int id) const;
	shared_ptr<Scene>       scene(int id) const;
	void                    replaceSample(int id, const shared_ptr<RveSample>&);
	void                    replaceScene(int id, const shared_ptr<Scene>&);
	bool                    hasSample(int id) const { return running().has(id); }
	::boost::python::object values(const string& name) const override;
	vector<Real>            valueAt(const string& name, int id) const override;
	vector<string>          measures() const override;
	::boost::python::list   pyMeasures() const;
	::boost::python::dict   cost() const;
	::boost::python::dict   blownUp() const;

private:
	/// The samples of a run.
	template <int Dim> struct Stores {
		static constexpr int                        dimension = Dim;
		std::shared_ptr<talik::SampleSkeleton<Dim>> model;
		std::shared_ptr<talik::PackedStore<Dim>>    packed; ///< one of the two
		std::shared_ptr<talik::OpenStore<Dim>>      open;
	};
	talik::PointSamples& running() const;
	/// Calls it with the samples of the run.
	template <class Visitor> decltype(auto) withStores(Visitor&& visitor) const { return std::visit(std::forward<Visitor>(visitor), now); }
	talik::SampleScheduling                 scheduling() const;
	void                                    checkSettings(int pointCount);
	bool                                    bondsCarryMoments() const;
	void                                    keepBlownUp(int id) const;
	string                                  reasonAgainstPacking(int dimension) const;
	template <int Dim> void                 makeStore(Stores<Dim>&);
	template <int Dim> void                 useDevice(Stores<Dim>&);
	template <int Dim> vector<int>          assigned(const Places<Dim>& places) const;
	template <int Dim> void                 prepareSlip(Stores<Dim>&);
	void                                    measureFriction(const vector<shared_ptr<RveSample>>& packed, const vector<string>& open, int dimension);

	std::shared_ptr<talik::PointSamples>     model; ///< that of `now`
	std::variant<Stores<2>, Stores<3>>       now;
	vector<shared_ptr<RveSample>>            prototypes;  ///< of packed samples
	std::vector<std::shared_ptr<const void>> takenStates; ///< of `samples` when they were built from
	std::vector<std::size_t>                 takenScenes; ///< digests of `scenes` then
	bool                                     byHand      = false;
	bool                                     told        = false;
	string                                   deviceInUse = "cpu";
	bool                                     sharedOut   = false; ///< among the ranks of the job, with the points

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(RveSkeleton,SkeletonLaw,"A periodic sample of grains with ice bonds behind every material point: it gets the displacement "
			"gradient and the ice saturation of its point when they have changed enough, returns effective stress, and keeps its history. Samples that were never "
			"updated share one state. Example: RveSkeleton(samples=[talik.rve.pack(talik.rve.prepare(grains=100))]).",
		((vector<shared_ptr<RveSample>>,samples,,,"Prepared samples, ice-free; the first step freezes them to the ice saturation of their points, free of stress."))
		((vector<shared_ptr<Scene>>,scenes,,,"Further samples, numbered after those: ordinary periodic YADE scenes (O._sceneObj) of any grains and contact law that "
				"stock YADE runs."))
		((string,form,"packed",,"packed: fused step (default), or open: YADE's own engines, a Scene behind every point that was updated. If one of the scenes cannot "
				"be packed all run open, with a message; an update then takes 20 to 30 times as long."))
		((vector<int>,sampleOf,,,"Which of the samples each point takes, by point id; empty: they are assigned to the points at random, see seed. See "
				"talik.slope.depthBands."))
		((int,seed,1,,"Seed of the random numbers by which samples are assigned to points where sampleOf is empty, >= 0. The place of a point and the seed decide, "
				"not the order of the points or the number of threads."))
		((Real,strainTolerance,2e-5,,"A sample is updated when a component of its accumulated displacement gradient exceeds this [-]; 0: in every step (the "
				"reference). Where MpmEngine.tolerance is set this is the initial value of every point, which then follows the measured errors."))
		((Real,saturationTolerance,0.01,,"A sample is also updated when its ice saturation has changed by this [-]; 0: at every change. Where MpmEngine.tolerance is "
				"set it is a third of that."))
		((bool,prediction,true,,"Between two updates the contact network's tangent predicts the stress; False: it is held."))
		((Real,stressTolerance,0.05,,"Relative error of that prediction [-]: the strain tolerance of each point is adapted to it, within a factor of ten. "
				"A sample is also updated when the prediction has changed its stress by twice that, eq. (15.2). 0: fixed tolerance, no such limit. Not used where "
				"MpmEngine.tolerance is set."))
		TALIK_ATTRIBUTES_OF_DEM_STEPS
		((shared_ptr<IceStrength>,iceStrength,,,"How strength and stiffness of the ice bonds follow the temperature of the point, and strength its strain rate in "
				"physical (calendar) time: strain since the last update of the sample over the calendar time since then. None: they are those of the samples."))
		((shared_ptr<IceCreep>,iceCreep,,,"How the ice bonds creep at the temperature of the point, over the calendar time since the sample was last updated; one "
				"that holds ice is updated in every step. None: they do not."))
		((Real,slipFriction,std::numeric_limits<double>::quiet_NaN(),,"Coulomb friction at the thaw front, shear over normal stress, eq. (20.2) [-], >= 0. "
				"nan (default): it is measured when the first of them thaws there, see measuredFriction. talik.studies.calibrate.thawedFriction measures it, too, over "
				"pressures and realisations."))
		((Real,slipCohesion,0,,"Cohesion at the thaw front, with slipFriction [Pa], >= 0. It stays where bonds of the samples break."))
		((Real,measuredFriction,std::numeric_limits<double>::quiet_NaN(),Attr::readonly,"Where slipFriction is nan and samples have met a thaw front: shear over "
				"normal stress of its samples in steady simple shear without ice [-], a mean over eight runs of up to eight samples (two runs where they run open), "
				"of shear 0.3 to 2 each, the first 0.15 of which does not count. nan before."))
		((Real,measuredFrictionError,std::numeric_limits<double>::quiet_NaN(),Attr::readonly,"Standard error of measuredFriction, from the scatter of the runs [-]."))
		((string,device,"cpu",,"Where packed samples are computed: cpu (the processor), gpu (a graphics card of NVIDIA), auto (a card if there is "
				"one). Results are identical. What a card cannot do with them stays on the processor, and so do all samples if the card is missing, too "
				"small or lost, with a message. A card pays where some thousand samples are updated in a step, see the manual. twin runs the kernels of the card "
				"on the processor, slowly, for tests. May be changed while running."))
		((int,threads,0,,"Threads over the samples; each sample is computed by one of them. 0: as many as yade was given (-j). Results do not depend on it. May be "
				"changed while running."))
		((string,onBlowUp,"stop",,"When a sample blows up: stop (the step is completed, then an exception names the point) or isolate (the point keeps its last "
				"stress from then on; see blownUp). May be changed while running."))
		((string,blowUpFolder,"blown-up-samples",,"Folder into which the last good state of a sample that blew up is written as a YADE scene, point<id>.yade, for "
				"O.load; empty: none is written. scene(id) gives it in any case. May be changed while running."))
		,/*ctor*/ talik::SequenceConverter<Scene>::registerOnce(); ,
		/*py*/
		.def("deal",&RveSkeleton::deal,(::boost::python::arg("position"),::boost::python::arg("samples"),::boost::python::arg("seed")=1),"List: the number, 0 to "
				"samples-1, of the sample that is assigned at random to a point at each position (n,2) or (n,3) [m].").staticmethod("deal")
		.def("sample",&RveSkeleton::sample,(::boost::python::arg("id")),"A copy of the sample behind a point, as RveSample. ValueError if it cannot be packed: see "
				"scene.")
		.def("scene",&RveSkeleton::scene,(::boost::python::arg("id")),"A copy of the sample behind a point as a YADE scene, in either form. See talik.inspect.")
		.def("replaceScene",&RveSkeleton::replaceScene,(::boost::python::arg("id"),::boost::python::arg("scene")),"Put a scene behind a point; the next step updates "
				"it. Bonds lost or made by hand are counted. ValueError if it cannot be a sample: the point keeps the one it had.")
		.def("replaceSample",&RveSkeleton::replaceSample,(::boost::python::arg("id"),::boost::python::arg("sample")),"Put another state behind a point; the next "
				"step updates it.")
		.def("hasSample",&RveSkeleton::hasSample,(::boost::python::arg("id")),"True if a sample of this skeleton is behind the point.")
		.def("measures",&RveSkeleton::pyMeasures,"Names that values() and MpmEngine.field() take.")
		.def("values",&RveSkeleton::values,(::boost::python::arg("name")),"A measure of all samples as a NumPy array by point id, NaN where a point has none: "
				"bondsIntact (now); since preparation bondsFormed, bondsBroken (mechanically), bondsMelted; contacts, coordinationNumber, samplePorosity, "
				"sampleIceSaturation, cellThickness (distance of a grain's next image over the mean diameter), cellSlips (how often a thin cell slipped), "
				"fabric (n,3) xx yy xy, in space (n,6) xx yy zz yz xz xy, of mean n(x)n.")
		.def("cost",&RveSkeleton::cost,"Dictionary: form (packed or open), points, calls (updates), steps (DEM), seconds, distinctStates, bytes. If "
				"ranks divide the ground, seconds and bytes are those of this rank, and there are: owned, samples of this rank; "
				"moved, how often one went to another rank (each of several that share a state counts); balance, mean over largest cost of the ranks [-]. If "
				"device is not cpu: onDevice, updates that a device did; endedOnProcessor, those that it began (flipped cells, lists that outgrow their place); "
				"leftToProcessor; listsOnDevice, neighbour lists built there; deviceSeconds, where the time of the updates goes [s]: making calls, sending "
				"them, waiting for the device, receiving its answers, taking them. The device rests but while it is waited for.")
		.add_property("blownUp",&RveSkeleton::blownUp,"Points whose sample blew up, with the reason.")
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(RveSkeleton);

} // namespace yade
