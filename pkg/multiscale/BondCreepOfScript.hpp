// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/python.hpp>
#include <pkg/icebond/IceCreepLaw.hpp>
#include <string>

namespace yade {

/// What IceCreep.over returned, or None. Throws std::invalid_argument naming the method.
inline talik::BondCreep bondCreep(const std::string& method, const ::boost::python::object& creep)
{
	namespace py = ::boost::python;
	if (creep.is_none()) return {};
	const py::extract<py::tuple> pair(creep);
	if (pair.check() && py::len(pair()) == 2) {
		const py::extract<double> fluidity(pair()[0]), exponent(pair()[1]);
		if (fluidity.check() && exponent.check() && fluidity() >= 0 && exponent() >= 1 && std::isfinite(fluidity() * exponent()))
			return { fluidity(), exponent() };
	}
	throw std::invalid_argument(
	        method + ": creep is " + py::extract<std::string>(py::str(creep))() + ": give what IceCreep.over(temperature,time) returns.");
}

} // namespace yade
