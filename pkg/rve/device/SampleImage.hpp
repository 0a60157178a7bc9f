// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <memory>
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
	/// Bonds are going to form: the place has room for them.
	void        makeRoomForBonds() { workspace.carryBonds(true); }
	bool        carriesBonds() const { return workspace.carriesBonds; }
	PlaceLayout layout() const;
	/// With room for lists of so many pairs and for some more.
	static PlaceLayout layoutOf(int grains, int pairs, bool bonded, bool hertz);
	void               write(const PlaceLayout&, std::vector<unsigned char>& bytes) const;
	/// What calls of this sample have in common: all but place, velocity gradient and steps.
	SampleCall call() const;

	/// The workspace takes a sample from the bytes of its place, with the lists that the call has last seen; the parameters, the use of the lists and
	/// whether it carries bonds are not in the bytes.
	void take(
	        const PlaceLayout&, const std::vector<unsigned char>& bytes, const SampleCall& call, const PackedParameters<Dim>& parameters,
	        std::shared_ptr<const PackedGrains> grains, const PackedListUse<Dim>& use, bool carriesBonds);

	const PackedListUse<Dim>& listUse() const { return workspace.use; }

private:
	template <class Visitor> void forPairs(Visitor&& visit) const; ///< visit(number, lanes, lane, crosses)
	std::vector<int>              imageNumbers() const;            ///< of the rows of shifts
	template <class Out> void     takeGrains(const Out& rows, int grains, PackedState<Dim>& state, PackedLists<Dim>& lists);
	template <class Out> void     takePairs(const Out& rows, const PlaceLayout&, const SampleCall&, PackedContacts<Dim>&, PackedLists<Dim>&);

	PackedWorkspace<Dim>& workspace;
};

} // namespace talik
