// SPDX-License-Identifier: GPL-2.0-or-later
#include "packedPair.hpp"
#include <algorithm>
#include <cstdio>
#include <gtest/gtest.h>
#include <map>
#include <pkg/icebond/BondTable.hpp>
#include <random>

using namespace talik;
using packedPair::State;

namespace {

/// Closed form of one bond between equal discs of 5 mm: E 0.6 + 3 phi GPa, C 1 + 50 phi MPa, k_s/k_n 0.8, mu 0.5, bond area R^2.
struct StrengthRow {
	double iceSaturation, normalForceAtBreak, overlapAtBreak, shearPeak0, slipPeak0, shearPeak100, slipPeak100, residual100;
};
constexpr StrengthRow strengthTable[] = {
	{ 1.0, -1275, -7.083333333333334e-05, 1275, 8.854166666666667e-05, 1325, 9.201388888888889e-05, 50 },
	{ 0.5, -571.875, -5.980392156862745e-05, 571.875, 7.475490196078431e-05, 621.875, 8.129084967320261e-05, 50 },
	{ 0.2, -123, -2.945402298850575e-05, 123, 3.6817528735632185e-05, 173, 5.178400383141762e-05, 50 },
	{ 0.05, -31.2421875, -1.0160370743010457e-05, 31.2421875, 1.2700463428763072e-05, 81.2421875, 3.3026286370519426e-05, 50 },
};

double stiffness(double iceSaturation) { return IceBondModel().youngAt(iceSaturation) * packedPair::radius; }

} // namespace

TEST(PackedBond, breaksInTensionAtTheClosedForm)
{
	for (const StrengthRow& row : strengthTable) {
		const State below = packedPair::step(packedPair::bonded(0, row.iceSaturation), row.overlapAtBreak * (1 - 1e-10), 0);
		const State above = packedPair::step(packedPair::bonded(0, row.iceSaturation), row.overlapAtBreak * (1 + 1e-10), 0);
		std::printf("S_i %.2f: force at break %.9g N, closed form %.9g N\n", row.iceSaturation, packedPair::normalForce(below), row.normalForceAtBreak);
		EXPECT_TRUE(packedPair::intact(below));
		EXPECT_NEAR(packedPair::normalForce(below), row.normalForceAtBreak, 2e-10 * std::fabs(row.normalForceAtBreak));
		EXPECT_FALSE(packedPair::intact(above));
		EXPECT_EQ(packedPair::normalForce(above), 0);
		EXPECT_EQ(above.bondsBrokenInTension, 1u);
	}
}

TEST(PackedBond, breaksInShearAtTheClosedForm)
{
	for (const StrengthRow& row : strengthTable)
		for (const bool loaded : { false, true }) {
			const double overlap = loaded ? 100 / stiffness(row.iceSaturation) : 0.;
			const double slip = loaded ? row.slipPeak100 : row.slipPeak0, peak = loaded ? row.shearPeak100 : row.shearPeak0;
			const State  below = packedPair::step(packedPair::bonded(0, row.iceSaturation), overlap, slip * (1 - 1e-10));
			const State  above = packedPair::step(packedPair::bonded(0, row.iceSaturation), overlap, slip * (1 + 1e-10));
			std::printf(
			        "S_i %.2f, N = %3.0f N: shear peak %.9g N, closed form %.9g N, residual %.9g N\n", row.iceSaturation, loaded ? 100. : 0.,
			        packedPair::shearForce(below), peak, packedPair::shearForce(above));
			EXPECT_TRUE(packedPair::intact(below));
			EXPECT_NEAR(packedPair::shearForce(below), peak, 2e-10 * peak);
			EXPECT_FALSE(packedPair::intact(above));
			EXPECT_NEAR(packedPair::shearForce(above), loaded ? row.residual100 : 0., 1e-8);
			EXPECT_EQ(above.bondsBrokenInShear, 1u);
		}
}

TEST(PackedBond, thatAddsStrengthButNoStiffnessBreaksToo)
{
	for (const bool portable : { false, true }) {
		PackedSample<2>::forcePortable(portable);
		State cemented        = packedPair::bonded(0, 0.5);
		cemented.ice.iceYoung = 0;
		const double slip = 571.875 / (0.8 * 3e6), gap = 571.875 / 3e6;
		EXPECT_TRUE(packedPair::intact(packedPair::step(cemented, 0, slip * (1 - 1e-10))));
		EXPECT_FALSE(packedPair::intact(packedPair::step(cemented, 0, slip * (1 + 1e-10))));
		EXPECT_TRUE(packedPair::intact(packedPair::step(cemented, -gap * (1 - 1e-10), 0)));
		EXPECT_FALSE(packedPair::intact(packedPair::step(cemented, -gap * (1 + 1e-10), 0)));
		cemented.ice.tensileStrength = cemented.ice.iceTensileStrength = 0;
		EXPECT_TRUE(packedPair::intact(packedPair::step(cemented, 1e-9, 0)));
		EXPECT_FALSE(packedPair::intact(packedPair::step(cemented, -1e-9, 0)));
	}
	PackedSample<2>::forcePortable(false);
}

