"""Functions for measurements of benchmarks: FFT pairs, times, the machine, joints, processes.

The yardstick of all times is one FFT pair: scipy.fft.rfft2 and irfft2 of 200 x 200 doubles on one
thread, which is the padded size of the paper's 100 x 100 cells. It is timed again before every
measurement, so that a machine that slows down slows both. Benchmarks import this before numpy: it
sets the number of threads.
"""

import argparse
import itertools
import json
import os
import platform
import re
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import numpy as np
import pandas as pd
import scipy.fft

import jointclosure as jc
from jointclosure.joint.simulation import simulate_walls
from jointclosure.storage.provenance import processor, versions_of
from studies.frame.cases import block_settings, cases_of
from studies.frame.configuration import Configuration, configured, merged, merged_study
from studies.frame.settings import BASE, Case, ClosureSettings, walls_of
from studies.frame.yaml_files import ConfigurationError


def options(text: str, **defaults: object) -> argparse.Namespace:
    """Read options of the command line, whose types are those of their defaults.

    A default that is a list takes one or more values; a default that is a type is none.
    """
    parser = argparse.ArgumentParser(
        description=text, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    for name, default in defaults.items():
        several = isinstance(default, list)
        kind = default if isinstance(default, type) else type(default[0] if several else default)
        given = {} if isinstance(default, type) else {"default": default, "help": f"{default}"}
        form = {"action": "store_true"} if kind is bool else {"type": kind}
        parser.add_argument(f"--{name}", **given, **form, **({"nargs": "+"} if several else {}))
    return parser.parse_args()


SPACING = 0.25e-3
DOLERITE = jc.Rock(78e9, 0.2, 165e6)
ELASTIC = jc.Effects(breakage=False, gouge=False)
FULL = jc.Effects()
SCENES = {"full": FULL, "elastic": ELASTIC}
POINTS = 20


def close(walls, effects: jc.Effects, stress: float, cycles: int = 1, **options):
    """Close a joint of dolerite to a stress [Pa] by the paper's model; return its history."""
    return jc.simulate(
        *walls, choices=jc.Choices(strength_bound="none"), spacing=SPACING, rock=DOLERITE,
        max_normal_stress=stress, cycles=cycles, effects=effects, **options,
    )  # fmt: skip


def paper_study(*changes: dict) -> tuple[Configuration, list[Case]]:
    """Return the paper's study with changes of its keys, and its base cases, one for each rock.

    A change that is not allowed ends the benchmark, with a message that names the key.
    """
    try:
        configuration = configured(merged(merged_study(), *changes))
    except ConfigurationError as error:
        raise SystemExit(str(error)) from None
    return configuration, [case for case in cases_of(configuration) if case.parameter == BASE]


def case_settings(
    realizations: int, cells: int, max_normal_stress: float, effects: jc.Effects, **study
) -> ClosureSettings:
    """Return settings of the paper's dolerite on a square grid; ``study`` has keys of `study`."""
    configuration, (case, *_) = paper_study(
        {"grid": {"cells_x": cells, "cells_y": cells}, "study": {"rocks": ["dolerite"]} | study}
    )
    case = case.under(max_normal_stress=max_normal_stress, effects=effects)
    settings = block_settings(configuration, case, range(realizations))
    return settings._replace(largest_stress=max_normal_stress)


def joint_walls(cells: int, seed: int, mated: bool = False) -> tuple:
    """Make two independent walls (y, x) [m] of JRC 8, or two that nearly mate."""
    upper, lower = jc.wall_pair(8.0, (cells, cells), SPACING, seed, roll_off=None)
    if mated:
        lower = -upper + 1e-7 * np.random.default_rng(seed).standard_normal(upper.shape)
    return upper, lower


def curve(walls):
    """Simulate the elastic closure curve of two walls to 30 MPa."""
    return close(walls, ELASTIC, 30e6, numerics=jc.Numerics(curve_points=POINTS))


def timed(function: Callable) -> tuple:
    """Return the processor time [s] of a call, and its result."""
    start = time.process_time()
    result = function()
    return time.process_time() - start, result


def median_time(function: Callable, repeats: int, before: Callable = lambda: None) -> float:
    """Return the median processor time [s] of calls after a first one; ``before`` precedes each."""
    function()
    times = []
    for _ in range(repeats):
        before()
        times.append(timed(function)[0])
    return float(np.median(times))


def base_case(configuration: Configuration, case: Case, realization: int) -> tuple[float, object]:
    """Simulate a realisation of a case as the study does; return processor time [s] and history."""
    block = range(realization, realization + 1)
    settings = block_settings(configuration, case, block)
    walls = next(walls_of(settings))
    return timed(lambda: simulate_walls(*walls, settings.conditions))


class Pair:
    """FFT pair of size x size doubles, whose time is sampled again and again."""

    def __init__(self, size: int = 200, count: int = 25):
        self.size = size
        self._count = count
        self._times = []
        self._values = np.random.default_rng(0).standard_normal((size, size))
        self._transform()

    def _transform(self):
        wave = scipy.fft.rfft2(self._values, workers=1)
        return scipy.fft.irfft2(wave, self._values.shape, workers=1)

    def sample(self) -> None:
        """Time a few transforms."""
        self._times += [timed(self._transform)[0] for _ in range(self._count)]

    @property
    def seconds(self) -> float:
        """Median of all sampled times [s]."""
        return float(np.median(self._times))


def machine() -> str:
    """Return processor and versions in one line."""
    versions = versions_of("numpy", "scipy", "numba")
    packages = ", ".join(f"{name} {version}" for name, version in versions.items())
    return f"{processor()}, Python {platform.python_version()}, {packages}"


def peak_memory() -> float:
    """Return the largest resident memory of this process so far [MB].

    It is VmHWM on Linux, where ru_maxrss begins with the value of the parent process.
    """
    status = Path("/proc/self/status")
    if status.is_file() and (peak := re.search(r"VmHWM:\s*(\d+)", status.read_text())):
        return 1024e-6 * int(peak[1])
    unit = 1e-6 if sys.platform == "darwin" else 1024e-6
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def called_alone(function: Callable, *arguments, timeout: float | None = None):
    """Call a function of a module of this folder in a new process, for at most ``timeout`` [s].

    Arguments must have a literal form, and the result one in JSON.
    """
    module = Path(function.__code__.co_filename).stem
    name = function.__name__
    program = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        f"import json, {module}; print(json.dumps({module}.{name}(*{arguments!r})))"
    )
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, timeout=timeout)
    return json.loads(done.stdout.splitlines()[-1])


