// SPDX-License-Identifier: GPL-2.0-or-later
#include "Report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

namespace talik::validation {

namespace {

	std::string number(double value, const char* format = "%.7g")
	{
		char text[64];
		std::snprintf(text, sizeof text, format, value);
		return text;
	}

	std::string currentTest()
	{
		const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
		return test ? std::string(test->test_suite_name()) + "." + test->name() : "none";
	}

	std::map<std::string, std::string>& sources()
	{
		static std::map<std::string, std::string> all;
		return all;
	}

	/// File in a part of the output folder, or empty if there is no such folder.
	std::string outputFile(const char* part, const std::string& name)
	{
		const char* folder = std::getenv("TALIK_VALIDATION_OUTPUT");
		if (!folder || !*folder) return {};
		const auto path = std::filesystem::path(folder) / part;
		std::filesystem::create_directories(path);
		return (path / (name + ".csv")).string();
	}

	std::string inQuotes(const std::string& text) { return '"' + text + '"'; }

	void keepRow(const std::string& what, double measured, const std::string& reference, double error, const std::string& tolerance, bool passed)
	{
		static std::map<std::string, std::string> files;
		const std::string                         test = currentTest();
		const std::string                         path = outputFile("rows", test);
		if (path.empty()) return;
		std::string& rows = files[test];
		if (rows.empty()) rows = "name,measured,reference,error,tolerance,source,passed\n";
		rows += inQuotes(what) + "," + number(measured, "%.10g") + "," + reference + "," + number(error, "%.3e") + "," + tolerance + ","
		        + inQuotes(sources()[test]) + "," + (passed ? "1" : "0") + "\n";
		std::ofstream(path) << rows;
	}

	void addRow(const std::string& what, double measured, const std::string& reference, double error, const std::string& tolerance, bool passed)
	{
		char text[512];
		std::snprintf(
		        text, sizeof text, "%-80s | %13s | %13s | %10.2e | %8s | %s%s", what.c_str(), number(measured).c_str(), reference.c_str(), error,
		        tolerance.c_str(), sources()[currentTest()].c_str(), passed ? "" : " FAILED");
		std::printf("%s\n", text);
		keepRow(what, measured, reference, error, tolerance, passed);
		EXPECT_TRUE(passed) << text;
	}

} // namespace

void citing(const std::string& source) { sources()[currentTest()] = source; }

void expectScaled(const std::string& what, double measured, double reference, double scale, double tolerance)
{
	const double error = (measured - reference) / scale;
	addRow(what, measured, number(reference), error, number(tolerance, "%.1e"), std::abs(error) <= tolerance);
}

void expectRelative(const std::string& what, double measured, double reference, double tolerance)
{
	expectScaled(what, measured, reference, reference, tolerance);
}

void expectSmall(const std::string& what, double value, double bound) { addRow(what, value, "0", value, number(bound, "%.1e"), std::abs(value) <= bound); }

void expectAtLeast(const std::string& what, double value, double bound) { addRow(what, value, ">= " + number(bound), value - bound, "0", value >= bound); }

Drawing::Drawing(const std::string& name, const std::string& title, const std::string& xLabel, const std::string& yLabel)
        : name_(name)
        , text_("# " + title + "\n# " + xLabel + "\n# " + yLabel + "\nseries,kind,x,y\n")
{}

Drawing::~Drawing()
{
	const std::string path = outputFile("curves", name_);
	if (!path.empty()) std::ofstream(path) << text_;
}

void Drawing::add(const std::string& series, const char* kind, double x, double y)
{
	text_ += inQuotes(series) + "," + kind + "," + number(x, "%.8g") + "," + number(y, "%.8g") + "\n";
}

void Drawing::reference(const std::string& series, double from, double to, const std::function<double(double)>& f)
{
	constexpr int samples = 200;
	for (int k = 0; k < samples; ++k) {
		const double x = from + (to - from) * k / (samples - 1);
		add(series, "reference", x, f(x));
	}
}

} // namespace talik::validation
