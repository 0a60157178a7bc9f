// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/python.hpp>
#include <core/Scene.hpp>
#include <pkg/mpm/AnyGround.hpp>
#include <pkg/multiscale/bodies/BodyContact.hpp>

#include <memory>
#include <string>
#include <vector>

namespace yade {
class MpmEngine;

/// The ground that the attributes of an engine describe, in the plane or in space: all that depends on the dimension between the two.
class GroundOfScene {
public:
	virtual ~GroundOfScene() = default;

	/// A ground with the settings and points of an engine, not yet initialised. goesOn: with a state that comes afterwards.
	/// Throws std::invalid_argument naming attribute, value and remedy.
	static std::shared_ptr<GroundOfScene> make(const MpmEngine& engine, int dimension, bool goesOn);

	virtual talik::AnyGround&       ground()       = 0;
	virtual const talik::AnyGround& ground() const = 0;

	/// Throws std::invalid_argument if lower and upper of the engine are not those of the ground any more.
	virtual void checkBox(const MpmEngine& engine) const = 0;
	/// Between two steps: what may change.
	virtual void followGravity(const MpmEngine& engine)         = 0;
	virtual void followHeat(const talik::HeatSettings& changed) = 0;

	/// See MpmEngine.balance.
	virtual ::boost::python::dict balance() const = 0;
	/// The bodies of the scene as this ground meets them. Call on an initialised ground with bodies.
	virtual SceneBodies& bodies() = 0;
};

} // namespace yade
