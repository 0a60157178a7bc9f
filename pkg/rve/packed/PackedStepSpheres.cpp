// SPDX-License-Identifier: GPL-2.0-or-later
// The fused step of spheres, pair by pair, in stock YADE's conventions (ScGeom with avoidGranularRatcheting).
#include <cmath>
#include <pkg/icebond/ContactForces.hpp>
#include <pkg/rve/packed/PackedContactMath.hpp>

namespace talik {

namespace {

	using HWY_NAMESPACE::bondedForces;
	using HWY_NAMESPACE::frictionalForces;

	void cross(const double* a, const double* b, double* c)
	{
		c[0] = a[1] * b[2] - a[2] * b[1];
		c[1] = a[2] * b[0] - a[0] * b[2];
		c[2] = a[0] * b[1] - a[1] * b[0];
	}

	/// Tangential velocity of second against first at the contact.
	Eigen::Vector3d slipVelocity(const PackedStepView<3>& view, const PackedPairRows<3>& rows, const double* n, double stretch)
	{
		constexpr int stride = PackedLayout<3>::motion / 4;
		const double* a      = view.motion + rows.first * stride + 3;
		const double* b      = view.motion + rows.second * stride + 3;
		const double* wa     = view.spin + rows.first;
		const double* wb     = view.spin + rows.second;
		double        w[3], rotation[3], normalPart = 0;
		for (int d = 0; d < 3; ++d)
			w[d] = wa[d] * wa[3] + wb[d] * wb[3];
		cross(w, n, rotation);
		Eigen::Vector3d slip;
		for (int d = 0; d < 3; ++d) {
			double v = b[d] - a[d];
			if (rows.shift) v += rows.shift[3 + d];
			slip[d] = stretch * v - rotation[d];
			normalPart += slip[d] * n[d];
		}
		for (int d = 0; d < 3; ++d)
			slip[d] -= normalPart * n[d];
		return slip;
	}

	/// Carries a shear force of the previous step along with the normal and the mean spin, as ScGeom::rotate does.
	void rotateShear(const PackedStepView<3>& view, const PackedPairRows<3>& rows, const double* oldNormal, const double* n, Eigen::Vector3d& shear)
	{
		if (shear.isZero(0)) return;
		const double* wa = view.spin + rows.first;
		const double* wb = view.spin + rows.second;
		double        axis[3], turn[3], twist = 0;
		cross(oldNormal, n, axis);
		cross(shear.data(), axis, turn);
		for (int d = 0; d < 3; ++d) {
			shear[d] -= turn[d];
			twist += n[d] * (wa[d] + wb[d]);
		}
		twist *= 0.5 * view.dt;
		for (int d = 0; d < 3; ++d)
			axis[d] = twist * n[d];
		cross(shear.data(), axis, turn);
		for (int d = 0; d < 3; ++d)
			shear[d] -= turn[d];
	}

	/// Adds a pair's force and moments to the grains' sums, and to its shift's.
	void addPairForce(const PackedStepView<3>& view, const PackedPairRows<3>& rows, const double* n, const ContactForces<double, Eigen::Vector3d>& f)
	{
		constexpr int stride = PackedLayout<3>::force / 4;
		double*       a      = view.force + rows.first * stride;
		double*       b      = view.force + rows.second * stride;
		double        force[3], moment[3];
		pairForce<3>(n, f.normal, f.shear, force);
		cross(n, f.shear.data(), moment);
		const double armA = view.spin[rows.first + 3] - 0.5 * f.overlap;
		const double armB = view.spin[rows.second + 3] - 0.5 * f.overlap;
		for (int d = 0; d < 3; ++d) {
			a[d] += force[d];
			b[d] -= force[d];
			a[4 + d] -= armA * moment[d];
			b[4 + d] -= armB * moment[d];
		}
		if (!rows.shift) return;
		double* sum = view.shiftForce + (rows.shift - view.shiftMotion) / (PackedLayout<3>::motion / 4) * stride;
		for (int d = 0; d < 3; ++d)
			sum[d] += force[d];
	}

