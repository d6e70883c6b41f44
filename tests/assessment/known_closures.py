"""Closures of an assessment with known differences, for the tests of its results."""

import numpy as np
import pandas as pd

from jointclosure.assessment.assessed_results import ASSESSED
from jointclosure.assessment.hardness import FEATURES

LADDER = ["coarse", "middle", "fine"]


def closures(effect=0.0, coarse=0.1, middle=0.02, scatter=0.01, joints=10, **changes):
    """Closures of three settings and of a scene without an effect, with known differences."""
    random = np.random.default_rng(3)
    rows = []
    settings = {"coarse": coarse, "middle": middle, "fine": 0.0, "without gouge": middle + effect}
    for joint in range(joints):
        own = random.normal(1e-4, 2e-5)
        for copy in ("as it is", "mirrored"):
            for variant, bias in settings.items():
                if copy == "mirrored" and joints > 1 and variant != "middle":
                    continue
                value = own * (1.0 + bias + scatter * random.normal())
                row = {"variant": variant, "joint": joint, "copy_of_walls": copy, "cycle": 1}
                row |= {"status": 0, "seconds": 1.0 + 9.0 * (variant == "fine"), "error": ""}
                row |= {"oracle_ratio": 0.5} | dict.fromkeys(FEATURES[:-1], 0.0)
                rows.append(row | dict.fromkeys(ASSESSED, value))
    return pd.DataFrame(rows).assign(**changes)
