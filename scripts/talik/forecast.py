# SPDX-License-Identifier: GPL-2.0-or-later
"""Forecasts with their uncertainty: soils by chance, soils that agree with observations, results as probabilities.

	from scipy import stats
	soil = {"cohesion": stats.lognorm(s=0.4, scale=4e3), "conductivity": stats.uniform(0.8, 1.0)}
	rows = talik.forecast.draw(soil, runs=40)                              # a soil for each run, and a seed
	results = talik.batch.run("slope.py", rows, "output/forecast")         # as many at a time as there are cores
	print(talik.forecast.Exceedance([result["displacement"] for result in results]))

In the script a RandomField varies from place to place, by the seed of the row:

	field = talik.forecast.RandomField(stats.beta(5, 7), lengths=(8, 1)).draw(row.seed, lower=(0, 0), upper=(30, 10))
	talik.geometry.fill(mpm, outline, porosity=field)

`invert` finds soils that agree with observations, and how far these leave them open. `probabilityMap` says where ground moves, and how sure that is
after so many runs.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy import fft, stats
from scipy.special import ndtr

from talik import dates, ensemble, geogrid, output, plots
from talik.ensemble import confidence
from talik.realisation import seedStride
from talik.tables import lines

correlations = {"exponential": lambda distance: np.exp(-distance), "gaussian": lambda distance: np.exp(-(distance**2))}


# ---- soils by chance -------------------------------------------------------------------------------------------------------


def quantiles(marginal, probability):
	"""Values of a distribution at probabilities (n,), 0 to 1.

	marginal  a distribution of scipy.stats with its parameters, or a function that gives the value of a probability (its quantiles)

	>>> talik.forecast.quantiles(lambda p: 2 + p, np.array([0.5])).tolist()
	[2.5]"""
	find = getattr(marginal, "ppf", marginal)
	if not callable(find):
		raise ValueError(
			f"forecast: the distribution is {marginal!r}; give one of scipy.stats, such as stats.lognorm(s=0.4, scale=4e3), or its quantile function"
		)
	return np.asarray(find(np.clip(probability, 1e-12, 1 - 1e-12)), dtype=float)


def draw(variables, runs, seed=1):
	"""Rows for talik.batch.run: in each a value of every variable, and a seed for random fields and samples of its own.

	variables  {name: distribution}, see quantiles; they are independent of each other
	runs       number of rows

	The values are a Latin hypercube: of every variable one in each of so many parts of equal probability.

	>>> rows = talik.forecast.draw({"cohesion": lambda p: 2e3 + 4e3 * p}, runs=4)
	>>> sorted(int(row["cohesion"] // 1000) for row in rows), [row["seed"] for row in rows]
	([2, 3, 4, 5], [1, 1001, 2001, 3001])"""
	if runs < 1:
		raise ValueError(f"forecast.draw: runs is {runs}; give 1 or more")
	if "seed" in variables:
		raise ValueError("forecast.draw: a variable is named 'seed', which every row has for its random fields; give it another name")
	chances = stats.qmc.LatinHypercube(len(variables), seed=seed).random(runs)
	columns = {name: quantiles(marginal, chance) for (name, marginal), chance in zip(variables.items(), chances.T)}
	return [{**{name: float(column[k]) for name, column in columns.items()}, "seed": seed + seedStride * k} for k in range(runs)]


@dataclass(frozen=True)
class RandomField:
	"""A quantity of the soil that varies from place to place: a Gaussian field whose values are given another distribution.

	marginal     distribution of the values at each place, see quantiles
	lengths      correlation lengths l along x, y (and z) [m], above 0; one number: the same in all directions
	correlation  of the Gaussian field at the distance d = sqrt(sum (dx_i/l_i)^2): "exponential", exp(-d), whose scale of fluctuation is 2 l, or
				 "gaussian", exp(-d^2), smooth

	With a normal distribution the field itself has this correlation; with a lognormal one of logarithmic deviation s it has
	(exp(s^2 rho) - 1)/(exp(s^2) - 1). Layers are long in x and short in y.

	>>> talik.forecast.RandomField(lambda p: p, lengths=(8, 1)).lengths
	(8, 1)"""

	marginal: object
	lengths: object
	correlation: str = "exponential"

	def __post_init__(self):
		if self.correlation not in correlations:
			raise ValueError(f"RandomField: correlation is {self.correlation!r}; choose {' or '.join(correlations)}")
		if not (np.atleast_1d(self.lengths) > 0).all():
			raise ValueError(f"RandomField: lengths is {self.lengths!r}; give correlation lengths in m, above 0")

	def draw(self, seed, lower, upper, resolution=10):
		"""Function of x, y (and z) [m], for talik.geometry.fill: one realisation between the corners lower and upper [m] of a box.

		resolution  places in a correlation length. At each the distribution is exact; between them the value is that of the nearest

		The covariance is embedded in a circulant one, whose root is found by the fast Fourier transform (Dietrich and Newsam 1997)."""
		lower, upper = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
		lengths = np.broadcast_to(np.asarray(self.lengths, dtype=float), lower.shape)
		if not (upper > lower).all():
			raise ValueError(f"RandomField.draw: lower is {tuple(lower)} and upper is {tuple(upper)}; give the corners of a box")
		side = lengths / resolution
		count = np.ceil((upper - lower) / side).astype(int) + 1
		whole = [fft.next_fast_len(int(n + max(n, 6 * resolution))) for n in count]
		steps = [np.minimum(np.arange(n), n - np.arange(n)) / resolution for n in whole]
		distance = np.sqrt(sum(axis**2 for axis in np.meshgrid(*steps, indexing="ij")))
		spectrum = np.maximum(0.0, fft.fftn(correlations[self.correlation](distance)).real)
		spectrum /= spectrum.mean()  # the variance is 1 where parts below 0 were left out
		random = np.random.default_rng(seed)
		noise = random.standard_normal(whole) + 1j * random.standard_normal(whole)
		gaussian = fft.fftn(np.sqrt(spectrum / spectrum.size) * noise).real
		values = quantiles(self.marginal, ndtr(gaussian[tuple(slice(n) for n in count)]))

		def at(*place):
			places = [np.asarray(x, dtype=float) for x in place]
			if len(places) != len(lower):
				raise ValueError(f"RandomField: the place has {len(places)} coordinates, and the box {len(lower)}")
			return values[tuple(np.clip(np.rint((x - x0) / d), 0, n - 1).astype(int) for x, x0, d, n in zip(places, lower, side, count))]

		return at


# ---- soils that agree with observations ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Observation:
	"""One measured value: day of the calendar, name of the quantity, value, standard deviation of its error in the same unit.

	>>> talik.forecast.Observation(30.0, "thaw depth", 0.8, 0.05).value
	0.8"""

	day: float
	quantity: str
	value: float
	error: float


def observations(path):
	"""Observations of a CSV file with the columns date, quantity, value, error, in this order and with one line of headings.

	date is an ISO date (2024-07-01, of a scene with talik.dates.start) or a day of the calendar; error is a standard deviation, above 0.

	>>> with open(folder + "/survey.csv", "w") as file:
	...     written = file.write("date,quantity,value,error\\n30,thaw depth [m],0.8,0.05\\n60,thaw depth [m],1.1,0.05\\n")
	>>> talik.forecast.observations(folder + "/survey.csv")[1]
	Observation(day=60.0, quantity='thaw depth [m]', value=1.1, error=0.05)"""
	found = []
	for line, cells in lines(path)[1:]:
		try:
			when, quantity, value, error = (cell.strip() for cell in cells[:4])
			one = Observation(dates.dayOf(when), quantity, float(value), float(error))
		except ValueError as problem:
			raise ValueError(f"{path}, line {line}: give date, quantity, value, error; {problem}") from None
		if not (np.isfinite(one.value) and one.error > 0):
			raise ValueError(f"{path}, line {line}: value is {value} and error is {error}; give a number, and a standard deviation above 0")
		found.append(one)
	if not found:
		raise ValueError(f"{path} holds no observations; it must have lines with date, quantity, value, error")
	return found


@dataclass(frozen=True)
class Inversion:
	"""Soils that agree with observations, see invert.

	rows     of the soils, as of draw; results: what the model gave for them
	misfit   mean of (computed - observed)^2/error^2 of the soils at first, after each step, and at last: about 1 to 2 where model and errors are right

	>>> talik.forecast.Inversion([dict(k=1.0, seed=1), dict(k=2.0, seed=2)], [None, None], [5.0, 1.0]).spread()["k"].mean
	1.5"""

	rows: list
	results: list
	misfit: list = field(default_factory=list)

	def spread(self):
		"""{name of a variable: talik.ensemble.Spread}."""
		return ensemble.spread([{name: value for name, value in row.items() if name != "seed"} for row in self.rows])

	def interval(self, name, level=0.8):
		"""(lowest, highest) value of a variable between which so much of its probability lies."""
		return tuple(float(x) for x in np.quantile([row[name] for row in self.rows], (0.5 - level / 2, 0.5 + level / 2)))

	def __str__(self):
		table = ["| variable | mean | standard deviation | first decile | median | ninth decile |", "|---|---|---|---|---|---|"]
		for name, one in self.spread().items():
			table.append(f"| {name} | {' | '.join(f'{value:.3g}' for value in (one.mean, one.given.std(ddof=1), *one.deciles))} |")
		return "\n".join(table) + f"\n\n{len(self.rows)} soils; misfit {', '.join(f'{value:.3g}' for value in self.misfit)}"


def invert(model, variables, observed, members=100, steps=4, seed=1):
	"""Soils that agree with observations, by ensemble Kalman inversion: Inversion.

	model      function of rows (see draw) that returns for each a dictionary {quantity: (days, values)}, or None for a run that failed. Rows may go to
			   talik.batch.run. The quantity is interpolated linearly to the days of its observations
	variables  {name: distribution} as they are believed to be before, see quantiles
	observed   list of Observation, see observations
	members    soils at a time, ten times the number of variables or more
	steps      in which the observations are taken into account; strongly nonlinear models need more. The model runs members*(steps + 1) times

	The ensemble smoother with multiple data assimilation (Emerick and Reynolds 2013), on normal variables that the distributions are mapped to. A misfit far
	above 1 at the end says that no soil of these variables gives the observations, or that their errors are larger than said.

	>>> def model(rows):
	...     return [{"thaw depth": ([0, 100], [0, 0.5 * row["rate"]])} for row in rows]
	>>> measured = [talik.forecast.Observation(100, "thaw depth", 1.0, 0.01)]
	>>> found = talik.forecast.invert(model, {"rate": lambda p: 1 + 2 * p}, measured, members=50)
	>>> abs(found.spread()["rate"].mean - 2) < 0.05
	True"""
	if members < 2 * len(variables) + 2:
		raise ValueError(f"forecast.invert: members is {members} with {len(variables)} variables; give {10 * len(variables)} or more")
	random = np.random.default_rng(seed)
	names = list(variables)
	normal = stats.norm.ppf(stats.qmc.LatinHypercube(len(names), seed=random).random(members))
	value, error = (np.array([getattr(one, name) for one in observed]) for name in ("value", "error"))

	def run():
		columns = [quantiles(variables[name], ndtr(column)) for name, column in zip(names, normal.T)]
		rows = [{**{name: float(column[k]) for name, column in zip(names, columns)}, "seed": seed + seedStride * k} for k in range(members)]
		results = list(model(rows))
		computed = np.array([_predicted(result, observed) for result in results])
		done = np.isfinite(computed).all(axis=1)
		if done.sum() < members / 2:
			raise RuntimeError(
				f"forecast.invert: {members - done.sum()} of {members} runs gave no values for the observations; look at what the first one says"
			)
		return rows, results, computed, done

	misfit = []
	for _ in range(steps):
		_, _, computed, done = run()
		misfit.append(float((((computed[done] - value) / error) ** 2).mean()))
		noise = random.standard_normal((members, len(value)))
		noise -= noise[done].mean(axis=0)
		of, by = normal[done] - normal[done].mean(axis=0), (computed[done] - computed[done].mean(axis=0)) / error
		gain = np.linalg.solve(by.T @ by / (done.sum() - 1) + steps * np.eye(len(value)), by.T @ of / (done.sum() - 1))
		normal[done] += ((value - computed[done]) / error + np.sqrt(steps) * noise[done]) @ gain
		normal[~done] = random.choice(normal[done], members - done.sum())
	rows, results, computed, done = run()
	misfit.append(float((((computed[done] - value) / error) ** 2).mean()))
	return Inversion([row for row, ended in zip(rows, done) if ended], [result for result, ended in zip(results, done) if ended], misfit)


def _predicted(result, observed):
	"""What a run gave for each observation; nan of a run that failed."""
	if result is None:
		return np.full(len(observed), np.nan)
	for one in observed:
		if one.quantity not in result:
			raise ValueError(f"forecast.invert: '{one.quantity}' was observed, and the model gives {', '.join(map(repr, result))}; give it under the same name")
	return np.array([np.interp(one.day, *result[one.quantity], right=np.nan) for one in observed])


# ---- results as probabilities ----------------------------------------------------------------------------------------------


def runsToHalve(happened, runs, level=0.9):
	"""Runs, besides those there are, that halve the width of the interval of confidence, if the event happens as often in them.

	>>> talik.forecast.runsToHalve(3, 30) > 60
	True"""
	low, high = confidence(happened, runs, level)
	total, share = runs, happened / runs
	while np.subtract(*confidence(share * total, total, level)[::-1]) > 0.5 * (high - low):
		total += 1
	return total - runs


def _unitIn(label):
	"""Unit in the brackets at the end of a label, after a space; nothing where there is none."""
	unit = label.partition(" [")[2].rstrip("]")
	return f" {unit}" if unit not in ("", "-") else ""


@dataclass(frozen=True)
class Exceedance:
	"""How probable it is that a result lies above a limit: from the values of several runs, those of None left out.

	quantity  name of the values with its unit; level: of confidence

	>>> print(talik.forecast.Exceedance([0.1, 0.2, 0.4, 2.0], "heave [m]"))
	heave above 0.1 m: 75 % (25 to 99 %)
	heave above 0.3 m: 50 % (10 to 90 %)
	heave above 1.52 m: 25 % (1 to 75 %)
	4 runs, confidence 90 %; 16 more halve the widest interval"""

	values: tuple
	quantity: str = "result"
	level: float = 0.9

	def __post_init__(self):
		if not len(self.known):
			raise ValueError("Exceedance: there is no value; give that of one run or more, None for a run that failed")

	@property
	def known(self):
		return np.sort([value for value in self.values if value is not None])

	def at(self, limit):
		"""(probability, lowest, highest) that the result is above a limit, or an array of them."""
		above = len(self.known) - np.searchsorted(self.known, limit, side="right")
		return above / len(self.known), *confidence(above, len(self.known), self.level)

	def __str__(self):
		runs = len(self.known)
		limits = np.quantile(self.known, (0.0, 0.5, 0.9)) if runs > 1 else self.known
		name, unit = self.quantity.partition(" [")[0], _unitIn(self.quantity)
		text = ["{} above {:.3g}{}: {:.0f} % ({:.0f} to {:.0f} %)".format(name, limit, unit, *(100 * np.array(self.at(limit)))) for limit in limits]
		more = runsToHalve(0.5 * runs, runs, self.level)
		return "\n".join([*text, f"{runs} runs, confidence {100 * self.level:.0f} %; {more} more halve the widest interval"])

	def draw(self, axes=None):
		"""Figure: probability over the limit, with its band of confidence. axes: of a figure that there is."""
		axes = axes or plots.figure(6, 4).subplots()
		limits = np.repeat(self.known, 2)
		at = np.array(self.at(limits))
		at[:, ::2] = np.array(self.at(np.nextafter(self.known, -np.inf)))
		axes.fill_between(limits, 100 * at[1], 100 * at[2], color="steelblue", alpha=0.3, linewidth=0, label=f"{100 * self.level:.0f} % confidence")
		axes.plot(limits, 100 * at[0], color="navy", label=f"{len(self.known)} runs")
		axes.set(xlabel=self.quantity, ylabel="probability that it is above [%]", ylim=(0, 100))
		axes.legend(frameon=False)
		return axes.figure


@dataclass(frozen=True)
class ProbabilityMap:
	"""Probability of an event at each place of the ground as it lay before it moved, see probabilityMap.

	place   (n, 2) middles of cells [m], in space (n, 3); side: their width [m]; share: probability (n,); low, high: its bounds of confidence
	inPlan  x and y of the places are those of a map

	>>> where = talik.forecast.ProbabilityMap("slides", np.zeros((1, 2)), 1.0, np.ones(1), np.ones(1), np.ones(1), 5)
	>>> where.write(folder + "/slides.vtu")"""

	name: str
	place: np.ndarray
	side: float
	share: np.ndarray
	low: np.ndarray
	high: np.ndarray
	runs: int
	inPlan: bool = False

	def _repr_png_(self):
		return self.draw()._repr_png_() if self.place.shape[1] == 2 else None

	def draw(self):
		"""Figure: the probability, and the width of its interval of confidence. Of ground in space a map in plan can be drawn."""
		if self.place.shape[1] == 3:
			raise ValueError("ProbabilityMap.draw: the places are in space; give probabilityMap inPlan=True, or write a .vtu file")
		fig = plots.figure(10, 2.8)
		fig.suptitle(f"{self.name}, {self.runs} run{'s' * (self.runs != 1)}", fontsize=9)
		size = np.full(len(self.place), self.side**2)
		for axes, values, label, colours in zip(
			fig.subplots(1, 2), (self.share, self.high - self.low), ("probability [%]", "width of its 90 % interval [%]"), ("magma_r", "Greys")
		):
			plots.slopeField(axes, self.place, 100 * values, size, label=label, colourMap=colours, limits=(0, 100))
		return fig

	def write(self, path, crs=None):
		"""A file with probability, lowest and highest: .vtu for ParaView; of a map in plan .tif (GeoTIFF with three bands) or .asc (the probability as
		an ESRI ASCII grid, which needs no package) for a GIS. crs: of x and y, for .tif, such as "EPSG:32633"."""
		values = {"probability": self.share, "lowest": self.low, "highest": self.high}
		suffix = Path(path).suffix
		if suffix == ".vtu":
			return output.writePoints(path, self.place, values)
		if suffix not in (".tif", ".asc"):
			raise ValueError(f"ProbabilityMap.write: '{path}' ends with '{suffix}'; choose .vtu, .tif or .asc")
		if not self.inPlan:
			raise ValueError(f"ProbabilityMap.write: '{path}' is for a map, and this is no map in plan; give probabilityMap ground in space and inPlan=True")
		geogrid.write(path, self.place, self.side, values, crs)


def probabilityMap(runs, field="displacement", above=0.1, day=None, inPlan=False):
	"""How probable it is, place by place, that a field of the ground is above a limit on a day: ProbabilityMap.

	runs    of each run its frames, as talik.output.Frames keeps them and loadFrames reads them
	field   name of a field; vectors by their length; "settlement" is the way down
	above   limit, in units of the field
	day     of the calendar, or an ISO date of a scene with talik.dates.start; the last frame up to it counts. None: the last one
	inPlan  of ground in space a map: whether the field is above the limit anywhere below a place

	>>> still = dict(position=np.zeros((1, 2)), displacement=np.zeros((1, 2)), volume=np.ones(1), time=0.0)
	>>> talik.forecast.probabilityMap([[still], [still]], above=0.1).share
	array([0.])"""
	if not len(runs):
		raise ValueError("probabilityMap: runs is empty; give the frames of one run or more, as talik.output.loadFrames reads them")
	last = [_until(frames, day) for frames in runs]
	name = f"{field} above {above:g}{_unitIn(plots.slopeFields.get(field, (field,))[0])}" + (
		"" if day is None else f" by {day if isinstance(day, str) else f'day {day:g}'}"
	)
	last = [{**frame, "happened": plots.magnitude(plots.valuesOf(frame, field)) > above} for frame in last]
	if inPlan:
		side = ensemble.sideOf(last[0])
		last = [_seenFromAbove(frame, side) for frame in last]
	place, side, shares = ensemble.shares(last, lambda frame: {name: frame["happened"]})
	low, high = confidence(np.rint(shares[name] * len(last)), len(last))
	return ProbabilityMap(name, place, side, shares[name], low, high, len(last), inPlan)


def _seenFromAbove(frame, side):
	"""A frame with a point in each column of ground, where it happened if it did so in one of its points."""
	start = frame["position"] - frame["displacement"]
	if start.shape[1] != 3:
		raise ValueError("probabilityMap: inPlan needs ground in space, and this lies in a plane; leave inPlan out")
	cells, column = np.unique(np.floor(start[:, :2] / side + 1e-6), axis=0, return_inverse=True)
	happened = np.bincount(column.ravel(), weights=frame["happened"]) > 0
	return {"position": (cells + 0.5) * side, "displacement": np.zeros_like(cells), "volume": np.full(len(cells), side**2), "happened": happened}


def _until(frames, day):
	if day is None:
		return frames[-1]
	limit = dates.dayOf(day)
	before = [frame for frame in frames if frame.get("day", frame["time"] / dates.secondsPerDay) <= limit * (1 + 1e-9)]
	if not before:
		raise ValueError(f"probabilityMap: a run has no frame up to day {limit:g}; keep one by talik.output.Frames(times=[…], days=True)")
	return before[-1]
