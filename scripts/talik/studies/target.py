# SPDX-License-Identifier: GPL-2.0-or-later
"""A sample calibrated to tests of a soil: a target in a CSV file, bond strength, stiffness, friction, rolling friction and thickness by SciPy;
where bonds carry moments their radius and share in the strength, too.

	rows = talik.studies.target.read("soil.csv")
	found = talik.studies.target.fit(rows, grains=100)
	sample = found.sample()
	several = talik.rve.prepare(**found.parameters(), realisations=8)
	scripts/calibrate --target soil.csv       # the same as a command: table, picture, sample file

A row of the target is one test: S_i, temperature, rate, confinement, and what was measured, E, strength, tension, phi; cells may be empty.
Contact modulus, bond moduli and bond strengths divided by the thickness of discs are all that a sample's stress depends on, so that the
contact modulus stays as it is and the thickness carries the scale. A sample of another thickness is tested as the same sample under
pressures times the ratio of both.
"""

import dataclasses
import math
import re

import numpy as np
import talik
from talik import packing, plots, rve, tables
from talik.studies import calibrate
from yade import O, wrapper

units = {
	"-": 1.0,
	"degC": 1.0,
	"°C": 1.0,
	"1/s": 1.0,
	"deg": 1.0,
	"°": 1.0,
	"Pa": 1.0,
	"kPa": 1e3,
	"MPa": 1e6,
	"GPa": 1e9,
}
stresses = ("Pa", "kPa", "MPa", "GPa")


@dataclasses.dataclass(frozen=True)
class Column:
	"""What a column of a target may hold, in SI units.

	>>> talik.studies.target.columns["S_i"].largest
	1.0"""

	units: tuple
	least: float
	largest: float
	remedy: str


columns = {
	"S_i": Column(("-",), 0.0, 1.0, "an ice saturation from 0 to 1"),
	"temperature": Column(("degC", "°C"), -100.0, 60.0, "degC, from -100 to 60"),
	"rate": Column(("1/s",), 1e-12, 1e3, "a strain rate above 0 in 1/s"),
	"confinement": Column(stresses, 0.0, 1e8, "a pressure, 0 to 100 MPa"),
	"E": Column(stresses, 1e5, 1e11, "a stiffness of 0.1 MPa to 100 GPa"),
	"strength": Column(stresses, 1e3, 1e9, "the largest axial less lateral stress, 1 kPa to 1 GPa"),
	"tension": Column(stresses, 1e2, 1e8, "a tensile strength, positive, 0.1 kPa to 100 MPa"),
	"phi": Column(("deg", "°"), 2.0, 60.0, "degrees, 2 to 60"),
}
conditions, quantities = tuple(columns)[:4], tuple(columns)[4:]


@dataclasses.dataclass(frozen=True)
class Row:
	"""One test of a soil, in SI units; NaN: not measured.

	>>> talik.studies.target.Row(line=2, iceSaturation=1, temperature=-10, rate=1e-4, confinement=0, wanted={"tension": 2e6}).wanted["tension"]
	2000000.0"""

	line: int  # of the file
	iceSaturation: float
	temperature: float  # [degC]
	rate: float  # [1/s]
	confinement: float  # [Pa]
	wanted: dict  # {quantity: value}: E, strength, tension [Pa], phi [deg]

	def __str__(self):
		if self.iceSaturation == 0:
			return f"thawed, {1e-3 * self.confinement:g} kPa"
		return f"S_i = {self.iceSaturation:g}, {self.temperature:g} °C, {self.rate:.1e} 1/s, {1e-3 * self.confinement:g} kPa"


