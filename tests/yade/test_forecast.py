# SPDX-License-Identifier: GPL-2.0-or-later
"""Random fields, soils that agree with observations, probabilities: against closed forms."""

import math

import numpy as np
import pytest
from scipy import stats
from yade import O, wrapper

import talik
from talik import forecast


def test_a_random_field_has_the_covariance_and_the_distribution_that_it_was_given():
	"""Lognormal, of logarithmic deviation s: (exp(s^2 rho) - 1)/(exp(s^2) - 1), with rho = exp(-d)."""
	s, lengths = 0.3, (4.0, 1.0)
	field = forecast.RandomField(stats.lognorm(s=s, scale=3e3), lengths)
	x, y = np.meshgrid(np.arange(0, 40, 0.8), np.arange(0, 10, 0.2))
	values = np.array([field.draw(seed, (0, 0), (40, 10))(x, y) for seed in range(150)])
	deciles = np.quantile(values, (0.1, 0.5, 0.9)) / stats.lognorm(s=s, scale=3e3).ppf((0.1, 0.5, 0.9))
	print(f"deciles over those of the distribution {np.round(deciles, 3)}")
	assert deciles == pytest.approx(1, abs=0.03)
	apart = values - math.exp(s**2 / 2) * 3e3
	variance = 9e6 * math.exp(s**2) * (math.exp(s**2) - 1)
	for axis, step, length in ((2, 0.8, 4.0), (1, 0.2, 1.0)):
		for lag in (0, 2, 5, 10):
			first, second = (np.take(apart, range(begin, apart.shape[axis] - lag + begin), axis) for begin in (0, lag))
			found = (first * second).mean() / variance
			closed = (math.exp(s**2 * math.exp(-lag * step / length)) - 1) / (math.exp(s**2) - 1)
			print(f"{lag * step:.1f} m along {'zyx'[axis]}: correlation {found:.3f}, closed form {closed:.3f}")
			assert found == pytest.approx(closed, abs=0.08)


def test_a_gaussian_field_in_space_is_smooth_and_the_same_for_the_same_seed():
	field = forecast.RandomField(stats.norm(), 2.0, "gaussian")
	at = field.draw(3, (0, 0, 0), (8, 8, 8), resolution=6)
	x = np.arange(0, 8, 1 / 3)
	line = at(x, np.full_like(x, 4), np.full_like(x, 4))
	print(f"largest step in a sixth of the length {np.abs(np.diff(line)).max():.2f}")
	assert np.abs(np.diff(line)).max() < 1 and (line == field.draw(3, (0, 0, 0), (8, 8, 8), resolution=6)(x, np.full_like(x, 4), np.full_like(x, 4))).all()
	with pytest.raises(ValueError, match="choose exponential or gaussian"):
		forecast.RandomField(stats.norm(), 2.0, "spherical")


def test_rows_are_one_in_each_part_of_equal_probability():
	rows = forecast.draw({"c": stats.lognorm(s=0.4, scale=4e3), "phi": stats.uniform(25, 10)}, runs=20)
	parts = sorted(int(20 * stats.lognorm(s=0.4, scale=4e3).cdf(row["c"])) for row in rows)
	print(rows[0], f"parts {parts}")
	assert parts == list(range(20)) and len({row["seed"] for row in rows}) == 20
	with pytest.raises(ValueError, match="quantile function"):
		forecast.draw({"c": 4e3}, runs=2)


# ---- inversion -------------------------------------------------------------------------------------------------------------

latent = 0.45 * 910 * 334e3  # [J/m3]
hidden = {"conductivity": 1.4, "potential": 2.2e-9, "cohesion": 1600.0}
believed = {
	"conductivity": stats.lognorm(s=0.4, scale=1.1),
	"potential": stats.lognorm(s=0.7, scale=1.5e-9),
	"cohesion": stats.lognorm(s=0.5, scale=1200.0),
}
days = np.linspace(0, 120, 61)


def year(row):
	"""Closed forms: thaw depth of Stefan under 10 degC, heave of the winter before by its segregation potential under 0.6 K/m (Konrad and Morgenstern), and
	the speed of a thawed Bingham layer on the frozen slope."""
	depth = np.sqrt(2 * row["conductivity"] * 10 * days * talik.day / latent)
	heave = 1.09 * row["potential"] * 0.6 * days * talik.day
	driving = 18e3 * depth * math.sin(math.radians(12)) * math.cos(math.radians(12))
	over = np.maximum(0.0, driving - row["cohesion"] - 0.2 * driving)
	creep = np.concatenate(([0], np.cumsum(0.5 * (over[1:] + over[:-1]) * np.diff(days)))) * 2e-6
	return {"thaw depth [m]": (days, depth), "heave [m]": (days, heave), "inclinometer [m]": (days, creep)}


