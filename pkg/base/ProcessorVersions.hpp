// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

/// Before a function with loops over points: the compiler builds it for several processors, and the version that the processor
/// at hand knows is taken when the library is loaded. Operations and their order stay those of the source, so all versions give
/// the same bits. Sanitizers start too late for the choice; they see the version for any processor.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define TALIK_PROCESSOR_VERSIONS __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define TALIK_PROCESSOR_VERSIONS
#endif
