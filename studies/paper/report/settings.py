"""Configuration of a study, compared with the paper's."""

import json

import pandas as pd

from jointclosure.cli.page import Sheet, sheet

_LEFT_OUT = ("accuracy", "ablation")
"""Sections of other targets, which are left out."""


def setting_rows(configuration: dict, paper: dict, schema: dict) -> pd.DataFrame:
    """Tabulate every key of a study with its value, the paper's value, and its description.

    Parameters
    ----------
    configuration, paper : dict
        Merged configurations; rocks that are not in the study are left out of the first.
    schema : dict
        Schema with the descriptions.

    Returns
    -------
    DataFrame
        Columns key, value, paper, differs, meaning.
    """
    chosen = {key: value for key, value in configuration.items() if key not in _LEFT_OUT}
    chosen["rocks"] = {name: chosen["rocks"][name] for name in chosen["study"]["rocks"]}
    theirs = dict(_leaves(paper, schema, ""))
    rows = []
    for key, (value, meaning) in _leaves(chosen, schema, ""):
        known = key in theirs
        rows.append(
            {
                "key": key,
                "value": _shown(value),
                "paper": _shown(theirs[key][0]) if known else "",
                "differs": not known or theirs[key][0] != value,
                "meaning": meaning,
            }
        )
    return pd.DataFrame(rows)


def departures(rows: pd.DataFrame) -> list[str]:
    """Return the keys in which a study differs from the paper's, without its name."""
    return rows[rows.differs & (rows.key != "study.name")].key.tolist()


def setting_sheet(rows: pd.DataFrame) -> Sheet:
    """Make the table of the configuration."""
    titles = {"key": "Key", "value": "This study", "paper": "The paper's study"}
    titles |= {"differs": "Differs", "meaning": "What it is"}
    return sheet("configuration", "Every key of this study", rows, titles)


def _leaves(value: dict, schema: dict, path: str):
    """Generate (key, (value, description)) of everything that is not a section."""
    known = schema.get("properties", {})
    extra = schema.get("additionalProperties")
    order = {name: place for place, name in enumerate(known)}
    for name, entry in sorted(value.items(), key=lambda item: order.get(item[0], len(order))):
        about = known.get(name, extra if isinstance(extra, dict) else {})
        if isinstance(entry, dict):
            yield from _leaves(entry, about, f"{path}{name}.")
        else:
            yield f"{path}{name}", (entry, about.get("description", ""))


def _shown(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
