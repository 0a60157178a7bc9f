// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/Check.hpp>
#include <pkg/mpm/MohrCoulombReturn.hpp>
#include <pkg/mpm/MohrCoulombSkeleton.hpp>
#include <pkg/mpm/ObjectiveUpdate.hpp>

#include <Eigen/Eigenvalues>

namespace talik {

namespace {

	constexpr double degree = 0.017453292519943295;

	/// Plastic part of a stress correction as equivalent deviatoric strain, from principal values.
	double equivalentStrain(const double* before, const double* after, double shear)
	{
		double d[3], mean = 0.0;
		for (int i = 0; i < 3; ++i) {
			d[i] = before[i] - after[i];
			mean += d[i] / 3.0;
		}
		double sum = 0.0;
		for (int i = 0; i < 3; ++i)
			sum += (d[i] - mean) * (d[i] - mean);
		return std::sqrt(2.0 / 3.0 * sum) / (2.0 * shear);
	}

	/// Plane strain: two principal stresses in the plane, the third is zz. Returns the plastic strain of the correction.
	double correct(const MohrCoulombState& m, double (&s)[4])
	{
		const double centre = 0.5 * (s[0] + s[1]), half = 0.5 * (s[0] - s[1]);
		const double radius = std::sqrt(half * half + s[3] * s[3]);
		const double inPlane[3] = { centre + radius, centre - radius, s[2] };
		int          order[3]   = { 0, 1, 2 };
		if (inPlane[2] > inPlane[0]) order[0] = 2, order[1] = 0, order[2] = 1;
		else if (inPlane[2] > inPlane[1])
			order[1] = 2, order[2] = 1;
		const double before[3] = { inPlane[order[0]], inPlane[order[1]], inPlane[order[2]] };
		double       after[3]  = { before[0], before[1], before[2] };
		if (!returnToMohrCoulomb(m, after)) return 0.0;
		double corrected[3];
		for (int i = 0; i < 3; ++i)
			corrected[order[i]] = after[i];
		const double newCentre = 0.5 * (corrected[0] + corrected[1]), newRadius = 0.5 * (corrected[0] - corrected[1]);
		const double cosine = radius > 0.0 ? half / radius : 1.0, sine = radius > 0.0 ? s[3] / radius : 0.0;
		s[0] = newCentre + newRadius * cosine;
		s[1] = newCentre - newRadius * cosine;
		s[2] = corrected[2];
		s[3] = newRadius * sine;
		return equivalentStrain(before, after, m.shear);
	}

	double correct(const MohrCoulombState& m, double (&s)[6])
	{
		Eigen::Matrix3d tensor;
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j)
				tensor(i, j) = s[stressIndex<3>(i, j)];
		const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spectrum(tensor);
		const auto&  values    = spectrum.eigenvalues(); // ascending
		const double before[3] = { values[2], values[1], values[0] };
		double       after[3]  = { before[0], before[1], before[2] };
		if (!returnToMohrCoulomb(m, after)) return 0.0;
		tensor.setZero();
		for (int k = 0; k < 3; ++k) {
			const Eigen::Vector3d n = spectrum.eigenvectors().col(2 - k);
			tensor += after[k] * n * n.transpose();
		}
		for (int i = 0; i < 3; ++i)
			for (int j = i; j < 3; ++j)
				s[stressIndex<3>(i, j)] = tensor(i, j);
		return equivalentStrain(before, after, m.shear);
	}

	/// phi(S_i) = 1 - (1 - S_i^m)^m
	double iceFunction(double saturation, double exponent)
	{
		const double s = std::min(std::max(saturation, 0.0), 1.0);
		if (exponent == 2.0) return s * s * (2.0 - s * s);
		return 1.0 - std::pow(1.0 - std::pow(s, exponent), exponent);
	}

} // namespace

