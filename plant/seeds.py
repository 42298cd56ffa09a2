"""Named random streams of one root seed.

Draw i of a stream is a pure function of (root, stream name, i): it does not depend on how many others are drawn, in which
order, by which worker or for which controller. Streams with different names never overlap, so search scenarios and
held-out scenarios cannot be confused.
"""

from hashlib import blake2b

import numpy as np


def generator(root: int, stream: str, index: int) -> np.random.Generator:
    """Return the generator of item `index` of a named stream of the root seed."""
    name = int.from_bytes(blake2b(stream.encode(), digest_size=8).digest(), "little")
    return np.random.Generator(np.random.PCG64DXSM(np.random.SeedSequence((root, name, index))))
