"""Table of docs/validation.md."""

from stored import stored

from content.markdown import Form, listed
from jointclosure.statistics.standard_errors import rounded

COLUMNS = {
    "seated_net": "closure since 0.5 MPa, net (mm)",
    "seated_gross": "gross (mm)",
    "stays_net": "of it stays, net (%)",
    "stays_gross": "gross (%)",
    "kn_net": "kn, 5 to 10 MPa, net (MPa/mm)",
    "kn_gross": "gross (MPa/mm)",
    "stiffer_net": "kn of cycle 2 over cycle 1, net",
    "stiffer_gross": "gross",
    "semilog": "rms miss of the semi-logarithmic law (%)",
    "hyperbola": "of the hyperbola (%)",
    "loop": "loop of cycle 2 (MPa)",
}


def model() -> str:
    """Tabulate means over joints, with the standard deviation of single joints."""
    columns: dict[str, Form] = {"walls": "{walls}", "side (mm)": "{side_mm:g}"}
    columns |= {"joints": "{joints}"} | {title: _mean(name) for name, title in COLUMNS.items()}
    return listed(stored("validation", "validation"), columns)


def _mean(name: str) -> Form:
    """Write a mean and its deviation; a mean alone of one joint, or where joints do not differ."""

    def cell(row: dict) -> str:
        mean, deviation = row[f"{name}_mean"], row[f"{name}_deviation"]
        return rounded(mean, deviation) if deviation > 0.0 else f"{mean:.3g}"

    return cell
