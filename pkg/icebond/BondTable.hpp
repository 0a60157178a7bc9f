// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <pkg/icebond/IceBond.hpp>
#include <string>

namespace talik {

/// Valid values of a parameter, and in words, for messages.
struct BondRange {
	bool (*holds)(double value, const IceBondModel& of);
	const char* words;
};

/// Of two materials the value that counts in a contact between them.
using BondMixing = double (*)(double first, double second, const IceBondModel& ofFirst, const IceBondModel& ofSecond);

/// A line of the list.
struct BondParameter {
	const char* name;
	double IceBondModel::*value;
	const char*           unit;
	BondRange             range;
	BondMixing            mixing;

	bool        isValid(const IceBondModel& of) const { return range.holds(of.*value, of); }
	std::string remedy() const { return std::string("give a number") + (unit[0] == '-' ? " " : std::string(" in ") + unit + ", ") + range.words + "."; }
};

/// The ranges and mixing rules that the list of parameters names.
struct BondRanges {
	static constexpr BondRange notNegative { [](double v, const IceBondModel&) { return v >= 0 && std::isfinite(v); }, "0 or more" };
	static constexpr BondRange positive { [](double v, const IceBondModel&) { return v > 0 && std::isfinite(v); }, "greater than 0" };
	static constexpr BondRange aboveOne { [](double v, const IceBondModel&) { return v > 1 && std::isfinite(v); }, "above 1" };
	static constexpr BondRange belowOne { [](double v, const IceBondModel&) { return v >= 0 && v < 1; }, "from 0 to below 1" };
	static constexpr BondRange notBelowMelting { [](double v, const IceBondModel& m) { return v >= m.meltSaturation; }, "not below meltSaturation" };
};
struct BondMixings {
	static double smaller(double a, double b, const IceBondModel&, const IceBondModel&) { return std::min(a, b); }
	static double larger(double a, double b, const IceBondModel&, const IceBondModel&) { return std::max(a, b); }
	static double softer(double a, double b, const IceBondModel& first, const IceBondModel& second)
	{
		return first.young * std::min(a / first.young, b / second.young);
	}
};

/// The list as a table.
#define TALIK_LINE(name, initial, unit, range, mixing, help, note) { #name, &IceBondModel::name, unit, BondRanges::range, &BondMixings::mixing },
inline constexpr BondParameter bondParameters[] = { TALIK_BOND_PARAMETERS(TALIK_LINE) };
#undef TALIK_LINE

/// Whether two models have the same parameters, apart from young.
inline bool sameBonds(const IceBondModel& one, const IceBondModel& other)
{
	for (const BondParameter& p : bondParameters)
		if (one.*p.value != other.*p.value) return false;
	return true;
}

/// Bonds between grains of two materials: of two different grains the weaker one decides.
inline IceBondModel mixed(const IceBondModel& first, const IceBondModel& second)
{
	IceBondModel both = first;
	for (const BondParameter& p : bondParameters)
		both.*p.value = p.mixing(first.*p.value, second.*p.value, first, second);
	return both;
}

} // namespace talik
