#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The same work on every machine, so that processor times of tests can be compared between machines: scripts/test-times.py."""

import hashlib

numbers = {}
for round in range(2_000_000):
	numbers[round % 1000] = numbers.get(round % 1000, 0.5) * 1.0000001 + round
digest = hashlib.sha256()
for _ in range(200):
	digest.update(bytes(2**20))
print(f"{sum(numbers.values()):.6e} {digest.hexdigest()[:8]}")
