// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/ParameterList.hpp>
#include <pkg/mpm/Balance.hpp>
#include <pkg/mpm/boundary/Boundary.hpp>
#include <pkg/mpm/grid/Vector.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>
#include <pkg/thm/CompressionCurve.hpp>
#include <pkg/thm/Enthalpy.hpp>
#include <pkg/thm/FreezingCurve.hpp>
#include <pkg/thm/Mixture.hpp>
#include <pkg/thm/PoreWaterState.hpp>
#include <pkg/thm/SegregationPotential.hpp>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace talik {

/// How the velocity of the solid comes back from the grid. What a point's own velocity differs by from that of the grid dies out in
/// the time picTime with each of them.
/// flip: points keep their own velocity and take the grid's acceleration (Brackbill & Ruppel 1986): little dissipation.
/// apic: points take the grid's velocity and its first moment and give both back (Jiang et al. 2015): momentum and angular momentum
///       are kept to round-off, noise is filtered.
/// tpic: points take the grid's velocity and its gradient (Taylor expansion; Nakamura et al. 2023): as apic, for any shape function,
///       angular momentum is kept approximately only.
enum class VelocityTransfer { flip, apic, tpic };

/// "flip" (default), "apic", "tpic".
std::vector<std::string> velocityTransferNames();
/// Throws std::invalid_argument that lists the names.
VelocityTransfer velocityTransferFromName(const std::string& name);

/// chi, the share of its difference from the grid that a point keeps in a step: exp(-dt/picTime). A share per step in its place is a
/// viscosity of some (1 - chi) h^2/(4 dt), larger the smaller the step.
double keptFraction(double picTime, double dt);
/// sqrt(h/g): in that time a body at rest falls by half a cell, or ground that flows under gravity passes one; g: gravity, that of
/// the earth where a scene has less. The viscosity h^2/(4 picTime) then vanishes as h^1.5, whatever stiffness and step.
double gravityTime(double spacing, double gravity);

/// The effect that lets the ground move, but for gravity.
struct MotionOfAnyDimension {
	VelocityTransfer transfer = VelocityTransfer::flip; ///< of the solid velocity; that of water is always a mix of FLIP and PIC
	/// Time in which the difference between a point's own velocity and that of the grid dies out [s], >= 0: 0 = PIC (with apic and
	/// tpic: as published), infinity = FLIP. NaN (default): sqrt(h/g) with flip, 0 with apic and tpic.
	double picTime      = std::numeric_limits<double>::quiet_NaN();
	double localDamping = 0.0;  ///< alpha of non-viscous damping on the mixture force, in [0, 1): 0.3 to 0.7 for equilibrium, 0 to 0.05 in failure
	bool   bBar         = true; ///< cell means of div v_s and, transposed, of the mean stress: without them the ground locks
};

/// The effect that lets the ground move. Without it the ground is rigid and only heat limits the time step.
template <int D> struct MotionSettings : MotionOfAnyDimension {
	Vec<D> gravity {}; ///< body force per mass b [m/s^2]
	double usedPicTime(double spacing) const
	{
		if (!std::isnan(picTime)) return picTime;
		return transfer == VelocityTransfer::flip ? gravityTime(spacing, lengthOf<D>(gravity)) : 0.0;
	}
};

/// Parameters of HeatTransfer, for the settings of the ground and for the class that a script sees.
// clang-format off
#define TALIK_HEAT_TRANSFER \
	((Real, thermalTimeScale, 1,,"f_T [-], > 0: calendar time that passes in each second of motion. Conduction, surface coefficients, heat fluxes and " \
		"sources are multiplied by it, and seepage and rain unless PoreWater.hydraulicTimeScale says otherwise; " \
		"tables of boundaries are read at calendar time. With " \
		"followsMotion its largest value, at rest. May be changed while running.")) \
	((bool, followsMotion, false,,"The scale of the calendar follows the motion: thermalTimeScale f_T while the ground rests, movingTimeScale f_m while it " \
		"moves, in between f_m + (f_T - f_m)/(1 + (v/motionTolerance)^2). v is the speed of the fastest ground, the largest mean velocity of the points of a cell. " \
		"Where heat needs shorter steps the scale is lowered, not the time step. See MpmEngine.calendar and MpmEngine.events. False: thermalTimeScale always. " \
		"Needs motion.")) \
	((Real, movingTimeScale, 1,,"f_m [-], > 0, at most thermalTimeScale: scale of the calendar while the ground moves, with followsMotion. 1: real time. May be " \
		"changed while running.")) \
	((Real, motionTolerance, 0.01,,"v_0 [m/s], 1e-6 to 1: speed of the fastest ground at which the scale of the calendar lies half way between its two values. " \
		"While ground with the acceleration a gains this speed, about (pi/2) thermalTimeScale v_0/a of calendar time pass. May be changed while running.")) \
	((Real, source, 0,,"Heat produced per volume [W/m^3]."))
