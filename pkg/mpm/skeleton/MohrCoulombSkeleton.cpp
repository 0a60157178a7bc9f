// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/base/ThreadPool.hpp>
#include <pkg/mpm/points/ObjectiveUpdate.hpp>
#include <pkg/mpm/skeleton/MohrCoulombSkeleton.hpp>

#include <algorithm>

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

	/// Returns the plastic strain of the correction.
	template <int D> double correct(const MohrCoulombState& m, PrincipalStresses<D>& stress)
	{
		double plastic = 0.0;
		stress.apply([&](double* p) {
			const double before[3] = { p[0], p[1], p[2] };
			if (!returnToMohrCoulomb(m, p)) return false;
			plastic = equivalentStrain(before, p, m.shear);
			return true;
		});
		return plastic;
	}

	/// Takes tension above the limit off principal stresses; returns the sum of what was taken [Pa].
	template <int D> double cut(double limit, PrincipalStresses<D>& stress)
	{
		double taken = 0.0;
		stress.apply([&](double* p) {
			for (int i = 0; i < 3; ++i)
				if (p[i] > limit) {
					taken += p[i] - limit;
					p[i] = limit;
				}
			return taken > 0.0;
		});
		return taken;
	}

	/// Marks the points in sequence that cannot keep their trial stress: some principal stress passes tensileStrength, or some pair of
	/// them the cone of Mohr and Coulomb. Stresses that are not numbers count as yielding. In space points next to yielding are marked too.
	TALIK_PROCESSOR_VERSIONS void findYielding(
	        const MohrCoulombState& m, const double* cohesion, const double* tensileStrength, const std::array<double*, 4>& stress, int count,
	        long long* yielding)
	{
		const double* const xx   = stress[0];
		const double* const yy   = stress[1];
		const double* const zz   = stress[2];
		const double* const xy   = stress[3];
		const double        sine = m.sinFriction, twoCosine = 2.0 * m.cosFriction;
#pragma GCC ivdep
		for (int k = 0; k < count; ++k) {
			const double centre = 0.5 * (xx[k] + yy[k]), half = 0.5 * (xx[k] - yy[k]);
			const double radius = __builtin_sqrt(half * half + xy[k] * xy[k]), most = centre + radius, least = centre - radius;
			const double high = most > zz[k] ? most : zz[k], low = least < zz[k] ? least : zz[k];
			const double cone = (high - low) + (high + low) * sine - cohesion[k] * twoCosine, cut = high - tensileStrength[k];
			yielding[k] = (cone > cut ? cone : cut) <= 0.0 ? 0 : 1;
		}
	}
	/// Eq. (23.3): the cone through the inner edges of that of Mohr and Coulomb. No principal stress passes the tensile strength t where t 1 - sigma
	/// has no negative principal minor.
	TALIK_PROCESSOR_VERSIONS void findYielding(
	        const MohrCoulombState& m, const double* cohesion, const double* tensileStrength, const std::array<double*, 6>& stress, int count,
	        long long* yielding)
	{
		const double* const xx   = stress[0];
		const double* const yy   = stress[1];
		const double* const zz   = stress[2];
		const double* const yz   = stress[3];
		const double* const xz   = stress[4];
		const double* const xy   = stress[5];
		const double        sine = m.sinFriction, cosine = m.cosFriction, edge = std::sqrt(1.0 + sine * sine / 3.0);
#pragma GCC ivdep
		for (int k = 0; k < count; ++k) {
			const double mean = (xx[k] + yy[k] + zz[k]) * (1.0 / 3.0), dx = xx[k] - mean, dy = yy[k] - mean, dz = zz[k] - mean;
			const double yz2 = yz[k] * yz[k], xz2 = xz[k] * xz[k], xy2 = xy[k] * xy[k], j2 = 0.5 * (dx * dx + dy * dy + dz * dz) + yz2 + xz2 + xy2;
			const double cone = edge * __builtin_sqrt(j2) + sine * mean - cohesion[k] * cosine;
			const double x = tensileStrength[k] - xx[k], y = tensileStrength[k] - yy[k], z = tensileStrength[k] - zz[k];
			const double ofYz = y * z - yz2, ofXz = x * z - xz2, ofXy = x * y - xy2;
			const double all   = x * ofYz - xy2 * z - xz2 * y - 2.0 * yz[k] * xz[k] * xy[k];
			const double sides = std::min(std::min(x, y), z), faces = std::min(std::min(ofYz, ofXz), ofXy);
			yielding[k] = (cone <= 0.0) & (sides >= 0.0) & (faces >= 0.0) & (all >= 0.0) ? 0 : 1;
		}
	}

	/// phi(S_i) = 1 - (1 - S_i^m)^m of eq. (23.2)
	double squareIceFunction(double saturation)
	{
		const double s = std::min(std::max(saturation, 0.0), 1.0);
		return s * s * (2.0 - s * s);
	}
	double iceFunction(double saturation, double exponent)
	{
		if (exponent == 2.0) return squareIceFunction(saturation);
		const double s = std::min(std::max(saturation, 0.0), 1.0);
		return 1.0 - std::pow(1.0 - std::pow(s, exponent), exponent);
	}

	/// Leaves the stress of the grains in stress, and in ice what melting leaves of the ice's.
	TALIK_PROCESSOR_VERSIONS void takeIceOff(int count, const double* kept, double* stress, double* ice)
	{
#pragma GCC ivdep
		for (int k = 0; k < count; ++k) {
			stress[k] -= ice[k];
			ice[k] *= kept[k];
		}
	}

	TALIK_PROCESSOR_VERSIONS void addPart(int count, const double* what, double* stress)
	{
#pragma GCC ivdep
		for (int k = 0; k < count; ++k)
			stress[k] += what[k];
	}

	/// No tension passes the apex of the cone.
	TALIK_PROCESSOR_VERSIONS void limitTension(double sineOfFriction, double cosineOfFriction, int count, const double* cohesion, double* tensileStrength)
	{
		if (!(sineOfFriction > 0.0)) return;
		const double cotangent = cosineOfFriction / sineOfFriction;
		for (int k = 0; k < count; ++k)
			tensileStrength[k] = std::min(tensileStrength[k], cohesion[k] * cotangent);
	}

	/// Volume by which grains part when a trial stress returns to strength, over their volume: what tension alone took from the mean stress, without
	/// the share of dilation.
	template <int D> double openedBy(const MohrCoulombState& m, const PrincipalStresses<D>& trial, const PrincipalStresses<D>& returned)
	{
		PrincipalStresses<D> undilated = returned;
		if (m.sinDilation > 0.0) {
			MohrCoulombState sheared = m;
			sheared.sinDilation      = 0.0;
			undilated                = trial;
			correct(sheared, undilated);
		}
		double taken = 0.0;
		for (int i = 0; i < 3; ++i)
			taken += trial.normal(i) - undilated.normal(i);
		return std::max(0.0, taken) / (3.0 * m.lambda + 2.0 * m.shear);
	}

} // namespace

