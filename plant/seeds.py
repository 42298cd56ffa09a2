"""Named random streams of one root seed.

Draw i of a stream is a pure function of (root, stream name, i): it does not depend on how many others are drawn, in which
order, by which worker or for which controller. Streams with different names never overlap, so search scenarios and
held-out scenarios cannot be confused.
"""

from collections.abc import Callable
from hashlib import blake2b
from typing import TypeAlias

import numpy as np

RandomSource: TypeAlias = Callable[[str, int], np.random.Generator]
"""Gives a fresh generator for a part of a flight, such as "air", and the number of the flight."""


def generator(root: int, stream: str, index: int) -> np.random.Generator:
    """Return the generator of item `index` of a named stream of the root seed."""
    name = int.from_bytes(blake2b(stream.encode(), digest_size=8).digest(), "little")
    return np.random.Generator(np.random.PCG64DXSM(np.random.SeedSequence((root, name, index))))


def source_of(root: int, stream: str) -> RandomSource:
    """Return the source of a named stream: part `air` of flight i is item i of `stream/air`."""
    return lambda part, index: generator(root, f"{stream}/{part}", index)