errors = {"thaw depth [m]": 0.05, "heave [m]": 0.002, "inclinometer [m]": 0.01}


def measured(seed, truth=hidden):
	random = np.random.default_rng(seed)
	exact = year(truth)
	return [
		forecast.Observation(day, name, float(np.interp(day, *exact[name]) + error * random.standard_normal()), error)
		for name, error in errors.items()
		for day in (30, 60, 90, 120)
	]


def test_three_hidden_numbers_are_found_within_a_fifth():
	found = forecast.invert(lambda rows: [year(row) for row in rows], believed, measured(1))
	print(found)
	for name, value in hidden.items():
		mean = found.spread()[name].mean
		print(f"{name}: {mean:.3g}, hidden {value:.3g}, off by {100 * (mean / value - 1):+.1f} %; prior median {believed[name].median():.3g}")
		assert mean == pytest.approx(value, rel=0.2)
	assert 0.5 < found.misfit[-1] < 2.5 < found.misfit[0]


def test_intervals_of_four_fifths_hold_the_truth_in_four_of_five_repeats():
	"""Truths are drawn from what is believed before, as an honest interval needs. 60 intervals; by chance alone 41 to 54 hold (95 %)."""
	held = []
	for repeat, truth in enumerate(forecast.draw(believed, 20, seed=7)):
		found = forecast.invert(lambda rows: [year(row) for row in rows], believed, measured(repeat, truth), seed=repeat)
		held += [found.interval(name)[0] <= truth[name] <= found.interval(name)[1] for name in believed]
	print(f"{sum(held)} of {len(held)} intervals hold the truth; 80 % is {0.8 * len(held):.0f}")
	assert 41 <= sum(held) <= 54


porosity, width = 0.4, 0.5


def finiteVolumes(conductivity, surface, depths, cells=40, height=3.0):
	"""Temperatures [degC] at depths [m] on each of 730 days, in a column with closed base: explicit finite volumes, enthalpy over temperature as a table.
	Grains conduct as given, ice 2.2 and water 0.6 W/(m K), arithmetic mean; the liquid saturation is exp(-(T/width)^2)."""
	table = np.linspace(-40, 40, 16001)
	liquid = np.where(table < 0, np.exp(-np.minimum(table / width, 0) ** 2), 1.0)
	ice = porosity * 910 * (1 - liquid)
	water = porosity * (910 + 90 * math.exp(-((2 / width) ** 2))) - ice  # pores are full at -2 degC
	enthalpy = ((1 - porosity) * 2650 * 800 + ice * 2060 + water * 4200) * table + water * 334e3
	h, step = height / cells, 1200.0
	at = (np.arange(cells) + 0.5) * h
	T = np.full(cells, -2.0)
	H = np.interp(T, table, enthalpy)
	rows = []
	for k in range(int(730 * 86400 / step)):
		if k % 72 == 0:
			rows.append(np.interp(depths, at, T))
		S = np.interp(T, table, liquid)
		kappa = (1 - porosity) * conductivity + porosity * ((1 - S) * 2.2 + S * 0.6)
		flux = np.concatenate(([kappa[0] * (T[0] - surface(k * step / 86400)) / (h / 2)], 2 / (1 / kappa[1:] + 1 / kappa[:-1]) * np.diff(T) / h, [0]))
		H = H + step * np.diff(flux) / h
		T = np.interp(H, enthalpy, table)
	return np.array(rows)


