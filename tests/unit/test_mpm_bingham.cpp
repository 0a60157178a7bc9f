// SPDX-License-Identifier: GPL-2.0-or-later
// The Bingham law, and what a law sees of time.
#include "lawElement.hpp"
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/skeleton/BinghamSkeleton.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/ShearStress.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

using namespace talik;

namespace {

BinghamSkeleton<2> mud()
{
	BinghamSkeleton<2> m;
	m.young       = 2.6e6; // G = 1 MPa
	m.poisson     = 0.3;
	m.yieldStress = 800.0;
	m.viscosity   = 50.0;
	return m;
}

/// Elastic, and writes down what it sees.
template <int D> struct Listening final : SkeletonModel<D> {
	ElasticSkeleton<D>                elastic;
	StepTime                          time;
	std::array<double, stressSize<D>> rate {};
	double                            shear  = 0.0;
	int                               inside = D == 2 ? 78 : 942; ///< in the middle of the body

	std::string name() const override { return "Listening"; }
	void        updateStress(const SkeletonBatch<D>& batch) override
	{
		time = batch.time;
		for (int k = 0; k < batch.count; ++k)
			if (batch.id[batch.place[k]] == inside) {
				rate  = strainRate(batch, batch.place[k]);
				shear = shearRate(batch, batch.place[k]);
			}
		elastic.updateStress(batch);
	}
	void tangentModulus(const SkeletonBatch<D>& batch, double* modulus) const override { elastic.tangentModulus(batch, modulus); }
};

/// A body without weight that is sheared: v_x = rate y, and heat whose calendar runs fast.
template <int D> std::shared_ptr<Listening<D>> shearBody(double rate, double scale, double step)
{
	auto              law = std::make_shared<Listening<D>>();
	GroundSettings<D> s;
	s.gridSpacing = 0.25;
	for (int a = 0; a < D; ++a)
		s.upper[a] = 3.0;
	s.motion.emplace();
	s.heat.emplace();
	s.heat->thermalTimeScale = scale;
	s.skeletons.push_back(law);
	Ground<D>     ground(s);
	PointInput<D> point;
	point.volume = std::pow(0.125, D);
	for (int k = 0; k < (D == 2 ? 144 : 1728); ++k) {
		const int along[3] = { k % 12, k / 12 % 12, k / 144 };
		for (int a = 0; a < D; ++a)
			point.position[a] = 0.8125 + 0.125 * along[a];
		point.velocity[0] = rate * (point.position[1] - 1.5);
		ground.addPoint(point);
	}
	ground.initialise();
	ground.step(step);
	return law;
}

template <int D> void seesBothTimesAndTheRate()
{
	const double step = 1e-4, rate = 0.3, scale = 500.0;
	const auto   law   = shearBody<D>(rate, scale, step);
	double       worst = 0.0;
	for (int i = 0; i < D; ++i)
		for (int j = i; j < D; ++j)
			worst = std::max(worst, std::abs(law->rate[stressIndex<D>(i, j)] - (i == 0 && j == 1 ? 0.5 * rate : 0.0)));
	std::printf(
	        "%d dimensions: rate of strain off by %.1e of %.2g 1/s (tolerance 1e-4); times %.17g and %.17g s\n", D, worst / rate, rate, law->time.motion,
	        law->time.calendar);
	EXPECT_NEAR(law->shear / rate, 1.0, 1e-4);
	EXPECT_LT(worst / rate, 1e-4); // the midpoint rotation turns simple shear by rate x step
	EXPECT_EQ(law->time.motion, step);
	EXPECT_DOUBLE_EQ(law->time.calendar, scale * step);
}

} // namespace

TEST(MpmSkeletonBatch, ALawSeesTheTimesOfMotionAndOfTheCalendarAndTheRateOfStrain)
{
	seesBothTimesAndTheRate<2>();
	seesBothTimesAndTheRate<3>();
}

TEST(MpmBinghamSkeleton, SteadyShearHasTheStressOfABinghamFluidWhateverTheStep)
{
	double worst = 0.0;
	for (const double rate : { 0.1, 2.0, 20.0 })
		for (const double step : { 1e-6, 1e-5, 1e-4 }) {
			auto       model = mud();
			Element<2> element;
			element.time        = step;
			element.gradient[1] = rate * step;
			const double passed = 40.0 * (model.viscosity / 1e6 + step) + (model.yieldStress / 1e6) / rate;
			for (double t = 0.0; t < passed; t += step)
				element.step(model);
			const double expected = model.yieldStress + model.viscosity * rate;
			worst                 = std::max(worst, std::abs(element.stress[3] / expected - 1.0));
		}
	std::printf("largest error of the shear stress %.1e (tolerance 1e-5, (tau/G)^2 and more)\n", worst);
	EXPECT_LT(worst, 1e-5);
}

