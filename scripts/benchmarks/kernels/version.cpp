// SPDX-License-Identifier: GPL-2.0-or-later
// One version of the packed samples, behind functions of its own name: NAME(x) is given by the build.
#include <functional>
#include <memory>
#include <tests/unit/packedReference.hpp>
#include <tests/unit/packedSpheres.hpp>

namespace {

std::function<double(long)> run;

/// Pure shear at a small rate, so that few contacts change [1/s].
template <int Dim> typename talik::PackedState<Dim>::Matrix pureShear()
{
	typename talik::PackedState<Dim>::Matrix shear = talik::PackedState<Dim>::Matrix::Zero();
	shear(0, 0)                                    = 0.01;
	shear(1, 1)                                    = -0.01;
	return shear;
}

/// What run does from now on: steps of a sample from one start; it gives the mean pressure [Pa].
template <int Dim> void prepare(const talik::PackedState<Dim>& state, bool frozen)
{
	auto sample = std::make_shared<talik::PackedSample<Dim>>(state);
	for (int k = 1; frozen && k <= 20; ++k) {
		sample->setIceSaturation(k / 20.);
		sample->advance(5);
	}
	run = [sample, start = sample->state()](long steps) {
		sample->setState(start);
		sample->advance(pureShear<Dim>(), steps);
		return -sample->state().stress.trace() / Dim;
	};
}

} // namespace

/// Reads a sample of the tests, of discs or of spheres, and freezes it where that is asked for.
extern "C" void NAME(prepare)(const char* file, bool spheres, bool frozen)
{
	if (spheres) prepare<3>(packedSpheres::read(file).state(), frozen);
	else prepare<2>(packedReference::read(file).state(), frozen);
}

/// Mean pressure [Pa] after some steps of pure shear from the start.
extern "C" double NAME(run)(long steps) { return run(steps); }
