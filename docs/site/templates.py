"""Write README.md and the pages of docs/ that are made from templates and stored results.

    python docs/site/templates.py

A template is Jinja: docs/templates/<page>.md.j2, or page.md.j2 in the folder of a study. Rows of a
stored table are `rows("size/size", "cycle == 1")`: run, table, and a query of pandas.
"""

import json
from collections.abc import Iterable
from functools import cache
from importlib import import_module
from pathlib import Path

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from jointclosure.ensembles.quantities import HEADINGS, QUANTITIES
from jointclosure.statistics.number_texts import rounded
from jointclosure.statistics.verdicts import frequency
from jointclosure.storage.files import read_csv

ROOT = Path(__file__).parents[2]
STUDIES = {
    "accuracy": "assessment",
    "hard_cases": "verification",
    "measured": "measured_joints",
    "paper": "paper",
}
"""Pages of single studies, with their folders; others are parts of docs/beyond.md."""
NOTE = "<!-- Made by `make docs`: edit {}. -->\n\n"
OLDER_SOLVER = (
    "accuracy_requests", "conclusions", "continuum", "effects_auto", "flow",
    "global_sensitivity", "global_sensitivity_full", "growth", "growth_once", "jrc_range",
    "large_pool", "later_loadings", "measured_fit",
    "numerics", "peers", "price_before", "readings_average", "registration", "size",
    "strength_bound", "variance_reduction",
)  # fmt: skip
"""Stored runs of an older solver, before 5cfd014e, in which joints reached their maximum otherwise.

With fixed steps mean net closures moved by 0.4 %, with resolved breakage by less than their errors;
before ae58a9b0 resolved breakage had other steps, and before 0d329c6 fixed steps were others."""

Rows = list[dict]


def folder_of(run: str) -> Path:
    """Return the folder of the stored results of a run of a study or a benchmark."""
    of_studies = list(ROOT.glob(f"studies/*/published/{run}"))
    if of_studies:
        return of_studies[0]
    study = ROOT / "studies" / run
    return study / "published" / run if study.is_dir() else ROOT / "benchmarks/results" / run


@cache
def stored(table: str) -> pd.DataFrame:
    """Read a stored table, "run/table"."""
    run, _, name = table.partition("/")
    return read_csv(folder_of(run) / f"{name}.csv")


def rows(table: str, query: str = "") -> Rows:
    """Return the rows of a stored table that a query selects; `ValueError` if there are none."""
    chosen = stored(table).query(query, engine="python") if query else stored(table)
    if chosen.empty:
        raise ValueError(f"{table}: no row has {query}")
    return chosen.to_dict("records")


def groups(chosen: Iterable[dict], *names: str) -> list[tuple]:
    """Group rows by their values in columns, in the order of the table: (value, ..., rows)."""
    chosen = list(chosen)
    keys = [tuple(row[name] for name in names) for row in chosen]
    return [
        (*key, [row for row, at in zip(chosen, keys, strict=True) if at == key])
        for key in dict.fromkeys(keys)
    ]


def ends(values: Iterable[float], form: str = "{:g}") -> str:
    """Format the least and the largest of some values, or a single value."""
    least, *_, largest = sorted(values := [float(value) for value in values]) * 2
    return form.format(least) + (f" to {form.format(largest)}" if len(values) > 1 else "")


def pm(row: dict, name: str, error: str = "", scale: float = 1.0) -> str:
    """Format a value of a row with its standard error, rounded by it; empty without a value."""
    value, doubt = row[name], row[error or f"{name}_error"]
    return "" if pd.isna(value) else rounded(scale * value, scale * doubt)


def counted(count: float, total: float) -> str:
    """Format a count of a total with the 95 % interval (Wilson) of its share."""
    share = frequency(int(count), int(total))
    return f"{int(count)} of {int(total)} ({100 * share.low:.0f} to {100 * share.high:.0f} %)"


def origin(run: str) -> dict:
    """Return the origin of the stored results of a run: commit, date, configuration."""
    return json.loads((folder_of(run) / "origin.json").read_text(encoding="utf-8"))


def pages() -> dict[Path, Path]:
    """Return the templates of all pages by page."""
    made = {ROOT / "docs" / path.stem: path for path in (ROOT / "docs/templates").glob("*.j2")}
    made |= {
        ROOT / f"docs/{page}.md": ROOT / f"studies/{study}/page.md.j2"
        for page, study in STUDIES.items()
    }
    made[ROOT / "README.md"] = made.pop(ROOT / "docs/README.md")
    return made


def made(template: Path) -> str:
    """Return the text of the page of a template."""
    jinja = Environment(
        loader=FileSystemLoader(ROOT),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    parts = sorted(ROOT.glob("studies/*/page.md.j2"))
    others = [path for path in parts if path.parent.name not in STUDIES.values()]
    jinja.globals |= {
        "rows": rows, "groups": groups, "ends": ends, "pm": pm, "origin": origin,
        "counted": counted, "inf": float("inf"),
        "use": import_module, "headings": HEADINGS, "quantities": QUANTITIES,
        "others": [str(path.relative_to(ROOT)) for path in others],
    }  # fmt: skip
    name = str(template.relative_to(ROOT))
    return NOTE.format(name) + jinja.get_template(name).render()


def main() -> None:
    """Write all pages."""
    for page, template in pages().items():
        page.write_text(made(template), encoding="utf-8")


if __name__ == "__main__":
    main()
