# SPDX-License-Identifier: GPL-2.0-or-later
"""The thaw slump of the examples, at a reduced end time, against its finest affordable run.

The reference is fine in grid, grains and samples; transfer, stiffness of water, scale of thermal time and time step are the standard's.
Errors of rows that change one of these four say how far the reference itself is from them."""

import tempfile

import numpy as np
import talik
import thaw_slump_surface
import thawslump
from yade import O

from talik.studies.accuracy.problem import Problem, Stopwatch, groundRun, largestRelative


standard = {
	"grid spacing": 0.5,
	"grains": 100,
	"sample tolerance": 2e-5,
	"inertial number": 5e-3,
	"tolerance": 0.0,
	"time-step fraction": 0.4,
	"transfer": "flip",
	"bulk modulus of water": 2.2e7,
	"thermal time scale": 8.64e5,
	"days of heat": 60,
}
scene = {
	"scene": thaw_slump_surface.case,
	"skeleton": "samples",
	"realisations": 1,
	"thawed cohesion": 0.0,
	"frozen modulus": thawslump.Ground.frozenModulus,
	"thaw strain": 0.0,
	"follows motion": False,
	"motion tolerance": thawslump.Ground.motionTolerance,
	"pore pressure": "explicit",
	"PIC time over sqrt(h/g)": thawslump.Ground.picTimeFactor,
}  # what the problem below leaves as it is


def slump(settings, folder):
	"""ThawSlump as the settings say; what they do not name is that of `standard` and `scene`."""
	s = {**standard, **scene, **settings}
	preset = thawslump.Preset(
		s["grid spacing"],
		s["grains"],
		s["days of heat"],
		strainTolerance=s["sample tolerance"],
		maxInertialNumber=s["inertial number"],
		realisations=s["realisations"],
		stressTolerance=s.get("stress tolerance", thawslump.Preset.stressTolerance),
	)
	ground = thawslump.Ground(
		thermalTimeScale=s["thermal time scale"],
		porePressure=s["pore pressure"],
		bulkModulus=s["bulk modulus of water"],
		frozenModulus=s["frozen modulus"],
		thawedCohesion=s["thawed cohesion"],
		thawStrain=s["thaw strain"],
		followsMotion=s["follows motion"],
		motionTolerance=s["motion tolerance"],
		picTimeFactor=s["PIC time over sqrt(h/g)"],
	)
	case = thawslump.ThawSlump(s["scene"], preset, folder, ground, skeleton=s["skeleton"])
	case.mpm.courantNumber, case.mpm.transfer = s["time-step fraction"], s["transfer"]
	case.mpm.tolerance = s["tolerance"]
	if s["skeleton"] == "samples" and s["sample tolerance"] == 0:
		case.skeleton.saturationTolerance = 0
	return case


def run(settings):
	watch = Stopwatch()
	with tempfile.TemporaryDirectory() as folder:
		case = slump(settings, folder)
	mpm = case.mpm
	with watch:
		case.rest()
	frozen = mpm.field("iceSaturation").max()
	with watch:
		talik.runUntilDay(mpm, case.preset.days)
	runOut = np.linalg.norm(mpm.field("displacement"), axis=1).max()
	thawed = np.sum((1 - mpm.field("iceSaturation") / frozen) * mpm.field("volume"))
	return groundRun(mpm, (runOut, thawed), watch, O.iter)


problem = Problem(
	name="thaw slump",
	title="Thaw slump, case I, 60 days of heat",
	norm="larger of the relative errors of the largest displacement and of the thawed volume",
	reference="finest affordable run",
	standard=standard,
	sweeps={
		"grid spacing": (0.25,),
		"grains": (200, 400),
		"sample tolerance": (5e-6,),
		"inertial number": (5e-4,),
		"tolerance": (0.01,),
		"time-step fraction": (0.2,),
		"transfer": ("apic",),
		"bulk modulus of water": (2.2e8,),
		"thermal time scale": (2.16e5,),
	},
	quick={
		"grains": (60, 200),
		"sample tolerance": (2e-4,),
		"inertial number": (1e-3,),
		"tolerance": (0.1, 0.03),
		"time-step fraction": (0.55,),
		"transfer": ("tpic",),
		"bulk modulus of water": (5e6,),
		"thermal time scale": (1.728e6,),
	},
	pairs=(("grid spacing", "grains"), ("grains", "tolerance"), ("inertial number", "sample tolerance")),
	togetherInFull=(
		{"sample tolerance": 0.0},
		{"bulk modulus of water": 2.2e8, "thermal time scale": 2.16e5},
		*(
			{"grid spacing": spacing, "grains": grains, "tolerance": tolerance}
			for spacing, grains, tolerance in (
				(0.25, 200, 0.1),
				(0.25, 200, 0.03),
				(0.25, 400, 0.03),
				(0.2, 400, 0.1),
			)
		),
	),
	run=run,
	error=largestRelative,
	finest={"grid spacing": 0.2, "grains": 400, "tolerance": 0.03},
	quickFinest={"tolerance": 0.01},
)
