// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/thm/Mixture.hpp>
#include <pkg/thm/PoreWaterState.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>

using namespace talik;

namespace {
const VolumeFractions thawed = VolumeFractions::of(0.4, 1.0), frozen = VolumeFractions::of(0.4, 0.0);
}

TEST(Mixture, CapacityAndConductivityOfThePapersSoil)
{
	MixtureProperties m;
	EXPECT_DOUBLE_EQ(m.heatCapacity(thawed), 2.952e6);
	EXPECT_DOUBLE_EQ(m.heatCapacity(frozen), 2.02184e6);
	EXPECT_DOUBLE_EQ(m.density(thawed), 1990.0);
	EXPECT_NEAR(m.conductivity(thawed), 0.84, 1e-15);
	EXPECT_NEAR(m.conductivity(frozen), 1.48, 1e-15);
	m.conductivityMean = ConductivityMean::geometric;
	EXPECT_NEAR(m.conductivity(thawed), std::pow(0.6, 0.4), 1e-14);
	EXPECT_NEAR(m.conductivity(frozen), std::pow(2.2, 0.4), 1e-14);
	m.conductivityMean = ConductivityMean::harmonic;
	EXPECT_NEAR(m.conductivity(thawed), 1.0 / (0.6 + 0.4 / 0.6), 1e-14);
}

TEST(Mixture, MeansAreOrderedHarmonicGeometricArithmetic)
{
	MixtureProperties m;
	for (double n = 0.1; n < 0.95; n += 0.1)
		for (double sl = 0.0; sl <= 1.0; sl += 0.25) {
			double value[3];
			for (int k = 0; k < 3; ++k) {
				m.conductivityMean = static_cast<ConductivityMean>(k);
				value[k]           = m.conductivity(VolumeFractions::of(n, sl));
			}
			EXPECT_LT(value[1], value[0]);
			EXPECT_LT(value[2], value[1]);
		}
	EXPECT_THROW(conductivityMeanFromName("mean"), std::invalid_argument);
}

TEST(Mixture, DensityDeficitAndExpansivityFollowTheirDefinitions)
{
	MixtureProperties m;
	m.liquid.expansivity = 2.1e-4;
	EXPECT_NEAR(m.densityDeficit(0.0), 0.09, 1e-15);
	const double zeta = m.densityDeficit(-2.0), expected = 0.08 * 2.1e-4 + (1.0 - zeta) * 0.32 * 1.6e-4 + 0.6 * (1.0 - 0.8 * zeta) * 2.4e-5;
	EXPECT_NEAR(m.expansivity(0.4, 0.2, -2.0) / expected, 1.0, 1e-13);
	EXPECT_DOUBLE_EQ(m.densityAt(m.liquid, 10.0), 1000.0 * (1.0 - 2.1e-3));
}

TEST(Mixture, ImpossiblePropertiesAreRefused)
{
	MixtureProperties m;
	m.ice.density = 1100.0;
	EXPECT_THROW(m.validate(), std::invalid_argument);
	m            = {};
	m.latentHeat = std::nan("");
	EXPECT_THROW(m.validate(), std::invalid_argument);
	m                     = {};
	m.liquid.conductivity = 0.0;
	EXPECT_THROW(m.validate(), std::invalid_argument);
}

TEST(Permeability, KozenyCarmanAndRelativeConductivityFollowTheirFormulas)
{
	Permeability k;
	EXPECT_DOUBLE_EQ(k.conductivity(0.4, 1.0), 1e-4);
	EXPECT_NEAR(k.porosityFactor(0.5), (0.125 / 0.25) / (0.064 / 0.36), 1e-14);
	EXPECT_NEAR(k.relative(0.5), 1e-3, 1e-17);
	EXPECT_EQ(k.relative(0.0), 1e-6);
	EXPECT_EQ(k.relative(1.0), 1.0);
	k.hydraulicTimeScale = 50.0;
	EXPECT_DOUBLE_EQ(k.conductivity(0.4, 1.0), 5e-3);
	k.index             = 1.3; // from a void ratio of 4.3 to 3
	k.referencePorosity = 4.3 / 5.3;
	EXPECT_NEAR(k.porosityFactor(0.75), 0.1, 1e-14);
}

// Darcy: the drag of a point balances the weight of its liquid at the seepage velocity k (unit gradient)
TEST(Permeability, DragBalancesUnitHydraulicGradientAtTheConductivity)
{
	const Permeability k;
	const double       volume = 0.01, n = 0.4, liquidMass = 1000.0 * n * volume;
	const double       relativeVelocity = 1e-4 / n;
	EXPECT_NEAR(k.dragAt(liquidMass, n, k.conductivity(n, 1.0)) * relativeVelocity / (liquidMass * 9.81), 1.0, 1e-14);
}

TEST(Permeability, ImpossibleValuesAreRefused)
{
	const auto refuses = [](auto change) {
		Permeability k;
		change(k);
		EXPECT_THROW(k.validate(), std::invalid_argument);
	};
	refuses([](Permeability& k) { k.referenceConductivity = 0.0; });
	refuses([](Permeability& k) { k.referencePorosity = 1.0; });
	refuses([](Permeability& k) { k.impedance = -1.0; });
	refuses([](Permeability& k) { k.index = -1.0; });
	refuses([](Permeability& k) { k.hydraulicTimeScale = std::nan(""); });
	EXPECT_NO_THROW(Permeability().validate());
}
