# SPDX-License-Identifier: GPL-2.0-or-later
"""Thaw settlement tests in CSV files: a prediction fitted to them, and how far it is off on tests that it was not fitted to.

	tests = talik.studies.thawtests.read("tests.csv", "steps.csv")
	fitted = talik.studies.thawtests.fit([test for test in tests if test.group == "fine"])
	scripts/calibrate --settlement tests.csv,steps.csv        # the same as a command, with cross validation: table, picture

The files have the form of the Permafrost Thaw Settlement Dataset (Mohammadi & Hayley, Zenodo 14538524; Earth Syst. Sci. Data 17, 3921, 2025):
one line a test in the first, one line a load step in the second. In a test a frozen sample thaws under a load and is loaded on in steps. Its
strain is that of the height frozen. talik.soils has the numbers that were fitted to that dataset.
"""

import csv
import dataclasses
import math

import numpy as np

from talik import plots

groups = {"Coarse-grained": "coarse", "Fine-grained": "fine", "Peat": "peat"}  # of the dataset, and their names here
ofTests = (
	"test_id",
	"borehole",
	"top",
	"bottom",
	"soil_group",
	"gravimetric_wc_init",
	"solid_grain_density_rpt_or_asm",
	"frozen_bulk_density_rep",
	"data_quality_flag",
)
fewestSteps = 3  # of a test that counts
gravity = 9.81  # [m/s^2]
# Root mean square difference of the best empirical method over the tests of the dataset (its paper, Table 6) [% of strain]
bestOfPaper = {"coarse": 11.75, "fine": 8.78}
lightest = 1150.0  # frozen density from which on the method of Nixon & Ladanyi gives a strain [kg/m^3]


@dataclasses.dataclass(frozen=True)
class ThawTest:
	"""One test of frozen soil, in SI units; strains positive in shortening.

	>>> test = talik.studies.thawtests.ThawTest("A", "hole", "fine", 2.0, 1500.0, 0.6, 2700.0, np.array([1e4, 1e5]), np.array([0.2, 0.3]))
	>>> round(test.at(1e6), 3)
	0.4"""

	name: str
	borehole: str
	group: str  # coarse, fine or peat
	depth: float  # [m]
	density: float  # bulk, frozen [kg/m^3]
	waterContent: float  # mass of water and ice over that of the grains [-]
	grainDensity: float  # [kg/m^3]
	stress: np.ndarray  # of each load step, vertical and effective [Pa]
	strain: np.ndarray  # since it was frozen [-]

	@property
	def overburden(self):
		"""Weight above it, if all ground there is as dense, at least 1 kPa [Pa]."""
		return max(1e3, self.density * gravity * self.depth)

	def at(self, stress):
		"""Strain at a stress [Pa] by the line through the load steps over the logarithm of stress [-]."""
		slope, start = np.polyfit(np.log10(self.stress / 1e3), self.strain, 1)
		return float(start + slope * math.log10(stress / 1e3))


