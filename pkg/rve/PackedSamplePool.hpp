// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstddef>
#include <memory>
#include <pkg/rve/PackedSample.hpp>
#include <vector>

namespace talik {

/// One sample to be updated.
template <int Dim> struct PackedRequest {
	std::size_t                       sample               = 0;
	typename PackedTypes<Dim>::Matrix displacementGradient = PackedTypes<Dim>::Matrix::Zero();
	double                            iceSaturation        = 0;
};

/// Thousands of samples. Samples that were never asked since they were prepared share one state; the first update detaches them.
template <int Dim> class SamplePool {
public:
	using StatePointer = std::shared_ptr<const PackedState<Dim>>;

	SamplePool();
	SamplePool(const SamplePool& other) : SamplePool() { states = other.states; }
	SamplePool& operator=(const SamplePool& other);

	/// Adds a sample that shares `state`; returns its index. Throws std::invalid_argument when the state is unusable.
	std::size_t  add(StatePointer state);
	std::size_t  size() const { return states.size(); }
	StatePointer state(std::size_t sample) const;
	void         setState(std::size_t sample, StatePointer state);
	void         clear();

	/// Each request's sample, at most once per call. Runs over `threads` OpenMP threads (0: OpenMP's default), each sample whole on
	/// one thread: the results do not depend on their number. Requests that agree bit for bit on the same shared state are computed once
	/// and stay shared. A sample that blows up keeps its last good state.
	/// Throws std::invalid_argument on an unknown or repeated sample, before anything has changed.
	std::vector<PackedUpdateResult<Dim>> update(const std::vector<PackedRequest<Dim>>& requests, const PackedUpdateOptions& options, int threads = 0);

	/// Distinct states held, and the bytes they and their neighbour lists hold.
	std::size_t distinctStates() const;
	std::size_t bytes() const;

private:
	/// Speeds up the next visit and decides nothing: neighbour lists of a state, workspaces of the threads.
	struct Memory;

	std::vector<StatePointer> states;
	std::shared_ptr<Memory>   memory;
};

} // namespace talik
