// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/engine/MpmEngine.hpp>

#include <cmath>
#include <map>
#include <sstream>

using namespace yade;

namespace talik {
namespace {
	template <int D> using Points = std::vector<PointInput<D>>;
	template <int D> using Box    = std::array<long, D>;

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

	/// Ids of points by boxes of a given side.
	template <int D> std::map<Box<D>, std::vector<int>> boxesOf(const Points<D>& points, double side)
	{
		Vec<D> low = points[0].position;
		for (const auto& point : points)
			for (int a = 0; a < D; ++a)
				low[a] = std::min(low[a], point.position[a]);
		std::map<Box<D>, std::vector<int>> boxes;
		for (std::size_t i = 0; i < points.size(); ++i) {
			Box<D> place;
			for (int a = 0; a < D; ++a)
				place[a] = long(std::floor((points[i].position[a] - low[a]) / side + 0.5));
			boxes[place].push_back(int(i));
		}
		return boxes;
	}

	/// Calls work(box) for all boxes around one, up to two away in each direction.
	template <int D, class Work> void overNeighbours(const Box<D>& middle, Work&& work)
	{
		Box<D> box;
		for (int k = 0; k < (D == 2 ? 25 : 125); ++k) {
			box    = middle;
			int in = k;
			for (int a = 0; a < D; ++a, in /= 5)
				box[a] += in % 5 - 2;
			work(box);
		}
	}

	/// Distance to the nearest other point; infinite where none is within two sides of a box.
	template <int D> std::vector<double> nearestDistances(const Points<D>& points, double side)
	{
		const auto          boxes = boxesOf<D>(points, side);
		std::vector<double> nearest(points.size(), std::numeric_limits<double>::infinity());
		for (const auto& [place, ids] : boxes) {
			const auto& here = ids;
			overNeighbours<D>(place, [&](const Box<D>& box) {
				const auto others = boxes.find(box);
				if (others == boxes.end()) return;
				for (const int i : here)
					for (const int j : others->second) {
						if (i == j) continue;
						Vec<D> apart;
						for (int a = 0; a < D; ++a)
							apart[a] = points[i].position[a] - points[j].position[a];
						nearest[i] = std::min(nearest[i], lengthOf<D>(apart));
					}
			});
		}
		return nearest;
	}

	template <int D> void doubtPlaces(Doubts& doubts, const Points<D>& points, double spacing)
	{
		const char* const   unit = D == 2 ? " m^2" : " m^3";
		std::vector<double> volumes;
		double              sum = 0;
		for (const auto& point : points) {
			if (!(point.volume > 0) || !std::isfinite(lengthOf<D>(point.position))) return; // refused anyway
			volumes.push_back(point.volume);
			sum += point.volume;
		}
		const double usual = median(volumes), side = D == 2 ? std::sqrt(usual) : std::cbrt(usual),
		             room = usual * double(boxesOf<D>(points, side).size());
		if (points.size() > 3 && sum > 1.8 * room)
			doubts.add(
			        true, "The volumes of the points add to ", sum, unit, " in a room of some ", room, unit,
			        ": was an outline filled twice, or volume (median ", usual, unit, ") given for more than one point?");
		if (points.size() < 4) return;
		const auto   distances = nearestDistances<D>(points, 0.75 * spacing);
		const double apart     = median(distances);
		if (!(apart <= 1.2 * spacing))
			doubts.add(
			        true, "MpmEngine.gridSpacing is ", spacing, " m and most points have no other one within ", 1.2 * spacing,
			        " m: the grid cannot carry ground whose points are farther apart than its nodes; give smaller points or a coarser grid.");
		else if (usual < 0.1 * std::pow(apart, D))
			doubts.add(
			        true, "The volume of the points is ", usual, unit, " (median) where their distance of ", apart, " m makes ", std::pow(apart, D),
			        unit, ": was volume meant to be that?");
	}

