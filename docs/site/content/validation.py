"""Tables and numbers of docs/validation.md."""

import pandas as pd
from stored import origin, stored

from content.markdown import markdown, rows_of
from jointclosure.engine.measured_joints import ALL, JOINTS, measured_joints, measured_range
from jointclosure.engine.measured_joints import measured as measured_value
from jointclosure.statistics.standard_errors import rounded
from studies.measured_joints.observables import HEADINGS

OBSERVABLES = {
    "first_closure": "first loading: closure at 10.27 MPa (mm)",
    "first_residual_share": "first loading: share that stays (%)",
    "first_stiffness": "first loading: stiffness, 5 to 10 MPa (MPa/mm)",
    "later_closure": "later loading: closure (mm)",
    "later_stiffness": "later loading: stiffness, 5 to 10 MPa (MPa/mm)",
    "stiffness_ratio": "stiffness, later over first",
    "later_residual_share": "later loading: share that stays (%)",
    "contact_share": "contact area at 10.27 MPa (%)",
}
JUDGED = {name: title for name, title in HEADINGS.items() if name != "first_closure"}
"""Observables that are not fitted, with their titles in tables of results."""
_RUN = ("measured_joints", "measured_joints")
DEFAULT = "default choices"


def _range(row: pd.Series) -> str:
    """Write a measured value with its range."""
    if pd.isna(row.value):
        return f"{row.low:g} to {row.high:g}"
    return f"{row.value:g}" + ("" if pd.isna(row.low) else f" ({row.low:g} to {row.high:g})")


def measured() -> str:
    """Tabulate the measured values, a column per joint."""
    table = measured_joints().set_index(["quantity", "joint"])
    lines = []
    for name, title in OBSERVABLES.items():
        here = table.loc[name]
        cells = [_range(here.loc[joint if joint in here.index else ALL]) for joint in JOINTS]
        heads = (f"joint {joint}" for joint in JOINTS)
        lines.append({"measured": title} | dict(zip(heads, cells, strict=True)))
    return markdown(pd.DataFrame(lines))


def span(quantity: str) -> str:
    """Give the smallest and the largest measured value of a quantity."""
    return "{:g} to {:g}".format(*measured_range(quantity))


def _mean(row: pd.Series) -> str:
    """Write a mean with its standard error; what is 0 but for rounding as 0."""
    if abs(row.value) < 0.05 and row.observable == "later_residual_share":
        return "0"
    return rounded(row.value, row.error)


def _hits(part: pd.DataFrame) -> str:
    return f"{(part.judgement == 'agrees').sum()} of {len(part)}"


def judged() -> str:
    """Count the joints that agree with walls fitted to them, by choice and observable."""
    table = rows_of(stored(*_RUN), walls="mated")
    lines = []
    for variant, of_variant in table.groupby("variant", sort=False):
        agree = (of_variant.judgement == "agrees").groupby(of_variant.observable).sum()
        titles = {title.partition(" (")[0]: str(agree[name]) for name, title in JUDGED.items()}
        lines.append({"choice": variant} | titles | {"sum": str(agree[list(JUDGED)].sum())})
    return markdown(pd.DataFrame(lines))


def wavelengths() -> str:
    """Give the fitted mismatch wavelengths [mm] of the default choices, with standard errors."""
    table = rows_of(stored(*_RUN), variant=DEFAULT, walls="mated")
    table = table.drop_duplicates("joint")
    pairs = zip(table.wavelength_mm, table.wavelength_error, strict=True)
    return ", ".join(rounded(*pair) for pair in pairs)


def means(observable: str, variant: str = DEFAULT, walls: str = "mated") -> str:
    """Give the means of an observable, by measured joint."""
    table = rows_of(stored(*_RUN), variant=variant, walls=walls, observable=observable)
    return ", ".join(dict.fromkeys(_mean(row) for _, row in table.iterrows()))


def values(observable: str) -> str:
    """Give the measured values of an observable, by joint."""
    return ", ".join(f"{measured_value(observable, joint).value:g}" for joint in JOINTS)


def hits(variant: str, walls: str = "mated") -> str:
    """Give the number of values that were not fitted and agree, by measured joint."""
    return ", ".join(str(count) for count in _hits_of(variant, walls))


def most_hits(variant: str) -> str:
    """Give the largest number of values that were not fitted and agree, over walls and joints."""
    return str(max(_hits_of(variant, "mated").max(), _hits_of(variant, "independent").max()))


def _hits_of(variant: str, walls: str) -> pd.Series:
    """Count the values that were not fitted and agree, by measured joint."""
    table = rows_of(stored(*_RUN), variant=variant, walls=walls)
    table = table[table.observable.isin(JUDGED)]
    return (table.judgement == "agrees").groupby(table.joint).sum()


def agreeing(observable: str, variant: str = DEFAULT, walls: str = "mated") -> str:
    """Count the joints that agree in an observable, of all: "1 of 3"."""
    return _hits(rows_of(stored(*_RUN), variant=variant, walls=walls, observable=observable))


def softness_of_paper() -> str:
    """Give the least ratio of Young's modulus to strength of the rocks of the paper."""
    rocks = stored("paper", "table_1_rocks")
    return f"{(1e3 * rocks.youngs_modulus_GPa / rocks.compressive_strength_MPa).min():.0f}"


def core_minutes() -> str:
    """Give the processor time of the run in minutes."""
    return f"{origin(_RUN[0])['cpu_minutes']:.0f}"


def tried() -> str:
    """Count the combinations of choice, walls and joint."""
    return str(len(stored(*_RUN)[["variant", "walls", "joint"]].drop_duplicates()))


def surfaces() -> str:
    """Give the number of surfaces of a mean."""
    counts = stored(*_RUN).surfaces
    return (
        f"{counts.min()}" if counts.min() == counts.max() else f"{counts.min()} to {counts.max()}"
    )


def predictions() -> str:
    """Tabulate hits of predictions by the number of joints that were fitted."""
    table = stored("measured_joints", "measured_joints_predictions")
    fitted = table.fitted_to.astype(str).str.count(r"\+").add(1)
    lines = []
    for count, part in table.groupby(fitted):
        line = {"fitted to": "one joint" if count == 1 else f"{count} joints (leave one out)"}
        for name in dict.fromkeys(table.observable):
            hits = part[part.observable == name].hit
            line[OBSERVABLES[name]] = f"{hits.sum()} of {hits.size}"
        lines.append(line)
    return markdown(pd.DataFrame(lines))