def read(tests, steps):
	"""Tests of two CSV files, in the order of the first: [ThawTest].

	tests  file with the columns of the dataset (see ofTests); others are passed over
	steps  file with test_id (or unique_id), sigma_v [kPa] and strain [%]

	Left out are tests that the dataset marks as faulty (data_quality_flag 0), without soil group, density or water content, or with fewer than three
	load steps. ValueError names file, line and fault.

	>>> with open(folder + "/tests.csv", "w") as file:
	...     written = file.write(",".join(talik.studies.thawtests.ofTests) + "\\nA,hole,1,3,Fine-grained,60,2.7,1500,2\\n")
	>>> with open(folder + "/steps.csv", "w") as file:
	...     written = file.write("test_id,sigma_v,strain\\nA,10,20\\nA,50,27\\nA,100,30\\n")
	>>> talik.studies.thawtests.read(folder + "/tests.csv", folder + "/steps.csv")[0].overburden
	29430.0"""
	loads = {}
	for line, row in _rows(steps, (("test_id", "unique_id"), "sigma_v", "strain")):
		stress, strain = (_number(steps, line, row, column) for column in ("sigma_v", "strain"))
		if math.isnan(stress) or math.isnan(strain):
			continue
		if not 0 < stress < 1e5:
			raise ValueError(f"{steps}, line {line}, column sigma_v: {stress:g} must be a vertical stress above 0 in kPa")
		if not -100 < strain < 100:
			raise ValueError(f"{steps}, line {line}, column strain: {strain:g} must be a strain in %, between -100 and 100")
		loads.setdefault(row.get("test_id") or row.get("unique_id"), []).append((1e3 * stress, 1e-2 * strain))
	found = []
	for line, row in _rows(tests, ofTests):
		numbers = [_number(tests, line, row, column) for column in ofTests if column not in ("test_id", "borehole", "soil_group")]
		top, bottom, water, grains, density, flag = numbers
		stepsOfTest = loads.get(row["test_id"], [])
		if flag == 0 or row["soil_group"] not in groups or len(stepsOfTest) < fewestSteps or not np.isfinite(numbers[:5]).all():
			continue
		if not (100 < density < 3000 and 0.5 < grains < 5 and 0 < water):
			raise ValueError(
				f"{tests}, line {line}: frozen density {density:g} kg/m^3, grain density {grains:g} Mg/m^3, water content {water:g} %: one of them is no such "
				"number; look at the unit"
			)
		stress, strain = np.array(sorted(stepsOfTest)).T
		place = (row["test_id"], row["borehole"], groups[row["soil_group"]], 0.5 * (top + bottom))
		found.append(ThawTest(*place, density, 1e-2 * water, 1e3 * grains, stress, strain))
	if not found:
		raise ValueError(f"{tests} and {steps} hold no test with soil group, density, water content and {fewestSteps} load steps")
	return found


def _rows(path, wanted):
	with open(path, newline="", encoding="utf-8-sig") as file:
		reader = csv.DictReader(file)
		for column in wanted:
			if not any(name in (reader.fieldnames or ()) for name in ([column] if isinstance(column, str) else column)):
				raise ValueError(f"{path} has no column {column if isinstance(column, str) else ' or '.join(column)}")
		for row in reader:
			yield reader.line_num, row


def _number(path, line, row, column):
	text = (row[column] or "").strip()
	if text in ("", "NA"):
		return math.nan
	try:
		return float(text)
	except ValueError:
		raise ValueError(f"{path}, line {line}, column {column}: '{text}' is no number") from None


# ---- prediction ------------------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Fitted:
	"""Strain of a soil group by its index, the frozen bulk density over 1000 kg/m^3 or, for peat, the natural logarithm of the water content:
	constant + ofIndex * index + perDecade * log10(stress/1 kPa), all [-].

	>>> fitted = talik.studies.thawtests.Fitted("fine", 1.0, -0.5, 0.1)
	>>> round(fitted.strain(1.6, 10e3), 3)
	0.3"""

	group: str
	constant: float
	ofIndex: float
	perDecade: float

	def strain(self, index, stress):
		"""At an index and a stress, or an array of stresses [Pa]."""
		return self.constant + self.ofIndex * index + self.perDecade * np.log10(np.asarray(stress) / 1e3)


def indexOf(group, density, waterContent):
	"""By which the strain of a soil group is predicted: frozen bulk density [Mg/m^3], of peat the logarithm of its water content.

	>>> talik.studies.thawtests.indexOf("fine", 1500.0, 0.6)
	1.5"""
	return math.log(waterContent) if group == "peat" else 1e-3 * density


def fit(tests):
	"""Least squares over the load steps of tests of one group, in which all tests have the same weight: Fitted.

	>>> def test(density):
	...     strain = 1.0 - 0.4e-3 * density + 0.1 * np.array([0, 1, 2])
	...     return talik.studies.thawtests.ThawTest("A", "hole", "fine", 2.0, density, 0.6, 2700.0, np.array([1e3, 1e4, 1e5]), strain)
	>>> fitted = talik.studies.thawtests.fit([test(1400.0), test(1700.0)])
	>>> round(fitted.ofIndex, 6), round(fitted.perDecade, 6)
	(-0.4, 0.1)"""
	rows, wanted = [], []
	for test in tests:
		weight = 1 / math.sqrt(len(test.stress))
		for stress, strain in zip(test.stress, test.strain):
			rows.append([weight, weight * indexOf(test.group, test.density, test.waterContent), weight * math.log10(stress / 1e3)])
			wanted.append(weight * strain)
	return Fitted(tests[0].group, *np.linalg.lstsq(np.array(rows), np.array(wanted), rcond=None)[0].tolist())


