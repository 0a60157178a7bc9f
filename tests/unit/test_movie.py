# SPDX-License-Identifier: GPL-2.0-or-later
"""Films from synthetic frames, read back with Pillow: as many pictures as frames, and what moves in the ground moves in the film."""

import numpy as np
import pytest
from matplotlib import colormaps
from PIL import Image

from talik import movie, output


def sliding(path, count=4):
	"""A block of 4 m above whose bottom a smaller one of 1 m, which alone has the largest value, slides by `path` from frame to frame."""
	side = (np.arange(16) + 0.5) / 4
	position = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
	mover = (position < 1).all(axis=1)
	position[mover] += (0, 4)
	value = mover.astype(float)
	slid = mover[:, None] * np.array([path, 0.0])
	return [
		dict(time=0.5 * k, position=position + k * slid, volume=np.full(256, 1 / 16), value=value, velocity=position, displacement=k * slid)
		for k in range(count)
	]


def pictures(path):
	with Image.open(path) as film:
		found = []
		for k in range(film.n_frames):
			film.seek(k)
			found.append((np.asarray(film.convert("RGB"), dtype=float), film.info["duration"]))
	return found


def middleOf(picture, colour, which=np.mean):
	"""Column of the pixels of a colour, above the colour bar."""
	near = np.linalg.norm(picture - colour, axis=2) < 30
	near[int(0.75 * len(near)) :] = False
	near[:, near.sum(axis=0) < 8] = False  # letters
	return which(np.argwhere(near)[:, 1])


def test_a_film_has_a_picture_for_each_frame_at_the_rate_asked_for_and_what_slides_slides_in_it(tmp_path):
	frames = sliding(path=1.0)
	film = pictures(movie.slope(frames, tmp_path / "block.gif", field="value", framesPerSecond=4, dpi=80))
	yellow, blue = (255 * np.array(colormaps["viridis"](value)[:3]) for value in (1.0, 0.0))
	columns = np.array([middleOf(picture, yellow) for picture, _ in film])
	metre = (middleOf(film[0][0], blue, np.max) - middleOf(film[0][0], blue, np.min)) / 4  # pixels: the block is 4 m wide
	paths = np.diff(columns) / metre
	print(
		f"{len(film)} pictures of {film[0][0].shape[1]} x {film[0][0].shape[0]}, {film[0][1]} ms each; the small block slides by {paths} m a picture, 1 m given"
	)
	assert len(film) == 4 and {duration for _, duration in film} == {250}
	assert {picture.shape for picture, _ in film} == {film[0][0].shape}
	np.testing.assert_allclose(paths, 1.0, atol=0.06)


def test_a_film_of_a_file_of_frames_is_that_of_the_frames(tmp_path):
	class Ground:
		calendar = None

	kept = output.Frames(Ground(), [0])
	kept.frames = sliding(path=0.5, count=2)
	kept.save(tmp_path / "frames.npz")
	one, other = (pictures(movie.slope(frames, tmp_path / "film.gif", field="velocity")) for frames in (kept.frames, tmp_path / "frames.npz"))
	assert len(one) == len(other) == 2 and all((a == b).all() for (a, _), (b, _) in zip(one, other))


@pytest.mark.parametrize(
	"change, sentence",
	[
		(dict(frames=[]), "frames is empty"),
		(dict(field="ice"), "field is 'ice', which the frames do not have; choose one of displacement, position, value, velocity, volume"),
		(dict(path="film.avi"), "path is 'film.avi'; give a name that ends in .gif or .mp4"),
		(dict(framesPerSecond=0), "framesPerSecond is 0; give a number above 0"),
	],
)
def test_a_film_that_cannot_be_is_refused_by_a_sentence(change, sentence):
	with pytest.raises(ValueError, match=sentence):
		movie.slope(**{"frames": sliding(path=1.0), "path": "film.gif", "field": "value", **change})


def test_a_film_of_a_slide_between_two_days_shows_the_slide():
	"""Of 200 days a slide takes a tenth of one, and is most of what happened."""
	days = np.unique(np.concatenate([np.arange(0.0, 201, 2), 100 + np.linspace(0, 0.1, 51)]))
	moved = np.clip((days - 100) / 0.1, 0, 1)
	block = sliding(path=1.0, count=1)[0]
	frames = [{**block, "day": day, "displacement": path * np.ones((256, 2))} for day, path in zip(days, moved)]
	shown = movie._shown(frames, 40)
	inSlide = sum(100 <= frame["day"] <= 100.1 for frame in shown)
	largest = np.abs(np.diff([frame["displacement"][0, 0] for frame in shown])).max()
	print(f"{len(shown)} pictures of {len(frames)} frames, {inSlide} of them within the slide; it jumps by at most {largest:.2f} of its path")
	assert 30 <= len(shown) <= 40 and 25 <= inSlide <= 35 and largest < 0.06
	assert shown[0] is frames[0] and shown[-1]["day"] == 200


def test_several_fields_are_drawn_one_above_the_other(tmp_path):
	one, two = (
		pictures(movie.slope(sliding(path=0.5, count=2), tmp_path / "film.gif", field=field))[0][0].shape for field in ("value", ("value", "displacement"))
	)
	print(f"one field {one[1]} x {one[0]}, two {two[1]} x {two[0]}")
	assert two[1] == one[1] and 1.5 * one[0] < two[0] < 2 * one[0]  # their colour bars stand beside them


def test_where_ffmpeg_lacks_an_mp4_is_refused_with_the_remedy(monkeypatch):
	monkeypatch.setattr(movie.animation.FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
	with pytest.raises(ValueError, match="install the package ffmpeg or give a name that ends in .gif"):
		movie.slope(sliding(path=1.0), "film.mp4", field="value")
