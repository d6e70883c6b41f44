"""Write config/README.md and config/schema.json: the keys of a configuration, and the defaults."""

import json
from itertools import groupby
from pathlib import Path
from typing import Any

import yaml

from jointclosure.parameters.units import in_unit, name_and_unit
from studies.frame.configuration import USUAL, model, sections
from studies.frame.keys import json_schema
from studies.frame.yaml_files import DEFAULT, read_plain

ROOT = Path(__file__).parents[2]

HEADER = """# Configuration

A study is a small file with the keys that differ from `default.yaml`. That file is the paper's study, and states the source of each number. Lists replace lists, and everything else is merged. `make study CONFIG=config/mine.yaml` checks the merged configuration, runs the study, and writes to `results/<study.name>/`. An error names the key, its value and the allowed values, also of files that are missing. `snakemake --configfile FILE` does the same, but if FILE itself is missing or is no YAML, Snakemake ends before it reads the project, with a text of its own; `make` names the file and the line. Editors can check YAML by `schema.json`.

- `smoke.yaml` is a small version of the paper's study.
- `my_rock.yaml` is a worked example ([how to write a study](../docs/first_hour.md)).
- `measured_wall.yaml` has scanned walls.
- `many_realizations.yaml` has 100,000 small joints.
- The other files change one thing, which their first line states.

Configurations of further studies are in the folders of `studies/`. `schema.json` has the keys of their sections.

The following list has all other keys, with the default and the allowed values of each. `<rock>` stands for any name. `.venv/bin/python workflow/scripts/key_table.py` writes this list.

"""


def main() -> str:
    """Return the text of the page."""
    lines, before = [HEADER], ""
    usual = {
        name: json.loads(section().model_dump_json(by_alias=True))
        for name, section in sections().items()
        if section.by_default
    }
    found = rows(json_schema(model()), read_plain(DEFAULT) | usual, "")
    for (given, text), same in groupby(found, key=lambda row: row[1:]):
        keys = ", ".join(f"`{key}`" for key, *_ in same)
        lines.append(f"- {keys} ({given}) {text if text != before else 'The same.'}\n")
        before = text
    return "".join(lines)


def schema() -> str:
    """Return the text of the JSON schema."""
    return json.dumps(json_schema(model()), indent=1) + "\n"


def rows(schema: dict, default: Any, path: str):
    """Generate each key below a path, its default and allowed values, and its description.

    Sections that are not in ``default`` are left out.
    """
    entries = dict(schema.get("properties", {}))
    extra = schema.get("additionalProperties")
    if isinstance(extra, dict):
        entries["<rock>" if path == "rocks." else "<name>"] = extra
    for name, entry in entries.items():
        if not path and name not in default:
            continue  # the section of an experiment without defaults
        value = default.get(name) if isinstance(default, dict) else None
        section = "properties" in entry or isinstance(entry.get("additionalProperties"), dict)
        if not section or "number" in entry.get("type", ""):  # a key may be either
            stated = isinstance(default, dict) and name in default and "<rock>" not in path
            shown = f"`{_shown(value)}`" if stated else ""
            given = ": ".join(part for part in (shown, _allowed(name, entry, stated)) if part)
            yield f"{path}{name}", given, entry["description"]
        if section:
            yield from rows(entry, value, f"{path}{name}.")


def _shown(value: object) -> str:
    return yaml.safe_dump(value, default_flow_style=True, width=1000).replace("\n...", "").strip()


def _allowed(name: str, entry: dict, stated: bool) -> str:
    """Return the allowed values of a key; its type only if its default does not show it."""
    if "enum" in entry:
        return ", ".join("null" if value is None else str(value) for value in entry["enum"])
    kinds = entry.get("type", "")
    kinds = " or ".join(kinds) if isinstance(kinds, list) else kinds
    if stated:  # the default shows the type
        kinds = kinds.removesuffix(" or null")
        kinds = "" if kinds in ("string", "array", "boolean", "number") else kinds
    ends = [
        (sign, bracket, f"{entry[key]:g}")
        for key, sign, bracket in (
            ("minimum", "≥", "["), ("exclusiveMinimum", ">", "("), ("maximum", "≤", "]"), ("exclusiveMaximum", "<", ")"),
        )
        if key in entry
    ]  # fmt: skip
    bounds = " ".join(f"{sign} {end}" for sign, _, end in ends)
    if len(ends) == 2:
        (_, opening, low), (_, closing, high) = ends
        bounds = f"{opening}{low}, {high}{closing}"
    bare, unit = name_and_unit(name)
    usual = ""
    if bare in USUAL:
        least, most = (in_unit(bound, unit) for bound in USUAL[bare][:2])
        usual = f"usually {least:g} to {most:g}"
    return ", ".join(part for part in (kinds, bounds, usual) if part)


if __name__ == "__main__":
    (ROOT / "config/README.md").write_text(main(), encoding="utf-8")
    (ROOT / "config/schema.json").write_text(schema(), encoding="utf-8")
