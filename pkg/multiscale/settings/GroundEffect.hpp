// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/serialization/Serializable.hpp>
#include <pkg/mpm/effects/Effect.hpp>
#include <pkg/python/ScriptValues.hpp>

namespace yade {

/// An effect of moving ground that stands in files of its own; derived classes say which.
class GroundEffect : public Serializable {
public:
	template <int D> using Pointer = std::shared_ptr<talik::Effect<D>>;
	/// The effect of one run, in the plane or in space.
	template <int D> Pointer<D> build() const
	{
		if constexpr (D == 2) return inPlane();
		else return inSpace();
	}

protected:
	virtual Pointer<2> inPlane() const;
	virtual Pointer<3> inSpace() const;

public:
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(GroundEffect, Serializable,
	                               "Effect of moving ground beside those that MpmEngine has by name; use one of the derived classes, in MpmEngine.effects. "
	                               "Example: mpm.effects=[BulkViscosity(viscosity=1e4)].",
	                               , talik::SequenceConverter<GroundEffect>::registerOnce(););
};
REGISTER_SERIALIZABLE(GroundEffect);

/// What every kind of effect does alike: make<D>() of the kind is asked in the dimension of the ground.
template <class Kind> class EffectInAnyDimension : public GroundEffect {
protected:
	Pointer<2> inPlane() const override { return static_cast<const Kind&>(*this).template make<2>(); }
	Pointer<3> inSpace() const override { return static_cast<const Kind&>(*this).template make<3>(); }
};

} // namespace yade
