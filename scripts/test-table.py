#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Prints what the tests measured: usage  test-table.py <JUnit file of ctest>.

Rows "case: figure | measured | reference | error | tolerance | source" of all tests end up in one table."""

import re
import sys
import xml.etree.ElementTree as ElementTree

# Lines by which a test program talks about itself, not about what it measured.
scaffold = re.compile(
	r"^\s*$|^\[[-=\s\w]+\]|^Running main\(\)|^Note: Google Test|^=+ .* =+$|^(platform|rootdir|plugins|cachedir|collected|configfile)\b"
	r"|^Welcome to Yade|^Using python version|^TCP python prompt|^XMLRPC info|^Running script|^\s*\[\s*\d+%\]$"
	r"|^\d+ (passed|failed).* in .*s"
)


requirement = re.compile(r"^\[ RUN\s+\] (\S+)")  # of GoogleTest; pytest's names come as lines of their own


row = re.compile(r"^[^|]+(\|[^|]*){4}\|[^|]*$")


def measuredLines(text):
	lines = (requirement.sub(r"\1", line.rstrip()) for line in (text or "").splitlines())
	return [line for line in lines if not scaffold.match(line)]


def outcome(case):
	if case.find("failure") is not None or case.get("status") == "fail":
		return "FAILED"
	if case.find("skipped") is not None or case.get("status") in ("disabled", "notrun"):
		return "NOT RUN"
	return "ok"


def _reason(case):
	"""What ctest says of a failure: its exit status, a signal or the time it was given."""
	failure = case.find("failure")
	return (failure.get("message") if failure is not None else "") or "no reason given"


def _ending(case, lines=60):
	"""Last lines of a failed test, repeated at the end, where whoever reads a long log looks first."""
	return [line.rstrip() for line in (case.findtext("system-out") or "").splitlines() if line.strip()][-lines:]


def main(path):
	try:
		cases = ElementTree.parse(path).getroot().findall("testcase")
	except (OSError, ElementTree.ParseError) as error:
		sys.exit(f"test-table.py: no test report in {path}: {error}")
	print("\nWhat the tests measured")
	rows = []
	for case in cases:
		state = outcome(case)
		print(f"\n{state:8s}{case.get('name')}  ({float(case.get('time', 0)):.1f} s)")
		if state == "ok":
			lines = measuredLines(case.findtext("system-out"))
			rows += [line for line in lines if row.match(line)]
			for line in lines if not any(map(row.match, lines)) else ():
				print("        " + line)
	rows = [line for line in dict.fromkeys(rows) if not line.startswith("case ")]
	if rows:
		print(f"\n{'case: figure':80s} | {'measured':>13s} | {'reference':>13s} | {'error':>10s} | {'tolerance':>8s} | source\n" + "\n".join(rows))
	failed = [case.get("name") for case in cases if outcome(case) != "ok"]
	seconds = sum(float(case.get("time", 0)) for case in cases)
	for case in cases:
		if outcome(case) == "FAILED":
			print(f"\nThe end of what {case.get('name')} said ({_reason(case)}):\n" + "\n".join(f"        {line}" for line in _ending(case)))
	print(f"\n{len(cases) - len(failed)} of {len(cases)} tests passed in {seconds:.0f} s" + (f"; not passed: {', '.join(failed)}" if failed else ""))


if __name__ == "__main__":
	if len(sys.argv) != 2:
		sys.exit(__doc__)
	main(sys.argv[1])
