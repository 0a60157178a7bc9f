// SPDX-License-Identifier: GPL-2.0-or-later
// Samples of discs and of spheres under random increments: strain rates, jumps of ice saturation, flips, archives, rest.
#include "Dice.hpp"
#include "Report.hpp"
#include "StockSamples.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <pkg/rve/packed/PackedSamplePool.hpp>

using namespace talik;
using namespace talik::stability;
using namespace talik::validation;

namespace {

/// The sample of stock YADE with bonds, frozen in twenty parts.
template <int D> PackedState<D> frozen(double iceSaturation)
{
	PackedSample<D> sample(ofStock<D>());
	for (int k = 1; k <= 20; ++k) {
		sample.setIceSaturation(iceSaturation * k / 20);
		sample.advance(5);
	}
	return sample.state();
}

double                         sumOf(double value) { return value; }
template <class Vector> double sumOf(const Vector& v) { return v.sum(); }

template <int D> bool finite(const PackedState<D>& s)
{
	double sum = s.stress.sum() + s.hSize.sum() + s.trsf.sum();
	for (std::size_t g = 0; g < s.size(); ++g)
		sum += s.position[g].sum() + s.velocity[g].sum() + sumOf(s.angularVelocity[g]);
	for (const auto& shear : s.contacts.shear)
		sum += sumOf(shear);
	return std::isfinite(sum);
}

/// Norm of the deviator of the stress over the bound that contacts set it which only push, each within its friction: the sum of
/// l (n (x) n F_n + n (x) t F_t) cannot have a larger deviator than its terms together, l F_n sqrt(1 - 1/D + mu^2/2). In the plane shear over
/// pressure is at most sqrt(1 + mu^2).
template <int D> double stressOverBound(const typename PackedState<D>::Matrix& stress, double friction)
{
	using Matrix           = typename PackedState<D>::Matrix;
	const double pressure  = -stress.trace() / D;
	const Matrix symmetric = 0.5 * (stress + stress.transpose());
	return (symmetric + pressure * Matrix::Identity()).norm() / (D * pressure * std::sqrt(1.0 - 1.0 / D + 0.5 * friction * friction));
}

/// Stresses are those of forces and of branches a step later: grains that fly have turned by then.
constexpr double ratioLimit = 1.01;

/// Stiffness of a packing over the contact modulus, at least.
constexpr double softest = 0.05;

/// A sample drawn at random, with what has been found wrong with it.
template <int D> class RandomSample {
	using State  = PackedState<D>;
	using Matrix = typename State::Matrix;

public:
	explicit RandomSample(std::uint64_t seed)
	        : dice_(seed)
	{
		pool_.add(drawState());
	}

	void run()
	{
		const int updates = dice_.count("updates", 3, 10);
		for (int k = 0; k < updates && wrong_.empty(); ++k) {
			update(dice_.chance("archived", 0.3));
		}
		if (wrong_.empty()) rest();
	}

	const std::string& wrong() const { return wrong_; }
	std::string        described() const { return dice_.text(); }
	int                blownUp       = 0;
	double             gradientError = 0.0, ratioOverBound = 0.0; ///< largest

private:
	State drawState()
	{
		State s          = dice_.chance("frozen", 0.5) ? frozen<D>(dice_.between("Si", 0.06, 1.0)) : ofStock<D>();
		s.friction       = dice_.between("mu", 0.0, 1.5);
		s.stiffnessRatio = dice_.between("ks/kn", 0.0, 1.0);
		s.damping        = dice_.between("damping", 0.05, 0.9);
		s.dt *= dice_.decades("dt", 0.1, 1.0) * std::sqrt(s.ice.youngAt(0.0) / s.ice.youngAt(1.0));
		s.ice.tensileStrength = s.ice.shearStrength = dice_.decades("C0", 1.0, 1e7);
		s.ice.iceTensileStrength = s.ice.iceShearStrength = dice_.decades("C1", 1e3, 1e9);
		s.ice.bondRange                                   = dice_.between("range", 0.0, 0.2);
		if (dice_.chance("shrinks", 0.4)) s.thawStrain = { dice_.between("thawStrain", 0.0, 0.5), s.iceSaturation };
		return s;
	}

	double drawIce(double now)
	{
		const std::string how = dice_.oneOf<std::string>("ice", { "as it is", "as it is", "0", "1", "any", "near bonds" });
		if (how == "as it is") return now;
		if (how == "near bonds") return dice_.between("Si", 0.0, 0.1);
		return how == "any" ? dice_.between("Si", 0.0, 1.0) : std::stod(how);
	}

	/// One random increment; if archived, of a twin too that is made from bytes, and must follow to the last bit.
	void update(bool archived)
	{
		const double strain = dice_.decades("strain", 1e-8, 0.3);
		Matrix       increment;
		for (int k = 0; k < D * D; ++k)
			increment(k / D, k % D) = strain * dice_.uniform(-1.0, 1.0);
		PackedUpdateOptions options;
		options.steps               = dice_.chance("stepsGiven", 0.5) || strain > 3e-3 ? long(dice_.decades("steps", 1.0, 3000.0)) : 0;
		options.maxInertialNumber   = dice_.decades("I", 1e-3, 1.0);
		options.relaxSteps          = dice_.chance("relax", 0.3) ? 100 : 0;
		options.saturationIncrement = dice_.decades("dSi", 0.01, 1.0);
		options.stepsPerSaturation  = dice_.count("stepsPerSi", 0, 3);
		options.flipSkew            = dice_.chance("neverFlip", 0.2) ? 0.0 : dice_.between("skew", 0.05, 0.6);
		options.tangent             = dice_.chance("tangent", 0.2);
		const State   before        = pool_.state(0);
		const double  ice           = drawIce(before.iceSaturation);
		SamplePool<D> twin;
		if (archived) twin.add(throughBytes());
		const auto  result = ask(pool_, increment, ice, options);
		const State after  = pool_.state(0);
		if (!finite(after) || !result.stress.allFinite()) return note("not finite");
		if (archived) {
			ask(twin, increment, ice, options);
			if (twin.state(0).toBytes() != after.toBytes()) note("goes on otherwise from its archive");
		}
		if (result.blewUp) return judgeContainment(before, after, result.reason);
		const Matrix wanted = before.trsf + increment * before.trsf;
		gradientError       = std::max(gradientError, (after.trsf - wanted).norm() / wanted.norm());
		if (gradientError > 1e-9) note("deformation gradient is not that given");
		if (after.iceSaturation != ice) note("ice saturation is not that given");
		if (ice <= after.ice.meltSaturation && PackedSample<D>(after).statistics().bondsIntact > 0) note("bonds without ice");
		if (ice <= after.ice.meltSaturation) judgeFriction(result.stress, after);
		if (options.tangent)
			for (const double c : result.tangent)
				if (!std::isfinite(c)) note("tangent not finite");
	}

	/// Grains without bonds cannot pull, and carry no more shear than friction lets them.
	void judgeFriction(const Matrix& stress, const State& s)
	{
		const double pressure = -stress.trace() / D, noise = 1e-6 * s.ice.young;
		if (pressure < -noise) note("tension without bonds");
		if (pressure <= noise) return;
		ratioOverBound = std::max(ratioOverBound, stressOverBound<D>(stress, s.friction));
		if (ratioOverBound > ratioLimit) note("more shear than friction lets contacts carry");
	}

	void judgeContainment(const State& before, const State& after, const std::string& reason)
	{
		++blownUp;
		if (reason.empty()) note("blew up without a reason");
		if (after.toBytes() != before.toBytes()) note("is not as it was before it blew up");
	}

	std::shared_ptr<const CompactSample<D>> throughBytes() const
	{
		State          state;
		PackedLists<D> lists;
		const bool     listed = pool_.compact(0)->expand(state, lists);
		return std::make_shared<const CompactSample<D>>(State::fromBytes(state.toBytes()), listed ? &lists : nullptr);
	}

	static PackedUpdateResult<D> ask(SamplePool<D>& pool, const Matrix& increment, double ice, const PackedUpdateOptions& options)
	{
		return pool.update({ { 0, increment, ice } }, options, 1).front();
	}

	/// Left alone, grains gain no energy but what springs held: an arch that gives way sets free a part of it.
	void rest()
	{
		const State         start  = pool_.state(0);
		const double        stored = start.stress.squaredNorm() / (2.0 * softest * start.ice.young) * start.volume();
		PackedUpdateOptions options;
		options.relaxSteps = 1500;
		double kinetic[3];
		for (double& k : kinetic) {
			const State before = pool_.state(0);
			const auto  result = ask(pool_, Matrix::Zero(), before.iceSaturation, options);
			if (result.blewUp) return judgeContainment(before, pool_.state(0), result.reason); // thrown together, grains go on for a while
			k = PackedSample<D>(pool_.state(0)).statistics().kineticEnergy;
		}
		if (!finite(pool_.state(0))) note("not finite at rest");
		if (!(kinetic[2] <= 2.0 * std::max(kinetic[0], kinetic[1]) + stored + 1e-9)) note("gains energy at rest");
	}

	void note(const std::string& what) { wrong_ += " " + what + ";"; }

	Dice          dice_;
	SamplePool<D> pool_;
	std::string   wrong_;
};

template <int D> void search(const std::string& kind, std::uint64_t draws)
{
	citing("increments given; friction bounds the stress ratio");
	const std::uint64_t first  = firstSeed();
	int                 failed = 0, blownUp = 0;
	double              gradient = 0.0, ratio = 0.0;
	for (std::uint64_t seed = first; seed < first + draws; ++seed) {
		RandomSample<D> sample(seed);
		sample.run();
		blownUp += sample.blownUp > 0;
		gradient = std::max(gradient, sample.gradientError);
		ratio    = std::max(ratio, sample.ratioOverBound);
		if (sample.wrong().empty()) continue;
		++failed;
		ADD_FAILURE() << "seed " << seed << ":" << sample.wrong() << "\n  sample:" << sample.described();
	}
	std::printf(
	        "seeds %llu to %llu: %d of %llu samples blew up and were left as they were\n", static_cast<unsigned long long>(first),
	        static_cast<unsigned long long>(first + draws - 1), blownUp, static_cast<unsigned long long>(draws));
	const std::string name = "random increments of " + kind + ", " + std::to_string(draws) + " draws";
	expectSmall(name + ": samples that failed", failed, 0.0);
	expectSmall(name + ": deformation gradient less that given", gradient, 1e-9);
	expectSmall(name + ": deviator of the stress without bonds over what friction lets contacts carry", ratio, ratioLimit);
}

} // namespace

TEST(RandomSearch, EverySampleFollowsRandomIncrementsOrIsLeftAsItWasBeforeTheOneThatBlewItUp) { search<2>("samples", drawsAskedFor()); }

// a step of spheres takes several times that of discs: a quarter of the draws
TEST(RandomSearch, EverySampleOfSpheresFollowsRandomIncrementsOrIsLeftAsItWasBeforeTheOneThatBlewItUp)
{
	search<3>("samples of spheres", (drawsAskedFor() + 3) / 4);
}
