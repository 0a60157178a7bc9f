// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/rve/device/SampleCall.hpp>
#include <pkg/rve/packed/PackedWorkspace.hpp>
#include <vector>

namespace talik {

/// A loaded workspace as bytes for a device, and back.
template <int Dim> class SampleImage {
public:
	explicit SampleImage(PackedWorkspace<Dim>& w)
	        : workspace(w)
	{}

	/// Why no kernel can advance this sample with the bits of the processor, or nothing.
	std::string reasonAgainst() const;
	PlaceLayout layout() const;
	void        write(const PlaceLayout&, std::vector<unsigned char>& bytes) const;
	/// What calls of this sample have in common: all but place, velocity gradient and steps.
	SampleCall call() const;

	/// The workspace holds a former state with the same lists: it takes the motion, forces and bonds of the bytes, the parameters and the use of
	/// the lists.
	void take(const PlaceLayout&, const std::vector<unsigned char>& bytes, const PackedParameters<Dim>& parameters, const PackedListUse<Dim>& use);

	/// Whether the lists of neighbours are to be built anew before the next step.
	bool                      listsExhausted() const { return workspace.listsExhausted(); }
	const PackedListUse<Dim>& listUse() const { return workspace.use; }

private:
	template <class Visitor> void forPairs(Visitor&& visit) const; ///< visit(number, lanes, lane, crosses)
	std::vector<int>              imageNumbers() const;            ///< of the rows of shifts

	PackedWorkspace<Dim>& workspace;
};

} // namespace talik
