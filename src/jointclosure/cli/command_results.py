"""Results of a simulated joint that commands print and write: tables, remarks, status and files."""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.ensembles.quantities import CURVES, QUANTITIES, shown_as
from jointclosure.exports.joint_files import NET, joint_files
from jointclosure.exports.loading import Exported
from jointclosure.inputs.remarks import caution
from jointclosure.joint.history import history_of, with_snapshots
from jointclosure.joint.laws import JointLaws, fitted_laws, law_curves
from jointclosure.joint.result_tables import (
    HYDRAULIC,
    columns_of,
    has_bands,
    wider_columns_of,
)
from jointclosure.joint.status import LOADING, ONLY_BOUNDS, failed, flags_of
from jointclosure.statistics.number_texts import number_text, significant, with_equal_decimals
from jointclosure.storage.folders import replace_files, write
from jointclosure.storage.provenance import origin, to_plain
from jointclosure.uncertainty.budget import MEASURED, NOT_MODELLED, ROUNDING, UNDETERMINED, Budget
from jointclosure.uncertainty.ranged_results import (
    APERTURE,
    CLOSURE_NET,
    CONTACT,
    FITTED,
    KNI,
    RANGED_RESULTS,
    STIFFNESS,
    VM,
    results_of,
    table_of,
)
from jointclosure.uncertainty.ranges import MEANT, RANGE_FLOW_STATUS

ENDED_WELL = "the simulation ended as it should, but"
"""Words before the flags of a status that is not a failure."""
_BOUNDS = (
    "the hydraulic aperture is left empty there, and its bounds are smallest_hydraulic and "
    "largest_hydraulic; they are to be used, or a lower maximum stress"
)
_REASONS = {
    "blocked": (
        "the flow is blocked at {steps}: no open cells connect both sides, as a cell in contact is "
        "shut whole, although contacts are smaller than cells; the upper bound is that of lines "
        "across the flow whose open cells are all connected"
    ),
    "at_least": (
        "the flow is known from below only at {steps}: cells that are about 2e-5 times as open as "
        f"their neighbours count as closed, and may pass more water; {_BOUNDS}"
    ),
    "not_solved": (
        "the flow is not solved at {steps}: the mass balances of the cells miss the inflow by up "
        "to {imbalance:.1g} of it, where {allowed:g} is allowed, as apertures differ by too much "
        f"for double precision; {_BOUNDS}"
    ),
}
"""Why the hydraulic aperture is 0, or why only bounds of it are known, by the status of a flow."""
_NO_RANGE_OF_LAWS = (
    "Barton-Bandis values have no range, because JRC and JCS are taken as exact and the law states "
    "no error"
)
_WITHOUT_FLOW = (
    "apertures are mechanical; hydraulic aperture and transmissivity are computed only with --flow "
    "(flow=True in Python)"
)
_MEAN_OF_DIRECTIONS = (
    "hydraulic aperture and transmissivity in the tables are of the geometric mean of the "
    "hydraulic apertures along x and y"
)
_NO_RANGE_OF_DIRECTIONS = (
    "; those along x and y alone have no range, because it is computed for their mean only"
)
_WIDER_SHOWN = (CLOSURE_NET, STIFFNESS, APERTURE, CONTACT)
"""Results whose range with other choices of the model is printed; joint.json has those of all."""
_CLOSURE = "closure_net_since_seating_mm"
"""Curve that has a value at every stress that a loading reached."""
_NAMED = (
    (_CLOSURE, "normal_stiffness_net_MPa_per_mm", "mean_aperture_mm"),
    ("hydraulic_aperture_mm", "largest_hydraulic_mm"),
    ("transmissivity_m2_per_s", "largest_transmissivity_m2_per_s"),
)
"""Curves whose values on loading are printed at the stresses that a user names, by table."""
_FLOW = tuple(name for table in _NAMED[1:] for name in table)
"""Curves of flow whose values at the maximum stress are rows of the table of results."""


