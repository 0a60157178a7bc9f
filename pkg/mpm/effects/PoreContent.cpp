// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/PoreContent.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace talik {

namespace {
	// Pore space below this fraction of the volume means that the ground was crushed, not that it is dense.
	constexpr double smallestPorosity = 1e-3;
	// A front within a cell changes the phase of a few points, and the heat that reaches it is meant for them: divided by sensible
	// capacity most of it would overcool (or overheat) their neighbours first, and a front that freezes would lag by h/3. Divided
	// by the whole apparent capacity the front would run in jumps from point to point, ahead of the heat that it needs.
	constexpr double largestWeight = 3.0;

	/// The points of a block, whose grains, water and pores are given.
	template <class Block, class OfHeat>
	EnthalpyBatch batchOf(Block& b, const OfHeat& heat, const double* solidMass, const double* waterMass, const double* poreVolume, double* capacityWeight)
	{
		return { std::size_t(b.count),        heat.enthalpy + b.first, solidMass, waterMass, poreVolume, b.temperature, b.liquidSaturation, b.ice,
			 heat.heatCapacity + b.first, capacityWeight };
	}
} // namespace

template <int D>
PoreContent<D>::PoreContent(PointFields& fields, const GroundSettings<D>& settings)
        : settings_(&settings)
{
	std::vector<SoilMaterial> given = settings.materials;
	if (given.empty()) given.emplace_back().mixture = settings.mixture;
	const Permeability permeability = settings.water ? settings.water->permeability : Permeability {};
	for (const SoilMaterial& m : given)
		materials_.push_back(
		        { m.mixture, EnthalpyModel(m.mixture, m.freezing ? m.freezing : settings.freezing), m.permeability.value_or(permeability) });
	if (settings.water)
		for (Material& m : materials_)
			m.enthalpy.letWaterFillPores(settings.water->state.densityChange ? m.mixture.ice.density : m.mixture.liquid.density);
	fields.declare("solidMass", "poreContent", "kg", solidMass);
	fields.declare("waterMass", "poreContent", "kg", waterMass);
	fields.declare("porosity", "poreContent", "-", porosity);
	if (settings.freezing) {
		fields.declare("iceMass", "freezing", "kg", iceMass);
		fields.declare("iceSaturation", "freezing", "-", iceSaturation);
	}
	if (settings.water && settings.water->state.massCoefficient == MassCoefficient::printed) {
		fields.declare("lastVolume", "water", "m^D", lastVolume_);
		fields.declare("lastWaterMass", "water", "kg", lastWater_);
	}
}

template <int D> void PoreContent<D>::bind(MaterialPoints<D>& points)
{
	volume_ = points.volume();
	points_ = &points;
}

template <int D> SeepageScales PoreContent<D>::useScale(double f, const PoreWater<D>& water)
{
	const bool   withIce = settings_->water->implicit;
	const double wanted  = water.wantedScale(f);
	if (withIce) largestConductivity_ = water.largestConductivity;
	SeepageScales all { wanted, 0.0 };
	for (Material& m : materials_) {
		const double used = std::min(wanted, water.largestConductivity / m.permeability.referenceConductivity);
		m.seepageScale    = withIce ? wanted : used;
		all.smallest      = std::min(all.smallest, used);
		all.largest       = std::max(all.largest, used);
	}
	return all;
}

template <int D> double PoreContent<D>::smallestReferencePorosity() const
{
	double smallest = 1.0;
	for (const Material& m : materials_)
		smallest = std::min(smallest, m.permeability.referencePorosity);
	return smallest;
}

