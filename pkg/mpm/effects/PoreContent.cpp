// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/HeatTransfer.hpp>
#include <pkg/mpm/effects/PoreContent.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/grid/CellMeans.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace talik {

namespace {
	// Pore space below this fraction of the volume means that the ground was crushed, not that it is dense.
	constexpr double smallestPorosity = 1e-3;
} // namespace

template <int D>
PoreContent<D>::PoreContent(PointFields& fields, const GroundSettings<D>& settings)
        : settings_(&settings)
{
	std::vector<SoilMaterial> given = settings.materials;
	if (given.empty()) given.emplace_back().mixture = settings.mixture;
	const HeatSettings heat         = settings.heat.value_or(HeatSettings {});
	const Permeability permeability = settings.water ? settings.water->permeability : Permeability {};
	for (const SoilMaterial& m : given)
		materials_.push_back({ m.mixture, EnthalpyModel(m.mixture, m.freezing ? m.freezing : settings.freezing, heat.enthalpyForm, heat.latentDensity),
		                       m.permeability.value_or(permeability) });
	solidMass_ = fields.declare("solidMass", "poreContent", "kg", 1);
	waterMass_ = fields.declare("waterMass", "poreContent", "kg", 1);
	porosity_  = fields.declare("porosity", "poreContent", "-", 1);
	if (settings.freezing) {
		iceMass_       = fields.declare("iceMass", "freezing", "kg", 1);
		iceSaturation_ = fields.declare("iceSaturation", "freezing", "-", 1);
	}
	if (settings.water && settings.water->state.massCoefficient == MassCoefficient::printed) {
		lastVolumeField_ = fields.declare("lastVolume", "water", "m^D", 1);
		lastWaterField_  = fields.declare("lastWaterMass", "water", "kg", 1);
	}
}

template <int D> void PoreContent<D>::bind(MaterialPoints<D>& points)
{
	PointFields& f = points.fields();
	solidMass      = f.component(solidMass_);
	waterMass      = f.component(waterMass_);
	porosity       = f.component(porosity_);
	iceMass        = f.component(iceMass_);
	iceSaturation  = f.component(iceSaturation_);
	lastVolume_    = f.component(lastVolumeField_);
	lastWater_     = f.component(lastWaterField_);
	volume_        = points.volume();
	points_        = &points;
}

template <int D> void PoreContent<D>::useScale(PoreWater<D>& water, double f)
{
	water.scale = water.fastest = water.usedScale(f, materials_.front().permeability);
	for (Material& m : materials_) {
		m.seepageScale = water.usedScale(f, m.permeability);
		water.scale    = std::min(water.scale, m.seepageScale);
		water.fastest  = std::max(water.fastest, m.seepageScale);
	}
}

template <int D> double PoreContent<D>::smallestReferencePorosity() const
{
	double smallest = 1.0;
	for (const Material& m : materials_)
		smallest = std::min(smallest, m.permeability.referencePorosity);
	return smallest;
}