def summary(
    closed: xr.Dataset,
    laws: JointLaws,
    curves: pd.DataFrame,
    budget: Budget | None = None,
    at: Sequence[float] = (),
) -> tuple[str, dict[str, Any]]:
    """Return the results of a simulated joint as text for the screen, and as a record for JSON.

    Both have the results of each cycle, those at the stresses ``at`` [Pa] that a user named, and
    remarks. ``curves`` are those of `stress_table`, with bands if a range was simulated; ``budget``
    is this range.
    """
    of_laws = laws.sentence()
    if budget and laws.by_cycle:
        of_laws += f"; {_NO_RANGE_OF_LAWS}"
    comparison = [of_laws, *_hyperbola_remarks(closed)]
    if budget:
        comparison.insert(0, MEASURED)
    apertures = _overlap_remarks(closed)
    if history_of(closed).has_flow:
        apertures += [*_flow_remarks(closed), *_stresses_without_aperture(curves)]
        apertures.append(_MEAN_OF_DIRECTIONS + (_NO_RANGE_OF_DIRECTIONS if budget else ""))
    else:
        apertures.append(_WITHOUT_FLOW)
    remarks = {
        "What the range is due to, and what it leaves out": budget.sentences() if budget else [],
        "Measured joints and laws": comparison,
        "Apertures": apertures,
    }
    table = result_table(closed, laws, curves, budget)
    seating = 1e-6 * closed.attrs["seating_stress_Pa"]
    head = (
        "Gross closure contains the elastic indentation of the half-spaces, and net closure does "
        f"not. Closures count from {seating:g} MPa."
    )
    if budget is not None:
        head += f" Brackets are ranges, which are {MEANT}."
    notes = budget.notes() if budget is not None else []
    lines = ["", "Results", head, table.to_string(), *notes]
    choices = list(budget.choices) if budget is not None else []
    wider = pd.DataFrame()
    if budget is not None and choices:
        wider = budget.wider_table()
        shown = wider.loc[[RANGED_RESULTS[name] for name in _WIDER_SHOWN]]
        wider = wider.rename(index=_of_hyperbola(closed))
        lines += ["", _as_heading(budget.wider_title()), shown.to_string()]
    named = named_table(curves, at)
    if len(named):
        lines += ["", "On loading, at the stresses that are named", *_in_parts(named)]
    wider_named = named_table(curves, at, with_choices=True)
    if len(wider_named) and budget is not None:
        lines += ["", f"The same, {budget.wider_title()}", *_in_parts(wider_named)]
    if budget is None:
        for heading, about in remarks.items():
            lines += _section(heading, about)
    else:
        lines += _section("Remarks", [*budget.main_sentences(), *comparison, *apertures])
    answer = {
        "table": table.to_dict(),
        "notes_of_table": notes,
        "with_other_choices": wider.to_dict(),
        "choices": choices,
        "at": named.to_dict("records"),
        "at_with_other_choices": wider_named.to_dict("records"),
        "remarks": [remark for about in remarks.values() for remark in about],
    }
    return "\n".join(lines), answer


def _section(heading: str, remarks: Sequence[str]) -> list[str]:
    """Return an empty line, a heading and a line for each remark; no lines without remarks."""
    return ["", heading, *(f"- {remark}" for remark in remarks)] if remarks else []


def _as_heading(text: str) -> str:
    """Return a text with a capital letter at its start."""
    return text[:1].upper() + text[1:]


def _hyperbola_remarks(closed: xr.Dataset) -> list[str]:
    """Return cautions about loadings whose largest closure exceeds the Vm of their hyperbola."""
    closures = law_curves(closed)
    laws = fitted_laws(closed, ["hyperbolic"], [LOADING])
    remarks: list[str] = []
    for row in laws[laws.parameter == "vm_mm"].itertuples():
        largest = closures[row.cycle, LOADING][1].max()
        if row.value < largest:
            remarks.append(
                caution(
                    f"a hyperbola does not describe the loading of cycle {row.cycle}: the fitted "
                    f"Vm of {row.value:.3g} mm is below the largest closure of {largest:.3g} mm, "
                    f"and the hyperbola misses the closures by {1e3 * row.rms_mm:.2g} um rms; "
                    "the curve is to be used in place of kni and Vm"
                )
            )
    return remarks


def _overlap_remarks(closed: xr.Dataset) -> list[str]:
    """Return cautions about cycles at whose maximum stress contacts overlap too much.

    It is too much if the mean overlap over all cells exceeds the mean aperture.
    """
    remarks: list[str] = []
    for cycle in history_of(closed).cycles:
        if not cycle.unloading.has_steps:
            continue
        at_maximum = closed.isel(step=cycle.unloading.steps[0])
        overlap = 1e3 * float(at_maximum.mean_overlap)
        aperture = 1e3 * float(at_maximum.mean_aperture)
        if overlap > aperture:
            left = f"more than the mean aperture of {aperture:.2g} mm that is left"
            if aperture <= ROUNDING:
                left = "and no aperture is left"
            pressed = (
                f"at the maximum of cycle {cycle.number} contacts are pressed into each other by "
                f"{overlap:.2g} mm on average over all cells, {left}: "
                "the model of separate asperities does not hold there, and closure and aperture "
                "are to be used at lower stresses only"
            )
            remarks.append(caution(pressed))
    return remarks