template <int D> void MohrCoulombSkeleton<D>::validate() const
{
	const auto name = [](const char* attribute) { return std::string("MohrCoulombSkeleton.") + attribute; };
	requireSetting(std::isfinite(young) && young > 0.0, name("young"), young, "must be positive, in Pa");
	requireSetting(std::isfinite(youngFrozen) && youngFrozen >= young, name("youngFrozen"), youngFrozen, "must not be below young, in Pa");
	requireSetting(poisson > -1.0 && poisson < 0.5, name("poisson"), poisson, "must lie in (-1, 0.5)");
	requireSetting(std::isfinite(cohesion) && cohesion >= 0.0, name("cohesion"), cohesion, "must not be negative, in Pa");
	requireSetting(std::isfinite(cohesionFrozen) && cohesionFrozen >= 0.0, name("cohesionFrozen"), cohesionFrozen, "must not be negative, in Pa");
	requireSetting(frictionAngle >= 0.0 && frictionAngle < 90.0, name("frictionAngle"), frictionAngle, "must lie in [0, 90) degrees");
	requireSetting(dilationAngle >= 0.0 && dilationAngle <= frictionAngle, name("dilationAngle"), dilationAngle, "must lie in [0, frictionAngle] degrees");
	requireSetting(std::isfinite(tensileStrength) && tensileStrength >= 0.0, name("tensileStrength"), tensileStrength, "must not be negative, in Pa");
	requireSetting(
	        std::isfinite(tensileStrengthFrozen) && tensileStrengthFrozen >= 0.0, name("tensileStrengthFrozen"), tensileStrengthFrozen,
	        "must not be negative, in Pa");
	requireSetting(std::isfinite(exponent) && exponent >= 1.0, name("exponent"), exponent, "must be 1 or more");
	validateTable();
}