template <int D> void PoreContent<D>::fill(int p, double givenPorosity, double givenTemperature, double pressure, double poreFill, const Effects& of)
{
	const Material&          material = this->of(p);
	const MixtureProperties& mixture  = material.mixture;
	const double             t        = of.heat ? givenTemperature : mixture.referenceTemperature;
	const double             sl       = material.enthalpy.curve().liquidSaturation(t);
	const double             vp       = givenPorosity * volume_[p];
	const PoreWaterState     state    = settings_->water ? settings_->water->state : PoreWaterState {};

	porosity[p]  = givenPorosity;
	solidMass[p] = (volume_[p] - vp) * mixture.densityAt(mixture.solid, t);
	waterMass[p] = poreFill * state.waterMass(mixture, settings_->water ? pressure : 0.0, sl, vp, t);

	const ThermalState thermal = material.enthalpy.stateAt({ solidMass[p], waterMass[p], vp }, t);
	if (of.heat) {
		of.heat->temperature[p]  = t;
		of.heat->enthalpy[p]     = material.enthalpy.enthalpy({ solidMass[p], waterMass[p], vp }, t);
		of.heat->heatCapacity[p] = thermal.heatCapacity;
	}
	if (iceMass) {
		iceMass[p]       = thermal.iceMass;
		iceSaturation[p] = 1.0 - thermal.liquidSaturation;
	}
	if (of.water) {
		of.water->pressure[p]       = pressure;
		of.water->liquidFraction[p] = (waterMass[p] - thermal.iceMass) / (mixture.liquid.density * volume_[p]);
	}
	if (lastVolume_) {
		lastVolume_[p] = volume_[p];
		lastWater_[p]  = waterMass[p];
	}
	if (of.motion) of.motion->mass[p] = solidMass[p] + (of.water ? thermal.iceMass : waterMass[p]);
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

template <int D> void PoreContent<D>::load(Block& b, const HeatTransfer<D>* heat) const
{
	if (heat) std::copy_n(heat->temperature + b.first, b.count, b.temperature);
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

/// Volume of the pores, eq. (2.2).
template <int D> void PoreContent<D>::findPoreVolume(Block& b) const
{
	const MixtureProperties m      = b.of->mixture;
	const double* const     volume = volume_ + b.first;
	const double* const     solid  = solidMass + b.first;
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k)
		b.poreVolume[k] = volume[k] - solid[k] / m.densityAt(m.solid, b.temperature[k]);
}

template <int D> void PoreContent<D>::solveTemperature(Block& b, HeatTransfer<D>& heat) const
{
	EnthalpyBatch batch;
	batch.count            = b.count;
	batch.enthalpy         = heat.enthalpy + b.first;
	batch.solidMass        = solidMass + b.first;
	batch.waterMass        = waterMass + b.first;
	batch.poreVolume       = b.poreVolume;
	batch.temperature      = b.temperature;
	batch.liquidSaturation = b.liquidSaturation;
	batch.iceMass          = b.ice;
	batch.heatCapacity     = heat.heatCapacity + b.first;
	batch.apparentCapacity = iceMass ? heat.share + b.first : nullptr;
	b.of->enthalpy.temperatures(batch);
	if (iceMass) heat.limitShares(b.first, b.count);
}

template <int D> void PoreContent<D>::exchangePhaseMomentum(const Block& b, SolidMotion<D>& motion, PoreWater<D>& water) const
{
	int                 changes  = 0;
	const double* const solids   = solidMass + b.first;
	const double* const contents = waterMass + b.first;
	double* const       mass     = motion.mass + b.first;
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
		double* const solid  = motion.velocity[i] + b.first;
#pragma GCC ivdep
		for (int k = 0; k < b.count; ++k) {
			const double w = liquid[k] - solid[k];
			liquid[k] -= liquidShare[k] * w;
			solid[k] += solidShare[k] * w;
		}
	}
}

template <int D> void PoreContent<D>::updatePressure(const Block& b, PoreWater<D>& water) const
{
	const MixtureProperties m        = b.of->mixture;
	const PoreWaterState    state    = settings_->water->state;
	const double* const     contents = waterMass + b.first;
	double* const           pressure = water.pressure + b.first;
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k)
		pressure[k] = state.pressure(m, contents[k] - b.ice[k], b.ice[k], b.poreVolume[k], b.temperature[k]).pressure;
}

template <int D> void PoreContent<D>::findFill(const Block& b, double (&excess)[blockSize], double (&compliance)[blockSize]) const
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

template <int D> void PoreContent<D>::collectPressure(const Block& b, const CellMeans<D>& cells, PoreWater<D>& water, double dt) const
{
	double excess[blockSize], compliance[blockSize];
	findFill(b, excess, compliance);
	if (iceMass) water.addFills(cells, b.first, b.count, excess, compliance, dt, b.of->mixture.liquid.density);
	else
		for (int k = 0; k < b.count; ++k)
			water.addFill(cells.cell(b.first + k), excess[k], compliance[k]);
}

template <int D> void PoreContent<D>::updatePressureRate(const Block& b, PoreWater<D>& water)
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
		water.pressure[p]                 = std::max(water.pressure[p] + change, state.cavitationPressure);
		lastVolume_[p]                    = volume_[p];
		lastWater_[p]                     = waterMass[p];
	}
}

template <int D> void PoreContent<D>::updateCoefficients(const Block& b, HeatTransfer<D>* heat, PoreWater<D>* water)
{
	updatePorosity(b);
	if (heat) updateConductivity(b, *heat);
	if (iceMass) updateIce(b);
	if (water) updateDrag(b, *water);
}

