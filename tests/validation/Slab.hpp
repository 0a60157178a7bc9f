// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// A thawed layer on frozen ground, both of the same Mohr-Coulomb law: the closed form that decides whether a slope slides as it should.

#include "Scenes.hpp"

#include <algorithm>

namespace talik::validation {

/// The front rises by `front` degrees to the grid, the layer slides downhill to the right; gravity acts at `slope` to its normal.
struct Slab {
	double                                  thickness = 1.0;                   ///< X over h, a multiple of 1/2
	double                                  above     = 0.0;                   ///< front above a node over h, multiple of 1/4; along the grid only
	double                                  front     = 0.0;                   ///< of the front to the grid [degrees]
	double                                  slope     = 45.0;                  ///< of the front to the horizontal [degrees]
	double                                  friction  = 26.0;                  ///< phi [degrees]
	double                                  dilation  = 0.0;                   ///< psi [degrees]
	double                                  cohesion  = 0.0;                   ///< of thawed ground [Pa]
	double                                  spacing   = 0.25;                  ///< h [m]
	double                                  young = 20e6, youngFrozen = 100e6; ///< [Pa]
	double                                  length     = 40.0;                 ///< of the layer over h
	bool                                    wallToWall = false;                ///< the layer fills the box, so that it has no ends to fall
	bool                                    wet        = false;                ///< saturated, water free to flow parallel to the front
	std::function<void(GroundSettings<2>&)> change;                            ///< of the settings

	static constexpr double porosity = 0.4, gravity = 9.81;
	static double           radians(double degrees) { return degrees * 0.017453292519943295; }
	double                  depth() const { return thickness * spacing; }
	double                  sine() const { return std::sin(radians(friction)); }
	/// tau/sigma_n at which simple shear goes on: tan(phi) with psi = phi, sin(phi) without dilation (Davis 1968).
	double ratio() const { return dilation == friction ? std::tan(radians(friction)) : sine(); }
	double density() const { return (1.0 - porosity) * 2650.0 + porosity * 1000.0; }
	/// Part of the total normal stress that grains carry: seepage parallel to the slope leaves p = rho_l g cos(slope) d.
	double effective() const { return wet ? 1.0 - 1000.0 / density() : 1.0; }
	double acceleration() const
	{
		const double carried = ratio() * std::cos(radians(slope)) * effective() + cohesion * cohesionShare() / (density() * gravity * depth());
		return gravity * (std::sin(radians(slope)) - carried);
	}
	double cohesionShare() const { return dilation == friction ? 1.0 : std::cos(radians(friction)); }
};

class SlabScene {
public:
	explicit SlabScene(const Slab& slab)
	        : slab_(slab)
	        , down_ { std::cos(Slab::radians(slab.front)), -std::sin(Slab::radians(slab.front)) }
	        , up_ { std::sin(Slab::radians(slab.front)), std::cos(Slab::radians(slab.front)) }
	{
		build();
	}

	Ground<2>& ground() { return *ground_; }
	/// Mean displacement of the top row at mid-length, downhill along the front [m].
	double displacement() const { return displacementBetween(slab_.depth() - 0.6 * slab_.spacing, slab_.depth()); }
	/// The same of the points that started at mid-length between two heights over the front [m].
	double displacementBetween(double lower, double upper) const
	{
		const auto x = valuesOf(*ground_, "displacement", 0), y = valuesOf(*ground_, "displacement", 1);
		double     sum   = 0.0;
		int        count = 0;
		for (const LayerPoint& p : layer_) {
			if (std::abs(p.along) >= 3.0 * slab_.spacing || !(p.height > lower && p.height < upper)) continue;
			sum += x[p.id] * down_[0] + y[p.id] * down_[1];
			++count;
		}
		return sum / count;
	}
	/// Freezes the points of the layer that started between two heights over the front [m].
	void freeze(double lower, double upper)
	{
		for (const LayerPoint& p : layer_)
			if (p.height > lower && p.height < upper) ground_->setThermalState(p.id, -10.0, 0.0);
	}
	/// Displacement over a t^2/2 after some time [s] from the start.
	double slide(double duration)
	{
		marchTo(*ground_, duration);
		return displacement() / (0.5 * slab_.acceleration() * duration * duration);
	}

private:
	/// A point of the layer, and where it started in the frame of the front [m].
	struct LayerPoint {
		int    id;
		double along, height;
	};

