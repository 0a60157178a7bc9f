// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/GlobalEngine.hpp>
#include <core/Scene.hpp>
#include <pkg/icebond/IceCreep.hpp>

namespace talik {

/// The ice of a real contact of two grains relaxes at their overlap [m]; nothing happens where there is no ice bond.
void relaxContact(const yade::Scene& scene, yade::Interaction& contact, double overlap, const BondCreep& creep);

} // namespace talik

namespace yade {

/// Creep of the ice bonds of a scene, in every step.
class CreepingBonds : public GlobalEngine {
public:
	virtual ~CreepingBonds() {};
	void action() override;
	void postLoad(CreepingBonds&);

private:
	void requireParallelSprings() const;
	bool checked = false;

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(CreepingBonds,GlobalEngine,"Ice bonds of the scene creep: in every step the force of their ice relaxes by the closed "
			"form of Glen's law over timeScale*O.dt. Put it behind the InteractionLoop. Samples need none: see RveSkeleton.iceCreep. Example: "
			"O.engines=O.engines+[CreepingBonds(iceCreep=IceCreep(),temperature=-5,timeScale=1e6)].",
		((shared_ptr<IceCreep>,iceCreep,,,"The law. None: bonds do not creep."))
		((Real,temperature,-10,Attr::triggerPostLoad,"Of the ice [degC]."))
		((Real,timeScale,1,Attr::triggerPostLoad,"Time of nature that passes per time of the scene [-], >= 0."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(CreepingBonds);

} // namespace yade
