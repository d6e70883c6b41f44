"""Simulations of a configuration, timed beside the yardstick of the benchmarks."""

import time
from typing import NamedTuple

import numpy as np
import scipy.fft
import xarray as xr

from jointclosure.config.configuration import choices_of, effects_of, numerics_of
from jointclosure.config.units import to_si
from jointclosure.ensemble.cases import Case, wall_seed
from jointclosure.parameters import Effects, Rock
from jointclosure.simulation import simulate
from jointclosure.surface.synthesis import wall_pair


class Timed(NamedTuple):
    """A simulation's dataset, the seconds it took, and those of an FFT pair beside it."""

    closed: xr.Dataset
    seconds: float
    pair: float


def walls_of(configuration: dict, case: Case, realization: int) -> tuple[np.ndarray, np.ndarray]:
    """Walls (y, x) [m] of a realisation, as the study of that configuration draws them."""
    grid = to_si(configuration["grid"])
    return wall_pair(
        case.jrc,
        (grid["cells_y"], grid["cells_x"]),
        grid["spacing"],
        wall_seed(configuration, case, realization),
        **configuration["surface"],
    )


def timed_simulation(
    configuration: dict, case: Case, walls: tuple, effects: Effects | None = None
) -> Timed:
    """Close walls as a configuration says, or with other effects."""
    pair = pair_seconds()
    start = time.perf_counter()
    closed = simulate(
        *walls,
        spacing=to_si(configuration["grid"])["spacing"],
        rock=Rock(case.youngs_modulus, case.poisson_ratio, case.compressive_strength),
        max_normal_stress=case.max_normal_stress,
        cycles=configuration["study"]["cycles"],
        effects=effects or effects_of(configuration),
        choices=choices_of(configuration),
        numerics=numerics_of(configuration),
    )
    return Timed(closed, time.perf_counter() - start, pair)


def pair_seconds(count: int = 5) -> float:
    """Median time of an FFT pair now [s]: `scipy.fft.rfft2` and `irfft2` of 200 x 200."""
    values = np.ones((200, 200))
    times = []
    for _ in range(count):
        start = time.perf_counter()
        scipy.fft.irfft2(scipy.fft.rfft2(values, workers=1), values.shape, workers=1)
        times.append(time.perf_counter() - start)
    return float(np.median(times))
