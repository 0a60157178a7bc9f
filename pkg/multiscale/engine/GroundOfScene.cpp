// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/Ground.hpp>
#include <pkg/multiscale/engine/GroundOfScene.hpp>
#include <pkg/multiscale/engine/MpmEngine.hpp>

#include <cmath>
#include <limits>

namespace py = boost::python;

namespace yade {
namespace {
	/// The box of the grid: as the engine says, and where it says nothing whole spacings around the points.
	template <int D> void placeBox(const MpmEngine& engine, talik::GroundSettings<D>& s)
	{
		const talik::Vec<D> lower = engine.lower.in<D>("MpmEngine.lower"), upper = engine.upper.in<D>("MpmEngine.upper");
		const auto&         points = engine.points;
		for (int axis = 0; axis < D; ++axis) {
			Real low = std::numeric_limits<Real>::infinity(), high = -low;
			for (int id = 0; id < points.given(); ++id) {
				const Real x = points.position(id, axis), half = 0.5 * (D == 2 ? std::sqrt(points.volume(id)) : std::cbrt(points.volume(id)));
				low  = std::min(low, x - half);
				high = std::max(high, x + half);
			}
			const Real h     = engine.gridSpacing;
			s.lower[axis]    = std::isnan(lower[axis]) ? h * std::floor(low / h + 1e-6) : lower[axis];
			const Real cells = (high - s.lower[axis]) / h;
			s.upper[axis]    = std::isnan(upper[axis]) ? s.lower[axis] + h * std::ceil(cells - 1e-6) : upper[axis];
		}
	}

	template <int D> talik::MotionSettings<D> motionOf(const MpmEngine& engine)
	{
		talik::MotionSettings<D> m;
		m.gravity  = engine.gravity.in<D>("MpmEngine.gravity");
		m.transfer = talik::velocityTransferFromName(engine.transfer);
		TALIK_TAKE_ATTRIBUTES(m, engine, (picTime)(bBar))
		m.localDamping = engine.damping;
		return m;
	}

	template <int D> vector<talik::Vec<D>> placesOf(const talik::PointTable& points)
	{
		vector<talik::Vec<D>> places;
		for (int id = 0; id < points.given(); ++id)
			places.push_back(points.point<D>(id).position);
		return places;
	}

	template <int D> talik::GroundSettings<D> settingsOf(const MpmEngine& engine)
	{
		talik::GroundSettings<D> s;
		TALIK_TAKE_ATTRIBUTES(s, engine, (gridSpacing)(shapeFunction)(axisymmetric)(energyLedger)(poreFill)(courantNumber)(heatFraction))
		placeBox(engine, s);
		s.mixture   = engine.activeMaterials().front()->build();
		s.materials = engine.soils();
		if (engine.motion) s.motion = motionOf<D>(engine);
		if (engine.heat) s.heat = engine.heat->build();
		if (engine.bodies) s.bodies = engine.bodies->build(D);
		if (engine.freezing) s.freezing = engine.freezing->build();
		if (!engine.thawFront) s.thawFront.reset();
		if (engine.water) s.water = engine.water->build();
		if (engine.segregation) s.segregation = engine.segregation->build();
		s.deformationRecord = engine.motion;
		s.pointsDivide      = engine.motion && engine.pointsDivide;
		for (const auto& boundary : engine.boundaries)
			s.boundaries.push_back(boundary->build<D>());
		for (const auto& effect : engine.effects)
			s.effects.push_back(effect->build<D>());
		if (engine.motion) {
			const auto places = placesOf<D>(engine.points);
			for (const auto& law : engine.activeSkeletons()) {
				s.skeletons.push_back(law->build(places));
				if (engine.tolerance > 0) law->setTolerance(engine.tolerance);
			}
		}
		return s;
	}

