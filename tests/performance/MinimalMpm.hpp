// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <vector>

namespace minimal {

/// What a dry material point method cannot do without: quadratic B-splines, FLIP, plane strain, one law, a rigid rough floor at
/// y = 0, free sides. Nothing is checked; points lie in cell order and are never sorted again. One thread.
struct Scene {
	int    columns, rows; ///< cells of the box
	double spacing, step; ///< [m], [s]
	double gravity;       ///< downwards [m/s^2]
	double flipFraction;
	double lambda, shear; ///< elastic [Pa]
	bool   plastic;       ///< Mohr and Coulomb on top, without dilation and tension
	double cohesion, sinFriction, cosFriction;
};

/// Points as arrays, nodes as records. Node coordinates count from a layer of ghost nodes around the box.
struct Block {
	Scene               scene;
	int                 count;
	double *            x, *y, *vx, *vy, *mass, *volume, *xx, *yy, *zz, *xy;
	double*             nodes;  ///< [mass, momentum x, y, unused, force x, y]
	double*             solved; ///< [change x, y, velocity x, y]
	int                 nodeCount, stride;
	std::vector<double> memory;

	/// perDirection^2 points per cell fill the box [left, left + width] x [0, height] [m].
	Block(const Scene&, double left, double width, double height, int perDirection, double density);
	Block(const Block&) = delete;
};

/// One step for a kind of processor; all do the same operations.
struct Kernel {
	const char* name;
	void (*step)(Block&);
};

extern const Kernel plain, avx2, avx512;

/// The fastest that this processor knows.
const Kernel& fastest();

/// Returns the stress xx, yy, zz, xy to the yield surface of the scene.
void returnStress(const Scene&, double (&stress)[4]);

} // namespace minimal
