// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/serialization/Serializable.hpp>

namespace yade {
class Scene;

/// Draws what is no body, when the renderer has drawn the scene.
class GlExtraDrawer : public Serializable {
public:
	Scene* scene = nullptr;
	bool   dead  = false;

	GlExtraDrawer() {}
	virtual ~GlExtraDrawer();
	TALIK_STOCK_OVERRIDES()
	virtual void render();
};

/// Draws the 3-D view. It is never made or measured here: only asked to look for drawing functors again.
class OpenGLRenderer : public Serializable {
public:
	OpenGLRenderer();
	virtual ~OpenGLRenderer();
	/// Finds the drawing functors of all registered classes and makes new ones; may be called again.
	void init();
};
} // namespace yade
TALIK_STOCK_BASE(GlExtraDrawer)
