// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundParts.hpp>

namespace talik {

template <int D> Balance<D> Ground<D>::balance() const
{
	const Parts& g = *parts_;
	if (!g.ready) throw std::logic_error("balance: the ground is not initialised");
	Balance<D> b;
	b.time      = g.clock.time;
	const int n = g.points->count();
	for (int p = 0; p < n; ++p) {
		double moving = 0.0, liquid = 0.0;
		if (g.content) {
			const double ice = g.content->iceMass ? g.content->iceMass[p] : 0.0;
			b.solidMass += g.content->solidMass[p];
			b.waterMass += g.content->waterMass[p];
			b.iceMass += ice;
			if (g.water) liquid = g.content->waterMass[p] - ice;
		}
		if (g.motion) {
			moving = g.motion->mass[p];
			if (!g.content) b.solidMass += moving;
			const Vec<D>& gravity = g.motion->settings->gravity;
			for (int a = 0; a < D; ++a) {
				const double v = g.motion->velocity[a][p], vl = g.water ? g.water->velocity[a][p] : 0.0;
				b.momentum[a] += moving * v + liquid * vl;
				b.kineticEnergy += 0.5 * (moving * v * v + liquid * vl * vl);
				b.gravityEnergy -= (moving + liquid) * gravity[a] * g.motion->position[a][p];
			}
		}
		if (g.heat) b.enthalpy += g.heat->enthalpy[p];
	}
	b.impulse            = g.clock.account.impulse;
	b.dragDissipation    = g.clock.account.dragDissipation;
	b.dampingDissipation = g.clock.account.dampingDissipation;
	b.loadWork           = g.clock.account.loadWork;
	b.slipWork           = g.clock.account.slipWork;
	b.skeletonWork       = g.clock.skeletonWork;
	b.porePressureWork   = g.clock.porePressureWork;
	if (g.heat) b.heatIn = g.heat->heatIn;
	if (g.water) {
		b.waterOut    = g.water->waterOut;
		b.enthalpyOut = g.water->enthalpyOut;
		for (int a = 0; a < D; ++a)
			b.impulse[a] -= g.water->momentumOut[a];
	}
	return b;
}

template Balance<2> Ground<2>::balance() const;
template Balance<3> Ground<3>::balance() const;

} // namespace talik