template <int D> void PoreContent<D>::fill(int p, double givenPorosity, double givenTemperature, double pressure, double poreFill, const PointArrays& of)
{
	const Material&          material = this->of(p);
	const MixtureProperties& mixture  = material.mixture;
	const double             t        = of.hasHeat() ? givenTemperature : mixture.referenceTemperature;
	const double             sl       = material.enthalpy.curve().liquidSaturation(t);
	const double             vp       = givenPorosity * volume_[p];
	const PoreWaterState     state    = settings_->water ? settings_->water->state : PoreWaterState {};

	porosity[p]  = givenPorosity;
	solidMass[p] = (volume_[p] - vp) * mixture.densityAt(mixture.solid, t);
	waterMass[p] = poreFill * state.waterMass(mixture, settings_->water ? pressure : 0.0, sl, vp, t);

	const ThermalState thermal = material.enthalpy.stateAt({ solidMass[p], waterMass[p], vp }, t);
	if (of.hasHeat()) {
		of.heat.temperature[p]  = t;
		of.heat.enthalpy[p]     = material.enthalpy.enthalpy({ solidMass[p], waterMass[p], vp }, t);
		of.heat.heatCapacity[p] = thermal.heatCapacity;
	}
	if (iceMass) {
		iceMass[p]       = thermal.iceMass;
		iceSaturation[p] = 1.0 - thermal.liquidSaturation;
	}
	if (of.hasWater()) {
		of.water.pressure[p]       = pressure;
		of.water.liquidFraction[p] = (waterMass[p] - thermal.iceMass) / (mixture.liquid.density * volume_[p]);
	}
	if (lastVolume_) {
		lastVolume_[p] = volume_[p];
		lastWater_[p]  = waterMass[p];
	}
	if (of.hasSolid()) of.solid.mass[p] = solidMass[p] + (of.hasWater() ? thermal.iceMass : waterMass[p]);
}

/// As many points as a block takes, up to the last or the first of another material.
template <int D> void PoreContent<D>::choosePoints(Block& b, int last) const
{
	b.of                              = &of(b.first);
	b.count                           = std::min(blockSize, last - b.first);
	const std::uint16_t* const number = points_->materials();
	if (!number) return;
	const auto* const begin = number + b.first;
	b.count                 = int(std::find_if(begin, begin + b.count, [&](std::uint16_t m) { return m != *begin; }) - begin);
}

template <int D> void PoreContent<D>::load(Block& b, const double* temperature) const
{
	if (temperature) std::copy_n(temperature + b.first, b.count, b.temperature);
	else std::fill_n(b.temperature, b.count, b.of->mixture.referenceTemperature);
	if (iceMass) {
		std::copy_n(iceMass + b.first, b.count, b.ice);
		for (int k = 0; k < b.count; ++k)
			b.liquidSaturation[k] = 1.0 - iceSaturation[b.first + k];
	} else {
		std::fill_n(b.ice, b.count, 0.0);
		std::fill_n(b.liquidSaturation, b.count, 1.0);
	}
	std::copy_n(b.temperature, b.count, b.temperatureBefore);
	std::copy_n(b.ice, b.count, b.iceBefore);
	std::copy_n(b.liquidSaturation, b.count, b.saturationBefore);
}

// Loops over points hold constants by value and fields, which never overlap, by pointers of their own: only then are they vectors.

/// Volume of the pores, eq. (2.2), of ground of the given volumes.
template <int D> void PoreContent<D>::findPoreVolume(Block& b, const double* volumes) const
{
	const MixtureProperties m      = b.of->mixture;
	const double* const     volume = volumes + b.first;
	const double* const     solid  = solidMass + b.first;
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k)
		b.poreVolume[k] = volume[k] - solid[k] / m.densityAt(m.solid, b.temperature[k]);
}

template <int D> void PoreContent<D>::solveTemperature(Block& b, const OfHeat& heat) const
{
	if (excessVolume_ && hasExcessIce(b)) return solveWithExcessIce(b, heat);
	const double* const solid = solidMass + b.first;
	const double* const water = waterMass + b.first;
	b.of->enthalpy.temperatures(batchOf(b, heat, solid, water, b.poreVolume, iceMass ? heat.capacityWeight + b.first : nullptr));
	if (iceMass) limitWeights(b, heat);
}

