# SPDX-License-Identifier: GPL-2.0-or-later
"""Run by a yade of its own: prepares one realisation, as talik.realisation asks, and leaves it in the cache."""

import json
import os

from talik import rve
from talik.realisation import doneMark, refusalMark


def main():
	call = json.loads(os.environ["TALIK_PREPARE"])
	try:
		rve.prepare(**{**call, "radius": tuple(call["radius"])})
	except Exception as error:
		print(f"{refusalMark}{' '.join(str(error).split())}", flush=True)
		return
	print(doneMark, flush=True)


if __name__ == "__main__":
	main()
