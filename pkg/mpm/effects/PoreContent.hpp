// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/CostMeter.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/thm/ProcessorVersions.hpp>

namespace talik {

template <int D> class CellMeans;
template <int D> class HeatTransfer;
template <int D> class PoreWater;
template <int D> class SolidMotion;

/// What fills the ground: grains, water and ice as masses, and the state that follows from them, the volume and the enthalpy:
/// porosity, temperature, ice saturation, pore pressure, heat capacity, conductivity and drag.
template <int D> class PoreContent {
public:
	PoreContent(PointFields& fields, const GroundSettings<D>& settings);
	/// The effects to whose points it gives mass, temperature and pressure; null: absent from the scene.
	struct Effects {
		SolidMotion<D>*  motion;
		HeatTransfer<D>* heat;
		PoreWater<D>*    water;
	};

	void bind(MaterialPoints<D>& points);

	/// Masses and enthalpy of a point of given porosity, temperature and pressure; its derived state follows from update().
	void fill(int place, double porosity, double temperature, double pressure, double poreFill, const Effects& of);

	/// State of points first .. last after their volume, water mass and enthalpy changed. Returns the place of the first point in
	/// an impossible state (no pore space, no liquid left, enthalpy out of range), or last.
	/// cells null: every point has a pressure of its own; else the cells collect what their pressure follows from, for
	/// PoreWater::shareCellPressure and, in the step dt, PoreWater::levelPoints (call within MaterialPoints::strips().scatter).
	/// sample: of the time that each effect takes.
	int update(int first, int last, const Effects& of, const CellMeans<D>* cells, double dt, CostMeter::Sample& sample);
	int update(int first, int last, const Effects& of);
	/// Why a point is in an impossible state; heat may be null.
	std::string whyImpossible(int place, const HeatTransfer<D>* heat) const;

	/// Of the liquid, which is the same in every material.
	const EnthalpyModel&     enthalpyModel() const { return materials_.front().enthalpy; }
	const MixtureProperties& mixture(int place) const { return of(place).mixture; }
	/// Seepage follows slow processes that run f times as fast as motion, in each material as far as its conductivity lets it.
	void useScale(PoreWater<D>& water, double f);
	/// f_H in force at a point [-].
	double seepageScale(int place) const { return of(place).seepageScale; }
	double smallestReferencePorosity() const;

	double *solidMass, *waterMass, *porosity;
	double* iceMass       = nullptr; ///< nullptr without freezing
	double* iceSaturation = nullptr;

private:
	/// What one material has of its own, for loops over points of it.
	struct Material {
		MixtureProperties mixture;
		EnthalpyModel     enthalpy;
		Permeability      permeability;
		double            seepageScale = 1.0; ///< f_H in this step [-]
	};
	const Material& of(int place) const { return materials_[points_->material(place)]; }
	struct Block;
	void                          choosePoints(Block& b, int last) const;
	void                          load(Block& b, const HeatTransfer<D>* heat) const;
	TALIK_PROCESSOR_VERSIONS void findPoreVolume(Block& b) const;
	void                          solveTemperature(Block& b, HeatTransfer<D>& heat) const;
	TALIK_PROCESSOR_VERSIONS void exchangePhaseMomentum(const Block& b, SolidMotion<D>& motion, PoreWater<D>& water) const;
	TALIK_PROCESSOR_VERSIONS void updatePressure(const Block& b, PoreWater<D>& water) const;
	void                          collectPressure(const Block& b, const CellMeans<D>& cells, PoreWater<D>& water, double dt) const;
	TALIK_PROCESSOR_VERSIONS void findFill(const Block& b, double (&excess)[blockSize], double (&compliance)[blockSize]) const;
	void                          updatePressureRate(const Block& b, PoreWater<D>& water);
	void                          updateCoefficients(const Block& b, HeatTransfer<D>* heat, PoreWater<D>* water);
	TALIK_PROCESSOR_VERSIONS void updatePorosity(const Block& b);
	TALIK_PROCESSOR_VERSIONS void updateConductivity(const Block& b, HeatTransfer<D>& heat) const;
	TALIK_PROCESSOR_VERSIONS void updateIce(const Block& b);
	TALIK_PROCESSOR_VERSIONS void updateDrag(const Block& b, PoreWater<D>& water) const;
	TALIK_PROCESSOR_VERSIONS bool allPossible(const Block& b) const;
	int                           firstImpossible(const Block& b) const;

	const GroundSettings<D>* settings_;
	std::vector<Material>    materials_; ///< one where the settings list none
	MaterialPoints<D>*       points_ = nullptr;
	PointFields::Handle      solidMass_, waterMass_, porosity_, iceMass_ = -1, iceSaturation_ = -1, lastVolumeField_ = -1, lastWaterField_ = -1;
	double*                  volume_     = nullptr;
	double*                  lastVolume_ = nullptr; ///< of the last update, in the rate form of pressure only
	double*                  lastWater_  = nullptr;
};

extern template class PoreContent<2>;
extern template class PoreContent<3>;

} // namespace talik
