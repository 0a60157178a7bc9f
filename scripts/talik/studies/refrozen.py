# SPDX-License-Identifier: GPL-2.0-or-later
"""What thaw and refreezing make of the strength of a frozen sample: biaxial compression after different histories.

	scripts/calibrate --refrozen              # table and picture

Every sample freezes under an isotropic pressure to full ice saturation. It thaws in parts while its stress is held, without water pressure, freezes again
under the stress that it has, and is compressed under the isotropic pressure.
"""

import dataclasses

import numpy as np

from talik import plots, rve
from talik.studies import calibrate

steps = 10  # in which ice melts, the stress is restored after each


@dataclasses.dataclass(frozen=True)
class Past:
	"""What a frozen sample went through before it was tested.

	>>> talik.studies.refrozen.pasts["never thawed"].cycles
	0"""

	cycles: int = 0  # of thaw and refreezing
	deviator: float = 0.0  # of the stress under which it thaws and freezes, over the pressure [-]; axial above lateral
	failed: float = 0.0  # axial strain of a compression before the first thaw [-]
	thawStrain: float = 0.0  # RveSample.thawStrain: area strain that grains release on complete thaw [-]


pasts = {
	"never thawed": Past(),
	"one cycle under isotropic stress": Past(1),
	"three cycles under isotropic stress": Past(3),
	"one cycle under a deviator": Past(1, 0.5),
	"three cycles under a deviator": Past(3, 0.5),
	"one cycle, grains shrink by 2 %": Past(1, thawStrain=0.02),
	"failed": Past(0, 0.0, 0.03),
	"failed, one cycle": Past(1, 0.0, 0.03),
}


@dataclasses.dataclass(frozen=True)
class Outcome:
	"""Of one sample: its compression, and the axial and areal strain [-] that the cycles left, shortening positive.

	>>> outcome = talik.studies.refrozen.test(packed, talik.studies.refrozen.Past(1), strain=5e-4)
	>>> bool(outcome.compression.bonds > 0)
	True"""

	compression: object  # talik.studies.calibrate.BiaxialTest
	settled: float
	contracted: float


def test(sample, past, pressure=100e3, strain=0.03, perCall=2e-5):
	"""Compression of an ice-free RveSample of discs, frozen at a pressure [Pa], after a Past: Outcome.

	>>> strength = talik.studies.refrozen.test(packed, talik.studies.refrozen.Past(), strain=5e-4).compression.deviator.max()"""
	tested = sample.copy()
	tested.thawStrain = past.thawStrain
	_hold(tested, pressure)
	tested.freeze(1)
	if past.failed:
		calibrate.drive(tested, 1.0, pressure, past.failed, perCall)
	before = _sides(tested)
	for _ in range(past.cycles):
		_hold(tested, pressure, past.deviator)
		for part in range(steps - 1, -1, -1):
			tested.freeze(part / steps)
			_hold(tested, pressure, past.deviator)
		tested.freeze(1)
	after = _sides(tested)
	if past.cycles or past.failed:
		_hold(tested, pressure)
	return Outcome(calibrate.drive(tested, 1.0, pressure, strain, perCall), float(np.log(before[1] / after[1])), float(np.log(before.prod() / after.prod())))


def _hold(sample, pressure, deviator=0.0):
	if not sample.servo(-pressure, -pressure * (1 + deviator)):
		raise RuntimeError(f"refrozen: the sample does not reach {pressure:g} Pa, {pressure * (1 + deviator):g} Pa along its axis; choose less or more grains")


def _sides(sample):
	return np.linalg.norm(np.asarray(sample.arrays()["hSize"]), axis=0)


# ---- table and picture ----------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Comparison:
	"""Outcomes by the past, a list of realisations for each.

	>>> talik.studies.refrozen.Comparison(100e3, {}).pressure
	100000.0"""

	pressure: float  # [Pa]
	outcomes: dict

	def strengths(self, past):
		"""Largest deviators [Pa], an array over the realisations.

		>>> found = talik.studies.refrozen.compare(30, 1, strain=5e-4, which=("never thawed",), told=lambda line: None, porosity=0.19)
		>>> len(found.strengths("never thawed"))
		1"""
		return np.array([outcome.compression.deviator.max() for outcome in self.outcomes[past]])

	def ratios(self, past):
		"""Strength over that of the same samples when they were never thawed [-].

		>>> found = talik.studies.refrozen.compare(30, 1, strain=5e-4, which=("never thawed",), told=lambda line: None, porosity=0.19)
		>>> float(found.ratios("never thawed")[0])
		1.0"""
		return self.strengths(past) / self.strengths("never thawed")

	def draw(self):
		"""Figure: mean deviator over axial strain, a line for each past, and strengths over that of the sample that never thawed."""
		fig = plots.figure(10, 4.6)
		curves, bars = fig.subplots(1, 2, width_ratios=(1.2, 1))
		for place, (past, outcomes) in enumerate(self.outcomes.items()):
			tests = [outcome.compression for outcome in outcomes]
			line = curves.plot(100 * tests[0].smooth(tests[0].strain), 1e-6 * np.mean([test.deviator for test in tests], axis=0), linewidth=1)[0]
			ratios = self.ratios(past)
			bars.barh(place, ratios.mean(), xerr=ratios.std(), color=line.get_color(), height=0.6, capsize=2)
		curves.set(xlabel="axial strain [%]", ylabel=f"deviator at {1e-3 * self.pressure:g} kPa [MPa]", ylim=(0, None))
		bars.set_yticks(range(len(self.outcomes)), list(self.outcomes), fontsize=8)
		bars.invert_yaxis()
		bars.axvline(1, color="0.4", linewidth=0.8)
		bars.set(xlabel="strength over never thawed [-]")
		return fig


def _row(past, outcomes, ratios):
	strengths = 1e-6 * np.array([outcome.compression.deviator.max() for outcome in outcomes])
	young = np.mean([1e-6 * outcome.compression.elasticity()[0] for outcome in outcomes])
	settled, contracted = (100 * np.mean([getattr(outcome, name) for outcome in outcomes]).round(4) + 0.0 for name in ("settled", "contracted"))
	return (
		f"| {past} | {strengths.mean():.2f} ± {strengths.std():.2f} | {ratios.mean():.2f} ± {ratios.std():.2f} | {young:.0f} | "
		f"{settled:.2f} | {contracted:.2f} |"
	)


def compare(grains=100, realisations=8, pressure=100e3, strain=0.03, which=tuple(pasts), told=print, porosity=0.18, **prepared):
	"""Compressions of samples after every one of `which` of the `pasts`, "never thawed" first. `told` is given each line of the table as soon as it is
	known.

	>>> lines = []
	>>> found = talik.studies.refrozen.compare(30, 1, strain=5e-4, which=("never thawed",), told=lines.append, porosity=0.19)
	>>> len(lines)
	2"""
	told("| past | strength [MPa] | over never thawed | E [MPa] | settled [%] | contracted [%] |\n|---|---|---|---|---|---|")
	samples = rve.listOf(rve.pack(rve.prepare(grains=grains, porosity=porosity, pressure=pressure, ice=True, realisations=realisations, **prepared)))
	found = Comparison(pressure, {})
	for past in ("never thawed", *(past for past in which if past != "never thawed")):
		found.outcomes[past] = [test(sample, pasts[past], pressure, strain) for sample in samples]
		told(_row(past, found.outcomes[past], found.ratios(past)))
	return found
