// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// InterFrost TH2 (Grenier et al. 2018, Adv. Water Resour. 114): a frozen square in rigid ground that water flows through, by finite
// volumes. Nothing here uses the code of pkg/.
//
// Published with the case (project's wiki, COMSOL's model library): 3 m by 1 m, square of 1/3 m around (1 m, 0.5 m) at -5 degC in ground
// of +5 degC, left face at +5 degC, no conduction through the other faces, heads that differ by 0, 3, 9 or 15 % of the length. From
// the project's parameter sheet at second hand, so not certain: porosity, permeability, viscosity, impedance and the properties
// of the phases. A comparison on equal parameters does not depend on them; hours of the published figures may.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace talik::reference {

struct FrozenInclusion {
	double length = 3.0, height = 1.0, side = 1.0 / 3.0, centreX = 1.0; ///< [m]; centre at half the height
	double cold = -5.0, warm = 5.0;                                     ///< [degC]
	double headDifference = 0.03 * 3.0;                                 ///< between left and right face [m]

	double porosity = 0.37, permeability = 1.3e-10, viscosity = 1.793e-3, gravity = 9.81; ///< [-, m^2, Pa s, m/s^2]
	double impedance = 50.0, smallestRelative = 1e-6;                                     ///< k_r = max(1e-6, 10^(-50 n (1 - S_w)))
	double residual = 0.05, width = 0.5;                                                  ///< S_w = S_r + (1 - S_r) exp(-(T/W)^2), T < 0 [-, K]
	double waterDensity = 1000.0, iceDensity = 920.0, solidDensity = 2650.0;
	double waterHeat = 4182.0, iceHeat = 2060.0, solidHeat = 835.0;                  ///< [J/(kg K)]
	double waterConductivity = 0.6, iceConductivity = 2.14, solidConductivity = 9.0; ///< [W/(m K)]
	double latentHeat = 334e3; ///< of the mass of ice [J/kg]; water that melts takes the volume of its ice

	bool   frozenAtStart(double x, double y) const { return std::abs(x - centreX) < 0.5 * side && std::abs(y - 0.5 * height) < 0.5 * side; }
	double saturation(double t) const { return t >= 0.0 ? 1.0 : residual + (1.0 - residual) * std::exp(-t * t / (width * width)); }
	double thawedConductivity() const { return permeability * waterDensity * gravity / viscosity; } ///< hydraulic [m/s]
	double relative(double t) const { return std::max(smallestRelative, std::pow(10.0, -impedance * porosity * (1.0 - saturation(t)))); }
	double conductivity(double t) const
	{
		const double s = saturation(t);
		return (1.0 - porosity) * solidConductivity + porosity * (s * waterConductivity + (1.0 - s) * iceConductivity);
	}
	/// Enthalpy per volume, ground of 0 degC without ice at zero; and its slope [J/m^3, J/(m^3 K)].
	std::array<double, 2> enthalpy(double t) const
	{
		const double s = saturation(t), slope = t < 0.0 ? -2.0 * t / (width * width) * (s - residual) : 0.0;
		const double ice = porosity * (1.0 - s), grains = (1.0 - porosity) * solidDensity * solidHeat;
		const double capacity = grains + porosity * s * waterDensity * waterHeat + ice * iceDensity * iceHeat;
		const double melting  = porosity * slope * (iceDensity * latentHeat + (waterDensity * waterHeat - iceDensity * iceHeat) * t);
		return { capacity * t - ice * iceDensity * latentHeat, capacity + melting };
	}
	double temperature(double enthalpyPerVolume, double guess) const
	{
		if (enthalpyPerVolume >= 0.0) return enthalpyPerVolume / enthalpy(0.0)[1];
		double low = -20.0, high = 0.0, t = std::min(guess, 0.0);
		for (int k = 0; k < 100; ++k) {
			const auto [h, slope] = enthalpy(t);
			const double residue = h - enthalpyPerVolume, newton = t - residue / slope;
			if (std::abs(newton - t) < 1e-11) break;
			(residue > 0.0 ? high : low) = t;
			t                            = newton > low && newton < high ? newton : 0.5 * (low + high);
		}
		return t;
	}
};

