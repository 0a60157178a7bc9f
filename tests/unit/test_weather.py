# SPDX-License-Identifier: GPL-2.0-or-later
"""Weather series: what a file says arrives unchanged, what it must not say is refused with its line."""

import numpy as np
import pytest

from talik import weather

series = "# station\ntime [s],air temperature [degC],snow [m]\n0,-20.5,0.3\n\n86400,-19,0.3\n172800,2.25\n"


def written(folder, text):
	path = folder / "station.csv"
	path.write_text(text)
	return path


def test_a_series_is_read_as_it_stands_with_heading_comments_and_further_columns(tmp_path):
	times, values = weather.airTemperature(written(tmp_path, series))
	print(times, values)
	assert times == [0, 86400, 172800] and values == [-20.5, -19, 2.25]


def test_a_series_without_heading_keeps_its_first_line(tmp_path):
	assert weather.airTemperature(written(tmp_path, "0, 1\n5, 2\n")) == ([0, 5], [1, 2])


def test_hastened_heat_sees_the_series_as_much_faster_from_the_chosen_start(tmp_path):
	times, values = weather.airTemperature(written(tmp_path, series), start=86400)
	print(times)
	assert times == pytest.approx([-86400, 0, 86400]) and values == [-20.5, -19, 2.25]


@pytest.mark.parametrize(
	"text, message",
	[
		("time,temperature\n0,1\n5,warm\n", "line 3: air temperature 'warm' is not a number"),
		("0,1\n5,nan\n", "line 2: air temperature 'nan'"),
		("0,1\n\n5\n", "line 3: 1 column"),
		("0,1\n5,2\n5,3\n", "line 3: time 5 s follows 5 s; times must increase"),
		("0,1\n5,250\n", "line 2: air temperature 250 must lie between"),
		("time,temperature\n", "holds no data"),
		("", "holds no data"),
	],
)
def test_a_faulty_series_is_refused_with_file_and_line(tmp_path, text, message):
	with pytest.raises(ValueError) as refusal:
		weather.airTemperature(written(tmp_path, text))
	print(refusal.value)
	assert message in str(refusal.value) and "station.csv" in str(refusal.value)


def test_a_missing_file_is_refused(tmp_path):
	with pytest.raises(ValueError, match="cannot be read"):
		weather.airTemperature(tmp_path / "none.csv")


def test_degree_days_of_a_year_are_those_of_the_sine_and_n_factors_give_them_back():
	days = np.arange(0, 366)
	air = -3 + 12 * np.sin(2 * np.pi * days / 365)
	thawing, freezing = weather.degreeDays(days * 86400.0, air)
	fine = np.linspace(0, 365, 2_000_001)
	curve = -3 + 12 * np.sin(2 * np.pi * fine / 365)
	reference = [np.clip(sign * curve, 0, None).mean() * 365 for sign in (1, -1)]
	print(f"degree-days {thawing:.2f} and {freezing:.2f} of daily values, {reference[0]:.2f} and {reference[1]:.2f} of the sine; tolerance 0.05 %")
	assert (thawing, freezing) == pytest.approx(reference, rel=5e-4)
	surface = weather.surfaceTemperature(air, thawing=0.8, freezing=0.35)
	found = weather.nFactors(days * 86400.0, air, surface)
	print(f"n-factors {found[0]:.4f} and {found[1]:.4f}; exact 0.8 and 0.35 but for the two days that cross 0 degC")
	assert found == pytest.approx((0.8, 0.35), rel=2e-4)


@pytest.mark.parametrize(
	"call, words",
	[
		(lambda: weather.degreeDays([0, 0], [1, 2]), "times increasing"),
		(lambda: weather.degreeDays([0, 1], [1, np.nan]), "not finite"),
		(lambda: weather.surfaceTemperature([1], thawing=0), "thawing is 0"),
	],
)
def test_degree_days_and_n_factors_refuse_what_they_cannot_use(call, words):
	with pytest.raises(ValueError, match=words) as refusal:
		call()
	print(refusal.value)