namespace {

/// The pair at another ice saturation, moved to where its springs carry the load again.
State loadedAt(const State& start, double iceSaturation, double normal, double shear)
{
	PackedSample<2> sample(start);
	sample.setIceSaturation(iceSaturation);
	State        s     = sample.state();
	const double grain = stiffness(0), ice = stiffness(iceSaturation) - grain;
	const double overlap = (normal + grain * s.contacts.grainReference[0] + ice * s.contacts.iceReference[0]) / (grain + ice);
	return packedPair::step(s, overlap, (shear - packedPair::shearForce(s)) / (0.8 * (grain + ice)));
}

} // namespace

TEST(PackedBond, meltsToFailureUnderConstantLoadAtTheClosedForm)
{
	struct {
		double tension, shear, normal, iceSaturationAtBreak;
	} const rows[] = { { 100, 0, 0, 0.1745394755255505 },
		           { 500, 0, 0, 0.46108482147953955 },
		           { 1000, 0, 0, 0.7286689399292775 },
		           { 0, 500, 100, 0.4331237231281657 },
		           { 0, 500, 500, 0.307345873872187 } };
	for (const auto& row : rows) {
		const double start = 0.9, k = stiffness(start), above = row.iceSaturationAtBreak * (1 + 1e-8), below = row.iceSaturationAtBreak * (1 - 1e-8);
		const State  loaded = packedPair::step(packedPair::bonded(0, start), (row.normal - row.tension) / k, row.shear / (0.8 * k));
		const State  before = loadedAt(loaded, above, row.normal - row.tension, row.shear);
		const State  after  = loadedAt(before, below, row.normal - row.tension, row.shear);
		std::printf(
		        "T = %4.0f V = %3.0f N = %3.0f N: intact just above S_i = %.9f, broken just below\n", row.tension, row.shear, row.normal,
		        row.iceSaturationAtBreak);
		EXPECT_TRUE(packedPair::intact(before));
		EXPECT_NEAR(packedPair::normalForce(before), row.normal - row.tension, 1e-8);
		EXPECT_FALSE(packedPair::intact(after));
	}
}

TEST(PackedBond, meltingAtFixedOverlapDropsTheShareOfTheIceAtTheClosedForm)
{
	const double    saturations[] = { 1.0, 0.9, 0.8, 0.6, 0.5, 0.4, 0.2 }, expected[] = { 12, 11.72925, 11.028, 8.928, 7.78125, 6.708, 5.088 };
	PackedSample<2> sample(packedPair::make(1e-6, 0));
	sample.advance(1);
	EXPECT_NEAR(packedPair::normalForce(sample.state()), 3, 3e-10);
	sample.setIceSaturation(1);
	sample.advance(1);
	EXPECT_NEAR(packedPair::normalForce(sample.state()), 3, 1e-9) << "freezing at fixed overlap";
	State squeezed          = sample.state();
	squeezed.position[1][0] = squeezed.position[0][0] + 2 * packedPair::radius - 1.5e-6;
	sample.setState(squeezed);
	for (int k = 0; k < 7; ++k) {
		sample.setIceSaturation(saturations[k]);
		sample.advance(1);
		const double force = packedPair::normalForce(sample.state());
		std::printf("S_i %.1f: F = %.10g N, closed form %.10g N\n", saturations[k], force, expected[k]);
		EXPECT_NEAR(force, expected[k], 1e-10 * expected[k]);
	}
	sample.setIceSaturation(0);
	sample.advance(1);
	EXPECT_NEAR(packedPair::normalForce(sample.state()), 4.5, 1e-9) << "melted: the grain contact alone";
	EXPECT_FALSE(sample.state().bonded());
}

TEST(PackedBond, saturationTablesFollowThePublishedFormulas)
{
	const IceBondModel m;
	EXPECT_NEAR(m.phi(0.5), 0.4375, 1e-15);
	EXPECT_NEAR(m.youngAt(0.5), 1.9125e9, 1e-3);
	EXPECT_NEAR(m.tensileStrengthAt(0.5), 22.875e6, 1e-6);
	EXPECT_NEAR(m.youngAt(0.8), 3.2112e9, 1e-3);
	EXPECT_NEAR(m.shearStrengthAt(0.8), 44.52e6, 1e-6);
	EXPECT_NEAR(equivalentRadiusRatio(0.18, 0, 1, 2), 1.104315261, 1e-9);
	EXPECT_NEAR(equivalentRadiusRatio(0.18, 0, 1, 3), 1.068387297, 1e-9);
	EXPECT_NEAR(equivalentRadiusRatio(0.4, -0.02, 0.5, 2), 1.147460965, 1e-9);
	std::printf(
	        "phi(0.5) = %.15g (0.4375), E = %.9g Pa, C = %.9g Pa, r/r_0 at S_i = 1, n_0 = 0.18: %.9f (1.104315261)\n", m.phi(0.5), m.youngAt(0.5),
	        m.tensileStrengthAt(0.5), equivalentRadiusRatio(0.18, 0, 1, 2));
}

