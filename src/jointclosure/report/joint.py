"""Page on a single joint, from the results of `jointclosure close`."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engineering.curves import KINDS, cycle_table
from jointclosure.engineering.laws import fitted_laws
from jointclosure.engineering.stiffness import stiffness_table
from jointclosure.ensemble.uncertainty import QUANTITIES
from jointclosure.report.page import Picture
from jointclosure.report.sheets import Sheet, number_text, sheet


def joint_content(history: xr.Dataset, record: dict, pictures: list[Picture]) -> dict:
    """Return names and values for the template ``joint.html.j2``.

    ``history`` is that of `simulate`, ``record`` the contents of joint.json.
    """
    cycles, stiffness = cycle_table(history), stiffness_table(history)
    return {
        "title": record.get("title", "a rough joint"),
        "joint": record["joint"].strip("<>").removeprefix("ClosedJoint: "),
        "finding": joint_finding(cycles, stiffness, history, record.get("range", [])),
        "warnings": record.get("warnings", []),
        "about_range": record.get("about_range", []),
        "found": record["found"],
        "status": record["status"],
        "sheets": {
            sheet.name: sheet
            for sheet in [
                *_sheets(cycles, stiffness, history),
                *_range_sheets(record.get("range", [])),
            ]
        },
        "pictures": pictures,
        "digests": record["sha256"],
        "versions": {
            name: value
            for name, value in record["provenance"].items()
            if name != "configuration" and len(str(value)) < 200
        },
    }


def joint_finding(
    cycles: pd.DataFrame, stiffness: pd.DataFrame, history: xr.Dataset, ranges: list[dict]
) -> str:
    """Describe closure, residual closure and stiffness of the joint, net and gross."""
    texts = {(entry["cycle"], entry["quantity"]): entry["text"] for entry in ranges}
    seating = 1e-6 * float(history.attrs["seating_stress_Pa"])
    first = cycles.iloc[0]
    net, gross = (
        texts.get((1, name), number_text(first[name], 3))
        for name in ("closure_net_since_seating_mm", "closure_gross_since_seating_mm")
    )
    text = f"From {seating:g} MPa on the joint closes {net} mm in its first cycle"
    if np.isfinite(first.residual_share_net):
        text += f", of which {100.0 * first.residual_share_net:.0f} % stay"
    known = stiffness[
        (stiffness.branch == "loading")
        & stiffness.normal_stiffness_net_MPa_per_mm.notna()
        & ~stiffness.landing
    ]
    if len(known):
        middle = known.normal_stress_MPa.unique()[known.normal_stress_MPa.nunique() // 2]
        here = known[known.normal_stress_MPa == middle].drop_duplicates("cycle")
        stiffness_words = " and ".join(
            f"{number_text(row.normal_stiffness_net_MPa_per_mm, 3)} MPa/mm in cycle {row.cycle}"
            for row in here.iloc[[0, -1] if len(here) > 1 else [0]].itertuples()
        )
        text += f"; its normal stiffness at {middle:.3g} MPa is {stiffness_words}"
    return (
        f"{text}. These are net; with the elastic indentation of the half-spaces, which is no "
        f"property of the joint, the first cycle closes {gross} mm (gross)."
    )


def _by_stress(stiffness: pd.DataFrame, kind: str) -> pd.DataFrame:
    """Arrange stiffness, net or gross, by stress (rows) and branch (columns)."""
    branch = "Cycle " + stiffness.cycle.astype(str) + ", " + stiffness.branch
    known = stiffness[f"normal_stiffness_{kind}_MPa_per_mm"].where(~stiffness.landing)
    columns = {name: known[branch == name].to_numpy() for name in branch.unique()}
    return pd.DataFrame({"Normal stress (MPa)": stiffness.normal_stress_MPa.unique()} | columns)


def _stiffness_sheet(stiffness: pd.DataFrame, kind: str) -> Sheet:
    by_stress = _by_stress(stiffness, kind)
    return sheet(
        f"stiffness-{kind}",
        f"{kind.capitalize()} normal stiffness kn (MPa/mm) by chords between stresses; a dash "
        "near the maximum of loading, where small steps break less",
        by_stress,
        {name: name for name in by_stress},
    )


def _range_sheets(ranges: list[dict]) -> list[Sheet]:
    """Return the table of ranges, if the joint has them."""
    if not ranges:
        return []
    rows = pd.DataFrame(ranges)
    table = rows.pivot_table("text", "quantity", "cycle", "first").loc[list(QUANTITIES)]
    table.columns = [f"Cycle {cycle}" for cycle in table.columns]
    table.insert(0, "Quantity", [QUANTITIES[name] for name in table.index])
    caption = "Best values and their range over what the model leaves open; closures since seating"
    return [sheet("range", caption, table, {name: name for name in table})]


def _sheets(cycles: pd.DataFrame, stiffness: pd.DataFrame, history: xr.Dataset) -> list[Sheet]:
    per_cycle = {
        "cycle": "Cycle",
        "closure_net_since_seating_mm": "Net closure since seating (mm)",
        "residual_net_at_seating_mm": "Net residual at seating (mm)",
        "residual_share_net": "Its share",
        "closure_gross_since_seating_mm": "Gross closure since seating (mm)",
        "max_closure_gross_mm": "Gross closure from its start (mm)",
        "mean_aperture_at_max_mm": "Mean aperture at the maximum (mm)",
        "contact_at_max": "Cells in contact there",
    }
    of_law = {
        "cycle": "Cycle",
        "branch": "Branch",
        "law": "Law",
        "parameter": "Parameter",
        "value": "Value",
        "standard_error": "Standard error",
        "rms_mm": "Error (mm rms)",
        "holds_from_MPa": "Valid from (MPa)",
        "holds_to_MPa": "to (MPa)",
    }
    return [
        sheet("cycles", "Closure by cycle", cycles, per_cycle),
        *(_stiffness_sheet(stiffness, kind) for kind in KINDS),
        sheet(
            "laws", "Laws fitted to the net closure of each branch", fitted_laws(history), of_law
        ),
    ]