def read(path):
	"""Rows of a target in a CSV file, a list of Row.

	path  file whose first line names the columns with their units, in any order: S_i [-], temperature [degC], rate [1/s], confinement [kPa],
		  E [MPa], strength [MPa], tension [MPa], phi [deg]; stresses in Pa, kPa, MPa or GPa. Further columns, empty lines and lines that begin
		  with # are passed over. Cells of what was not measured are empty; ground without ice needs no temperature and no rate

	ValueError names file, line, column and fault.

	>>> with open(folder + "/soil.csv", "w") as file:
	...     head = "S_i [-],temperature [degC],rate [1/s],confinement [kPa],E [MPa],strength [MPa],tension [MPa],phi [deg]"
	...     written = file.write(head + "\\n1,-10,1e-4,0,1500,10,2,\\n0,,,100,50,,,36\\n")
	>>> [row.wanted for row in talik.studies.target.read(folder + "/soil.csv")]
	[{'E': 1500000000.0, 'strength': 10000000.0, 'tension': 2000000.0}, {'E': 50000000.0, 'phi': 36.0}]"""
	lines = [(line, cells) for line, cells in tables.lines(path) if any(cell.strip() for cell in cells)]
	if not lines:
		raise ValueError(f"{path} holds no data; its first line names the columns: {', '.join(columns)}, each with its unit")
	places = _placesOf(path, *lines[0])
	width = len(lines[0][1])
	for line, cells in lines[1:]:
		if any(cell.strip() for cell in cells[width:]):
			raise ValueError(f"{path}, line {line}, column {width + 1}: '{cells[width].strip()}' has no heading; numbers have a decimal point, not a comma")
	rows = [_rowOf(path, line, cells, places) for line, cells in lines[1:]]
	if not rows:
		raise ValueError(f"{path} has no row below its headings; give a test in each line")
	return rows


def _placesOf(path, line, headings):
	"""{column: (place in a line, factor to SI units)}."""
	places = {}
	for place, heading in enumerate(headings):
		name, unit = re.fullmatch(r"\s*(.*?)\s*(?:\[\s*(.*?)\s*\])?\s*", heading).groups()
		if name not in columns:
			continue
		allowed = columns[name].units
		if unit not in allowed:
			said = "no unit" if unit is None else f"the unit '{unit}'"
			raise ValueError(f"{path}, line {line}, column {name}: it has {said}; write {name} [{'] or ['.join(allowed)}]")
		if name in places:
			raise ValueError(f"{path}, line {line}, column {name}: it is there twice; leave one out")
		places[name] = place, units[unit]
	for name in columns:
		if name not in places:
			raise ValueError(f"{path}, line {line}: the column {name} is missing; add {name} [{columns[name].units[0]}], its cells may be empty")
	return places


def _rowOf(path, line, cells, places):
	def refuse(name, fault):
		raise ValueError(f"{path}, line {line}, column {name}: {fault}")

	values = {}
	for name, (place, factor) in places.items():
		cell = cells[place].strip() if place < len(cells) else ""
		if not cell:
			continue
		try:
			value = float(cell) * factor
		except ValueError:
			value = math.nan
		column = columns[name]
		if not column.least <= value <= column.largest:
			refuse(name, f"'{cell}' must be {column.remedy}; look at the unit in the heading, too")
		values[name] = value
	for name in ("S_i", "confinement"):
		if name not in values:
			refuse(name, f"the cell is empty; give {columns[name].remedy}")
	wanted = {name: values[name] for name in quantities if name in values}
	if not wanted:
		refuse("E", f"nothing was measured in this row; give one of {', '.join(quantities)} or remove the row")
	if values["S_i"] > 0:
		for name in ("temperature", "rate"):
			if name not in values:
				refuse(name, f"the cell is empty; frozen ground needs {columns[name].remedy}")
		if values["temperature"] > 0:
			refuse("temperature", f"{values['temperature']:g} degC with ice (S_i = {values['S_i']:g}); give 0 or less")
		if "phi" in wanted:
			refuse("phi", "the friction angle is that of ground without ice; give strength at two confinements instead")
	else:
		if "tension" in wanted:
			refuse("tension", "grains without ice carry none; leave the cell empty")
		if values["confinement"] < 1e3:
			refuse("confinement", f"{values['confinement']:g} Pa; grains without ice need 1 kPa or more")
	return Row(line, values["S_i"], values.get("temperature", math.nan), values.get("rate", math.nan), values["confinement"], wanted)


# ---- tests of a sample ----------------------------------------------------------------------------------------------------

usualPressure, usualThickness = 100e3, 0.1  # of talik.rve.prepare [Pa], [m]
leastPressure = 1e3  # at which a sample that is not confined freezes [Pa]


