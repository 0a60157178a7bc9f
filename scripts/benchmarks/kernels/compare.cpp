// SPDX-License-Identifier: GPL-2.0-or-later
// Two versions of the packed samples in turn: processor time of this thread, ratio of neighbours in time.
// usage  compare <packed_reference.txt> [rounds]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

extern "C" {
void   former_prepare(const char* file, bool frozen);
void   present_prepare(const char* file, bool frozen);
double former_run(long steps);
double present_run(long steps);
}

namespace {

double processorTime()
{
	timespec now;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

double timeOf(double (*run)(long), double& pressure)
{
	const double start = processorTime();
	pressure           = run(2000);
	return processorTime() - start;
}

} // namespace

int main(int argc, char** argv)
{
	if (argc < 2) return std::fprintf(stderr, "usage: compare <packed_reference.txt> [rounds]\n"), 2;
	const int rounds = argc > 2 ? std::atoi(argv[2]) : 60;
	bool      alike  = true;
	for (const bool frozen : { false, true }) {
		former_prepare(argv[1], frozen);
		present_prepare(argv[1], frozen);
		std::vector<double> ratios;
		double              before = 0, now = 0;
		for (int round = 0; round < rounds; ++round) {
			double former = 0, present = 0;
			if (round % 2) former = timeOf(former_run, before);
			present = timeOf(present_run, now);
			if (round % 2 == 0) former = timeOf(former_run, before);
			ratios.push_back(present / former);
		}
		std::sort(ratios.begin(), ratios.end());
		const auto part = [&](double share) { return ratios[std::size_t(share * double(ratios.size() - 1))]; };
		std::printf(
		        "%s: time now over before %.3f (quartiles %.3f and %.3f); pressure %.17g and %.17g Pa\n", frozen ? "frozen" : "frictional", part(0.5),
		        part(0.25), part(0.75), now, before);
		alike = alike && now == before;
	}
	if (!alike) std::puts("the two versions do not give the same bits: they do not do the same work");
	return alike ? 0 : 1;
}