template <int D> void MohrCoulombSkeleton<D>::validate() const
{
	const auto name = [](const char* attribute) { return std::string("MohrCoulombSkeleton.") + attribute; };
	requireSetting(std::isfinite(youngModulus) && youngModulus > 0.0, name("youngModulus"), youngModulus, "must be positive, in Pa");
	requireSetting(
	        std::isfinite(youngModulusFrozen) && youngModulusFrozen >= youngModulus,
	        name("youngModulusFrozen"),
	        youngModulusFrozen,
	        "must not be below youngModulus, in Pa");
	requireSetting(poissonRatio > -1.0 && poissonRatio < 0.5, name("poissonRatio"), poissonRatio, "must lie in (-1, 0.5)");
	requireSetting(std::isfinite(cohesion) && cohesion >= 0.0, name("cohesion"), cohesion, "must not be negative, in Pa");
	requireSetting(std::isfinite(cohesionFrozen) && cohesionFrozen >= 0.0, name("cohesionFrozen"), cohesionFrozen, "must not be negative, in Pa");
	requireSetting(frictionAngle >= 0.0 && frictionAngle < 90.0, name("frictionAngle"), frictionAngle, "must lie in [0, 90) degrees");
	requireSetting(
	        dilationAngle >= 0.0 && dilationAngle <= frictionAngle, name("dilationAngle"), dilationAngle, "must lie in [0, frictionAngle] degrees");
	requireSetting(
	        std::isfinite(tensileStrength) && tensileStrength >= 0.0, name("tensileStrength"), tensileStrength, "must not be negative, in Pa");
	requireSetting(
	        std::isfinite(tensileStrengthFrozen) && tensileStrengthFrozen >= 0.0,
	        name("tensileStrengthFrozen"),
	        tensileStrengthFrozen,
	        "must not be negative, in Pa");
	requireSetting(std::isfinite(iceExponent) && iceExponent >= 1.0, name("iceExponent"), iceExponent, "must be 1 or more");
}

template <int D> void MohrCoulombSkeleton<D>::declareFields(PointFields& fields, const std::string& prefix)
{
	fields_        = &fields;
	plasticStrain_ = fields.declare(prefix + "plasticStrain", "MohrCoulombSkeleton", "-", 1);
}

template <int D> void MohrCoulombSkeleton<D>::updateStress(const SkeletonBatch<D>& b)
{
	double*      plasticStrain = fields_ ? fields_->component(plasticStrain_) : nullptr;
	const double sinFriction = std::sin(frictionAngle * degree), cosFriction = std::cos(frictionAngle * degree);
	const double sinDilation = std::sin(dilationAngle * degree);
	const LameModuli unit(1.0, poissonRatio);
#pragma omp parallel for schedule(static) if (b.count >= 4000)
	for (int k = 0; k < b.count; ++k) {
		const int        p   = b.place[k];
		const double     phi = b.iceSaturation ? iceFunction(b.iceSaturation[p], iceExponent) : 0.0;
		const double     e   = youngModulus + (youngModulusFrozen - youngModulus) * phi;
		MohrCoulombState m;
		m.lambda          = e * unit.lambda;
		m.shear           = e * unit.shear;
		m.cohesion        = cohesion + (cohesionFrozen - cohesion) * phi;
		m.sinFriction     = sinFriction;
		m.cosFriction     = cosFriction;
		m.sinDilation     = sinDilation;
		m.tensileStrength = tensileStrength + (tensileStrengthFrozen - tensileStrength) * phi;
		if (sinFriction > 0.0) m.tensileStrength = std::min(m.tensileStrength, m.cohesion * cosFriction / sinFriction);

		double gradient[D * D], s[stressSize<D>];
		for (int c = 0; c < D * D; ++c)
			gradient[c] = b.gradient[c][p];
		for (int c = 0; c < stressSize<D>; ++c)
			s[c] = b.stress[c][p];
		const MidpointIncrement<D> increment(gradient);
		increment.rotate(s);
		increment.addElastic(s, m.lambda, m.shear);
		const double plastic = correct(m, s);
		for (int c = 0; c < stressSize<D>; ++c)
			b.stress[c][p] = s[c];
		if (plasticStrain) plasticStrain[p] += plastic;
	}
}

template <int D> void MohrCoulombSkeleton<D>::tangentModulus(const SkeletonBatch<D>& b, double* modulus) const
{
	const double unit = LameModuli(1.0, poissonRatio).oedometer();
	for (int k = 0; k < b.count; ++k) {
		const double phi    = b.iceSaturation ? iceFunction(b.iceSaturation[b.place[k]], iceExponent) : 0.0;
		modulus[b.place[k]] = unit * (youngModulus + (youngModulusFrozen - youngModulus) * phi);
	}
}

template class MohrCoulombSkeleton<2>;
template class MohrCoulombSkeleton<3>;

} // namespace talik
