// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/icebond/AttributeRefusal.hpp>
#include <pkg/icebond/IceBondMat.hpp>
#include <pkg/icebond/IceBondPhys.hpp>

namespace yade {
YADE_PLUGIN((IceBondMat));

talik::IceBondModel IceBondMat::model() const
{
	talik::IceBondModel m;
	m.grainYoung       = young;
	m.iceYoung         = iceYoung;
	m.tensileStrength0 = tensileStrength;
	m.tensileStrengthI = iceTensileStrength;
	m.shearStrength0   = shearStrength;
	m.shearStrengthI   = iceShearStrength;
	m.exponent         = exponent;
	m.bondAreaFactor   = bondAreaFactor;
	m.meltSaturation   = meltSaturation;
	m.bondSaturation   = bondSaturation;
	m.bondRange        = bondRange;
	m.thawedStrength   = thawedStrength;
	return m;
}

shared_ptr<IceBondPhys> IceBondMat::newContact(const IceBondMat&, Real, Real, Real) const { return shared_ptr<IceBondPhys>(new IceBondPhys); }

namespace {
	constexpr AttributeRefusal require { "IceBondMat" };
} // namespace

void IceBondMat::postLoad(IceBondMat&)
{
	require(iceSaturation >= 0 && iceSaturation <= 1, "iceSaturation", iceSaturation, "give a saturation from 0 to 1.");
	require(iceYoung >= 0, "iceYoung", iceYoung, "give a finite modulus in Pa, 0 or more.");
	require(tensileStrength >= 0, "tensileStrength", tensileStrength, "give a finite strength in Pa, 0 or more.");
	require(iceTensileStrength >= 0, "iceTensileStrength", iceTensileStrength, "give a finite strength in Pa, 0 or more.");
	require(shearStrength >= 0, "shearStrength", shearStrength, "give a finite strength in Pa, 0 or more.");
	require(iceShearStrength >= 0, "iceShearStrength", iceShearStrength, "give a finite strength in Pa, 0 or more.");
	require(exponent > 1, "exponent", exponent, "eq. (7) needs a number above 1.");
	require(bondAreaFactor > 0, "bondAreaFactor", bondAreaFactor, "give a positive factor.");
	require(meltSaturation >= 0 && meltSaturation < 1, "meltSaturation", meltSaturation, "give a saturation from 0 to below 1.");
	require(bondSaturation >= meltSaturation, "bondSaturation", bondSaturation, "it must not be below meltSaturation.");
	require(bondRange >= 0, "bondRange", bondRange, "give a gap over radius, 0 or more.");
	require(thawedStrength >= 0, "thawedStrength", thawedStrength, "give a finite strength in Pa, 0 or more.");
	require(radiusRatio > 0, "radiusRatio", radiusRatio, "it is a positive ratio that GrainSwelling sets; leave it out.");
	require(radiusRatioBefore > 0, "radiusRatioBefore", radiusRatioBefore, "it is a positive ratio that GrainSwelling sets; leave it out.");
}

} // namespace yade