template <int D> void PoreContent<D>::limitWeights(const Block& b, const OfHeat& heat) const
{
	double* const       limited  = heat.capacityWeight + b.first;
	const double* const sensible = heat.heatCapacity + b.first;
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k)
		limited[k] = std::min(std::max(limited[k], sensible[k]), largestWeight * sensible[k]);
}

template <int D> bool PoreContent<D>::hasExcessIce(const Block& b) const
{
	return std::any_of(excessVolume_ + b.first, excessVolume_ + b.end(), [](double v) { return v > 0.0; });
}

/// Excess ice that is frozen is as inert as grains: it has heat, takes none of the freezing curve, and is no part of the pores.
template <int D> void PoreContent<D>::solveWithExcessIce(Block& b, const OfHeat& heat) const
{
	const MixtureProperties& m    = b.of->mixture;
	const double             most = 1.0 - EnthalpyModel::residualWaterFraction, asGrains = m.ice.specificHeat / m.solid.specificHeat;
	double                   solid[blockSize], water[blockSize], pores[blockSize];
	for (int k = 0; k < b.count; ++k) {
		const int    p   = b.first + k;
		const double ice = std::min(m.ice.density * excessVolume_[p], most * waterMass[p]);
		excessIce_[p]    = ice;
		solid[k]         = solidMass[p] + asGrains * ice;
		water[k]         = waterMass[p] - ice;
		pores[k]         = b.poreVolume[k] - excessVolume_[p];
	}
	b.of->enthalpy.temperatures(batchOf(b, heat, solid, water, pores, heat.capacityWeight + b.first));
	const double freezing = b.of->enthalpy.curve().freezingTemperature();
	for (int k = 0; k < b.count; ++k)
		if (b.temperature[k] > freezing && excessIce_[b.first + k] > 0.0) meltExcessIce(b, heat, k);
		else b.ice[k] += excessIce_[b.first + k];
	limitWeights(b, heat);
}

/// A point with more heat than its excess ice, all frozen, lets it have.
template <int D> void PoreContent<D>::meltExcessIce(Block& b, const OfHeat& heat, int k) const
{
	const int                p     = b.first + k;
	const EnthalpyModel&     model = b.of->enthalpy;
	const MixtureProperties& m     = b.of->mixture;
	const SoilContent        all { solidMass[p], waterMass[p], b.poreVolume[k] };
	const double             freezing = model.curve().freezingTemperature();
	const double             perMass  = m.latentHeat + (m.liquid.specificHeat - m.ice.specificHeat) * (freezing - m.referenceTemperature);
	const double             missing  = model.enthalpy(all, freezing) - heat.enthalpy[p];
	excessIce_[p]                     = std::clamp(missing / perMass, 0.0, excessIce_[p]);
	b.ice[k]                          = excessIce_[p];
	b.liquidSaturation[k]             = 1.0;
	b.temperature[k]                  = freezing;
	if (missing <= 0.0) b.temperature[k] = model.solve(all, heat.enthalpy[p], freezing).temperature;
	heat.heatCapacity[p] = all.solidMass * m.solid.specificHeat + (all.waterMass - excessIce_[p]) * m.liquid.specificHeat
	        + excessIce_[p] * m.ice.specificHeat;
	heat.capacityWeight[p] = missing > 0.0 ? std::numeric_limits<double>::max() : heat.heatCapacity[p];
}