@dataclasses.dataclass(frozen=True)
class Range:
	"""Of a parameter that is fitted.

	>>> talik.studies.target.ranges["friction"].at(0.0)
	0.2"""

	least: float
	largest: float
	logarithmic: bool = True

	def at(self, part):
		"""The value at a part 0..1 of the range."""
		if self.logarithmic:
			return self.least * (self.largest / self.least) ** part
		return self.least + (self.largest - self.least) * part

	def partOf(self, value):
		"""Where a value lies in the range, 0 (least) to 1 (largest)."""
		if self.logarithmic:
			return math.log(value / self.least) / math.log(self.largest / self.least)
		return (value - self.least) / (self.largest - self.least)


ranges = {
	"thickness": Range(3e-3, 1.0),  # [m]
	"iceYoung": Range(0.1e9, 60e9),  # [Pa]
	"iceTensileStrength": Range(1e6, 1e9),  # [Pa]
	"iceShearStrength": Range(1e6, 1e9),  # [Pa]
	"friction": Range(0.2, 1.0, False),
	"etaRoll": Range(0.01, 0.3, False),
	"bondRadiusFactor": Range(0.5, 2.0),
	"momentContribution": Range(0.0, 1.0, False),
}
ofMoments = ("bondRadiusFactor", "momentContribution")
standard = dict(thickness=0.03, iceYoung=3e9, iceTensileStrength=50e6, iceShearStrength=50e6, friction=0.5, etaRoll=0.05)
standardMoments = dict(bondRadiusFactor=1.0, momentContribution=0.5)
unbentMoments = dict(bondRadiusFactor=1.8, momentContribution=0.01)  # bonds that moments stiffen and do not break


def fitted(rows, moments=False):
	"""Names of the parameters that the rows decide; moments: bonds carry moments.

	>>> talik.studies.target.fitted([talik.studies.target.Row(2, 0.0, 0, 0, 100e3, {"phi": 36.0})])
	['friction', 'etaRoll']"""
	frozen = {name for row in rows if row.iceSaturation > 0 for name in row.wanted}
	thawed = {name for row in rows if row.iceSaturation == 0 for name in row.wanted}
	decided = {
		"thickness": "E" in thawed or frozen,
		"iceYoung": "E" in frozen,
		"iceTensileStrength": frozen & {"strength", "tension"},
		"iceShearStrength": "strength" in frozen,
		"friction": thawed & {"strength", "phi"},
		"etaRoll": thawed & {"strength", "phi"} or moments and "strength" in frozen,
		"bondRadiusFactor": moments and "strength" in frozen,
		"momentContribution": moments and "strength" in frozen,
	}
	return [name for name in ranges if decided[name]]


def altered(sample, friction, etaRoll, **bonds):
	"""A copy of a packed, ice-free sample of RollingIceBondMat or MomentIceBondMat with another contact friction, rolling friction and bonds.

	bonds  attributes of IceBondMat: iceYoung, iceTensileStrength, iceShearStrength [Pa]; of MomentIceBondMat bondRadiusFactor and
		   momentContribution [-]

	>>> rolling = talik.rve.pack(talik.rve.prepare(grains=30, porosity=0.19, ice=True, etaRoll=0.1))
	>>> other = talik.studies.target.altered(rolling, friction=0.6, etaRoll=0.2, iceYoung=5e9)"""
	with talik.inspect(sample.open()) as scene:
		packing.setFriction(friction)
		packing.setRolling(etaRoll)
		for material in O.materials:
			material.updateAttrs(bonds)
		for contact in O.interactions:
			if contact.isReal:
				contact.phys.updateAttrs({name: bonds[name] for name in ofMoments if name in bonds})
		return wrapper.RveSample.fromScene(scene)


@dataclasses.dataclass(frozen=True)
class Measured:
	"""What a sample gives for a row: {quantity: value} and the curves of its tests, each strain [-] and axial less lateral stress [Pa].

	>>> measured = talik.studies.target.Measured({"E": 1e9}, {})"""

	values: dict
	curves: dict


