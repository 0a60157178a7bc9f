// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/GlobalEngine.hpp>
#include <core/Scene.hpp>
#include <lib/serialization/Serializable.hpp>
#include <pkg/icebond/IceLaws.hpp>

namespace yade {

/// The strength law of ice bonds as a script writes it.
class IceStrength : public Serializable {
public:
	void                   postLoad(IceStrength&);
	talik::IceStrengthLaw  law() const;
	::boost::python::tuple factors(Real temperature, Real strainRate) const;
	Real                   stiffnessFactor(Real temperature) const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(IceStrength,Serializable,"Strength and stiffness of ice bonds over temperature and strain rate: factors "
			"exp(b (T_0-T)) (rate/rate_0)^n on the tensile and the shear strength that IceBondMat gives at T_0 = -10 degC and rate_0. Ground above 0 degC "
			"counts as 0, strain slower than 1e-7/s as that: the slowest tests that are known (Parameswaran 1980). Defaults are those of "
			"frozen Fairbanks silt: temperature by Haynes & Karalius 1977 (0 to -57 degC: compression tenfold, tension by root ten), rate by Haynes, Karalius & "
			"Kalafut 1975 (1.2e-4 to 2.9/s at -10 degC: compression tenfold, tension hardly). Example: "
			"IceStrength(shearRateExponent=0.1).factors(-5,1e-3).",
		((Real,referenceRate,1e-4,Attr::triggerPostLoad,"rate_0 [1/s in physical time], > 0."))
		((Real,tensileCold,0.0203,Attr::triggerPostLoad,"b of the tensile strength [1/K], >= 0: ln(root 10)/56.7."))
		((Real,shearCold,0.0406,Attr::triggerPostLoad,"b of the shear strength [1/K], >= 0: ln(10)/56.7."))
		((Real,tensileRateExponent,0,Attr::triggerPostLoad,"n of the tensile strength [-], 0 to below 1."))
		((Real,shearRateExponent,0.228,Attr::triggerPostLoad,"n of the shear strength [-], 0 to below 1: 1/log10(2.9/1.2e-4). A sample of such "
				"bonds grows less over these rates, 1.4 fold in compression, because it breaks bonds in tension, too. Tenfold takes n = 0.3, "
				"iceShearStrength=20e6, etaRoll=0.2, bondRadiusFactor=2 and momentContribution=0 in talik.rve.prepare (scripts/calibrate --growth)."))
		((Real,stiffnessCold,0,Attr::triggerPostLoad,"b of the stiffness of the ice, IceBondMat.iceYoung [1/K], >= 0. 0 (default): it does not follow. Ice "
				"itself has 0.0014, by its elastic constants at -3 and -16 degC (Gammon, Kiefte & Clouter 1980; Gammon et al. 1983)."))
		,/*ctor*/ ,
		/*py*/
		.def("factors",&IceStrength::factors,(::boost::python::arg("temperature"),::boost::python::arg("strainRate")),"(tensile, shear): strength at a temperature "
				"[degC] and a strain rate [1/s in physical time] over that of the material [-]. For RveSample.tensileStrengthFactor and shearStrengthFactor.")
		.def("stiffnessFactor",&IceStrength::stiffnessFactor,(::boost::python::arg("temperature")),"Stiffness of the ice at a temperature [degC] over that of the "
				"material [-]: exp(stiffnessCold (T_0-T)), at most 2. For RveSample.iceStiffnessFactor.")
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(IceStrength);

/// The creep law of ice bonds as a script writes it.
class IceCreep : public Serializable {
public:
	void                   postLoad(IceCreep&);
	talik::IceCreepLaw     law() const;
	Real                   rateFactorAt(Real temperature) const;
	::boost::python::tuple over(Real temperature, Real time) const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(IceCreep,Serializable,"Creep of ice bonds by Glen's law: the strain rate of a bond under the stress s, its force over its "
			"area, is A s^n, with A = rateFactor exp(Q/R (1/T_0-1/T)), T in K, T_0 = -10 degC, Q = 60 kJ/mol below and 115 kJ/mol above T_0; ground above "
			"0 degC counts as 0. Numbers are those that Cuffey & Paterson 2010 (The Physics of Glaciers, section 3.4.6) recommend for glacier ice. Time "
			"is that of nature, in samples behind points that of the calendar. Example: "
			"IceCreep(exponent=3).rateFactorAt(-5).",
		((Real,rateFactor,3.5e-25,Attr::triggerPostLoad,"A at T_0 [Pa^-n/s of calendar time], >= 0. Stress in a bond is that of a sample times some 40 t/(0.1 m), t "
				"its thickness."))
		((Real,exponent,3,Attr::triggerPostLoad,"n [-], 1 to 10; 3 by Glen 1955."))
		,/*ctor*/ ,
		/*py*/
		.def("rateFactorAt",&IceCreep::rateFactorAt,(::boost::python::arg("temperature")),"A [Pa^-n/s] at a temperature [degC].")
		.def("over",&IceCreep::over,(::boost::python::arg("temperature"),::boost::python::arg("time")),"(A t [Pa^-n], n): creep at a temperature [degC] over a "
				"calendar time [s]. RveSample.apply and OpenRveSample.apply take it as creep.")
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(IceCreep);

} // namespace yade

namespace talik {

/// The ice of a real contact of two grains becomes stiffer by a factor at their overlap [m] and keeps its forces.
void stiffenContact(yade::Interaction& contact, double overlap, double factor);

/// The ice of a real contact of two grains relaxes at their overlap [m]; nothing happens where there is no ice bond.
void relaxContact(const yade::Scene& scene, yade::Interaction& contact, double overlap, const BondCreep& creep);

} // namespace talik

namespace yade {

/// Creep of the ice bonds of a scene, in every step.
class CreepingBonds : public GlobalEngine {
public:
	void action() override;
	void postLoad(CreepingBonds&);

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(CreepingBonds,GlobalEngine,"Ice bonds of the scene creep: in every step the force of their ice relaxes by the closed "
			"form of Glen's law over timeScale*O.dt. Put it behind the InteractionLoop. Samples need none: see RveSkeleton.iceCreep. Example: "
			"O.engines=O.engines+[CreepingBonds(iceCreep=IceCreep(),temperature=-5,timeScale=1e6)].",
		((shared_ptr<IceCreep>,iceCreep,,,"The law. None: bonds do not creep."))
		((Real,temperature,-10,Attr::triggerPostLoad,"Of the ice [degC], above -273.15; above 0 counts as 0."))
		((Real,timeScale,1,Attr::triggerPostLoad,"Time of nature that passes per time of the scene [-], >= 0."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(CreepingBonds);

} // namespace yade
