"""Whether rounding and the order of breakage flip verdicts: `python benchmarks/flips.py`.

The same surfaces of a pool are closed again with their rounding moved on purpose: mirrored and
transposed (the same joints, met in another order of breakage), and with heights changed by one
unit in the last place. Verdicts on the model are judged of each, and those that differ from the
first are listed. Small by default; --cells 100 --stress 30 is the paper's size (four times
36 cases, 1 to 2 s a simulation).
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
from collections.abc import Callable

import numpy as np
import pandas as pd
import xarray as xr
from yardstick import machine

from jointclosure.config.configuration import configured, merged
from jointclosure.config.files import DEFAULT, PAPER_TABLE_3, read_plain
from jointclosure.config.typed import Configuration
from jointclosure.ensemble.aggregation import join_cases
from jointclosure.ensemble.cases import cases_of, pool_of
from jointclosure.ensemble.closing import close_surfaces
from jointclosure.ensemble.slices import block_settings
from jointclosure.ensemble.surfaces import surfaces_of
from jointclosure.sensitivity.claims import Evidence, judge_claims
from jointclosure.statistics.drawn_studies import Design
from jointclosure.statistics.randomness import generator
from jointclosure.statistics.verdicts import UNDECIDED
from jointclosure.storage.text import read_csv

AS_MADE = "as made"


def one_ulp(wall: np.ndarray) -> np.ndarray:
    """Every height moved to a neighbouring number, up or down at random."""
    up = generator(1).random(wall.shape) < 0.5
    return np.nextafter(wall, np.where(up, np.inf, -np.inf))


VARIANTS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    AS_MADE: lambda wall: wall,
    "mirrored": lambda wall: np.ascontiguousarray(wall[..., ::-1]),
    "transposed": lambda wall: np.ascontiguousarray(np.swapaxes(wall, -1, -2)),
    "one unit in the last place": one_ulp,
}


def closed(configuration: Configuration, move: Callable[[np.ndarray], np.ndarray]) -> xr.Dataset:
    """The pool, its walls moved."""
    cases = {case.label: case for case in cases_of(configuration)}
    block = range(configuration.study.realizations)
    parts = []
    for label in cases:
        settings = block_settings(configuration, cases, label, block)
        pairs = xr.concat(list(surfaces_of(settings.surfaces)), "realization")
        for side in ("upper", "lower"):
            pairs[side] = pairs[side].copy(data=move(pairs[side].values))
        parts.append(xr.concat(list(close_surfaces(pairs, settings)), "realization"))
    return join_cases(list(cases.values()), parts)


def judged(pool: xr.Dataset) -> pd.Series:
    """Verdicts on the model by claim."""
    evidence = Evidence(pool, pool, Design(), 100, 1, resampled_pools=0)
    table, _ = judge_claims(evidence, read_csv(PAPER_TABLE_3))
    return table.set_index("number").verdict


def main(rocks: list[str], cells: int, stress: float, surfaces: int) -> None:
    """Close, judge, and print what flips."""
    print(machine())
    keys = {
        "study": {"rocks": rocks, "pool": surfaces},
        "grid": {"cells_x": cells, "cells_y": cells},
        "rocks": {rock: {"max_normal_stress_MPa": stress} for rock in rocks},
    }
    configuration = pool_of(configured(merged(read_plain(DEFAULT), keys), read_csv).typed)
    pools = {name: closed(configuration, move) for name, move in VARIANTS.items()}
    verdicts = pd.DataFrame({name: judged(pool) for name, pool in pools.items()})
    print(f"{', '.join(rocks)}: {surfaces} surfaces of {cells} x {cells} cells, {stress:g} MPa")
    print(verdicts.to_string())
    first, means = verdicts[AS_MADE], pools[AS_MADE].max_closure.mean("realization")
    for name in list(VARIANTS)[1:]:
        differs = verdicts[name] != first
        either = (verdicts[name] == UNDECIDED) | (first == UNDECIDED)
        change = np.abs(pools[name].max_closure.mean("realization") / means - 1.0)
        print(
            f"{name}: {int((differs & ~either).sum())} flips between stands and falls, "
            f"{int((differs & either).sum())} undecided in one only; mean closures move by "
            f"{100 * float(change.mean()):.2g} % (at most {100 * float(change.max()):.2g} %)"
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rocks", nargs="+", default=["dolerite"])
    parser.add_argument("--cells", type=int, default=24)
    parser.add_argument("--stress", type=float, default=5.0, help="maximum stress [MPa]")
    parser.add_argument("--surfaces", type=int, default=20)
    arguments = parser.parse_args()
    main(arguments.rocks, arguments.cells, arguments.stress, arguments.surfaces)
