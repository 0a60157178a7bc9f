// SPDX-License-Identifier: GPL-2.0-or-later
#include "Report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

namespace talik::validation {

namespace {

	std::vector<std::string>& rows()
	{
		static std::vector<std::string> all;
		return all;
	}

	void addRow(const std::string& what, const std::string& measured, const std::string& reference, double error, const std::string& tolerance, bool passed)
	{
		char text[512];
		std::snprintf(
		        text,
		        sizeof text,
		        "%-74s | %14s | %14s | %10.2e | %10s |%s",
		        what.c_str(),
		        measured.c_str(),
		        reference.c_str(),
		        error,
		        tolerance.c_str(),
		        passed ? "" : " FAILED");
		rows().push_back(text);
		std::printf("%s\n", text);
		EXPECT_TRUE(passed) << text;
	}

	std::string number(double value, const char* format = "%.7g")
	{
		char text[64];
		std::snprintf(text, sizeof text, format, value);
		return text;
	}

	/// Prints all rows together once every test has run.
	class SummaryTable : public ::testing::Environment {
	public:
		void TearDown() override
		{
			if (rows().empty()) return;
			std::printf("\n%-74s | %14s | %14s | %10s | %10s |\n", "case", "measured", "reference", "error", "tolerance");
			std::printf("%s\n", std::string(133, '-').c_str());
			for (const std::string& row : rows())
				std::printf("%s\n", row.c_str());
			std::printf("\n");
		}
	};

	const auto* const summaryTable = ::testing::AddGlobalTestEnvironment(new SummaryTable);

} // namespace

void expectScaled(const std::string& what, double measured, double reference, double scale, double tolerance)
{
	const double error = (measured - reference) / scale;
	addRow(what, number(measured), number(reference), error, number(tolerance, "%.1e"), std::abs(error) <= tolerance);
}

void expectRelative(const std::string& what, double measured, double reference, double tolerance)
{
	expectScaled(what, measured, reference, reference, tolerance);
}

void expectSmall(const std::string& what, double value, double bound)
{
	addRow(what, number(value), "0", value, number(bound, "%.1e"), std::abs(value) <= bound);
}

void expectAtLeast(const std::string& what, double value, double bound)
{
	addRow(what, number(value), ">= " + number(bound), value - bound, "0", value >= bound);
}

} // namespace talik::validation
