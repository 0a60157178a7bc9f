// SPDX-License-Identifier: GPL-2.0-or-later
#include <cmath>
#include <cstring>
#include <pkg/base/SavedBytes.hpp>
#include <pkg/icebond/BondTable.hpp>
#include <pkg/rve/packed/PackedState.hpp>
#include <stdexcept>

namespace talik {

namespace {

	constexpr char formatName[8] = { 'T', 'A', 'L', 'I', 'K', 'P', 'S', '5' };

	template <class T> void number(ByteWriter& writer, const T& item) { writer.raw(&item, sizeof(T)); }
	template <class T> void number(ByteReader& reader, T& item)
	{
		T read;
		reader.raw(&read, sizeof(T));
		item = read;
	}

	/// One list of members for writing and reading, so that they cannot diverge.
	template <class Stream, class State, class Grains> void streamAll(Stream& stream, State& s, Grains& g)
	{
		for (auto* m : { &s.hSize, &s.prevHSize, &s.velGrad, &s.prevVelGrad, &s.nextVelGrad, &s.trsf, &s.stress })
			stream.raw(m->data(), sizeof(*m));
		for (auto* v : { &s.dt, &s.damping, &s.thickness, &s.friction, &s.stiffnessRatio, &s.density, &s.iceSaturation, &s.radiusFactor,
		                 &s.thawStrain.thawStrain, &s.thawStrain.frozenSaturation, &s.cellSlipStrain, &s.cellSlipStress, &s.ice.young,
		                 &g.rolling.alphaKr, &g.rolling.etaRoll, &g.section.radiusFactor, &g.section.contribution, &g.hertz.modulus })
			number(stream, *v);
		for (const BondParameter& parameter : bondParameters)
			number(stream, s.ice.*parameter.value);
		for (auto* v : { &s.step, &s.bondsFormed, &s.bondsBrokenInTension, &s.bondsBrokenInShear, &s.bondsMelted, &s.cellSlips })
			number(stream, *v);
		auto&      c      = s.contacts;
		const auto arrays = [&](auto&... all) { (stream.array(all), ...); };
		arrays(g.radius, g.mass, g.inertia, g.id, s.position, s.velocity, s.angularVelocity, s.orientation);
		arrays(c.first, c.second, c.cellDist, c.shear, c.moment, c.iceShear, c.iceReference, c.grainReference, c.bondMoment, c.bond);
	}

	[[noreturn]] void refuse(const char* attribute, double value, const char* remedy)
	{
		throw std::invalid_argument(std::string("packed sample: ") + attribute + " = " + std::to_string(value) + " " + remedy);
	}

	void requireSize(const char* attribute, std::size_t size, std::size_t wanted)
	{
		if (size != wanted)
			throw std::invalid_argument(
			        std::string("packed sample: ") + attribute + " has " + std::to_string(size) + " entries, not " + std::to_string(wanted)
			        + "; give one per grain or contact");
	}