template <int D> void MohrCoulombSkeleton<D>::validateTable() const
{
	const auto require = [](const char* column, const std::vector<double>& values, std::size_t wanted, bool zeroAllowed) {
		const std::string name = std::string("MohrCoulombSkeleton.") + column;
		requireSetting(values.size() == wanted, name + " length", double(values.size()), "must be that of the ice saturations");
		for (const double value : values)
			requireSetting(
			        std::isfinite(value) && (zeroAllowed ? value >= 0.0 : value > 0.0), name, value,
			        zeroAllowed ? "must not be negative" : "must be positive");
	};
	const auto& s = iceSaturations;
	require("youngs", youngs, s.size(), false);
	require("cohesions", cohesions, s.size(), true);
	require("tensileStrengths", tensileStrengths, s.size(), true);
	for (std::size_t k = 0; k < s.size(); ++k)
		requireSetting(
		        s[k] >= 0.0 && s[k] <= 1.0 && (k == 0 || s[k] > s[k - 1]), "MohrCoulombSkeleton.iceSaturations", s[k],
		        "must lie in 0 to 1 and above the one before it");
}

template <int D> typename MohrCoulombSkeleton<D>::AtSaturation MohrCoulombSkeleton<D>::at(double saturation) const
{
	const auto& s = iceSaturations;
	if (s.empty()) {
		const double phi = iceFunction(saturation, exponent);
		return { young + (youngFrozen - young) * phi, cohesion + (cohesionFrozen - cohesion) * phi,
			 tensileStrength + (tensileStrengthFrozen - tensileStrength) * phi };
	}
	const std::size_t above = std::upper_bound(s.begin(), s.end(), saturation) - s.begin();
	const std::size_t j = std::min(above, s.size() - 1), i = above == 0 ? 0 : above - 1;
	const double      part  = i == j ? 0.0 : (saturation - s[i]) / (s[j] - s[i]);
	const auto        value = [&](const std::vector<double>& column) { return column[i] + part * (column[j] - column[i]); };
	return { value(youngs), value(cohesions), value(tensileStrengths) };
}

template <int D> void MohrCoulombSkeleton<D>::declareFields(PointFields& fields, const std::string& prefix)
{
	fields.declare(prefix + "plasticStrain", "MohrCoulombSkeleton", "-", plasticStrain_);
	if (!fields.has("iceSaturation")) return;
	fields.declare(prefix + "iceStress", "MohrCoulombSkeleton", "Pa", iceStress_);
	fields.declare(prefix + "iceModulus", "MohrCoulombSkeleton", "Pa", iceModulus_);
	fields.declare(prefix + "opening", "MohrCoulombSkeleton", "-", opening_);
}

template <int D> void MohrCoulombSkeleton<D>::initialise(const SkeletonBatch<D>& b)
{
	if (!iceModulus_) return;
	const double thawed = at(0.0).young;
	for (int k = 0; k < b.count; ++k)
		iceModulus_[b.place[k]] = std::max(0.0, at(b.iceSaturation[b.place[k]]).young - thawed);
}

/// Davis 1968: tan(phi) with psi = phi, sin(phi) without dilation, and the same share of the cohesion.
template <int D> std::optional<ShearStrength> MohrCoulombSkeleton<D>::shearStrength(double iceSaturation) const
{
	const double sine = std::sin(frictionAngle * degree), dilation = dilationAngle * degree;
	const double share = std::cos(dilation) / (1.0 - sine * std::sin(dilation));
	return ShearStrength { sine * share, at(iceSaturation).cohesion * std::cos(frictionAngle * degree) * share };
}

