// SPDX-License-Identifier: GPL-2.0-or-later
#include "Held.hpp"

#include "Report.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace talik::stability {

void expectHeld(const std::string& name, const Figures& f, const Limits& limits)
{
	using validation::expectSmall;
	EXPECT_TRUE(f.finite) << name << ": a field is not finite";
	EXPECT_EQ(f.stopped, "") << name;
	if (std::isfinite(limits.energy)) expectSmall(name + ": energy from nowhere", f.energyCreated, limits.energy);
	expectSmall(name + ": drift of solid and water", std::max(f.solidDrift, f.waterDrift), limits.mass);
	expectSmall(name + ": drift of heat", f.heatDrift, limits.heat);
	expectSmall(name + ": momentum less impulse", f.momentumDrift, limits.momentum);
}

Map::Map(const std::string& name, const std::string& title, const std::string& xLabel, const std::string& yLabel, const std::string& valueLabel)
        : name_(name)
        , text_("# " + title + "\n# " + xLabel + "\n# " + yLabel + "\n# " + valueLabel + "\nx,y,value,held\n")
{}

Map::~Map()
{
	const char* folder = std::getenv("TALIK_VALIDATION_OUTPUT");
	if (!folder || !*folder) return;
	const auto path = std::filesystem::path(folder) / "maps";
	std::filesystem::create_directories(path);
	std::ofstream(path / (name_ + ".csv")) << text_;
}

void Map::add(double x, double y, double value, bool held)
{
	char line[128];
	std::snprintf(line, sizeof line, "%.8g,%.8g,%.8g,%d\n", x, y, value, held ? 1 : 0);
	text_ += line;
}

} // namespace talik::stability