/// Lower half of the channel in square cells: two-point fluxes with harmonic means for water and heat, advection by the mean of both
/// cells (Peclet number of a cell below one), explicit in time; pressure without storage, by conjugate gradients in every
/// fourth step, in which the temperature of a cell moves little.
class FrozenInclusionVolumes {
public:
	/// cells: over half the height; a multiple of 6 puts the edges of the square on faces in y.
	FrozenInclusionVolumes(const FrozenInclusion& scene, int cells)
	        : scene_(scene)
	        , ny_(cells)
	        , nx_(int(std::lround(2.0 * cells * scene.length / scene.height)))
	        , h_(0.5 * scene.height / cells)
	        , head_(size())
	        , temperature_(size())
	        , enthalpy_(size())
	        , flowX_((nx_ + 1) * ny_)
	        , flowY_(nx_ * (ny_ + 1))
	{
		for (int j = 0; j < ny_; ++j)
			for (int i = 0; i < nx_; ++i) {
				const double x         = (i + 0.5) * h_;
				temperature_[at(i, j)] = scene.frozenAtStart(x, (j + 0.5) * h_) ? scene.cold : scene.warm;
				enthalpy_[at(i, j)]    = scene.enthalpy(temperature_[at(i, j)])[0];
				head_[at(i, j)]        = scene.headDifference * (1.0 - x / scene.length);
			}
		const double stiffest = scene.conductivity(0.0) / scene.enthalpy(0.0)[1];
		step_                 = 0.8 * h_ * h_ / (4.0 * std::max(stiffest, scene.conductivity(scene.cold) / scene.enthalpy(scene.cold)[1]));
	}

	double time() const { return time_; }
	void   marchTo(double instant)
	{
		const int count = int(std::ceil((instant - time_) / step_ * (1.0 - 1e-12)));
		for (int k = 0; k < count; ++k)
			advance((instant - time_) / (count - k));
	}

	double lowestTemperature() const { return *std::min_element(temperature_.begin(), temperature_.end()); }
	/// Volume of liquid water in the whole channel [m^3/m].
	double liquidVolume() const
	{
		double sum = 0.0;
		for (const double t : temperature_)
			sum += 2.0 * scene_.porosity * scene_.saturation(t) * h_ * h_;
		return sum;
	}
	/// Water through the right face of the whole channel [m^2/s].
	double discharge() const
	{
		double sum = 0.0;
		for (int j = 0; j < ny_; ++j)
			sum += 2.0 * flowX_[j * (nx_ + 1) + nx_] * h_;
		return sum;
	}

private:
	int           size() const { return nx_ * ny_; }
	int           at(int i, int j) const { return j * nx_ + i; }
	static double harmonic(double a, double b) { return 2.0 * a * b / (a + b); }

	void advance(double dt)
	{
		if (scene_.headDifference != 0.0 && steps_++ % 4 == 0) solvePressure();
		std::vector<double> lambda(size());
		for (int c = 0; c < size(); ++c)
			lambda[c] = scene_.conductivity(temperature_[c]);
		const double perVolume = scene_.waterDensity * scene_.waterHeat, share = dt / h_;
		for (int j = 0; j < ny_; ++j)
			for (int i = 0; i <= nx_; ++i) {
				const double flow = flowX_[j * (nx_ + 1) + i];
				if (i == nx_) { // out of the channel with the temperature of the last cell
					enthalpy_[at(nx_ - 1, j)] -= share * perVolume * flow * temperature_[at(nx_ - 1, j)];
					continue;
				}
				const int    right     = at(i, j);
				const double left      = i > 0 ? temperature_[right - 1] : scene_.warm;
				const double conducted = i > 0 ? harmonic(lambda[right - 1], lambda[right]) : 2.0 * lambda[right];
				const double carried   = i > 0 ? 0.5 * (left + temperature_[right]) : left;
				const double heat      = conducted * (left - temperature_[right]) / h_ + perVolume * flow * carried;
				enthalpy_[right] += share * heat;
				if (i > 0) enthalpy_[right - 1] -= share * heat;
			}
		for (int j = 1; j < ny_; ++j)
			for (int i = 0; i < nx_; ++i) {
				const int    above = at(i, j), below = above - nx_;
				const double heat = harmonic(lambda[below], lambda[above]) * (temperature_[below] - temperature_[above]) / h_
				        + perVolume * flowY_[j * nx_ + i] * 0.5 * (temperature_[below] + temperature_[above]);
				enthalpy_[above] += share * heat;
				enthalpy_[below] -= share * heat;
			}
		for (int c = 0; c < size(); ++c)
			temperature_[c] = scene_.temperature(enthalpy_[c], temperature_[c]);
		time_ += dt;
	}

