// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Scene.hpp>
#include <pkg/rve/open/ScenePacking.hpp>
#include <pkg/rve/packed/PackedSample.hpp>

namespace yade {
class IceBondMat;
}

namespace talik {

/// The sample's part of a matrix in space.
template <int Dim> typename PackedTypes<Dim>::Matrix partOf(const Eigen::Matrix3d& m) { return m.template topLeftCorner<Dim, Dim>(); }

/// One of the sample's in space, zero out of its plane.
template <int Dim> Eigen::Matrix3d inSpace(const typename PackedTypes<Dim>::Matrix& m)
{
	Eigen::Matrix3d all                    = Eigen::Matrix3d::Zero();
	all.template topLeftCorner<Dim, Dim>() = m;
	return all;
}

/// Measures of an open sample; bondsBroken since it was made: formed = intact + broken + melted.
struct OpenStatistics : PackedStatistics<3> {
	std::uint64_t bondsFormed = 0, bondsMelted = 0;
};

/// Love-Weber stress of the forces of a scene as it stands, between centres of rigid bodies, tension positive, not symmetrised [Pa].
Eigen::Matrix3d stressOf(const yade::Scene& scene, double volume);

/// Upper bound of a sample's oedometric modulus at any ice saturation, also when it has lost its contacts.
struct StiffnessBound {
	bool         hasIce = false;
	IceBondModel ice;
	double       young   = 0;                         ///< largest contact modulus without ice [Pa]
	double       scale   = 1;                         ///< modulus of a packing over the contact modulus of its grains [-]
	double       network = 0;                         ///< tangent of the contacts when it was measured, over the contact modulus then [-]
	double       modulus(double iceSaturation) const; ///< [Pa]
};

/// Why a scene cannot be a sample at all (no periodic cell, engines that may not run in it); empty if it can.
std::string reasonAgainstSample(const yade::Scene& scene);

/// One periodic sample in the open form: an ordinary Scene, advanced by its own YADE engines, whatever its grains and laws. Follows
/// the same protocol as PackedSample. Where grains are of IceBondMat they take the ice saturation, elsewhere ice has no effect.
/// Made and recovered by one thread at a time; apply() may run in parallel for different samples.
class OpenSample {
public:
	/// A scene of its own from bytes (sceneToBytes). Throws std::invalid_argument when it cannot be a sample.
	explicit OpenSample(const std::string& sceneBytes);

	/// F_new = (1 + displacementGradient) F_old, and ice saturation to its target, in this order: ice at zero velocity gradient, then
	/// motion, then relaxation, then a flip of the cell where due. Throws std::invalid_argument on an increment no sample could
	/// follow. A sample that blew up has to recover() before it is asked again; the stress is that before the update.
	PackedUpdateResult<3> apply(const Eigen::Matrix3d& displacementGradient, double targetIceSaturation, const PackedUpdateOptions& options = {});

	/// Keeps the present state to recover() from, if the last one kept is `steps` DEM steps old. Costs as much as some ten steps.
	void keepState(long steps = 2000);
	/// After a blow-up: back to the state kept last.
	void recover();

	/// Flips the cell to its shortest equivalent vectors if a skew exceeds `skew`; physics unchanged. True if it flipped.
	bool flip(double skew = 0.5);
	/// Distance of a body from its next image over the mean diameter of spheres [-].
	double thickness() const;
	/// Bonds every pair of ice-bearing grains without bond whose gap is within bondRange, stress-free, in the next step. Returns their number.
	std::size_t bondAll();

	/// Symmetrised Love-Weber stress of the forces now, between centres of rigid bodies; exactly zero without contacts [Pa].
	Eigen::Matrix3d  stress() const;
	PackedTangent<3> tangent() const;
	OpenStatistics   statistics() const;
	Eigen::Matrix3d  deformation() const { return scene->cell->trsf; }
	/// Whether its grains are discs, held in the plane, and not spheres.
	bool           planar() const { return discs; }
	bool           hasIce() const { return !iceMaterials.empty(); }
	double         iceSaturation() const; ///< 0 without IceBondMat
	StiffnessBound stiffnessBound() const;

	const boost::shared_ptr<yade::Scene>& yadeScene() const { return scene; }

	std::size_t bytesKept() const { return kept.size(); }
	/// Counters beside the scene, for archives: bonds formed, bonds melted.
	std::array<std::uint64_t, 2> bondCounts() const { return { formed, melted }; }
	void                         setBondCounts(const std::array<std::uint64_t, 2>& counts);

private:
	void adopt(boost::shared_ptr<yade::Scene>);
	void measureGrains();
	/// Volume that stress is a mean over: of discs area times thickness [m^3].
	double stressVolume() const;

	class ChangedIce;
	friend class SampleUpdate<OpenSample>;
	using Matrix                          = Eigen::Matrix3d;
	static constexpr long leastStepsOfIce = 1; ///< contacts take ice saturation up in a step
	double                timeStep() const { return scene->dt; }
	double                longestTimeStep(double iceStiffness) const { return talik::longestTimeStep(*scene, iceStiffness); }
	void                  setTimeStep(double seconds) { scene->dt = seconds; }
	Matrix                velGrad() const { return scene->cell->velGrad; }
	void                  setNextVelGrad(const Matrix&);
	void                  run(long steps);
	const Matrix&         lastStress() const { return meanStress; }
	long                  movingSteps(const Matrix& displacementGradient, const PackedUpdateOptions&) const;
	Matrix                motionPerStep(const Matrix& displacementGradient, long steps) const;
	void                  setIceSaturation(double iceSaturation);
	void                  creep(const BondCreep&);
	/// Calls visit(contact, overlap [m]) for real contacts of two spheres, with the overlap of now.
	template <class Visitor> void visitContacts(Visitor&& visit) const;

	bool        bondPair(yade::Body& first, yade::Body& second);
	void        checkHealth() const;
	std::size_t intactBonds() const;

	boost::shared_ptr<yade::Scene> scene;
	std::vector<yade::IceBondMat*> iceMaterials;
	bool                           discs         = false;
	double                         averageRadius = 0, density = 0;               ///< density of discs: mass over their area and the thickness
	double                         thicknessOverDepth = 1;                       ///< of discs: thickness over depth of the cell [-]
	Eigen::Matrix3d                meanStress         = Eigen::Matrix3d::Zero(); ///< of the last steps that were run, not symmetrised [Pa]
	std::uint64_t                  formed = 0, melted = 0;
	std::string                    kept;
	std::array<std::uint64_t, 2>   keptCounts {};
	long                           keptAt = 0;
};

/// Stepping samples reads the redirection flag of YADE's current scene: it has to be off there as well (stock YADE would crash).
void forbidRedirection();

} // namespace talik
