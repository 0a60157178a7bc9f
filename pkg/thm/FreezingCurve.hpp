// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace talik {

class EnthalpyModel;
struct EnthalpyBatch;

/// Named parameter values of a freezing curve.
using CurveParameters = std::map<std::string, double>;

/// Soil freezing characteristic curve S_l(T): liquid saturation against temperature [degC].
/// S_l = 1 at and above freezingTemperature, decreasing to residualSaturation below; all curves are monotone.
class FreezingCurve {
public:
	virtual ~FreezingCurve() = default;

	virtual std::string name() const                = 0;
	virtual double      freezingTemperature() const = 0; ///< T_f [degC]
	virtual double      residualSaturation() const  = 0; ///< S_r [-]
	/// True if S_l jumps at T_f; liquid saturation is then an unknown of its own at T_f.
	virtual bool isSharp() const = 0;

	virtual double liquidSaturation(double temperature) const = 0; ///< S_l in [S_r, 1]
	virtual double derivative(double temperature) const       = 0; ///< dS_l/dT >= 0 [1/K]

	/// T(H) for every entry of the batch with this curve's own code, see EnthalpyModel::temperatures.
	virtual std::size_t solveTemperatures(const EnthalpyModel& model, const EnthalpyBatch& batch) const = 0;
};

using FreezingCurvePtr = std::shared_ptr<const FreezingCurve>;

/// Makes a curve by its name: vanGenuchten, gauss, exponential, power, linear, sharp. Parameters that are not given take
/// their defaults. Throws std::invalid_argument for an unknown name or parameter, or a value out of range.
FreezingCurvePtr makeFreezingCurve(const std::string& name = "gauss", const CurveParameters& parameters = {});

/// A measured point of a freezing curve.
struct CurvePoint {
	double temperature;      ///< [degC]
	double liquidSaturation; ///< [-], 0 to 1
};

/// The curve through measured points, in ascending order of temperature: linear in between, constant below the first. T_f is the temperature of the
/// first point with S_l = 1, S_r the saturation of the first point. Throws std::invalid_argument for points that are none of a monotone curve.
FreezingCurvePtr makeFreezingCurve(const std::vector<CurvePoint>& points);

/// The curve of ground that never freezes: S_l = 1 at any temperature.
FreezingCurvePtr unfrozenCurve();

/// Names of all registered curves, in alphabetical order.
std::vector<std::string> freezingCurveNames();

/// Parameters of a registered curve with their defaults.
CurveParameters freezingCurveParameters(const std::string& name);

} // namespace talik
