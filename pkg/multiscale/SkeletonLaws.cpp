// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/ScriptNames.hpp>
#include <pkg/multiscale/SkeletonLaws.hpp>

namespace yade {
YADE_PLUGIN((SkeletonLaw)(ElasticSkeleton)(MohrCoulombSkeleton));

SkeletonLaw::Pointer SkeletonLaw::build(int)
{
	throw std::invalid_argument("SkeletonLaw is only a base class: use ElasticSkeleton, MohrCoulombSkeleton or RveSkeleton.");
}

::boost::python::object SkeletonLaw::values(const string& name) const { throw std::invalid_argument(getClassName() + " has no measure '" + name + "'."); }

vector<Real> SkeletonLaw::valueAt(const string& name, int) const { throw std::invalid_argument(getClassName() + " has no measure '" + name + "'."); }

SkeletonLaw::Pointer ElasticSkeleton::build(int)
{
	auto model          = std::make_shared<talik::ElasticSkeleton<2>>();
	model->youngModulus = young;
	model->poissonRatio = poisson;
	talik::underScriptNames(
	        { { "ElasticSkeleton.youngModulus", "ElasticSkeleton.young" }, { "ElasticSkeleton.poissonRatio", "ElasticSkeleton.poisson" } },
	        [&] { model->validate(); });
	return model;
}

SkeletonLaw::Pointer MohrCoulombSkeleton::build(int)
{
	auto model                   = std::make_shared<talik::MohrCoulombSkeleton<2>>();
	model->youngModulus          = young;
	model->youngModulusFrozen    = youngFrozen;
	model->poissonRatio          = poisson;
	model->cohesion              = cohesion;
	model->cohesionFrozen        = cohesionFrozen;
	model->frictionAngle         = frictionAngle;
	model->dilationAngle         = dilationAngle;
	model->tensileStrength       = tensileStrength;
	model->tensileStrengthFrozen = tensileStrengthFrozen;
	model->iceExponent           = exponent;
	model->table                 = { iceSaturations, youngs, cohesions, tensileStrengths };
	talik::underScriptNames(
	        { { "MohrCoulombSkeleton.youngModulusFrozen", "MohrCoulombSkeleton.youngFrozen" },
	          { "MohrCoulombSkeleton.youngModulus", "MohrCoulombSkeleton.young" },
	          { "MohrCoulombSkeleton.poissonRatio", "MohrCoulombSkeleton.poisson" },
	          { "MohrCoulombSkeleton.iceExponent", "MohrCoulombSkeleton.exponent" },
	          { "MohrCoulombSkeleton.table.saturation", "MohrCoulombSkeleton.iceSaturations" },
	          { "MohrCoulombSkeleton.table.youngModulus", "MohrCoulombSkeleton.youngs" },
	          { "MohrCoulombSkeleton.table.cohesion", "MohrCoulombSkeleton.cohesions" },
	          { "MohrCoulombSkeleton.table.tensileStrength", "MohrCoulombSkeleton.tensileStrengths" } },
	        [&] { model->validate(); });
	return model;
}

} // namespace yade
