// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/GlobalEngine.hpp>
#include <core/Scene.hpp>
#include <pkg/python/ScriptValues.hpp>
#include <pkg/rve/open/OpenSample.hpp>
#include <pkg/rve/open/ScenePacking.hpp>
#include <pkg/rve/packed/PackedSample.hpp>
#include <variant>

/// Attributes of a class that moves samples: options of PackedUpdateOptions by the same names.
#define TALIK_ATTRIBUTES_OF_DEM_STEPS                                                                                                      \
	((Real, maxInertialNumber, 5e-3, ,                                                                                                 \
	  "I_max: bounds the strain of a DEM step, 1e-3 careful, 5e-3 production [-]. Behind points it is steered where "                  \
	  "MpmEngine.tolerance is set."))(                                                                                                 \
	        (Real, maxStrainPerStep, 1e-5, , "Largest strain of a DEM step of the sample's own length, see timeStepFollowsIce [-]."))( \
	        (int, minSteps, 10, , "Fewest DEM steps of an update with motion, >= 1."))(                                                \
	        (bool, timeStepFollowsIce, true, ,                                                                                         \
	         "Motion takes longer DEM steps where ice is missing, at the same strain rate: the time step of a sample bears "           \
	         "the stiffness of full ice, and without ice it can be longer by the root of 1 + iceYoung/young. False: always "           \
	         "that of the sample, as where steps are compared with those of an ordinary scene."))

namespace yade {

/// The packed form of a sample: all of its grains, contacts and bonds in contiguous arrays inside one YADE engine, advanced by
/// a fused step. As the only engine of a Scene it is that scene; open() makes the ordinary YADE scene of it.
class RveSample : public GlobalEngine {
public:
	void action() override;

	/// Takes the packed form of a scene; ValueError says why one cannot be packed.
	static shared_ptr<RveSample> fromScene(const shared_ptr<Scene>&);
	shared_ptr<Scene>            open() const;
	/// Takes over what was done to an opened scene.
	void repack(const shared_ptr<Scene>&);

	::boost::python::dict apply(const Matrix3r& displacementGradient, Real iceSaturation, const ::boost::python::object& creep = ::boost::python::object());
	void                  advance(const Matrix3r& velGrad, long steps);
	void                  freeze(Real iceSaturation);
	bool                  servo(Real stressX, Real stressY, const ::boost::python::object& stressZ);
	::boost::python::tuple  stress() const;
	::boost::python::dict   statistics() const;
	::boost::python::dict   arrays() const;
	shared_ptr<RveSample>   copy() const;
	Real                    iceSaturation() const;
	Real                    timeStep() const;
	void                    setTimeStep(Real);
	Real                    thawStrain() const;
	void                    setThawStrain(Real);
	Real                    thawedStrength() const;
	void                    setThawedStrength(Real);
	Real                    thickness() const;
	Matrix3r                deformation() const;
	::boost::python::object stateBytes() const;
	string                  path() const;
	static void             usePortablePath(bool portable) { talik::PackedSample<2>::forcePortable(portable); }

	/// 2 for discs, 3 for spheres. Throws std::runtime_error on an empty sample.
	int dimension() const;
	/// Throws std::invalid_argument on a sample of the other dimension.
	template <int Dim> const talik::PackedState<Dim>& packed() const;
	std::size_t                                       digest() const; ///< of the whole state
	/// Another one whenever the state has changed; empty sample: null.
	std::shared_ptr<const void> stateNow() const;
	template <int Dim> void     setPacked(talik::PackedState<Dim>);

	void preSave(RveSample&);
	void postLoad(RveSample&);

private:
	template <int Dim> using StatePointer = std::shared_ptr<const talik::PackedState<Dim>>;
	/// Calls it with the state.
	template <class Visitor> decltype(auto) withState(Visitor&& visitor) const { return dimension() == 2 ? visitor(packed<2>()) : visitor(packed<3>()); }
	template <int Dim>::boost::python::dict applied(const Matrix3r& displacementGradient, Real iceSaturation, const talik::BondCreep& creep);

