# SPDX-License-Identifier: GPL-2.0-or-later
"""Pages of figures of a slump, to be laid beside Figs 4, 6, 7 and 8 of Yu & Zhao.

	page        S_i, deviatoric strain and displacement at four times; samples of two points: force chains by bond state, contact normals
	sideBySide  runs of one slope that differ in one thing: fields at the end, displacement over time, broken bonds, bill
	draw        the pictures of a run from the files in its folder, without the run
	film        the same of a film
"""

import json
from pathlib import Path

import numpy as np

import talik
from talik import movie, output, packing, plots
from thawslump import shearband
from thawslump.settings import widened

pageTimes, filmPictures = 4, 40
linesOfPictures = "crimson: thaw front, $S_i$ = 0.5; dashed: ground at the start; arrows: direction of displacement"
framesName, samplesName, summaryName = "frames.npz", "samples.npz", "summary.json"  # what a run leaves in its folder to be drawn from


def sampleOf(skeleton, point):
	"""Grains, contacts, forces and bond states of the sample behind a point, as talik.packing.sampleArrays gives them."""
	with talik.inspect(skeleton.sample(point).open()):
		return packing.sampleArrays()


def saveSamples(path, samples, watched):
	"""One compressed NumPy file of {letter: arrays of sampleOf} and {letter: id}; loadSamples(path) reads both back."""
	arrays = {f"{letter}/{name}": values for letter, sample in samples.items() for name, values in sample.items()}
	np.savez_compressed(path, **arrays, **{f"{letter}/point": point for letter, point in watched.items()})


def loadSamples(path):
	"""(samples, watched) that saveSamples wrote; both empty where there is no such file, as of ground without samples."""
	samples, watched = {}, {}
	if Path(path).exists():
		with np.load(path) as file:
			for key in file.files:
				letter, name = key.split("/", 1)
				if name == "point":
					watched[letter] = int(file[key])
				else:
					samples.setdefault(letter, {})[name] = file[key]
	return samples, watched


def summaryOf(folder):
	"""Named results of the run whose folder it is."""
	return json.loads((Path(folder) / summaryName).read_text())


def outlineOf(folder, outline):
	"""The outline of a case as the run in a folder had it, whose grid may lie a little differently."""
	if not (Path(folder) / summaryName).exists():
		return outline
	summary = summaryOf(folder)
	return widened(outline, summary["preset.gridSpacing"], summary.get("preset.gridOffset", 0))


def draw(folder, outline, threshold=0.2):
	"""slope.png, page.png and calendar.png from frames.npz, samples.npz and summary.json in the folder of a run.

	outline, threshold  as for shearband.measure
	FileNotFoundError where no run left its results."""
	folder = Path(folder)
	if not (folder / framesName).exists():
		raise FileNotFoundError(f"{folder} holds no {framesName} to draw from: give the folder in which a run left its results (--output)")
	frames, (samples, watched) = output.loadFrames(folder / framesName), loadSamples(folder / samplesName)
	told = output.telling(frames[1:], pageTimes)
	summary = summaryOf(folder)
	title = f"{summary['case']}; {slipSurfaces(frames[-1], outline, threshold)}\n{linesOfPictures}"
	fig = plots.slopeHistory(told)
	fig.suptitle(title, fontsize=11)
	plots.save(fig, folder / "slope.png", dpi=100)
	plots.save(page(told, samples, watched, title), folder / "page.png", dpi=80)
	fig = plots.figure(7, 3.2)
	looked = [(frame["day"], frame["time"], plots.magnitude(frame["displacement"]).max()) for frame in frames]
	plots.calendarHistory(fig.subplots(), sorted([*map(tuple, summary["history"]), *looked]), summary["events"])
	plots.save(fig, folder / "calendar.png")


def film(folder):
	"""film.gif from the frames in the folder of a run: ice saturation above displacement."""
	folder = Path(folder)
	frames = output.loadFrames(folder / framesName)
	return movie.slope(frames, folder / "film.gif", field=("iceSaturation", "displacement"), pictures=filmPictures, framesPerSecond=8, width=7.2, dpi=100)


