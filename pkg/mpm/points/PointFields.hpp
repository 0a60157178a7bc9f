// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/PagedArray.hpp>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace talik {

/// What is known about one field of the points or of the nodes.
struct FieldInfo {
	std::string name;
	std::string owner; ///< the effect that needs it
	std::string unit;
	std::string place;      ///< "points" or "nodes"
	int         components; ///< arrays of doubles
	std::size_t bytes;
	bool        persistent; ///< part of the state that a checkpoint holds (the rest is recomputed in each step)
};

/// Registry and storage of the fields of the material points. Every field is a set of contiguous arrays of doubles, one per
/// component, owned by the effect that declared it. Declare first, then allocate once; pointers stay valid afterwards, also
/// when the points are reordered.
class PointFields {
public:
	/// Handle of a declared field.
	using Handle = int;

	/// Declares a field. Throws std::logic_error if the name is taken or storage exists already.
	Handle declare(const std::string& name, const std::string& owner, const std::string& unit, int components, bool persistent = true);
	/// The same. The pointers, one for each component, are those of its arrays from allocate() on; they stay where they are.
	template <std::size_t N>
	void declare(const std::string& name, const std::string& owner, const std::string& unit, std::array<double*, N>& arrays, bool persistent = true)
	{
		const Handle field = declare(name, owner, unit, int(N), persistent);
		for (std::size_t c = 0; c < N; ++c)
			bound_[firstArray_[field] + c] = &arrays[c];
	}
	void declare(const std::string& name, const std::string& owner, const std::string& unit, double*& array, bool persistent = true)
	{
		bound_[firstArray_[declare(name, owner, unit, 1, persistent)]] = &array;
	}

	/// Allocates all fields for count points, set to zero, with place for others that may come if the capacity is larger.
	void allocate(int count, int capacity = 0);

	int  count() const { return count_; }
	int  capacity() const { return capacity_; }
	bool has(const std::string& name) const;

	/// Array of one component; nullptr if the field is not there.
	double* component(Handle field, int component = 0) const;
	double* find(const std::string& name, int component = 0) const;

	const std::vector<FieldInfo>& list() const { return info_; }

	/// Place at + k receives what was at place from[k], in every field.
	void reorder(const std::vector<int>& from, int at = 0);
	/// The points at these places are halves: of their mass, volume and energy, by the units of fields, and with all else.
	void halve(const std::vector<int>& places);
	/// So many points, which fit into the capacity.
	void resize(int count);
	/// All but the places [first, end) are zero and take no memory.
	void keepOnly(int first, int end);
	/// Arrays of doubles, one per component of each field.
	const std::vector<double*>& arrays() const { return arrays_; }

private:
	std::vector<FieldInfo> info_;
	std::vector<int>       firstArray_;
	std::vector<double*>   arrays_;
	std::vector<double**>  bound_; ///< by array, the pointer that whoever declared it has, or null
	PagedMemory            storage_;
	std::vector<double>    scratch_;
	int                    count_ = 0, capacity_ = 0;
};

} // namespace talik
