"""Run a target of the Makefile: `make` starts this with the name of the target and nothing else."""

import os
import sys

from process_group import EndRequest


def open_streams() -> None:
    """Open the standard streams that are closed, and let them print any character in some form."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number, which is this one
    sys.stdout = sys.stdout or os.fdopen(1, "w", encoding="utf-8")
    sys.stderr = sys.stderr or os.fdopen(2, "w", encoding="utf-8")
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="replace")


if __name__ == "__main__":
    open_streams()
    request = EndRequest()  # before the imports that take seconds: a signal during them is heeded
    from targets import InputError, run_target

    try:
        sys.exit(run_target(sys.argv[1], request))
    except (InputError, OSError) as error:
        sys.exit(str(error))
