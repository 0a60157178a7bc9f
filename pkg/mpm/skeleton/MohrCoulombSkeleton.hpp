// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/ParameterList.hpp>
#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/mpm/skeleton/MohrCoulombReturn.hpp>
#include <pkg/mpm/skeleton/PrincipalStresses.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>

#include <vector>

/// Parameters of MohrCoulombSkeleton, for the model and for the class that a script sees.
// clang-format off
#define TALIK_MOHR_COULOMB_SKELETON \
	((Real, young, 10e6,,"Thawed Young's modulus [Pa], > 0.")) \
	((Real, youngFrozen, 100e6,,"Young's modulus at full ice saturation [Pa], >= young.")) \
	((Real, poisson, 0.3,,"Poisson's ratio [-], in (-1, 0.5).")) \
	((Real, cohesion, 1e3,,"Thawed cohesion [Pa], >= 0.")) \
	((Real, cohesionFrozen, 500e3,,"Cohesion at full ice saturation [Pa], >= 0.")) \
	((Real, frictionAngle, 30,,"[deg], 0 to below 90 (FrictMat of YADE has radians).")) \
	((Real, dilationAngle, 0,,"[deg], 0 to frictionAngle.")) \
	((Real, tensileStrength, 0,,"Thawed tensile strength [Pa], >= 0.")) \
	((Real, tensileStrengthFrozen, 200e3,,"Tensile strength at full ice saturation [Pa], >= 0.")) \
	((Real, exponent, 2,,"m of phi [-], >= 1.")) \
	((vector<Real>, iceSaturations, ,,"Ice saturations of the tables, ascending in 0..1 [-]; empty: values follow phi.")) \
	((vector<Real>, youngs, ,,"Young's modulus at each of iceSaturations [Pa], > 0.")) \
	((vector<Real>, cohesions, ,,"Cohesion at each of iceSaturations [Pa], >= 0.")) \
	((vector<Real>, tensileStrengths, ,,"Tensile strength at each of iceSaturations [Pa], >= 0."))
// clang-format on

namespace talik {

/// Elastic, perfectly plastic ground after Mohr and Coulomb with a tension cut-off, whose stiffness, cohesion and tensile
/// strength follow the ice saturation: X(S_i) = X_thawed + (X_frozen - X_thawed) phi(S_i), phi = 1 - (1 - S_i^m)^m
/// (the ice function of Yu & Zhao, eqs. 5 to 7, used here at the scale of the ground).
/// A table, e.g. measured on samples, takes the place of the function where it is given.
/// Trial stress by the Jaumann rate, then return to the yield surface in principal stresses (planes, edges, apex, cut-off).
///
/// In ground that freezes the stress has two parts in parallel, as a bonded contact has: that of the grains, with the thawed
/// modulus, and that of the ice, with E(S_i) less it. New ice is free of stress; ice that melts takes its share of the ice's
/// stress with it: sigma_ice *= E_ice(new)/E_ice(old). Strength limits the sum, as it limits the force of a bond as a whole; what
/// exceeds it is taken off both parts by their stiffnesses. Where ground opens the volume of the opening is kept, and the grains
/// are pressed again only when it has closed. Given initial stress is that of the grains.
template <int D> class MohrCoulombSkeleton final : public SkeletonModel<D> {
public:
	TALIK_PARAMETERS(TALIK_MOHR_COULOMB_SKELETON)

	std::string                  name() const override { return "MohrCoulombSkeleton"; }
	std::optional<ShearStrength> shearStrength(double iceSaturation) const override;
	bool                         knowsHoopStrain() const override { return true; }
	void                         validate() const override;
	void                         declareFields(PointFields&, const std::string& prefix) override;
	void                         initialise(const SkeletonBatch<D>&) override;
	void                         updateStress(const SkeletonBatch<D>&) override;
	void                         tangentModulus(const SkeletonBatch<D>&, double* modulus) const override;

private:
	struct AtSaturation {
		double young, cohesion, tensileStrength;
	};
	AtSaturation         at(double saturation) const;
	MohrCoulombState     cone() const;
	void                 validateTable() const;
	static constexpr int pieceSize = 256;
	/// Of points in sequence.
	struct Piece {
		double young[pieceSize], cohesion[pieceSize], tensileStrength[pieceSize];
	};
	void                          lookUp(const double* saturation, int count, Piece& piece) const;
	TALIK_PROCESSOR_VERSIONS void interpolate(const double* saturation, int count, Piece& piece) const;
	/// The two parts of points in sequence, and what each may bear.
	struct Parts {
		double grainLambda[pieceSize], grainShear[pieceSize], iceLambda[pieceSize], iceShear[pieceSize];
		double hidden[pieceSize];  ///< stress that the opening stands for [Pa]
		double keptIce[pieceSize]; ///< share of the ice's stress that melting leaves [-]
	};
	TALIK_PROCESSOR_VERSIONS static void splitModulus(
	        double thawedModulus, const double* opening, double* iceModulus, int count, const Piece& piece, double poisson, Parts& parts);
	/// count points in sequence from place first on
	void updateRun(const SkeletonBatch<D>&, int first, int count);
	void updateFreezingRun(const SkeletonBatch<D>&, int first, int count);
	void limitSum(int first, int count, const Piece& piece, const Parts& parts, const std::array<double*, stressSize<D>>& stress) const;

	/// By place; null without a ground, all but the first one also without tables of ice.
	double *                           plasticStrain_ = nullptr, *iceModulus_ = nullptr, *opening_ = nullptr;
	std::array<double*, stressSize<D>> iceStress_ {};
};

} // namespace talik
