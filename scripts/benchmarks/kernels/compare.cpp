// SPDX-License-Identifier: GPL-2.0-or-later
// Two versions of the packed samples in turn: processor time of this thread, ratio of neighbours in time, as JSON.
// usage  compare <discs.txt> <spheres.txt> <rounds> [kind]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

extern "C" {
void   former_prepare(const char* file, bool spheres, bool frozen);
void   present_prepare(const char* file, bool spheres, bool frozen);
double former_run(long steps);
double present_run(long steps);
}

namespace {

struct Kind {
	const char* name;
	bool        spheres, frozen;
	long        steps;
};
constexpr Kind kinds[] = {
	{ "discs", false, false, 2000 }, { "frozen discs", false, true, 2000 }, { "spheres", true, false, 400 }, { "frozen spheres", true, true, 400 }
};

double processorTime()
{
	timespec now;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

double timeOf(double (*run)(long), long steps, double& pressure)
{
	const double start = processorTime();
	pressure           = run(steps);
	return processorTime() - start;
}

} // namespace

int main(int argc, char** argv)
{
	if (argc < 4) return std::fprintf(stderr, "usage: compare <discs.txt> <spheres.txt> <rounds> [kind]\n"), 2;
	const int         rounds = std::atoi(argv[3]);
	const std::string wanted = argc > 4 ? argv[4] : "";
	std::puts("[");
	for (const Kind& kind : kinds) {
		if (!wanted.empty() && wanted != kind.name) continue;
		const char* file = argv[kind.spheres ? 2 : 1];
		former_prepare(file, kind.spheres, kind.frozen);
		present_prepare(file, kind.spheres, kind.frozen);
		std::vector<double> ratios;
		double              before = 0, now = 0;
		for (int round = 0; round < rounds; ++round) {
			double former = 0, present = 0;
			if (round % 2) former = timeOf(former_run, kind.steps, before);
			present = timeOf(present_run, kind.steps, now);
			if (round % 2 == 0) former = timeOf(former_run, kind.steps, before);
			ratios.push_back(present / former);
		}
		std::sort(ratios.begin(), ratios.end());
		const auto part = [&](double share) { return ratios[std::size_t(share * double(ratios.size() - 1))]; };
		std::printf(
		        "\t{\"kind\": \"%s\", \"steps\": %ld, \"ratio\": %.6f, \"quartiles\": [%.6f, %.6f], \"pressure\": [%.17g, %.17g]}%s\n", kind.name,
		        kind.steps, part(0.5), part(0.25), part(0.75), before, now, wanted.empty() && &kind != &kinds[3] ? "," : "");
	}
	std::puts("]");
}