def named_table(
    curves: pd.DataFrame, at: Sequence[float], with_choices: bool = False
) -> pd.DataFrame:
    """Return a table of curves on loading at the stresses ``at`` [Pa], as texts for the screen.

    It has a row for each cycle and stress that the cycle reached, and each value with its band, if
    ``curves`` have bands. ``with_choices``: it has only the bands with other choices of the model;
    it is empty if ``curves``, as those of a single run, have none.
    """
    known = (curves.branch == LOADING) & curves.normal_stress_MPa.isin(np.asarray(at) / 1e6)
    rows = curves[known].dropna(subset=columns_of(curves, _CLOSURE))  # that the cycle reached
    if rows.empty or (with_choices and not wider_columns_of(curves, _CLOSURE)):
        return pd.DataFrame()
    shown = rows[["cycle", "normal_stress_MPa"]].rename(
        columns={"normal_stress_MPa": "normal stress (MPa)"}
    )
    figures = 2 if has_bands(curves) else 4
    for name in (name for names in _NAMED for name in names):
        if name in curves and with_choices:
            shown[CURVES[name][0]] = _wider_bands(rows, name)
        elif name in curves:
            shown[CURVES[name][0]] = with_bands(rows, name, figures)
    return shown


def _in_parts(named: pd.DataFrame) -> list[str]:
    """Return the table of `named_table` as texts: one for each part that fits on a screen."""
    keys = list(named.columns[:2])
    parts = []
    for names in _NAMED:
        titles = [CURVES[name][0] for name in names if CURVES[name][0] in named]
        if titles:
            parts.append(named[[*keys, *titles]].to_string(index=False))
    return parts


def _of_hyperbola(closed: xr.Dataset) -> dict[str, str]:
    """Return headings of kni and Vm with the stress from which the hyperbola was fitted.

    They are by the headings that they replace.
    """
    where = f"of the hyperbola fitted from {1e-6 * history_of(closed).seating_stress:g} MPa"
    return {RANGED_RESULTS[KNI]: f"kni {where} (MPa/mm)", RANGED_RESULTS[VM]: f"Vm {where} (mm)"}


def result_table(
    closed: xr.Dataset, laws: JointLaws, curves: pd.DataFrame, budget: Budget | None = None
) -> pd.DataFrame:
    """Return the table of results as texts: a row for each result, a column for each cycle.

    Values have their ranges if there is a ``budget``. Further columns have the values of the law of
    Barton and Bandis. Rows of flow at the maximum stress follow if the flow was computed.
    """
    results = results_of(closed).set_index("cycle")

    def text(cycle: int, name: str) -> str:
        value = float(results.loc[cycle, name])
        if name in FITTED and np.isnan(value):
            return UNDETERMINED
        if name == APERTURE and value <= ROUNDING:
            return "0"
        return NOT_MODELLED if abs(value) <= ROUNDING else number_text(value)

    table = budget.table() if budget else table_of(results.index, text)
    for title, values in law_values(closed, laws).items():
        table[title] = [significant(values[n], 2) if n in values else "" for n in RANGED_RESULTS]
    table = table.rename(index=_of_hyperbola(closed))
    reached = curves[curves.branch == LOADING].dropna(subset=columns_of(curves, _CLOSURE))
    highest = reached.groupby("cycle").tail(1).set_index("cycle").reindex(curves.cycle.unique())
    for name in _FLOW if history_of(closed).has_flow else ():
        title = CURVES[name][0].replace(" (", ", at the maximum stress (")
        table.loc[title] = [
            *with_bands(highest, name, 2 if budget else 4),
            *[""] * len(laws.by_cycle),
        ]
    return table


def with_bands(curves: pd.DataFrame, name: str, figures: int) -> pd.Series:
    """Return a quantity of `stress_table` as texts, one for each row of ``curves``.

    A value is followed by its band in brackets if the table has bands, and if they have a width.
    """
    columns = columns_of(curves, name)
    values = _without_rounding(curves[columns], name)
    texts = [with_equal_decimals(row, figures) for row in values.to_numpy()]
    # a value that is fixed by definition, such as the closure at seating, has no range
    same = ~(values.max(axis=1) > values.min(axis=1))
    shown = [
        row[0] if no_range else f"{row[0]} ({' to '.join(row[1:])})"
        for row, no_range in zip(texts, same, strict=True)
    ]
    return pd.Series(shown, curves.index, dtype=str)


