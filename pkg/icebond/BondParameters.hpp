// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
/// The parameters of ice bonds, one line each: X(name, default, unit, range, mixing, help, note).
///  name    of the member of IceBondModel, of the attribute of IceBondMat, in messages
///  range   valid values, one of talik::BondRanges
///  mixing  which value counts between grains of two materials, one of talik::BondMixings
///  help    what it is; unit, range, note and mixing follow in the help of the attribute
/// BondTable.hpp has it as a table. Archives, checks and the help of scripts follow this list, in this order. eq. (5), (6) and (7) are those of Yu & Zhao.
// clang-format off
#define TALIK_BOND_PARAMETERS(X) \
	X(iceYoung, 3e9, "Pa", notNegative, softer, "Delta E of eq. (6): contact modulus added at full ice saturation", "") \
	X(tensileStrength, 1e6, "Pa", notNegative, smaller, "C_eta0 of eq. (5): tensile strength of a bond at vanishing ice saturation", \
		" Dropped once the ice has melted, see thawedStrength.") \
	X(iceTensileStrength, 50e6, "Pa", notNegative, smaller, "Delta C_eta of eq. (5): tensile strength added at full ice saturation", "") \
	X(shearStrength, 1e6, "Pa", notNegative, smaller, "C_tau0 of eq. (5): cohesive shear strength of a bond at vanishing ice saturation", \
		" Dropped once the ice has melted, see thawedStrength.") \
	X(iceShearStrength, 50e6, "Pa", notNegative, smaller, "Delta C_tau of eq. (5): cohesive shear strength added at full ice saturation", "") \
	X(exponent, 2., "-", aboveOne, larger, "Exponent m of eq. (7)", "") \
	X(bondAreaFactor, 1., "-", positive, smaller, "Bond area over the square of the smaller radius", "") \
	X(meltSaturation, 0.02, "-", belowOne, larger, "At or below this ice saturation every bond is gone and contacts are purely frictional", "") \
	X(bondSaturation, 0.05, "-", notBelowMelting, larger, "Ice rising through this saturation bonds every frictional contact in range", "") \
	X(bondRange, 0.05, "-", notNegative, smaller, "Largest gap that is bonded, in units of the smaller radius", "") \
	X(thawedStrength, 0., "Pa", notNegative, smaller, "Tensile and cohesive shear strength that a bond keeps when its ice has melted", \
		" C_0 of eq. (5) is the strength without ice. Such a bond holds until it breaks, once; ice that grows again bonds the contact anew. 0: melting takes " \
		"the bond away.")

/// Ranges and mixing rules in the help of an attribute.
#define TALIK_RANGE_notNegative ">= 0"
#define TALIK_RANGE_positive "> 0"
#define TALIK_RANGE_aboveOne "> 1"
#define TALIK_RANGE_belowOne "0 to below 1"
#define TALIK_RANGE_notBelowMelting ">= meltSaturation"
#define TALIK_MIXING_smaller " Of two materials the smaller one counts."
#define TALIK_MIXING_larger " Of two materials the larger one counts."
#define TALIK_MIXING_softer " Of two materials the smaller ratio to young counts."
#define TALIK_BOND_HELP(unit, range, mixing, help, note) help " [" unit "], " TALIK_RANGE_##range "." note TALIK_MIXING_##mixing
// clang-format on