def warm_up(*solvers: str) -> None:
    """Compile the kernels of the scenes by simulating a small joint in each."""
    for effects, solver in itertools.product(SCENES.values(), solvers):
        close(joint_walls(24, 0), effects, 1e6, numerics=jc.Numerics(solver=solver))


def by_solver(cells: int, seed: int, scene: str, solver: str) -> tuple[float, float]:
    """Simulate a joint to 3 MPa by a solver; return processor time [s] and maximum closure [um]."""
    walls = joint_walls(cells, seed)
    numerics = jc.Numerics(solver=solver)
    seconds, found = timed(lambda: close(walls, SCENES[scene], 3e6, numerics=numerics))
    return seconds, 1e6 * float(found.max_closure[0])


def spread(times: list, unit: str, scale: float) -> dict:
    """Return median, least and largest of times by names with ``unit``, times ``scale``."""
    names = (unit, f"{unit} min", f"{unit} max")
    return dict(zip(names, scale * np.quantile(times, (0.5, 0.0, 1.0)), strict=True))


def show(title: str, table: pd.DataFrame, output: Path | None, name: str) -> None:
    """Print a table with a title, and write it as CSV to a folder, if one is given."""
    if len(table.columns) > 8:
        shown = table.set_index(table.columns[0]).T.to_string(float_format="{:.4g}".format)
    else:
        shown = table.to_string(index=False, float_format="{:.4g}".format)
    print(f"\n{title}\n{shown}", flush=True)
    if output:
        output.mkdir(parents=True, exist_ok=True)
        table.to_csv(output / f"{name}.csv", index=False)