/// Heat flows through all that a point holds, water through the pores of its soil.
template <int D> void PoreContent<D>::correctForExcessIce(const Block& b, const OfHeat& heat, const OfWater& water) const
{
	const MixtureProperties& m   = b.of->mixture;
	Permeability             law = b.of->permeability;
	law.hydraulicTimeScale *= b.of->seepageScale;
	for (int k = 0; k < b.count; ++k) {
		const int p = b.first + k;
		if (!(excessVolume_[p] > 0.0)) continue;
		const double ice     = std::min(1.0, b.ice[k] / (m.ice.density * b.poreVolume[k]));
		heat.conductivity[p] = m.conductivity(VolumeFractions::of(porosity[p], 1.0 - ice));
		const double held = excessIce_[p] / m.ice.density, soil = volume_[p] - held, n = (b.poreVolume[k] - held) / soil;
		const double liquid = (waterMass[p] - b.ice[k]) / m.liquid.density / soil;
		const double fill   = std::min(1.0, liquid / (n * b.liquidSaturation[k]));
		const double open   = std::max(law.floor, fill * fill * fill);
		water.drag[p]       = law.dragAt(waterMass[p] - b.ice[k], water.liquidFraction[p], open * reached(law.conductivity(n, b.liquidSaturation[k])));
	}
}

template <int D> void PoreContent<D>::exchangePhaseMomentum(const Block& b, const OfSolid& moving, const OfWater& water) const
{
	int                 changes  = 0;
	const double* const solids   = solidMass + b.first;
	const double* const contents = waterMass + b.first;
	double* const       mass     = moving.mass + b.first;
	for (int k = 0; k < b.count; ++k)
		changes |= b.iceBefore[k] != b.ice[k];
	if (!changes) return;
	double liquidShare[blockSize], solidShare[blockSize];
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k) {
		const double melt     = b.iceBefore[k] - b.ice[k];
		const double toLiquid = std::max(melt, 0.0), toSolid = std::max(-melt, 0.0);
		liquidShare[k] = toLiquid / (contents[k] - b.iceBefore[k] + toLiquid);
		solidShare[k]  = toSolid / (solids[k] + b.iceBefore[k] + toSolid);
		mass[k]        = solids[k] + b.ice[k];
	}
	for (int i = 0; i < D; ++i) {
		double* const liquid = water.velocity[i] + b.first;
		double* const solid  = moving.velocity[i] + b.first;
#pragma GCC ivdep
		for (int k = 0; k < b.count; ++k) {
			const double w = liquid[k] - solid[k];
			liquid[k] -= liquidShare[k] * w;
			solid[k] += solidShare[k] * w;
		}
	}
}

template <int D> void PoreContent<D>::updatePressure(const Block& b, double* pressures) const
{
	const MixtureProperties m        = b.of->mixture;
	const PoreWaterState    state    = settings_->water->state;
	const double* const     contents = waterMass + b.first;
	double* const           pressure = pressures + b.first;
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k)
		pressure[k] = state.pressure(m, contents[k] - b.ice[k], b.ice[k], b.poreVolume[k], b.temperature[k]);
}

template <int D> void PoreContent<D>::findFill(const Block& b, double (&excess)[blockSize], double (&compliance)[blockSize]) const
{
	computeFill(b, excess, compliance);
}

template <int D> void PoreContent<D>::computeFill(const Block& b, double (&excess)[blockSize], double (&compliance)[blockSize]) const
{
	const MixtureProperties m     = b.of->mixture;
	const PoreWaterState    state = settings_->water->state;
	const double* const     water = waterMass + b.first;
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k) {
		const PoreFill f = state.fill(m, water[k] - b.ice[k], b.ice[k], b.temperature[k]);
		excess[k]        = f.volume - b.poreVolume[k];
		compliance[k]    = f.compliance;
	}
}

