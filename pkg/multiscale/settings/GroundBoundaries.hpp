// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/serialization/Serializable.hpp>
#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/multiscale/settings/GroundVector.hpp>
#include <pkg/python/ScriptValues.hpp>
#include <set>

namespace yade {

using talik::secondsPerDay;

/// Condition on a part of the ground's surface; derived classes say which.
class GroundBoundary : public Serializable {
public:
	template <int D> using Pointer = std::shared_ptr<talik::Boundary<D>>;
	/// The condition of one run, in the plane or in space.
	template <int D> Pointer<D> build() const
	{
		if constexpr (D == 2) return inPlane();
		else return inSpace();
	}
	/// Throws if the boundary names a body that is none of those which the ground meets, by their numbers and clumps.
	virtual void checkBodies(const std::set<int>&) const {};

protected:
	virtual Pointer<2> inPlane() const;
	virtual Pointer<3> inSpace() const;

	template <int D> talik::Region<D> where() const;
	/// The same, of a boundary without a value that could change.
	template <int D> talik::Region<D> always() const;
	/// The table of times and values if there is one, else the constant.
	talik::TimeTable overTime(Real constant) const;

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(GroundBoundary,Serializable,"Condition on a part of the ground's surface; use one of the derived classes, in "
			"MpmEngine.boundaries. Example: mpm.boundaries=[RollerBoundary(region='left'),FixedBoundary(region='bottom')].",
		((string,region,"",,"left, right, bottom or top side of the grid's box, in space also front and back: x is smallest at left, y at front, and z (in the "
				"plane y) at bottom; surface: the moving free surface where it is open to the air, which enters the box from the top and through sides "
				"without boundary; cavities: surfaces of hollows inside the ground that are closed to the air, such as a body leaves; box: nodes between lower and upper; "
				"disc (ball in space): the ellipse (ellipsoid) that fits between lower and upper, such as a pipe."))
		((GroundVector,lower,-std::numeric_limits<Real>::infinity(),,"Lower corner of the box that limits the region [m]: two components, three in space."))
		((GroundVector,upper,std::numeric_limits<Real>::infinity(),,"Upper corner of the box that limits the region [m]: two components, three in space."))
		((vector<Real>,times,,,"Instants of a value that changes in time, calendar time [s], increasing; see days; linear in between, constant "
				"outside. Empty: the value is constant."))
		((vector<Real>,days,,,"Instants as in times, but in days of the calendar [d]; give one of the two."))
		((vector<Real>,values,,,"Values at these instants, in the unit [that of the attribute that they replace]."))
		,talik::SequenceConverter<GroundBoundary>::registerOnce(); talik::GroundVector::registerOnce();
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(GroundBoundary);

/// What every kind of boundary does alike: make<D>() of the kind is asked in the dimension of the ground.
template <class Kind> class BoundaryInAnyDimension : public GroundBoundary {
protected:
	Pointer<2> inPlane() const override { return static_cast<const Kind&>(*this).template make<2>(); }
	Pointer<3> inSpace() const override { return static_cast<const Kind&>(*this).template make<3>(); }
};

class RollerBoundary : public BoundaryInAnyDimension<RollerBoundary> {
public:
	template <int D> Pointer<D> make() const;
	YADE_CLASS_BASE_DOC(
	        RollerBoundary, GroundBoundary,
	        "Neither grains nor water move across this side; they may slide along it. Example: RollerBoundary(region='left').");
};
REGISTER_SERIALIZABLE(RollerBoundary);

class FixedBoundary : public BoundaryInAnyDimension<FixedBoundary> {
public:
	template <int D> Pointer<D> make() const;
	YADE_CLASS_BASE_DOC(FixedBoundary, GroundBoundary, "Grains and water are at rest on this side. Example: FixedBoundary(region='bottom').");
};
REGISTER_SERIALIZABLE(FixedBoundary);

class PeriodicBoundary : public BoundaryInAnyDimension<PeriodicBoundary> {
public:
	template <int D> Pointer<D> make() const;
	YADE_CLASS_BASE_DOC(
	        PeriodicBoundary, GroundBoundary,
	        "Joins this side with the opposite one: what leaves through one of them (ground, water, heat) comes in at the other, as if the ground were "
	        "repeated behind both for ever. A slope without end is then a column of one cell (talik.slope.infiniteColumn). region is left or right, in "
	        "space "
	        "also front or back; other boundaries act on neither of the two, and others still are the same at both. Positions lie in the box, "
	        "displacements go "
	        "on. Ice that segregates draws no water across. Not with bodies, nor with distribute='ground'. gravityEnergy in MpmEngine.balance() is that of "
	        "the "
	        "displacement along the axis, without what seeps through the grains. Example: PeriodicBoundary(region='left').");
};
REGISTER_SERIALIZABLE(PeriodicBoundary);

class MovingBoundary : public BoundaryInAnyDimension<MovingBoundary> {
public:
	template <int D> Pointer<D> make() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(MovingBoundary,GroundBoundary,"Impermeable wall of given velocity on a side or on the nodes of a box: a plate that presses, a wall "
			"that shears the ground, a base that shakes. Its path across a side, or in any direction in a box, is limited to half of gridSpacing, along a side it is "
			"not; for longer paths take a body of the scene. Its work is wallWork in MpmEngine.balance(), its force on the ground along direction the increase of "
			"wallWork over that of its path. Nodes that it shares with other walls move with it. Example, pressed by 1 cm in 10 s: "
			"MovingBoundary(region='right',rough=False,times=[0,10,10.001],values=[1e-3,1e-3,0]).",
		((Real,speed,0,,"Along direction [m/s], per time of motion, with thermalTimeScale too; times and values may replace it."))
		((GroundVector,direction,0,,"Of the velocity, of any length: two components, three in space; on a side not given: into the ground."))
		((Real,ahead,0,,"Distance of the wall in front of its side at the start [m], 0 to half of gridSpacing, as room to move back (speed < 0): fill the "
				"ground from there."))
		((bool,rough,true,,"The ground sticks to it. False: frictionless, with direction along the normal of a side, or one axis in a box."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(MovingBoundary);

class ImpermeableBoundary : public BoundaryInAnyDimension<ImpermeableBoundary> {
public:
	template <int D> Pointer<D> make() const;
	YADE_CLASS_BASE_DOC(
	        ImpermeableBoundary, GroundBoundary,
	        "Water does not cross this side, whose grains are free to move. Example: ImpermeableBoundary(region='top').");
};
REGISTER_SERIALIZABLE(ImpermeableBoundary);

class DrainedBoundary : public BoundaryInAnyDimension<DrainedBoundary> {
public:
	template <int D> Pointer<D> make() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(DrainedBoundary,GroundBoundary,"Water crosses freely against a prescribed pressure; the balance keeps account of it. Example, a "
			"pond that fills to 2 m within a day: DrainedBoundary(region='left',times=[0,86400],values=[0,19620]).",
		((Real,pressure,0,,"Water pressure outside [Pa], compression positive; times and values may replace it."))
		((bool,recharge,true,,"Water may also come in."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(DrainedBoundary);

class InsulatedBoundary : public BoundaryInAnyDimension<InsulatedBoundary> {
public:
	template <int D> Pointer<D> make() const;
	YADE_CLASS_BASE_DOC(
	        InsulatedBoundary, GroundBoundary,
	        "No heat crosses: what happens anyway where no thermal boundary acts; refused where another one heats the same side. Example: "
	        "InsulatedBoundary(region='right').");
};
REGISTER_SERIALIZABLE(InsulatedBoundary);

class WallTemperature : public BoundaryInAnyDimension<WallTemperature> {
public:
	template <int D> Pointer<D> make() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(WallTemperature,GroundBoundary,"Temperature of the ground on a side of the grid's box, or inside a box or disc in the ground, "
			"whose edge may lie anywhere between nodes: a pipe has region='disc',lower=(-.4,-2),upper=(.4,-1.2). Example: "
			"WallTemperature(region='bottom',lower=(2,-1),upper=(6,1),temperature=10).",
		((Real,temperature,0,,"[degC]; times and values may replace it."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(WallTemperature);

class SurfaceTemperature : public BoundaryInAnyDimension<SurfaceTemperature> {
public:
	template <int D> Pointer<D> make() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(SurfaceTemperature,GroundBoundary,"Temperature of the moving free surface, or of air that exchanges heat h_c (T_air - T) with it. "
			"A weather series: see talik.weather.airTemperature. Example: SurfaceTemperature(region='surface',days=[0,10],values=[-5,10]).",
		((Real,temperature,0,,"[degC]; times and values may replace it."))
		((Real,heatTransferCoefficient,std::numeric_limits<Real>::infinity(),,"Between air and surface [W/(m^2 K)], > 0, per calendar time; infinite: the surface "
				"itself has the temperature."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(SurfaceTemperature);

class BodyTemperature : public BoundaryInAnyDimension<BodyTemperature> {
public:
	template <int D> Pointer<D> make() const;
	void                        checkBodies(const std::set<int>& met) const override;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(BodyTemperature,GroundBoundary,"Temperature of bodies of the scene (a pipe, a slab, a warm wall), which heats or cools the ground "
			"where it faces them now: within half a point's width of their surface, wherever they have moved. Heat per area (T_body - T_ground)/(resistance + that of "
			"the ground). Other bodies let no heat pass. Needs MpmEngine.bodies; region, lower and upper stay as they are. Example, body 0 as a pipe of 10 degC in 5 "
			"cm of insulation of 0.04 W/(m K): BodyTemperature(bodies=[0],temperature=10,resistance=0.05/0.04).",
		((vector<int>,bodies,,,"Numbers of the bodies (O.bodies), or of clumps, whose members then all have the temperature."))
		((Real,temperature,0,,"Inside the bodies [degC], -100 to 100; times and values may replace it."))
		((Real,resistance,0,,"Thermal resistance between inside and ground [m^2 K/W], >= 0, thickness over conductivity of a wall, per area of the body's surface; "
				"0: the surface itself has the temperature."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(BodyTemperature);

class HeatFlux : public BoundaryInAnyDimension<HeatFlux> {
public:
	template <int D> Pointer<D> make() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(HeatFlux,GroundBoundary,"Heat into the ground per unit area of its surface. Example: HeatFlux(region='surface',flux=50).",
		((Real,flux,0,,"Into the ground [W/m^2], per calendar time; times and values may replace it."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(HeatFlux);

class HeatSource : public BoundaryInAnyDimension<HeatSource> {
public:
	template <int D> Pointer<D> make() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(HeatSource,GroundBoundary,"Heat produced in the ground inside a box or disc (ball) that stays in its place, edges between nodes "
			"included: a cable, waste, a heat pump (negative). heatIn in MpmEngine.balance() has it. HeatTransfer.source heats the whole ground. Example, a "
			"cable of 40 W per metre: HeatSource(region='disc',lower=(-.1,-1.1),upper=(.1,-.9),power=40/(3.1416*.1**2)).",
		((Real,power,0,,"[W/m^3] of ground, pores included, per calendar time; times and values may replace it."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(HeatSource);

class WaterFlux : public BoundaryInAnyDimension<WaterFlux> {
public:
	template <int D> Pointer<D> make() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(WaterFlux,GroundBoundary,"Water fed into the ground per unit area of a side or of the surface (rain, a spring; negative: drawn "
			"out), whatever pressure that takes; refused where a DrainedBoundary prescribes the pressure. The balance keeps account of it as negative waterOut. "
			"Example, 20 mm of rain a day: WaterFlux(region='surface',flux=0.02/86400).",
		((Real,flux,0,,"Volume of water per area and time into the ground [m/s], scaled like the conductivity (calendar time, see PoreWater.hydraulicTimeScale); "
				"times and values may replace it."))
		((Real,temperature,NaN,,"Of the water that enters [degC], 0 to 100; NaN: that of the ground where it enters."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(WaterFlux);

class SurfaceLoad : public BoundaryInAnyDimension<SurfaceLoad> {
public:
	template <int D> Pointer<D> make() const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(SurfaceLoad,GroundBoundary,"Pressure or traction on the ground's surface. Example: SurfaceLoad(region='surface',pressure=10e3).",
		((Real,pressure,0,,"Pushes onto the surface [Pa]; times and values may replace it."))
		((GroundVector,traction,0,,"Force per area beside the pressure [Pa], constant: two components, three in space."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(SurfaceLoad);

} // namespace yade
