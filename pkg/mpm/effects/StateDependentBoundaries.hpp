// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/boundary/Boundary.hpp>
#include <pkg/mpm/effects/FreeSurface.hpp>
#include <pkg/mpm/effects/HeatTransfer.hpp>
#include <pkg/mpm/effects/MomentumSolver.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/StepContext.hpp>
#include <string>

#include <cstring>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

namespace talik {

/// Boundaries whose fluxes follow from the state of their nodes (Boundary::usesNodes).
template <int D> class StateDependentBoundaries {
public:
	/// Finds them among the boundaries of a scene, which have to live as long.
	void find(const Grid<D>& grid, const std::vector<std::shared_ptr<Boundary<D>>>& boundaries)
	{
		for (std::size_t b = 0; b < boundaries.size(); ++b)
			if (boundaries[b]->usesNodes()) list_.push_back({ boundaries[b].get(), int(b), nodeShares(grid, boundaries[b]->region()) });
	}
	bool empty() const { return list_.empty(); }

	/// What the nodes have at the beginning of a step, mapped from the points; null where the ground has no such effect.
	struct State {
		const SolidMotion<D>*  motion;
		const HeatTransfer<D>* heat;
		const PoreWater<D>*    water;
	};
	/// Every boundary sees the state of its nodes and finds its fluxes, before anything of the step is booked. surface: of boundaries that act there.
	/// With ranks each of them sees the nodes of all, in the order of one rank; collective.
	void evaluate(const StepContext<D>& step, const State& state, const FreeSurface<D>* surface)
	{
		nodes_.time = step.calendarEnd;
		for (const Item& item : list_)
			evaluateOne(step, item, state, surface);
	}
	/// Forces of those that accelerate the ground.
	void accelerate(MomentumSolver<D>& momentum, SolidMotion<D>& motion) const
	{
		for (const Item& item : list_)
			if (item.boundary->accelerates()) momentum.accelerate(*item.boundary, item.shares, motion);
	}

private:
	template <class T> static void appendBytes(std::string& bytes, const std::vector<T>& values)
	{
		bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
	}
	template <class T> static void takeBytes(const char*& from, std::size_t count, std::vector<T>& values)
	{
		const std::size_t before = values.size();
		values.resize(before + count);
		std::memcpy(static_cast<void*>(values.data() + before), from, count * sizeof(T));
		from += count * sizeof(T);
	}
	struct Item {
		Boundary<D>*           boundary;
		int                    index;  ///< among the boundaries of the scene
		std::vector<NodeShare> shares; ///< of its volume
	};
	void evaluateOne(const StepContext<D>& step, const Item& item, const State& state, const FreeSurface<D>* surface)
	{
		nodes_.slots = item.boundary->takesVolumes() ? item.shares.size() : surface->patch(item.index).nodes.size();
		clear();
		const auto range = ownNodes(step);
		for (std::size_t k = 0; k < nodes_.slots; ++k) {
			const int node = nodeOfSlot(item, k, surface);
			if (node >= range.first && node < range.second) add(step, item, state, surface, int(k), node);
		}
		if (step.slabs) addNodesOfAll(step, item, state, surface);
		item.boundary->evaluate(nodes_);
		if (step.slabs) requireSameFluxes(*step.slabs, *item.boundary);
	}
	void clear()
	{
		nodes_.slot.clear();
		numbers_.clear();
		for (auto* vectors : { &nodes_.position, &nodes_.normal, &nodes_.velocity })
			vectors->clear();
		for (auto* numbers : { &nodes_.temperature, &nodes_.pressure })
			numbers->clear();
	}
	int nodeOfSlot(const Item& item, std::size_t slot, const FreeSurface<D>* surface) const
	{
		return item.boundary->takesVolumes() ? item.shares[slot].node : surface->patch(item.index).nodes[slot].node;
	}
	void add(const StepContext<D>& step, const Item& item, const State& state, const FreeSurface<D>* surface, int slot, int node)
	{
		const SolidMotion<D>* const motion = state.motion;
		const double* const         moving = motion ? motion->nodes[node] : nullptr;
		if (!((moving ? moving[motion->massAt] : state.heat->nodes[node][0]) > 0.0)) return;
		Vec<D>     x, v;
		const auto at = step.grid.nodeOf(node);
		for (int a = 0; a < D; ++a) {
			x[a] = step.grid.nodePosition(a, at[a]);
			v[a] = moving ? moving[motion->momentumAt + a] / moving[motion->massAt] : 0.0;
		}
		nodes_.slot.push_back(slot);
		numbers_.push_back(node);
		nodes_.position.push_back(x);
		if (moving) nodes_.velocity.push_back(v);
		if (state.heat) nodes_.temperature.push_back(state.heat->mapped[node][0]);
		if (state.water) nodes_.pressure.push_back(state.water->pressureAtNode(node));
		if (item.boundary->takesVolumes()) return;
		const Vec<D> normal = surface->patch(item.index).nodes[slot].area;
		const double area   = lengthOf<D>(normal);
		nodes_.normal.push_back(area > 0.0 ? normal / area : normal);
	}
	/// Nodes follow each other by rows, as slabs do.
	void addNodesOfAll(const StepContext<D>& step, const Item& item, const State& state, const FreeSurface<D>* surface)
	{
		const bool  normal = !item.boundary->takesVolumes();
		std::string own;
		appendBytes(own, numbers_);
		for (const auto* vectors : { &nodes_.position, &nodes_.normal, &nodes_.velocity })
			appendBytes(own, *vectors);
		for (const auto* numbers : { &nodes_.temperature, &nodes_.pressure })
			appendBytes(own, *numbers);
		const std::size_t ofNode = sizeof(int) + (1 + normal + bool(state.motion)) * sizeof(Vec<D>)
		        + (bool(state.heat) + bool(state.water)) * sizeof(double);
		clear();
		for (const std::string& bytes : step.slabs->say(own)) {
			const std::size_t count = bytes.size() / ofNode;
			const char*       from  = bytes.data();
			takeBytes(from, count, numbers_);
			takeBytes(from, count, nodes_.position);
			if (normal) takeBytes(from, count, nodes_.normal);
			if (state.motion) takeBytes(from, count, nodes_.velocity);
			if (state.heat) takeBytes(from, count, nodes_.temperature);
			if (state.water) takeBytes(from, count, nodes_.pressure);
		}
		std::size_t k = 0; // slots follow the nodes, too
		for (const int node : numbers_) {
			while (k < nodes_.slots && nodeOfSlot(item, k, surface) < node)
				++k;
			nodes_.slot.push_back(k < nodes_.slots && nodeOfSlot(item, k, surface) == node ? int(k) : -1);
		}
	}
	/// Ranks work out the fluxes of a boundary each for themselves.
	static void requireSameFluxes(SlabDecomposition& slabs, const Boundary<D>& boundary)
	{
		const auto digests = slabs.byRank(boundary.digest());
		for (std::size_t rank = 1; rank < digests.size(); ++rank)
			if (digests[rank] != digests[0])
				throw std::runtime_error(
				        boundary.name() + " gives other values on rank " + std::to_string(rank)
				        + " than on rank 0: let its function follow from its argument alone, or choose distribute='none'.");
	}
	/// Nodes in the rows of this rank's strips.
	static std::pair<int, int> ownNodes(const StepContext<D>& step)
	{
		const SlabDecomposition* const slabs = step.slabs;
		if (!slabs) return { 0, step.grid.nodeCount() };
		const int strip = Strips::rows * step.grid.nodeStride(step.strips.axis);
		return { slabs->firstStrip() * strip, slabs->rank() + 1 == slabs->count() ? step.grid.nodeCount() : slabs->endStrip() * strip };
	}

	std::vector<Item> list_;
	BoundaryNodes<D>  nodes_;   ///< what the present one sees
	std::vector<int>  numbers_; ///< of these nodes on the grid
};

} // namespace talik
