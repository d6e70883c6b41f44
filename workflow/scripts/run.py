"""Run a target of the Makefile: `make` starts this with the name of the target and nothing else."""

import sys

from process_group import EndRequest

if __name__ == "__main__":
    request = EndRequest()  # before the imports that take seconds: a signal during them is heeded
    from targets import InputError, run_target

    try:
        sys.exit(run_target(sys.argv[1], request))
    except (InputError, OSError) as error:
        sys.exit(str(error))
