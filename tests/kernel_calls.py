"""Pytest plugin for kernels that are not compiled: records which of them tests call.

`python -m pytest -p tests.kernel_calls` with ``NUMBA_DISABLE_JIT=1`` and the
file to write to in ``KERNEL_CALLS``. It must be imported before jointclosure,
whose `kernel` decorator it watches.
"""

import functools
import os
from pathlib import Path

import numba

CALLED: set[str] = set()


def watched(function, **options):
    """Return a function that records its calls, in place of `numba.njit`."""
    name = f"{function.__module__}.{function.__name__}"

    @functools.wraps(function)
    def recorded(*arguments):
        CALLED.add(name)
        return function(*arguments)

    return recorded


if numba.config.DISABLE_JIT:
    numba.njit = watched


def pytest_sessionfinish(session, exitstatus) -> None:
    """Write the names of the recorded kernels, one a line."""
    Path(os.environ["KERNEL_CALLS"]).write_text("\n".join(sorted(CALLED)))
