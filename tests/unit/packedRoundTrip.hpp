// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
// What a sample must keep to the last bit when it is saved, made compact and advanced by a pool.

#include "packedReference.hpp"

#include <pkg/rve/packed/PackedSamplePool.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace packedReference {

/// state comes back from its bytes and from its compact form, and a pool advances it as it advances alone, through some ice saturations; moments are
/// those of its contacts, of which one at least has to act.
inline void expectKept(const talik::PackedState<2>& state, const std::vector<double>& moments, const std::vector<double>& iceSaturations)
{
	using namespace talik;
	const std::string bytes = state.toBytes();
	PackedState<2>    expanded;
	CompactSample<2>(state).expand(expanded);
	EXPECT_TRUE(std::any_of(moments.begin(), moments.end(), [](double moment) { return moment != 0; }));
	EXPECT_EQ(PackedState<2>::fromBytes(bytes).toBytes(), bytes);
	EXPECT_EQ(expanded.toBytes(), bytes);

	SamplePool<2>       pool;
	PackedUpdateOptions options;
	options.steps = 40;
	pool.add(state);
	PackedSample<2> alone(state);
	for (const double ice : iceSaturations) {
		pool.update({ { 0, matrix(1e-5, 4e-5, 0, -3e-5), ice } }, options, 1);
		alone.apply(matrix(1e-5, 4e-5, 0, -3e-5), ice, options);
		EXPECT_EQ(pool.state(0).toBytes(), alone.state().toBytes());
	}
}

} // namespace packedReference