def test_a_borehole_gives_the_conductivity_of_its_ground_with_its_spread_and_predicts_the_next_year_slow():
	"""The borehole is finite volumes of its own, read each month with an error of 0.2 K; the model is a column of MpmEngine."""
	summers, depths, truth = (10.0, 14.0), np.array([0.5, 1.0, 2.0]), 1.8
	surface = lambda day: -3 + (7 + summers[int(day > 365)]) / 2 * -math.cos(2 * math.pi * day / 365)  # noqa: E731
	borehole = finiteVolumes(truth, surface, depths)
	random = np.random.default_rng(3)
	read = [
		forecast.Observation(float(day), f"{depth} m", float(borehole[day, k] + 0.2 * random.standard_normal()), 0.2)
		for k, depth in enumerate(depths)
		for day in range(30, 360, 30)
	]

	def column(row, until):
		times = np.arange(0, 731, 5)
		mpm = wrapper.MpmEngine(
			gridSpacing=0.1,
			lower=(0, 0),
			upper=(0.1, 3),
			motion=False,
			heat=wrapper.HeatTransfer(),
			freezing=wrapper.FreezingCurve(width=width),
			materials=[wrapper.GroundMaterial(solidConductivity=row["conductivity"])],
			boundaries=[wrapper.SurfaceTemperature(region="top", days=times.tolist(), values=[surface(day) for day in times])],
		)
		talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 0.1, 3), porosity=porosity, temperature=-2)
		O.reset()
		O.engines = [mpm]
		days, rows = [], []
		for day in range(0, until + 1, 10):
			talik.runUntilDay(mpm, day)
			order = mpm.field("position")[:, 1].argsort()
			days.append(mpm.calendar["day"])
			rows.append(np.interp(3 - depths, mpm.field("position")[order, 1], mpm.field("temperature")[order]))
		return {f"{depth} m": (np.array(days), np.array(rows)[:, k]) for k, depth in enumerate(depths)}

	believed = {"conductivity": stats.lognorm(s=0.4, scale=1.2)}
	found = forecast.invert(lambda rows: [column(row, 360) for row in rows], believed, read, members=16, steps=3)
	low, high = found.interval("conductivity")
	nextYear = np.array([[one[1][40:] for one in column(row, 720).values()] for row in found.rows])
	due = borehole[400:730:10, :].T
	off = np.sqrt(((nextYear.mean(axis=0) - due) ** 2).mean())
	mean = found.spread()["conductivity"].mean
	print(
		f"conductivity {mean:.2f} W/(m K), {low:.2f} to {high:.2f} (80 %), due {truth}; year 2 off by {off:.2f} K rms, tolerance 0.3 K; misfit {found.misfit}"
	)
	assert mean == pytest.approx(truth, rel=0.15) and off < 0.3 and high - low < 0.6


def test_runs_that_fail_are_left_out_and_quantities_that_the_model_lacks_are_named():
	def model(rows):
		return [None if row["seed"] % 3000 == 1 else year(row) for row in rows]

	found = forecast.invert(model, believed, measured(1), members=60, steps=2)
	assert len(found.rows) == len(found.results) == 40
	with pytest.raises(ValueError, match="'tilt' was observed"):
		forecast.invert(model, believed, [forecast.Observation(30, "tilt", 0.1, 0.01)])
	with pytest.raises(RuntimeError, match="gave no values"):
		forecast.invert(lambda rows: [None] * len(rows), believed, measured(1))


def test_observations_of_a_file_have_days_by_their_dates(tmp_path):
	talik.dates.start("2024-05-15")
	file = tmp_path / "survey.csv"
	file.write_text("date,quantity,value,error\n2024-06-14,thaw depth [m],0.8,0.05\n45.5,thaw depth [m],1.0,0.05\n")
	assert [(one.day, one.value) for one in forecast.observations(file)] == [(30.0, 0.8), (45.5, 1.0)]
	file.write_text("date,quantity,value,error\n2024-06-14,thaw depth [m],0.8,0\n")
	with pytest.raises(ValueError, match="line 2: .*standard deviation above 0"):
		forecast.observations(file)


# ---- probabilities ---------------------------------------------------------------------------------------------------------


def test_an_interval_of_confidence_holds_the_probability_as_often_as_it_says():
	"""Clopper and Pearson: at least 90 % of all draws, exactly by the binomial distribution."""
	for runs, p in ((10, 0.3), (30, 0.1), (30, 0.5)):
		k = np.arange(runs + 1)
		low, high = talik.ensemble.confidence(k, runs)
		holds = stats.binom(runs, p).pmf(k)[(low <= p) & (p <= high)].sum()
		print(f"{runs} runs, probability {p}: the interval holds it in {100 * holds:.1f} % of all draws")
		assert 0.9 <= holds < 0.99
	more = forecast.runsToHalve(9, 30)
	before, after = (np.subtract(*talik.ensemble.confidence(n * 0.3, n)[::-1]) for n in (30, 30 + more))
	print(f"{more} runs more make the interval {before:.3f} wide {after:.3f}")
	assert after == pytest.approx(before / 2, rel=0.02)


