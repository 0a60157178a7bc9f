// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Vector.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace talik {

/// Principal values and axes of some stress tensors.
struct Spectra {
	static constexpr int most  = 64;
	int                  count = 0;
	double               stress[6][most];  ///< given: xx, yy, zz, yz, xz, xy [Pa]
	double               value[3][most];   ///< largest first [Pa]
	double               axis[3][3][most]; ///< axis k, component i at [k][i]: orthogonal unit vectors

	/// Finds values and axes of all tensors, to round-off of their largest component, also where values are equal.
	void find();
};

/// Stress of one point in its principal axes. change(p) of apply() gets the principal stresses, largest first [Pa], and says whether it
/// changed them; the axes stay.
template <int D> class PrincipalStresses;

/// Plane strain: two principal stresses in the plane, the third is zz.
template <> class PrincipalStresses<2> {
public:
	/// The stress at a place, components in order of stressIndex.
	PrincipalStresses(const std::array<double*, 4>& stress, int place)
	{
		for (int c = 0; c < 4; ++c)
			s_[c] = stress[c][place];
	}
	template <class Change> bool apply(Change&& change)
	{
		const double centre = 0.5 * (s_[0] + s_[1]), half = 0.5 * (s_[0] - s_[1]);
		const double radius     = std::sqrt(half * half + s_[3] * s_[3]);
		const double inPlane[3] = { centre + radius, centre - radius, s_[2] };
		int          order[3]   = { 0, 1, 2 };
		if (inPlane[2] > inPlane[0]) order[0] = 2, order[1] = 0, order[2] = 1;
		else if (inPlane[2] > inPlane[1]) order[1] = 2, order[2] = 1;
		double after[3] = { inPlane[order[0]], inPlane[order[1]], inPlane[order[2]] };
		if (!change(after)) return false;
		double corrected[3];
		for (int i = 0; i < 3; ++i)
			corrected[order[i]] = after[i];
		const double newCentre = 0.5 * (corrected[0] + corrected[1]), newRadius = 0.5 * (corrected[0] - corrected[1]);
		const double cosine = radius > 0.0 ? half / radius : 1.0, sine = radius > 0.0 ? s_[3] / radius : 0.0;
		s_[0] = newCentre + newRadius * cosine;
		s_[1] = newCentre - newRadius * cosine;
		s_[2] = corrected[2];
		s_[3] = newRadius * sine;
		return true;
	}
	/// One of three normal stresses whose sum is the trace [Pa].
	double normal(int i) const { return s_[i]; }
	/// Component in order of stressIndex [Pa].
	double component(int c) const { return s_[c]; }

private:
	double s_[4];
};

template <> class PrincipalStresses<3> {
public:
	/// Tensor i of some whose values and axes were found.
	PrincipalStresses(const Spectra& all, int i)
	        : value_ { all.value[0][i], all.value[1][i], all.value[2][i] }
	        , all_(&all)
	        , i_(i)
	{}
	template <class Change> bool apply(Change&& change)
	{
		double after[3] = { value_[0], value_[1], value_[2] };
		if (!change(after)) return false;
		std::copy(after, after + 3, value_);
		changed_ = true;
		return true;
	}
	double normal(int i) const { return value_[i]; }
	double component(int c) const
	{
		if (!changed_) return all_->stress[c][i_];
		constexpr int first[] = { 0, 1, 2, 1, 0, 0 }, second[] = { 0, 1, 2, 2, 2, 1 };
		double        sum = 0.0;
		for (int k = 0; k < 3; ++k)
			sum += value_[k] * all_->axis[k][first[c]][i_] * all_->axis[k][second[c]][i_];
		return sum;
	}

private:
	double         value_[3];
	const Spectra* all_;
	int            i_;
	bool           changed_ = false;
};

/// work(k, principal) for every marked point of a sequence; what it leaves in principal becomes the point's stress.
template <class Work> void overMarked(const long long* marked, int count, const std::array<double*, 4>& stress, Work&& work)
{
	for (int k = 0; k < count; ++k) {
		if (!marked[k]) continue;
		PrincipalStresses<2> principal(stress, k);
		work(k, principal);
		for (int c = 0; c < 4; ++c)
			stress[c][k] = principal.component(c);
	}
}
template <class Work> void overMarked(const long long* marked, int count, const std::array<double*, 6>& stress, Work&& work)
{
	Spectra spectra;
	int     place[Spectra::most];
	for (int next = 0; next < count;) {
		for (spectra.count = 0; next < count && spectra.count < Spectra::most; ++next) {
			if (!marked[next]) continue;
			for (int c = 0; c < 6; ++c)
				spectra.stress[c][spectra.count] = stress[c][next];
			place[spectra.count++] = next;
		}
		spectra.find();
		for (int i = 0; i < spectra.count; ++i) {
			PrincipalStresses<3> principal(spectra, i);
			work(place[i], principal);
			for (int c = 0; c < 6; ++c)
				stress[c][place[i]] = principal.component(c);
		}
	}
}

} // namespace talik
