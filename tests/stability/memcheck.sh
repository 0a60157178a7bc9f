#!/bin/bash
# SPDX-License-Identifier: GPL-2.0-or-later
# usage: memcheck.sh PROGRAM: a slope that thaws and moves, under valgrind; ends with an error on any wrong access, use of what was
# never set, or leak.
set -euo pipefail
log=$(mktemp -t talik-memcheck.XXXXXX)
trap 'rm -f "$log"' EXIT
OMP_NUM_THREADS=1 valgrind --error-exitcode=99 --leak-check=full --errors-for-leak-kinds=definite --show-leak-kinds=definite \
	"$1" --gtest_brief=1 --gtest_filter=Slope.Thaws* >"$log" 2>&1 || { tail -n 60 "$log"; exit 1; }
grep -E "ERROR SUMMARY|PASSED" "$log"
