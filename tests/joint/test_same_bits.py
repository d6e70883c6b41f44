"""A simulation is the same history on any processor: breakage makes another one of a last digit."""

import pytest

from tests.same_bits import PROCESSORS, printed

SIMULATION = """
import hashlib, jointclosure as jc
walls = jc.wall_pair(8.0, (40, 40), 0.25e-3, seed=1, roll_off=None)
rock = jc.Rock(78e9, 0.2, 165e6)
closed = jc.simulate(*walls, spacing=0.25e-3, rock=rock, max_normal_stress=10e6)
assert closed.breakage_steps > 10_000
for name in sorted(closed.variables):
    if closed[name].dtype.kind in "fiu":
        print(name, hashlib.sha256(closed[name].values.tobytes()).hexdigest())
"""


def test_a_simulation_has_the_same_bits_on_any_processor():
    here = printed(SIMULATION)
    for name, environment in PROCESSORS.items():
        assert printed(SIMULATION, **environment) == here, name


@pytest.mark.slow
def test_a_simulation_has_the_same_bits_as_plain_machine_code(tmp_path):
    """Kernels are compiled for the processor that they run on; here for none in particular."""
    plain = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    plain["JOINTCLOSURE_CACHE"] = str(tmp_path)
    assert printed(SIMULATION, **plain) == printed(SIMULATION)
