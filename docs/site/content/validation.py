"""Table of docs/validation.md."""

from content.markdown import Form, Group, Table, written

NAMES = {
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


def _mean(name: str) -> Form:
    """Write a mean and its deviation; a mean alone of one joint, or where joints do not differ."""

    def cell(group: Group) -> str:
        scattered = group[f"{name}_deviation"] > 0.0
        form = f"{{{name}_mean±{name}_deviation}}" if scattered else f"{{{name}_mean:.3g}}"
        return written(form, group)

    return cell


model = Table(
    "validation/validation",
    {"walls": "{walls}", "side (mm)": "{side_mm:g}", "joints": "{joints}"}
    | {title: _mean(name) for name, title in NAMES.items()},
)