template <int D> void MohrCoulombSkeleton<D>::updateStress(const SkeletonBatch<D>& b)
{
	const int pieces = (b.count + pieceSize - 1) / pieceSize;
	ThreadPool::run(pieces, b.count >= 4000 ? ThreadPool::threads() : 1, [&](int i, int) {
		const int end = std::min(b.count, (i + 1) * pieceSize);
		for (int k = i * pieceSize; k < end;) {
			// places that follow each other are worked on in one go
			const int first = k;
			while (k < end && b.place[k] == b.place[first] + (k - first))
				++k;
			if (iceModulus_) updateFreezingRun(b, b.place[first], k - first);
			else updateRun(b, b.place[first], k - first);
		}
	});
}

/// Its angles; the strength is that of each point.
template <int D> MohrCoulombState MohrCoulombSkeleton<D>::cone() const
{
	MohrCoulombState m;
	m.sinFriction = std::sin(frictionAngle * degree);
	m.cosFriction = std::cos(frictionAngle * degree);
	m.sinDilation = std::sin(dilationAngle * degree);
	return m;
}

template <int D> void MohrCoulombSkeleton<D>::lookUp(const double* saturation, int count, Piece& piece) const
{
	if (saturation && iceSaturations.empty() && exponent == 2.0) return interpolate(saturation, count, piece);
	AtSaturation present = at(0.0);
	for (int k = 0; k < count; ++k) {
		if (saturation) present = at(saturation[k]);
		piece.young[k]           = present.young;
		piece.cohesion[k]        = present.cohesion;
		piece.tensileStrength[k] = present.tensileStrength;
	}
}

/// The usual exponent, without a power function per point.
template <int D> void MohrCoulombSkeleton<D>::interpolate(const double* saturation, int count, Piece& piece) const
{
	const double stiffness = young, moreStiffness = youngFrozen - young;
	const double strength = cohesion, moreStrength = cohesionFrozen - cohesion;
	const double tension = tensileStrength, moreTension = tensileStrengthFrozen - tensileStrength;
#pragma GCC ivdep
	for (int k = 0; k < count; ++k) {
		const double phi         = squareIceFunction(saturation[k]);
		piece.young[k]           = stiffness + moreStiffness * phi;
		piece.cohesion[k]        = strength + moreStrength * phi;
		piece.tensileStrength[k] = tension + moreTension * phi;
	}
}

template <int D> void MohrCoulombSkeleton<D>::updateRun(const SkeletonBatch<D>& b, int first, int count)
{
	double*          plasticStrain = plasticStrain_;
	const LameModuli unit(1.0, poisson);
	MohrCoulombState m = cone();
	Piece            piece;
	double           lambda[pieceSize], shear[pieceSize];
	lookUp(b.iceSaturation ? b.iceSaturation + first : nullptr, count, piece);
	limitTension(m.sinFriction, m.cosFriction, count, piece.cohesion, piece.tensileStrength);
	for (int k = 0; k < count; ++k) {
		lambda[k] = piece.young[k] * unit.lambda;
		shear[k]  = piece.young[k] * unit.shear;
	}
	const std::array<double*, stressSize<D>> stress = from(b.stress, first);
	updateElastic<D>(count, lambda, shear, from(b.gradient, first), stress, b.hoopFrom(first));

	long long yielding[pieceSize];
	findYielding(m, piece.cohesion, piece.tensileStrength, stress, count, yielding);
	overMarked(yielding, count, stress, [&](int k, PrincipalStresses<D>& s) {
		m.lambda             = lambda[k];
		m.shear              = shear[k];
		m.cohesion           = piece.cohesion[k];
		m.tensileStrength    = piece.tensileStrength[k];
		const double plastic = correct(m, s);
		if (plasticStrain) plasticStrain[first + k] += plastic;
	});
}

