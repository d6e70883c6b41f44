"""Write config/README.md and config/schema.json: the keys of a configuration, and the defaults."""

import json
from pathlib import Path

import yaml

from jointclosure.parameters.units import in_unit, name_and_unit
from studies.frame.config.contradictions import USUAL
from studies.frame.config.files import DEFAULT, read_plain
from studies.frame.config.keys.configuration import ConfigurationKeys
from studies.frame.config.schema import json_schema

ROOT = Path(__file__).parents[2]

HEADER = """# Configuration

A study is a small file with what differs from `default.yaml`, the paper's study, which states the source of each number. Lists replace lists; everything else is merged.
`make study CONFIG=config/mine.yaml` runs it and writes to `results/<study.name>/`. The merged configuration is checked first: an error names the key, its value and what is allowed.
Values unusual of rock are refused as likely slips of units, unless `study.unusual_values: allow`. Editors can check YAML by `schema.json`.

| file | study |
|---|---|
| `default.yaml` | the paper's study (a link to the package's file) |
| `smoke.yaml` | the same, small |
| `common_draws.yaml` | the same 20 surfaces in all cases, with the paired test |
| `no_roll_off.yaml` | walls with waves of all lengths, the former default ([readings](../docs/decisions.md)) |
| `many_levels.yaml` | nine levels of every property: does a quadratic suffice? |
| `regularised.yaml`, `paper_at_10_mpa.yaml` | the model that converges as steps shrink, to 10 MPa, and the paper's beside it |
| `accuracy.yaml` | cost of accuracy (`make accuracy`) |
| `accuracy_biases.yaml` | errors of the presets for four rocks, and total errors ([accuracy](../docs/accuracy.md)) |
| `effects.yaml` | contribution and cost of each effect (`make effects`) |
| `mismatch.yaml` | walls from mated to independent, and shifted (`make mismatch`) |
| `size.yaml` | nested patches of several sizes and spacings (`make size`) |
| `misalignment.yaml` | tilted or rotated walls (`make misalignment`) |
| `measured_joints.yaml` | the model beside three measured joints ([validation](../docs/measured.md), `make measured-joints`) |
| `global_sensitivity.yaml`, `global_sensitivity_full.yaml` | properties and open choices varied together (`make global-sensitivity`); at full size, for a cluster |
| `many_realizations.yaml` | 100,000 small joints of one case ([clusters](../docs/reference.md#run-on-a-cluster)) |
| `measured_wall.yaml` | a rock with scanned walls ([scanned walls](../docs/two_scans.md)) |
| `hard_cases.yaml` | joints that are hard on a solver (`make hard-cases`); its keys are in `verification/hard_case_keys.py` |
| `my_rock.yaml` | worked example: another rock and a measured curve ([how to](../docs/first_hour.md)) |

Another rock is an entry under `rocks`, named in `study.rocks`:

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
      youngs_modulus_GPa: [50, 55, 65, 70]   # with the rock's 60: five levels
      jrc: [8, 12]
```

`python workflow/scripts/key_table.py` writes this table from `studies/frame/config/keys/`; `<rock>` and `<name>` stand for any name.

| key | default | allowed | what it is |
|---|---|---|---|
"""


def main() -> str:
    """Return the text of the page."""
    return HEADER + "".join(
        f"{row}\n" for row in rows(json_schema(ConfigurationKeys), read_plain(DEFAULT), "")
    )


def schema() -> str:
    """Return the text of the JSON schema, without required keys: a file overrides defaults."""
    return json.dumps(_without_required(json_schema(ConfigurationKeys)), indent=1) + "\n"


def _without_required(part: object) -> object:
    if isinstance(part, list):
        return [_without_required(entry) for entry in part]
    if not isinstance(part, dict):
        return part
    return {name: _without_required(part[name]) for name in part if name != "required"}


def rows(schema: dict, default: object, path: str):
    """Generate a row for each key below a path."""
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
