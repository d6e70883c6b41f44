"""A simulation is the same history on any processor: breakage makes another one of a last digit."""

import pytest

from tests.same_bits import PROCESSORS, printed

SIMULATION = """
import hashlib
from tests.joints import closed, pair
joint = closed(pair(32, 1), 10e6)
assert joint.breakage_steps > 5_000
for name in sorted(joint.variables):
    if joint[name].dtype.kind in "fiu":
        print(name, hashlib.sha256(joint[name].values.tobytes()).hexdigest())
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
