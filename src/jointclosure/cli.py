"""The command line: `jointclosure --help`. Each command is a module of `commands`."""

import argparse
import sys

from jointclosure.commands import compare, repeat, roughness
from jointclosure.parameters import InputError

COMMANDS = (compare, repeat, roughness)


def parser() -> argparse.ArgumentParser:
    """Commands and their arguments."""
    program = argparse.ArgumentParser(prog="jointclosure", description="Closure of rock joints.")
    commands = program.add_subparsers(required=True, metavar="command")
    for command in COMMANDS:
        command.add_to(commands)
    return program


def main(words: list[str] | None = None) -> int:
    """Run a command; what is wrong with its input is one line on standard error."""
    arguments = parser().parse_args(words)
    try:
        return arguments.run(arguments)
    except (InputError, OSError, ValueError) as error:
        print(f"jointclosure: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
