// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// Reference for frost heave, which shares no code with the ground.

#include <algorithm>
#include <cmath>
#include <vector>

namespace talik::validation {

/// A column that freezes from its top, with water at its base, by finite volumes so fine that they resolve the frozen fringe: heat with latent heat,
/// Darcy flow by pressure, gravity and Clapeyron's suction, rigid grains. Pores press with no more than what lies on them; where they would, the
/// ground parts, and the water that arrives there is excess ice. Ice is as dense as water. A lens lies behind the soil of its cell, seen from the
/// water: its warm face has the temperature of that soil however thick it grows, and heat and water beyond it pass all of it.
class ResolvedFringe {
public:
	double height = 0.3, permeability = 1e-9, impedance = 6.0, load = 50e3, cold = -3.0, base = 1.0; ///< [m, m/s, -, Pa, degC, degC]
	double porosity = 0.4, conductivity = 1.5, width = 0.5, residual = 0.05;                         ///< [-, W/(m K), K, -]
	double capacity = 0.6 * 2650.0 * 800.0 + 0.4 * 1000.0 * 2940.0, capacityOfIce = 2.94e6;          ///< [J/(m^3 K)]
	int    cells      = 60;
	bool   weightless = false; ///< gravity makes no pressure

	/// Thickness of the excess ice after a time [m].
	double excessIceAfter(double time)
	{
		start();
		const double dt = 0.2 * first * first * capacity / conductivity;
		for (double t = 0.0; t < time; t += dt) {
			weigh();
			flow();
			conduct(dt);
		}
		double sum = 0.0;
		for (const double e : excess)
			sum += e;
		return sum;
	}

	/// What the force of Clapeyron draws from the base through soil with one gradient of temperature [m/s].
	double intake()
	{
		start();
		for (int i = 0; i < cells; ++i)
			temperature[i] = base + (cold - base) * (i + 0.5) / cells;
		weigh();
		flow();
		return flux[0];
	}

private:
	static constexpr double latent = 334e3, weight = 9810.0, suction = 1000.0 * latent / 273.15;

	double liquid(double t) const { return t < 0.0 ? residual + (1.0 - residual) * std::exp(-t * t / (width * width)) : 1.0; }
	double slope(double t) const { return t < 0.0 ? -2.0 * t / (width * width) * (liquid(t) - residual) : 0.0; }

	void start()
	{
		first = height / cells;
		temperature.assign(cells, base);
		for (auto* field : { &excess, &pressure, &onTop, &gain, &below, &conductance, &drive, &diagonal, &right })
			field->assign(cells, 0.0);
		flux.assign(cells + 1, 0.0);
		parted.assign(cells, 0);
	}

	void weigh()
	{
		double above = load;
		for (int i = cells - 1; i >= 0; --i) {
			const double w = (weightless ? 0.0 : 9.81) * (first * ((1.0 - porosity) * 2650.0 + porosity * 1000.0) + excess[i] * 1000.0);
			onTop[i]       = above + 0.5 * w;
			above += w;
		}
	}

	/// Active set: cells that part have the pressure of what lies on them.
	void flow()
	{
		for (int i = 0; i + 1 < cells; ++i) {
			const double gap = first + excess[i], t = 0.5 * (temperature[i] + temperature[i + 1]);
			conductance[i] = permeability * std::pow(10.0, -impedance * (1.0 - liquid(t))) / (weight * gap);
			drive[i]       = (weightless ? 0.0 : weight * gap) + suction * (std::min(temperature[i + 1], 0.0) - std::min(temperature[i], 0.0));
		}
		bool settled = false;
		for (int k = 0; k < 300 && !settled; ++k) {
			solve();
			settled = true;
			for (int i = 0; i < cells; ++i) {
				gain[i]        = flux[i] - flux[i + 1];
				const char now = parted[i] ? gain[i] > -1e-20 : pressure[i] > onTop[i] * (1.0 + 1e-12);
				settled        = settled && now == parted[i];
				parted[i]      = now;
			}
		}
	}

	void solve()
	{
		const double atBase = permeability / (weight * 0.5 * first), lift = weightless ? 0.0 : weight * 0.5 * first;
		for (int i = 0; i < cells; ++i) {
			const double down = i ? conductance[i - 1] : 0.0, up = i + 1 < cells ? conductance[i] : 0.0;
			below[i]    = parted[i] ? 0.0 : -down;
			diagonal[i] = parted[i] ? 1.0 : down + up + (i ? 0.0 : atBase);
			right[i]    = parted[i] ? onTop[i] : (i ? -down * drive[i - 1] : -atBase * lift) + (i + 1 < cells ? up * drive[i] : 0.0);
			if (i == 0) continue;
			const double m = below[i] / diagonal[i - 1];
			diagonal[i] -= m * (parted[i - 1] ? 0.0 : -conductance[i - 1]);
			right[i] -= m * right[i - 1];
		}
		for (int i = cells - 1; i >= 0; --i)
			pressure[i] = (right[i] + (i + 1 < cells && !parted[i] ? conductance[i] * pressure[i + 1] : 0.0)) / diagonal[i];
		flux[0] = -atBase * (pressure[0] + lift);
		for (int i = 0; i + 1 < cells; ++i)
			flux[i + 1] = -conductance[i] * (pressure[i + 1] - pressure[i] + drive[i]);
	}

	void conduct(double dt)
	{
		double into = -conductivity * (temperature[0] - base) / (0.5 * first);
		for (int i = 0; i < cells; ++i) {
			const bool   top = i + 1 == cells;
			const double gap = (top ? 0.5 : 1.0) * first + excess[i];
			const double out = -conductivity * ((top ? cold : temperature[i + 1]) - temperature[i]) / gap;
			const double ice = parted[i] ? gain[i] * dt : 0.0, heat = capacity * first + capacityOfIce * excess[i],
			             pores = porosity * 1000.0 * latent * first;
			const double want  = heat * temperature[i] - pores * (1.0 - liquid(temperature[i])) + (into - out) * dt + 1000.0 * latent * ice;
			into               = out;
			excess[i] += ice;
			newTemperature(i, heat, pores, want);
		}
	}

	/// Newton, kept between bounds.
	void newTemperature(int i, double heat, double pores, double want)
	{
		double low = -30.0, high = 30.0, x = temperature[i];
		for (int k = 0; k < 100; ++k) {
			const double miss         = heat * x - pores * (1.0 - liquid(x)) - want;
			(miss > 0.0 ? high : low) = x;
			double next               = x - miss / (heat + pores * slope(x));
			if (!(next > low && next < high)) next = 0.5 * (low + high);
			const bool done = std::abs(next - x) < 1e-13;
			x               = next;
			if (done) break;
		}
		temperature[i] = x;
	}

	double              first = 0.0; ///< thickness of a cell at the start [m]
	std::vector<double> temperature, excess, pressure, onTop, gain, below, conductance, drive, diagonal, right, flux;
	std::vector<char>   parted;
};

} // namespace talik::validation