template <int D> void PoreContent<D>::updatePressureRate(const Block& b, double* pressures)
{
	const MixtureProperties& m     = b.of->mixture;
	const PoreWaterState&    state = settings_->water->state;
	for (int k = 0; k < b.count; ++k) {
		const int    p      = b.first + k;
		const double n      = porosity[p];
		const double zeta   = state.densityChange ? m.densityDeficit(b.temperature[k]) : 0.0;
		const double strain = volume_[p] / lastVolume_[p] - 1.0;
		const double inflow = (waterMass[p] - lastWater_[p]) / (m.liquid.density * volume_[p]);
		// secant of the freezing curve: its derivative would miss what melts within the step
		const double freed = zeta * n * (b.liquidSaturation[k] - b.saturationBefore[k])
		        - m.expansivity(n, b.liquidSaturation[k], b.temperature[k]) * (b.temperature[k] - b.temperatureBefore[k]);
		const PressureCoefficients c      = state.coefficients(m, { n, b.liquidSaturation[k], 0.0, b.temperature[k] });
		const double               change = -(freed + c.undrained() * strain - inflow) / c.storage;
		pressures[p]                      = std::max(pressures[p] + change, state.cavitationPressure);
		lastVolume_[p]                    = volume_[p];
		lastWater_[p]                     = waterMass[p];
	}
}

template <int D> void PoreContent<D>::updatePorosity(const Block& b)
{
	const double* const volume = volume_ + b.first;
	double* const       n      = porosity + b.first;
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k)
		n[k] = b.poreVolume[k] / volume[k];
}

template <int D> void PoreContent<D>::updateConductivity(const Block& b, double* conductivity) const
{
	const MixtureProperties m        = b.of->mixture;
	const double* const     n        = porosity + b.first;
	const double* const     contents = waterMass + b.first;
	double* const           kappa    = conductivity + b.first;
	double                  fill[blockSize]; // pores that their ice fills are full when it melts, too
	std::fill_n(fill, b.count, 1.0);
	for (int k = 0; holdsAir && k < b.count; ++k)
		fill[k] = std::min(1.0, contents[k] / (m.ice.density * b.poreVolume[k]));
	if (m.conductivityMean == ConductivityMean::arithmetic) {
#pragma GCC ivdep
		for (int k = 0; k < b.count; ++k)
			kappa[k] = m.arithmeticConductivity(VolumeFractions::of(n[k], b.liquidSaturation[k], fill[k]));
		return;
	}
	for (int k = 0; k < b.count; ++k)
		kappa[k] = m.conductivity(VolumeFractions::of(n[k], b.liquidSaturation[k], fill[k]));
}

template <int D> void PoreContent<D>::updateIce(const Block& b)
{
	double* const saturation = iceSaturation + b.first;
	std::copy_n(b.ice, b.count, iceMass + b.first);
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k)
		saturation[k] = 1.0 - b.liquidSaturation[k];
}

/// Where water has left a gap, less of it flows, and through narrower ways: conductivity falls with the cube of the fill (Corey). Ground
/// that drains then runs dry ever more slowly, and nothing flows that is not there.
template <int D> void PoreContent<D>::updateDrag(const Block& b, const OfWater& water) const
{
	Permeability law = b.of->permeability;
	law.hydraulicTimeScale *= b.of->seepageScale;
	const double        perDensity = 1.0 / b.of->mixture.liquid.density, largest = largestConductivity_;
	const double* const contents       = waterMass + b.first;
	const double* const n              = porosity + b.first;
	const double* const volume         = volume_ + b.first;
	double* const       liquidFraction = water.liquidFraction + b.first;
	double* const       drag           = water.drag + b.first;
	double              open[blockSize];
	// that of the mass that moves: from n S_l, which it is in full pores with density change, seepage would carry another mass than
	// weight and pressure act on
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k) {
		liquidFraction[k] = (contents[k] - b.ice[k]) * perDensity / volume[k];
		const double fill = std::min(1.0, liquidFraction[k] / (n[k] * b.liquidSaturation[k]));
		open[k]           = std::max(Permeability::floor, fill * fill * fill);
	}
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k)
		drag[k] = law.dragAt(contents[k] - b.ice[k], liquidFraction[k], open[k] * std::min(largest, law.conductivity(n[k], b.liquidSaturation[k])));
}

