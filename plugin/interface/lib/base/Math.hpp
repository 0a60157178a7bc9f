// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
/// Numeric types of stock YADE 2023.02a in double precision, under YADE's own names.
#include <boost/lexical_cast.hpp>
#include <boost/shared_ptr.hpp>
#include <cmath>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#ifndef EIGEN_DONT_ALIGN
#error "stock YADE is built with EIGEN_DONT_ALIGN; every unit that includes its interface must be, too"
#endif

namespace yade {
using boost::shared_ptr;
using std::runtime_error;
using std::string;
using std::vector;

using Real        = double;
using Vector2r    = Eigen::Matrix<Real, 2, 1>;
using Vector2i    = Eigen::Matrix<int, 2, 1>;
using Vector3r    = Eigen::Matrix<Real, 3, 1>;
using Vector3i    = Eigen::Matrix<int, 3, 1>;
using Vector6r    = Eigen::Matrix<Real, 6, 1>;
using Matrix3r    = Eigen::Matrix<Real, 3, 3>;
using Quaternionr = Eigen::Quaternion<Real>;
using mask_t      = int;

/// Position and orientation of a body, in this order in memory.
struct Se3r {
	Vector3r    position;
	Quaternionr orientation;
};

const Real NaN = std::numeric_limits<Real>::signaling_NaN();
} // namespace yade
