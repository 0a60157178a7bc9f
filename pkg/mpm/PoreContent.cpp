// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/CellMeans.hpp>
#include <pkg/mpm/HeatTransfer.hpp>
#include <pkg/mpm/PlaneLoops.hpp>
#include <pkg/mpm/PoreContent.hpp>
#include <pkg/mpm/PoreWater.hpp>
#include <pkg/mpm/SolidMotion.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace talik {

namespace {
	// Pore space below this fraction of the volume means that the ground was crushed, not that it is dense.
	constexpr double smallestPorosity = 1e-3;
} // namespace

/// Some consecutive points with what is known only during an update.
template <int D> struct PoreContent<D>::Block {
	int    first, count;
	double temperature[blockSize];
	double temperatureBefore[blockSize];
	double poreVolume[blockSize];
	double liquidSaturation[blockSize];
	double saturationBefore[blockSize];
	double iceBefore[blockSize];
	double ice[blockSize];
	double capacity[blockSize];
};

template <int D>
PoreContent<D>::PoreContent(PointFields& fields, const GroundSettings<D>& settings)
        : settings_(&settings)
        , enthalpyModel_(
                  settings.mixture,
                  settings.freezing,
                  settings.heat ? settings.heat->enthalpyForm : EnthalpyForm::stateFunction,
                  settings.heat ? settings.heat->latentDensity : LatentDensity::ice)
{
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

template <int D> void PoreContent<D>::bind(MaterialPoints<D>& points, SolidMotion<D>* motion, HeatTransfer<D>* heat, PoreWater<D>* water)
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
	motion_        = motion;
	heat_          = heat;
	water_         = water;
}

template <int D> void PoreContent<D>::fill(int p, double givenPorosity, double givenTemperature, double pressure, double poreFill)
{
	const MixtureProperties& mixture = settings_->mixture;
	const double t   = heat_ ? givenTemperature : mixture.referenceTemperature;
	const double sl  = enthalpyModel_.curve().liquidSaturation(t);
	const double vp  = givenPorosity * volume_[p];
	const PoreWaterState state = settings_->water ? settings_->water->state : PoreWaterState {};

	porosity[p]  = givenPorosity;
	solidMass[p] = (volume_[p] - vp) * mixture.densityAt(mixture.solid, t);
	waterMass[p] = poreFill * state.waterMass(mixture, settings_->water ? pressure : 0.0, sl, vp, t);

	const ThermalState thermal = enthalpyModel_.stateAt({ solidMass[p], waterMass[p], vp }, t);
	if (heat_) {
		heat_->temperature[p]  = t;
		heat_->enthalpy[p]     = enthalpyModel_.enthalpy({ solidMass[p], waterMass[p], vp }, t);
		heat_->heatCapacity[p] = thermal.heatCapacity;
	}
	if (iceMass) {
		iceMass[p]       = thermal.iceMass;
		iceSaturation[p] = 1.0 - thermal.liquidSaturation;
	}
	if (water_) {
		water_->pressure[p]       = pressure;
		water_->liquidFraction[p] = givenPorosity * thermal.liquidSaturation;
	}
	if (lastVolume_) {
		lastVolume_[p] = volume_[p];
		lastWater_[p]  = waterMass[p];
	}
	if (motion_) motion_->mass[p] = solidMass[p] + (water_ ? thermal.iceMass : waterMass[p]);
}

template <int D> void PoreContent<D>::findPoreVolume(Block& b) const
{
	const MixtureProperties& m = settings_->mixture;
	for (int k = 0; k < b.count; ++k)
		b.poreVolume[k] = volume_[b.first + k] - solidMass[b.first + k] / m.densityAt(m.solid, b.temperature[k]);
}

template <int D> void PoreContent<D>::solveTemperature(Block& b) const
{
	EnthalpyBatch batch;
	batch.count            = b.count;
	batch.enthalpy         = heat_->enthalpy + b.first;
	batch.solidMass        = solidMass + b.first;
	batch.waterMass        = waterMass + b.first;
	batch.poreVolume       = b.poreVolume;
	batch.temperature      = b.temperature;
	batch.liquidSaturation = b.liquidSaturation;
	batch.iceMass          = b.ice;
	batch.heatCapacity     = heat_->heatCapacity + b.first;
	batch.apparentCapacity = iceMass ? heat_->share + b.first : nullptr;
	enthalpyModel_.temperatures(batch);
	if (iceMass) heat_->limitShares(b.first, b.count);
}

