"""Pages of docs/ that are made of docs/templates/ and committed: readable where they lie.

    python docs/site/templates.py
    python docs/site/templates.py '{{ size.exponents() }}'

The first writes the pages, the second prints what a text becomes: a table of content/size.py.
`{{ number("p") }}` is a number of content/numbers.py.
"""

import sys
import traceback
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

import content
from jinja2 import Environment, StrictUndefined

DOCS = Path(__file__).parents[1]
ALL = sorted(DOCS.glob("templates/*.md.j2"))
NOTE = "<!-- Made by `make docs`: edit docs/templates/{name}. -->\n\n"
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


def made(template: Path) -> str:
    """Make the page of a template."""
    text = template.read_text(encoding="utf-8")
    return NOTE.format(name=template.name) + filled(text, f"docs/templates/{template.name}")


def page_of(template: Path) -> Path:
    """Return where the page of a template lies."""
    return DOCS / template.stem


def main(words: list[str]) -> None:
    """Print what a text becomes, or write all pages."""
    if words:
        print(filled(words[0], "argument"))
        return
    for template in ALL:
        page_of(template).write_text(made(template), encoding="utf-8")


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except PageError as error:
        raise SystemExit(str(error)) from None
