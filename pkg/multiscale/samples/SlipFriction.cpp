// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/ThreadPool.hpp>
#include <pkg/multiscale/samples/SlipFriction.hpp>
#include <pkg/rve/open/OpenSample.hpp>
#include <pkg/rve/packed/PackedWorkspace.hpp>
#include <pkg/rve/SimpleShear.hpp>

#include <cmath>
#include <exception>
#include <map>
#include <set>
#include <stdexcept>

namespace talik {

namespace {
	constexpr double      forgotten  = 0.15;               ///< shear after which the means no longer depend on how a sample was packed [-]
	constexpr double      leastShear = 0.3, mostShear = 1; ///< of one of eight runs [-]
	constexpr double      grainsTimesShear = 100;          ///< where that lies in between: the mean of as many grains over as much shear is equally sure
	constexpr std::size_t runsOfPacked = 8, runsOfOpen = 2;
	constexpr double      perCall     = 4e-5; ///< shear of a call [-]
	constexpr double      quasiStatic = 1e-3; ///< inertial number of packed samples [-]

	/// How one run moves its sample.
	struct Run {
		std::size_t source = 0;
		int         along = 0, across = 1;
		double      direction = 1;
	};
	template <int Dim> constexpr std::size_t differentRuns = Dim == 2 ? 4 : 8; ///< of one sample

	struct Outcome {
		double      friction = 0;
		std::string failure;
	};

	/// Runs that share a sample differ in their planes and directions, those of different samples in their directions only.
	template <int Dim> std::vector<Run> plan(std::size_t sources, std::size_t runs)
	{
		std::vector<Run> list;
		for (std::size_t r = 0; r < runs; ++r) {
			Run run;
			run.source              = r * sources / runs;
			const std::size_t first = (run.source * runs + sources - 1) / sources, variant = r - first;
			run.across    = Dim - 1 - int(variant / 2 % 2);
			run.along     = (run.across + 1 + int(variant / 4)) % Dim;
			run.direction = (sources > 1 ? r : variant) % 2 == 0 ? 1 : -1;
			list.push_back(run);
		}
		return list;
	}

	template <class Matrix> double heldPressure(const Matrix& stress)
	{
		const double own = -stress.trace() / double(stress.rows());
		return own >= 2e3 && own <= 50e3 ? own : 10e3;
	}

	/// Means of a run over what comes after the first shear.
	class Means {
	public:
		explicit Means(long callsLeftOut)
		        : left(callsLeftOut)
		{}
		void add(double shearStress, double normalStress)
		{
			if (left-- > 0) return;
			shear += shearStress;
			normal += normalStress;
		}
		double friction() const { return normal < 0 ? std::max(0., -shear / normal) : 0; }

	private:
		long   left;
		double shear = 0, normal = 0;
	};

	ShearPath pathOf(const Run& run, double shear, double ofCall)
	{
		ShearPath path;
		path.along   = run.along;
		path.across  = run.across;
		path.perCall = run.direction * ofCall;
		path.calls   = std::lround(shear / ofCall);
		return path;
	}

	template <int Dim> Outcome outcomeOfPacked(const PackedState<Dim>& state, const Run& run, double timesLonger)
	{
		PackedUpdateOptions options;
		options.maxInertialNumber = quasiStatic;
		const double shear        = std::min(mostShear, std::max(leastShear, grainsTimesShear / double(state.size())));
		ShearPath    path         = pathOf(run, timesLonger * shear, perCall);
		path.pressure             = heldPressure(state.stress);
		Means   means(std::lround(forgotten / perCall));
		Outcome outcome;
		outcome.failure = shearPacked<Dim>(
		        state, path, options, [&](double shearStress, double normalStress) { means.add(shearStress, normalStress); });
		outcome.friction = means.friction();
		return outcome;
	}