template <int D> void PoreContent<D>::exchangePhaseMomentum(const Block& b) const
{
	bool changes = false;
	for (int k = 0; k < b.count; ++k)
		changes |= b.iceBefore[k] != b.ice[k];
	if (!changes) return;
	for (int k = 0; k < b.count; ++k) {
		const int    p      = b.first + k;
		const double melt   = b.iceBefore[k] - b.ice[k];
		const double solid  = solidMass[p] + b.iceBefore[k];
		const double liquid = waterMass[p] - b.iceBefore[k];
		const double toLiquid = std::max(melt, 0.0), toSolid = std::max(-melt, 0.0);
		const double liquidShare = toLiquid / (liquid + toLiquid), solidShare = toSolid / (solid + toSolid);
		for (int i = 0; i < D; ++i) {
			const double w = water_->velocity[i][p] - motion_->velocity[i][p];
			water_->velocity[i][p] -= liquidShare * w;
			motion_->velocity[i][p] += solidShare * w;
		}
		motion_->mass[p] = solidMass[p] + b.ice[k];
	}
}

template <int D> void PoreContent<D>::updatePressure(const Block& b) const
{
	const MixtureProperties& m     = settings_->mixture;
	const PoreWaterState&    state = settings_->water->state;
	for (int k = 0; k < b.count; ++k) {
		const int p         = b.first + k;
		water_->pressure[p] = state.pressure(m, waterMass[p] - b.ice[k], b.ice[k], b.poreVolume[k], b.temperature[k]).pressure;
	}
}

template <int D> void PoreContent<D>::collectPressure(const Block& b, const CellMeans<D>& cells) const
{
	const MixtureProperties& m     = settings_->mixture;
	const PoreWaterState&    state = settings_->water->state;
	for (int k = 0; k < b.count; ++k) {
		const int      p = b.first + k;
		const PoreFill f = state.fill(m, waterMass[p] - b.ice[k], b.ice[k], b.temperature[k]);
		water_->addFill(cells.cell(p), f.volume - b.poreVolume[k], f.compliance);
	}
}

template <int D> void PoreContent<D>::updatePressureRate(const Block& b) const
{
	const MixtureProperties& m     = settings_->mixture;
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
		water_->pressure[p]               = std::max(water_->pressure[p] + change, state.cavitationPressure);
		lastVolume_[p]                    = volume_[p];
		lastWater_[p]                     = waterMass[p];
	}
}

template <int D> void PoreContent<D>::updateCoefficients(const Block& b) const
{
	const MixtureProperties& m = settings_->mixture;
	for (int k = 0; k < b.count; ++k)
		porosity[b.first + k] = b.poreVolume[k] / volume_[b.first + k];
	if (heat_)
		for (int k = 0; k < b.count; ++k)
			heat_->conductivity[b.first + k] = m.conductivity(VolumeFractions::of(porosity[b.first + k], b.liquidSaturation[k]));
	if (iceMass)
		for (int k = 0; k < b.count; ++k) {
			iceMass[b.first + k]       = b.ice[k];
			iceSaturation[b.first + k] = 1.0 - b.liquidSaturation[k];
		}
	if (water_) updateDrag(b);
}

