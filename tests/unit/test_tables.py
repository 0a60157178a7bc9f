# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of a survey: what a file says arrives at its place, what it must not say is refused with its line."""

import numpy as np
import pytest
from talik import tables

hill = [(0, 0), (10, 0), (10, 2), (6, 2), (4, 5), (0, 5)]


def written(folder, text):
	path = folder / "survey.csv"
	path.write_text(text)
	return path


def test_corners_of_a_survey_are_an_outline_with_and_without_the_first_one_repeated(tmp_path):
	text = "# by total station\nx [m],y [m],remark\n0,0,peg\n4,0,\n4,2.5,\n"
	for end in ("", "0,0,\n"):
		assert tables.outline(written(tmp_path, text + end)) == [(0, 0), (4, 0), (4, 2.5)]


def test_a_borehole_gives_each_place_the_value_of_its_depth_below_an_uneven_surface(tmp_path):
	temperature = tables.ofDepth(written(tmp_path, "0,-1\n2,-3\n4,-2\n"), hill, "temperature")
	x, y = np.array([1.0, 1.0, 5.0, 8.0, 8.0]), np.array([5.0, 4.0, 2.5, 1.0, 0.0])  # depths 0, 1, 1, 1, 2
	print(temperature(x, y))
	assert temperature(x, y) == pytest.approx([-1, -2, -2, -2, -3], abs=1e-12)


def test_scattered_places_of_a_plane_give_that_plane_between_them_and_the_nearest_value_outside(tmp_path):
	rows = "".join(f"{x},{y},{3 * x - 2 * y}\n" for x, y in ((0, 0), (10, 0), (10, 6), (0, 6), (3, 2)))
	value = tables.ofPlace(written(tmp_path, "x,y,pressure [Pa]\n" + rows))
	x, y = np.array([1.0, 4.5, 7.0, 12.0]), np.array([1.0, 3.5, 5.0, -1.0])
	assert value(x, y) == pytest.approx([1, 6.5, 11, 30], abs=1e-9)


@pytest.mark.parametrize(
	"call, text, message",
	[
		(tables.outline, "0,0\n1,0\n", "has 2 corners"),
		(tables.outline, "x,y\n0,0\n1\n", "line 3: 1 column instead of x, y"),
		(tables.outline, "0,0\n1,zero\n2,2\n", "line 2: y 'zero' is not a number"),
		(lambda path: tables.ofDepth(path, hill), "0,1\n2,2\n1,3\n", "line 3: depth 1 m follows 2 m"),
		(lambda path: tables.ofDepth(path, hill), "depth,value\n", "holds no data"),
		(tables.ofPlace, "0,0,1\n1,1,2\n2,2,3\n", "do not lie on one line"),
	],
)
def test_a_faulty_table_is_refused_with_file_and_fault(tmp_path, call, text, message):
	with pytest.raises(ValueError) as refusal:
		call(written(tmp_path, text))
	print(refusal.value)
	assert message in str(refusal.value) and "survey.csv" in str(refusal.value)
