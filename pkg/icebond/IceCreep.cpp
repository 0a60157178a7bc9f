// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/icebond/AttributeRefusal.hpp>
#include <pkg/icebond/IceCreep.hpp>

namespace yade {
YADE_PLUGIN((IceCreep));

namespace {
	constexpr AttributeRefusal require { "IceCreep" };
} // namespace

void IceCreep::postLoad(IceCreep&)
{
	require(rateFactor >= 0, "rateFactor", rateFactor, "give a rate factor in Pa^-n/s, 0 or more.");
	require(exponent >= 1 && exponent <= 10, "exponent", exponent, "give an exponent from 1 to 10; Glen's is 3.");
	require(referenceTemperature <= 0 && referenceTemperature > -talik::IceCreepLaw::celsius, "referenceTemperature", referenceTemperature,
	        "give a temperature in degC, 0 or less.");
	require(coldActivationEnergy >= 0, "coldActivationEnergy", coldActivationEnergy, "give an energy in J/mol, 0 or more.");
	require(warmActivationEnergy >= 0, "warmActivationEnergy", warmActivationEnergy, "give an energy in J/mol, 0 or more.");
}

talik::IceCreepLaw IceCreep::law() const
{
	talik::IceCreepLaw l;
	l.rateFactor           = rateFactor;
	l.exponent             = exponent;
	l.referenceTemperature = referenceTemperature;
	l.coldActivationEnergy = coldActivationEnergy;
	l.warmActivationEnergy = warmActivationEnergy;
	return l;
}

Real IceCreep::rateFactorAt(Real temperature) const
{
	require(temperature > -talik::IceCreepLaw::celsius, "rateFactorAt: temperature", temperature, "give a temperature in degC, above -273.15.");
	return law().rateFactorAt(temperature);
}

::boost::python::tuple IceCreep::over(Real temperature, Real time) const
{
	require(temperature > -talik::IceCreepLaw::celsius, "over: temperature", temperature, "give a temperature in degC, above -273.15.");
	require(time >= 0, "over: time", time, "give a time in s, 0 or more.");
	const auto creep = law().over(temperature, time);
	return ::boost::python::make_tuple(creep.fluidity, creep.exponent);
}

} // namespace yade