template <int D> bool PoreContent<D>::allPossible(const Block& b) const
{
	const double* const volume = volume_ + b.first;
	const double* const water  = waterMass + b.first;
	const double        least  = settings_->water ? 0.0 : -std::numeric_limits<double>::infinity();
	int                 bad    = 0;
	for (int k = 0; k < b.count; ++k) {
		const bool hasPores = b.poreVolume[k] >= smallestPorosity * volume[k];
		const bool hasState = std::abs(b.temperature[k]) <= std::numeric_limits<double>::max() && water[k] - b.ice[k] > least;
		bad |= !(hasPores & hasState);
	}
	return !bad;
}

template <int D> int PoreContent<D>::firstImpossible(const Block& b) const
{
	if (allPossible(b)) return b.first + b.count;
	Block one;
	one.count = 1;
	for (int k = 0; k < b.count; ++k) {
		one.first          = b.first + k;
		one.of             = b.of;
		one.poreVolume[0]  = b.poreVolume[k];
		one.temperature[0] = b.temperature[k];
		one.ice[0]         = b.ice[k];
		if (!allPossible(one)) return one.first;
	}
	return b.first + b.count;
}

template <int D> int PoreContent<D>::findTemperature(Block& b, const PointArrays& of) const
{
	load(b, of.heat.temperature);
	// ice has the room of the pores at the start where no water flows, which strain does not change
	findPoreVolume(b, of.hasSolid() ? of.solid.initialVolume : volume_);
	if (of.hasHeat()) solveTemperature(b, of.heat);
	findPoreVolume(b, volume_);
	const int bad = firstImpossible(b);
	if (bad < b.end() || !of.hasHeat()) return bad;
	std::copy_n(b.temperature, b.count, of.heat.temperature + b.first);
	if (iceMass && of.hasWater()) exchangePhaseMomentum(b, of.solid, of.water);
	return bad;
}

template <int D> void PoreContent<D>::findCoefficients(const Block& b, const PointArrays& of)
{
	updatePorosity(b);
	if (of.hasHeat()) updateConductivity(b, of.heat.conductivity);
	if (iceMass) updateIce(b);
	if (of.hasWater()) updateDrag(b, of.water);
	if (excessVolume_ && hasExcessIce(b)) correctForExcessIce(b, of.heat, of.water);
}

template <int D> void PoreContent<D>::findPressure(const Block& b, const PointArrays& of)
{
	if (lastVolume_) updatePressureRate(b, of.water.pressure);
	else updatePressure(b, of.water.pressure);
}

template <int D> int PoreContent<D>::update(int first, int last, const PointArrays& of)
{
	return inBlocks(first, last, [&](Block& b) {
		const int reached = findTemperature(b, of);
		if (reached < b.end()) return reached;
		findCoefficients(b, of);
		if (of.hasWater()) findPressure(b, of);
		return reached;
	});
}

template <int D> std::string PoreContent<D>::whyImpossible(int p, const double* temperature, const double* enthalpy) const
{
	const MixtureProperties& m = of(p).mixture;
	std::ostringstream       text;
	const double             t    = temperature ? temperature[p] : m.referenceTemperature;
	const double             pore = volume_[p] - solidMass[p] / m.densityAt(m.solid, t);
	text << "volume " << volume_[p] << ", porosity " << pore / volume_[p] << ", water mass " << waterMass[p] << " kg";
	if (iceMass) text << ", ice mass " << iceMass[p] << " kg";
	if (temperature) text << ", enthalpy " << enthalpy[p] << " J, temperature " << t << " degC";
	if (!(pore >= smallestPorosity * volume_[p])) text << ": the pores are crushed; use a stiffer skeleton or a smaller time step";
	else text << ": no possible state; use a smaller time step";
	return text.str();
}

TALIK_IN_PLANE_AND_SPACE(PoreContent);

} // namespace talik