	void build()
	{
		const double      h = slab_.spacing, beta = Slab::radians(slab_.slope), tilt = beta - Slab::radians(slab_.front);
		GroundSettings<2> s;
		s.gridSpacing       = h;
		s.mixture           = withoutExpansion();
		const double across = (slab_.length + 8.0) * down_[0] * h, rise = -(slab_.length + 8.0) * down_[1] * h;
		const double cells = std::ceil(across / h + 2.0 * slab_.thickness * up_[0] + 4.0);
		base_              = std::ceil(0.5 * rise / h + 4.0) * h;
		s.upper            = { cells * h, 2.0 * base_ + std::ceil(2.0 * slab_.thickness + 4.0) * h };
		origin_            = { 0.5 * cells * h, base_ + slab_.above * h };
		s.motion.emplace();
		s.motion->gravity = { Slab::gravity * std::sin(tilt), -Slab::gravity * std::cos(tilt) };
		s.heat.emplace();
		s.freezing = makeFreezingCurve();
		if (slab_.wet) {
			s.water.emplace();
			s.water->permeability.referenceConductivity = 1e-4;
			s.water->state.liquidBulkModulus            = 2.2e7;
			s.water->state.iceBulkModulus               = 8.8e7;
		}
		auto law                   = std::make_shared<MohrCoulombSkeleton<2>>();
		law->young                 = slab_.young;
		law->youngFrozen           = slab_.youngFrozen;
		law->cohesion              = slab_.cohesion;
		law->tensileStrength       = slab_.cohesion / std::tan(Slab::radians(slab_.friction)); // no cut-off below the cone
		law->cohesionFrozen        = 50e6;
		law->tensileStrengthFrozen = 50e6;
		law->frictionAngle         = slab_.friction;
		law->dilationAngle         = slab_.dilation;
		s.skeletons.push_back(law);
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("left"));
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("right"));
		addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
		if (slab_.change) slab_.change(s);
		ground_ = std::make_unique<Ground<2>>(s);
		fill(s);
		ground_->initialise();
	}

	void fill(const GroundSettings<2>& s)
	{
		// points stand on the lattice of the grid, moved with the front; front and surface of an inclined slab are steps
		const double h = slab_.spacing, step = 0.5 * h, shift = std::fmod(slab_.above * h, step);
		int          id = 0;
		for (double y = shift + 0.5 * step - (shift > 0.0 ? step : 0.0); y < s.upper[1]; y += step)
			for (double x = 0.5 * step; x < s.upper[0]; x += step) {
				if (y < 0.0) continue;
				const double rx = x - origin_[0], ry = y - origin_[1];
				const double along = rx * down_[0] + ry * down_[1], height = rx * up_[0] + ry * up_[1];
				const bool   layer = height >= 0.0;
				if (layer && (height >= slab_.depth() || (!slab_.wallToWall && std::abs(along) >= 0.5 * slab_.length * h))) continue;
				PointInput<2> p = point(height, { x, y }, step * step);
				ground_->addPoint(p);
				if (layer) layer_.push_back({ id, along, height });
				++id;
			}
	}

	PointInput<2> point(double height, const Vec<2>& position, double volume) const
	{
		const double  beta = Slab::radians(slab_.slope), weight = slab_.density() * Slab::gravity, depth = slab_.depth() - height;
		PointInput<2> p;
		p.position    = position;
		p.volume      = volume;
		p.porosity    = Slab::porosity;
		p.temperature = height >= 0.0 ? 5.0 : -10.0;
		if (slab_.wet) p.pressure = 1000.0 * Slab::gravity * std::cos(beta) * depth;
		const double normal = weight * std::cos(beta) * slab_.effective() * depth;
		// at rest, or at strength where rest asks for more
		const auto carried = [&](double d) {
			const double strength = slab_.cohesion * std::cos(Slab::radians(slab_.friction))
			        + slab_.sine() * weight * std::cos(beta) * slab_.effective() * d;
			return std::min(strength, weight * std::sin(beta) * d);
		};
		const double shear = height >= 0.0 ? carried(depth) : carried(slab_.depth()) - weight * std::sin(beta) * height;
		// sigma = -normal 1 + shear (down up + up down), in the frame of the front; the part above pulls the part below downhill
		p.stress[0] = -normal + 2.0 * shear * down_[0] * up_[0];
		p.stress[1] = -normal + 2.0 * shear * down_[1] * up_[1];
		p.stress[2] = -normal;
		p.stress[3] = shear * (down_[0] * up_[1] + down_[1] * up_[0]);
		return p;
	}

	Slab                       slab_;
	Vec<2>                     down_, up_, origin_ {};
	double                     base_ = 0.0;
	std::unique_ptr<Ground<2>> ground_;
	std::vector<LayerPoint>    layer_;
};

} // namespace talik::validation
