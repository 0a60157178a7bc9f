// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace talik {

/// Which number of which effect stands in which column of the records on the nodes. Numbers that one pass over the points writes or
/// reads together lie in one record. In the plane a record is as long as the vectors of the plane loops and serves several effects;
/// in space each effect has records of its own. The effect named at a record allocates it.
template <int D> struct NodeColumns {
	static constexpr bool shared = D == 2;

	/// SolidMotion::nodes, mapped from the points. Shared: capacity and heat are HeatTransfer::nodes.
	struct Moving {
		static constexpr int mass = 0, momentum = 1, force = 4, capacity = 6, heat = 7, size = 8;
	};
	/// PoreWater::nodes, mapped from the points.
	struct Liquid {
		static constexpr int mass = 0, momentum = 1, volume = 1 + D, liquidVolume = 2 + D, pressure = 3 + D, drag = 4 + D, potential = 5 + D,
		                     size = 6 + D;
	};
	/// PoreWater::nodal, whose gradients drive. Shared: temperature is HeatTransfer::nodal.
	struct Driving {
		static constexpr int pressure = 0, liquidFraction = 1, perLiquidMass = 2, temperature = 3, size = shared ? 4 : 3;
	};
	/// PoreWater::force, what the gradients do. Shared: heat and unseen are HeatTransfer::energy and noise.
	struct Driven {
		static constexpr int force = 0, heat = D, unseen = D + 1, size = shared ? D + 2 : D;
	};
	/// Record of HeatTransfer in ground without water, as the plane loops write it.
	struct Conducted {
		static constexpr int heat = 0, unseen = 1, size = 2;
	};
	/// PoreWater::exchange, what the points gather. Shared: velocity is PoreWater::solved, rise HeatTransfer::rise.
	struct Gathered {
		static constexpr int water = 0, enthalpy = 1, momentum = 2, exchange = 2 + D; ///< of seepage; first sums, then per liquid mass of the node
		static constexpr int velocity = exchange, rise = velocity + D, size = shared ? 8 : exchange;
	};
};

} // namespace talik
