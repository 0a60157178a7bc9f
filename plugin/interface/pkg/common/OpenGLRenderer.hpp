// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/serialization/Serializable.hpp>

namespace yade {
/// Draws the 3-D view. It is never made or measured here: only asked to look for drawing functors again.
class OpenGLRenderer : public Serializable {
public:
	OpenGLRenderer();
	virtual ~OpenGLRenderer();
	/// Finds the drawing functors of all registered classes and makes new ones; may be called again.
	void init();
};
} // namespace yade