template <int D> void PoreContent<D>::updateDrag(const Block& b) const
{
	const Permeability& law = settings_->water->permeability;
	for (int k = 0; k < b.count; ++k)
		water_->liquidFraction[b.first + k] = porosity[b.first + k] * b.liquidSaturation[k];
	if (law.law != RelativeConductivity::impedance) {
		for (int k = 0; k < b.count; ++k)
			water_->drag[b.first + k] = law.drag(waterMass[b.first + k] - b.ice[k], porosity[b.first + k], b.liquidSaturation[k]);
		return;
	}
	// the usual law, without a power function per point
	constexpr double ln10 = 2.302585092994045684;
	double           relative[blockSize];
	for (int k = 0; k < b.count; ++k)
		relative[k] = std::max(-700.0, -law.impedance * ln10 * (1.0 - b.liquidSaturation[k]));
	planeLoops().exponential(b.count, relative, relative);
	const double thawed = law.hydraulicTimeScale * law.referenceConductivity;
	for (int k = 0; k < b.count; ++k) {
		const int    p           = b.first + k;
		const double conductance = thawed * law.porosityFactor(porosity[p]) * std::max(law.floor, relative[k]);
		water_->drag[p]          = (waterMass[p] - b.ice[k]) * water_->liquidFraction[p] * Permeability::gravity / conductance;
	}
}

template <int D> int PoreContent<D>::firstImpossible(const Block& b) const
{
	for (int k = 0; k < b.count; ++k) {
		const int  p      = b.first + k;
		const bool hasPores = b.poreVolume[k] >= smallestPorosity * volume_[p];
		const bool hasState = std::isfinite(b.temperature[k]) && (!water_ || waterMass[p] - b.ice[k] > 0.0);
		if (!hasPores || !hasState) return p;
	}
	return b.first + b.count;
}

template <int D> int PoreContent<D>::update(int first, int last, const CellMeans<D>* cells) const
{
	std::array<double, CostMeter::entries> unused {};
	CostMeter::Sample                      sample(unused);
	return update(first, last, cells, sample);
}

template <int D> int PoreContent<D>::update(int first, int last, const CellMeans<D>* cells, CostMeter::Sample& sample) const
{
	const CostMeter::Entry thermal = iceMass ? CostMeter::freezing : heat_ ? CostMeter::heat : CostMeter::water;
	const double reference = settings_->mixture.referenceTemperature;
	for (int start = first; start < last; start += blockSize) {
		sample.beginBlock();
		Block b;
		b.first = start;
		b.count = std::min(blockSize, last - start);
		for (int k = 0; k < b.count; ++k) {
			b.temperature[k] = b.temperatureBefore[k] = heat_ ? heat_->temperature[start + k] : reference;
			b.ice[k] = b.iceBefore[k] = iceMass ? iceMass[start + k] : 0.0;
			b.liquidSaturation[k] = b.saturationBefore[k] = iceSaturation ? 1.0 - iceSaturation[start + k] : 1.0;
		}
		findPoreVolume(b);
		if (heat_) solveTemperature(b);
		const int bad = firstImpossible(b);
		if (bad < start + b.count) return bad;
		if (heat_) {
			for (int k = 0; k < b.count; ++k)
				heat_->temperature[start + k] = b.temperature[k];
			findPoreVolume(b);
			if (iceMass && water_) exchangePhaseMomentum(b);
		}
		sample.lap(thermal);
		updateCoefficients(b);
		if (!water_) {
			sample.lap(CostMeter::heat);
			continue;
		}
		if (lastVolume_) updatePressureRate(b);
		else if (cells)
			collectPressure(b, *cells);
		else
			updatePressure(b);
		sample.lap(CostMeter::water);
	}
	return last;
}

template <int D> std::string PoreContent<D>::complaint(int p) const
{
	const MixtureProperties& m = settings_->mixture;
	std::ostringstream       text;
	const double             t    = heat_ ? heat_->temperature[p] : m.referenceTemperature;
	const double             pore = volume_[p] - solidMass[p] / m.densityAt(m.solid, t);
	text << "volume " << volume_[p] << ", porosity " << pore / volume_[p] << ", water mass " << waterMass[p] << " kg";
	if (iceMass) text << ", ice mass " << iceMass[p] << " kg";
	if (heat_) text << ", enthalpy " << heat_->enthalpy[p] << " J, temperature " << t << " degC";
	if (!(pore >= smallestPorosity * volume_[p])) text << ": the pores are crushed; use a stiffer skeleton or a smaller time step";
	else
		text << ": no possible state; use a smaller time step";
	return text.str();
}

template class PoreContent<2>;
template class PoreContent<3>;

} // namespace talik