	template <int D> class InDimension final : public GroundOfScene {
	public:
		InDimension(const MpmEngine& engine, bool goesOn)
		        : inside(settingsOf<D>(engine))
		{
			const auto  laws   = engine.activeSkeletons();
			const auto& points = engine.points;
			for (int id = 0; id < points.given(); ++id) {
				const talik::PointInput<D> point = points.point<D>(id);
				const bool given = !std::isnan(point.stress[0]), hasLaw = point.skeleton >= 0 && point.skeleton < int(laws.size());
				if (given && !goesOn && engine.motion && hasLaw && laws[point.skeleton]->beginsWithOwnStress())
					throw std::invalid_argument(
					        "MpmEngine.addPoints: stress of point " + std::to_string(id) + " is given, but its "
					        + laws[point.skeleton]->getClassName()
					        + " begins with the stress of its sample: leave stress out, and bring the samples to it by "
					          "talik.slope.settle or depthBands.");
			}
			inside.takePoints(points.given(), [&points](int id) {
				talik::PointInput<D> point = points.point<D>(id);
				if (std::isnan(point.stress[0])) point.stress.fill(0);
				return point;
			});
		}

		talik::AnyGround&       ground() override { return inside; }
		const talik::AnyGround& ground() const override { return inside; }

		void checkBox(const MpmEngine& engine) const override
		{
			const auto& s       = inside.settings();
			const auto  require = [](const talik::GroundVector& now, const talik::Vec<D>& built, const char* name) {
                                const talik::Vec<D> corner = now.in<D>(string("MpmEngine.") + name);
                                for (int axis = 0; axis < D; ++axis)
                                        if (!std::isnan(corner[axis]) && corner[axis] != built[axis])
                                                throw std::invalid_argument(
						         "MpmEngine." + string(name) + " is now " + now.text()
						         + ", which the running ground cannot follow: set it back, or give the points to another engine.");
			};
			require(engine.lower, s.lower, "lower");
			require(engine.upper, s.upper, "upper");
		}

		void followGravity(const MpmEngine& engine) override
		{
			if (auto& motion = inside.settings().motion) motion->gravity = engine.gravity.in<D>("MpmEngine.gravity");
		}

		void followHeat(const talik::HeatSettings& heat) override
		{
			auto changed = inside.settings();
			changed.heat = heat;
			talik::checkSettings(changed);
			auto& inForce = *inside.settings().heat;
			TALIK_TAKE_ATTRIBUTES(inForce, heat, (thermalTimeScale)(movingTimeScale)(motionTolerance))
		}

		py::dict balance() const override
		{
			const auto b = inside.balance();
			py::dict   d;
			TALIK_PUT_MEMBERS(d, b, (time)(solidMass)(waterMass)(iceMass)(waterOut))
			d["momentum"] = py::tuple(talik::listOf(b.momentum));
			d["impulse"]  = py::tuple(talik::listOf(b.impulse));
			TALIK_PUT_MEMBERS(d, b, (enthalpy)(heatIn)(enthalpyOut)(kineticEnergy)(gravityEnergy)(skeletonWork)(porePressureWork))
			if (inside.settings().water) d["waterEnergyOut"] = b.waterEnergyOut;
			TALIK_PUT_MEMBERS(d, b, (dragDissipation)(dampingDissipation)(loadWork)(slipWork)(wallWork))
			if (inside.settings().segregation) d["waterDrawn"] = b.waterDrawn;
			if (inside.settings().segregation || (inside.settings().freezing && inside.settings().water)) d["segregationWork"] = b.segregationWork;
			return d;
		}

		SceneBodies& bodies() override
		{
			if (!met) met = SceneBodies::of(*inside.bodies());
			return *met;
		}

	private:
		talik::Ground<D>             inside;
		std::unique_ptr<SceneBodies> met;
	};
} // namespace

std::shared_ptr<GroundOfScene> GroundOfScene::make(const MpmEngine& engine, int dimension, bool goesOn)
{
	if (dimension == 2) return std::make_shared<InDimension<2>>(engine, goesOn);
	return std::make_shared<InDimension<3>>(engine, goesOn);
}

} // namespace yade
