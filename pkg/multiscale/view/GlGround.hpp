// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/common/OpenGLRenderer.hpp>
#include <pkg/multiscale/engine/MpmEngine.hpp>
#include <pkg/multiscale/view/GroundPicture.hpp>

namespace yade {

/// Draws the points of a ground in the 3-D view, beside the bodies of the scene.
class GlGround : public GlExtraDrawer {
public:
	void render() override;
	void postLoad(GlGround&);

private:
	void drawPoints(const talik::GroundPicture::Points& points);

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(GlGround,GlExtraDrawer,"Draws the points of an MpmEngine in the 3-D view as squares of their volume, in space as "
			"cubes, coloured by a field. While the ground runs the view shows it as it was at the end of a recent step. It is drawn once it is in "
			"yade.qt.Renderer().extraDrawers. Example: GlGround(field='temperature',smallest=-5,largest=10).",
		((shared_ptr<MpmEngine>,mpm,,Attr::triggerPostLoad,"The ground; None draws nothing."))
		((string,field,"displacement",Attr::triggerPostLoad,"Field of the points, as in mpm.fieldNames() but for those of samples and strains; of several "
				"components the norm."))
		((Real,smallest,NaN,,"Value that is drawn with lowColor [unit of the field]; NaN: the smallest in the picture."))
		((Real,largest,NaN,,"Value that is drawn with highColor [unit of the field]; NaN: the largest in the picture."))
		((Vector3r,lowColor,Vector3r(0.95,0.9,0.75),,"Colour of the smallest value: red, green, blue from 0 to 1 [-]."))
		((Vector3r,highColor,Vector3r(0.1,0.3,0.7),,"Colour of the largest value: red, green, blue from 0 to 1 [-]."))
		((long,drawn,0,Attr::readonly,"Points drawn the last time; 0 before."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(GlGround);

} // namespace yade
