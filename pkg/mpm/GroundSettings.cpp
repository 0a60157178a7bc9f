// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/mpm/effects/Effect.hpp>
#include <pkg/mpm/GroundSettings.hpp>

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <stdexcept>

namespace talik {

std::vector<std::string> velocityTransferNames() { return { "flip", "apic", "tpic" }; }

VelocityTransfer velocityTransferFromName(const std::string& name)
{
	return static_cast<VelocityTransfer>(placeOfName("MpmEngine.transfer", name, velocityTransferNames()));
}

double keptFraction(double picTime, double dt) { return std::exp(-dt / picTime); }

double gravityTime(double spacing, double gravity)
{
	constexpr double ofTheEarth = 9.81;
	return std::sqrt(spacing / std::max(gravity, ofTheEarth));
}

namespace {
	std::string asText(double number)
	{
		std::ostringstream text;
		text << number;
		return text.str();
	}
} // namespace

template <int D> void checkCalendar(const GroundSettings<D>& s)
{
	const HeatSettings& heat = *s.heat;
	if (!s.motion)
		throw std::invalid_argument(
		        "HeatTransfer.followsMotion = true without motion: rigid ground never moves, its calendar has one scale; leave followsMotion out");
	requireSetting(
	        heat.movingTimeScale > 0.0 && heat.movingTimeScale <= heat.thermalTimeScale, "HeatTransfer.movingTimeScale", heat.movingTimeScale,
	        "must be positive and no more than thermalTimeScale = " + asText(heat.thermalTimeScale));
	requireSetting(
	        heat.motionTolerance >= 1e-6 && heat.motionTolerance <= 1.0, "HeatTransfer.motionTolerance", heat.motionTolerance,
	        "must lie between 1e-6 and 1 m/s, e.g. 0.01");
}

namespace {
	/// Throws unless water and ice of a material are those of the first: water that moves would change its energy on the way.
	void requireSameWater(const MixtureProperties& first, const MixtureProperties& other, const std::string& name)
	{
		const auto same = [&](double a, double b, const char* attribute) {
			std::ostringstream remedy;
			remedy << "must be that of materials[0], " << b << ": water moves from one material to the other";
			requireSetting(a == b, name + attribute, a, remedy.str());
		};
		const auto samePhase = [&](const Phase& a, const Phase& b, const std::string& phase) {
			same(a.density, b.density, (phase + "Density").c_str());
			same(a.specificHeat, b.specificHeat, (phase + "SpecificHeat").c_str());
			same(a.expansivity, b.expansivity, (phase + "Expansivity").c_str());
		};
		samePhase(other.ice, first.ice, "ice");
		samePhase(other.liquid, first.liquid, "liquid");
		same(other.latentHeat, first.latentHeat, "latentHeat");
		same(other.referenceTemperature, first.referenceTemperature, "referenceTemperature");
	}

	/// value: of the attribute name, above zero.
	template <int D> void requireSettling(const GroundSettings<D>& s, double value, const std::string& name)
	{
		requireSetting(bool(s.freezing), name, value, "ground that does not freeze has none; add freezing or leave it out");
		requireSetting(bool(s.motion), name, value, "rigid ground does not settle; add motion or leave it out");
		requireSetting(lengthOf<D>(s.motion->gravity) > 0.0, name, value, "acts along gravity; give gravity or leave it out");
	}

	template <int D> void checkThawStrain(const GroundSettings<D>& s, const SoilMaterial& m, const std::string& material)
	{
		const std::string name = material + "thawStrain";
		requireSetting(m.thawStrain >= 0.0 && m.thawStrain < 1.0, name, m.thawStrain, "must lie in [0, 1)");
		m.compression.validate(material);
		if (m.thawStrain > 0.0) requireSettling(s, m.thawStrain, name);
		if (m.compression.compressibility > 0.0) requireSettling(s, m.compression.compressibility, material + "compressibility");
		if (m.compression.compressionIndex > 0.0) requireSettling(s, m.compression.compressionIndex, material + "compressionIndex");
	}