namespace {

/// The contact law written down sentence by sentence, one contact, parallel rule: the referee of the random walk below.
struct WrittenLaw {
	IceBondModel m;
	double       kg = 3e6, nu = 0.8, mu = 0.5, area = 25e-6, saturation = 0;
	enum { none, bonded, broken } state = none;
	bool   cut                          = false;
	double s = 0, sIce = 0, uIce = 0, uGrain = 0, force = 0;
	int    tension = 0, shear = 0;

	double kIce(double at) const { return kg * m.iceStiffnessRatio(at); }
	void   forget() { state = none, cut = false, sIce = uIce = uGrain = 0; }

	void change(double to, double un)
	{
		const double before = kIce(saturation), after = kIce(to);
		const bool   spring = state == bonded || (state == broken && !cut);
		if (to <= m.meltSaturation) {
			if (state != none) {
				s -= sIce;
				forget();
			}
		} else if (spring && after >= before) {
			uIce = un - before / after * (un - uIce);
		} else if (spring) {
			s -= sIce * (1 - after / before);
			sIce *= after / before;
		}
		if (m.formsBonds(saturation, to) && state == none && un >= -m.bondRange * packedPair::radius) {
			state = bonded, cut = false;
			uIce = un, uGrain = un >= 0 ? 0 : un, sIce = 0;
		}
		saturation = to;
	}

	void limit(double cap)
	{
		if (std::fabs(s) <= cap) return;
		const double factor = cap / std::fabs(s);
		s *= factor, sIce *= factor;
	}

	void evaluate(double un, double slip)
	{
		const double ki = kIce(saturation);
		force           = 0;
		if (state != bonded && un < 0) {
			forget();
			s = 0;
			return;
		}
		if (state == bonded) {
			force = kg * (un - uGrain) + ki * (un - uIce);
			s += nu * (kg + ki) * slip, sIce += nu * ki * slip;
			if (force < -m.tensileStrengthAt(saturation) * area) {
				++tension;
				force = s = sIce = 0;
				state = broken, cut = true;
				if (un <= 0) forget();
			} else if (std::fabs(s) > m.shearStrengthAt(saturation) * area + mu * std::max(force, 0.)) {
				++shear;
				const double fi = ki * std::max(un - uIce, 0.), fg = kg * std::max(un, 0.);
				force = fi + fg, uGrain = 0, state = broken, cut = fi == 0;
				limit(mu * force);
				if (cut) sIce = 0;
				if (un < 0) { // nothing holds or pushes across a gap
					force = s = 0;
					forget();
				}
			}
			return;
		}
		if (state == broken && !cut && un <= uIce) cut = true, sIce = 0;
		const double ice = state == broken && !cut ? ki : 0;
		force            = kg * un + ice * (un - uIce);
		s += nu * (kg + ice) * slip, sIce += nu * ice * slip;
		limit(mu * force);
	}
};

void walk(bool portable)
{
	PackedSample<2>::forcePortable(portable);
	std::mt19937                           random(7);
	std::uniform_real_distribution<double> uniform(-1, 1);
	int                                    failures[2] = { 0, 0 }, bondsSeen = 0, uncutSeen = 0;
	double                                 worst = 0;
	for (int path = 0; path < 200; ++path) {
		WrittenLaw      law;
		PackedSample<2> sample(packedPair::make(1e-5 * uniform(random), 0));
		for (int segment = 0; segment < 60; ++segment) {
			if (segment % 3 == 0) {
				const double to = segment % 15 == 0 ? 0.5 * (1 + uniform(random))
				                                    : std::min(1., std::max(0., law.saturation + 0.1 * uniform(random)));
				law.change(to, packedPair::overlap(sample.state()));
				sample.setIceSaturation(to);
			}
			State        s    = sample.state();
			const double un   = packedPair::overlap(s);
			const double slip = 4e-6 * uniform(random) * (uniform(random) > 0.5 ? 10 : 1);
			s.velocity[1][0]  = (3e-6 * uniform(random) * (uniform(random) > 0.3 ? 4 : 1) + 0.08 * un) / s.dt;
			packedPair::setSlip(s, slip);
			sample.setState(s);
			for (int k = 0; k < 5; ++k) {
				law.evaluate(packedPair::overlap(sample.state()), slip);

				sample.advance(1);
				const State  now   = sample.state();
				const double force = -now.stress(0, 0) * now.volume() / (now.position[1] - now.position[0]).norm();
				worst              = std::max({ worst, std::fabs(force - law.force), std::fabs(packedPair::shearForce(now) - law.s) });
				ASSERT_NEAR(force, law.force, 1e-7) << "path " << path << " segment " << segment;
				ASSERT_NEAR(packedPair::shearForce(now), law.s, 1e-7) << "path " << path << " segment " << segment;
				ASSERT_EQ(packedPair::intact(now), law.state == WrittenLaw::bonded);
				bondsSeen += law.state == WrittenLaw::bonded;
				uncutSeen += law.state == WrittenLaw::broken && !law.cut;
			}
		}
		failures[0] += law.tension;
		failures[1] += law.shear;
	}
	PackedSample<2>::forcePortable(false);
	std::printf(
	        "%s path: 60000 steps, %d bonded and %d broken with a pushing ice spring, %d tension and %d shear failures; largest difference %.1e N\n",
	        portable ? "portable" : "fastest", bondsSeen, uncutSeen, failures[0], failures[1], worst);
	EXPECT_GT(failures[0], 20);
	EXPECT_GT(failures[1], 20);
	EXPECT_GT(uncutSeen, 100);
}

} // namespace