	std::variant<StatePointer<2>, StatePointer<3>> state;
	string                                         sceneBytes;

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(RveSample,GlobalEngine,"Packed periodic sample of discs or spheres with optional ice bonds, as it is used "
			"behind material points. Made by talik.rve.pack(sample) from a prepared sample or any packable YADE scene; open() gives the ordinary YADE "
			"scene back. Stress in Pa, tension positive. Example: s=talik.rve.pack(talik.rve.prepare(grains=100)); s.freeze(1); "
			"s.apply(Matrix3(0,1e-3,0, 0,0,0, 0,0,0),1); s.stress.",
		TALIK_ATTRIBUTES_OF_DEM_STEPS
		((Real,tensileStrengthFactor,1,,"Tensile strength of ice bonds in apply() and freeze() over that of the material [-], > 0: the first number of "
				"IceStrength.factors(temperature,strainRate). Of this sample alone; behind points RveSkeleton.iceStrength does that."))
		((Real,shearStrengthFactor,1,,"The same of the shear strength [-], > 0: the second number."))
		((Real,iceStiffnessFactor,1,,"Stiffness of the ice in apply() and freeze() over that of the material [-], > 0 to 2: "
				"IceStrength.stiffnessFactor(temperature). Forces stay when it changes."))
		((string,saved,"",Attr::hidden,"State in an archive."))
		((string,savedScene,"",Attr::hidden,"Scene that the sample opens into, in an archive."))
		,/*ctor*/ talik::SequenceConverter<RveSample>::registerOnce(); ,
		/*py*/
		.def("fromScene",&RveSample::fromScene,(::boost::python::arg("scene")),"Packed form of a YADE scene (O._sceneObj). ValueError tells why a scene cannot be "
				"packed.").staticmethod("fromScene")
		.def("open",&RveSample::open,"A new ordinary YADE scene in the sample's state: bodies, interactions, bonds, engines. See talik.inspect.")
		.def("repack",&RveSample::repack,(::boost::python::arg("scene")),"Take over the state of an opened scene.")
		.def("apply",&RveSample::apply,(::boost::python::arg("displacementGradient"),::boost::python::arg("iceSaturation"),
				::boost::python::arg("creep")=::boost::python::object()),"Apply F_new = (1+displacementGradient) "
				"F_old (3x3; of discs the in-plane part) and bring the ice saturation to its target; history is kept. creep: what "
				"IceCreep.over(temperature,time) returns; before the motion ice bonds relax by it. Returns a dictionary: stress as below, "
				"steps, flipped, slipped (a thin cell has slipped, see pkg/rve/README.md), blewUp, reason.")
		.def("advance",&RveSample::advance,(::boost::python::arg("velGrad"),::boost::python::arg("steps")),"Advance by DEM steps under a velocity gradient [1/s, "
				"DEM time] (3x3; of discs the in-plane part), as YADE does when O.cell.velGrad is set: the cell follows one step later.")
		.def("freeze",&RveSample::freeze,(::boost::python::arg("iceSaturation")),"Freeze at rest to an ice saturation, 0 to 1: bonds and ice springs form "
				"stress-free.")
		.def("servo",&RveSample::servo,(::boost::python::arg("stressX"),::boost::python::arg("stressY"),::boost::python::arg("stressZ")=::boost::python::object()),
				"Bring the sample to principal stresses [Pa], all negative; stressZ for spheres only. True when they were reached.")
		.def("statistics",&RveSample::statistics,"Dictionary: contacts and bondsIntact (now), since preparation bondsFormed, bondsBroken = bondsBrokenInTension + "
				"bondsBrokenInShear, and bondsMelted, as MpmEngine.field has them; brokenBondsInContact, those that broke and whose grains touch now; "
				"coordinationNumber, porosity, fabric (components as of stress), unbalancedForce, kineticEnergy, cellThickness (distance of a grain's next "
				"image over the mean diameter), cellSlips (how often a thin cell slipped), cellSlipStrain (the strain that took, in all [-]), cellSlipStress "
				"(the most stress that was missing afterwards [Pa]), steps (DEM steps done so far).")
		.def("arrays",&RveSample::arrays,"Dictionary of NumPy arrays for d=2 or 3 dimensions: position (n,d) [m], radius (n,) [m], contact (m,2) grain indices, "
				"cellDist (m,d), bond (m,) 0 frictional 1 intact 2 broken, shear (m,) or (m,3) [N], hSize (d,d) [m].")
		.def("copy",&RveSample::copy,"An independent copy.")
		.add_property("stress",&RveSample::stress,"(xx, yy, xy) [Pa] of discs, (xx, yy, zz, yz, xz, xy) of spheres, tension positive, of the last step.")
		.add_property("dimension",&RveSample::dimension,"2: discs, 3: spheres.")
		.add_property("iceSaturation",&RveSample::iceSaturation,"Ice saturation [-]; change it by freeze() or apply().")
		.add_property("dt",&RveSample::timeStep,&RveSample::setTimeStep,"DEM time step [s].")
		.add_property("thawStrain",&RveSample::thawStrain,&RveSample::setThawStrain,"Area strain that the grains release on complete thaw [-]: eq. (8) of Yu & Zhao "
				"as mechanical shrinkage of grains prepared frozen, (r/r_0)^2 = 1-thawStrain*(1-S_i/S_frozen), S_frozen the largest ice saturation so far; not undone by "
				"refreezing. From 0 (default, bookkeeping: grains keep their radii) to the porosity of the sample (all of eq. 8); set it before the sample freezes. A "
				"scene opened from it keeps the radii of that moment; one that goes on behind a point (MpmEngine.inspect, form='open') has a GrainSwelling.")
		.add_property("thawedStrength",&RveSample::thawedStrength,&RveSample::setThawedStrength,"Tensile and cohesive shear strength that bonds keep when their ice "
				"has melted [Pa], >= 0, see IceBondMat.thawedStrength; 0 (default): they melt. talik.studies.calibrate.thawedStrength finds the one that gives a cohesion.")
		.add_property("thickness",&RveSample::thickness,"Of discs: thickness of the slice of ground that carries their forces [m], by which stress is divided; "
				"set in talik.rve.prepare, or by O.tags['thickness'] of the scene that is packed. ValueError for spheres.")
		.add_property("stateBytes",&RveSample::stateBytes,"The whole state as bytes: samples with equal ones go on alike, bit for bit.")
		.add_property("path",&RveSample::path,"What the steps of samples run on here: the vectors in use as the library Highway names them, such as AVX2, AVX3 or "
				"AVX3_DL (AVX-512) or NEON, or portable.")
		.def("usePortablePath",&RveSample::usePortablePath,(::boost::python::arg("portable")),"Run all samples on the path that every CPU has, from now on "
				"(comparisons).").staticmethod("usePortablePath")
		.add_property("trsf",&RveSample::deformation,"Accumulated deformation gradient [-].")
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(RveSample);

/// A YADE scene driven as a sample: strain and ice saturation in, stress out, by the scene's own engines.
class OpenRveSample : public Serializable {
public:
	::boost::python::dict apply(const Matrix3r& displacementGradient, Real iceSaturation, const ::boost::python::object& creep = ::boost::python::object());
	bool                  flip(Real skew);
	void                  freeze(Real iceSaturation);
	Matrix3r              stress() const { return sample().stress(); }
	Matrix3r              deformation() const { return sample().deformation(); }
	Real                  iceSaturation() const { return sample().iceSaturation(); }
	Real                  stiffness(int axis) const { return sample().tangent().at(std::size_t(40 * axis)); }
	::boost::python::dict statistics() const;
	/// The scene itself: what is done to it is done to the sample.
	shared_ptr<Scene> runningScene() const { return sample().yadeScene(); }
	/// A copy, to be shown and run in O.
	shared_ptr<Scene> open() const;

private:
	talik::OpenSample&                         sample() const;
	mutable std::shared_ptr<talik::OpenSample> running;

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(OpenRveSample,Serializable,"A periodic YADE scene of any grains and contact law as a sample, advanced by its own engines; "
			"for those of discs RveSample does the same, faster. Works on a copy of the scene given. Example: "
			"s=OpenRveSample(source=talik.rve.openScene(talik.rve.prepare(grains=40))); s.apply(Matrix3(0,1e-3,0, 0,0,0, 0,0,0),1)['stress'].",
		((shared_ptr<Scene>,source,,,"Scene that the sample is a copy of, taken when it is first used."))
		TALIK_ATTRIBUTES_OF_DEM_STEPS
		((Real,tensileStrengthFactor,1,,"Tensile strength of ice bonds in apply() and freeze() over that of IceBondMat [-], > 0; see IceStrength."))
		((Real,shearStrengthFactor,1,,"The same of the shear strength [-], > 0."))
		((Real,iceStiffnessFactor,1,,"Stiffness of the ice in apply() and freeze() over that of IceBondMat [-], > 0 to 2; see IceStrength. Forces stay when it "
				"changes."))
		,/*ctor*/ ,
		/*py*/
		.def("apply",&OpenRveSample::apply,(::boost::python::arg("displacementGradient"),::boost::python::arg("iceSaturation"),
				::boost::python::arg("creep")=::boost::python::object()),"Apply F_new = "
				"(1+displacementGradient) F_old (3x3) and bring the ice saturation of IceBondMat to its target; history is kept. creep: what "
				"IceCreep.over(temperature,time) returns; before the motion ice bonds relax by it. Returns a dictionary: stress (Matrix3) "
				"[Pa], steps, flipped, blewUp, reason.")
		.def("flip",&OpenRveSample::flip,(::boost::python::arg("skew")=0.5),"Replace a skewed cell by its shortest equivalent; nothing physical changes. True if it "
				"was skewed.")
		.def("freeze",&OpenRveSample::freeze,(::boost::python::arg("iceSaturation")),"Freeze at rest to an ice saturation: bonds, also across gaps within "
				"bondRange, and ice springs form stress-free.")
		.def("statistics",&OpenRveSample::statistics,"Dictionary: contacts, bondsIntact, bondsFormed, bondsBroken, bondsMelted, coordinationNumber, porosity, "
				"fabric (Matrix3), unbalancedForce, kineticEnergy.")
		.def("stiffness",&OpenRveSample::stiffness,(::boost::python::arg("axis")),"Modulus of the contacts along an axis, 0 to 2, with no strain across it: an "
				"upper bound of that of the sample [Pa].")
		.def("open",&OpenRveSample::open,"A copy of the Scene that runs, with as many threads as O has, for talik.inspect or O.")
		.add_property("scene",&OpenRveSample::runningScene,"The Scene that runs, not a copy, stepped by one thread; talik.inspect shows it in a yade of one thread "
				"(-j1).")
		.add_property("stress",&OpenRveSample::stress,"Love-Weber stress (Matrix3) of the last step [Pa], tension positive.")
		.add_property("trsf",&OpenRveSample::deformation,"Accumulated deformation gradient [-].")
		.add_property("iceSaturation",&OpenRveSample::iceSaturation,"Ice saturation of the grains' material [-], 0 without IceBondMat.")
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(OpenRveSample);

} // namespace yade
