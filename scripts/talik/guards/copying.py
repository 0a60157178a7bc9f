# SPDX-License-Identifier: GPL-2.0-or-later
"""Copies of Talik's objects by Python's own means: copy.deepcopy(sample), pickle.dumps(mpm).

Stock YADE's objects have no copy that is whole: those of Python come out empty. Ours are copied as YADE archives them, with all that
they hold: a sample with its grains and bonds, a running ground with its state.
"""

import hashlib

from talik import _talik

digestSize = hashlib.sha256().digest_size


def makeCopyable(cls):
	"""Gives a class copies and pickles that are whole."""

	def __reduce_ex__(self, protocol):
		data = _talik.callBetweenSteps(_talik.objectToBytes, (self,), {})
		return _restored, (type(self).__name__, hashlib.sha256(data).digest() + data)

	cls.__reduce_ex__ = __reduce_ex__


def _restored(name, data):
	digest, data = data[:digestSize], data[digestSize:]
	if hashlib.sha256(data).digest() != digest:  # YADE's archives end the process on bytes that are not theirs
		raise ValueError(f"{name} cannot be restored: its pickled bytes are damaged; copy the original again")
	return _talik.objectFromBytes(data)
