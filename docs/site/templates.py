"""Pages of docs/ as templates: `{{ size.exponents() }}` is a table of content/size.py.

    python docs/site/templates.py '{{ size.exponents() }}'

prints what a text becomes. `{{ number("p") }}` is a number of content/numbers.py.
"""

import sys
import traceback
from importlib import import_module
from pkgutil import iter_modules

import content
from jinja2 import Environment, StrictUndefined

NAMES = {
    module.name: import_module(f"content.{module.name}")
    for module in iter_modules(content.__path__)
}
PAGES = Environment(undefined=StrictUndefined, keep_trailing_newline=True)
PAGES.globals = NAMES | {"number": NAMES["numbers"].number}


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
