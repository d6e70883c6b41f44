"""The one place where random generators are made.

Every wall has its own stream, named by what the wall *is*: adding, removing
or reordering cases changes no surface (docs/decisions/0007-surfaces.md).
"""

import hashlib

import numpy as np


def seed_of(root_seed: int, *name: str | int | float) -> int:
    """A 128-bit seed from a root seed and the name of what is drawn."""
    text = "\x1f".join(repr(part) for part in (int(root_seed), *name))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:16], "big")


def generator(seed: int) -> np.random.Generator:
    """The generator of a seed: PCG64, whose stream numpy keeps stable."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))
