"""Simulations timed beside the yardstick of the benchmarks."""

import time
from typing import NamedTuple

import numpy as np
import scipy.fft
import xarray as xr

from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.settings import Conditions


class Timed(NamedTuple):
    """A simulation's dataset, the seconds it took, and those of an FFT pair beside it."""

    closed: xr.Dataset
    seconds: float
    pair: float


def timed_simulation(walls: tuple[np.ndarray, np.ndarray], conditions: Conditions) -> Timed:
    """Close walls (upper, lower), each (y, x) [m], and tell the time."""
    pair = pair_seconds()
    start = time.process_time()
    closed = close_walls(*walls, conditions)
    return Timed(closed, time.process_time() - start, pair)


def pair_seconds(count: int = 5) -> float:
    """Median time of an FFT pair now [s]: `scipy.fft.rfft2` and `irfft2` of 200 x 200."""
    values = np.ones((200, 200))
    times = []
    for _ in range(count):
        start = time.process_time()
        scipy.fft.irfft2(scipy.fft.rfft2(values, workers=1), values.shape, workers=1)
        times.append(time.process_time() - start)
    return float(np.median(times))