def test(sample, row, thickness=None, law=None, strain=0.04):
	"""Tests of a row on a packed, ice-free sample of discs, as if it had another thickness [m], default its own: Measured.

	law     IceStrength of the bonds over temperature and rate; default its defaults
	strain  axial, of each test [-], 1e-3 or more

	>>> row = talik.studies.target.Row(2, 1.0, -10.0, 1e-4, 100e3, {"strength": 1e6})
	>>> measured = talik.studies.target.test(packed, row, strain=1e-3)"""
	if not strain >= 1e-3:
		raise ValueError(f"strain is {strain!r}; a test needs 1e-3 or more to have a stiffness and a peak")
	scale = 1.0 if thickness is None else sample.thickness / thickness
	tested = sample.copy()
	if row.iceSaturation > 0:
		tested.tensileStrengthFactor, tested.shearStrengthFactor = (law or wrapper.IceStrength()).factors(row.temperature, row.rate)
	values, curves = {}, {}
	if set(row.wanted) & {"E", "strength", "phi"}:
		confinement = row.confinement / scale
		compression = calibrate.biaxialTest(tested, row.iceSaturation, max(confinement, leastPressure), strain, lateral=confinement)
		mean, shear = compression.peak
		values = dict(E=scale * compression.elasticity()[0], strength=scale * 2 * shear)
		if row.iceSaturation == 0:
			values["phi"] = math.degrees(math.asin(min(0.99, shear / mean)))
		curves["compression"] = compression.smooth(compression.strain), scale * compression.deviator
	if "tension" in row.wanted:
		extension = calibrate.extensionTest(tested, row.iceSaturation, leastPressure, strain / 2)
		values["tension"] = scale * extension.tension
		curves["tension"] = extension.smooth(extension.strain), scale * extension.smooth(extension.axial)
	return Measured({name: float(values[name]) for name in row.wanted}, curves)


# ---- fit ------------------------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Candidate:
	"""A sample that was tested: its parameters and, for each row, what it gives.

	>>> candidate = talik.studies.target.Candidate(dict(thickness=0.03), [dict(E=2e9)])"""

	parameters: dict
	values: list  # of {quantity: value}

	def logs(self, rows):
		"""[(quantity, ln(found/target))] over rows and quantities, of friction angles ln of the ratio of tangents."""
		return [(name, _logRatio(name, found[name], wanted)) for row, found in zip(rows, self.values) for name, wanted in row.wanted.items()]

	def misfits(self, rows):
		"""{quantity: factor, 1 or more, by which the sample is off, root of the mean square over the rows}."""
		logs = self.logs(rows)
		return {
			name: math.exp(math.sqrt(np.mean([log**2 for other, log in logs if other == name]))) for name in quantities if any(o == name for o, _ in logs)
		}


def _logRatio(name, found, wanted):
	if name == "phi":
		found, wanted = math.tan(math.radians(found)), math.tan(math.radians(wanted))
	return math.log(max(found, 1e-3 * wanted) / wanted)