TEST(MpmBinghamSkeleton, OverstressRelaxesExponentiallyToTheYieldStressAndTheMeanStays)
{
	const auto   law    = mud();
	const double time   = law.viscosity / 1e6; // mu/G
	double       former = 0.0;
	for (const int steps : { 50, 100, 200 }) {
		auto       model = law;
		Element<2> element;
		element.stress[0] = element.stress[1] = element.stress[2] = -7e3;
		element.stress[3]                                         = 5e3;
		element.time                                              = time / steps;
		for (int k = 0; k < steps; ++k)
			element.step(model);
		const double expected = law.yieldStress + (5e3 - law.yieldStress) * std::exp(-1.0);
		const double error    = element.stress[3] / expected - 1.0;
		std::printf(
		        "%d steps: %.1f Pa, closed form %.1f Pa, error %.2e; over that of half as many steps %.3f\n", steps, element.stress[3], expected, error,
		        error / former);
		if (former > 0.0) {
			EXPECT_NEAR(error / former, 0.5, 0.02);
		}
		former = error;
		EXPECT_NEAR(element.stress[0], -7e3, 1e-9);
		EXPECT_NEAR(element.stress[2], -7e3, 1e-9);
	}
	EXPECT_LT(former, 2e-3);
}

TEST(MpmBinghamSkeleton, UpToTheYieldStressGroundIsElasticToTheLastBit)
{
	auto               model = mud();
	ElasticSkeleton<2> elastic;
	elastic.young   = model.young;
	elastic.poisson = model.poisson;
	Element<2> flowing, reference;
	flowing.time = reference.time = 1e-3;
	for (auto* element : { &flowing, &reference }) {
		element->gradient[1] = 1e-4;
		element->gradient[3] = -1e-5;
	}
	for (int k = 0; k < 7; ++k) { // 700 Pa
		flowing.step(model);
		reference.step(elastic);
	}
	for (int c = 0; c < 3; ++c)
		EXPECT_EQ(flowing.stress[c], reference.stress[c]);
}

TEST(MpmBinghamSkeleton, IceRaisesTheYieldStressInProportion)
{
	auto model = mud();
	for (const double ice : { 0.0, 0.25, 1.0 }) {
		Element<2> element;
		element.ice       = ice;
		element.time      = 1e3;
		element.stress[3] = 1e6;
		element.step(model);
		const double expected = 800.0 + (500e3 - 800.0) * ice;
		EXPECT_NEAR(element.stress[3] / expected, 1.0, 1e-4);
		EXPECT_EQ(model.shearStrength(ice)->cohesion, expected);
		EXPECT_EQ(model.shearStrength(ice)->friction, 0.0);
	}
}

TEST(MpmBinghamSkeleton, BadParametersAreNamed)
{
	const auto message = [](double BinghamSkeleton<2>::*attribute, double value) -> std::string {
		auto model       = mud();
		model.*attribute = value;
		try {
			model.validate();
		} catch (const std::invalid_argument& error) {
			return error.what();
		}
		return "no exception";
	};
	using Law                                                    = BinghamSkeleton<2>;
	const std::tuple<double Law::*, double, const char*> wrong[] = {
		{ &Law::young, 0.0, "BinghamSkeleton.young = 0: must be positive" },
		{ &Law::poisson, 0.5, "BinghamSkeleton.poisson = 0.5: must lie in" },
		{ &Law::yieldStress, -1.0, "BinghamSkeleton.yieldStress = -1: must be finite and not negative" },
		{ &Law::yieldStress, INFINITY, "BinghamSkeleton.yieldStress = inf" },
		{ &Law::yieldStressFrozen, 700.0, "BinghamSkeleton.yieldStressFrozen = 700: must be finite and at least yieldStress" },
		{ &Law::viscosity, 0.0, "BinghamSkeleton.viscosity = 0: must be positive" },
		{ &Law::viscosity, NAN, "BinghamSkeleton.viscosity = nan" },
	};
	for (const auto& [attribute, value, sentence] : wrong)
		EXPECT_NE(message(attribute, value).find(sentence), std::string::npos) << sentence << " is missing in: " << message(attribute, value);
}
