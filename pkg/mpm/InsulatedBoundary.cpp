// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/InsulatedBoundary.hpp>

namespace talik {

template class InsulatedBoundary<2>;
template class InsulatedBoundary<3>;

} // namespace talik
