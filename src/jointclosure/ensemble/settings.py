"""All that the files of a case depend on, so that a file of other settings is noticed.

A file bears its settings as JSON in its attribute ``settings``. Whoever reads it says
which it should have; `check_settings` names the first one that differs.
"""

import json
from pathlib import Path

from jointclosure.config.configuration import (
    choice_tolerance,
    effects_of,
    end_of_stress_axis,
    numerics_in_full,
)
from jointclosure.config.walls import wall_files
from jointclosure.ensemble.cases import Case, wall_name
from jointclosure.inputs import InputError
from jointclosure.scans import file_digest


class OtherSettingsError(InputError):
    """A file that was made with other settings, or by other code."""


def surface_settings(configuration: dict, case: Case, block: range, code: str) -> dict:
    """What the surface pairs of a case and a block of realisations depend on.

    Parameters
    ----------
    configuration : dict
    case : Case
        Whose ``surface`` is its own label.
    block : range
        Of realisations, see `jointclosure.ensemble.cases.blocks_of`.
    code : str
        Digest of the sources that make surfaces.
    """
    walls = configuration["rocks"][case.rock].get("walls")
    roughness = {"walls": walls | {"sha256": wall_digests(walls)}} if walls else {"jrc": case.jrc}
    return roughness | {
        "root_seed": configuration["study"]["root_seed"],
        "seeds_named_by": wall_name(configuration, case),
        "first_realization": block.start,
        "realizations": len(block),
        "grid": dict(configuration["grid"]),
        "surface": dict(configuration["surface"]),
        "code": code,
    }


def wall_digests(walls: dict) -> dict[str, str]:
    """SHA-256 of the files of measured walls: their contents count, and not their time."""
    return {side: file_digest(file) for side, file in wall_files(walls).items()}


def closure_settings(configuration: dict, case: Case, surfaces: dict, code: str) -> dict:
    """What the closures of a case and a block of realisations depend on.

    Parameters
    ----------
    configuration : dict
    case : Case
    surfaces : dict
        `surface_settings` of the surface pairs that are closed.
    code : str
        Digest of the sources that close them.
    """
    output = configuration["output"]
    return {
        "case": case._asdict(),
        "cycles": configuration["study"]["cycles"],
        "seating_stress_MPa": configuration["seating_stress_MPa"],
        "stress_points": output["stress_points"],
        "largest_stress_MPa": end_of_stress_axis(configuration),
        "surfaces": surfaces,
        "code": code,
        "effects": effects_of(configuration, case.rock)._asdict(),
        "effects_chosen_to": choice_tolerance(configuration),
        "choices": dict(configuration["choices"]),
        "numerics": numerics_in_full(configuration),
    }


def block_settings(
    configuration: dict,
    cases: dict[str, Case],
    label: str,
    block: range,
    surface_code: str,
    solver_code: str,
) -> dict:
    """`closure_settings` of a case and a block, with those of the surfaces that it closes."""
    case = cases[label]
    surfaces = surface_settings(configuration, cases[case.surface], block, surface_code)
    return closure_settings(configuration, case, surfaces, solver_code)


def as_text(settings: dict) -> str:
    """Settings as JSON, the same text for the same settings."""
    return json.dumps(settings, sort_keys=True)


def check_settings(path: str | Path, attributes: dict, expected: dict) -> None:
    """Raise `OtherSettingsError` unless a file's attributes are of the expected settings."""
    text = attributes.get("settings")
    if text == as_text(expected):
        return
    said = (
        "it does not say which" if text is None else _first_difference(json.loads(text), expected)
    )
    raise OtherSettingsError(
        f"{path}: the file was made with other settings ({said}): "
        "delete it and start again, what is missing is made anew"
    )


def _first_difference(found: dict, expected: dict, prefix: str = "") -> str:
    for key in sorted({*found, *expected}):
        one, other = found.get(key), expected.get(key)
        if as_text({key: one}) == as_text({key: other}):
            continue
        if isinstance(one, dict) and isinstance(other, dict):
            return _first_difference(one, other, f"{prefix}{key}.")
        return f"{prefix}{key} is {one!r} there, and should be {other!r}"
    return "in their order"
