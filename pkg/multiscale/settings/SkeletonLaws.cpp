// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/settings/SkeletonLaws.hpp>
#include <pkg/python/ScriptValues.hpp>

namespace yade {
YADE_PLUGIN((SkeletonLaw)(ElasticSkeleton)(MohrCoulombSkeleton)(CreepingSkeleton));

SkeletonLaw::Model<2> SkeletonLaw::build(const Places<2>&)
{
	throw std::invalid_argument(
	        "SkeletonLaw is only a base class: use ElasticSkeleton, MohrCoulombSkeleton, CreepingSkeleton, BinghamSkeleton or RveSkeleton.");
}

SkeletonLaw::Model<3> SkeletonLaw::build(const Places<3>&)
{
	throw std::invalid_argument(
	        "MpmEngine.skeleton: " + getClassName()
	        + " knows no ground in space: use ElasticSkeleton, MohrCoulombSkeleton, CreepingSkeleton or BinghamSkeleton.");
}

::boost::python::object SkeletonLaw::values(const string& name) const { throw std::invalid_argument(getClassName() + " has no measure '" + name + "'."); }

vector<Real> SkeletonLaw::valueAt(const string& name, int) const { throw std::invalid_argument(getClassName() + " has no measure '" + name + "'."); }

template <int D> SkeletonLaw::Model<D> CreepingSkeleton::model() const
{
	if (!iceCreep) throw std::invalid_argument("CreepingSkeleton.iceCreep is None; give an IceCreep(), or use ElasticSkeleton.");
	const auto law   = iceCreep->law();
	auto       model = std::make_shared<talik::CreepingSkeleton<D>>();
	TALIK_TAKE(*model, *this, TALIK_CREEPING_SKELETON)
	model->exponent               = law.exponent;
	model->rateFactor             = [law](double temperature) { return law.rateFactorAt(temperature); };
	model->temperatureWithoutHeat = law.referenceTemperature;
	model->validate();
	return model;
}

template SkeletonLaw::Model<2> CreepingSkeleton::model<2>() const;
template SkeletonLaw::Model<3> CreepingSkeleton::model<3>() const;

} // namespace yade
