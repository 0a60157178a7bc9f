// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/AnyGround.hpp>
#include <pkg/multiscale/GroundPicture.hpp>

#include <cmath>

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
