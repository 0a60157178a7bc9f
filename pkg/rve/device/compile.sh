#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# compile.sh CLANG nvidia|amd SOURCES EIGEN OUTPUT: kernels for the cards of a maker, as PTX or as code for gfx90a, with no file of the maker's.
# Where clang cannot, the output is empty and the build goes on.
clang=$1 maker=$2 sources=$3 eigen=$4 output=$5
common="-std=c++17 -O3 -fno-math-errno -fno-trapping-math -ffp-contract=off -DEIGEN_NO_CUDA -DEIGEN_NO_HIP -DEIGEN_DONT_VECTORIZE -Wno-ignored-pragmas
	-I$sources/pkg/rve/device/one -I$sources -isystem $eigen -S $sources/pkg/rve/device/CardKernels.cu -o $output"
mkdir -p "$(dirname "$output")"
case $maker in
nvidia) # PTX 7.5: drivers of CUDA 11.5 (2021) and later
	"$clang" -x cuda -Xclang -target-feature -Xclang +ptx75 --cuda-device-only --cuda-gpu-arch=sm_70 --cuda-path=/nowhere -nocudainc -nocudalib $common ;;
amd) "$clang" -x hip --cuda-device-only --offload-arch=gfx90a -nogpuinc -nogpulib $common ;;
esac && exit
echo "clang did not compile the kernels for graphics cards: Talik is built without them." >&2
: >"$output"