def _wider_bands(curves: pd.DataFrame, name: str) -> pd.Series:
    """Return the bands of a quantity with other choices of the model, as one text for each row."""
    values = _without_rounding(curves[[name, *wider_columns_of(curves, name)]], name)
    texts = (with_equal_decimals(row)[1:] for row in values.to_numpy())
    shown = [low if low == high else f"{low} to {high}" for low, high in texts]
    return pd.Series(shown, curves.index, dtype=str)


def _without_rounding(values: pd.DataFrame, name: str) -> pd.DataFrame:
    """Return values of a quantity of `stress_table`, with 0 for values that are only rounding.

    Only lengths [mm] are changed: those of at most `ROUNDING`.
    """
    least = ROUNDING if name.endswith("_mm") else 0.0
    return values.where(~(values.abs() <= least), 0.0)


def law_values(closed: xr.Dataset, laws: JointLaws) -> dict[str, dict[str, float]]:
    """Return the results of a joint by the laws of Barton and Bandis, in the units of tables.

    They are by the title of the cycle's law, and then by the name of the column of the result.
    """
    maxima = history_of(closed).maxima
    values: dict[str, dict[str, float]] = {}
    for cycle, law in laws.by_cycle.items():
        of_cycle = values[f"Barton-Bandis, cycle {cycle}"] = {}
        for name, value in law.results(float(maxima[cycle - 1]), laws.seating).items():
            column, scale = shown_as(name, QUANTITIES[name].unit)
            of_cycle[column] = scale * value
    return values


def _flow_remarks(closed: xr.Dataset) -> list[str]:
    """Return remarks on the hydraulic apertures at the maximum stress of each cycle.

    Further remarks count the steps whose flow is blocked or is known only by bounds.
    """
    from jointclosure.joint.flow import LARGEST_IMBALANCE  # loads scipy's sparse matrices

    remarks = []
    history = history_of(closed)
    statuses = history.flow_statuses
    for cycle in history.cycles:
        parts = []
        for step in cycle.unloading.steps[:1]:
            for along, status in zip(closed.direction.values, statuses[step], strict=True):
                at = closed.isel(step=step).sel(direction=along)
                value, least, most = (1e3 * float(at[name]) for name in HYDRAULIC)
                text = f"{value:.3g}"
                if status == "blocked":
                    text += f", upper bound {most:.2g}"
                elif status in ONLY_BOUNDS:
                    text = f"between {least:.2g} and {most:.2g}"
                parts.append(f"along {along} {text} ({status})")
        about_cycle = f"cycle {cycle.number}: {'; '.join(parts)}"
        remarks.append(f"hydraulic aperture at the maximum (mm) and flow_status, {about_cycle}")
    steps = len(statuses)
    imbalance = closed.flow_imbalance.values
    for status, reason in _REASONS.items():
        here = statuses == status
        if count := int(here.any(axis=1).sum()):
            about = {"imbalance": imbalance[here].max(), "allowed": LARGEST_IMBALANCE}
            text = reason.format(steps=f"{count} of {steps} steps", **about)
            remarks.append(caution(text) if status in ONLY_BOUNDS else text)
    return remarks


def _stresses_without_aperture(curves: pd.DataFrame) -> list[str]:
    """Return remarks on the stresses of `stress_table` without a hydraulic aperture or its range.

    There the flow is blocked, or only bounds of the aperture are known.
    """
    reached = curves.dropna(subset=[_CLOSURE])
    aperture = reached.hydraulic_aperture_mm
    cases = {
        "the hydraulic aperture is 0, as the flow is blocked,": aperture == 0.0,
        "only bounds of the hydraulic aperture are known": aperture.isna(),
    }
    if RANGE_FLOW_STATUS in reached:
        unknown = reached[RANGE_FLOW_STATUS].isin(ONLY_BOUNDS) & aperture.notna()
        no_range = (
            "the range of the hydraulic aperture is left empty, as at least one simulation of the "
            "range gives only bounds there,"
        )
        cases[no_range] = unknown
    remarks = []
    for what, here in cases.items():
        parts = []
        for (cycle, branch), rows in reached.groupby(["cycle", "branch"], sort=False):
            chosen = here[rows.index].to_numpy()
            if chosen.any():
                stresses = _intervals(rows.normal_stress_MPa.to_numpy(), chosen)
                parts.append(f"cycle {cycle}, {branch}: {stresses}")
        if parts:
            remarks.append(f"{what} at these stresses of answer.csv (MPa): {'; '.join(parts)}")
    return remarks


