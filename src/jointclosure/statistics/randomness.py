"""Seeds and generators of random numbers; other modules make none of their own.

Every wall has a separate stream, named by the identity of the wall: adding, removing or reordering
cases changes no surface (docs/decisions.md#0007-surfaces).
"""

import hashlib

import numpy as np


def seed_of(root_seed: int, *name: str | int | float) -> int:
    """Return a 128-bit seed from a root seed and the ``name`` of a random quantity.

    The name has several parts, whose types count: 1 and 1.0 give different seeds.
    """
    text = "\x1f".join(repr(part) for part in (int(root_seed), *name))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:16], "big")


def generator(seed: int) -> np.random.Generator:
    """Return the random generator of a seed: PCG64, whose stream all versions of NumPy share."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))
