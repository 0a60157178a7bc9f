// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/points/CellMeans.hpp>
#include <pkg/mpm/StepContext.hpp>

namespace talik {

/// Work of effective stress and pore pressure on the strain of a step, half with the stress at its start and half with that at its end: the mean
/// of both is what an elastic skeleton stores, either alone is off by the first order of dt.
template <int D> class StrainWork {
public:
	/// Part of the work of pore pressure that is taken with the pressure at the start of the step; the rest with that at its end.
	double pressureAtStart = 1.0;
	/// The pressure acts in the step itself, and not on the motion in the next one (implicit pressure).
	bool pressureActsNow = false;

	/// Before cell means (null: there are none) replace the divergence. water may be null.
	void bookStart(
	        const StepContext<D>& step, const MaterialPoints<D>& points, const SolidMotion<D>& motion, const PoreWater<D>* water,
	        const CellMeans<D>* means) const;
	/// When stress and pressure are those of the end.
	void bookEnd(const StepContext<D>& step, const MaterialPoints<D>& points, const SolidMotion<D>& motion, const PoreWater<D>* water) const;

private:
	TALIK_PROCESSOR_VERSIONS static double skeletonWork(
	        const MaterialPoints<D>& points, const SolidMotion<D>& motion, const CellMeans<D>* means, int first, int last);
	TALIK_PROCESSOR_VERSIONS static double pressureWork(
	        const MaterialPoints<D>& points, const SolidMotion<D>& motion, const double* pressure, const CellMeans<D>* means, int first, int last);
};

} // namespace talik
