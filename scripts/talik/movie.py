# SPDX-License-Identifier: GPL-2.0-or-later
"""A film of a slope in the plane, a picture of it at each time that was kept:

	talik.movie.slope("output/thaw_slump_surface/frames.npz", "slump.gif", field="displacement")

The frames are those of talik.output.Frames, or the file that its save() wrote. A GIF needs nothing but Matplotlib; .mp4 needs ffmpeg.
"""

import os
import tempfile
from pathlib import Path

from matplotlib import animation

from talik import output, plots, ranks
from talik.files import writableFolder, writeWhole

_writers = {".gif": animation.PillowWriter, ".mp4": animation.FFMpegWriter}


def slope(frames, path, field="deviatoricStrain", framesPerSecond=5, watched=None, limits=(None, None), width=7.0, dpi=90):
	"""Writes the film and returns its path; in a job of several ranks rank 0 does.

	frames           list of frames of talik.output.Frames, at least one, or the path of a file that Frames.save wrote; ground in the plane
	path             of the film: .gif, or .mp4 where ffmpeg is installed
	field            of the frames, by which points are coloured; vectors by their length
	framesPerSecond  above 0; a GIF counts in hundredths of a second
	watched          {letter: id} points that are followed, or {letter: (x, y)} places [m]
	limits           (lowest, highest) value of the colours; None: from all frames
	width            of the picture [inch], and dpi its dots per inch

	All pictures have the same place and colours; the crimson line is the thaw front S_i = 0.5. ValueError names what is wrong.

	>>> frames = talik.output.Frames(mpm, times=[0])
	>>> frames.take()
	>>> film = talik.movie.slope(frames.frames, folder + "/slope.gif", field="displacement")"""
	frames = output.loadFrames(frames) if isinstance(frames, (str, os.PathLike)) else frames
	path = Path(path)
	_check(frames, path, field, framesPerSecond)
	if not ranks.first:
		return str(path)
	fig = plots.figure(width, width * _heightOverWidth(frames))
	draw = plots.slopeFilm(fig, frames, field, watched, limits)
	writableFolder(path.parent)
	with tempfile.TemporaryDirectory() as folder:
		whole = Path(folder, "film" + path.suffix.lower())
		film = _writers[path.suffix.lower()](fps=framesPerSecond)
		with film.saving(fig, whole, dpi):
			for frame in frames:
				draw(frame)
				film.grab_frame()
		writeWhole(path, whole.read_bytes())
	return str(path)


def _check(frames, path, field, framesPerSecond):
	if not len(frames):
		raise ValueError("frames is empty; give at least one frame of talik.output.Frames")
	if field not in frames[0]:
		known = sorted(name for name, values in frames[0].items() if getattr(values, "ndim", 0) in (1, 2))
		raise ValueError(f"field is '{field}', which the frames do not have; choose one of {', '.join(known)}")
	if not 0 < framesPerSecond <= 100:
		raise ValueError(f"framesPerSecond is {framesPerSecond}; give a number above 0, at most 100")
	writer = _writers.get(path.suffix.lower())
	if writer is None:
		raise ValueError(f"path is '{path}'; give a name that ends in {' or '.join(_writers)}")
	if not writer.isAvailable():
		raise ValueError(f"path is '{path}', which ffmpeg makes, and there is none here; install the package ffmpeg or give a name that ends in .gif")


def _heightOverWidth(frames):
	"""Of the whole picture: the ground at its largest, title and colour bar."""
	low = [min(frame["position"][:, axis].min() for frame in frames) for axis in (0, 1)]
	high = [max(frame["position"][:, axis].max() for frame in frames) for axis in (0, 1)]
	return max((high[1] - low[1]) / max(high[0] - low[0], 1e-12), 0.2) + 0.25