def page(frames, samples=None, watched=None, title=None):
	"""The page of one case.

	frames   of talik.output.Frames, four or fewer; talik.output.telling chooses such
	samples  {letter: arrays of sampleOf}, drawn below the slope
	watched  {letter: id} points marked on the slope
	Returns the figure."""
	samples = samples or {}
	slopeHeight, sampleHeight = plots.historyHeight(frames) + 0.4, 4.0 if samples else 0.0
	fig = plots.figure(12.6, slopeHeight + sampleHeight)
	upper, lower = fig.subfigures(2, 1, height_ratios=(slopeHeight, sampleHeight)) if samples else (fig.subfigures(1, 1), None)
	plots.slopeHistory(frames, watched=watched, into=upper)
	for place, (letter, sample) in enumerate(samples.items()):
		_drawSample(lower, place, 2 * len(samples), letter, sample, frames[-1], (watched or {}).get(letter))
	if title:
		fig.suptitle(title, fontsize=11)
	return fig


def _drawSample(fig, place, columns, letter, sample, frame, point):
	chains, rose = fig.add_subplot(1, columns, 2 * place + 1), fig.add_subplot(1, columns, 2 * place + 2, projection="polar")
	plots.sampleForces(chains, sample)
	chains.set_title(f"{letter}: {_stateOf(frame, point)}", fontsize=9)
	plots.normalRose(rose, sample["normal"], bins=24)


def _stateOf(frame, point):
	if point is None:
		return "sample"
	bonded, ice = shearband.frozen(frame)[point], frame["iceSaturation"][point]
	state = ("frozen" if ice >= 0.5 else "thawing") if bonded else "thawed"
	share = frame["bondsBroken"][point] / max(frame["bondsFormed"][point], 1)
	return f"{state}, $S_i$ = {ice:.2f}, $\\varepsilon_d$ = {frame['deviatoricStrain'][point]:.2f}\n{100 * share:.0f} % of its bonds broke mechanically"


def sideBySide(runs, outline, fields=("iceSaturation", "deviatoricStrain", "displacement"), threshold=0.2):
	"""One row for each run: its fields at the end, under them all runs: largest displacement and broken bonds over time.

	runs  {label: (frames, bill)}; label says what differs, bill what the run cost
	Returns the figure."""
	ends = [frames[-1] for frames, _ in runs.values()]
	slopeHeight = plots.historyHeight(ends) + 0.3 + 0.2 * len(ends)
	fig = plots.figure(12.6, slopeHeight + 3.2)
	upper, lower = fig.subfigures(2, 1, height_ratios=(slopeHeight, 3.2))
	plots.slopeHistory(ends, fields=fields, into=upper)
	upper.suptitle(plots.timeLabel(ends[0]["time"], ends[0].get("day")), fontsize=11)
	rows = [axes for axes in upper.axes if axes.get_title(loc="left")]
	moved, broken = lower.subplots(1, 2)
	for axes, (label, (frames, bill)) in zip(rows, runs.items()):
		axes.set_title("", loc="left")
		heading = f"{label}: {bill}; {slipSurfaces(frames[-1], outline, threshold)}"
		axes.text(0, 1.04, heading, transform=axes.transAxes, fontsize=9, in_layout=False)  # it is wider than its column
		times = [frame.get("day", frame["time"]) for frame in frames]
		moved.plot(times, [np.linalg.norm(frame["displacement"], axis=1).max() for frame in frames], marker="o", markersize=3, label=label)
		if "bondsFormed" in frames[0]:
			broken.plot(times, [100 * shearband.brokenShare(frame, slice(None)) for frame in frames], marker="o", markersize=3, label=label)
	moved.set(xlabel="day", ylabel="largest displacement [m]")
	moved.set_ylim(bottom=0)
	moved.legend(fontsize=8, frameon=False)
	broken.set(xlabel="day", ylabel="bonds broken mechanically [%]", ylim=(0, None))
	if not any("bondsFormed" in frames[0] for frames, _ in runs.values()):
		broken.set_visible(False)
	return fig


def slipSurfaces(frame, outline, threshold=0.2):
	"""Inclination and depth of the shear bands in frozen and in all ground, in words."""
	bands = {ground: shearband.measure(frame, outline, threshold, among) for ground, among in (("frozen", None), ("all", True))}
	found = [f"{band.inclination:.0f}° in {ground} ground, to {band.depth:.1f} m deep" for ground, band in bands.items() if band is not None]
	return "slip surface " + ", ".join(found) if found else "no slip surface"
