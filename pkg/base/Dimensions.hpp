// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

/// Compiles a class of the dimension in the plane and in space.
#define TALIK_IN_PLANE_AND_SPACE(Class) \
	template class Class<2>;        \
	template class Class<3>
