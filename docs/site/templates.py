"""Pages of docs/ as templates: `{{ size.exponents() }}` is the table that this function makes.

    python docs/site/templates.py '{{ results.outcome() }}'

prints what a text becomes. The functions are those of content/, by the names of its modules;
`{{ number("p") }}` is a number by its name.
"""

import sys
import traceback

from content import (
    accuracy,
    conclusions,
    continuum,
    effects,
    global_sensitivity,
    misalignment,
    mismatch,
    numbers,
    results,
    size,
    speed,
    validation,
)
from jinja2 import Environment, StrictUndefined

MODULES = (accuracy, conclusions, continuum, effects, global_sensitivity, misalignment, mismatch,
           numbers, results, size, speed, validation)  # fmt: skip
NAMES = {module.__name__.rpartition(".")[2]: module for module in MODULES}
NAMES["number"] = numbers.number
PAGES = Environment(undefined=StrictUndefined, keep_trailing_newline=True)
PAGES.globals = NAMES


class PageError(Exception):
    """A page that asks for what there is not: a name, a stored file, a column."""


def filled(text: str, page: str) -> str:
    """Fill the expressions of a page; `PageError` names page, line and expression if one fails."""
    try:
        return PAGES.from_string(text).render()
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in frames if frame.filename == "<template>"]
        line = lines[-1] if lines else getattr(error, "lineno", 1)
        source = text.splitlines()[line - 1].strip()
        raise PageError(
            f"{page}, line {line}: {source}: {type(error).__name__}: {error}"
        ) from error


if __name__ == "__main__":
    print(filled(sys.argv[1], "argument"))
