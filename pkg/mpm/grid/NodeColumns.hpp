// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace talik {

/// Which number of which effect stands in which column of the records on the nodes. Numbers that one pass over the points writes or
/// reads together lie in one record, which is as long as the vectors of the loops over nodes: a record may end in columns that nobody
/// uses. The effect named at a record allocates it.
template <int D> struct NodeColumns {
	static constexpr bool plane = D == 2;

	/// SolidMotion::nodes, mapped from the points. In the plane capacity and heat are HeatTransfer::nodes.
	struct Moving {
		static constexpr int  mass = 0, momentum = 1, force = 4, capacity = 6, heat = 7, size = 8;
		static constexpr bool carriesHeat = plane;
	};
	/// SolidMotion::solved, what the points gather. In space increment is HeatTransfer::increment.
	struct Solved {
		static constexpr int  change = 0, increment = D, velocity = plane ? D : 4, size = plane ? 4 : 8;
		static constexpr bool carriesIncrement = !plane;
	};
	/// PoreWater::nodes, mapped from the points. In space capacity and heat are HeatTransfer::nodes.
	struct Liquid {
		static constexpr int mass = 0, momentum = 1, volume = 1 + D, liquidVolume = 2 + D, pressure = 3 + D, drag = 4 + D, potential = 5 + D,
		                     capacity = 6 + D, heat = 7 + D, numbers = plane ? 8 : 11, size = plane ? 8 : 12;
		static constexpr bool carriesHeat = !plane;
	};
	/// PoreWater::nodal, whose gradients drive. temperature is HeatTransfer::nodal.
	struct Driving {
		static constexpr int pressure = 0, liquidFraction = 1, perLiquidMass = 2, temperature = 3, size = 4;
	};
	/// PoreWater::force, what the gradients do. heat and nullSpace are HeatTransfer::energy and nullSpaceResidual.
	struct Driven {
		static constexpr int force = 0, heat = plane ? 2 : 4, nullSpace = heat + 1, size = plane ? 4 : 8;
	};
	/// Record of HeatTransfer in ground without water.
	struct Conducted {
		static constexpr int heat = 0, nullSpace = 1, size = 2;
	};
	/// FreeSurface::nodes, mapped from the points.
	struct Surface {
		static constexpr int area = 0, volume = D, conduction = D + 1, size = plane ? 4 : 8; ///< outward area vector, volume, volume times conductivity
	};
	/// PoreWater::flux.
	struct Flux {
		static constexpr int size = plane ? 2 : 4;
	};
	/// PoreWater::exchange, what the points gather. velocity is PoreWater::solved, in the plane increment is HeatTransfer::increment.
	struct Gathered {
		static constexpr int  water = 0, enthalpy = 1, momentum = 2, exchange = 2 + D; ///< of seepage; first sums, then per liquid mass of the node
		static constexpr int  velocity = exchange, increment = velocity + D, size = 8;
		static constexpr bool carriesIncrement = plane;
	};

	// Records of front nodes: what points of the frozen side bring, those of the thawed side, and their pores. The numbers from straight on
	// take values and slopes of the shape functions, those before values alone. The first of each stands at number at of the record.
	struct Frozen {
		static constexpr int at = 0, mass = 0, momentum = 1, liquidMass = 1 + D, liquidMomentum = 2 + D, straight = 8, force = 8, area = force + D,
		                     volume = plane ? 6 : 14, size = plane ? 12 : 16;
	};
	struct Thawed {
		static constexpr int at = Frozen::at + Frozen::size, volume = 0, mass = 1, momentum = 2, liquidMass = 2 + D, friction = 3 + D, cohesion = 4 + D,
		                     stress = 5 + D, straight = plane ? 12 : 16, area = straight, size = straight + 4;
	};
	struct Pores {
		static constexpr int at = Thawed::at + Thawed::size, straight = 0, fullMass = 0, force = 1, size = 4;
	};
	/// What points of a side gather from front nodes: correction of the velocity, of what points gain of it, and of what their liquid gains.
	struct Side {
		static constexpr int velocity = 0, gain = 4, liquidGain = plane ? 6 : 8, size = plane ? 8 : 12;
	};
	/// And thawed points alone: velocity of their slip along the front.
	struct Slip {
		static constexpr int at = 2 * Side::size, velocity = 0, size = 4;
	};
};

} // namespace talik
