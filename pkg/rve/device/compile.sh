#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# compile.sh CLANG SOURCES EIGEN OUTPUT: kernels for cards of NVIDIA, as PTX, with no file of the maker's.
# Where clang cannot, the output is empty and the build goes on.
clang=$1 sources=$2 eigen=$3 output=$4
common="-std=c++17 -O3 -fno-math-errno -fno-trapping-math -ffp-contract=off -DEIGEN_NO_CUDA -DEIGEN_DONT_VECTORIZE -Wno-ignored-pragmas
	-I$sources/pkg/rve/device/one -I$sources -isystem $eigen -S $sources/pkg/rve/device/CardKernels.cu -o $output"
mkdir -p "$(dirname "$output")"
# PTX 7.5: drivers of CUDA 11.5 (2021) and later
"$clang" -x cuda -Xclang -target-feature -Xclang +ptx75 --cuda-device-only --cuda-gpu-arch=sm_70 --cuda-path=/nowhere -nocudainc -nocudalib $common && exit
echo "clang did not compile the kernels for graphics cards: Talik is built without them." >&2
: >"$output"
