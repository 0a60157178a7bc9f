// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Vector.hpp>
#include <pkg/mpm/points/PointFields.hpp>

#include <array>
#include <vector>

namespace talik {

/// The moving points as an effect sees them: arrays by place, of all points. Between two sortings a place belongs to one point.
template <int D> struct PointsInMotion {
	std::array<const double*, D>             position;
	std::array<const double*, D>             velocity; ///< of the solid [m/s]
	std::array<const double*, D * D>         gradient; ///< displacement gradient of the last step, Delta t dv_i/dx_j at [i*D+j] [-], with B-bar
	std::array<const double*, stressSize<D>> stress;   ///< effective, tension positive [Pa]
	const double*                            mass;     ///< that moves with the solid [kg]
	const double*                            volume;   ///< [m^D]
	double* addedStress; ///< added to each normal stress by the momentum balance [Pa], tension positive; null: see Effect::addsStress()
	std::array<const double*, D> displacement;  ///< since the start [m]
	const double*                initialVolume; ///< at the start [m^D]
	const double*                hoop;          ///< direct strain of the step around the axis [-]; null: there is no axis

	/// Of the displacement gradient of a point: its volumetric strain in the step [-].
	double trace(int place) const
	{
		double sum = hoop ? hoop[place] : 0.0;
		for (int a = 0; a < D; ++a)
			sum += gradient[a * D + a][place];
		return sum;
	}
	/// Effective normal stress of a point on a plane with this unit normal, compression positive [Pa].
	double pressureAlong(int place, const Vec<D>& normal) const
	{
		double pressure = 0.0;
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D; ++j)
				pressure -= normal[i] * stress[stressIndex<D>(i, j)][place] * normal[j];
		return pressure;
	}
};

/// Displacement gradients of the points by component, for an effect that changes them.
template <int D> using Gradients = std::array<double*, D * D>;

/// Strain that an effect adds to the displacement gradient of some points, so that skeleton laws see that of the soil, and takes out again.
template <int D> class AddedStrain {
public:
	/// Of up to so many points.
	void reserve(int points) { before_.reserve(points); }
	/// Adds a strain along a direction to the gradient of a point.
	void add(const Gradients<D>& gradient, int place, double strain, const Vec<D>& along)
	{
		Before before { place, {} };
		for (int i = 0; i < D; ++i)
			for (int j = 0; j < D; ++j) {
				double* const component    = gradient[i * D + j];
				before.gradient[i * D + j] = component[place];
				component[place] += strain * along[i] * along[j];
			}
		before_.push_back(before);
	}
	/// The gradients are what they were before.
	void takeOut(const Gradients<D>& gradient)
	{
		for (auto before = before_.rbegin(); before != before_.rend(); ++before) // the first of a point is that without any
			for (int c = 0; c < D * D; ++c)
				gradient[c][before->place] = before->gradient[c];
		before_.clear();
	}

private:
	struct Before {
		int                       place;
		std::array<double, D * D> gradient;
	};
	std::vector<Before> before_;
};

} // namespace talik
