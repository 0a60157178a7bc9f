// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/skeleton/SkeletonModel.hpp>

namespace talik {

/// One point driven by displacement gradients.
template <int D> struct Element {
	double gradient[D * D]       = {};
	double stress[stressSize<D>] = {};
	double ice = 0.0, volume = 1.0, temperature = 0.0, time = 0.0;
	int    place = 0, id = 0;
	void   step(SkeletonModel<D>& model)
	{
		SkeletonBatch<D> b;
		b.count = 1;
		b.place = &place;
		b.id    = &id;
		for (int c = 0; c < D * D; ++c)
			b.gradient[c] = &gradient[c];
		for (int c = 0; c < stressSize<D>; ++c)
			b.stress[c] = &stress[c];
		b.iceSaturation = &ice;
		b.volume        = &volume;
		b.temperature   = &temperature;
		b.time          = { time, time };
		model.updateStress(b);
	}
};

} // namespace talik
