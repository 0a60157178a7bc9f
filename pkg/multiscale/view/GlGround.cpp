// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <pkg/common/OpenGLRenderer.hpp>
#include <pkg/icebond/Gl1_IceBondPhys.hpp>
#include <pkg/mpm/AnyGround.hpp>
#include <pkg/multiscale/engine/MpmEngine.hpp>
#include <pkg/multiscale/view/GroundPicture.hpp>
#include <pkg/python/StepGate.hpp>

namespace yade {

/// Draws the points of a ground in the 3-D view, beside the bodies of the scene.
class GlGround : public GlExtraDrawer {
public:
	void render() override;
	void postLoad(GlGround&);

private:
	void drawPoints(const talik::GroundPicture::Points& points);

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(GlGround,GlExtraDrawer,"Draws the points of an MpmEngine in the 3-D view as squares of their volume, in space as "
			"cubes, coloured by a field. While the ground runs the view shows it as it was at the end of a recent step. It is drawn once it is in "
			"yade.qt.Renderer().extraDrawers. Example: GlGround(field='temperature',smallest=-5,largest=10).",
		((shared_ptr<MpmEngine>,mpm,,Attr::triggerPostLoad,"The ground; None draws nothing."))
		((string,field,"displacement",Attr::triggerPostLoad,"Field of the points, as in mpm.fieldNames() but for those of samples and strains; of several "
				"components the norm."))
		((Real,smallest,NaN,,"Value that is drawn with lowColor [unit of the field]; NaN: the smallest in the picture."))
		((Real,largest,NaN,,"Value that is drawn with highColor [unit of the field]; NaN: the largest in the picture."))
		((Vector3r,lowColor,Vector3r(0.95,0.9,0.75),,"Colour of the smallest value: red, green, blue from 0 to 1 [-]."))
		((Vector3r,highColor,Vector3r(0.1,0.3,0.7),,"Colour of the largest value: red, green, blue from 0 to 1 [-]."))
		((long,drawn,0,Attr::readonly,"Points drawn the last time; 0 before."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(GlGround);

} // namespace yade

namespace talik {
namespace {
	std::vector<double> component(const AnyGround& ground, const std::string& field, int number, std::size_t points)
	{
		std::vector<double> values(points);
		ground.copyById(field, number, values.data());
		return values;
	}

	std::vector<double> valuesOf(const AnyGround& ground, const std::string& field, std::size_t points)
	{
		for (const FieldInfo& info : ground.fields()) {
			if (info.place != "points" || info.name != field) continue;
			std::vector<double> values = component(ground, field, 0, points);
			if (info.components == 1) return values;
			for (double& value : values)
				value *= value;
			for (int c = 1; c < info.components; ++c) {
				const std::vector<double> more = component(ground, field, c, points);
				for (std::size_t k = 0; k < points; ++k)
					values[k] += more[k] * more[k];
			}
			for (double& value : values)
				value = std::sqrt(value);
			return values;
		}
		return {};
	}
} // namespace

void GroundPicture::ask(const std::string& wanted)
{
	const std::lock_guard<std::mutex> lock(mutex);
	field = wanted;
	asked = true;
}

void GroundPicture::takeIfAsked(const AnyGround& ground, int pointCount)
{
	if (!asked) return;
	std::string wanted;
	{
		const std::lock_guard<std::mutex> lock(mutex);
		wanted = field;
		asked  = false;
	}
	const std::size_t points  = pointCount;
	const auto        picture = std::make_shared<Points>();
	picture->dimension        = ground.dimension();
	for (int a = 0; a < picture->dimension; ++a)
		picture->position[a] = component(ground, "position", a, points);
	picture->edge = component(ground, "volume", 0, points);
	for (double& edge : picture->edge)
		edge = picture->dimension == 2 ? std::sqrt(edge) : std::cbrt(edge);
	picture->value = valuesOf(ground, wanted, points);
	const std::lock_guard<std::mutex> lock(mutex);
	taken = picture;
}

std::shared_ptr<const GroundPicture::Points> GroundPicture::last() const
{
	const std::lock_guard<std::mutex> lock(mutex);
	return taken;
}

} // namespace talik

namespace yade {
YADE_PLUGIN((GlGround));

namespace {

	void drawSquare(const Vector3r& centre, Real half)
	{
		for (const auto& corner : { std::pair { -1, -1 }, { 1, -1 }, { 1, 1 }, { -1, 1 } })
			glVertex3d(centre[0] + corner.first * half, centre[1] + corner.second * half, centre[2]);
	}

	/// Faces along the axes have shades of their own, in place of light.
	void drawCube(const Vector3r& centre, Real half, const Vector3r& color)
	{
		constexpr Real shades[] = { 0.75, 0.88, 1 };
		for (int axis = 0; axis < 3; ++axis) {
			const Vector3r u = Vector3r::Unit((axis + 1) % 3), v = Vector3r::Unit((axis + 2) % 3), shaded = shades[axis] * color;
			glColor3d(shaded[0], shaded[1], shaded[2]);
			for (const int side : { -1, 1 })
				for (const auto& corner : { std::pair { -1, -1 }, { 1, -1 }, { 1, 1 }, { -1, 1 } }) {
					const Vector3r at = centre + half * (side * Vector3r::Unit(axis) + corner.first * u + corner.second * v);
					glVertex3d(at[0], at[1], at[2]);
				}
		}
	}

	/// Smallest and largest of the numbers that are finite; 0 and 0 if none is.
	std::pair<Real, Real> rangeOf(const vector<double>& values)
	{
		Real lowest = std::numeric_limits<Real>::infinity(), highest = -lowest;
		for (const double value : values) {
			if (!std::isfinite(value)) continue;
			lowest  = std::min(lowest, value);
			highest = std::max(highest, value);
		}
		return lowest <= highest ? std::make_pair(lowest, highest) : std::make_pair(Real(0), Real(0));
	}

} // namespace

void GlGround::postLoad(GlGround&)
{
	if (!mpm || !mpm->isInitialised()) return;
	string names;
	for (const auto& info : mpm->runningGround().fields()) {
		if (info.place != "points") continue;
		if (info.name == field) return;
		names += (names.empty() ? "" : ", ") + info.name;
	}
	throw std::invalid_argument("GlGround.field is '" + field + "', which the points of this ground do not have; there are " + names + ".");
}

void GlGround::render()
{
	if (!mpm) return;
	mpm->picture.ask(field);
	{
		const talik::StepGate gate(std::try_to_lock); // whoever steps may wait for this view
		if (gate.passes() && mpm->isInitialised()) mpm->picture.takeIfAsked(mpm->runningGround(), mpm->pointCount());
	}
	if (const auto points = mpm->picture.last()) drawPoints(*points);
}

void GlGround::drawPoints(const talik::GroundPicture::Points& points)
{
	const talik::Unlit unlit;
	const auto         range = rangeOf(points.value);
	const Real         from = std::isnan(smallest) ? range.first : smallest, to = std::isnan(largest) ? range.second : largest;
	const auto         colorOf = [&](std::size_t k) -> Vector3r {
                if (points.value.empty() || !std::isfinite(points.value[k])) return Vector3r(0.5, 0.5, 0.5);
                const Real share = to > from ? std::min(std::max((points.value[k] - from) / (to - from), Real(0)), Real(1)) : 0;
                return (1 - share) * lowColor + share * highColor;
	};
	glBegin(GL_QUADS);
	for (std::size_t k = 0; k < points.edge.size(); ++k) {
		const Vector3r color = colorOf(k);
		const Vector3r centre(points.position[0][k], points.position[1][k], points.dimension == 3 ? points.position[2][k] : 0);
		if (!centre.allFinite()) continue;
		glColor3d(color[0], color[1], color[2]);
		if (points.dimension == 2) drawSquare(centre, 0.5 * points.edge[k]);
		else drawCube(centre, 0.5 * points.edge[k], color);
	}
	glEnd();
	drawn = points.edge.size();
}

} // namespace yade
