// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Boundary.hpp>

namespace talik {

/// No heat crosses. This is what happens where no thermal boundary acts; the object states the intention and is refused
/// where another boundary heats the same side.
template <int D> class InsulatedBoundary final : public Boundary<D> {
public:
	explicit InsulatedBoundary(const Region<D>& region)
	        : Boundary<D>(region)
	{
	}
	std::string name() const override { return "InsulatedBoundary"; }
	std::string effect() const override { return "heat"; }
};

} // namespace talik
