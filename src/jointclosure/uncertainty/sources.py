"""Sources of uncertainty of a joint, and the changes of a result that they make."""

from typing import Any, NamedTuple

import numpy as np

from jointclosure.parameters import OF_ROCK

ORDER = "order"  # source of another order of breakage: copies that differ in rounding, or mirrored
TITLES = {
    "spacing": "grid spacing",
    "breakage": "numerical error",
    "registration": "registration",
    "noise": "noise of the scans",
    "resolution": "waves that the scans lost",
    "scale": "scale of heights",
    "holes": "missing heights",
    ORDER: "order of breakage",
    "peak_modulus_ratio": "peak modulus ratio",
    "base_radius_in_cells": "base radius",
    "peaks": "choice of soft peaks",
} | {name: about.long_name for name, about in OF_ROCK.items()}
"""Sources of uncertainty by name."""
ALL = "all together"  # source of the variants in which all sources have random values
MULTIPLE = "multiple"
"""Kind of a source with the value of the joint, a multiple of it, or its inverse, whose change is
opposite."""
SHARED = "shared"  # kind of a source whose second value all variants have


class Source(NamedTuple):
    """A source of uncertainty, by its kind.

    ``values`` are the ends of a "range", the alternatives of a "choice" with that of the joint
    first, or the draws of a "random" source with that of the joint (none) first. All variants of
    other sources have the second value of a "shared" source, and are compared with the joint that
    differs by it alone. A source that is not ``varied`` is a choice of the model: it is changed
    alone, and is no part of the range.
    """

    values: tuple
    kind: str = "choice"
    varied: bool = True
    usual: float = 0.5  # share of a "range" at which the joint lies

    def at(self, share: float) -> Any:
        """Return the value at a share, in [0, 1), of its range or of its alternatives."""
        if self.kind == "random":
            return len(self.values) + int(share * 2**32)  # another draw
        if self.kind == "choice":
            return self.values[int(share * len(self.values))]
        low, high = self.values
        return low * (high / low) ** share if low > 0.0 else low + share * (high - low)

    def changes_at(self, changes: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """Return the expected change of a result at shares (n,), from that at each value (k,)."""
        if self.kind == "random":
            return np.zeros(shares.shape)
        changes = np.nan_to_num(changes)  # what is not known counts as 0
        if self.kind == "range":
            return np.interp(shares, [0.0, self.usual, 1.0], [changes[0], 0.0, changes[1]])
        if self.kind == SHARED:  # the error may as well have the other sign
            return (2.0 * shares - 1.0) * changes[0]
        if self.kind == MULTIPLE:
            return np.array([-changes[0], 0.0, changes[0]])[(3.0 * shares).astype(int)]
        return np.append(0.0, changes)[(shares * len(self.values)).astype(int)]