@dataclasses.dataclass(frozen=True)
class Fit:
	"""The best candidate, all that were tested, and those of them of which none is better in everything.

	>>> best = talik.studies.target.Candidate(dict(talik.studies.target.standard), [dict(E=2e9)])
	>>> found = talik.studies.target.Fit([talik.studies.target.Row(2, 1.0, -10.0, 1e-4, 0.0, {"E": 1e9})], best, [best], grains=100, porosity=0.18)
	>>> found.best.misfits(found.rows)["E"]
	2.0"""

	rows: list
	best: Candidate
	candidates: list
	grains: int
	porosity: float
	moments: bool = False  # bonds carry moments

	def parameters(self):
		"""Keyword arguments of talik.rve.prepare for further realisations of the best candidate."""
		return dict(self.best.parameters, grains=self.grains, porosity=self.porosity, ice=True)

	def sample(self, cache=True):
		"""The best candidate itself: a packed, ice-free sample of its thickness at 100 kPa."""
		parameters = dict(self.best.parameters)
		thickness = parameters.pop("thickness")
		with talik.inspect(altered(_unfitted(self.grains, self.porosity, cache, self.moments), **parameters).open()) as scene:
			O.tags["thickness"] = repr(float(thickness))
			sample = wrapper.RveSample.fromScene(scene)
		if not sample.servo(-usualPressure, -usualPressure):
			raise RuntimeError(f"the sample of {thickness:g} m does not reach {usualPressure:g} Pa; choose more grains")
		return sample

	def front(self):
		"""Pareto: candidates than which no other is as good in all quantities and better in one."""
		misfits = np.array([list(candidate.misfits(self.rows).values()) for candidate in self.candidates])
		beaten = [np.any(np.all(misfits <= one, axis=1) & np.any(misfits < one, axis=1)) for one in misfits]
		return [candidate for candidate, worse in zip(self.candidates, beaten) if not worse]

	def report(self):
		"""Target and sample row by row, parameters, and for each quantity the sample of the front that meets it best, as a table."""
		lines = ["| test | quantity | target | sample |", "|---|---|---|---|"]
		for row, found in zip(self.rows, self.best.values):
			lines += [f"| {row} | {name} | {_said(name, wanted)} | {_said(name, found[name])} |" for name, wanted in row.wanted.items()]
		lines += ["", "| sample | " + " | ".join(self.best.parameters) + " | off by a factor of |", "|---|" + "---|" * (len(self.best.parameters) + 1)]
		for title, candidate in [("best", self.best)] + [(f"best in {name}", self.bestIn(name)) for name in self.best.misfits(self.rows)]:
			off = ", ".join(f"{name} {factor:.2f}" for name, factor in candidate.misfits(self.rows).items())
			lines.append(f"| {title} | {' | '.join(f'{value:.3g}' for value in candidate.parameters.values())} | {off} |")
		return "\n".join(lines)

	def bestIn(self, quantity):
		"""The candidate of the front that meets a quantity best."""
		return min(self.front(), key=lambda candidate: candidate.misfits(self.rows)[quantity])


def _said(name, value):
	return f"{value:.1f}°" if name == "phi" else f"{1e-6 * value:.3g} MPa"


def fit(rows, grains=100, porosity=0.18, steps=6, strain=0.04, cache=True, law=None, moments=False):
	"""Fit of the parameters that the rows decide (`fitted`) by scipy.optimize.least_squares on ln(found/target): Fit.

	grains, porosity  of the sample (discs)
	steps             of the optimiser from each start, then two towards each quantity alone, for what cannot be met at once, and as many again from
					  the best sample
	strain            axial, of each test [-]: strength is the largest stress within it
	cache             of talik.rve.prepare
	moments           bonds carry moments (MomentIceBondMat): their radius and their share in the strength are fitted, too, from two starts, with bonds
					  that moments break and with bonds that they do not break

	>>> rows = [talik.studies.target.Row(2, 0.0, 0, 0, 100e3, {"phi": 25.0})]
	>>> found = talik.studies.target.fit(rows, grains=30, steps=1, strain=1e-3)"""
	from tqdm import tqdm

	names = fitted(rows, moments)
	sample = _unfitted(grains, porosity, cache, moments)
	begins = [dict(standard, **bonds) for bonds in ((standardMoments, unbentMoments) if moments else ({},))]
	wanted = sorted({name for row in rows for name in row.wanted}, key=quantities.index)
	candidates = []
	aims = [{}] + ([{name: 5.0} for name in wanted] if len(wanted) > 1 else [])
	with tqdm(total=(steps * (len(begins) + 1) + 2 * (len(aims) - 1)) * (len(names) + 1), unit="sample", desc="calibrating") as bar:

		def tested(places):
			parameters = dict(begins[0], **{name: ranges[name].at(place - 1) for name, place in zip(names, places)})
			bonds = {name: value for name, value in parameters.items() if name != "thickness"}
			candidate = Candidate(parameters, [test(altered(sample, **bonds), row, parameters["thickness"], law, strain).values for row in rows])
			candidates.append(candidate)
			bar.update()
			bar.set_postfix({name: f"{factor:.2f}" for name, factor in candidate.misfits(rows).items()})
			return candidate

		def descend(parameters, aim, most):
			start = np.array([1 + ranges[name].partOf(parameters[name]) for name in names])
			_descend(lambda places: [aim.get(name, 1.0) * log for name, log in tested(places).logs(rows)], start, most)

		def best():
			return min(candidates, key=lambda candidate: sum(log**2 for _, log in candidate.logs(rows)))

		for parameters in begins:
			descend(parameters, aims[0], steps)
		for aim in aims[1:]:
			descend(best().parameters, aim, 2)
		descend(best().parameters, aims[0], steps)
	return Fit(rows, best(), candidates, grains, porosity, moments)


