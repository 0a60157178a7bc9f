// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/icebond/AttributeRefusal.hpp>
#include <pkg/icebond/IceStrength.hpp>

namespace yade {
YADE_PLUGIN((IceStrength));

namespace {
	constexpr AttributeRefusal require { "IceStrength" };
} // namespace

void IceStrength::postLoad(IceStrength&)
{
	require(referenceTemperature <= 0, "referenceTemperature", referenceTemperature, "give a temperature in degC, 0 or less.");
	require(referenceRate > 0, "referenceRate", referenceRate, "give a positive rate in 1/s.");
	require(leastRate > 0, "leastRate", leastRate, "give a positive rate in 1/s.");
	require(tensileCold >= 0, "tensileCold", tensileCold, "give a number in 1/K, 0 or more.");
	require(shearCold >= 0, "shearCold", shearCold, "give a number in 1/K, 0 or more.");
	require(tensileRateExponent >= 0 && tensileRateExponent < 1, "tensileRateExponent", tensileRateExponent, "give an exponent from 0 to below 1.");
	require(shearRateExponent >= 0 && shearRateExponent < 1, "shearRateExponent", shearRateExponent, "give an exponent from 0 to below 1.");
}

talik::IceStrengthLaw IceStrength::law() const
{
	talik::IceStrengthLaw l;
	l.tensile              = { tensileCold, tensileRateExponent };
	l.shear                = { shearCold, shearRateExponent };
	l.referenceTemperature = referenceTemperature;
	l.referenceRate        = referenceRate;
	l.leastRate            = leastRate;
	return l;
}

::boost::python::tuple IceStrength::factors(Real temperature, Real strainRate) const
{
	require(true, "factors: temperature", temperature, "give a temperature in degC.");
	require(strainRate >= 0, "factors: strainRate", strainRate, "give a rate in 1/s, 0 or more.");
	const auto both = law().factors(temperature, strainRate);
	return ::boost::python::make_tuple(both.tensile, both.shear);
}

} // namespace yade
