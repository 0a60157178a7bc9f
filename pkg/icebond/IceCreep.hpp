// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/serialization/Serializable.hpp>
#include <pkg/icebond/IceCreepLaw.hpp>

namespace yade {

/// The creep law of ice bonds as a script writes it.
class IceCreep : public Serializable {
public:
	virtual ~IceCreep() {};
	void                   postLoad(IceCreep&);
	talik::IceCreepLaw     law() const;
	Real                   rateFactorAt(Real temperature) const;
	::boost::python::tuple over(Real temperature, Real time) const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(IceCreep,Serializable,"Creep of ice bonds by Glen's law: the strain rate of a bond under the stress s, its force over its "
			"area, is A s^n, with A = rateFactor exp(Q/R (1/T_0-1/T)), T in K. Defaults are those that Cuffey & Paterson 2010 (The Physics of Glaciers, section "
			"3.4.6) recommend for glacier ice. Time is that of nature, in samples behind points that of the calendar. Example: "
			"IceCreep(exponent=3).rateFactorAt(-5).",
		((Real,rateFactor,3.5e-25,Attr::triggerPostLoad,"A at T_0 [Pa^-n/s in nature's time], >= 0. Stress in a bond is that of a sample times some 40 t/(0.1 m), t "
				"its thickness."))
		((Real,exponent,3,Attr::triggerPostLoad,"n [-], 1 to 10."))
		((Real,referenceTemperature,-10,Attr::triggerPostLoad,"T_0 [degC], > -273.15 and <= 0; Q changes there. Ground above 0 counts as 0."))
		((Real,coldActivationEnergy,60e3,Attr::triggerPostLoad,"Q below T_0 [J/mol], >= 0."))
		((Real,warmActivationEnergy,115e3,Attr::triggerPostLoad,"Q above T_0 [J/mol], >= 0."))
		,/*ctor*/ ,
		/*py*/
		.def("rateFactorAt",&IceCreep::rateFactorAt,(::boost::python::arg("temperature")),"A [Pa^-n/s] at a temperature [degC].")
		.def("over",&IceCreep::over,(::boost::python::arg("temperature"),::boost::python::arg("time")),"(A t [Pa^-n], n): creep at a temperature [degC] over a "
				"time of nature [s]. RveSample.apply and OpenRveSample.apply take it as creep.")
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(IceCreep);

} // namespace yade
