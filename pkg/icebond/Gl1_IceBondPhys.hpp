// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <GL/gl.h>
#include <pkg/common/GLDrawFunctors.hpp>
#include <pkg/icebond/IceBondContacts.hpp>

namespace talik {

/// Drawing by colours that tell something, which light must not change; the former drawing state returns with the scope.
struct Unlit {
	/// onTop: over what is drawn already.
	explicit Unlit(bool onTop = false)
	{
		glPushAttrib(GL_ENABLE_BIT | GL_CURRENT_BIT | GL_POLYGON_BIT);
		glDisable(GL_LIGHTING);
		glDisable(GL_CULL_FACE);
		if (onTop) glDisable(GL_DEPTH_TEST);
	}
	~Unlit() { glPopAttrib(); }
	Unlit(const Unlit&)            = delete;
	Unlit& operator=(const Unlit&) = delete;
};

} // namespace talik

namespace yade {

/// Draws contacts as rods from grain centre to grain centre: colour by state, thickness by force.
class Gl1_IceBondPhys : public GlIPhysFunctor {
public:
	void go(const shared_ptr<IPhys>&, const shared_ptr<Interaction>&, const shared_ptr<Body>&, const shared_ptr<Body>&, bool wire) override;

private:
	Real     radiusFor(const IceBondPhys&) const;
	Vector3r wrapped(const Vector3r& position) const;

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_STATICATTRS(Gl1_IceBondPhys,GlIPhysFunctor,"Draws ice bonds in the 3-D view: intact bonds red, broken and frictional contacts black, "
			"rods as thick as the contact force, over the grains. Switch on by yade.qt.Renderer().intrPhys=True. Example: Gl1_IceBondPhys.maxRadius=1e-3.",
		((Real,maxForce,0,,"Force that is drawn with maxRadius [N]; it grows to the largest force seen. Set to 0 to begin anew."))
		((Real,maxRadius,0,,"Radius of the thickest rod [m]; 0: a quarter of the radius of the smaller grain of the contact drawn first."))
	);
	// clang-format on
	RENDERS(IceBondPhys);
};
REGISTER_SERIALIZABLE(Gl1_IceBondPhys);

} // namespace yade
