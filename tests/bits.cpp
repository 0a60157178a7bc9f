// SPDX-License-Identifier: GPL-2.0-or-later
// Hashes of all that small slopes are made of after some steps, by way of computing them; tests/bits.py compares those of two builds.
//   talik_bits [--steps N] [--only PART OF A NAME]
#include <slopeScenes.hpp>

#include <omp.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

using namespace talik;

namespace {

/// FNV-1a over the bytes of numbers.
std::uint64_t hashOf(const double* numbers, std::size_t count)
{
	std::uint64_t hash  = 14695981039346656037ull;
	const auto*   bytes = reinterpret_cast<const unsigned char*>(numbers);
	for (std::size_t k = 0; k < count * sizeof(double); ++k)
		hash = (hash ^ bytes[k]) * 1099511628211ull;
	return hash;
}

/// What is told of a ground: lines of scene, way, name and hash.
template <int D> class Report {
public:
	Report(const Scene& scene, std::string way)
	        : begin_(std::string(D == 2 ? "plane" : "space") + ", " + scene.name + " | " + std::move(way) + " | ")
	{}
	void add(const std::string& name, const std::vector<double>& numbers)
	{
		std::printf("%s%s | %016llx\n", begin_.c_str(), name.c_str(), static_cast<unsigned long long>(hashOf(numbers.data(), numbers.size())));
	}
	void addFields(Ground<D>& ground)
	{
		for (const FieldInfo& field : ground.pointFields().list()) {
			const std::size_t   points = ground.points().count();
			std::vector<double> numbers(points * field.components);
			for (int c = 0; c < field.components; ++c)
				ground.copyById(field.name, c, numbers.data() + c * points);
			add(field.name, numbers);
		}
		std::vector<double> bodies;
		if (ground.bodies())
			for (const double impulse : ground.bodies()->bodies[0].impulse)
				bodies.push_back(impulse);
		add("impulse of bodies", bodies);
	}
	void addBalance(const Balance<D>& b, const CalendarState& calendar)
	{
		add("balance of mass", { b.solidMass, b.waterMass, b.iceMass, b.waterOut, b.waterDrawn });
		add("balance of heat", { b.enthalpy, b.heatIn, b.enthalpyOut });
		std::vector<double> motion(b.momentum.begin(), b.momentum.end());
		motion.insert(motion.end(), b.impulse.begin(), b.impulse.end());
		add("balance of momentum", motion);
		add("balance of energy", { b.kineticEnergy, b.gravityEnergy, b.skeletonWork, b.porePressureWork, b.workAhead, b.dragDissipation });
		add("dissipation and works", { b.dampingDissipation, b.loadWork, b.slipWork, b.wallWork, b.segregationWork });
		add("time", { b.time, calendar.time, calendar.scale, calendar.speed });
	}

private:
	std::string begin_;
};

/// The balances in mid-run belong to it, too.
template <int D> void tell(const Scene& scene, const std::string& way, Ground<D>& ground, const std::vector<double>& limits)
{
	Report<D> report(scene, way);
	report.addFields(ground);
	report.addBalance(ground.balance(), ground.calendar());
	report.add("time step limits", limits);
}

template <int D> void march(Ground<D>& ground, int steps, std::vector<double>& limits)
{
	for (int k = 0; k < steps; ++k) {
		if (k % 20 == 0)
			for (const TimeStepLimit& limit : ground.stableTimeStep().limits)
				limits.push_back(limit.step);
		ground.step(2e-4);
	}
}

template <int D> void onThreads(const Scene& scene, int steps, int threads)
{
	omp_set_num_threads(threads);
	const auto          ground = slope<D>(scene, nullptr);
	std::vector<double> limits;
	march(*ground, steps, limits);
	tell<D>(scene, threads == 1 ? "one thread" : "threads", *ground, limits);
	omp_set_num_threads(1);
}

template <int D> void onTwoRanks(const Scene& scene, int steps)
{
	asRanks(2, [&](const std::shared_ptr<Communicator>& communicator) {
		const auto          ground = slope<D>(scene, communicator);
		std::vector<double> limits;
		march(*ground, steps, limits);
		if (communicator->rank() == 0) tell<D>(scene, "two ranks", *ground, limits);
		communicator->meet("it is told"); // the others answer it until then
	});
}

/// Its state goes over into a second ground half way.
template <int D> void throughCheckpoint(const Scene& scene, int steps)
{
	const auto          first = slope<D>(scene, nullptr), second = slope<D>(scene, nullptr);
	std::vector<double> limits;
	const int           half = steps / 40 * 20;
	march(*first, half, limits);
	const auto  kept = copyOf(first->state());
	std::size_t k    = 0;
	second->repeatDivisions(first->divisions());
	for (const StateArray& array : second->state())
		std::copy(kept[k].begin(), kept[k].end(), static_cast<char*>(array.data)), ++k;
	second->stateRestored();
	if (second->bodies()) second->bodies()->bodies = first->bodies()->bodies;
	march(*second, steps - half, limits);
	tell<D>(scene, "checkpoint", *second, limits);
}

template <int D> void allWays(const Scene& scene, int steps)
{
	onThreads<D>(scene, steps, 1);
	onThreads<D>(scene, steps, 3);
	throughCheckpoint<D>(scene, steps);
	if (!scene.periodic) onTwoRanks<D>(scene, steps); // ranks refuse such sides
	std::fflush(stdout);
}

} // namespace

int main(int count, char** words)
{
	int         steps = 220; // points are sorted anew after 200
	std::string only;
	for (int k = 1; k + 1 < count; k += 2) {
		if (std::string(words[k]) == "--steps") steps = std::atoi(words[k + 1]);
		if (std::string(words[k]) == "--only") only = words[k + 1];
	}
	Scene tpic = wet, implicit = wet;
	tpic.name = "water, tpic", tpic.transfer = VelocityTransfer::tpic;
	implicit.name = "water, implicit pressure", implicit.implicit = true;
	const Scene endless         = withoutEnds(iceRichWet, "all, thaw strain, periodic sides"),
	            endlessImplicit = withoutEnds(allImplicit, "all, implicit, periodic sides");
	for (const Scene& scene : { dryApic, tpic, implicit, warm, frozen, aroundAxis, allOwn, withWalls, withBall, iceRichWet, heaving, dividing,
	                            fillingImplicit, endless, endlessImplicit })
		if (("plane, " + std::string(scene.name)).find(only) != std::string::npos) allWays<2>(scene, steps);
	for (const Scene& scene : { dryApic, frozen, withWalls, withBall, iceRichWet, heaving, dividing })
		if (("space, " + std::string(scene.name)).find(only) != std::string::npos) allWays<3>(scene, steps / 4);
	return 0;
}
