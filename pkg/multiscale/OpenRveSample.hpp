// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Scene.hpp>
#include <pkg/rve/open/OpenSample.hpp>

namespace yade {

/// A YADE scene driven as a sample: strain and ice saturation in, stress out, by the scene's own engines.
class OpenRveSample : public Serializable {
public:
	virtual ~OpenRveSample() {};

	::boost::python::dict apply(const Matrix3r& displacementGradient, Real iceSaturation, const ::boost::python::object& creep = ::boost::python::object());
	bool                  flip(Real skew);
	void                  freeze(Real iceSaturation);
	Matrix3r              stress() const { return sample().stress(); }
	Matrix3r              deformation() const { return sample().deformation(); }
	Real                  iceSaturation() const { return sample().iceSaturation(); }
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
		((Real,maxInertialNumber,5e-3,,"I_max: bounds the strain of a DEM step, 1e-3 careful, 5e-3 production [-]."))
		((Real,maxStrainPerStep,1e-5,,"Largest strain of a DEM step [-]."))
		((int,minSteps,10,,"Fewest DEM steps of one apply() with motion."))
		((Real,tensileStrengthFactor,1,,"Tensile strength of ice bonds in apply() and freeze() over that of IceBondMat [-], > 0; see IceStrength."))
		((Real,shearStrengthFactor,1,,"The same of the shear strength [-], > 0."))
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
