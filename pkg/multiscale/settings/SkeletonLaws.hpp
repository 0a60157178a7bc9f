// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/serialization/Serializable.hpp>
#include <pkg/icebond/IceStrengthAndCreep.hpp>
#include <pkg/mpm/skeleton/CreepingSkeleton.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/MohrCoulombSkeleton.hpp>
#include <pkg/multiscale/checkpoints/CheckpointParts.hpp>
#include <pkg/multiscale/samples/SampleAccuracy.hpp>
#include <pkg/python/ScriptValues.hpp>

namespace yade {

/// What turns strain and ice saturation of a material point into effective stress.
class SkeletonLaw : public Serializable {
public:
	template <int D> using Model  = std::shared_ptr<talik::SkeletonModel<D>>;
	template <int D> using Places = std::vector<talik::Vec<D>>;
	/// The model of one run, in the plane or in space; places: where all points of the ground were added, by id [m]. Throws
	/// std::invalid_argument if the law has none there.
	virtual Model<2> build(const Places<2>& places);
	virtual Model<3> build(const Places<3>& places);
	/// What build() took from other objects has changed since, so that it would build another model now.
	virtual bool sourcesChanged() const { return false; }
	/// The model was changed by hand since build().
	virtual bool changedByHand() const { return false; }
	/// Points begin with a stress of the law's own; one that the user gives is none of theirs.
	virtual bool beginsWithOwnStress() const { return false; }
	/// What the model keeps beside the fields of the points, as bytes, and back. beside: where what is large goes in a checkpoint; null in others.
	virtual string saved(talik::CheckpointParts*) const { return ""; }
	virtual void   restore(const string&, const talik::CheckpointParts::Source*) {}
	/// Before every step: what may be changed while the ground runs comes into force.
	virtual void followAttributes() {}
	/// Whether points of a running ground may be given this law, see MpmEngine.exchangeSkeletons.
	virtual bool admitsPoints() const { return true; }
	/// After an exchange: forget the points that are not in the batch.
	virtual void keepOnly(const talik::SkeletonPoints&) {}
	/// MpmEngine.tolerance, > 0: a law that is asked now and then, with an error, steers that error; others make none.
	virtual void                setTolerance(Real) {}
	virtual talik::ErrorSquares errorSquares(const talik::SkeletonPoints&) const { return {}; }
	/// Why this law cannot run with distribute='ground' in this dimension, as a phrase for the message, such as "samples that run open"; empty: it can.
	virtual string notInSlabs(int) const { return {}; }
	/// Before build(): MpmEngine.distribute. Says whether the law is worth slabs of a small ground, too.
	virtual bool shareAmongRanks(const string&) { return false; }
	/// Names of what can be measured on each point beside the fields, for MpmEngine.field().
	virtual vector<string> measures() const { return {}; }
	/// One of them for all points of the ground, NaN where a point has another skeleton.
	virtual ::boost::python::object values(const string& name) const;
	/// One of them for one point; a single NaN for a point with another skeleton.
	virtual vector<Real> valueAt(const string& name, int id) const;
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(SkeletonLaw, Serializable,
	                               "Turns strain and ice saturation of a material point into effective stress; use one of the derived classes, in "
	                               "MpmEngine.skeleton or MpmEngine.skeletons. Example: mpm.skeletons=[ElasticSkeleton(),MohrCoulombSkeleton()].",
	                               , talik::SequenceConverter<SkeletonLaw>::registerOnce(););
};
REGISTER_SERIALIZABLE(SkeletonLaw);

/// What laws of one point do alike: model<D>() of the law is asked in the dimension of the ground.
template <class Law> class LawInAnyDimension : public SkeletonLaw {
public:
	Model<2> build(const Places<2>&) override { return static_cast<const Law&>(*this).template model<2>(); }
	Model<3> build(const Places<3>&) override { return static_cast<const Law&>(*this).template model<3>(); }
};

/// The model of a law whose parameters are all in a list, see ParameterList.hpp.
#define TALIK_MODEL_FROM_LIST(Law, list)                        \
	template <int D> Model<D> model() const                 \
	{                                                       \
		auto model = std::make_shared<talik::Law<D>>(); \
		TALIK_TAKE(*model, *this, list)                 \
		model->validate();                              \
		return model;                                   \
	}

class ElasticSkeleton : public LawInAnyDimension<ElasticSkeleton> {
public:
	TALIK_MODEL_FROM_LIST(ElasticSkeleton, TALIK_ELASTIC_SKELETON)
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(ElasticSkeleton,SkeletonLaw,"Isotropic hypoelastic skeleton. Example: "
			"MpmEngine(gridSpacing=0.5,skeleton=ElasticSkeleton(young=10e6,poisson=0.3)).",
		TALIK_ELASTIC_SKELETON
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(ElasticSkeleton);

class MohrCoulombSkeleton : public LawInAnyDimension<MohrCoulombSkeleton> {
public:
	TALIK_MODEL_FROM_LIST(MohrCoulombSkeleton, TALIK_MOHR_COULOMB_SKELETON)
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(MohrCoulombSkeleton,SkeletonLaw,"Elastic, perfectly plastic skeleton whose stiffness, cohesion and tensile strength follow ice "
			"saturation through phi(S_i) = 1-(1-S_i^m)^m, or through tables (iceSaturations and what goes with it), linear in between: "
			"talik.studies.calibrate measures them on a sample. Example: MohrCoulombSkeleton(cohesion=1e3,cohesionFrozen=300e3,frictionAngle=20).",
		TALIK_MOHR_COULOMB_SKELETON
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(MohrCoulombSkeleton);

class CreepingSkeleton : public LawInAnyDimension<CreepingSkeleton> {
public:
	template <int D> Model<D> model() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(CreepingSkeleton,SkeletonLaw,"Elastic skeleton that flows by Glen's law while it has ice: strain rate A(T) tau^(n-1) times the "
			"stress deviator, tau the root of its second invariant (in simple shear the shear stress), in calendar time. A and n are those of iceCreep, by default "
			"of glacier ice. Volume does not creep, ground without ice is elastic, there is no strength. Field creepStrain [-]: A tau^n over the time. Example: "
			"CreepingSkeleton(young=500e6,iceCreep=IceCreep(rateFactor=7e-25)).",
		TALIK_CREEPING_SKELETON
		((shared_ptr<IceCreep>,iceCreep,shared_ptr<IceCreep>(new IceCreep),,"Rate factor over temperature, and exponent. Ground without heat has "
				"-10 degC."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(CreepingSkeleton);

} // namespace yade
