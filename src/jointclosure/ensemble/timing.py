"""Unit of time of benchmarks: an FFT pair, whose time varies with the machine as closures do."""

import time

import numpy as np
import scipy.fft


def pair_seconds(count: int = 5) -> float:
    """Measure the median processor time [s] of `scipy.fft.rfft2` and `irfft2` of 200 x 200."""
    values = np.ones((200, 200))
    times = []
    for _ in range(count):
        start = time.process_time()
        scipy.fft.irfft2(scipy.fft.rfft2(values, workers=1), values.shape, workers=1)
        times.append(time.process_time() - start)
    return float(np.median(times))
