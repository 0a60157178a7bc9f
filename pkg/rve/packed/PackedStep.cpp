// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/rve/packed/PackedContactMath.hpp>

namespace talik {

namespace {

	template <int Dim> void clampShear(double* shear, double cap)
	{
		const double norm = shearNorm<Dim>(shear);
		if (norm <= cap) return;
		const double factor = cap / norm;
		for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
			shear[d] *= factor;
	}

	template <> void clampShear<2>(double* shear, double cap)
	{
		if (shear[0] > cap) shear[0] = cap;
		if (shear[0] < -cap) shear[0] = -cap;
	}

	template <int Dim> bool sameShear(const double* a, const double* b)
	{
		for (int d = 0; d < PackedLayout<Dim>::shear; ++d)
			if (a[d] != b[d]) return false;
		return true;
	}

	template <int Dim> void keepNormal(const PackedPairs<Dim>& pairs, std::size_t lane, const double* n)
	{
		if constexpr (Dim == 3)
			for (int d = 0; d < 3; ++d)
				pairs.normals[lane / 4].n[d][lane % 4] = n[d];
	}

	/// Takes shear over from the previous step: turned with the contact for spheres, as it is for discs.
	template <int Dim>
	void carryShear(const PackedStepView<Dim>& view, const PackedPairs<Dim>& pairs, const PackedPairRows<Dim>& rows, std::size_t lane, const double* n, double* shear)
	{
		if constexpr (Dim == 3) {
			if (shear[0] == 0 && shear[1] == 0 && shear[2] == 0) return;
			double old[3];
			for (int d = 0; d < 3; ++d)
				old[d] = pairs.normals[lane / 4].n[d][lane % 4];
			rotateShear(view, rows, old, n, shear);
		}
	}

	template <int Dim, bool Bonded> void contactLoop(PackedStepView<Dim>& view, const PackedPairs<Dim>& pairs, int periodic)
	{
		constexpr int parts = PackedLayout<Dim>::shear;
		for (std::size_t lane = 0; lane < 4 * pairs.blocks; ++lane) {
			PackedBlock<Dim>&         block = pairs.block[lane / 4];
			const std::size_t         l     = lane % 4;
			const PackedPairRows<Dim> rows  = pairRows(view, pairs, lane);
			const double              floor = Bonded ? pairs.ice[lane / 4].floor[l] : 0.;
			const double              sum   = block.sumRadius[l];
			double                    n[Dim];
			const double              square = pairBranch(view, rows, n);
			if (square > sum * sum && (!Bonded || floor == 0)) {
				for (int d = 0; d < parts; ++d)
					block.shear[d][l] = 0;
				continue;
			}
			const double distance = std::sqrt(square), inverse = 1 / distance, overlap = sum - distance;
			for (int d = 0; d < Dim; ++d)
				n[d] *= inverse;
			double slip[parts], shear[parts], trial[parts];
			slipVelocity(view, rows, n, sum * inverse, slip);
			const double stiffness = block.stiffness[l], increment = view.stiffnessRatio * stiffness * view.dt;
			for (int d = 0; d < parts; ++d)
				shear[d] = block.shear[d][l];
			carryShear(view, pairs, rows, lane, n, shear);
			for (int d = 0; d < parts; ++d)
				trial[d] = shear[d] = shear[d] - increment * slip[d];
			double normalForce = stiffness * overlap;
			if constexpr (Bonded) {
				PackedIceBlock<Dim>& ice = pairs.ice[lane / 4];
				const double         raw = normalForce - ice.offset[l];
				normalForce              = raw < floor ? floor : raw;
				clampShear<Dim>(shear, ice.cohesion[l] + (floor < 0 ? view.bondFriction : view.friction) * (raw > 0 ? raw : 0));
				const bool limited = !sameShear<Dim>(trial, shear), opened = floor != 0 && raw < floor, failed = floor < 0 && limited;
				if (ice.iceShare[l] != 0 || floor < 0 || opened) {
					PackedBondEvent<Dim> event;
					event.periodic    = periodic;
					event.lane        = lane;
					event.overlap     = overlap;
					event.normalForce = raw;
					for (int d = 0; d < parts; ++d)
						event.iceShear[d] = ice.iceShear[d][l];
					carryShear(view, pairs, rows, lane, n, event.iceShear);
					for (int d = 0; d < parts; ++d) {
						event.shear[d]     = trial[d];
						event.increment[d] = increment * slip[d];
						event.iceShear[d] -= ice.iceShare[l] * event.increment[d];
					}
					if (opened || failed) {
						view.bondEvent(view.owner, &event);
						normalForce = event.normalForce;
						for (int d = 0; d < parts; ++d)
							shear[d] = event.shear[d];
					} else if (limited) { // a broken bond slides: the ice's share shrinks with the rest
						const double factor = shearNorm<Dim>(shear) / shearNorm<Dim>(trial);
						for (int d = 0; d < parts; ++d)
							event.iceShear[d] *= factor;
					}
					for (int d = 0; d < parts; ++d)
						ice.iceShear[d][l] = event.iceShear[d];
				}
			} else {
				clampShear<Dim>(shear, view.friction * normalForce);
			}
			for (int d = 0; d < parts; ++d)
				block.shear[d][l] = shear[d];
			keepNormal(pairs, lane, n);
			addPairForce(view, rows, n, overlap, normalForce, shear);
		}
	}

