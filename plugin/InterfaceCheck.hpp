// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <string>

namespace talik {

/// Compares the memory layout that this module was compiled for with what the running YADE reports about itself: offsets and
/// types from the member pointers inside its Python getters, object sizes from its allocations, virtual functions from its
/// tables. Returns an empty string when all agree, else one sentence naming YADE's version, the class and the member.
/// The environment variable TALIK_EXPECT_OFFSET, "Class.member=offset", overrides one expectation (to prove the refusal).
std::string interfaceMismatch();

} // namespace talik
