// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/kernels/NodeLoops.hpp>

namespace talik {

namespace {
	template <int D> const NodeLoops<D>*& chosen()
	{
		static const NodeLoops<D>* loops = &bestVectorLoops<D>();
		return loops;
	}
} // namespace

template <int D> const NodeLoops<D>& nodeLoops() { return *chosen<D>(); }
template <int D> void                chooseNodeLoops(const NodeLoops<D>& loops) { chosen<D>() = &loops; }

template const NodeLoops<2>& nodeLoops<2>();
template const NodeLoops<3>& nodeLoops<3>();
template void                chooseNodeLoops<2>(const NodeLoops<2>&);
template void                chooseNodeLoops<3>(const NodeLoops<3>&);

} // namespace talik