def _unfitted(grains, porosity, cache, moments):
	"""Packed sample that is fitted: it bears what one of the standard thickness bears at the usual pressure."""
	pressure = usualPressure * standard["thickness"] / usualThickness
	ofBonds = standardMoments if moments else {}
	return rve.pack(rve.prepare(grains=grains, porosity=porosity, pressure=pressure, ice=True, etaRoll=standard["etaRoll"], cache=cache, **ofBonds))


def _descend(residuals, start, steps):
	"""Places 1..2 in the ranges. A step of 5 % for the derivatives passes over the jumps of single contacts."""
	from scipy.optimize import least_squares

	least_squares(residuals, np.clip(start, 1.001, 1.999), bounds=(1.0, 2.0), diff_step=0.04, max_nfev=steps, x_scale=0.2)


# ---- picture --------------------------------------------------------------------------------------------------------------


def draw(found, sample, law=None, strain=0.04):
	"""Figure: curves of a packed sample beside the target of each row, and the front.

	>>> row = talik.studies.target.Row(2, 1.0, -10.0, 1e-4, 100e3, {"strength": 1e6, "E": 1e8})
	>>> best = talik.studies.target.Candidate(dict(talik.studies.target.standard), [dict(strength=2e6, E=1e8)])
	>>> figure = talik.studies.target.draw(talik.studies.target.Fit([row], best, [best], 30, 0.19), packed, strain=1e-3)"""
	panels = len(found.rows) + 1
	across = min(3, panels)
	fig = plots.figure(4.2 * across, 3.6 * math.ceil(panels / across))
	axes = np.ravel(fig.subplots(math.ceil(panels / across), across, squeeze=False))
	for row, panel in zip(found.rows, axes):
		_drawRow(panel, row, test(sample, row, law=law, strain=strain))
	_drawFront(axes[len(found.rows)], found)
	for unused in axes[panels:]:
		unused.remove()
	return fig


def _drawRow(axes, row, measured):
	for (name, (strain, stress)), colour in zip(measured.curves.items(), ("black", "C0")):
		axes.plot(100 * np.asarray(strain), 1e-6 * np.asarray(stress), color=colour, linewidth=0.9, label=f"sample, {name}")
	reach = 1.0 if "compression" not in measured.curves else 100 * max(measured.curves["compression"][0])
	strength = row.wanted.get("strength") or measured.values.get("strength")
	if "phi" in row.wanted and "strength" not in row.wanted:
		sine = math.sin(math.radians(row.wanted["phi"]))
		strength = 2 * row.confinement * sine / (1 - sine)
	if set(row.wanted) & {"strength", "phi"}:
		axes.axhline(1e-6 * strength, color="crimson", linestyle="--", label="target, strength" if "strength" in row.wanted else "target, φ")
	if "E" in row.wanted:
		end = min(0.5 * strength / row.wanted["E"], reach / 100)
		axes.plot([0, 100 * end], [0, 1e-6 * row.wanted["E"] * end], color="crimson", linewidth=2, label="target, E")
	if "tension" in row.wanted:
		axes.axhline(-1e-6 * row.wanted["tension"], color="C1", linestyle="--", label="target, tension")
	axes.set(xlabel="axial strain [%]", ylabel="axial less lateral stress [MPa]")
	axes.set_title(str(row), fontsize=9)
	axes.legend(fontsize=7)


def _drawFront(axes, found):
	names = list(found.best.misfits(found.rows))
	for candidate in found.front():
		axes.plot(names, list(candidate.misfits(found.rows).values()), "o-", color="0.7", linewidth=0.7, markersize=3)
	axes.plot(names, list(found.best.misfits(found.rows).values()), "o-", color="black", label="best")
	axes.axhline(1, color="crimson", linestyle="--", label="target")
	axes.set(ylabel="off by a factor of", yscale="log")
	axes.yaxis.set_major_formatter("{x:g}")
	axes.yaxis.set_minor_formatter("{x:g}")
	axes.set_title("samples of which none is better in everything", fontsize=9)
	axes.legend(fontsize=7)
