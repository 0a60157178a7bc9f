// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/serialization/Serializable.hpp>
#include <pkg/icebond/IceStrengthLaw.hpp>

namespace yade {

/// The strength law of ice bonds as a script writes it.
class IceStrength : public Serializable {
public:
	virtual ~IceStrength() {};
	void                   postLoad(IceStrength&);
	talik::IceStrengthLaw  law() const;
	::boost::python::tuple factors(Real temperature, Real strainRate) const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(IceStrength,Serializable,"Strength of ice bonds over temperature and strain rate: factors exp(b (T_0-T)) (rate/rate_0)^n on "
			"the tensile and the shear strength that IceBondMat gives at T_0 and rate_0. Defaults are those of frozen Fairbanks silt: temperature by Haynes & "
			"Karalius 1977 (0 to -57 degC: compression tenfold, tension by root ten), rate by Haynes, Karalius & Kalafut 1975 (1.2e-4 to 2.9/s at -10 degC: "
			"compression tenfold, tension hardly). Example: IceStrength(shearRateExponent=0.1).factors(-5,1e-3).",
		((Real,referenceTemperature,-10,Attr::triggerPostLoad,"T_0 [degC], <= 0; ground above 0 counts as 0."))
		((Real,referenceRate,1e-4,Attr::triggerPostLoad,"rate_0 [1/s in nature's time], > 0."))
		((Real,leastRate,1e-7,Attr::triggerPostLoad,"Slower strain counts as this [1/s], > 0: the slowest tests that are known (Parameswaran 1980)."))
		((Real,tensileCold,0.0203,Attr::triggerPostLoad,"b of the tensile strength [1/K], >= 0: ln(root 10)/56.7."))
		((Real,shearCold,0.0406,Attr::triggerPostLoad,"b of the shear strength [1/K], >= 0: ln(10)/56.7."))
		((Real,tensileRateExponent,0,Attr::triggerPostLoad,"n of the tensile strength [-], 0 to below 1."))
		((Real,shearRateExponent,0.228,Attr::triggerPostLoad,"n of the shear strength [-], 0 to below 1: 1/log10(2.9/1.2e-4)."))
		,/*ctor*/ ,
		/*py*/
		.def("factors",&IceStrength::factors,(::boost::python::arg("temperature"),::boost::python::arg("strainRate")),"(tensile, shear): strength at a temperature "
				"[degC] and a strain rate [1/s in nature's time] over that of the material [-]. RveSample takes them as strengthFactors.")
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(IceStrength);

} // namespace yade