	template <int D> void doubtStates(Doubts& doubts, const MpmEngine& mpm, const Points<D>& points)
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
			        2 * tensile > int(points.size()), "addPoints: stress of ", tensile, " points is tensile, up to ", tension,
			        " Pa: was compression meant? Compression is negative.");
		if (mpm.motion && stress > 0 && stress < 500)
			doubts.add(false, "addPoints: stress is ", stress, " Pa at most: was ", stress * 1e3, " Pa (kPa) meant?");
		if (mpm.water && pressure > 0 && pressure < 200)
			doubts.add(false, "addPoints: pressure is ", pressure, " Pa at most: was ", pressure * 1e3, " Pa (kPa) meant?");
	}

	/// What points carry for an effect that the scene does not have.
	template <int D> void doubtUnused(Doubts& doubts, const MpmEngine& mpm, const Points<D>& points)
	{
		const auto unused = [&](bool used, const char* attribute, const char* unit, const char* without, const char* remedy, auto numberOf) {
			if (used) return;
			double most = 0;
			for (const auto& point : points)
				if (const double number = numberOf(point); std::abs(number) > std::abs(most)) most = number;
			if (most != 0)
				doubts.add(
				        true, "addPoints: ", attribute, " is ", most, unit, " and is not used, since the scene has no ", without, ": ", remedy,
				        ", or leave ", attribute, " out.");
		};
		unused(bool(mpm.heat), "temperature", " degC", "heat", "add heat=HeatTransfer()", [](const auto& p) { return p.temperature; });
		unused(bool(mpm.water), "pressure", " Pa", "water", "add water=PoreWater()", [](const auto& p) { return p.pressure; });
		unused(mpm.motion, "velocity", " m/s", "motion", "set motion=True", [](const auto& p) { return lengthOf<D>(p.velocity); });
	}

	struct Range {
		const char* name;
		double      value, least, most;
		const char* unit;
		double      factor = 1e3;
	};

	/// Where a thousand times more or less would do, or another factor between units, that was meant.
	void doubtRange(Doubts& doubts, bool grave, const Range& r)
	{
		if (r.value == 0 || !std::isfinite(r.value) || (r.value >= r.least && r.value <= r.most)) return;
		const double meant = r.value < r.least ? r.value * r.factor : r.value / r.factor;
		if (meant >= r.least && meant <= r.most) doubts.add(grave, r.name, " is ", r.value, " ", r.unit, ": was ", meant, " meant?");
		else doubts.add(grave, r.name, " is ", r.value, " ", r.unit, ": ", r.least, " to ", r.most, " would be usual.");
	}

	void doubtMaterial(Doubts& doubts, const MpmEngine& mpm, const yade::GroundMaterial& m)
	{
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

	void doubtStiffness(Doubts& doubts, const char* name, double young) { doubtRange(doubts, false, Range { name, young, 1e4, 1e12, "Pa", 1e6 }); }

	void doubtSkeletons(Doubts& doubts, const MpmEngine& mpm)
	{
		for (const auto& law : mpm.activeSkeletons()) {
			if (const auto* elastic = dynamic_cast<const yade::ElasticSkeleton*>(law.get()))
				doubtStiffness(doubts, "ElasticSkeleton.young", elastic->young);
			if (const auto* creeping = dynamic_cast<const yade::CreepingSkeleton*>(law.get()))
				doubtStiffness(doubts, "CreepingSkeleton.young", creeping->young);
			if (const auto* mohrCoulomb = dynamic_cast<const yade::MohrCoulombSkeleton*>(law.get())) {
				doubtAngle(doubts, "MohrCoulombSkeleton.frictionAngle", mohrCoulomb->frictionAngle);
				doubtStiffness(doubts, "MohrCoulombSkeleton.young", mohrCoulomb->young);
				doubtRange(doubts, false, Range { "MohrCoulombSkeleton.cohesion", mohrCoulomb->cohesion, 10, 1e8, "Pa" });
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

	template <class... Kinds> bool isOneOf(const yade::GroundBoundary& boundary) { return (dynamic_cast<const Kinds*>(&boundary) || ...); }

	/// Water that stands on the ground presses on its grains, too.
	void doubtPond(Doubts& doubts, const MpmEngine& mpm, const yade::DrainedBoundary& pond)
	{
		const double p = largest(pond.pressure, pond.values);
		if (pond.region != "surface" || !(p > 0)) return;
		for (const auto& boundary : mpm.boundaries)
			if (isOneOf<yade::SurfaceLoad>(*boundary)) return;
		doubts.add(
		        false, "DrainedBoundary.pressure is ", p,
		        " Pa on the surface, where no load is: water that stands there presses on the ground, too. Add "
		        "SurfaceLoad(region='surface',pressure=",
		        p, ").");
	}

	/// Only a side that ground touches can warm or cool it.
	template <int D> void doubtWall(Doubts& doubts, const MpmEngine& mpm, const yade::WallTemperature& wall, const Points<D>& points)
	{
		const std::map<string, std::pair<int, bool>> sides { { "left", { 0, false } },   { "right", { 0, true } },  { "bottom", { D - 1, false } },
			                                             { "top", { D - 1, true } }, { "front", { 1, false } }, { "back", { 1, true } } };
		const auto                                   side = sides.find(wall.region);
		if (side == sides.end() || !mpm.lower.isGiven() || !mpm.upper.isGiven()) return;
		const auto [axis, upper] = side->second;
		const double at          = (upper ? mpm.upper : mpm.lower).template in<D>("corner")[axis];
		double       apart       = std::numeric_limits<double>::infinity();
		for (const auto& point : points)
			apart = std::min(apart, std::abs(point.position[axis] - at));
		if (apart > mpm.gridSpacing)
			doubts.add(
			        true, "WallTemperature(region='", wall.region, "'): no ground is there, the nearest point is ", apart,
			        " m away: was SurfaceTemperature(region='surface') meant, or a grid that ends at the ground?");
	}

	template <int D> void doubtBoundaries(Doubts& doubts, const MpmEngine& mpm, const Points<D>& points)
	{
		for (const auto& boundary : mpm.boundaries) {
			if (const auto* load = dynamic_cast<const yade::SurfaceLoad*>(boundary.get())) {
				const double p = largest(load->pressure, load->values);
				if (p > 0 && p < 500) doubts.add(false, "SurfaceLoad.pressure is ", p, " Pa at most: was ", p * 1e3, " Pa (kPa) meant?");
			}
			if (const auto* flux = dynamic_cast<const yade::WaterFlux*>(boundary.get())) {
				const double q = largest(flux->flux, flux->values);
				if (q > 0.1) doubts.add(false, "WaterFlux.flux is ", q, " m/s: was ", q / 1e3 / 3600, " m/s (", q, " mm per hour) meant?");
				else if (q > 0 && flux->region == "surface" && mpm.freezing)
					doubts.add(
					        false,
					        "WaterFlux on the surface: rain does not run off here. What frozen or full ground cannot take is pressed into "
					        "it and "
					        "lifts it: give DrainedBoundary(region='surface') while it takes none.");
			}
			if (const auto* drained = dynamic_cast<const yade::DrainedBoundary*>(boundary.get()); drained && mpm.motion)
				doubtPond(doubts, mpm, *drained);
			if (const auto* wall = dynamic_cast<const yade::WallTemperature*>(boundary.get())) doubtWall<D>(doubts, mpm, *wall, points);
		}
	}

	bool isThermal(const yade::GroundBoundary& boundary)
	{
		return isOneOf<yade::SurfaceTemperature, yade::WallTemperature, yade::BodyTemperature, yade::HeatFlux, yade::HeatSource>(boundary);
	}

	/// Tables in seconds that are over before anything comes of them, or in days that nobody waits for.
	void doubtTables(Doubts& doubts, const MpmEngine& mpm)
	{
		constexpr double longest = 1e5; // days of a table: 274 years
		for (const auto& boundary : mpm.boundaries)
			if (boundary && !boundary->days.empty() && boundary->days.back() > longest)
				doubts.add(
				        false, boundary->getClassName(), ".days ends at day ", boundary->days.back(), ", in ", boundary->days.back() / 365.25,
				        " years: were seconds meant? They are times=, in place of days.");
		constexpr double diffusivity = 1e-6, shareOfCell = 0.1, shortest = 1e-3; // of ground [m^2/s]; -; of a table [s of motion]
		const double     scale = mpm.heat ? mpm.heat->thermalTimeScale : 1;
		for (const auto& boundary : mpm.boundaries) {
			if (!boundary || boundary->times.size() < 2 || isOneOf<yade::MovingBoundary>(*boundary)) continue;
			const double       end = boundary->times.back(), depth = std::sqrt(diffusivity * std::max(0., end));
			std::ostringstream days;
			for (const double time : boundary->times)
				days << (days.tellp() > 0 ? ", " : "") << time;
			const string name = boundary->getClassName() + ".times ends at ";
			if (!(end > 0)) continue;
			if (isThermal(*boundary) && depth < shareOfCell * mpm.gridSpacing)
				doubts.add(
				        false, name, end, " s of the calendar, in which heat comes some ", 1e3 * depth, " mm deep in cells of ",
				        mpm.gridSpacing, " m: was days=[", days.str(), "] meant?");
			else if (!isThermal(*boundary) && end < shortest * scale)
				doubts.add(
				        false, name, end, " s of the calendar, which pass within ", end / scale, " s of motion: was days=[", days.str(),
				        "] meant?");
		}
	}

	/// The lowest value of the table, or the constant; after: of those that follow a value above zero.
	double lowest(double constant, const std::vector<double>& table, bool after)
	{
		if (table.empty()) return after ? std::numeric_limits<double>::infinity() : constant;
		double least = std::numeric_limits<double>::infinity();
		bool   warm  = !after;
		for (const double value : table) {
			if (warm) least = std::min(least, value);
			warm = warm || value > 0;
		}
		return least;
	}

	template <int D> void doubtHeave(Doubts& doubts, const MpmEngine& mpm, const Points<D>& points)
	{
		if (!mpm.water || !mpm.freezing || !mpm.heat || mpm.segregation) return;
		const bool thawed  = std::any_of(points.begin(), points.end(), [](const auto& point) { return point.temperature >= 0; });
		bool       freezes = false;
		const auto look    = [&](const auto* boundary) {
                        if (boundary) freezes = freezes || lowest(boundary->temperature, boundary->values, !thawed) < 0;
		};
		for (const auto& boundary : mpm.boundaries) {
			look(dynamic_cast<const yade::SurfaceTemperature*>(boundary.get()));
			look(dynamic_cast<const yade::WallTemperature*>(boundary.get()));
			look(dynamic_cast<const yade::BodyTemperature*>(boundary.get()));
			if (const auto* flux = dynamic_cast<const yade::HeatFlux*>(boundary.get()))
				freezes = freezes || (thawed && lowest(flux->flux, flux->values, false) < 0);
		}
		if (!freezes) return;
		doubts.add(
		        false,
		        "Ground freezes here and has water to draw: frost heave by segregation (ice lenses, cryosuction) is absent. What heaves is pore water "
		        "that "
		        "freezes where it is, by 9 % of its volume at most. segregation=IceSegregation(segregationPotential=1e-9) adds it.");
	}

	/// What the water that ice draws is computed from, if it is not measured.
	void doubtSegregation(Doubts& doubts, const MpmEngine& mpm)
	{
		if (!mpm.segregation || !mpm.water || !std::isnan(mpm.segregation->segregationPotential) || mpm.water->relativeConductivity != "impedance"
		    || mpm.water->impedance != yade::PoreWater().impedance)
			return;
		doubts.add(
		        false,
		        "IceSegregation.segregationPotential is not given, so that frost heave follows from PoreWater.impedance, which is the default of ",
		        mpm.water->impedance,
		        ": a silt measured in the laboratory heaves three times too much with it, and its ice thaws back under constant cold. Give a measured "
		        "segregationPotential, or the impedance of the soil.");
	}

	void doubtClock(Doubts& doubts, const MpmEngine& mpm)
	{
		if (!mpm.heat || !(mpm.heat->thermalTimeScale < 1)) return;
		const double scale = mpm.heat->thermalTimeScale;
		doubts.add(
		        false, "HeatTransfer.thermalTimeScale is ", scale, ", so that ", scale, " s of the calendar pass in a second of motion: was ",
		        1 / scale, " meant?");
	}

	void doubtConductivity(Doubts& doubts, double k)
	{
		if (k < 1e-14)
			doubts.add(false, "PoreWater.conductivity is ", k, " m/s: soils and rocks have 1e-14 to 1 m/s; was a permeability in m^2 given?");
		else if (k > 0.05)
			doubts.add(
			        false, "PoreWater.conductivity is ", k,
			        " m/s: soils and rocks have 1e-14 to 1 m/s, and only coarse gravel more than 0.05; was ", k / talik::secondsPerDay, " (", k,
			        " m per day) meant?");
	}

	template <int D> void doubtGravity(Doubts& doubts, const MpmEngine& mpm)
	{
		if (mpm.gravity.isGiven() && mpm.gravity.components() != D) return; // refused anyway
		Vec<D> gravity = mpm.gravity.in<D>("gravity");
		double beside  = 0;
		for (int a = 0; a < D - 1; ++a)
			beside = std::max(beside, std::abs(gravity[a]));
		const string text = mpm.gravity.text();
		if (gravity[D - 1] > 0) {
			gravity[D - 1] *= -1;
			std::ostringstream meant;
			for (int a = 0; a < D; ++a)
				meant << (a ? ", " : "(") << gravity[a];
			doubts.add(true, "MpmEngine.gravity is ", text, " m/s^2, upwards: was ", meant.str(), ") meant?");
		} else if (D == 3 && gravity[D - 1] == 0 && beside > 0)
			doubts.add(true, "MpmEngine.gravity is ", text, " m/s^2: z points upwards in space, was (0, 0, ", -lengthOf<D>(gravity), ") meant?");
	}

	template <int D> std::vector<Doubt> doubtsIn(const MpmEngine& mpm)
	{
		Points<D> points;
		for (int id = 0; id < mpm.points.count(); ++id)
			points.push_back(mpm.points.point<D>(id));
		Doubts doubts;
		if (mpm.gridSpacing > 0 && !points.empty()) doubtPlaces<D>(doubts, points, mpm.gridSpacing);
		if (mpm.motion) doubtGravity<D>(doubts, mpm);
		for (const auto& m : mpm.activeMaterials())
			if (m) doubtMaterial(doubts, mpm, *m);
		doubtStates<D>(doubts, mpm, points);
		doubtUnused<D>(doubts, mpm, points);
		if (mpm.motion) doubtSkeletons(doubts, mpm);
		if (mpm.water) doubtConductivity(doubts, mpm.water->conductivity);
		doubtBoundaries<D>(doubts, mpm, points);
		doubtTables(doubts, mpm);
		doubtHeave<D>(doubts, mpm, points);
		doubtSegregation(doubts, mpm);
		doubtClock(doubts, mpm);
		return doubts.list;
	}

	double loadAtStart(const MpmEngine& mpm)
	{
		double sum = 0;
		for (const auto& boundary : mpm.boundaries)
			if (const auto* load = dynamic_cast<const yade::SurfaceLoad*>(boundary.get()))
				sum += load->values.empty() ? load->pressure : load->values.front();
		return sum;
	}

	/// Vertical effective stress that the weight above each point makes [Pa], compression positive, by columns as wide as a cell.
	template <int D> std::vector<double> weightAbove(const MpmEngine& mpm, const Points<D>& points, double gravity)
	{
		std::map<Box<D>, std::vector<int>> columns;
		for (std::size_t i = 0; i < points.size(); ++i) {
			Box<D> place {};
			for (int a = 0; a < D - 1; ++a)
				place[a] = long(std::floor(points[i].position[a] / mpm.gridSpacing + 1e-6));
			columns[place].push_back(int(i));
		}
		const auto          soils = mpm.activeMaterials();
		const double        width = std::pow(mpm.gridSpacing, D - 1), load = loadAtStart(mpm);
		const double        usual = !std::isnan(mpm.poreFill) ? mpm.poreFill : mpm.heat || mpm.water ? 1 : 0;
		std::vector<double> weight(points.size());
		for (auto& column : columns) {
			auto& ids = column.second;
			std::sort(ids.begin(), ids.end(), [&](int i, int j) { return points[i].position[D - 1] > points[j].position[D - 1]; });
			double sum = load;
			for (const int i : ids) {
				const auto&  point = points[i];
				const auto&  soil  = *soils[std::size_t(point.material)];
				const double fill  = std::isnan(point.poreFill) ? usual : point.poreFill;
				const double own   = point.volume * gravity / width
				        * ((1 - point.porosity) * soil.solidDensity + point.porosity * fill * soil.liquidDensity);
				weight[i] = sum + 0.5 * own - (mpm.water ? point.pressure : 0);
				sum += own;
			}
		}
		return weight;
	}

	template <int D> std::vector<Doubt> doubtSamples(const MpmEngine& mpm, const AnyGround& ground)
	{
		constexpr double least = 3e3, factor = 2; // weight that a sample feels [Pa], and how far its stress may be from that [-]
		Doubts           doubts;
		const double     gravity = -mpm.gravity.in<D>("gravity")[D - 1];
		if (!mpm.motion || !(gravity > 0)) return {};
		Points<D> points;
		for (int id = 0; id < mpm.points.count(); ++id)
			points.push_back(mpm.points.point<D>(id));
		std::vector<double> stress(points.size()), found, due;
		ground.copyById("stress", D - 1, stress.data());
		const auto weight  = weightAbove<D>(mpm, points, gravity);
		const auto laws    = mpm.activeSkeletons();
		long       misfits = 0;
		for (std::size_t i = 0; i < points.size(); ++i) {
			if (!laws[std::size_t(points[i].skeleton)]->beginsWithOwnStress() || weight[i] < least) continue;
			found.push_back(-stress[i]);
			due.push_back(weight[i]);
			misfits += !(found.back() < factor * due.back() && factor * found.back() > due.back());
		}
		if (2 * misfits > long(found.size()))
			doubts.add(
			        false, "RveSkeleton: samples begin with a vertical stress of ", -median(found),
			        " Pa (median) where the weight above their points makes ", -median(due),
			        " Pa: ground bursts or falls together as it thaws; talik.slope.settle(mpm, outline) brings them to it.");
		return doubts.list;
	}
} // namespace

std::vector<Doubt> doubtsAboutSamples(const MpmEngine& mpm, const AnyGround& ground)
{
	return mpm.usedDimension() == 2 ? doubtSamples<2>(mpm, ground) : doubtSamples<3>(mpm, ground);
}

std::vector<Doubt> doubtsAbout(const MpmEngine& mpm) { return mpm.usedDimension() == 2 ? doubtsIn<2>(mpm) : doubtsIn<3>(mpm); }

} // namespace talik
