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
		((Real,thermalTimeScale,1,,"f_T [-], > 0: calendar time that passes in each second of motion. Conduction, surface coefficients, heat fluxes and sources are "
				"multiplied by it, and seepage and rain unless PoreWater.hydraulicTimeScale says otherwise; tables of boundaries are read at calendar time. With "
				"followsMotion its largest value, at rest. May be changed while running."))
		((bool,followsMotion,false,,"The scale of the calendar follows the motion: thermalTimeScale f_T while the ground rests, movingTimeScale f_m while it "
				"moves, in between f_m + (f_T - f_m)/(1 + (v/motionTolerance)^2). v is the speed of the fastest ground, the largest mean velocity of the points of a cell. "
				"Where heat needs shorter steps the scale is lowered, not the time step. See MpmEngine.calendar and MpmEngine.events. False: thermalTimeScale always. "
				"Needs motion."))
		((Real,movingTimeScale,1,,"f_m [-], > 0, at most thermalTimeScale: scale of the calendar while the ground moves, with followsMotion. 1: real time. May be "
				"changed while running."))
		((Real,motionTolerance,0.01,,"v_0 [m/s], 1e-6 to 1: speed of the fastest ground at which the scale of the calendar lies half way between its two values. "
				"While ground with the acceleration a gains this speed, about (pi/2) thermalTimeScale v_0/a of calendar time pass. May be changed while running."))
		((Real,eventSpeed,1e-5,,"Speed in calendar time above which motion is an event [m/s], >= 0: the speed of the fastest ground divided by the scale of the "
				"calendar. It must also exceed motionTolerance. Ground that only settles or creeps as it thaws is slower, whatever the scale. "
				"1e-5 m/s is a metre a day, a moderate landslide (Cruden and Varnes 1996)."))
		((Real,eventDisplacement,0.02,,"Displacement from which on a point counts as moved in an event [m], > 0. Events in which no point moves that far are "
				"left out."))
		((Real,source,0,,"Heat produced per volume [W/m^3]."))
		((Real,smoothingTime,NaN,,"Time constant of the damping of temperature differences that vanish at the nodes (null space of the grid); energy is conserved "
				"[s of calendar time]. NaN: chosen from the grid, infinite: no damping."))
		((string,enthalpyForm,"stateFunction",,"stateFunction (exact) or capacityIntegral (latent heat constant, Yu & Zhao eq. 4)."))
		((string,latentDensity,"ice",,"Density that multiplies the latent heat: ice (the mass that melts) or liquid (as printed in Yu & Zhao eq. 4; 9.9 % more "
				"heat)."))
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
	talik::ThawFrontSettings build() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(ThawFront,Serializable,"Effect of a scene: where frozen and thawed ground meet, they have separate velocities on the nodes, so that "
			"a thawed layer of any thickness can slide on its frozen base. The friction between them is the strength of the law or the samples of the "
			"thawed points. It acts in scenes with motion, freezing and a skeleton that can fail, with the fields frozenSide (1: frozen) and slip [m]. "
			"MpmEngine.thawFront=None switches it off: a layer thinner than about two cells then moves with its base. Example: "
			"MpmEngine(gridSpacing=0.5,thawFront=ThawFront(frozenAbove=0.1)).",
		((Real,thawedBelow,0.02,,"Ice saturation at and below which a point becomes thawed ground [-], 0 to below 1: the bonds of samples are gone there."))
		((Real,frozenAbove,0.05,,"Ice saturation at and above which it becomes frozen ground again [-], above thawedBelow, up to 1: the bonds of samples form "
				"there."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(ThawFront);

/// Effect: pore water moves and carries pressure, Yu & Zhao eqs (2), (3).
class PoreWater : public Serializable {
public:
	talik::WaterSettings build(Real residualSaturation) const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(PoreWater,Serializable,"Effect of a scene: pore water with its own velocity, pressure and seepage. Needs motion. The drag "
			"between water and grains is implicit on the nodes, so that permeability does not limit the time step. Example: "
			"PoreWater(conductivity=1e-4,bulkModulus=2.2e7).",
		((Real,conductivity,1e-4,,"Saturated hydraulic conductivity k of thawed ground at referencePorosity [m/s], > 0. Larger values than 12.5 ms * g * "
				"referencePorosity, 0.049 by default (1e-2 at least), are lowered to that, with a warning; pressure then comes to rest within a fraction of a second. "
				"MpmEngine.calendar['largestConductivity'] has the limit in force."))
		((Real,referencePorosity,0.4,,"Porosity at which conductivity holds [-]. At other porosities it follows Kozeny-Carman."))
		((string,relativeConductivity,"impedance",,"How ice reduces the conductivity: impedance (10^(-Omega S_i)), vanGenuchtenMualem, power, iceAsGrain."))
		((Real,impedance,6,,"Omega of impedance [-], >= 0."))
		((Real,relativeConductivityFloor,1e-6,,"Smallest relative conductivity [-], in (0,1]."))
		((Real,hydraulicTimeScale,NaN,,"f_H multiplies the conductivity and the inflow of WaterFlux [-], 1e-12 to 1e12. NaN: the scale of the calendar, so that "
				"thaw and consolidation keep their ratio. A number replaces it; 1 leaves seepage in seconds of motion. Seepage is accelerated only up to the conductivity "
				"at which pressure comes to rest within a fraction of a second, see MpmEngine.calendar['largestConductivity']."))
		((string,pressure,"explicit",,"How the pressure follows: explicit, from step to step, so that the stiffness of water limits the step; implicit, for all "
				"cells at once at the end of the step: the step is that of the skeleton, with water as stiff as it is, and pressure does not alternate from cell to cell. "
				"implicit needs bBar, and refuses MovingBoundary, segregation and distribute='ground'."))
		((Real,bulkModulus,NaN,,"Bulk modulus of water K_w [Pa], > 0. Real water has 2.2e9. NaN: 2.2e9 with implicit pressure; with explicit pressure 2.2e7, a "
				"hundredth, which allows larger time steps and lowers Skempton's B, see MpmEngine.skemptonB."))
		((Real,iceBulkModulus,NaN,,"Bulk modulus of ice K_i [Pa], > 0; NaN: four times that of water."))
		((Real,cavitationPressure,0,,"p_cav [Pa], <= 0: lowest pressure. A gap opens there, which has to close before the pressure rises again."))
		((bool,zetaActive,true,,"Water expands as it freezes. False: phase change drives no flow (density of ice kept in inertia and heat)."))
		((string,massCoefficient,"exact",,"exact: 1 - zeta S_i; printed: 1 - zeta n_i as in Yu & Zhao eq. (3), for comparison."))
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
		((Real,segregationPotential,NaN,,"SP_0 [m^2/(s K)], 0 or 1e-13 to 1e-6: water that the front draws over the gradient of temperature "
				"in the frozen ground behind it, without "
				"load. Frost-susceptible silts have 1e-10 to 4e-9; 1 mm^2/(s K) is 1e-6. NaN: computed, which needs a freezing curve and an "
				"impedance of the soil's own: "
				"the default impedance gives some fifty times what is measured."))
		((Real,pressureDecay,0,,"a of SP = SP_0 exp(-a P), P the effective stress normal to the front [1/Pa], 0 to 1e-3; soils have 1e-6 to "
				"1e-5 (Konrad and Morgenstern 1982). Only "
				"with segregationPotential."))
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
	/// True if its phases are the default ones.
	bool hasDefaultPhases() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(GroundMaterial,Serializable,"Soil grains, ice and liquid water of saturated ground; defaults are those of Yu & Zhao, section 3. "
			"MpmEngine.materials lists several, with the same densities, specific heats, expansivities and latent heat of ice and liquid. "
			"Example: GroundMaterial(conductivityMean='geometric').",
		((Real,solidDensity,2650,,"Intrinsic density of the soil grains [kg/m^3], > 0."))
		((Real,iceDensity,910,,"Intrinsic density of ice [kg/m^3], > 0."))
		((Real,liquidDensity,1000,,"Intrinsic density of liquid water [kg/m^3], > 0."))
		((Real,solidSpecificHeat,800,,"[J/(kg K)], > 0."))
		((Real,iceSpecificHeat,2060,,"[J/(kg K)], > 0."))
		((Real,liquidSpecificHeat,4200,,"[J/(kg K)], > 0."))
		((Real,solidConductivity,1.0,,"Thermal conductivity [W/(m K)], > 0."))
		((Real,iceConductivity,2.2,,"Thermal conductivity [W/(m K)], > 0."))
		((Real,liquidConductivity,0.6,,"Thermal conductivity [W/(m K)], > 0."))
		((Real,solidExpansivity,2.4e-5,,"Volumetric thermal expansivity [1/K]."))
		((Real,iceExpansivity,1.6e-4,,"Volumetric thermal expansivity [1/K]."))
		((Real,liquidExpansivity,2.1e-4,,"Volumetric thermal expansivity [1/K]."))
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
		((Real,impedance,NaN,,"Omega of this material [-], >= 0; NaN: PoreWater.impedance."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(GroundMaterial);

} // namespace yade
