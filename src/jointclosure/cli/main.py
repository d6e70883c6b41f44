"""Command line `jointclosure`; each command is a module of this package."""

import argparse
import importlib
import io
import re
import sys
from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

from jointclosure import __version__
from jointclosure.cli import COMMANDS
from jointclosure.inputs import InputError, did_you_mean


class Parser(argparse.ArgumentParser):
    """Parser that reports errors of arguments in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Add the most similar allowed word to argparse's error for a word that is not allowed."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            meant = did_you_mean(value, map(str, action.choices or ()))
            raise argparse.ArgumentError(action, f"{error.message}{meant}") from None


def parser(
    words: Sequence[str],
    program_name: str = "jointclosure",
    described: Mapping[str, str] = COMMANDS,
    package: str = "jointclosure.cli",
) -> argparse.ArgumentParser:
    """Return a parser of all commands, with the arguments of one command only.

    This is the first of the ``words`` of the command line that is no option; its module in
    ``package`` is imported. ``described`` has the purposes of all commands by name.
    """
    named = next((word for word in words if not word.startswith("-")), "")
    program = Parser(prog=program_name, description="Closure of rock joints.")
    program.add_argument("--version", action="version", version=__version__)
    commands = program.add_subparsers(required=True, metavar="command")
    for name, purpose in described.items():
        command = commands.add_parser(name, help=purpose)
        if name == named:
            module = importlib.import_module(f"{package}.{name}")
            text, _, examples = (module.__doc__ or "").partition("examples:\n")
            command.formatter_class = argparse.RawDescriptionHelpFormatter
            command.description = text
            command.epilog = examples and f"examples:\n{examples}"
            command.set_defaults(run=module.run, command=command)
            module.declare(command)
    return program


def main(words: Sequence[str] | None = None, **commands: Any) -> int:
    """Run the command that ``words`` state; return its exit status.

    ``commands`` are further arguments of `parser`. Errors of input are printed in one line on
    standard error, and have the status 2; an interruption has the status 130.
    """
    words = sys.argv[1:] if words is None else words
    arguments, unknown = parser(words, **commands).parse_known_args(words)
    if unknown:
        options = re.findall(r"--[\w-]+", arguments.command.format_usage())
        meant = did_you_mean(unknown[0], options)
        arguments.command.error(f"unrecognized arguments: {' '.join(unknown)}{meant}")
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # write logs line by line
    try:
        return arguments.run(arguments)
    except (InputError, OSError, ValueError) as error:
        message = "; ".join(line.strip() for line in str(error).splitlines())
        print(f"jointclosure: {message.replace(':;', ':')}", file=sys.stderr)
        return 2
    except (KeyboardInterrupt, SystemError) as error:  # the latter in a compiled kernel
        if not isinstance(error.__cause__ or error, KeyboardInterrupt):
            raise
        print("jointclosure: interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