def nixonLadanyi(density):
	"""Thaw strain [-] by the frozen bulk density [kg/m^3] alone, 0.9 - 0.868 sqrt(density/1000 - 1.15): Nixon & Ladanyi 1978, the best of six
	empirical methods in the paper of the dataset; nan below 1150 kg/m^3.

	>>> round(talik.studies.thawtests.nixonLadanyi(1500.0), 3)
	0.386"""
	return 0.9 - 0.868 * math.sqrt(1e-3 * density - 1.15) if density >= lightest else math.nan


@dataclasses.dataclass(frozen=True)
class HeldOut:
	"""A test and what was predicted for it by tests of other boreholes; strains [-].

	>>> test = talik.studies.thawtests.ThawTest("A", "hole", "fine", 2.0, 1500.0, 0.6, 2700.0, np.array([1e3, 1e4, 1e5]), np.array([0.2, 0.3, 0.4]))
	>>> round(talik.studies.thawtests.HeldOut(test, talik.studies.thawtests.Fitted("fine", 0.2, 0, 0.1)).ofSteps, 9)
	0.0"""

	test: ThawTest
	fitted: Fitted

	def predicted(self, stress):
		"""Strain of the soil of the test at a stress, or an array of them [Pa]."""
		return self.fitted.strain(indexOf(self.test.group, self.test.density, self.test.waterContent), stress)

	@property
	def ofSteps(self):
		"""Mean square difference over the load steps."""
		return float(np.mean((self.predicted(self.test.stress) - self.test.strain) ** 2))

	@property
	def underOverburden(self):
		"""Difference at the stress that the sample had in the ground, as in the paper of the dataset."""
		return float(self.predicted(self.test.overburden)) - self.test.at(self.test.overburden)

	@property
	def line(self):
		"""(at 1 kPa, a decade) of measured less predicted strain, by the line through the load steps."""
		slope, start = np.polyfit(np.log10(self.test.stress / 1e3), self.test.strain - self.predicted(self.test.stress), 1)
		return float(start), float(slope)


def crossValidate(tests):
	"""Predicts the tests of each borehole by those of all others of the group: [HeldOut] in the order of tests.

	ValueError if a group has tests of one borehole only.

	>>> def test(hole, density):
	...     strain = 1.0 - 0.4e-3 * density + 0.1 * np.array([0, 1, 2])
	...     return talik.studies.thawtests.ThawTest("A", hole, "fine", 2.0, density, 0.6, 2700.0, np.array([1e3, 1e4, 1e5]), strain)
	>>> tests = [test(hole, 1300.0 + 50 * k) for k, hole in enumerate("abcabc")]
	>>> abs(round(talik.studies.thawtests.crossValidate(tests)[0].underOverburden, 9))
	0.0"""
	held = []
	for test in tests:
		others = [other for other in tests if other.group == test.group and other.borehole != test.borehole]
		if len(others) < fewestSteps:
			raise ValueError(f"cross validation: soil group {test.group} has {len(others)} tests outside of borehole {test.borehole}; it needs {fewestSteps}")
		held.append(HeldOut(test, fit(others)))
	return held


def rootMeanSquare(values):
	"""Of an array.

	>>> talik.studies.thawtests.rootMeanSquare([3.0, 4.0, 5.0, 0.0, 0.0, 0.0])
	2.886751345948129"""
	return math.sqrt(float(np.mean(np.square(values))))


