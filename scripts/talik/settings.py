# SPDX-License-Identifier: GPL-2.0-or-later
"""Settings of MpmEngine for four tasks, as dictionaries of attributes: what is usual, and why.

	mpm = MpmEngine(**talik.settings.settlement(), gridSpacing=0.25, lower=(0, 0), upper=(10, 4), skeleton=ElasticSkeleton())
	talik.settings.slump(damping=0.02)             # a setting of one's own in place of the usual one
	print(talik.settings.usual)                    # attributes that most scenes give; the others are for experts

Each call makes effects of its own, whose attributes may be changed: mpm.water.conductivity = 1e-6.
"""

from yade import wrapper

scale = 1e6  # calendar time in each second of motion, where the calendar does not follow the motion
usual = (
	"gridSpacing",
	"lower",
	"upper",
	"gravity",
	"damping",
	"material",
	"materials",
	"skeleton",
	"skeletons",
	"boundaries",
	"heat",
	"freezing",
	"water",
	"segregation",
	"bodies",
	"thawFront",
	"motion",
)


def settlement(**changes):
	"""Ground that thaws and settles, and does not slide.

	damping 0.3             the ground comes to rest while the calendar runs
	thawFront None          frozen and thawed ground have one velocity: settlement is that of the thaw strain within 1 %, with the front 4 % more
	thermalTimeScale 1e6    a day in 0.09 s of motion. 1e7 is faster, and settles by some per cent too little
	gravity (0, -9.81)      thaw strain is lost along it

	>>> sorted(talik.settings.settlement(damping=0.5))
	['damping', 'freezing', 'gravity', 'heat', 'thawFront']"""
	return _with(changes, damping=0.3, thawFront=None, heat=wrapper.HeatTransfer(thermalTimeScale=scale))


def heave(**changes):
	"""Ground that freezes and heaves by ice segregation.

	segregation             the potential of a silt (Devon silt has 6e-10 to 1.4e-9). Give that of the soil: IceSegregation(segregationPotential=…)
	water, -50 kPa          suction lifts water to the front, so that pressure may fall below 0 (PoreWater.cavitationPressure)
	hydraulicTimeScale 1e6  seepage keeps its ratio to freezing
	damping 0.3, thawFront None, thermalTimeScale 1e6    as for settlement: nothing slides

	>>> talik.settings.heave()["water"].cavitationPressure
	-50000.0"""
	water = wrapper.PoreWater(cavitationPressure=-5e4, hydraulicTimeScale=scale)
	return {**settlement(), **_with({"water": water, "segregation": wrapper.IceSegregation(segregationPotential=1e-9), **changes})}


def slope(**changes):
	"""A slope whose state is wanted while it stands, such as its factor of safety.

	damping 0.3             the ground comes to rest
	thermalTimeScale 1e6    constant: a day in 0.09 s of motion
	hydraulicTimeScale 1e6  seepage keeps its ratio to thaw
	water, implicit         pore pressure of real water, which does not alternate from cell to cell
	thawFront               stays: a thawed layer may slide on frozen ground even if it is thinner than a cell

	>>> talik.settings.slope()["water"].pressure
	'implicit'"""
	water = wrapper.PoreWater(pressure="implicit", hydraulicTimeScale=scale)
	return _with(changes, damping=0.3, heat=wrapper.HeatTransfer(thermalTimeScale=scale), water=water)


def slump(**changes):
	"""A slope that thaws, fails and runs out.

	damping 0.05            a slide is not braked; 0 leaves elastic waves undamped
	thermalTimeScale 8.64e5, followsMotion    ten days in a second while the slope rests, real time while it moves
	water, implicit         as for slope
	thawFront               as for slope

	>>> talik.settings.slump()["heat"].followsMotion
	True"""
	heat = wrapper.HeatTransfer(thermalTimeScale=8.64e5, followsMotion=True)
	return _with(changes, damping=0.05, heat=heat, water=wrapper.PoreWater(pressure="implicit"))


def _with(changes, **own):
	return {"gravity": (0, -9.81), "freezing": wrapper.FreezingCurve(), **own, **changes}