template <int D>
void MohrCoulombSkeleton<D>::splitModulus(
        double thawedModulus, const double* opening, double* iceModulus, int count, const Piece& piece, double poisson, Parts& parts)
{
	const LameModuli unit(1.0, poisson);
#pragma GCC ivdep
	for (int k = 0; k < count; ++k) {
		const double whole = piece.young[k], grains = std::min(whole, thawedModulus), ice = whole - grains;
		parts.keptIce[k]     = ice < iceModulus[k] ? ice / iceModulus[k] : 1.0;
		parts.grainLambda[k] = grains * unit.lambda;
		parts.grainShear[k]  = grains * unit.shear;
		parts.iceLambda[k]   = ice * unit.lambda;
		parts.iceShear[k]    = ice * unit.shear;
		parts.hidden[k]      = (parts.grainLambda[k] + 2.0 / 3.0 * parts.grainShear[k]) * opening[k];
		iceModulus[k]        = ice;
	}
}

template <int D> void MohrCoulombSkeleton<D>::updateFreezingRun(const SkeletonBatch<D>& b, int first, int count)
{
	Piece piece;
	Parts parts;
	lookUp(b.iceSaturation + first, count, piece);
	const MohrCoulombState m = cone();
	limitTension(m.sinFriction, m.cosFriction, count, piece.cohesion, piece.tensileStrength);
	splitModulus(at(0.0).young, opening_ + first, iceModulus_ + first, count, piece, poisson, parts);
	std::array<double*, stressSize<D>> stress, ice;
	for (int c = 0; c < stressSize<D>; ++c) {
		stress[c] = b.stress[c] + first;
		ice[c]    = iceStress_[c] + first;
		takeIceOff(count, parts.keptIce, stress[c], ice[c]);
		if (c < 3) addPart(count, parts.hidden, stress[c]);
	}
	updateElastic<D>(count, parts.grainLambda, parts.grainShear, from(b.gradient, first), stress, b.hoopFrom(first));
	updateElastic<D>(count, parts.iceLambda, parts.iceShear, from(b.gradient, first), ice, b.hoopFrom(first));
	for (int c = 0; c < stressSize<D>; ++c)
		addPart(count, ice[c], stress[c]);
	std::fill_n(opening_ + first, count, 0.0); // limitSum() finds it anew
	limitSum(first, count, piece, parts, stress);
}

/// Grains and ice flow together: what their sum exceeds its strength by is taken off both by their stiffnesses.
template <int D>
void MohrCoulombSkeleton<D>::limitSum(int first, int count, const Piece& piece, const Parts& parts, const std::array<double*, stressSize<D>>& stress) const
{
	double* const    plasticStrain = plasticStrain_ + first;
	double* const    opening       = opening_ + first;
	MohrCoulombState m             = cone();
	long long        yielding[pieceSize];
	findYielding(m, piece.cohesion, piece.tensileStrength, stress, count, yielding);
	overMarked(yielding, count, stress, [&](int k, PrincipalStresses<D>& s) {
		m.lambda                          = parts.grainLambda[k] + parts.iceLambda[k];
		m.shear                           = parts.grainShear[k] + parts.iceShear[k];
		m.cohesion                        = piece.cohesion[k];
		m.tensileStrength                 = piece.tensileStrength[k];
		const bool                 hasIce = m.shear > parts.grainShear[k];
		const PrincipalStresses<D> before = s;
		const double               taken  = hasIce ? cut(m.tensileStrength, s) : 0.0;
		plasticStrain[k] += correct(m, s);
		if (!hasIce) {
			opening[k] = openedBy(m, before, s);
			return;
		}
		opening[k] += taken / (3.0 * m.lambda + 2.0 * m.shear);
		const double share = parts.iceShear[k] / m.shear;
		for (int c = 0; c < stressSize<D>; ++c)
			iceStress_[c][first + k] += share * (s.component(c) - before.component(c));
	});
}

template <int D> void MohrCoulombSkeleton<D>::tangentModulus(const SkeletonBatch<D>& b, double* modulus) const
{
	const double unit = LameModuli(1.0, poisson).oedometer();
	for (int k = 0; k < b.count; ++k)
		modulus[b.place[k]] = unit * at(b.iceSaturation ? b.iceSaturation[b.place[k]] : 0.0).young;
}

TALIK_IN_PLANE_AND_SPACE(MohrCoulombSkeleton);

} // namespace talik
