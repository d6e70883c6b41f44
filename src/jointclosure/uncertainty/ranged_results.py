"""Results of a joint that have a range, as `close` prints them: names, headings, values."""

from collections.abc import Callable, Iterable

import pandas as pd
import xarray as xr

from jointclosure.ensembles.quantities import HEADINGS
from jointclosure.joint.cycle_results import net_responses
from jointclosure.joint.laws import loading_hyperbolas
from jointclosure.joint.result_tables import cycle_table

RESIDUAL_NET = "residual_closure_seated_net_mm"
CLOSURE_NET = "max_closure_seated_net_mm"
CLOSURE_GROSS = "max_closure_seated_mm"
CONTACT = "contact_at_max"
STIFFNESS = "stiffness_net_MPa_per_mm"
KNI = "kni_net_MPa_per_mm"
VM = "vm_net_mm"
FITTED = KNI, VM  # constants of the hyperbola of loading
APERTURE = "mean_aperture_at_max_mm"
UNRESOLVED = 0.005
"""Residual closure over the net closure of a cycle, up to which it is the error of the steps."""
RANGED_RESULTS = {
    column: HEADINGS[column]
    for column in (
        CLOSURE_NET,
        RESIDUAL_NET,
        CLOSURE_GROSS,
        STIFFNESS,
        KNI,
        VM,
        APERTURE,
        CONTACT,
    )
}
"""Headings of results with a range, by column of `results_of`."""


def results_of(history: xr.Dataset) -> pd.DataFrame:
    """Return the table of the results of a joint that have a range, a row for each cycle.

    Its columns are ``cycle`` and those of `RANGED_RESULTS`, in the units of their names. The joint
    must not have failed.
    """
    table = cycle_table(history)
    stiffness = net_responses(history)["stiffness_net"]
    table[STIFFNESS] = 1e-9 * stiffness[table.cycle - 1]
    hyperbolas = loading_hyperbolas(history, table.cycle)
    table[[KNI, VM]] = hyperbolas[["kni_MPa_per_mm", "vm_mm"]].to_numpy()
    return table[["cycle", *RANGED_RESULTS]]


def table_of(cycles: Iterable[int], text: Callable[[int, str], str]) -> pd.DataFrame:
    """Return a table of texts of results: a row for each of `RANGED_RESULTS`, a column per cycle.

    ``text`` returns the text of a result by its cycle and column.
    """
    columns = {f"cycle {cycle}": [text(cycle, name) for name in RANGED_RESULTS] for cycle in cycles}
    return pd.DataFrame(columns, index=list(RANGED_RESULTS.values()))
