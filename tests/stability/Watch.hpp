// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// What every hard case is held to: finite state, no energy from nowhere, balances that close, temperatures between those given.

#include <pkg/mpm/Ground.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace talik::stability {

/// The worst that a run has shown.
struct Figures {
	double      energyCreated = 0.0; ///< largest mechanical energy that no work accounts for, over all that was turned over [-]
	double      kineticPeak   = 0.0; ///< [J]
	double      solidDrift = 0.0, waterDrift = 0.0, heatDrift = 0.0; ///< [-]; heat over the largest of content and exchange
	double      momentumDrift = 0.0;                                 ///< momentum less logged impulse, over the largest of both [-]
	double      strain        = 0.0;                                 ///< largest change of a point's volume over its initial one [-]
	double      coldest = INFINITY, hottest = -INFINITY;             ///< of points [degC]
	bool        finite = true;
	long        steps  = 0;
	std::string stopped; ///< sentence of the error that ended the run; empty if none

	double worstDrift() const { return std::max({ solidDrift, waterDrift, heatDrift, momentumDrift }); }
};

/// What meets the ground from outside.
struct Outside {
	std::function<void(double)> advance     = [](double) {};           ///< by a time step [s], after the ground
	std::function<double()>     energy      = [] { return 0.0; };      ///< mechanical, that the ground may take or give [J]
	std::function<double()>     longestStep = [] { return INFINITY; }; ///< that it stands [s]
};

/// Compares the balance of a ground with that at the start; needs GroundSettings::energyLedger for the energy.
template <int D> class Watch {
public:
	explicit Watch(Ground<D>& ground, Outside outside = {})
	        : ground_(ground)
	        , outside_(std::move(outside))
	        , start_(ground.balance())
	        , outsideStart_(outside_.energy())
	{
		for (const FieldInfo& f : ground.fields())
			if (f.place == "points") names_.push_back(f);
		volume_.resize(ground.points().count());
		ground.copyById("volume", 0, volume_.data());
	}

	/// Adds the present state to the figures.
	void look()
	{
		const Balance<D> now = ground_.balance();
		figures_.steps       = ground_.steps();
		keepEnergy(now);
		keepDrifts(now);
		keepFields();
	}

	/// Steps count times with the stable step that the ground proposes, times a factor; looks every few steps. An error ends the run
	/// and is kept.
	void run(long count, long every = 20, double factor = 1.0)
	{
		try {
			for (long k = 0; k < count && figures_.finite; ++k) {
				const double dt = factor * std::min(ground_.stableTimeStep().step, outside_.longestStep());
				ground_.step(dt);
				outside_.advance(dt);
				if ((k + 1) % every == 0 || k + 1 == count) look();
			}
		} catch (const std::exception& error) {
			figures_.stopped = error.what();
		}
	}

	const Figures& figures() const { return figures_; }

private:
	static constexpr double slowest = 1e-3; ///< [m/s]; the scale of ground that cannot move

	static double size(const Vec<D>& v)
	{
		double sum = 0.0;
		for (int a = 0; a < D; ++a)
			sum += v[a] * v[a];
		return std::sqrt(sum);
	}

	void keepEnergy(const Balance<D>& b)
	{
		const double brought = outsideStart_ - outside_.energy();
		const double held    = b.kineticEnergy - start_.kineticEnergy + b.gravityEnergy + b.waterEnergyOut - start_.gravityEnergy - brought;
		const double spent   = b.skeletonWork + b.porePressureWork - b.workAhead + b.dragDissipation + b.dampingDissipation - b.loadWork - b.wallWork
		        - b.segregationWork;
		const double turned = b.kineticEnergy + start_.kineticEnergy + std::abs(b.gravityEnergy - start_.gravityEnergy) + std::abs(b.skeletonWork)
		        + std::abs(b.porePressureWork) + b.dragDissipation + b.dampingDissipation + std::abs(b.loadWork) + std::abs(b.wallWork)
		        + std::abs(b.segregationWork) + std::abs(brought);
		// of ground at rest the height of every point is rounded in every step
		const double rounded = 1e-10 * std::abs(b.gravityEnergy);
		turnedOver_          = std::max({ turnedOver_, turned, rounded, 1e-6 * slowest * slowest * (b.solidMass + b.waterMass) });
		figures_.kineticPeak = std::max(figures_.kineticPeak, b.kineticEnergy);
		if (turnedOver_ > 0.0) figures_.energyCreated = std::max(figures_.energyCreated, (held + spent) / turnedOver_);
		if (!std::isfinite(held + spent)) figures_.finite = false;
	}

	void keepDrifts(const Balance<D>& b)
	{
		const auto keep = [](double& worst, double drift, double scale) {
			if (scale > 0.0) worst = std::max(worst, std::abs(drift) / scale);
		};
		keep(figures_.solidDrift, b.solidMass - start_.solidMass, start_.solidMass);
		keep(figures_.waterDrift, b.waterMass + b.waterOut - start_.waterMass, start_.waterMass);
		heatScale_ = std::max({ heatScale_, std::abs(b.enthalpy), std::abs(start_.enthalpy), std::abs(b.heatIn), std::abs(b.enthalpyOut) });
		keep(figures_.heatDrift, b.enthalpy + b.enthalpyOut - start_.enthalpy - b.heatIn, heatScale_);
		const double mass   = b.solidMass + b.waterMass;
		const double weight = mass * size(ground_.settings().motion ? ground_.settings().motion->gravity : Vec<D> {});
		momentumScale_      = std::max({ momentumScale_, weight * b.time, mass * slowest, size(b.impulse), std::sqrt(2.0 * b.kineticEnergy * mass) });
		Vec<D> missing;
		for (int a = 0; a < D; ++a)
			missing[a] = b.momentum[a] - start_.momentum[a] - (b.impulse[a] - start_.impulse[a]);
		keep(figures_.momentumDrift, size(missing), momentumScale_);
	}

	void keepFields()
	{
		std::vector<double> values(ground_.points().count());
		for (const FieldInfo& f : names_)
			for (int c = 0; c < f.components; ++c) {
				ground_.copyById(f.name, c, values.data());
				for (const double v : values)
					figures_.finite = figures_.finite && std::isfinite(v);
				if (f.name == "volume")
					for (std::size_t p = 0; p < values.size(); ++p)
						figures_.strain = std::max(figures_.strain, std::abs(values[p] / volume_[p] - 1.0));
				if (f.name != "temperature") continue;
				figures_.coldest = std::min(figures_.coldest, *std::min_element(values.begin(), values.end()));
				figures_.hottest = std::max(figures_.hottest, *std::max_element(values.begin(), values.end()));
			}
	}

	Ground<D>&             ground_;
	Outside                outside_;
	Balance<D>             start_;
	double                 outsideStart_; ///< [J]
	std::vector<FieldInfo> names_;
	std::vector<double>    volume_; ///< at the start, by id [m^D]
	Figures                figures_;
	double                 turnedOver_ = 0.0, heatScale_ = 0.0, momentumScale_ = 0.0;
};

} // namespace talik::stability
