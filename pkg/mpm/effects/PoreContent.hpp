// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

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
	/// From now on points have ice beside that of their pores, which melts at T_f: of this volume when all of it is frozen [m^D]; mass [kg]: what is
	/// frozen, found with the temperature.
	void holdExcessIce(const double* volume, double* mass)
	{
		excessVolume_ = volume;
		excessIce_    = mass;
	}

	/// Masses and enthalpy of a point of given porosity, temperature and pressure; its derived state follows from update().
	void fill(int place, double porosity, double temperature, double pressure, double poreFill, const Effects& of);

	struct Material;
	/// Some consecutive points of one material with what is known only during an update.
	struct Block {
		int             first, count;
		const Material* of;
		double          temperature[blockSize];
		double          temperatureBefore[blockSize];
		double          poreVolume[blockSize];
		double          liquidSaturation[blockSize];
		double          saturationBefore[blockSize];
		double          iceBefore[blockSize];
		double          ice[blockSize];
		double          capacity[blockSize];

		int end() const { return first + count; }
	};
	/// work(block) for points first .. last in turn, until it returns a place before the end of its block. Returns that place, or last.
	template <class Work> int inBlocks(int first, int last, Work&& work) const
	{
		Block b;
		for (b.first = first; b.first < last; b.first += b.count) {
			choosePoints(b, last);
			if (const int reached = work(b); reached < b.end()) return reached;
		}
		return last;
	}
	/// Temperature and ice after volume, water mass and enthalpy changed. Returns the place of the first point in an impossible state (no pore space,
	/// no liquid left, enthalpy out of range), or the end of the block.
	int findTemperature(Block& b, const Effects& of) const;
	/// Porosity, conductivity, drag and pressure, after findTemperature().
	/// cells null: every point has a pressure of its own; else the cells collect what their pressure follows from, for
	/// PoreWater::shareCellPressure and, in the step dt, PoreWater::levelPoints (call within MaterialPoints::strips().scatter).
	void findCoefficientsAndPressure(const Block& b, const Effects& of, const CellMeans<D>* cells, double dt);
	/// Both, where every point has a pressure of its own. Returns as findTemperature(), or last.
	int update(int first, int last, const Effects& of);
	/// Why a point is in an impossible state; heat may be null.
	std::string whyImpossible(int place, const HeatTransfer<D>* heat) const;

	/// add(place, e, c) for points first .. last: unstressed volume of liquid and ice less the pore volume [m^D], and compliance [m^D/Pa].
	/// temperature null: that of reference.
	template <class Add> void overFills(int first, int last, const double* temperature, Add&& add) const
	{
		for (int p = first; p < last; ++p) {
			const MixtureProperties& m   = mixture(p);
			const double             ice = iceMass ? iceMass[p] : 0.0;
			const PoreFill f = settings_->water->state.fill(m, waterMass[p] - ice, ice, temperature ? temperature[p] : m.referenceTemperature);
			add(p, f.volume - porosity[p] * volume_[p], f.compliance);
		}
	}

	/// Of the liquid, which is the same in every material.
	const EnthalpyModel&     enthalpyModel() const { return materials_.front().enthalpy; }
	const MixtureProperties& mixture(int place) const { return of(place).mixture; }
	/// Seepage follows slow processes that run f times as fast as motion, in each material as far as its conductivity lets it.
	void useScale(PoreWater<D>& water, double f);
	/// m_l^2/(V Q) of a point as it will be when all of its ice has melted: k rho_l/g [kg s/m^3].
	double thawedOpening(int place) const
	{
		const Material& m = of(place);
		return m.seepageScale * m.permeability.conductivity(porosity[place], 1.0) * m.mixture.liquid.density / Permeability::gravity;
	}
	/// f_H in force at a point [-].
	double seepageScale(int place) const { return of(place).seepageScale; }
	double smallestReferencePorosity() const;

	double *solidMass, *waterMass, *porosity;
	double* iceMass       = nullptr; ///< nullptr without freezing
	double* iceSaturation = nullptr;

	/// What one material has of its own, for loops over points of it.
	struct Material {
		MixtureProperties mixture;
		EnthalpyModel     enthalpy;
		Permeability      permeability;
		double            seepageScale = 1.0; ///< f_H in this step [-]
	};

private:
	const Material&               of(int place) const { return materials_[points_->material(place)]; }
	void                          choosePoints(Block& b, int last) const;
	void                          load(Block& b, const HeatTransfer<D>* heat) const;
	TALIK_PROCESSOR_VERSIONS void findPoreVolume(Block& b) const;
	void                          solveTemperature(Block& b, HeatTransfer<D>& heat) const;
	bool                          hasExcessIce(const Block& b) const;
	void                          solveWithExcessIce(Block& b, HeatTransfer<D>& heat) const;
	void                          meltExcessIce(Block& b, HeatTransfer<D>& heat, int k) const;
	void                          correctForExcessIce(const Block& b, HeatTransfer<D>* heat, PoreWater<D>* water) const;
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
	double*                  volume_       = nullptr;
	const double*            excessVolume_ = nullptr; ///< see holdExcessIce; null: there is none
	double*                  excessIce_    = nullptr;
	double*                  lastVolume_   = nullptr; ///< of the last update, in the rate form of pressure only
	double*                  lastWater_    = nullptr;
};

extern template class PoreContent<2>;
extern template class PoreContent<3>;

} // namespace talik
