# SPDX-License-Identifier: GPL-2.0-or-later
"""Dates of a scene: its calendar counts days, and the first of them may have a date.

	talik.dates.start("2024-05-15")                # day 0 of every calendar in this scene; saved with it
	talik.runUntilDay(mpm, talik.dates.dayOf("2024-09-30"))
	print(talik.dates.today(mpm), talik.dates.events(mpm))

Tables of talik.output then have a column of dates, and tables of weather and observations may be given with dates.
Dates are ISO 8601, 2024-05-15 or 2024-05-15T12:00, all in one time zone.
"""

from datetime import datetime, timedelta

secondsPerDay = 86400.0
_tag = "startDate"  # O.tags are saved with a scene


def start(date):
	"""Gives day 0 of the calendars of the scene in O a date.

	>>> talik.dates.start("2024-05-15")"""
	from yade import O

	O.tags[_tag] = _parsed(date).isoformat()


def started():
	"""Date of day 0; None where none was given.

	>>> talik.dates.start("2024-05-15")
	>>> talik.dates.started()
	'2024-05-15'"""
	first = _first()
	return None if first is None else _text(first)


def dayOf(date):
	"""Day of the calendar of a date; a number, or the text of one, is a day already.

	>>> talik.dates.start("2024-05-15")
	>>> talik.dates.dayOf("2024-06-01T12:00")
	17.5"""
	try:
		return float(date)
	except (TypeError, ValueError):
		pass
	first = _first()
	if first is None:
		raise ValueError(f"'{date}' is a date, and the scene has none for its day 0; give it by talik.dates.start('2024-05-15'), or give days of the calendar")
	return (_parsed(date) - first).total_seconds() / secondsPerDay


def dateOf(day, first=None):
	"""Date of a day of the calendar, with minutes where it is not midnight; first: date of day 0, default that of the scene.

	>>> talik.dates.start("2024-05-15")
	>>> talik.dates.dateOf(17.5)
	'2024-06-01T12:00'"""
	first = _first() if first is None else _parsed(first)
	if first is None:
		raise ValueError("dates.dateOf: the scene has no date for its day 0; give it by talik.dates.start('2024-05-15')")
	return _text(first + timedelta(days=day))


def today(mpm):
	"""Date of the calendar of a ground.

	>>> talik.dates.start("2024-05-15")
	>>> talik.dates.today(mpm)[:7]
	'2024-05'"""
	return dateOf(mpm.calendar["day"])


def events(mpm):
	"""mpm.events(), each with its date.

	>>> sliding = MpmEngine(gridSpacing=0.5, skeleton=ElasticSkeleton(), heat=HeatTransfer(followsMotion=True))
	>>> added = talik.geometry.fill(sliding, talik.geometry.rectangle(0, 0, 1, 1))
	>>> talik.dates.start("2024-05-15")
	>>> talik.dates.events(sliding)
	[]"""
	return [{"date": dateOf(event["day"]), **event} for event in mpm.events()]


def _first():
	from yade import O

	return datetime.fromisoformat(O.tags[_tag]) if _tag in O.tags.keys() else None


def _text(moment):
	moment = (moment + timedelta(seconds=30)).replace(second=0, microsecond=0)
	return moment.date().isoformat() if (moment.hour, moment.minute) == (0, 0) else moment.isoformat(timespec="minutes")


def _parsed(date):
	try:
		moment = datetime.fromisoformat(str(date).strip().removesuffix("Z"))
	except ValueError:
		moment = None
	if moment is None or moment.tzinfo is not None:
		raise ValueError(f"'{date}' is no date without a time zone; write it like 2024-05-15 or 2024-05-15T12:00")
	return moment
