// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>

namespace talik {

template <int D> class PoreWater;
struct SeepageScales;

/// What fills the ground: grains, water and ice as masses, and the state that follows from them, the volume and the enthalpy:
/// porosity, temperature, ice saturation, pore pressure, heat capacity, conductivity and drag.
template <int D> class PoreContent {
public:
	PoreContent(PointFields& fields, const GroundSettings<D>& settings);
	/// What an update reads and writes of the points of other effects, by place; null: the scene has no such effect.
	struct OfHeat {
		double* enthalpy; ///< [J]; only read by an update, written by fill()
		double* temperature;
		double* heatCapacity;
		double* capacityWeight; ///< between the sensible capacity and three times that, as dH/dT asks [J/K]
		double* conductivity;
	};
	struct OfSolid {
		double*                mass;     ///< changes where water freezes or melts
		std::array<double*, D> velocity; ///< the same, by the momentum that goes along
		const double*          initialVolume;
	};
	struct OfWater {
		double *               pressure, *liquidFraction, *drag;
		std::array<double*, D> velocity;
	};
	struct PointArrays {
		OfSolid solid;
		OfHeat  heat;
		OfWater water;
		bool    hasSolid() const { return solid.mass != nullptr; }
		bool    hasHeat() const { return heat.temperature != nullptr; }
		bool    hasWater() const { return water.pressure != nullptr; }
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
	void fill(int place, double porosity, double temperature, double pressure, double poreFill, const PointArrays& of);

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
	int findTemperature(Block& b, const PointArrays& of) const;
	/// Porosity, conductivity and drag, after findTemperature().
	void findCoefficients(const Block& b, const PointArrays& of);
	/// Pressure of points that have one of their own, after findCoefficients().
	void findPressure(const Block& b, const PointArrays& of);
	/// What the pressure of a cell follows from, where its points share one, see PoreWater::addFills: unstressed volume of liquid and ice less the pore
	/// volume [m^D], and their compliance [m^D/Pa].
	void findFill(const Block& b, double (&excess)[blockSize], double (&compliance)[blockSize]) const;
	/// All of it, where every point has a pressure of its own. Returns as findTemperature(), or last.
	int update(int first, int last, const PointArrays& of);
	/// Why a point is in an impossible state; temperature [degC] and enthalpy [J] of it are null in ground without heat.
	std::string whyImpossible(int place, const double* temperature, const double* enthalpy) const;

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

	double liquidMass(int place) const { return waterMass[place] - (iceMass ? iceMass[place] : 0.0); } ///< [kg]

	/// Of the liquid, which is the same in every material.
	const EnthalpyModel&     enthalpyModel() const { return materials_.front().enthalpy; }
	const MixtureProperties& mixture(int place) const { return of(place).mixture; }
	/// Seepage follows slow processes that run f times as fast as motion, in each material as far as its conductivity lets it. Returns the scales in
	/// force.
	SeepageScales useScale(double f, const PoreWater<D>& water);
	/// m_l^2/(V Q) of a point as it will be when all of its ice has melted: k rho_l/g [kg s/m^3].
	double thawedOpening(int place) const
	{
		const Material& m = of(place);
		return reached(m.seepageScale * m.permeability.conductivity(porosity[place], 1.0)) * m.mixture.liquid.density / Permeability::gravity;
	}
	/// Drag [kg/s] of a place whose drag was found without f_H.
	double scaledDrag(int place, double drag, double liquidFraction) const
	{
		return std::max(drag / of(place).seepageScale, Permeability::dragAt(liquidMass(place), liquidFraction, largestConductivity_));
	}
	double smallestReferencePorosity() const;

	double *solidMass = nullptr, *waterMass = nullptr, *porosity = nullptr;
	bool    holdsAir      = false;   ///< some pores were not full at the start: what they hold conducts heat
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
	/// Conductivity in force of ground that f_H gives k [m/s], see PoreWater::largestConductivity.
	double                        reached(double k) const { return std::min(k, largestConductivity_); }
	const Material&               of(int place) const { return materials_[points_->material(place)]; }
	void                          choosePoints(Block& b, int last) const;
	void                          load(Block& b, const double* temperature) const;
	TALIK_PROCESSOR_VERSIONS void findPoreVolume(Block& b, const double* volumes) const;
	void                          solveTemperature(Block& b, const OfHeat& heat) const;
	bool                          hasExcessIce(const Block& b) const;
	void                          solveWithExcessIce(Block& b, const OfHeat& heat) const;
	void                          meltExcessIce(Block& b, const OfHeat& heat, int k) const;
	/// Weights that hold dH/dT are kept between the sensible capacity and three times that.
	TALIK_PROCESSOR_VERSIONS void limitWeights(const Block& b, const OfHeat& heat) const;
	void                          correctForExcessIce(const Block& b, const OfHeat& heat, const OfWater& water) const;
	TALIK_PROCESSOR_VERSIONS void exchangePhaseMomentum(const Block& b, const OfSolid& moving, const OfWater& water) const;
	TALIK_PROCESSOR_VERSIONS void computeFill(const Block& b, double (&excess)[blockSize], double (&compliance)[blockSize]) const;
	TALIK_PROCESSOR_VERSIONS void updatePressure(const Block& b, double* pressures) const;
	void                          updatePressureRate(const Block& b, double* pressures);
	TALIK_PROCESSOR_VERSIONS void updatePorosity(const Block& b);
	TALIK_PROCESSOR_VERSIONS void updateConductivity(const Block& b, double* conductivity) const;
	TALIK_PROCESSOR_VERSIONS void updateIce(const Block& b);
	TALIK_PROCESSOR_VERSIONS void updateDrag(const Block& b, const OfWater& water) const;
	TALIK_PROCESSOR_VERSIONS bool allPossible(const Block& b) const;
	int                           firstImpossible(const Block& b) const;

	const GroundSettings<D>* settings_;
	std::vector<Material>    materials_; ///< one where the settings list none
	MaterialPoints<D>*       points_              = nullptr;
	double*                  volume_              = nullptr;
	const double*            excessVolume_        = nullptr; ///< see holdExcessIce; null: there is none
	double*                  excessIce_           = nullptr;
	double                   largestConductivity_ = std::numeric_limits<double>::infinity(); ///< see PoreWater [m/s]; none with explicit pressure
	double*                  lastVolume_          = nullptr;                                 ///< of the last update, in the rate form of pressure only
	double*                  lastWater_           = nullptr;
};

} // namespace talik
