# SPDX-License-Identifier: GPL-2.0-or-later
"""Films from synthetic frames, read back with Pillow: as many pictures as frames, and what moves in the ground moves in the film."""

import numpy as np
import pytest
from matplotlib import colormaps
from PIL import Image

from talik import movie, output


def sliding(path, count=4):
	"""A block of 4 m whose last point alone has the largest value and slides by `path` from frame to frame."""
	side = (np.arange(16) + 0.5) / 4
	position = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
	value = np.where(np.arange(256) == 255, 1.0, 0.0)
	mover = (np.arange(256) == 255)[:, None] * np.array([path, 0.0])
	return [dict(time=0.5 * k, position=position + k * mover, volume=np.full(256, 1 / 16), value=value, velocity=position) for k in range(count)]


def pictures(path):
	with Image.open(path) as film:
		found = []
		for k in range(film.n_frames):
			film.seek(k)
			found.append((np.asarray(film.convert("RGB"), dtype=float), film.info["duration"]))
	return found


def middleOf(picture, colour):
	"""Column of the pixels of a colour, above the colour bar."""
	near = np.linalg.norm(picture - colour, axis=2) < 30
	near[int(0.75 * len(near)) :] = False
	return np.argwhere(near)[:, 1].mean()


def test_a_film_has_a_picture_for_each_frame_at_the_rate_asked_for_and_what_slides_slides_in_it(tmp_path):
	frames = sliding(path=1.0)
	film = pictures(movie.slope(frames, tmp_path / "block.gif", field="value", framesPerSecond=4, dpi=80))
	yellow = 255 * np.array(colormaps["viridis"](1.0)[:3])
	columns = np.array([middleOf(picture, yellow) for picture, _ in film])
	blue = np.linalg.norm(film[0][0] - 255 * np.array(colormaps["viridis"](0.0)[:3]), axis=2) < 30
	blue[int(0.75 * len(blue)) :] = False
	metre = np.ptp(np.flatnonzero(blue.sum(axis=0) > 20)) / 4  # pixels: the block is 4 m wide
	paths = np.diff(columns) / metre
	print(f"{len(film)} pictures of {film[0][0].shape[1]} x {film[0][0].shape[0]}, {film[0][1]} ms each; the point slides by {paths} m a picture, 1 m given")
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
		(dict(field="ice"), "field is 'ice', which the frames do not have; choose one of position, value, velocity, volume"),
		(dict(path="film.avi"), "path is 'film.avi'; give a name that ends in .gif or .mp4"),
		(dict(framesPerSecond=0), "framesPerSecond is 0; give a number above 0"),
	],
)
def test_a_film_that_cannot_be_is_refused_by_a_sentence(change, sentence):
	with pytest.raises(ValueError, match=sentence):
		movie.slope(**{"frames": sliding(path=1.0), "path": "film.gif", "field": "value", **change})


def test_where_ffmpeg_lacks_an_mp4_is_refused_with_the_remedy(monkeypatch):
	monkeypatch.setattr(movie._writers[".mp4"], "isAvailable", classmethod(lambda cls: False))
	with pytest.raises(ValueError, match="install the package ffmpeg or give a name that ends in .gif"):
		movie.slope(sliding(path=1.0), "film.mp4", field="value")