	template <int D> void checkMaterials(const GroundSettings<D>& s)
	{
		constexpr std::size_t most = std::numeric_limits<std::uint16_t>::max();
		requireSetting(s.materials.size() <= most, "MpmEngine.materials", s.materials.size(), "must be no more than 65535");
		for (std::size_t k = 0; k < s.materials.size(); ++k) {
			const SoilMaterial& m    = s.materials[k];
			const std::string   name = "MpmEngine.materials[" + std::to_string(k) + "].";
			m.mixture.validate();
			requireSameWater(s.materials.front().mixture, m.mixture, name);
			if (m.freezing && !s.freezing)
				throw std::invalid_argument(name + "freezing is set, but the scene does not freeze; add freezing or leave it out");
			if (m.permeability && !s.water)
				throw std::invalid_argument(name + "permeability is set, but the scene has no water; add water or leave it out");
			if (m.permeability) m.permeability->validate();
			checkThawStrain(s, m, name);
			if (m.segregation && !s.segregation)
				throw std::invalid_argument(name + "segregation is set, but the scene has none; add segregation or leave it out");
			if (m.segregation) m.segregation->validate(name + "segregation.");
		}
	}
} // namespace

template <int D> void checkSegregation(const GroundSettings<D>& s)
{
	const auto refuse = [](const char* why) { throw std::invalid_argument(std::string("segregation ") + why); };
	if (!s.freezing) refuse("without freezing: ground that does not freeze draws no water to its ice; add freezing or leave segregation out");
	if (!s.water) refuse("without water: there is none to draw; add water or leave segregation out");
	if (!s.motion->bBar) refuse("with bBar = false: what is drawn is shared out by cells; leave bBar true or segregation out");
	if (s.water->state.massCoefficient != MassCoefficient::exact)
		refuse("with massCoefficient = printed: excess ice needs the pressure that follows from masses; use exact or leave segregation out");
	s.segregation->validate("segregation.");
}

/// With water pores are never quite dry, as in drained ground: a point keeps some liquid.
template <int D> static void requireFill(const GroundSettings<D>& s, const std::string& attribute, double fill)
{
	requireSetting(fill >= (s.water ? 0.01 : 0.0) && fill <= 1.0, attribute, fill, s.water ? "must lie in [0.01, 1] with water" : "must lie in [0, 1]");
}

/// What has no radius in its areas or no strain around the axis is refused.
template <int D> static void checkAxis(const GroundSettings<D>& s)
{
	const auto require = [](bool holds, const std::string& what, const char* remedy) {
		if (!holds) throw std::invalid_argument("MpmEngine.axisymmetric = true " + what + ": " + remedy);
	};
	require(D == 2, "in space", "an axis is for ground in the plane; give points of two components, or leave axisymmetric out");
	require(s.lower[0] >= 0.0, "with lower.x = " + asText(s.lower[0]), "x is the radius; let the box begin at the axis, x = 0, or beyond");
	const bool fails = std::any_of(s.skeletons.begin(), s.skeletons.end(), [](const auto& law) { return law && law->canFail(); });
	require(!(s.freezing && s.motion && s.thawFront && fails), "with thawFront", "the front has no hoop stress; set thawFront to None");
	require(!s.pointsDivide, "with pointsDivide", "edges of points do not see the hoop strain; leave pointsDivide out");
	require(!s.bodies, "with bodies", "they would be rings; leave bodies out, and move walls by MovingBoundary");
	require(s.effects.empty(), "with effects", "they do not see the hoop strain; leave them out");
	require(!s.segregation, "with segregation", "lenses have no radius in their areas; leave segregation out");
	for (const auto& law : s.skeletons)
		require(!law || law->knowsHoopStrain(), "with " + (law ? law->name() : ""), "it does not see the hoop strain; take another skeleton law");
}

template <int D> void checkSettings(const GroundSettings<D>& s)
{
	if (s.axisymmetric) checkAxis(s);
	s.mixture.validate();
	checkMaterials(s);
	if (!s.motion && !s.heat) throw std::invalid_argument("no effect: the scene has neither motion nor heat; give it at least one");
	if (s.freezing && !s.heat) throw std::invalid_argument("freezing without heat: ice forms when heat leaves; add heat or leave freezing out");
	if (s.water && !s.motion) throw std::invalid_argument("water without motion: seepage needs the momentum balance; add motion or leave water out");
	if (s.bodies && !s.motion) throw std::invalid_argument("bodies without motion: ground that is pushed has to move; add motion or leave bodies out");
	if (s.bodies) s.bodies->validate();
	if (s.segregation) checkSegregation(s);
	if (!std::isnan(s.poreFill)) requireFill(s, "MpmEngine.poreFill", s.poreFill);
	requireSetting(s.courantNumber > 0.0 && s.courantNumber <= 1.0, "MpmEngine.courantNumber", s.courantNumber, "must lie in (0, 1]");
	requireSetting(s.heatFraction > 0.0 && s.heatFraction <= 1.0, "MpmEngine.heatFraction", s.heatFraction, "must lie in (0, 1]");
	requireSetting(s.motionFraction > 0.0 && s.motionFraction <= 0.5, "MpmEngine.motionFraction", s.motionFraction, "must lie in (0, 0.5]");
	if (s.motion) {
		for (int a = 0; a < D; ++a)
			requireSetting(std::isfinite(s.motion->gravity[a]), "MpmEngine.gravity", s.motion->gravity[a], "must be finite, in m/s^2");
		requireSetting(
		        !(s.motion->picTime < 0.0), "MpmEngine.picTime", s.motion->picTime, "must not be negative, in s; infinity: none dies out, NaN: chosen");
		requireSetting(
		        s.motion->localDamping >= 0.0 && s.motion->localDamping < 1.0, "MpmEngine.damping", s.motion->localDamping, "must lie in [0, 1)");
		if (s.skeletons.empty()) throw std::invalid_argument("skeletons = []: a scene with motion needs at least one skeleton model");
		for (const auto& skeleton : s.skeletons) {
			if (!skeleton) throw std::invalid_argument("skeletons: an entry is empty; give a skeleton model");
			skeleton->validate();
		}
	}
	for (const auto& effect : s.effects) {
		if (!effect) throw std::invalid_argument("effects: an entry is empty; give an effect");
		requireSetting(bool(s.motion), "effects", effect->name(), "needs ground that moves; switch motion on or leave the effect out");
		effect->validate(s);
	}
	if (s.heat) {
		requireSetting(
		        std::isfinite(s.heat->thermalTimeScale) && s.heat->thermalTimeScale > 0.0, "HeatTransfer.thermalTimeScale", s.heat->thermalTimeScale,
		        "must be positive (1: real time)");
		if (s.heat->followsMotion) checkCalendar(s);
		requireSetting(std::isfinite(s.heat->source), "HeatTransfer.source", s.heat->source, "must be finite, in W/m^3");
	}
	if (s.water) {
		s.water->state.validate();
		s.water->permeability.validate();
		requireSetting(
		        !(s.water->largestConductivity <= 0.0), "PoreWater.largestConductivity", s.water->largestConductivity,
		        "must be positive, in m/s; leave it out to have it chosen");
		requireSetting(
		        s.water->permeability.hydraulicTimeScale == 1.0, "permeability.hydraulicTimeScale", s.water->permeability.hydraulicTimeScale,
		        "must be 1 in a ground; set WaterSettings::hydraulicTimeScale");
		requireSetting(
		        std::isnan(s.water->hydraulicTimeScale) || (s.water->hydraulicTimeScale >= 1e-12 && s.water->hydraulicTimeScale <= 1e12),
		        "PoreWater.hydraulicTimeScale", s.water->hydraulicTimeScale,
		        "must lie between 1e-12 and 1e12 (1: no scaling); leave it out for the scale of the calendar");
		requireSetting(
		        !s.water->implicit || s.motion->bBar, "MpmEngine.bBar", s.motion->bBar,
		        "must be on with implicit pressure, which belongs to cells; switch it on or take the explicit pressure");
		requireSetting(
		        !s.water->implicit || s.water->state.massCoefficient == MassCoefficient::exact, "PoreWater.massCoefficient", "printed",
		        "must be exact with implicit pressure, which follows from masses");
		requireSetting(
		        !(s.water->picTime < 0.0), "PoreWater.picTime", s.water->picTime, "must not be negative, in s; infinity: none dies out, NaN: chosen");
	}
}

namespace {
	/// Throws if a boundary is not the same on both sides that a PeriodicBoundary joins.
	template <int D> void checkBeside(const Boundary<D>& joining, const std::string& number, const Boundary<D>& b, const Grid<D>& grid)
	{
		const Region<D>& r      = b.region();
		const int        axis   = joining.region().on.axis;
		const auto       refuse = [&](const std::string& why) {
                        throw std::invalid_argument(number + " = " + b.name() + " on " + r.describe() + " beside PeriodicBoundary " + why);
		};
		if (r.kind == Region<D>::Kind::side && r.on.axis == axis) refuse("acts on a side that this joins with the opposite one; remove one of them");
		if (b.usesNodes()) refuse("would have two places for one node of the ground; take a boundary of Talik");
		if (r.kind == Region<D>::Kind::nodeBox && b.usesSurface()) refuse("has no single area at the sides; give the load on the surface");
		if (r.boxLower[axis] > grid.lower()[axis] - grid.spacing() || r.boxUpper[axis] < grid.upper()[axis] + grid.spacing())
			refuse("ends between the sides that this joins; leave its limits along this axis out, or let them lie two cells outside of the box");
	}
} // namespace

template <int D> void checkBoundaries(const GroundSettings<D>& settings, const Grid<D>& grid)
{
	const auto& all    = settings.boundaries;
	const auto  named  = [&](std::size_t k) { return "MpmEngine.boundaries[" + std::to_string(k) + "] = " + all[k]->name(); };
	const auto  placed = [&](std::size_t k) { return (all[k]->region().kind == Region<D>::Kind::bodies ? " of " : " on ") + all[k]->region().describe(); };
	for (std::size_t i = 0; i < settings.boundaries.size(); ++i) {
		const auto& b = settings.boundaries[i];
		if (!b) throw std::invalid_argument("MpmEngine.boundaries[" + std::to_string(i) + "] is empty; give a boundary condition");
		const std::string effect  = b->effect();
		const bool        present = effect.empty()
		        || (effect == "motion"         ? bool(settings.motion)
		                    : effect == "heat" ? bool(settings.heat)
		                                       : bool(settings.water));
		const auto refuse = [&](const std::string& why) { throw std::invalid_argument(named(i) + why); };
		if (!present) refuse(placed(i) + ": the scene has no " + effect + "; add it or leave this boundary out");
		if (b->region().kind == Region<D>::Kind::bodies && !settings.bodies)
			refuse(placed(i) + ": the ground meets no bodies; add bodies or leave this boundary out");
		b->validate(grid);
		const Side side  = b->region().on;
		const bool axial = settings.axisymmetric && b->region().kind == Region<D>::Kind::side && side.axis == 0;
		if (axial && (b->joinsSides() || (!side.upper && grid.lower()[0] == 0.0)) && b->name() != "RollerBoundary" && b->name() != "InsulatedBoundary")
			refuse(placed(i) + " of axisymmetric ground: an axis has no area and no other side; leave it out, or let the box begin at a radius");
		for (std::size_t j = 0; b->joinsSides() && j < settings.boundaries.size(); ++j)
			if (j != i && settings.boundaries[j]) checkBeside(*b, "MpmEngine.boundaries[" + std::to_string(j) + "]", *settings.boundaries[j], grid);
		if (b->joinsSides() && settings.bodies)
			throw std::invalid_argument("PeriodicBoundary in ground that meets bodies: these are not repeated; leave bodies out, or take walls");
		if (b->accelerates() && settings.water)
			refuse(" accelerates grains and ice, and this ground has pore water, which would stay behind; leave water out, or change gravity");
		if (b->feeds() && !std::isnan(b->inflowTemperature()) && !settings.heat)
			refuse(".temperature is set but the scene has no heat; leave it out or add heat");
		for (std::size_t j = 0; j < i; ++j) {
			const auto& other = settings.boundaries[j];
			// a surface has either its pressure or its flux prescribed
			const bool pressureAndFlux = (b->drains() && other->feeds()) || (b->feeds() && other->drains());
			// water crosses a side or it does not
			const bool openAndClosed = (b->drains() && other->name() == "ImpermeableBoundary")
			        || (other->drains() && b->name() == "ImpermeableBoundary");
			// no water crosses a wall that moves
			const bool openAndMoving = (b->moves() && (other->drains() || other->feeds())) || (other->moves() && (b->drains() || b->feeds()));
			const bool mayMeet       = other->effect() != effect || b->loads() || other->loads() || b->drains() != other->drains()
			        || (b->usesSurface() && other->usesSurface() && b->name() != other->name());
			if (mayMeet && !pressureAndFlux && !openAndClosed && !openAndMoving) continue;
			const Region<D>&r = b->region(), &q = other->region();
			if (r.kind != q.kind || r.kind == Region<D>::Kind::nodeBox || r.cavities != q.cavities) continue;
			if (r.kind == Region<D>::Kind::side && (r.on.axis != q.on.axis || r.on.upper != q.on.upper)) continue;
			const auto bothName = [&](int id) { return std::find(q.ids.begin(), q.ids.end(), id) != q.ids.end(); };
			bool       overlap  = r.kind != Region<D>::Kind::bodies || std::any_of(r.ids.begin(), r.ids.end(), bothName);
			for (int a = 0; a < D; ++a) {
				if (r.kind == Region<D>::Kind::side && a == r.on.axis) continue;
				overlap = overlap && r.boxLower[a] < q.boxUpper[a] && q.boxLower[a] < r.boxUpper[a];
			}
			if (overlap) refuse(placed(i) + " overlaps " + named(j) + placed(j) + "; limit one of them to a box or remove it");
		}
	}
}

template <int D> void checkPoints(const GroundSettings<D>& settings, const Grid<D>& grid, int count, const std::function<PointInput<D>(int)>& point)
{
	if (count == 0) throw std::invalid_argument("points = 0: the scene has no material points; add some before the start");
	const auto name = [](int id, const char* attribute) { return "point " + std::to_string(id) + "." + attribute; };
	for (int id = 0; id < count; ++id) {
		const PointInput<D> in = point(id);
		for (int a = 0; a < D; ++a) {
			requireSetting(
			        in.position[a] >= grid.lower()[a] && in.position[a] <= grid.upper()[a], name(id, "position") + "[" + std::to_string(a) + "]",
			        in.position[a], "outside the grid's box; move the point or enlarge the box");
			requireSetting(std::isfinite(in.velocity[a]), name(id, "velocity"), in.velocity[a], "must be finite, in m/s");
		}
		requireSetting(std::isfinite(in.volume) && in.volume > 0.0, name(id, "volume"), in.volume, "must be positive, in m^3 (m^2 in 2-D)");
		requireSetting(in.porosity > 1e-3 && in.porosity < 1.0, name(id, "porosity"), in.porosity, "must lie in (0.001, 1)");
		if (!std::isnan(in.poreFill)) requireFill(settings, name(id, "poreFill"), in.poreFill);
		if (settings.heat)
			requireSetting(
			        in.temperature > -100.0 && in.temperature < 100.0, name(id, "temperature"), in.temperature,
			        "must lie between -100 and 100 degC");
		if (settings.water) requireSetting(std::isfinite(in.pressure), name(id, "pressure"), in.pressure, "must be finite, in Pa");
		const int materials = std::max<int>(1, settings.materials.size());
		requireSetting(
		        in.material >= 0 && in.material < materials, name(id, "material"), in.material,
		        "must be an index into the list of materials, 0 to " + std::to_string(materials - 1));
		const double thawStrain = settings.materials.empty() ? 0.0 : settings.materials[in.material].thawStrain;
		requireSetting(
		        thawStrain == 0.0 || thawStrain < in.porosity, name(id, "porosity"), in.porosity,
		        "must exceed the thawStrain of its material, " + asText(thawStrain)
		                + ", since ice leaves no more room than it takes: give more porosity or less thawStrain");
		if (settings.motion) {
			requireSetting(
			        in.skeleton >= 0 && in.skeleton < int(settings.skeletons.size()), name(id, "skeleton"), in.skeleton,
			        "must be an index into the list of skeletons, 0 to " + std::to_string(settings.skeletons.size() - 1));
			for (double s : in.stress)
				requireSetting(std::isfinite(s), name(id, "stress"), s, "must be finite, in Pa");
		}
	}
}

template void checkSettings(const GroundSettings<2>&);
template void checkBoundaries(const GroundSettings<2>&, const Grid<2>&);
template void checkPoints(const GroundSettings<2>&, const Grid<2>&, int, const std::function<PointInput<2>(int)>&);
template void checkSettings(const GroundSettings<3>&);
template void checkBoundaries(const GroundSettings<3>&, const Grid<3>&);
template void checkPoints(const GroundSettings<3>&, const Grid<3>&, int, const std::function<PointInput<3>(int)>&);

} // namespace talik
