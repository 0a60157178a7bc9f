// SPDX-License-Identifier: GPL-2.0-or-later
// One version of the packed samples, behind functions of its own name: NAME(x) is given by the build.
#include <memory>
#include <tests/unit/packedReference.hpp>

namespace {
std::unique_ptr<talik::PackedSample<2>> sample;
packedReference::State                  start;
} // namespace

/// Reads the sample of discs, and freezes it where that is asked for.
extern "C" void NAME(prepare)(const char* file, bool frozen)
{
	sample = std::make_unique<talik::PackedSample<2>>(packedReference::read(file).state());
	for (int k = 1; frozen && k <= 20; ++k) {
		sample->setIceSaturation(k / 20.);
		sample->advance(5);
	}
	start = sample->state();
}

/// Pressure [Pa] after some steps of pure shear from the start.
extern "C" double NAME(run)(long steps)
{
	constexpr double        rate = 0.01; // [1/s]
	packedReference::Matrix shear;
	shear << rate, 0, 0, -rate;
	sample->setState(start);
	sample->advance(shear, steps);
	return -0.5 * sample->state().stress.trace();
}