	/// div (k grad head) = 0 with the heads of the last step as first guess.
	void solvePressure()
	{
		const double        k0 = scene_.thawedConductivity();
		std::vector<double> k(size()), diagonal(size(), 0.0), east(size(), 0.0), north(size(), 0.0), residual(size(), 0.0);
		for (int c = 0; c < size(); ++c)
			k[c] = scene_.relative(temperature_[c]);
		for (int j = 0; j < ny_; ++j)
			for (int i = 0; i < nx_; ++i) {
				const int c = at(i, j);
				if (i + 1 < nx_) east[c] = harmonic(k[c], k[c + 1]);
				if (j + 1 < ny_) north[c] = harmonic(k[c], k[c + nx_]);
				diagonal[c] += east[c] + north[c] + (i > 0 ? east[c - 1] : 2.0 * k[c]) + (j > 0 ? north[c - nx_] : 0.0)
				        + (i + 1 == nx_ ? 2.0 * k[c] : 0.0);
				if (i == 0) residual[c] += 2.0 * k[c] * scene_.headDifference;
			}
		const auto product = [&](const std::vector<double>& v, std::vector<double>& out) {
			for (int j = 0; j < ny_; ++j)
				for (int i = 0; i < nx_; ++i) {
					const int c = at(i, j);
					double    s = diagonal[c] * v[c];
					if (i > 0) s -= east[c - 1] * v[c - 1];
					if (i + 1 < nx_) s -= east[c] * v[c + 1];
					if (j > 0) s -= north[c - nx_] * v[c - nx_];
					if (j + 1 < ny_) s -= north[c] * v[c + nx_];
					out[c] = s;
				}
		};
		std::vector<double> image(size()), direction(size());
		product(head_, image);
		double largest = 0.0, weight = 0.0;
		for (int c = 0; c < size(); ++c) {
			largest = std::max(largest, std::abs(residual[c]));
			residual[c] -= image[c];
			direction[c] = residual[c] / diagonal[c];
			weight += residual[c] * direction[c];
		}
		const double enough = 1e-13 * largest * largest;
		for (int n = 0; n < 5000 && weight > enough; ++n) {
			product(direction, image);
			double along = 0.0, next = 0.0;
			for (int c = 0; c < size(); ++c)
				along += direction[c] * image[c];
			const double a = weight / along;
			for (int c = 0; c < size(); ++c) {
				head_[c] += a * direction[c];
				residual[c] -= a * image[c];
				next += residual[c] * residual[c] / diagonal[c];
			}
			for (int c = 0; c < size(); ++c)
				direction[c] = residual[c] / diagonal[c] + next / weight * direction[c];
			weight = next;
		}
		for (int j = 0; j < ny_; ++j)
			for (int i = 0; i <= nx_; ++i) {
				const int c = at(std::min(i, nx_ - 1), j);
				double&   q = flowX_[j * (nx_ + 1) + i];
				if (i == 0) q = k0 * 2.0 * k[c] * (scene_.headDifference - head_[c]) / h_;
				else if (i == nx_) q = k0 * 2.0 * k[c] * head_[c] / h_;
				else q = k0 * east[c - 1] * (head_[c - 1] - head_[c]) / h_;
			}
		for (int j = 1; j < ny_; ++j)
			for (int i = 0; i < nx_; ++i)
				flowY_[j * nx_ + i] = k0 * north[at(i, j - 1)] * (head_[at(i, j - 1)] - head_[at(i, j)]) / h_;
	}

	FrozenInclusion     scene_;
	int                 ny_, nx_;
	double              h_, step_ = 0.0, time_ = 0.0;
	long                steps_ = 0;
	std::vector<double> head_, temperature_, enthalpy_, flowX_, flowY_;
};

} // namespace talik::reference