	template <int Dim, bool Bonded> void contacts(PackedStepView<Dim>* view)
	{
		contactLoop<Dim, Bonded>(*view, view->inner, 0);
		contactLoop<Dim, Bonded>(*view, view->periodic, 1);
	}

	/// YADE's numerical damping: acceleration is reduced where it feeds the velocity and raised where it brakes. Its sign is as good as
	/// random, so it is not branched upon.
	inline double damped(double acceleration, double velocity, double damping, double halfStep)
	{
		return acceleration * (1 - std::copysign(damping, acceleration * (velocity + halfStep * acceleration)));
	}

	template <int Dim> void turnGrain(PackedStepView<Dim>& view, std::size_t g, const double* spinJump, bool jump)
	{
		const double halfStep = 0.5 * view.dt;
		if constexpr (Dim == 2) {
			double*      force = view.force + 4 * g;
			double&      w     = view.angular[g];
			const double a     = (force[3] - view.radius[g] * force[2]) * view.inverseInertia[g];
			w += view.dt * damped(a, w, view.damping, halfStep);
			if (jump) w += spinJump[0];
			view.orientation[g] += view.dt * w;
			view.spin[g] = w * view.radius[g];
		} else {
			double* force = view.force + 8 * g;
			double* w     = view.angular + 3 * g;
			for (int d = 0; d < 3; ++d) {
				const double a = force[4 + d] * view.inverseInertia[g];
				w[d] += view.dt * damped(a, w[d], view.damping, halfStep);
				if (jump) w[d] += spinJump[d];
				view.spin[4 * g + d] = w[d];
			}
			double*      q     = view.orientation + 4 * g;
			const double speed = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
			if (speed > 0) {
				const double angle = 0.5 * view.dt * speed, c = std::cos(angle), s = std::sin(angle) / speed;
				const double x = s * w[0], y = s * w[1], z = s * w[2];
				const double p[4] = { c * q[0] - x * q[1] - y * q[2] - z * q[3], c * q[1] + x * q[0] + y * q[3] - z * q[2],
					                  c * q[2] - x * q[3] + y * q[0] + z * q[1], c * q[3] + x * q[2] - y * q[1] + z * q[0] };
				const double norm = 1 / std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
				for (int d = 0; d < 4; ++d)
					q[d] = p[d] * norm;
			}
		}
	}

	template <int Dim> void integrate(PackedStepView<Dim>* view)
	{
		constexpr int strideV = PackedLayout<Dim>::motion, strideF = PackedLayout<Dim>::force;
		const double  dt = view->dt, halfStep = 0.5 * dt;
		double        jump[Dim * Dim], spinJump[3] = { 0, 0, 0 };
		bool          jumps = false;
		for (int k = 0; k < Dim * Dim; ++k) {
			jump[k] = view->nextVelGrad[k] - view->prevVelGrad[k];
			jumps |= jump[k] != 0;
		}
		if constexpr (Dim == 2) {
			spinJump[0] = -0.5 * (jump[1] - jump[2]);
		} else {
			spinJump[0] = -0.5 * (jump[5] - jump[7]);
			spinJump[1] = -0.5 * (jump[6] - jump[2]);
			spinJump[2] = -0.5 * (jump[1] - jump[3]);
		}
		const double* gradient = view->prevVelGrad;
		double        virial[Dim * Dim] = {}, largest = 0;
		for (std::size_t g = 0; g < view->grains; ++g) {
			double* x = view->motion + strideV * g;
			double* v = x + Dim;
			double* f = view->force + strideF * g;
			double  old[Dim], fluctuation = 0;
			for (int d = 0; d < Dim; ++d)
				old[d] = v[d];
			double carried[Dim];
			for (int d = 0; d < Dim; ++d) {
				double meanField = 0, convected = 0, leap = 0;
				for (int e = 0; e < Dim; ++e) {
					meanField += gradient[d * Dim + e] * x[e];
					convected += gradient[d * Dim + e] * old[e];
					leap += jump[d * Dim + e] * x[e];
				}
				const double a = damped(f[d] * view->minusInverseMass[g], old[d] - meanField, view->damping, halfStep) + convected;
				v[d] += dt * a;
				if (jumps) v[d] += leap;
				carried[d] = v[d] - meanField - (jumps ? leap : 0);
				fluctuation += carried[d] * carried[d];
			}
			for (int d = 0; d < Dim; ++d)
				x[d] += dt * v[d];
			if (fluctuation > largest) largest = fluctuation;
			turnGrain(*view, g, spinJump, jumps);
			if (view->sampleStress)
				for (int d = 0; d < Dim; ++d)
					for (int e = 0; e < Dim; ++e)
						virial[d * Dim + e] += f[d] * x[e];
			for (int d = 0; d < strideF; ++d)
				f[d] = 0;
		}
		for (int k = 0; k < Dim * Dim; ++k)
			view->virial[k] = virial[k];
		view->maxFluctuationSquare = largest;
	}

} // namespace

template <int Dim> PackedKernel<Dim> portableKernel(bool bonded)
{
	if (bonded) return { contacts<Dim, true>, integrate<Dim>, "portable" };
	return { contacts<Dim, false>, integrate<Dim>, "portable" };
}

template PackedKernel<2> portableKernel<2>(bool);
template PackedKernel<3> portableKernel<3>(bool);

} // namespace talik
