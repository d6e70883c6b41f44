"""Times of commands that are run in processes of their own, for benchmarks."""

import resource
import subprocess
import time
from typing import Any


def timed(command: list[Any], **options: Any) -> tuple[subprocess.CompletedProcess, float, float]:
    """Run a command, and wait for its end.

    Return its outcome, the processor time [s] of it and of the processes that it started and waited
    for, and the time [s] on the clock. ``options`` are keywords of `subprocess.run`.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    outcome = subprocess.run(command, capture_output=True, **options)
    clock = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return outcome, processor, clock