// clang-format on

/// The effect of heat: enthalpy, conduction, latent heat where a freezing curve is present.
struct HeatSettings {
	TALIK_PARAMETERS(TALIK_HEAT_TRANSFER)
	/// Speed in calendar time above which motion is an event [m/s], a metre a day, a moderate landslide (Cruden and Varnes 1996): ground that only settles
	/// or creeps as it thaws is slower, whatever the scale. And displacement from which on a point counts as moved in an event [m].
	double eventSpeed = 1e-5, eventDisplacement = 0.02;
	/// Time constant of the damping of temperature differences that vanish at the nodes (null space of the grid); energy is conserved [s of calendar
	/// time]. NaN (default): chosen from the grid, infinite: no damping.
	double smoothingTime = NaN;
};

/// The effect of pore water: a second velocity, pressure, seepage.
struct WaterSettings {
	PoreWaterState state;        ///< bulk moduli, cavitation pressure, densityChange
	Permeability   permeability; ///< hydraulic conductivity
	double         picTime = std::numeric_limits<
                double>::quiet_NaN(); ///< of the liquid velocity [s], >= 0; NaN (default): sqrt(h/g); no more than 12.5 ms where seepage is accelerated
	/// f_H multiplies conductivity and what is fed in [-], 1e-12 to 1e12; NaN (default): the scale of the calendar.
	double hydraulicTimeScale = std::numeric_limits<double>::quiet_NaN();
	/// No water is accelerated beyond this conductivity, and that of gravel is lowered to it [m/s], > 0; NaN (default): chosen, see
	/// PoreWater::largestConductivity; infinity: none.
	double largestConductivity = std::numeric_limits<double>::quiet_NaN();
	/// Pressure of the end of the step, from one system for all cells, see ImplicitPressure: the stiffness of water does not limit the step.
	bool implicit = false;
};

/// Constants of the contact at the thaw front. What each does is measured by `scripts/accuracy front`.
struct FrontConstants {
	/// Part of gravity along the normal from which on thawed ground lies on frozen ground and settles with it [-].
	double restingWeight = 0.5;
	/// Water over what the pores hold from which on they begin to be full, and from which on they are, so that still water bears its part [-].
	double nearlyFull = 0.97, full = 0.99;
	/// A side with less of a node's mass than this has no velocity of its own there: the quotient would be round-off [-].
	static constexpr double smallestMassShare = 1e-9;
};

/// The effect of two velocities where ground that ice holds meets ground that it does not, see ThawFront.
struct ThawFrontSettings {
	FrontConstants constants;
};

/// The effect of rigid bodies that push the ground and are pushed by it.
struct RigidContactSettings {
	double stiffness
	        = std::numeric_limits<double>::quiet_NaN(); ///< k, pressure over penetration [Pa/m]; NaN: oedometer modulus of the stiffest point over h
	double shearRatio = 0.5;                            ///< tangential over normal stiffness [-], in (0, 1]
	double damping    = 0.1;                            ///< of the contact, over critical for a point [-], in [0, 1)

	/// Throws std::invalid_argument naming attribute, value and remedy.
	void validate() const;
};

/// What one soil of a ground has of its own. Water is the same everywhere, because it moves from soil to soil.
struct SoilMaterial {
	MixtureProperties                  mixture; ///< densities, specific heats and expansivities of ice and liquid, and the latent heat: those of all others
	FreezingCurvePtr                   freezing;     ///< empty: that of the scene; needs one there
	std::optional<Permeability>        permeability; ///< empty: that of the scene
	std::optional<SegregationSettings> segregation;  ///< empty: that of the scene; needs one there
	double           thawStrain = 0.0; ///< volume lost on complete thaw over that at the start [-], 0 to below 1; needs motion, gravity and freezing
	CompressionCurve compression;      ///< of the soil once it has thawed; needs the same
};

/// What is fixed about a scene before it starts and has no direction. Absent optionals are absent effects: no field, no loop, no limit.
struct SettingsOfAnyDimension {
	double      gridSpacing   = 0.0;                ///< h [m], > 0
	std::string shapeFunction = "quadraticBSpline"; ///< see shapeFunctionNames()
	bool        axisymmetric  = false;              ///< the plane turns about x = 0; all quantities are those of a radian

	MixtureProperties         mixture;   ///< of a ground without materials
	std::vector<SoilMaterial> materials; ///< PointInput::material counts in this list; empty: one soil, of mixture, freezing and water->permeability
	/// Of the points of a material.
	const MixtureProperties& mixtureOf(int material) const { return materials.empty() ? mixture : materials[material].mixture; }

