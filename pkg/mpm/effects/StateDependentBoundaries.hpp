// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/boundary/Boundary.hpp>
#include <pkg/mpm/StepContext.hpp>
#include <string>

#include <memory>
#include <utility>
#include <vector>

namespace talik {

template <int D> class FreeSurface;
template <int D> class HeatTransfer;
template <int D> class MomentumSolver;
template <int D> class PoreWater;
template <int D> class SolidMotion;

/// Boundaries whose fluxes follow from the state of their nodes (Boundary::usesNodes).
template <int D> class StateDependentBoundaries {
public:
	/// Finds them among the boundaries of a scene, which have to live as long.
	void find(const Grid<D>& grid, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries);
	bool empty() const { return list_.empty(); }

	/// What the nodes have at the beginning of a step, mapped from the points; null where the ground has no such effect.
	struct State {
		const SolidMotion<D>*  motion;
		const HeatTransfer<D>* heat;
		const PoreWater<D>*    water;
	};
	/// Every boundary sees the state of its nodes and finds its fluxes, before anything of the step is booked. surface: of boundaries that act there.
	/// With ranks each of them sees the nodes of all, in the order of one rank; collective.
	void evaluate(const StepContext<D>& step, const State& state, const FreeSurface<D>* surface);
	/// Forces of those that accelerate the ground.
	void accelerate(MomentumSolver<D>& momentum, SolidMotion<D>& motion) const;

private:
	struct Item {
		Boundary<D>*           boundary;
		int                    index;  ///< among the boundaries of the scene
		std::vector<NodeShare> shares; ///< of its volume
	};
	void        evaluateOne(const StepContext<D>& step, const Item& item, const State& state, const FreeSurface<D>* surface);
	void        clear();
	int         nodeOfSlot(const Item& item, std::size_t slot, const FreeSurface<D>* surface) const;
	void        add(const StepContext<D>& step, const Item& item, const State& state, const FreeSurface<D>* surface, int slot, int node);
	void        addNodesOfAll(const StepContext<D>& step, const Item& item, const State& state, const FreeSurface<D>* surface);
	static void requireSameFluxes(SlabDecomposition& slabs, const Boundary<D>& boundary);
	/// Nodes in the rows of this rank's strips.
	static std::pair<int, int> ownNodes(const StepContext<D>& step);

	std::vector<Item> list_;
	BoundaryNodes<D>  nodes_;   ///< what the present one sees
	std::vector<int>  numbers_; ///< of these nodes on the grid
};

} // namespace talik
