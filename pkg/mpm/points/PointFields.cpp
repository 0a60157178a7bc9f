// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/points/PointFields.hpp>

#include <algorithm>
#include <new>
#include <stdexcept>

namespace talik {

namespace {
	constexpr std::size_t cacheLine = 64;
	// Arrays of equal size that start at the same page offset fight for the same sets of the first-level cache.
	constexpr std::size_t stagger = 192;
	constexpr std::size_t page    = 4096;

	bool isExtensive(const std::string& unit)
	{
		static const std::vector<std::string> units { "kg", "J", "J/K", "kg/s", "m^D", "m^2", "m^3" };
		return std::find(units.begin(), units.end(), unit) != units.end();
	}

	std::size_t roundUp(std::size_t bytes, std::size_t unit) { return (bytes + unit - 1) / unit * unit; }
} // namespace

PointFields::Handle PointFields::declare(const std::string& name, const std::string& owner, const std::string& unit, int components, bool persistent)
{
	if (storage_.data()) throw std::logic_error("field '" + name + "' declared after the points were allocated");
	if (has(name)) throw std::logic_error("field '" + name + "' declared twice, the second time by " + owner);
	firstArray_.push_back(int(arrays_.size()));
	arrays_.resize(arrays_.size() + components, nullptr);
	bound_.resize(arrays_.size(), nullptr);
	info_.push_back({ name, owner, unit, "points", components, 0, persistent });
	return Handle(info_.size()) - 1;
}

void PointFields::allocate(int count, int capacity)
{
	capacity_                  = std::max(count, capacity);
	const std::size_t one      = std::size_t(capacity_) * sizeof(double);
	const std::size_t perArray = roundUp(one + stagger, page) + stagger;
	const std::size_t total    = roundUp(perArray * std::max<std::size_t>(arrays_.size(), 1), page);
	storage_                   = PagedMemory(total);
	for (std::size_t i = 0; i < arrays_.size(); ++i)
		arrays_[i] = reinterpret_cast<double*>(storage_.data() + roundUp(i * perArray, cacheLine));
	for (std::size_t i = 0; i < arrays_.size(); ++i)
		if (bound_[i]) *bound_[i] = arrays_[i];
	resize(count);
}

void PointFields::resize(int count)
{
	count_ = count;
	for (FieldInfo& f : info_)
		f.bytes = std::size_t(count) * sizeof(double) * f.components;
}

void PointFields::halve(const std::vector<int>& places)
{
	for (std::size_t i = 0; i < info_.size(); ++i)
		for (int c = 0; isExtensive(info_[i].unit) && c < info_[i].components; ++c)
			for (const int p : places)
				component(Handle(i), c)[p] *= 0.5;
}

bool PointFields::has(const std::string& name) const
{
	return std::any_of(info_.begin(), info_.end(), [&](const FieldInfo& f) { return f.name == name; });
}

double* PointFields::component(Handle field, int component) const
{
	if (field < 0 || field >= int(info_.size()) || component < 0 || component >= info_[field].components) return nullptr;
	return arrays_[firstArray_[field] + component];
}

double* PointFields::find(const std::string& name, int component) const
{
	for (std::size_t i = 0; i < info_.size(); ++i)
		if (info_[i].name == name) return this->component(Handle(i), component);
	return nullptr;
}

void PointFields::keepOnly(int first, int end)
{
	for (double* array : arrays_) {
		const auto begin = std::size_t(reinterpret_cast<char*>(array) - storage_.data());
		storage_.forget(begin, begin + first * sizeof(double));
		storage_.forget(begin + end * sizeof(double), begin + capacity_ * sizeof(double));
	}
	scratch_.clear();
	scratch_.shrink_to_fit();
}

void PointFields::reorder(const std::vector<int>& from, int at)
{
	scratch_.resize(from.size());
	for (double* array : arrays_) {
		for (std::size_t k = 0; k < from.size(); ++k)
			scratch_[k] = array[from[k]];
		std::copy(scratch_.begin(), scratch_.end(), array + at);
	}
}

} // namespace talik