	std::optional<HeatSettings>         heat;
	FreezingCurvePtr                    freezing;    ///< needs heat
	std::optional<WaterSettings>        water;       ///< needs motion
	std::optional<SegregationSettings>  segregation; ///< freezing ground draws water; needs motion with bBar, freezing and water
	std::optional<RigidContactSettings> bodies;      ///< needs motion
	std::optional<ThawFrontSettings>    thawFront
	        = ThawFrontSettings {}; ///< at work where the scene has motion, freezing and a skeleton that can fail; empty: one velocity for all
	bool energyLedger      = false; ///< keep account of work and dissipation, see Balance
	bool deformationRecord = false; ///< points remember their deformation gradient; needs motion
	bool pointsDivide      = false; ///< points that grow longer than a cell become two, see DividingPoints; needs motion

	/// Fraction of the pores that holds water, in [0, 1]; NaN (default): 1 with heat or water, 0 in a dry scene. With water it must be 1.
	double poreFill = std::numeric_limits<double>::quiet_NaN();
	double usedPoreFill() const { return std::isnan(poreFill) ? (heat || water ? 1.0 : 0.0) : poreFill; }

	/// Number of points from which on a step uses several threads; with fewer they would wait for each other longer than they
	/// work. Results do not depend on it.
	int parallelFrom = 500;

	double courantNumber  = 0.4; ///< C_w: time step over h/(c_max + |v|), in (0, 1]; cut to sqrt(2/(D steepness)), beyond which no step is safe
	double heatFraction   = 0.9; ///< C_T: time step over the explicit heat limit, in (0, 1]
	double motionFraction = 0.2; ///< largest path of a point per step over h, in (0, 0.5]
};

template <int D> class Effect;

/// Everything about a scene that is fixed before it starts.
template <int D> struct GroundSettings : SettingsOfAnyDimension {
	Vec<D> lower {}; ///< corner of the grid's box [m]
	Vec<D> upper {}; ///< opposite corner [m], whole number of spacings away

	std::optional<MotionSettings<D>>               motion;
	std::vector<std::shared_ptr<Boundary<D>>>      boundaries;
	std::vector<std::shared_ptr<SkeletonModel<D>>> skeletons; ///< PointInput::skeleton counts in this list
	std::vector<std::shared_ptr<Effect<D>>>        effects;   ///< that stand in files of their own, see Effect; need motion

	/// Pore water expands where it freezes, so that ice may part the grains.
	bool iceExpands() const { return motion && freezing && water && water->state.densityChange; }
};

/// One material point as it is put into a scene.
template <int D> struct PointInput {
	Vec<D> position {};                                            ///< [m]
	double volume      = 0.0;                                      ///< [m^D], > 0; about an axis that of the plane, without the radius
	double porosity    = 0.4;                                      ///< n [-], in (0, 1)
	double temperature = 0.0;                                      ///< [degC], used if heat is present
	double pressure    = 0.0;                                      ///< pore pressure [Pa], used if water is present
	double poreFill    = std::numeric_limits<double>::quiet_NaN(); ///< part of the pores that holds water or ice, in [0, 1]; NaN: GroundSettings::poreFill
	int    skeleton    = 0;                                        ///< index into GroundSettings::skeletons
	int    material    = 0;                                        ///< index into GroundSettings::materials; 0 where that is empty
	Vec<D> velocity {};                                            ///< of solid and liquid [m/s]
	std::array<double, stressSize<D>> stress {};                   ///< effective stress [Pa], tension positive
};

/// One of the limits of the explicit time step.
struct TimeStepLimit {
	std::string name;  ///< "wave", "velocity", "heat", "heat advection"
	double      step;  ///< [s], safety fraction included; infinity: not a limit
	int         point; ///< id of the point that governs, -1 if none
};

/// The largest stable time step and what limits it.
struct StableTimeStep {
	double                     step; ///< [s]
	std::string                governing;
	std::vector<TimeStepLimit> limits;
};

/// One array of the complete state.
struct StateArray {
	std::string name;
	void*       data;
	std::size_t bytes;
};

// What a scene must fulfil before its ground is set up. All throw std::invalid_argument naming attribute, value and remedy.

template <int D> void checkSettings(const GroundSettings<D>& settings);
template <int D> void checkBoundaries(const GroundSettings<D>& settings, const Grid<D>& grid);
template <int D> void checkPoints(const GroundSettings<D>& settings, const Grid<D>& grid, int count, const std::function<PointInput<D>(int id)>& point);

} // namespace talik
