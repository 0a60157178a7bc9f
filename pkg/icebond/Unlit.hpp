// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <GL/gl.h>

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