	void requirePositive(const char* attribute, const std::vector<double>& values)
	{
		for (const double value : values)
			if (!(value > 0) || !std::isfinite(value)) refuse(attribute, value, "of a grain must be positive and finite");
	}

} // namespace

template <int Dim> double PackedParameters<Dim>::volume() const
{
	const Matrix& h = hSize;
	if constexpr (Dim == 2) return std::fabs(h(0, 0) * h(1, 1) - h(0, 1) * h(1, 0)) * thickness;
	else
		return std::fabs(
		        h(0, 0) * (h(1, 1) * h(2, 2) - h(1, 2) * h(2, 1)) - h(0, 1) * (h(1, 0) * h(2, 2) - h(1, 2) * h(2, 0))
		        + h(0, 2) * (h(1, 0) * h(2, 1) - h(1, 1) * h(2, 0)));
}

template <int Dim> void PackedParameters<Dim>::checkParameters() const
{
	if (!(dt > 0) || !std::isfinite(dt)) refuse("dt", dt, "s must be positive; 0.3 to 0.5 of the critical time step is usual");
	if (!(damping >= 0 && damping < 1)) refuse("damping", damping, "must lie in 0..1; 0.2 to 0.5 is usual");
	if (!(friction >= 0)) refuse("friction", friction, "(a tangent) must not be negative");
	if (!(stiffnessRatio >= 0)) refuse("stiffnessRatio", stiffnessRatio, "must not be negative");
	if (Dim == 2 && !(thickness > 0)) refuse("thickness", thickness, "m must be positive; 0.1 m is the usual slice");
	if (!(density > 0)) refuse("density", density, "kg/m^3 must be positive");
	if (!(ice.young > 0)) refuse("ice.young", ice.young, "Pa must be positive");
	for (const BondParameter& parameter : bondParameters)
		if (!parameter.isValid(ice))
			refuse((std::string("ice.") + parameter.name).c_str(), ice.*parameter.value, ("is not valid: " + parameter.remedy()).c_str());
	if (!(iceSaturation >= 0 && iceSaturation <= 1)) refuse("iceSaturation", iceSaturation, "must lie in 0..1");
	if (!(radiusFactor > 0)) refuse("radiusFactor", radiusFactor, "must be positive");
	if (!(thawStrain.thawStrain >= 0 && thawStrain.thawStrain < 1))
		refuse("thawStrain.thawStrain", thawStrain.thawStrain, "must lie between 0 (grains keep their radii) and 1");
	if (!(thawStrain.frozenSaturation >= 0 && thawStrain.frozenSaturation <= 1))
		refuse("thawStrain.frozenSaturation", thawStrain.frozenSaturation, "must lie in 0..1");
	if (!(volume() > 0) || !std::isfinite(volume())) refuse("hSize: cell volume", volume(), "m^3 must be positive; give independent cell vectors");
}

template <int Dim> void PackedState<Dim>::check() const
{
	this->checkParameters();
	if (!grains) throw std::invalid_argument("packed sample: grains is null; give radii, masses and inertias");
	const std::size_t n = grains->size();
	if (n == 0 || n > 65000) refuse("number of grains", double(n), "must lie in 1..65000");
	requireSize("grains.mass", grains->mass.size(), n);
	requireSize("grains.inertia", grains->inertia.size(), n);
	requireSize("grains.id", grains->id.size(), n);
	requirePositive("radius", grains->radius);
	requirePositive("mass", grains->mass);
	requirePositive("inertia", grains->inertia);
	for (const double value : { grains->rolling.alphaKr, grains->rolling.etaRoll })
		if (!(value >= 0) || !std::isfinite(value)) refuse("alphaKr or etaRoll", value, "must be finite and not negative");
	const BondSection& section = grains->section;
	if (!(section.radiusFactor >= 0) || !std::isfinite(section.radiusFactor))
		refuse("bondRadiusFactor", section.radiusFactor, "must be finite and not negative");
	if (!(grains->hertz.modulus >= 0) || !std::isfinite(grains->hertz.modulus))
		refuse("hertz.modulus", grains->hertz.modulus, "Pa must be finite and not negative");
	if (!(section.contribution >= 0 && section.contribution <= 1)) refuse("momentContribution", section.contribution, "must lie in 0..1");
	requireSize("position", position.size(), n);
	requireSize("velocity", velocity.size(), n);
	requireSize("angularVelocity", angularVelocity.size(), n);
	requireSize("orientation", orientation.size(), Dim == 2 ? n : 0);
	for (std::size_t g = 0; g < n; ++g)
		if (!position[g].allFinite() || !velocity[g].allFinite()) refuse("position or velocity of grain", double(g), "is not finite");
	const std::size_t m = contacts.size();
	requireSize("contacts.second", contacts.second.size(), m);
	requireSize("contacts.cellDist", contacts.cellDist.size(), m);
	requireSize("contacts.shear", contacts.shear.size(), m);
	requireSize("contacts.moment", contacts.moment.size(), resistsRolling() ? m : 0);
	const std::size_t bonds = bonded() ? m : 0;
	requireSize("contacts.bond", contacts.bond.size(), bonds);
	requireSize("contacts.iceShear", contacts.iceShear.size(), bonds);
	requireSize("contacts.iceReference", contacts.iceReference.size(), bonds);
	requireSize("contacts.grainReference", contacts.grainReference.size(), bonds);
	requireSize("contacts.bondMoment", contacts.bondMoment.size(), bondsCarryMoments() ? bonds : 0);
	for (std::size_t k = 0; k < m; ++k)
		if (contacts.first[k] >= contacts.second[k] || contacts.second[k] >= n)
			refuse("contacts.second", contacts.second[k], "must be a grain's index and larger than contacts.first");
}

template <int Dim> std::string PackedState<Dim>::toBytes() const
{
	check();
	ByteWriter         writer;
	const std::int32_t dimension = Dim;
	writer.raw(formatName, sizeof(formatName));
	number(writer, dimension);
	streamAll(writer, *this, *grains);
	return writer.bytes();
}

static std::int32_t takeDimension(ByteReader& reader)
{
	char         name[sizeof(formatName)];
	std::int32_t dimension = 0;
	reader.raw(name, sizeof(name));
	if (std::memcmp(name, formatName, sizeof(name)) != 0) throw std::runtime_error("packed sample: these bytes are not a packed sample of this version");
	number(reader, dimension);
	return dimension;
}

int packedDimension(const std::string& bytes)
{
	ByteReader reader(bytes);
	return takeDimension(reader);
}

template <int Dim> PackedState<Dim> PackedState<Dim>::fromBytes(const std::string& bytes)
{
	ByteReader reader(bytes);
	const auto dimension = takeDimension(reader);
	if (dimension != Dim) throw std::runtime_error("packed sample: saved with dimension " + std::to_string(dimension) + ", wanted " + std::to_string(Dim));
	PackedState state;
	auto        grains = std::make_shared<PackedGrains>();
	streamAll(reader, state, *grains);
	if (!reader.atEnd()) throw std::runtime_error("packed sample: the saved bytes are longer than a sample; save again");
	state.grains = std::move(grains);
	state.check();
	return state;
}

template struct PackedParameters<2>;
template struct PackedParameters<3>;
template struct PackedState<2>;
template struct PackedState<3>;

} // namespace talik