TEST(PackedBond, randomWalkAgreesWithTheWrittenLawOnThePortablePath) { walk(true); }

TEST(PackedBond, randomWalkAgreesWithTheWrittenLawOnTheFastestPath) { walk(false); }

TEST(PackedBond, everyParameterOfTheListIsArchivedWithItsSampleAndRefusedByNameOutsideItsRange)
{
	State state = packedPair::bonded(0, 0.5);
	for (const BondParameter& parameter : bondParameters)
		state.ice.*parameter.value = 0.75 * state.ice.*parameter.value + 0.125 * (parameter.value == &IceBondModel::exponent ? 6 : 1);
	const auto back = State::fromBytes(state.toBytes());
	int        kept = 0, refused = 0;
	for (const BondParameter& parameter : bondParameters) {
		kept += back.ice.*parameter.value == state.ice.*parameter.value;
		State wrong                = packedPair::bonded(0, 0.5);
		wrong.ice.*parameter.value = -1;
		try {
			wrong.check();
		} catch (const std::invalid_argument& refusal) {
			refused += std::string(refusal.what()).find(std::string("ice.") + parameter.name + " = -1") != std::string::npos;
		}
	}
	std::printf("%zu parameters: %d kept to the last bit, %d refused at -1 by name\n", std::size(bondParameters), kept, refused);
	EXPECT_EQ(kept, int(std::size(bondParameters)));
	EXPECT_EQ(refused, int(std::size(bondParameters)));
}

TEST(PackedBond, ofTwoMaterialsEachParameterIsThatOfTheWeakerBond)
{
	IceBondModel a, b;
	b.young = 2 * a.young;
	// by hand: whether the smaller or the larger value makes the weaker bond, or the later one
	const std::map<std::string, bool> smaller { { "tensileStrength", true },  { "iceTensileStrength", true }, { "shearStrength", true },
		                                    { "iceShearStrength", true }, { "exponent", false },          { "bondAreaFactor", true },
		                                    { "meltSaturation", false },  { "bondSaturation", false },    { "bondRange", true },
		                                    { "thawedStrength", true } };
	int                               agree = 0;
	for (const BondParameter& parameter : bondParameters) {
		if (parameter.value == &IceBondModel::iceYoung) continue;
		a.*parameter.value  = 0.5 * b.*parameter.value + 1e-3 * (parameter.value == &IceBondModel::thawedStrength);
		const double wanted = smaller.at(parameter.name) ? std::min(a.*parameter.value, b.*parameter.value)
		                                                 : std::max(a.*parameter.value, b.*parameter.value);
		agree += mixed(a, b).*parameter.value == wanted && mixed(b, a).*parameter.value == wanted;
	}
	std::printf("%d of %zu parameters as by hand; ice over grains %.3g, by hand 2.5\n", agree, smaller.size(), mixed(a, b).iceYoung / mixed(a, b).young);
	EXPECT_EQ(agree, int(smaller.size()));
	EXPECT_EQ(smaller.size() + 1, std::size(bondParameters));
	// 3 GPa on 0.6 GPa beside 3 GPa on 1.2 GPa: the smaller ratio
	EXPECT_DOUBLE_EQ(mixed(a, b).iceYoung / mixed(a, b).young, 2.5);
	EXPECT_DOUBLE_EQ(mixed(b, a).iceYoung / mixed(b, a).young, 2.5);
}
