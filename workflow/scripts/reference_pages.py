"""Write build/docs/: reference pages from the docstrings and the schema, to be read offline.

`make docs` runs it; what it writes is not kept in the repository.
"""

import pkgutil
import re
from pathlib import Path

import pdoc
from pdoc import render_helpers

import jointclosure

ROOT = Path(__file__).parents[2]
OUTPUT = ROOT / "build/docs"

PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; }}
table {{ border-collapse: collapse; display: block; overflow-x: auto; }}
td, th {{ border: 1px solid #ccc; padding: .2em .5em; text-align: left; vertical-align: top; }}
</style>
<p><a href="index.html">Functions</a> · <a href="configuration.html">Configuration</a></p>
{body}
</html>
"""


def configuration_page() -> str:
    """The table of keys, which `key_table.py` makes from the schema, as HTML."""
    text = (ROOT / "config/README.md").read_text(encoding="utf-8")
    # links to files of the project lead nowhere from here
    text = re.sub(r"\[([^]]+)\]\((?!http)[^)]+\)", r"\1", text)
    return PAGE.format(title="Configuration", body=render_helpers.to_html(text))


def main() -> None:
    """Write all pages."""
    OUTPUT.mkdir(parents=True, exist_ok=True)
    pdoc.render.configure(
        docformat="numpy",
        search=True,
        footer_text="keys of a configuration: configuration.html",
    )
    parts = [f"jointclosure.{part.name}" for part in pkgutil.iter_modules(jointclosure.__path__)]
    pdoc.pdoc("jointclosure", *parts, output_directory=OUTPUT)
    (OUTPUT / "configuration.html").write_text(configuration_page(), encoding="utf-8")
    print(f"wrote {OUTPUT}/index.html")


if __name__ == "__main__":
    main()