def _intervals(stresses: np.ndarray, chosen: np.ndarray) -> str:
    """Return the ``chosen`` ones of increasing stresses as text, such as "1, 3 to 5".

    Of three or more neighbouring stresses in a row only the first and the last are named.
    """
    parts = []
    changes = np.flatnonzero(np.diff(chosen)) + 1
    runs = zip(np.split(stresses, changes), np.split(chosen, changes), strict=True)
    for run, of_run in runs:
        texts = [f"{stress:g}" for stress in run]
        if of_run.any():
            parts.append(f"{texts[0]} to {texts[-1]}" if len(texts) > 2 else ", ".join(texts))
    return ", ".join(parts)


def status_text(closed: xr.Dataset) -> str:
    """Return "success" or "failed" with the names of the flags of a joint's status, for files."""
    remarks = ", ".join(flag.name for flag in flags_of(int(closed.status)))
    word = "failed" if failed(closed) else "success"
    return f"{word}: {remarks}" if remarks else word


def status_lines(closed: xr.Dataset) -> list[str]:
    """Return the status of a joint as lines for the screen.

    The first line has the status, further ones the meaning and remedy of each of its flags.
    """
    flags = flags_of(int(closed.status))
    outcome = "failed" if failed(closed) else ENDED_WELL
    return [
        f"{outcome}: {', '.join(flag.words for flag in flags)}" if flags else "success",
        *(f"- {flag.meaning}; {flag.remedy} (status {flag.name})".replace("`", "")
          for flag in flags),
    ]  # fmt: skip


def attributes(settings: Mapping[str, Any]) -> dict[str, str]:
    """Return the provenance of a command's results as texts by name.

    It has the code, the versions, the machine, and the ``settings`` (keywords) as JSON.
    """
    return origin() | {"settings": json.dumps(to_plain(settings), default=str)}


def scaled(values: Any, scale: float = 1.0) -> Any:
    """Return numbers times ``scale`` for JSON, with None (null) for those that are not finite.

    It is a list, or for a named tuple a mapping of its fields.
    """
    known = [scale * float(value) if np.isfinite(value) else None for value in values]
    return dict(zip(values._fields, known, strict=True)) if hasattr(values, "_fields") else known


def plain(column: pd.Series) -> list[Any]:
    """Return a column of a table as a list for JSON, with None (null) for numbers not finite."""
    return scaled(column) if pd.api.types.is_numeric_dtype(column) else column.tolist()


def kept_stresses(
    snapshots: tuple[float, ...], animation: Path | None, stress: Any
) -> tuple[float, ...]:
    """Return the stresses [Pa] at which snapshots are kept: those requested, and those of frames.

    Frames are those of an ``animation``, if one is requested, up to the largest ``stress`` [Pa].
    """
    if animation is None:
        return snapshots
    from jointclosure.plotting.snapshots import animated_stresses

    return (*snapshots, *animated_stresses(np.max(stress)))


def write_animation(closed: xr.Dataset, arguments: argparse.Namespace, title: str) -> xr.Dataset:
    """Write the requested animation of a joint; return the joint with the requested snapshots only.

    Without a request nothing is written, and the joint is returned as it is.
    """
    if arguments.animation is None:
        return closed
    from jointclosure.plotting.snapshots import crushing_animation

    if closed.sizes["snapshot"]:
        write(crushing_animation(closed, title), arguments.animation)
        print(f"wrote {arguments.animation}")
    return with_snapshots(closed, arguments.snapshots)


def exported(
    joint: xr.Dataset,
    title: str,
    curves: pd.DataFrame,
    laws: JointLaws,
    cycle: int,
    in_list: bool = False,
) -> Exported:
    """Return the files of a joint for other programs, with a figure of them; print the remarks.

    The remarks on the files continue a list that was printed before (``in_list``), or follow a
    heading. ``cycle`` is that of the constants, see `joint_files`.
    """
    known = joint_files(joint, curves, laws, cycle)
    lines = _section("Files", known.remarks)
    if in_list:
        lines = [f"- {line}" for line in known.remarks if line != NET]
    for line in lines:
        print(line)
    if not known.files:
        return known
    from jointclosure.plotting.joint import engineering_figure

    figure = engineering_figure(joint, title, curves, laws.by_cycle)
    return known._replace(files=known.files | {"engineering.png": figure})


def write_folder(folder: Path, command: str, files: Mapping[str, Any]) -> str:
    """Write files into a folder, in the place of those of the command's earlier run there.

    Return the line for the screen that names them.
    """
    replace_files(folder, command, files)
    return f"wrote {folder}: {', '.join(sorted(files)) or 'no file'}"
