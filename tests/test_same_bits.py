"""Walls, their registration and a history are the same bits on any processor and by any library.

Breakage makes another history of another last digit.
"""

import contextlib
import io

import pytest

from tests.processes import python

PROCESSORS = {
    "without AVX-512": {
        "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR", "OPENBLAS_CORETYPE": "Haswell",
    },
    "without AVX2": {
        "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR",
        "OPENBLAS_CORETYPE": "Nehalem", "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4",
    },
}  # fmt: skip
"""Environments, by what the libraries then take the processor for; on one that has none of it
already they change nothing."""
PROGRAM = """
import hashlib, numpy as np, jointclosure as jc
from jointclosure.walls.gridding import Cloud, Scan, points_of
from jointclosure.walls.registration import registered
from tests.joints import closed, pair

def shown(name, *arrays):
    print(name, *(hashlib.sha256(array.tobytes()).hexdigest() for array in arrays))

h = 0.25e-3
for rule in ({}, {"rule": "walk", "roll_off": 3e-3}):
    for normalise in ("wall", "expectation"):
        shown(normalise, *jc.wall_pair(8.0, (40, 50), h, seed=3, normalise=normalise, **rule))
upper, lower = jc.wall_pair(9.0, (64, 72), h, seed=4, correlation=0.9, roll_off=None)
y, x = np.indices(lower.shape) * h
upper = -upper + 0.02 * x - 0.01 * y
lower[30:33, 20:24] = np.nan
grids = Scan(upper, (h, h), (0.0, 0.0)), Scan(lower, (h, h), (0.0, 0.0))
apart = [Cloud(points_of(grid) + [0.3e-3 * i, 0.0, 0.0]) for i, grid in enumerate(grids)]
for scans, spacing in ((grids, h), (grids, 1.4 * h), (apart, h)):
    found = registered(*scans, spacing)
    shown("registered", found.upper, found.lower)
joint = closed(pair(32, 1), 10e6)
assert joint.breakage_steps > 5_000
for name in sorted(joint.variables):
    if joint[name].dtype.kind in "fiu":
        shown(name, joint[name].values)
"""


@pytest.fixture(scope="module")
def here():
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(PROGRAM, "same bits", "exec"), {})
    return printed.getvalue()


def elsewhere(**environment: str) -> str:
    return python("-W", "ignore", "-c", PROGRAM, **environment).stdout


@pytest.mark.parametrize(
    "name", [pytest.param("without AVX-512", marks=pytest.mark.slow), "without AVX2"]
)
def test_bits_are_the_same_on_any_processor(here, name):
    assert elsewhere(**PROCESSORS[name]) == here


@pytest.mark.slow
def test_bits_are_those_of_plain_machine_code(here, tmp_path):
    """Kernels are compiled for the processor that they run on; here for none in particular."""
    plain = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    assert elsewhere(**plain, JOINTCLOSURE_CACHE=str(tmp_path)) == here
