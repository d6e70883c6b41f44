"""Commands on finished studies: `python -m studies report results/paper`."""

import sys
from collections.abc import Sequence

from jointclosure.cli.main import main as run
from studies.commands import COMMANDS


def main(words: Sequence[str] | None = None) -> int:
    """Run a command on a study; report errors of its input in one line on standard error."""
    return run(words, program_name="studies", described=COMMANDS, package="studies.commands")


if __name__ == "__main__":
    sys.exit(main())
