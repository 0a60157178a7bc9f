#!/bin/bash
# SPDX-License-Identifier: GPL-2.0-or-later
# usage: sanitized.sh SOURCE BUILD: unit and stability tests of the part without YADE, built in the folder BUILD with the address and
# undefined-behaviour sanitizers. Ends with an error on the first report of either.
set -euo pipefail
source=$1 build=$2
mkdir -p "$build"
export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
if ! { cmake -S "$source" -B "$build" -DTALIK_SANITIZE=ON -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache)" &&
	cmake --build "$build" --target talik_unit talik_stability; } >"$build/build.log" 2>&1; then
	tail -n 40 "$build/build.log"
	exit 1
fi
export ASAN_OPTIONS=detect_leaks=1 UBSAN_OPTIONS=print_stacktrace=1
for kind in unit stability; do
	TALIK_DRAWS=${TALIK_DRAWS:-100} "$build/talik_$kind" --gtest_brief=1 --gtest_filter="-*_slow" >"$build/$kind.log" 2>&1 || {
		tail -n 60 "$build/$kind.log"
		exit 1
	}
	printf '%s tests under address and undefined-behaviour sanitizers: %s\n' "$kind" "$(grep PASSED "$build/$kind.log")"
done
