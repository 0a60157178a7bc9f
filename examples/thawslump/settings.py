# SPDX-License-Identifier: GPL-2.0-or-later
"""What a thaw slump can be told: size of the job, ground, and the values that both cases share."""

import math
from dataclasses import dataclass, field


@dataclass
class Preset:
	"""Size of a job."""

	gridSpacing: float  # [m], with one point a cell; the paper has 0.2 with four
	grains: int  # in each sample; the paper's is 400
	days: float  # of thaw
	strainTolerance: float = 2e-5  # of a point, before its sample is updated [-]
	stressTolerance: float = 0.05  # relative error of stress to which that tolerance is steered [-]
	maxInertialNumber: float = 5e-3  # of the motion of its grains [-]
	bandThickness: float = 0.5  # of samples at the same initial stress [m]
	restTime: float = 0.6  # longest time to come to rest before the thaw [s]
	realisations: int = 1  # of the sample, assigned to the points at random
	seed: int = 1  # of the samples and of that chance
	gridOffset: float = 0.0  # of the nodes against the slope, to the left [cells], 0 to below 1; the ground reaches as far as the grid
	longestMotion: float = math.inf  # of the thaw [s]: a run whose ground never rests ends here
	lawGridSpacing: float = None  # with the calibrated law alone, which is cheap enough for a finer grid [m]; None: gridSpacing
	calibration: dict = field(default_factory=dict)  # arguments of talik.studies.calibrate.calibrate, for MohrCoulombSkeleton


skeletons = ("samples", "MohrCoulomb")
calendars = ("follows-motion", "constant")
porePressures = ("implicit", "explicit")
# of Ground with the law alone, of samples 0.1 m thick: five times as stiff as thawed ground is enough, at half the steps; that of water if explicit
softened = dict(bulkModulus=5.5e6, frozenModulus=2e7)
flowingPicTimeFactor = 4.0  # Ground.picTimeFactor of runs whose path is to depend on no setting
oneGrainThick = 0.01  # mean diameter of the discs [m]
fullThawStrain = "full"  # all of eq. (8): the porosity of the sample

presets = {
	"test": Preset(
		gridSpacing=0.5,
		grains=60,
		days=6.0,
		strainTolerance=5e-5,
		bandThickness=1.0,
		restTime=0.2,
		calibration=dict(iceSaturations=(0.0, 0.5, 1.0), pressures=(10e3, 50e3)),
	),
	# samples that are updated less often and move faster pay for the finer grid, which counts for more
	"draft": Preset(gridSpacing=0.25, grains=100, days=150.0, strainTolerance=2e-4, stressTolerance=0.1, maxInertialNumber=2e-2, lawGridSpacing=1 / 6),
	"standard": Preset(gridSpacing=0.25, grains=200, days=150.0, lawGridSpacing=0.125),
	"paper": Preset(gridSpacing=0.2, grains=400, days=150.0),
}


def widened(outline, gridSpacing, offset):
	"""Corners of a slope [m] whose grid begins `offset` cells further left and ends where a cell does: flat ground on both sides becomes as much longer."""
	if not offset:
		return outline
	left, right = min(x for x, _ in outline), max(x for x, _ in outline)
	longer = {left: left - offset * gridSpacing, right: right + (1 - offset) * gridSpacing}
	return [(longer.get(x, x), y) for x, y in outline]


@dataclass
class Ground:
	"""Settings of the ground; (P) the paper's, (O) ours where it is silent."""

	temperature: float = -5.0  # initial [degC] (P)
	warm: float = 10.0  # [degC] (P)
	porosity: float = 0.4  # (P)
	conductivity: float = 1e-4  # k [m/s] (P)
	thermalTimeScale: float = 8.64e5  # f_T, one second is ten days of heat (P)
	followsMotion: bool = False  # the scale of slow time falls to movingTimeScale while the ground moves (O); False: constant (P)
	movingTimeScale: float = 1.0  # f_m, while it moves (O)
	motionTolerance: float = 0.05  # speed at which the scale lies half way [m/s] (O)
	porePressure: str = "implicit"  # solved for all cells at once, at the step of the skeleton; explicit: the water limits the step (O)
	bulkModulus: float = math.nan  # K_w [Pa]; nan: 2.2e9 if implicit, else a numerical one of 2.2e7 (O); see skemptonB in the summary
	frozenModulus: float = math.inf  # Young's modulus of frozen ground is at most this, with the law alone [Pa] (O)
	freezingWidth: float = 0.5  # W of the gauss freezing curve [K] (O)
	residualSaturation: float = 0.05  # S_r (O)
	zetaActive: bool = True  # melting contracts; the gap behind the front keeps thawed ground drained (O)
	lateralRatio: float = 0.7  # horizontal over vertical stress at rest (O)
	thawStrain: float = 0.0  # area strain that thawing grains release [-], or fullThawStrain; 0: bookkeeping of grain size, eq. (8) (O)
	thickness: float = 0.1  # of the slice of ground that carries the forces of the discs [m]; stiffness and strength go with its inverse (O)
	thawedCohesion: float = 0.0  # cohesion that stays when the ice has gone [Pa], C_0 of eq. (5); 0: none, and a slope without a length of its own (O)
	damping: float = 0.02  # local damping during failure (O)
	picTimeFactor: float = 1.0  # points keep what the grid does not see for so many times sqrt(h/g) during failure (O); 1: MpmEngine's default
	restDamping: float = 0.7  # local damping while the slope comes to rest (O)

	def picTime(self, gridSpacing):
		"""MpmEngine.picTime [s] during failure. A shorter one is a viscosity that holds thin slides back."""
		return self.picTimeFactor * math.sqrt(gridSpacing / 9.81)
