"""The command line: `jointclosure --help`. Each command is a module of `commands`."""

import argparse
import sys
from typing import NoReturn

from jointclosure import __version__
from jointclosure.commands import close, compare, doctor, plan, repeat, report, roughness, simulate
from jointclosure.inputs import InputError

COMMANDS = (close, simulate, roughness, compare, report, plan, repeat, doctor)


class Parser(argparse.ArgumentParser):
    """Says what is wrong with its arguments in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")


def parser() -> argparse.ArgumentParser:
    """Commands and their arguments."""
    program = Parser(prog="jointclosure", description="Closure of rock joints.")
    program.add_argument("--version", action="version", version=__version__)
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
        said = "; ".join(line.strip() for line in str(error).splitlines())
        print(f"jointclosure: {said.replace(':;', ':')}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("jointclosure: interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
