# SPDX-License-Identifier: GPL-2.0-or-later
"""Named settings do what they are for, against closed forms."""

import pydoc
import re

import numpy as np
import pytest
from yade import O, wrapper

import talik


def column(settings, temperature, top, **more):
	mpm = wrapper.MpmEngine(
		**settings,
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(0.25, 1.5),
		skeleton=wrapper.ElasticSkeleton(young=3e7),
		boundaries=[
			*(wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")),
			wrapper.SurfaceTemperature(region="surface", temperature=top),
		],
		**more,
	)
	talik.layers.fill(mpm, {"silt": dict(polygon=talik.geometry.rectangle(0, 0, 0.25, 1), porosity=0.5, temperature=temperature)}, lateralRatio=0.5)
	O.engines = [mpm]
	return mpm


def test_settings_for_settlement_give_the_thaw_strain():
	silt = wrapper.GroundMaterial(thawStrain=0.1)
	mpm = column(talik.settings.settlement(), temperature=-0.1, top=40, material=silt)
	talik.runUntilDay(mpm, 60)
	moved = mpm.field("displacement")[:, 1]
	start = mpm.field("position")[:, 1] - moved
	top = start.argmax()
	settled = -moved[top] / start[top]  # of the ground below this point, over its height
	print(f"settled by {1e3 * settled:.1f} mm, thaw strain times 1 m 100 mm; thawed {100 * (mpm.field('iceSaturation') < 0.5).mean():.0f} %")
	assert (mpm.field("iceSaturation") < 0.01).all() and settled == pytest.approx(0.1, rel=0.03)


@pytest.mark.parametrize("name", ["settlement", "heave", "slope", "slump"])
def test_every_set_of_settings_makes_a_ground_without_doubts_that_runs(name):
	settings = getattr(talik.settings, name)
	freezes = name == "heave"
	mpm = column(settings(damping=0.2), temperature=1.0 if freezes else -1.0, top=-1 if freezes else 5)
	O.run(5, True)
	print(name, sorted(settings()), talik.check(mpm))
	assert mpm.damping == 0.2 and np.isfinite(mpm.field("stress")).all() and talik.check(mpm) == []
	assert settings()["heat"] is not settings()["heat"]


def test_the_usual_attributes_are_attributes():
	assert all(hasattr(wrapper.MpmEngine, name) for name in talik.settings.usual)


def test_help_names_what_most_scenes_give_first_and_nothing_that_says_nothing():
	page = pydoc.plain(pydoc.render_doc(wrapper.MpmEngine))
	assert "Most scenes give gridSpacing, lower, upper, gravity" in page.split("Methods defined here")[0].replace("\n |  ", " ")
	section = page.split("Data descriptors defined here:")[1].split("----------")[0]
	listed = re.findall(r"^ \|  (\w+)$", section, re.M)
	print(listed)
	usual = [name for name in talik.settings.usual if name in listed]
	assert listed[: len(usual)] == usual and len(usual) > 12 and len(listed) > 25
	assert "bogus" not in page and "just define" not in page
