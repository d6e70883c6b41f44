"""Tables and numbers of docs/validation.md."""

import numpy as np
import pandas as pd
from stored import origin, stored

from content.markdown import Form, Group, Table, markdown, rows_of, written
from jointclosure.engineering.measured_joints import ALL, JOINTS, measured_joints, measured_range
from jointclosure.engineering.measured_joints import measured as measured_value
from jointclosure.measured.joints import HEADINGS
from jointclosure.statistics.standard_errors import rounded

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


def _with_deviation(name: str) -> Form:
    """Write a mean and its deviation; a mean alone of one joint, or where joints do not differ."""

    def cell(group: Group) -> str:
        scattered = group[f"{name}_deviation"] > 0.0
        form = f"{{{name}_mean±{name}_deviation}}" if scattered else f"{{{name}_mean:.3g}}"
        return written(form, group)

    return cell


model = Table(
    "validation/validation",
    {"walls": "{walls}", "side (mm)": "{side_mm:g}", "joints": "{joints}"}
    | {title: _with_deviation(name) for name, title in NAMES.items()},
)

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
SIGNIFICANT = 2.0
"""Standard errors of a difference above which it counts as a change."""


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


def judged(walls: str) -> str:
    """Tabulate means of all choices for "independent" or "mated" walls, and hits."""
    table = rows_of(stored(*_RUN), walls=walls)
    lines = []
    for variant, of_variant in table.groupby("variant", sort=False):
        line = {"choice": variant}
        if walls == "independent":
            part = of_variant[of_variant.observable == "first_closure"]
            line["first closure (mm)"] = f"{_mean(part.iloc[0])}; **{_hits(part)}**"
        for name, title in JUDGED.items():
            part = of_variant[of_variant.observable == name]
            means = dict.fromkeys(_mean(row) for _, row in part.iterrows())
            line[title] = f"{', '.join(means)}; **{_hits(part)}**"
        lines.append(line)
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


def changes() -> str:
    """Tabulate which observables a choice moves nearer to the measured range, and which away.

    The means are those of fitted walls, compared with the default choices. A change counts if the
    distance from the measured range differs by more than `SIGNIFICANT` standard errors.
    """
    table = rows_of(stored(*_RUN), walls="mated")
    table = table[table.observable.isin(JUDGED)].assign(off=_distance)
    keys = ["observable", "joint"]
    default = rows_of(table, variant=DEFAULT).set_index(keys)
    lines = []
    for variant, part in table[table.variant != DEFAULT].groupby("variant", sort=False):
        part = part.set_index(keys)
        nearer = default.off - part.off
        nearer = nearer[nearer.abs() > SIGNIFICANT * np.hypot(part.error, default.error)]
        line = {"choice": variant, "nearer to the measured range": _with_joints(nearer[nearer > 0])}
        lines.append(line | {"farther from it": _with_joints(nearer[nearer < 0])})
    return markdown(pd.DataFrame(lines))


def _distance(table: pd.DataFrame) -> pd.Series:
    """Compute distances of means from measured ranges; an upper bound is off only if too small."""
    below = (table.measured_low - table.value).clip(lower=0.0)
    above = (table.value - table.measured_high).clip(lower=0.0)
    return below + above.where(table.observable != "contact_share", 0.0)


def _with_joints(rows: pd.Series) -> str:
    """Name observables, each with the joints in the rows; "none" without rows."""
    joints = rows.index.to_frame(index=False).groupby("observable").joint
    named = {name: ", ".join(map(str, sorted(part))) for name, part in joints}
    titles = {name: title.partition(" (")[0] for name, title in JUDGED.items()}
    return (
        "; ".join(f"{titles[name]} ({named[name]})" for name in JUDGED if name in named) or "none"
    )


def agreeing(observable: str, variant: str = DEFAULT, walls: str = "mated") -> str:
    """Count the joints that agree in an observable, of all: "1 of 3"."""
    return _hits(rows_of(stored(*_RUN), variant=variant, walls=walls, observable=observable))


def mean(observable: str, joint: int, variant: str = DEFAULT) -> str:
    """Give the mean of an observable for walls fitted to one joint."""
    rows = {"variant": variant, "walls": "mated", "observable": observable, "joint": joint}
    return _mean(rows_of(stored(*_RUN), **rows).iloc[0])


def bounds(quantity: str, joint: int) -> str:
    """Give the measured range of a quantity of a joint."""
    rows = {"observable": quantity, "joint": joint, "variant": DEFAULT, "walls": "mated"}
    return written("{measured_low:g} to {measured_high:g}", Group(rows_of(stored(*_RUN), **rows)))


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


def left_out() -> str:
    """Tabulate the predicted intervals of the joint that was left out."""
    table = stored("measured_joints", "measured_joints_predictions").astype({"fitted_to": str})
    table = table[table.fitted_to.str.contains("+", regex=False)]
    lines = []
    for joint, part in table.groupby("joint"):
        line = {"predicted joint": str(joint)}
        for row in part.itertuples():
            known = f"{row.measured_low:g} to {row.measured_high:g}"
            line[OBSERVABLES[row.observable]] = f"{row.low:.3g} to {row.high:.3g} ({known})"
        lines.append(line)
    return markdown(pd.DataFrame(lines))
