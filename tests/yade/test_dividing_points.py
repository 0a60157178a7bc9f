# SPDX-License-Identifier: GPL-2.0-or-later
"""Points that divide while a ground with samples is drawn out, as scripts see them."""

import numpy as np
from fixtures import thirty
from yade import O, wrapper

import talik
from talik import rve

run = talik._talik.runSerially


def drawnOut(sample, **ofSkeleton):
	"""One point a cell, twice as long after a twentieth of a second."""
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(-1, 0),
		upper=(5, 1),
		gravity=(0, -9.81),
		pointsDivide=True,
		skeleton=wrapper.RveSkeleton(samples=[sample], strainTolerance=1e-3, **ofSkeleton),
		heat=wrapper.HeatTransfer(),
		freezing=wrapper.FreezingCurve(),
		boundaries=[wrapper.RollerBoundary(region="bottom")],
	)
	position, volume = talik.geometry.fillPolygon([(0, 0), (1, 0), (1, 0.5), (0, 0.5)], 0.25, pointsPerCell=1)
	mpm.addPoints(position=position, volume=volume, porosity=0.4, temperature=-1.0, velocity=np.column_stack([20 * position[:, 0], 0 * position[:, 1]]))
	O.reset()
	O.engines = [mpm]
	return mpm


def divided(mpm):
	given = mpm.pointCount
	for _ in range(60):
		run(10)
		if mpm.pointCount > given:
			return given
	raise AssertionError(f"none of {given} points divided in {O.time} s")


def check(form, sampleCache, tmp_path):
	mpm = drawnOut(rve.pack(rve.prepare(**thirty, cache=sampleCache)), form=form)
	mpm.initialise()
	mass = mpm.field("mass").sum()
	given = divided(mpm)
	new = mpm.pointCount - 1
	for name in mpm.fieldNames():
		assert len(mpm.field(name)) == mpm.pointCount, name
	bonds = mpm.field("bondsIntact")
	print(f"{form}: {given} points became {mpm.pointCount}; mass {mpm.field('mass').sum() / mass - 1:.1e}; {bonds[new]:.0f} bonds in the last")
	assert abs(mpm.field("mass").sum() / mass - 1) < 1e-14
	assert len(mpm.addedPoints()["volume"]) == given and bonds[new] > 10
	with mpm.inspect(new):
		assert len(O.bodies) == 30
	mpm.watch([new], fields=["volume", "bondsIntact"])
	run(5)
	assert len(mpm.history(new)["volume"]) >= 5
	O.save(str(tmp_path / "scene.yade.gz"))
	run(20)
	expected = mpm.field("position"), mpm.field("stress")
	O.load(str(tmp_path / "scene.yade.gz"))
	mpm = O.engines[0]
	run(20)
	found = mpm.field("position"), mpm.field("stress")
	for a, b in zip(expected, found):
		assert a.shape == b.shape and (form == "open" or np.array_equal(a, b))
	if form == "packed":
		mpm.exchangeSkeletons([mpm.skeleton, wrapper.ElasticSkeleton(young=1e7)], np.arange(mpm.pointCount) % 2)
		run(20)
		assert mpm.skeletonOf[new] == new % 2 and np.isnan(mpm.field("bondsIntact")).sum() == mpm.pointCount // 2


def test_points_that_divide_have_copies_of_their_samples_and_can_be_looked_at_watched_and_saved(sampleCache, tmp_path):
	check("packed", sampleCache, tmp_path)


def test_points_that_divide_have_copies_of_their_open_samples_slow(sampleCache, tmp_path):
	check("open", sampleCache, tmp_path)
