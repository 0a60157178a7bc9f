// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/MpmEngine.hpp>
#include <pkg/multiscale/Plausibility.hpp>

#include <cmath>
#include <map>
#include <sstream>

using namespace yade;

namespace talik {
namespace {
	using Points = std::vector<PointInput<2>>;

	class Doubts {
	public:
		template <class... Parts> void add(bool grave, const Parts&... parts)
		{
			std::ostringstream text;
			text.precision(4);
			(text << ... << parts);
			list.push_back({ text.str(), grave });
		}
		std::vector<Doubt> list;
	};

	double median(std::vector<double> values)
	{
		const auto middle = values.begin() + long(values.size() / 2);
		std::nth_element(values.begin(), middle, values.end());
		return *middle;
	}

	/// Ids of points by square boxes of a given side.
	std::map<std::pair<long, long>, std::vector<int>> boxesOf(const Points& points, double side)
	{
		double low[2] = { points[0].position[0], points[0].position[1] };
		for (const auto& point : points)
			for (int a = 0; a < 2; a++)
				low[a] = std::min(low[a], point.position[a]);
		std::map<std::pair<long, long>, std::vector<int>> boxes;
		for (std::size_t i = 0; i < points.size(); i++) {
			const auto place = [&](int a) { return long(std::floor((points[i].position[a] - low[a]) / side + 0.5)); };
			boxes[{ place(0), place(1) }].push_back(int(i));
		}
		return boxes;
	}

	/// Distance to the nearest other point; infinite where none is within two sides of a box.
	std::vector<double> nearestDistances(const Points& points, double side)
	{
		const auto          boxes = boxesOf(points, side);
		std::vector<double> nearest(points.size(), std::numeric_limits<double>::infinity());
		for (const auto& [place, ids] : boxes)
			for (long dx = -2; dx <= 2; dx++)
				for (long dy = -2; dy <= 2; dy++) {
					const auto others = boxes.find({ place.first + dx, place.second + dy });
					if (others == boxes.end()) continue;
					for (const int i : ids)
						for (const int j : others->second)
							if (i != j)
								nearest[i] = std::min(
								        nearest[i],
								        std::hypot(
								                points[i].position[0] - points[j].position[0],
								                points[i].position[1] - points[j].position[1]));
				}
		return nearest;
	}

	void doubtPlaces(Doubts& doubts, const Points& points, double spacing)
	{
		std::vector<double> volumes;
		double              sum = 0;
		for (const auto& point : points) {
			if (!(point.volume > 0) || !std::isfinite(point.position[0]) || !std::isfinite(point.position[1])) return; // refused anyway
			volumes.push_back(point.volume);
			sum += point.volume;
		}
		const double usual = median(volumes), side = std::sqrt(usual), room = usual * double(boxesOf(points, side).size());
		if (points.size() > 3 && sum > 1.8 * room)
			doubts.add(
			        true, "The volumes of the points add to ", sum, " m^2 in a room of some ", room,
			        " m^2: was an outline filled twice, or volume (median ", usual, " m^2) given for more than one point?");
		if (points.size() < 4) return;
		const auto   distances = nearestDistances(points, 0.75 * spacing);
		const double apart     = median(distances);
		if (!(apart <= 1.2 * spacing))
			doubts.add(
			        true, "MpmEngine.gridSpacing is ", spacing, " m and most points have no other one within ", 1.2 * spacing,
			        " m: the grid cannot carry ground whose points are farther apart than its nodes; give smaller points or a coarser grid.");
		else if (usual < 0.1 * apart * apart)
			doubts.add(
			        true, "The volume of the points is ", usual, " m^2 (median) where their distance of ", apart, " m makes ", apart * apart,
			        " m^2: was volume meant to be that?");
	}

	void doubtStates(Doubts& doubts, const MpmEngine& mpm, const Points& points)
	{
		double stress = 0, tension = 0, pressure = 0;
		int    tensile = 0;
		for (const auto& point : points) {
			if (std::isfinite(point.stress[0])) {
				for (const int c : { 0, 1, 2 })
					stress = std::max(stress, std::abs(point.stress[c]));
				const double most = std::max({ point.stress[0], point.stress[1], point.stress[2] });
				tensile += most > 0;
				tension = std::max(tension, most);
			}
			pressure = std::max(pressure, std::abs(point.pressure));
		}
		if (tensile > 0)
			doubts.add(
			        true, "addPoints: stress of ", tensile, " points is tensile, up to ", tension,
			        " Pa: was compression meant? Compression is negative.");
		if (mpm.motion && stress > 0 && stress < 500)
			doubts.add(false, "addPoints: stress is ", stress, " Pa at most: was ", stress * 1e3, " Pa (kPa) meant?");
		if (mpm.water && pressure > 0 && pressure < 200)
			doubts.add(false, "addPoints: pressure is ", pressure, " Pa at most: was ", pressure * 1e3, " Pa (kPa) meant?");
	}

	struct Range {
		const char* name;
		double      value, least, most;
		const char* unit;
	};

	/// Where a thousand times more or less would do, that was meant.
	void doubtRange(Doubts& doubts, bool grave, const Range& r)
	{
		if (r.value == 0 || !std::isfinite(r.value) || (r.value >= r.least && r.value <= r.most)) return;
		const double meant = r.value < r.least ? r.value * 1e3 : r.value / 1e3;
		if (meant >= r.least && meant <= r.most) doubts.add(grave, r.name, " is ", r.value, " ", r.unit, ": was ", meant, " meant?");
		else doubts.add(grave, r.name, " is ", r.value, " ", r.unit, ": ", r.least, " to ", r.most, " would be usual.");
	}