	/// At the speed that samples behind points have, which takes a tenth of the steps.
	template <int Dim> Outcome outcomeOfOpen(const std::string& scene, const Run& run)
	{
		constexpr double ofCall = 1e-4;
		forbidRedirection();
		OpenSample sample(scene);
		ShearPath  path = pathOf(run, leastShear, ofCall);
		path.pressure   = heldPressure(sample.stress().topLeftCorner<Dim, Dim>());
		path.stiffness  = stiffnessAcross<3>(sample.tangent(), path);
		Means   means(std::lround(forgotten / ofCall));
		Outcome outcome;
		outcome.failure = shearSample<Dim>(
		        path, sample.stress().topLeftCorner<Dim, Dim>(),
		        [&](const auto& gradient) {
			        Eigen::Matrix3d inSpace                    = Eigen::Matrix3d::Zero();
			        inSpace.template topLeftCorner<Dim, Dim>() = gradient;
			        const auto              all                = sample.apply(inSpace, 0);
			        PackedUpdateResult<Dim> result;
			        result.stress = all.stress.template topLeftCorner<Dim, Dim>();
			        result.blewUp = all.blewUp;
			        result.reason = all.reason;
			        return result;
		        },
		        [&](double shearStress, double normalStress) { means.add(shearStress, normalStress); });
		outcome.friction = means.friction();
		return outcome;
	}

	SteadyFriction summed(const std::vector<Outcome>& outcomes)
	{
		SteadyFriction found;
		double         sum = 0, squares = 0, count = 0;
		std::string    reason;
		for (const auto& outcome : outcomes) {
			if (!outcome.failure.empty()) {
				reason = outcome.failure;
				continue;
			}
			sum += outcome.friction;
			squares += outcome.friction * outcome.friction;
			++count;
		}
		if (2 * count < double(outcomes.size())) throw std::runtime_error(reason);
		found.mean  = sum / count;
		found.error = count > 1 ? std::sqrt(std::max(0., squares / count - found.mean * found.mean) / (count - 1)) : 0;
		return found;
	}

	template <int Dim> SteadyFriction measured(const std::vector<ShearedSource<Dim>>& sources, int threads)
	{
		const bool anyOpen = std::any_of(sources.begin(), sources.end(), [](const auto& source) { return !source.packed; });
		const auto runs    = plan<Dim>(sources.size(), anyOpen ? runsOfOpen : std::min(runsOfPacked, differentRuns<Dim> * sources.size()));

		std::vector<Outcome>            outcomes(runs.size());
		std::vector<std::exception_ptr> failures(runs.size());
		const auto                      shear = [&](std::size_t r) {
                        const auto& source = sources[runs[r].source];
                        try {
                                outcomes[r] = source.packed ? outcomeOfPacked<Dim>(*source.packed, runs[r], double(runsOfPacked) / double(runs.size()))
				                                                 : outcomeOfOpen<Dim>(source.scene, runs[r]);
                        } catch (...) {
                                failures[r] = std::current_exception();
                        }
		};
		// scenes are made by one thread: YADE's constructors ask the system for names
		const int workers = anyOpen ? 1 : std::max(1, std::min(threads > 0 ? threads : ThreadPool::threads(), int(runs.size())));
		ThreadPool::run(int(runs.size()), workers, [&](int r, int) { shear(std::size_t(r)); });
		for (const auto& failure : failures)
			if (failure) std::rethrow_exception(failure);

		SteadyFriction        found = summed(outcomes);
		std::set<std::size_t> sheared;
		for (const auto& run : runs)
			sheared.insert(run.source);
		found.samples = int(sheared.size());
		return found;
	}

	template <int Dim> std::size_t digestOf(const std::vector<ShearedSource<Dim>>& sources)
	{
		std::string all;
		for (const auto& source : sources)
			all += std::to_string(std::hash<std::string>()(source.packed ? source.packed->toBytes() : source.scene)) + " ";
		return std::hash<std::string>()(all);
	}
} // namespace

/// Scenes that a script makes again and again from the same samples measure them once.
template <int Dim> SteadyFriction steadyFriction(const std::vector<ShearedSource<Dim>>& sources, int threads)
{
	static std::map<std::pair<std::size_t, int>, SteadyFriction> known;
	const std::pair<std::size_t, int>                            key { digestOf<Dim>(sources), threads };
	const auto                                                   before = known.find(key);
	if (before == known.end()) return known[key] = measured<Dim>(sources, threads);
	return before->second;
}

template SteadyFriction steadyFriction<2>(const std::vector<ShearedSource<2>>&, int);
template SteadyFriction steadyFriction<3>(const std::vector<ShearedSource<3>>&, int);

} // namespace talik