template <int D> void PoreContent<D>::updatePorosity(const Block& b)
{
	const double* const volume = volume_ + b.first;
	double* const       n      = porosity + b.first;
#pragma GCC ivdep
	for (int k = 0; k < b.count; ++k)
		n[k] = b.poreVolume[k] / volume[k];
}

template <int D> void PoreContent<D>::updateConductivity(const Block& b, HeatTransfer<D>& heat) const
{
	const MixtureProperties m     = b.of->mixture;
	const double* const     n     = porosity + b.first;
	double* const           kappa = heat.conductivity + b.first;
	if (m.conductivityMean == ConductivityMean::arithmetic) {
#pragma GCC ivdep
		for (int k = 0; k < b.count; ++k)
			kappa[k] = m.arithmeticConductivity(VolumeFractions::of(n[k], b.liquidSaturation[k]));
		return;
	}
	for (int k = 0; k < b.count; ++k)
		kappa[k] = m.conductivity(VolumeFractions::of(n[k], b.liquidSaturation[k]));
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
template <int D> void PoreContent<D>::updateDrag(const Block& b, PoreWater<D>& water) const
{
	Permeability law = b.of->permeability;
	law.hydraulicTimeScale *= b.of->seepageScale;
	const double        perDensity = 1.0 / b.of->mixture.liquid.density, floor = law.floor;
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
		open[k]           = std::max(floor, fill * fill * fill);
	}
	if (law.law == RelativeConductivity::impedance) {
#pragma GCC ivdep
		for (int k = 0; k < b.count; ++k)
			drag[k] = law.dragAt(contents[k] - b.ice[k], liquidFraction[k], open[k] * law.impededConductivity(n[k], b.liquidSaturation[k]));
		return;
	}
	for (int k = 0; k < b.count; ++k)
		drag[k] = law.dragAt(contents[k] - b.ice[k], liquidFraction[k], open[k] * law.conductivity(n[k], b.liquidSaturation[k]));
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

template <int D> int PoreContent<D>::findTemperature(Block& b, const Effects& of) const
{
	load(b, of.heat);
	findPoreVolume(b);
	if (of.heat) solveTemperature(b, *of.heat);
	const int bad = firstImpossible(b);
	if (bad < b.end() || !of.heat) return bad;
	std::copy_n(b.temperature, b.count, of.heat->temperature + b.first);
	findPoreVolume(b);
	if (iceMass && of.water) exchangePhaseMomentum(b, *of.motion, *of.water);
	return bad;
}

template <int D> void PoreContent<D>::findCoefficientsAndPressure(const Block& b, const Effects& of, const CellMeans<D>* cells, double dt)
{
	updateCoefficients(b, of.heat, of.water);
	if (!of.water) return;
	if (lastVolume_) updatePressureRate(b, *of.water);
	else if (cells) collectPressure(b, *cells, *of.water, dt);
	else updatePressure(b, *of.water);
}

template <int D> int PoreContent<D>::update(int first, int last, const Effects& of)
{
	return inBlocks(first, last, [&](Block& b) {
		const int reached = findTemperature(b, of);
		if (reached == b.end()) findCoefficientsAndPressure(b, of, nullptr, 0.0);
		return reached;
	});
}

template <int D> std::string PoreContent<D>::whyImpossible(int p, const HeatTransfer<D>* heat) const
{
	const MixtureProperties& m = of(p).mixture;
	std::ostringstream       text;
	const double             t    = heat ? heat->temperature[p] : m.referenceTemperature;
	const double             pore = volume_[p] - solidMass[p] / m.densityAt(m.solid, t);
	text << "volume " << volume_[p] << ", porosity " << pore / volume_[p] << ", water mass " << waterMass[p] << " kg";
	if (iceMass) text << ", ice mass " << iceMass[p] << " kg";
	if (heat) text << ", enthalpy " << heat->enthalpy[p] << " J, temperature " << t << " degC";
	if (!(pore >= smallestPorosity * volume_[p])) text << ": the pores are crushed; use a stiffer skeleton or a smaller time step";
	else text << ": no possible state; use a smaller time step";
	return text.str();
}

template class PoreContent<2>;
template class PoreContent<3>;

} // namespace talik