	void doubtMaterial(Doubts& doubts, const MpmEngine& mpm)
	{
		const auto& m = *mpm.material;
		for (const Range& r : { Range { "GroundMaterial.solidDensity", m.solidDensity, 300, 2e4, "kg/m^3" },
		                        Range { "GroundMaterial.iceDensity", m.iceDensity, 300, 2e4, "kg/m^3" },
		                        Range { "GroundMaterial.liquidDensity", m.liquidDensity, 300, 2e4, "kg/m^3" } })
			doubtRange(doubts, true, r);
		if (!mpm.heat) return;
		for (const Range& r : { Range { "GroundMaterial.solidSpecificHeat", m.solidSpecificHeat, 50, 2e4, "J/(kg K)" },
		                        Range { "GroundMaterial.iceSpecificHeat", m.iceSpecificHeat, 50, 2e4, "J/(kg K)" },
		                        Range { "GroundMaterial.liquidSpecificHeat", m.liquidSpecificHeat, 50, 2e4, "J/(kg K)" },
		                        Range { "GroundMaterial.latentHeat", m.latentHeat, 1e4, 1e7, "J/kg" },
		                        Range { "GroundMaterial.solidConductivity", m.solidConductivity, 0.01, 500, "W/(m K)" },
		                        Range { "GroundMaterial.iceConductivity", m.iceConductivity, 0.01, 500, "W/(m K)" },
		                        Range { "GroundMaterial.liquidConductivity", m.liquidConductivity, 0.01, 500, "W/(m K)" } })
			doubtRange(doubts, true, r);
	}

	void doubtAngle(Doubts& doubts, const char* name, double degrees)
	{
		if (degrees > 0 && degrees < 1.58)
			doubts.add(true, name, " is ", degrees, " degrees: was ", degrees * 180 / M_PI, " (the same number in radians) meant?");
	}

	void doubtSkeletons(Doubts& doubts, const MpmEngine& mpm)
	{
		for (const auto& law : mpm.activeSkeletons()) {
			if (const auto* elastic = dynamic_cast<const yade::ElasticSkeleton*>(law.get()))
				doubtRange(doubts, false, Range { "ElasticSkeleton.young", elastic->young, 1e4, 1e12, "Pa" });
			if (const auto* mohrCoulomb = dynamic_cast<const yade::MohrCoulombSkeleton*>(law.get())) {
				doubtAngle(doubts, "MohrCoulombSkeleton.frictionAngle", mohrCoulomb->frictionAngle);
				doubtRange(doubts, false, Range { "MohrCoulombSkeleton.young", mohrCoulomb->young, 1e4, 1e12, "Pa" });
				doubtRange(doubts, false, Range { "MohrCoulombSkeleton.cohesionFrozen", mohrCoulomb->cohesionFrozen, 10, 1e9, "Pa" });
			}
		}
	}

	double largest(double constant, const std::vector<double>& table)
	{
		double most = table.empty() ? std::abs(constant) : 0;
		for (const double value : table)
			most = std::max(most, std::abs(value));
		return most;
	}

	void doubtBoundaries(Doubts& doubts, const MpmEngine& mpm)
	{
		for (const auto& boundary : mpm.boundaries) {
			if (const auto* load = dynamic_cast<const yade::SurfaceLoad*>(boundary.get())) {
				const double p = largest(load->pressure, load->values);
				if (p > 0 && p < 500) doubts.add(false, "SurfaceLoad.pressure is ", p, " Pa at most: was ", p * 1e3, " Pa (kPa) meant?");
			}
			if (const auto* flux = dynamic_cast<const yade::WaterFlux*>(boundary.get())) {
				const double q = largest(flux->flux, flux->values);
				if (q > 0.1) doubts.add(false, "WaterFlux.flux is ", q, " m/s: was ", q / 1e3 / 3600, " m/s (", q, " mm per hour) meant?");
			}
		}
	}
} // namespace

std::vector<Doubt> doubtsAbout(const MpmEngine& mpm, const Points& points)
{
	Doubts doubts;
	if (mpm.gridSpacing > 0 && !points.empty()) doubtPlaces(doubts, points, mpm.gridSpacing);
	if (mpm.motion && mpm.gravity[1] > 0)
		doubts.add(
		        true, "MpmEngine.gravity is (", mpm.gravity[0], ", ", mpm.gravity[1], ") m/s^2, upwards: was (", mpm.gravity[0], ", ", -mpm.gravity[1],
		        ") meant?");
	if (mpm.material) doubtMaterial(doubts, mpm);
	doubtStates(doubts, mpm, points);
	if (mpm.motion) doubtSkeletons(doubts, mpm);
	if (mpm.water && (mpm.water->conductivity < 1e-14 || mpm.water->conductivity > 1))
		doubts.add(
		        false, "PoreWater.conductivity is ", mpm.water->conductivity,
		        " m/s: soils and rocks have 1e-14 to 1 m/s; was a permeability in m^2 given, or a unit other than m/s?");
	doubtBoundaries(doubts, mpm);
	return doubts.list;
}

} // namespace talik
