// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <limits>
#include <pkg/base/ParameterList.hpp>
#include <pkg/thm/FreezingCurve.hpp>
#include <pkg/thm/Mixture.hpp>
#include <pkg/thm/PoreWaterState.hpp>

#include <cmath>
#include <string>
#include <vector>

namespace talik {

/// Parameters of IceSegregation, for the settings of the ground and for the class that a script sees.
// clang-format off
#define TALIK_ICE_SEGREGATION \
	((Real, segregationPotential, NaN,,"SP_0 [m^2/(s K)], 0 or 1e-13 to 1e-6: water that the front draws over the gradient of temperature in the " \
		"frozen ground behind it, without load. Frost-susceptible silts have 1e-10 to 4e-9; 1 mm^2/(s K) is 1e-6. NaN: computed, an upper " \
		"bound: each lens lies where it draws most. With little load that is at -0.03 degC, where the fringe has hardly any ice, and tests heave " \
		"two to four times less, with any impedance.")) \
	((Real, pressureDecay, 0,,"a of SP = SP_0 exp(-a P), P the effective stress normal to the front, to which suction of the water before it adds " \
		"[1/Pa], 0 to 1e-3; soils have 1e-6 to 1e-5 (Konrad and Morgenstern 1982). Only with segregationPotential."))
// clang-format on

/// How much water a freezing soil draws.
struct SegregationSettings {
	TALIK_PARAMETERS(TALIK_ICE_SEGREGATION)

	bool isGiven() const { return !std::isnan(segregationPotential); }
	/// Throws std::invalid_argument naming attribute, value and remedy; prefix: before the names.
	void validate(const std::string& prefix) const;
};

/// Intake of one soil through its frozen fringe, eqs (26.1) to (26.3).
class SegregationPotential {
public:
	SegregationPotential(
	        const SegregationSettings& settings, const FreezingCurve& curve, const Permeability& permeability, const MixtureProperties& mixture);

	/// What stands at a front.
	struct Front {
		double gradient;     ///< of temperature in the frozen ground behind the front [K/m], > 0
		double conductivity; ///< of that ground for heat [W/(m K)]
		double load;         ///< total pressure normal to the front [Pa]
		double pressure;     ///< of the water in the unfrozen ground [Pa], at
		double distance;     ///< from the front [m], and
		double rise;         ///< how much higher the front lies [m]
		double coldest;      ///< temperature of the coldest ground behind the front less T_f [K], < 0: no lens lies farther
		double unfrozen;     ///< gradient in the unfrozen ground before the front that carries as much heat there [K/m], >= 0
		double ice;          ///< saturation of the pores where the gradient behind the front stands, > 0
	};
	struct Intake {
		double water; ///< that the front draws [m/s], >= 0
		double lens;  ///< temperature of the lens less T_f [K], <= 0; 0: not known
	};
	Intake intake(const Front& front) const;

	/// SP of eq. (26.1) where neither the way to the front nor the heat of what freezes counts [m^2/(s K)].
	double potential(double load, double pressure, double coldest = -lowest) const;
	bool   drawsNothing() const { return settings_.segregationPotential == 0.0; }

private:
	static constexpr double lowest = 10.0, step = 2.5e-3; ///< of the table, below T_f [K]
	/// Integrals over the temperature from T_f down.
	struct Fringe {
		double resistance;     ///< of dT/k [K s/m]
		double withIce;        ///< of S_i dT/k, and
		double withIceSquared; ///< of S_i^2 dT/k
	};
	/// How temperature falls in a fringe: linearly with the ice saturation.
	struct Gradient {
		double ofNoIce, perIce; ///< [K/m]
	};
	Fringe fringe(double depth) const;
	/// Of unit area, up to a depth below T_f [s].
	double resistance(double depth, const Gradient& gradient) const;
	/// Largest of (suction depth - head)/(resistance + more) over the depth, up to the coldest; and where.
	Intake largestIntake(double head, const Gradient& gradient, double more, double coldest) const;
	double headOf(double load, double pressure) const;

	SegregationSettings settings_;
	double              liquidDensity_, iceDensity_, latentHeat_, conductivity_, suction_; ///< [m/K]: head of Clapeyron's suction
	std::vector<Fringe> fringes_;                                                          ///< up to k steps
};

} // namespace talik
