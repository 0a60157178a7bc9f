// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/serialization/Serializable.hpp>
#include <pkg/mpm/GroundSettings.hpp>

namespace yade {

/// Effect: heat conduction with enthalpy on the points, Yu & Zhao eq. (4).
class HeatTransfer : public Serializable {
public:
	talik::HeatSettings build() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(HeatTransfer,Serializable,"Effect of a scene: heat is stored as enthalpy, conducted, and carried by seeping water. Without it "
			"there is no temperature. Example: MpmEngine(gridSpacing=0.5,heat=HeatTransfer(thermalTimeScale=8.64e5,followsMotion=True)).",
		TALIK_HEAT_TRANSFER
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(HeatTransfer);

/// Effect: pore water freezes, liquid saturation follows temperature.
class FreezingCurve : public Serializable {
	talik::FreezingCurvePtr ofTable() const;

public:
	talik::FreezingCurvePtr build() const;
	/// S_r [-]
	Real residual() const;
	/// Refuses a curve that leaves too little liquid for a scene with water; whose: " of material 'silt'", or nothing.
	void requireLiquid(const string& whose) const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(FreezingCurve,Serializable,"Effect of a scene: pore water freezes along the soil freezing characteristic curve S_l(T). Needs "
			"HeatTransfer. Examples: FreezingCurve(curve='gauss',width=0.5,residualSaturation=0.05), "
			"FreezingCurve(curve='table',temperatures=[-5,-1,-0.2,0],liquidSaturations=[0.1,0.2,0.6,1]).",
		((string,curve,"gauss",,"gauss, exponential, power, vanGenuchten, linear, sharp; or table, of measured points."))
		((Real,freezingTemperature,0,,"T_f: at and above it all water is liquid [degC]. A table has its own."))
		((Real,residualSaturation,0.05,,"S_r: liquid saturation that never freezes [-], 0.01 to below 1; without PoreWater also 0. A table has its own."))
		((Real,width,NaN,,"Width of the freezing range [K], > 0: W of gauss and exponential, T_f - T_m of linear, D of power; NaN: the curve's default."))
		((Real,exponent,NaN,,"a of power, lambda of vanGenuchten [-]; NaN: the curve's default."))
		((Real,airEntryPressure,NaN,,"P_0 of vanGenuchten [Pa]; NaN: the curve's default."))
		((vector<Real>,temperatures,,,"Of the measured points of the curve table [degC], ascending: -100 to 50. T_f is that of the first point with saturation 1."))
		((vector<Real>,liquidSaturations,,,"At each of temperatures [-], 0 to 1, never decreasing; the last is 1. Linear in between; the first is S_r, and holds in "
				"colder ground, too."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(FreezingCurve);

/// Effect: two velocities where frozen and thawed ground meet.
class ThawFront : public Serializable {
public:
	// clang-format off
	YADE_CLASS_BASE_DOC(ThawFront,Serializable,"Effect of a scene: where frozen and thawed ground meet, they have separate velocities on the nodes, so that "
			"a thawed layer of any thickness can slide on its frozen base. The friction between them is the strength of the law or the samples of the "
			"thawed points. A point is thawed at and below an ice saturation of 0.02, where the bonds of samples are gone, and frozen again from 0.05 on, "
			"where they form. It acts in scenes with motion, freezing and a skeleton that can fail, with the fields frozenSide (1: frozen) and slip [m]. "
			"MpmEngine.thawFront=None switches it off: a layer thinner than about two cells then moves with its base. Example: "
			"MpmEngine(gridSpacing=0.5,thawFront=ThawFront()).");
	// clang-format on
};
REGISTER_SERIALIZABLE(ThawFront);

/// Effect: pore water moves and carries pressure, Yu & Zhao eqs (2), (3).
class PoreWater : public Serializable {
public:
	talik::WaterSettings build() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(PoreWater,Serializable,"Effect of a scene: pore water with its own velocity, pressure and seepage. Needs motion. The drag "
			"between water and grains is implicit on the nodes, so that permeability does not limit the time step. Example: "
			"PoreWater(conductivity=1e-4,bulkModulus=2.2e7).",
		((Real,conductivity,1e-4,,"Saturated hydraulic conductivity k of thawed ground at referencePorosity [m/s], > 0. Larger values than 12.5 ms * g * "
				"referencePorosity, 0.049 by default, are lowered to that, with a warning; pressure then comes to rest within a fraction of a second. "
				"MpmEngine.calendar['largestConductivity'] has the limit in force."))
		((Real,referencePorosity,0.4,,"Porosity at which conductivity holds [-]. At other porosities it follows Kozeny-Carman."))
		((Real,impedance,6,,"Omega [-], >= 0: ice reduces the conductivity by the factor 10^(-Omega S_i), but no further than by 1e-6."))
		((Real,hydraulicTimeScale,NaN,,"f_H multiplies the conductivity and the inflow of WaterFlux [-], 1e-12 to 1e12. NaN: the scale of the calendar, so that "
				"thaw and consolidation keep their ratio. A number replaces it; 1 leaves seepage in seconds of motion. Seepage is accelerated only up to the conductivity "
				"at which pressure comes to rest within a fraction of a second, see MpmEngine.calendar['largestConductivity']."))
		((string,pressure,"explicit",,"How the pressure follows: explicit, from step to step, so that the stiffness of water limits the step; implicit, for all "
				"cells at once at the end of the step: the step is that of the skeleton, with water as stiff as it is, and pressure does not alternate from cell to cell. "
				"implicit needs bBar. Water has no inertia of its own then: liquidVelocity is the velocity of the ground that it is in, and seepageVelocity what it "
				"flows relative to the grains."))
		((Real,bulkModulus,NaN,,"Bulk modulus of water K_w [Pa], > 0. Real water has 2.2e9. NaN: 2.2e9 with implicit pressure; with explicit pressure 2.2e7, a "
				"hundredth, which allows larger time steps and lowers Skempton's B, see MpmEngine.skemptonB."))
		((Real,iceBulkModulus,NaN,,"Bulk modulus of ice K_i [Pa], > 0; NaN: four times that of water."))
		((Real,cavitationPressure,0,,"p_cav [Pa], <= 0: lowest pressure. A gap opens there, which has to close before the pressure rises again."))
		((bool,zetaActive,true,,"Water expands as it freezes. False: phase change drives no flow (density of ice kept in inertia and heat)."))
		((string,massCoefficient,"exact",,"exact: 1 - zeta S_i; printed: 1 - zeta n_i as in Yu & Zhao eq. (3), for comparison; all pores count as full."))
		((Real,picTime,NaN,,"Time in which the difference between the liquid velocity of a point and that of the grid dies out [s], >= 0, see MpmEngine.picTime; "
				"NaN: sqrt(h/g), but no longer than the 12.5 ms of its inertia where seepage is accelerated."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(PoreWater);

/// Effect: freezing ground draws water and heaves.
class IceSegregation : public Serializable {
public:
	talik::SegregationSettings build() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(IceSegregation,Serializable,"Effect of a scene: frost heave by ice segregation. Freezing ground draws water from the unfrozen "
			"ground to its front, where it freezes as excess ice, parts the ground along the gradient of temperature, and heaves it. The fringe "
			"through which it is "
			"drawn may be thinner than a cell; its intake comes from the segregation potential SP: as measured, or computed from hydraulic "
			"conductivity, freezing curve and load "
			"(Clapeyron's equation). The ice melts at FreezingCurve.freezingTemperature, and the ground settles as with "
			"GroundMaterial.thawStrain. Needs motion, freezing and "
			"water. Suction lowers the pressure of the water below the front no farther than PoreWater.cavitationPressure, 0 by default: give "
			"-5e4 or less where the water "
			"table lies below the front. Adds the fields segregatedVolume [m^3] and segregatedIceMass [kg]; MpmEngine.balance has waterDrawn and "
			"segregationWork. In the "
			"cell at a surface or wall of known temperature intake begins with the first ice. The ice of a computed "
			"intake lies where the lens is, at most three cells behind the first frozen one. Example: "
			"MpmEngine(gridSpacing=0.1,segregation=IceSegregation(segregationPotential=1e-9,pressureDecay=5e-6)).",
		TALIK_ICE_SEGREGATION
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(IceSegregation);

/// Phases of the ground, Yu & Zhao section 3.
class GroundMaterial : public Serializable {
public:
	talik::MixtureProperties build() const;
	/// With what it has of its own and, for the rest, what the scene has (null: nothing). Throws std::invalid_argument.
	talik::SoilMaterial soil(const FreezingCurve* ofScene, const PoreWater* water) const;
	/// True if it has a freezing curve, a conductivity, a thaw strain or a compression of its own.
	bool isOwnSoil() const;
	bool hasOwnSeepage() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(GroundMaterial,Serializable,"Soil grains, ice and liquid water of saturated ground; defaults are those of Yu & Zhao, section 3. "
			"Ice has a specific heat of 2060, water of 4200 J/(kg K). "
			"MpmEngine.materials lists several, with the same densities, specific heats, expansivities and latent heat of ice and liquid. "
			"Example: GroundMaterial(conductivityMean='geometric').",
		((Real,solidDensity,2650,,"Intrinsic density of the soil grains [kg/m^3], > 0."))
		((Real,iceDensity,910,,"Intrinsic density of ice [kg/m^3], > 0."))
		((Real,liquidDensity,1000,,"Intrinsic density of liquid water [kg/m^3], > 0."))
		((Real,solidSpecificHeat,800,,"[J/(kg K)], > 0."))
		((Real,solidConductivity,1.0,,"Thermal conductivity [W/(m K)], > 0."))
		((Real,iceConductivity,2.2,,"Thermal conductivity [W/(m K)], > 0."))
		((Real,liquidConductivity,0.6,,"Thermal conductivity [W/(m K)], > 0."))
		((Real,solidExpansivity,2.4e-5,,"Volumetric thermal expansivity [1/K]."))
		((Real,iceExpansivity,1.6e-4,,"Volumetric thermal expansivity [1/K]."))
		((Real,liquidExpansivity,0,,"Volumetric thermal expansivity [1/K]: none between 0 and 8 degC on average (densest at 4 degC, Kell 1975), 2.1e-4 at 20 degC."))
		((Real,latentHeat,334e3,,"Latent heat of fusion at 0 degC [J/kg], > 0 (the paper gives none)."))
		((string,conductivityMean,"arithmetic",,"How conductivities of the phases combine: arithmetic, geometric or harmonic."))
		((string,name,"",,"Name by which points are given this material, e.g. talik.geometry.fill(mpm,polygon,material='peat'). Names in "
				"MpmEngine.materials differ."))
		((Real,thawStrain,0,,"Volume that ice-rich ground loses on complete thaw over its volume at the start [-], 0 to below its porosity: 1-(1-n_0)/(1-n_1) with "
				"the porosity n_0 of the frozen ground, excess ice included, and n_1 of the thawed soil (talik.layers.thawStrain). It is lost along gravity as the ice "
				"saturation falls from that at the start to 0, and not regained by freezing; open room carries no stress. Any skeleton law takes it; "
				"that of the grains of a sample, RveSample.thawStrain, comes on top. Adds the fields thawStrainReleased [-], of the "
				"volume at the start, and thawStrainOpen [-], what is not closed yet of the present volume. It is the settlement without load: what "
				"load adds is compressibility or compressionIndex. Needs freezing, motion and gravity."))
		((Real,compressibility,0,,"Strain of the ground once it has thawed, of its volume frozen, over the effective stress along gravity, a_0 [1/Pa], 0 to 1e-3: "
				"1 % per kPa is 1e-5. Thaw tests give settlement A_0+a_0*stress, with A_0 the thawStrain (talik.soils has them by soil). All strain since "
				"the start counts, that of the skeleton law included, which must be the stiffer: it governs unloading. Ground without ice at the start has "
				"settled under its stress already. Follows ice as thawStrain does, with load before or after thaw, and any skeleton law takes it. Adds the "
				"fields thawedCompression [-], lost for good beyond the strain of the law, of the volume at the start, and pressureAtStart [Pa]. Needs "
				"freezing, motion and gravity. Error where the law is softer, and where thaw closes all pores."))
		((Real,compressionIndex,0,,"In place of compressibility: void ratio that thawed ground loses as the effective stress along gravity grows tenfold, C_c "
				"[-], 0 to 100. Strain is compressionIndex*(1-porosity)*log10(stress/referenceStress) beyond referenceStress, where thawStrain is that of the test."))
		((Real,referenceStress,1e3,,"Effective stress along gravity up to which compressionIndex gives no strain [Pa], > 0."))
		((shared_ptr<IceSegregation>,segregation,,,"Ice segregation of this material; None: MpmEngine.segregation, which must be there in either case. "
				"IceSegregation(segregationPotential=0) is a soil that is not frost-susceptible."))
		((shared_ptr<FreezingCurve>,freezing,,,"Freezing curve of this material; None: MpmEngine.freezing, which must be there in either case."))
		((Real,hydraulicConductivity,NaN,,"Saturated hydraulic conductivity of this material, thawed, at referencePorosity [m/s], > 0; NaN: PoreWater.conductivity."))
		((Real,referencePorosity,NaN,,"Porosity at which hydraulicConductivity holds [-], in (0,1); NaN: PoreWater.referencePorosity."))
		((Real,permeabilityIndex,0,,"C_k [-], 0.01 to 100: void ratio over which the hydraulic conductivity grows tenfold, log10(k) linear in the void ratio; 0: it "
				"follows Kozeny-Carman. Clays have about half their void ratio (Tavenas et al. 1983). Beside compressionIndex for large settlement."))
		((Real,impedance,NaN,,"Omega of this material [-], >= 0; NaN: PoreWater.impedance."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(GroundMaterial);

} // namespace yade
