"""Write config/README.md and config/schema.json: the keys of a configuration, and the defaults."""

import json
from pathlib import Path

import yaml

from jointclosure.config.contradictions import USUAL
from jointclosure.config.files import DEFAULT, read_plain
from jointclosure.config.keys import ConfigurationKeys
from jointclosure.config.schema import json_schema
from jointclosure.config.units import in_unit, name_and_unit

ROOT = Path(__file__).parents[2]

HEADER = """# Configuration

`default.yaml` is the paper's study and holds every number of the model, each with its source. Another study is a small file
with what differs: lists replace lists, everything else is merged. `make study CONFIG=config/mine.yaml` runs it, and writes to
`results/<study.name>/`. Before any job starts the merged configuration is checked against the keys below; an error names the key,
its value and what is allowed. Numbers beyond what is usual of rock are more often a slip of units than meant: they are refused, unless
`study.unusual_values: allow` says that they are meant. `schema.json` is the same for editors that check YAML.

- `default.yaml`: the paper's study (a link to the package's file, so that it is in the wheel).
- `smoke.yaml`: the same made small.
- `common_draws.yaml`: the same 20 surfaces in all cases, with the paired test.
- `no_roll_off.yaml`: walls with waves of all lengths; the default of before ([which reading](../docs/readings.md)).
- `many_levels.yaml`: nine levels of every property: is a quadratic enough?
- `regularised.yaml`: the model that has a limit, to 10 MPa; `paper_at_10_mpa.yaml`: what it is held against.
- `accuracy.yaml`: what accuracy costs in time (`make accuracy`).
- `readings.yaml`: which reading of the paper gives its Table 3 (`make readings`).
- `effects.yaml`: what each effect adds, and what it costs (`make effects`).
- `mismatch.yaml`: walls from mates to independent ones, and shifted (`make mismatch`).
- `size.yaml`: nested patches of several sizes and spacings (`make size`).
- `misalignment.yaml`: walls that are tilted, or rotated about the normal (`make misalignment`).
- `global_sensitivity.yaml`: which properties and open choices matter (`make global-sensitivity`); `global_sensitivity_full.yaml`: the same at full size, for a cluster.
- `many_realizations.yaml`: 100,000 small joints of one case ([docs/clusters.md](../docs/clusters.md)).
- `measured_wall.yaml`: a rock whose walls were scanned ([scanned walls](../docs/measured_walls.md)).
- `hard_cases.yaml`: joints that are hard on a solver (`make hard-cases`); its keys are in `verification/hard_case_keys.py`.
- `my_rock.yaml`: a worked example of a study of one's own, with a measured curve ([how to](../docs/own_rock.md)).

A rock of your own is an entry under `rocks` and its name in `study.rocks`:

```yaml
study:
  name: my_granite
  rocks: [granite]
rocks:
  granite:
    title: Granite
    youngs_modulus_GPa: 60
    poisson_ratio: 0.22
    compressive_strength_MPa: 180
    jrc: 10
    max_normal_stress_MPa: 20
    levels:
      youngs_modulus_GPa: [50, 55, 65, 70]   # besides its own 60: five levels
      jrc: [8, 12]
```

The table is written by `python workflow/scripts/key_table.py` from `src/jointclosure/config/keys.py`; `<rock>` and `<name>` stand for any name.

| key | default | allowed | what it is |
|---|---|---|---|
"""


def main() -> str:
    """The page's text."""
    return HEADER + "".join(
        f"{row}\n" for row in rows(json_schema(ConfigurationKeys), read_plain(DEFAULT), "")
    )


def schema() -> str:
    """The JSON schema's text; a file has what differs from the defaults, so it requires nothing."""
    return json.dumps(_without_required(json_schema(ConfigurationKeys)), indent=1) + "\n"


def _without_required(part: object) -> object:
    if isinstance(part, list):
        return [_without_required(each) for each in part]
    if not isinstance(part, dict):
        return part
    kept = {name: each for name, each in part.items() if name != "required"}
    return {name: _without_required(each) for name, each in kept.items()}


def rows(schema: dict, default: object, path: str):
    """A row for each key below a path."""
    entries = dict(schema.get("properties", {}))
    extra = schema.get("additionalProperties")
    if isinstance(extra, dict):
        entries["<rock>" if path == "rocks." else "<name>"] = extra
    for name, entry in entries.items():
        value = default.get(name) if isinstance(default, dict) else None
        section = "properties" in entry or isinstance(entry.get("additionalProperties"), dict)
        if not section or "number" in entry.get("type", ""):  # a key may be either
            shown = "" if "<rock>" in path else f"`{_shown(value)}`"
            yield f"| `{path}{name}` | {shown} | {_allowed(name, entry)} | {entry['description']} |"
        if section:
            yield from rows(entry, value, f"{path}{name}.")


def _shown(value: object) -> str:
    return yaml.safe_dump(value, default_flow_style=True, width=1000).replace("\n...", "").strip()


def _allowed(name: str, entry: dict) -> str:
    if "enum" in entry:
        return ", ".join("null" if value is None else str(value) for value in entry["enum"])
    kinds = entry.get("type", "")
    kinds = " or ".join(kinds) if isinstance(kinds, list) else kinds
    bounds = [
        f"{sign} {entry[key]:g}"
        for key, sign in (
            ("minimum", "≥"), ("exclusiveMinimum", ">"), ("maximum", "≤"), ("exclusiveMaximum", "<"),
        )
        if key in entry
    ]  # fmt: skip
    bare, unit = name_and_unit(name)
    if bare in USUAL:
        low, high = (in_unit(bound, unit) for bound in USUAL[bare][:2])
        bounds.append(f"usually {low:g} to {high:g}")
    return ", ".join([kinds, *bounds])


if __name__ == "__main__":
    (ROOT / "config/README.md").write_text(main(), encoding="utf-8")
    (ROOT / "config/schema.json").write_text(schema(), encoding="utf-8")