def test_a_curve_of_exceedance_is_the_share_of_runs_above_a_limit():
	values = np.random.default_rng(1).lognormal(size=200)
	curve = forecast.Exceedance((*values, None), "displacement [m]")
	for limit in (0.5, 1.0, 3.0):
		share, low, high = curve.at(limit)
		print(f"above {limit}: {share:.3f} ({low:.3f} to {high:.3f}), of the distribution {stats.lognorm(s=1).sf(limit):.3f}")
		assert share == (values > limit).mean() and (low, high) == talik.ensemble.confidence((values > limit).sum(), 200)
	print(curve)
	with pytest.raises(ValueError, match="no value"):
		forecast.Exceedance([None])
	assert str(curve).startswith(f"displacement above {values.min():.3g} m: ") and curve.draw().axes[0].get_xlabel() == "displacement [m]"


def test_a_map_of_probability_counts_runs_place_by_place_up_to_a_day(tmp_path):
	position = np.array([[x + 0.5, y + 0.5] for x in range(3) for y in range(2)])

	def frame(day, moved):
		displacement = np.zeros((6, 2))
		displacement[:moved, 0] = 0.3
		return dict(time=0.0, day=day, position=position + displacement, displacement=displacement, volume=np.ones(6))

	runs = [[frame(0.0, 0), frame(10.0, moved), frame(20.0, 6)] for moved in (2, 2, 4, 0)]
	found = forecast.probabilityMap(runs, above=0.1, day=15)
	print(dict(zip(map(tuple, found.place), found.share)))
	assert found.share.tolist() == [0.75, 0.75, 0.25, 0.25, 0, 0]
	assert found.name == "displacement above 0.1 m by day 15"
	assert (found.low <= found.share).all() and (found.share <= found.high).all()
	assert (forecast.probabilityMap(runs, above=0.1).share == 1).all()
	found.write(tmp_path / "map.vtu")
	talik.plots.save(found.draw(), tmp_path / "map.png")
	assert (tmp_path / "map.vtu").stat().st_size > 500
	for given, told in ((dict(day=-1), "no frame up to day -1"), (dict(field="displacment"), "choose one of settlement, day, displacement")):
		with pytest.raises(ValueError, match=told):
			forecast.probabilityMap(runs, **given)
	with pytest.raises(ValueError, match="runs is empty"):
		forecast.probabilityMap([])
	assert (forecast.probabilityMap(runs, "settlement", above=-0.1).share == 1).all()


def ofHill(moved):
	"""A hill of 3 m by 2 m and 2 m of height in UTM, in cells of a metre, of which points have moved."""
	position = np.array([[500000.5 + x, 7100000.5 + y, z + 0.5] for x in range(3) for y in range(2) for z in range(2)])
	displacement = np.zeros((12, 3))
	displacement[list(moved), 0] = 0.3
	return [dict(time=0.0, day=0.0, position=position + displacement, displacement=displacement, volume=np.ones(12))]


@pytest.mark.parametrize("ending", ["asc", "tif"])
def test_a_map_in_plan_says_where_anything_below_has_moved_and_other_programs_read_it(tmp_path, ending):
	if ending == "tif":
		pytest.importorskip("rasterio")
	found = forecast.probabilityMap([ofHill({0}), ofHill({1}), ofHill({4}), ofHill({4, 5})], above=0.1, inPlan=True)
	found.write(tmp_path / f"risk.{ending}", **(dict(crs="EPSG:32633") if ending == "tif" else {}))
	grid = talik.solids.readHeights(tmp_path / f"risk.{ending}")
	print(grid.x, grid.y, grid.z, sep="\n")
	assert grid.z.tolist() == [[0.5, 0], [0.5, 0], [0, 0]]  # in two runs the first column, once its lower and once its upper point
	assert grid.x == pytest.approx([500000.5, 500001.5, 500002.5], abs=1e-6) and grid.y == pytest.approx([7100000.5, 7100001.5], abs=1e-6)
	if ending == "tif":
		import rasterio

		with rasterio.open(tmp_path / "risk.tif") as file:
			assert file.descriptions == ("probability", "lowest", "highest") and file.crs.to_epsg() == 32633


def test_a_section_is_no_map_and_a_map_needs_a_known_ending(tmp_path):
	section = [dict(time=0.0, position=np.zeros((1, 2)), displacement=np.zeros((1, 2)), volume=np.ones(1))]
	with pytest.raises(ValueError, match="give probabilityMap ground in space and inPlan=True"):
		forecast.probabilityMap([section]).write(tmp_path / "risk.tif")
	with pytest.raises(ValueError, match="inPlan needs ground in space"):
		forecast.probabilityMap([section], inPlan=True)
	with pytest.raises(ValueError, match="choose .vtu, .tif or .asc"):
		forecast.probabilityMap([section]).write(tmp_path / "risk.png")
	with pytest.raises(ValueError, match="the places are in space"):
		forecast.probabilityMap([ofHill({0})]).draw()