def report(tests, told=print):
	"""Fits and cross-validates each group, tells the table line by line and returns {group: [HeldOut]}.

	>>> def test(hole, density):
	...     strain = 1.0 - 0.4e-3 * density + 0.1 * np.array([0, 1, 2])
	...     return talik.studies.thawtests.ThawTest("A", hole, "fine", 2.0, density, 0.6, 2700.0, np.array([1e3, 1e4, 1e5]), strain)
	>>> tests = [test(hole, 1300.0 + 50 * k) for k, hole in enumerate("abcabc")]
	>>> len(talik.studies.thawtests.report(tests, told=lambda line: None)["fine"])
	6"""
	found = {}
	told(
		"| soil | tests | boreholes | at the load steps | under the overburden | the same from 1150 kg/m³ on | Nixon & Ladanyi there | best method of the paper |"
	)
	told("|---|---|---|---|---|---|---|---|")
	fits = []
	for group in groups.values():
		ofGroup = [test for test in tests if test.group == group]
		if not ofGroup:
			continue
		held = found[group] = crossValidate(ofGroup)
		fits.append(fit(ofGroup))
		dense = [one for one in held if one.test.density >= lightest]
		steps = math.sqrt(np.mean([one.ofSteps for one in held]))
		overburden = [rootMeanSquare([one.underOverburden for one in some]) if some else math.nan for some in (held, dense)]
		classical = [nixonLadanyi(one.test.density) - one.test.at(one.test.overburden) for one in dense]
		numbers = [steps, *overburden, rootMeanSquare(classical) if classical else math.nan]
		cells = ["" if math.isnan(number) else f"{100 * number:.2f} %" for number in numbers] + [f"{bestOfPaper[group]:.2f} %" if group in bestOfPaper else ""]
		told(f"| {group} | {len(held)} | {len({test.borehole for test in ofGroup})} | " + " | ".join(cells) + " |")
	told("\nRoot mean square difference of strain on tests of boreholes that were not used to fit. Fitted to all of them, strain [%]:\n")
	for one in fits:
		index = "ln(water content)" if one.group == "peat" else "frozen density [Mg/m³]"
		line = np.array([held.line for held in found[one.group]])
		told(
			f"- {one.group}: {100 * one.constant:.2f} {100 * one.ofIndex:+.2f} × {index} {100 * one.perDecade:+.2f} × log10(stress/kPa); spread of held-out "
			f"tests: {100 * line[:, 0].std():.2f} at 1 kPa, {100 * line[:, 1].std():.2f} a decade, correlation {np.corrcoef(line.T)[0, 1]:.2f}"
		)
	return found


def draw(found):
	"""Prediction against test at the load steps, a panel for each group of a report: matplotlib figure.

	found  {group: [HeldOut]}, of report

	>>> def test(hole, density):
	...     strain = 1.0 - 0.4e-3 * density + 0.1 * np.array([0, 1, 2])
	...     return talik.studies.thawtests.ThawTest("A", hole, "fine", 2.0, density, 0.6, 2700.0, np.array([1e3, 1e4, 1e5]), strain)
	>>> tests = [test(hole, 1300.0 + 50 * k) for k, hole in enumerate("abcabc")]
	>>> figure = talik.studies.thawtests.draw(talik.studies.thawtests.report(tests, told=lambda line: None))"""
	figure = plots.figure(3.4 * len(found), 3.6)
	panels = np.atleast_1d(figure.subplots(1, len(found)))
	for axes, (group, held) in zip(panels, found.items()):
		measured = np.concatenate([100 * one.test.strain for one in held])
		predicted = np.concatenate([100 * one.predicted(one.test.stress) for one in held])
		stress = np.concatenate([1e-3 * one.test.stress for one in held])
		shown = axes.scatter(measured, predicted, c=np.log10(stress), s=6, cmap="viridis", vmin=0, vmax=2.2, linewidths=0)
		low, high = min(measured.min(), predicted.min()) - 2, max(measured.max(), predicted.max()) + 2
		axes.plot([low, high], [low, high], color="black", linewidth=0.8)
		off = 100 * math.sqrt(np.mean([one.ofSteps for one in held]))
		axes.fill_between([low, high], [low - off, high - off], [low + off, high + off], color="grey", alpha=0.2, linewidth=0)
		axes.set(xlim=(low, high), ylim=(low, high), aspect="equal", xlabel="strain measured [%]", title=f"{group}: {len(held)} tests, ±{off:.1f} %")
	panels[0].set_ylabel("strain predicted from other boreholes [%]")
	bar = figure.colorbar(shown, ax=list(panels), shrink=0.8, label="vertical stress [kPa]", ticks=[0, 1, 2])
	bar.ax.set_yticklabels(["1", "10", "100"])
	return figure