	/// Forces of a pair that may be bonded.
	ContactForces<double, Eigen::Vector3d> bondedPair(
	        PackedStepView<3>& view, const PackedPairs<3>& pairs, std::size_t lane, double overlap, const Eigen::Vector3d& shear,
	        const Eigen::Vector3d& iceShear, const Eigen::Vector3d& increment)
	{
		const std::size_t             b = lane / 4, l = lane % 4;
		PackedIceBlock<3>&            ice = pairs.ice[b];
		const ContactResponse<double> contact { pairs.block[b].stiffness[l], ice.offset[l], ice.floor[l], ice.cohesion[l], ice.iceShare[l] };
		const auto                    settle = [&](bool, ContactForces<double, Eigen::Vector3d>& forces) {
                        PackedBondEvent<3> event { pairs.shift != nullptr, lane, forces };
                        view.bondEvent(view.owner, &event);
                        forces = event.forces;
		};
		const auto f = bondedForces(contact, { view.friction, view.bondFriction }, overlap, shear, iceShear, increment, settle);
		setLaneShear<3>(ice.iceShear, l, f.iceShear);
		return f;
	}

	template <bool Bonded> void contactLoop(PackedStepView<3>& view, const PackedPairs<3>& pairs)
	{
		for (std::size_t lane = 0; lane < 4 * pairs.blocks; ++lane) {
			PackedBlock<3>&         block = pairs.block[lane / 4];
			const std::size_t       l     = lane % 4;
			const PackedPairRows<3> rows  = pairRows(view, pairs, lane);
			const double            sum   = block.sumRadius[l];
			double                  n[3];
			const double            square = pairBranch(view, rows, n);
			if (square > sum * sum && (!Bonded || pairs.ice[lane / 4].floor[l] == 0)) {
				setLaneShear<3>(block.shear, l, Eigen::Vector3d::Zero());
				continue;
			}
			const double distance = std::sqrt(square), inverse = 1 / distance, overlap = sum - distance;
			double       oldNormal[3];
			for (int d = 0; d < 3; ++d) {
				n[d] *= inverse;
				oldNormal[d]                    = pairs.normals[lane / 4].n[d][l];
				pairs.normals[lane / 4].n[d][l] = n[d];
			}
			const Eigen::Vector3d increment = view.stiffnessRatio * block.stiffness[l] * view.dt * slipVelocity(view, rows, n, sum * inverse);
			Eigen::Vector3d       shear     = laneShear<3>(block.shear, l);
			rotateShear(view, rows, oldNormal, n, shear);
			ContactForces<double, Eigen::Vector3d> f;
			if constexpr (Bonded) {
				Eigen::Vector3d iceShear = laneShear<3>(pairs.ice[lane / 4].iceShear, l);
				rotateShear(view, rows, oldNormal, n, iceShear);
				f = bondedPair(view, pairs, lane, overlap, shear, iceShear, increment);
			} else {
				f = frictionalForces(block.stiffness[l], view.friction, overlap, shear, increment);
			}
			setLaneShear<3>(block.shear, l, f.shear);
			addPairForce(view, rows, n, f);
		}
	}

	template <bool Bonded> void contacts(PackedStepView<3>* view)
	{
		contactLoop<Bonded>(*view, view->inner);
		contactLoop<Bonded>(*view, view->periodic);
	}

	/// YADE's numerical damping: acceleration is reduced where it feeds the velocity and raised where it brakes. Its sign is as good as
	/// random, so it is not branched upon.
	inline double damped(double acceleration, double velocity, double damping, double halfStep)
	{
		return acceleration * (1 - std::copysign(damping, acceleration * (velocity + halfStep * acceleration)));
	}

	void turnGrain(PackedStepView<3>& view, std::size_t g, const double* spinJump, bool jump)
	{
		const double halfStep = 0.5 * view.dt;
		double*      force    = view.force + 8 * g;
		double*      w        = view.angular + 3 * g;
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

	void integrate(PackedStepView<3>* view)
	{
		constexpr int Dim = 3, strideV = PackedLayout<Dim>::motion, strideF = PackedLayout<Dim>::force;
		const double  dt = view->dt, halfStep      = 0.5 * dt;
		double        jump[Dim * Dim], spinJump[3] = { 0, 0, 0 };
		bool          jumps = false;
		for (int k = 0; k < Dim * Dim; ++k) {
			jump[k] = view->nextVelGrad[k] - view->prevVelGrad[k];
			jumps |= jump[k] != 0;
		}
		spinJump[0]                     = -0.5 * (jump[5] - jump[7]);
		spinJump[1]                     = -0.5 * (jump[6] - jump[2]);
		spinJump[2]                     = -0.5 * (jump[1] - jump[3]);
		const double* gradient          = view->prevVelGrad;
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

template <> PackedKernel<3> stepKernel<3>(bool bonded, bool)
{
	if (bonded) return { contacts<true>, integrate, "portable" };
	return { contacts<false>, integrate, "portable" };
}

} // namespace talik
