# SPDX-License-Identifier: GPL-2.0-or-later
"""A film of a slope in the plane:

	talik.movie.slope("output/thaw_slump_surface/frames.npz", "slump.gif", field="displacement")

The frames are those of talik.output.Frames, or the file that its save() wrote. A slide takes seconds of a calendar of months: frames that motion took
(byMotion of Frames) show it, and the pictures are chosen by what happened. A GIF needs nothing but Matplotlib and Pillow; .mp4 needs ffmpeg.
"""

import os
import tempfile
from pathlib import Path

import numpy as np
from matplotlib import animation
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from talik import output, plots, ranks
from talik.files import writableFolder, writeWhole

colours = 128  # of a GIF


def slope(frames, path, field="deviatoricStrain", framesPerSecond=5, watched=None, limits=(None, None), width=7.0, dpi=90, pictures=None):
	"""Writes the film and returns its path; in a job of several ranks rank 0 does.

	frames           list of frames of talik.output.Frames, at least one, or the path of a file that Frames.save wrote; ground in the plane
	path             of the film: .gif, or .mp4 where ffmpeg is installed
	field            of the frames, drawn as plots.ground does; vectors by their length. Several are drawn one above the other
	framesPerSecond  above 0; a GIF counts in hundredths of a second
	watched          {letter: id} points that are followed, or {letter: (x, y)} places [m]
	limits           (lowest, highest) value of the colours of the (first) field; None: from all frames
	width            of the picture [inch], and dpi its dots per inch
	pictures         at most so many, evenly over the motion (three quarters) and the time (a quarter); None: one of each frame

	All pictures have the same place and colours; the crimson line is the thaw front S_i = 0.5, the dashed one the ground at the start. ValueError names
	what is wrong.

	>>> frames = talik.output.Frames(mpm, times=[0])
	>>> frames.take()
	>>> film = talik.movie.slope(frames.frames, folder + "/slope.gif", field="displacement")"""
	frames = output.loadFrames(frames) if isinstance(frames, (str, os.PathLike)) else frames
	path, fields = Path(path), [field] if isinstance(field, str) else list(field)
	_check(frames, path, fields, framesPerSecond)
	if not ranks.first:
		return str(path)
	fig = plots.figure(width, width * len(fields) * _heightOverWidth(frames, 1.0 if len(fields) == 1 else 0.82) + 0.3)
	draw = plots.slopeFilm(fig, frames, fields, watched, limits)
	writableFolder(path.parent)
	with tempfile.TemporaryDirectory() as folder:
		whole = Path(folder, "film" + path.suffix.lower())
		_writers[path.suffix.lower()](fig, (draw(frame) for frame in _shown(frames, pictures)), whole, framesPerSecond, dpi)
		writeWhole(path, whole.read_bytes())
	return str(path)


def _shown(frames, pictures):
	"""Every one of so many equal steps of progress has the frame next to it."""
	if pictures is None or len(frames) <= pictures:
		return frames
	progress = output.progressOf(frames, byTime=0.25)
	places = [int(np.argmin(np.abs(progress - part))) for part in np.linspace(0, 1, pictures)]
	return [frames[place] for place in sorted(set(places))]


def _writeGif(fig, drawn, path, framesPerSecond, dpi):
	"""One palette for all pictures, so that a picture stores what differs from the one before."""
	fig.set_dpi(dpi)
	pictures, canvas = [], FigureCanvasAgg(fig)
	for _ in drawn:
		canvas.draw()
		pictures.append(np.asarray(canvas.buffer_rgba())[..., :3].copy())
		fig.set_layout_engine("none")  # the first one arranges the axes for all
	palette = _palette(pictures)
	film = [_withPalette(picture, palette) for picture in pictures]
	film[0].save(path, save_all=True, append_images=film[1:], duration=round(100 / framesPerSecond) * 10, loop=0, optimize=False)


def _palette(pictures):
	"""The colours (n, 3) that most pixels have: bands are of one colour each, so all of theirs are among them."""
	found, count = np.unique(np.concatenate([_numbered(picture) for picture in pictures[:: max(1, len(pictures) // 8)] + pictures[-1:]]), return_counts=True)
	return _coloursOf(found[np.argsort(-count)][:colours])


def _withPalette(picture, palette):
	"""Each pixel has the colour of the palette that is next to its own."""
	height, wide = picture.shape[:2]
	found, place = np.unique(_numbered(picture), return_inverse=True)
	nearest = np.argmin(((_coloursOf(found)[:, None] - palette) ** 2).sum(axis=2), axis=1)
	image = Image.fromarray(nearest[place].reshape(height, wide).astype(np.uint8), mode="P")
	image.putpalette(palette.astype(np.uint8).tobytes())
	return image


def _numbered(picture):
	return picture.reshape(-1, 3).astype(int) @ (1 << 16, 1 << 8, 1)


def _coloursOf(numbers):
	return np.column_stack([numbers >> 16, numbers >> 8 & 255, numbers & 255])


def _writeMp4(fig, drawn, path, framesPerSecond, dpi):
	film = animation.FFMpegWriter(fps=framesPerSecond)
	with film.saving(fig, path, dpi):
		for _ in drawn:
			film.grab_frame()


_writers = {".gif": _writeGif, ".mp4": _writeMp4}


def _check(frames, path, fields, framesPerSecond):
	if not len(frames):
		raise ValueError("frames is empty; give at least one frame of talik.output.Frames")
	for field in fields:
		if field not in frames[0]:
			known = sorted(name for name, values in frames[0].items() if getattr(values, "ndim", 0) in (1, 2))
			raise ValueError(f"field is '{field}', which the frames do not have; choose one of {', '.join(known)}")
	if not 0 < framesPerSecond <= 100:
		raise ValueError(f"framesPerSecond is {framesPerSecond}; give a number above 0, at most 100")
	if path.suffix.lower() not in _writers:
		raise ValueError(f"path is '{path}'; give a name that ends in {' or '.join(_writers)}")
	if path.suffix.lower() == ".mp4" and not animation.FFMpegWriter.isAvailable():
		raise ValueError(f"path is '{path}', which ffmpeg makes, and there is none here; install the package ffmpeg or give a name that ends in .gif")


def _heightOverWidth(frames, part):
	"""Of the picture of one field: the ground at its largest over a part of the width, title and colour bar."""
	low = [min(frame["position"][:, axis].min() for frame in frames) for axis in (0, 1)]
	high = [max(frame["position"][:, axis].max() for frame in frames) for axis in (0, 1)]
	return part * max((high[1] - low[1]) / max(high[0] - low[0], 1e-12), 0.2) + (0.1 if part == 1 else 0.07)
