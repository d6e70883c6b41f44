"""Errors that `jointclosure assess` states of single joints, compared with true ones.

Joints are those of `benchmarks/numerical_error.py`. Each is simulated with all settings of the
assessment, as it is and as copies that should be equal, and once with an eighth of the finest
tolerance, from whose results the true errors are taken. A true error is the factor between a result
and that by an eighth of the finest tolerance, or its inverse, less 1. Joints that take more than
`LONGEST` seconds by the tolerance of `jointclosure close` are left out.

`python benchmarks/assessment_error.py` writes joints.csv, coverage.csv and largest.csv, and goes
on with the joints that its folder has. ``--compare FOLDER ...`` fits the weights of the limit by
the finest setting to the joints of these folders. Those of the package are of joints of seeds 31
and 51.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))


import numpy as np
import pandas as pd
from numerical_error import (
    COUNTS,
    arguments,
    compared_folders,
    fitted_weights,
    joint_of,
    simulated_joints,
    write_coverage,
)

from jointclosure.assessment.assess import assessed_variants, closures_of
from jointclosure.assessment.assessed_results import ASSESSED, JUDGED, STIFFNESS
from jointclosure.assessment.assessment import Assessment
from jointclosure.assessment.finest_error import WEIGHTS
from jointclosure.assessment.numerical_settings import FINEST, LADDER
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import RESOLVED
from jointclosure.storage.files import write_csv
from jointclosure.uncertainty.numerical_error import log_change
from jointclosure.uncertainty.sources import coarser
from jointclosure.uncertainty.variants import COPIES

TRUE = "an eighth of the finest tolerance"
LONGEST = 3.0
"""Processor time [s] by the tolerance of `close` beyond which a joint is left out."""
WITHIN = 0.05


def closed(seed: int, number: int, cells: tuple[int, int]) -> pd.DataFrame:
    """Simulate a joint by all settings; return rows as `Assessment.closures`, none if it fails."""
    conditions, pair = joint_of(seed, number, cells)
    stated, ladder, variants = assessed_variants(conditions._replace(numerics=RESOLVED))
    fine = conditions._replace(numerics=coarser(FINEST, 0.125))
    settings = {name: variants[name] for name in ladder} | {TRUE: fine}
    first = (stated, 0, "as it is")
    others = [(name, 0, copy) for name in ladder for copy in COPIES]
    tasks = [task for task in others if task != first] + [(TRUE, 0, "as it is")]
    try:
        own = closures_of([first], stated, settings, [pair])
    except InputError as error:
        print(f"joint {number}: {error}")
        return pd.DataFrame()
    if own.seconds.max() > LONGEST:
        print(f"joint {number}: left out, as it takes {own.seconds.max():.0f} s")
        return pd.DataFrame()
    return pd.concat([own, closures_of(tasks, stated, settings, [pair])]).assign(joint=number)


def compared(joints: pd.DataFrame) -> pd.DataFrame:
    """Return the stated and the true relative error of each joint, setting, result and cycle.

    ``jump``, ``change`` and ``scatter`` [1] are those from which the error by the finest setting is
    stated, and ``apart`` is the logarithm of the true result over that of the joint as it is.
    """
    rows = []
    for number, of_joint in joints.groupby("joint"):
        closures = of_joint[of_joint.variant != TRUE]
        assessment = Assessment(closures, list(LADDER), list(LADDER)[-2], WITHIN)
        limits = assessment.limits.set_index(["variant", "quantity", "cycle"]).limit
        as_it_is = of_joint[of_joint.copy_of_walls == "as it is"]
        values = as_it_is.set_index(["variant", "cycle"])
        known = assessment.known_of_finest.set_index(["quantity", "cycle"])
        for (name, quantity, cycle), limit in limits.items():
            apart = log_change(values[quantity][name, cycle], values[quantity][TRUE, cycle])
            row = {"joint": number, "setting": name, "result": quantity, "cycle": cycle}
            row |= {"quantity": ASSESSED[quantity], "stated": limit, "true": np.expm1(abs(apart))}
            rows.append(row | {"apart": apart} | known.loc[(quantity, cycle)].to_dict())
    return pd.DataFrame(rows)


def coverage_of(errors: pd.DataFrame) -> pd.DataFrame:
    """Count the true errors within the stated ones by setting, quantity and cycle."""
    errors = errors.dropna(subset=["stated", "true"])
    errors = errors.assign(inside=errors.true <= errors.stated, over=errors.stated / errors.true)
    by_result = errors.groupby(["setting", "quantity", "cycle"], sort=False)
    return by_result.agg(**COUNTS).reset_index()


def largest_of(errors: pd.DataFrame) -> pd.DataFrame:
    """Count the joints whose largest error is within their largest limit, as `assess` prints it.

    A row for each setting, and for closures (net and gross) and stiffness: of all cycles.
    """
    tables = []
    for of, quantities in (("closures", JUDGED), ("stiffness", (STIFFNESS,))):
        known = errors[errors.result.isin(quantities)].dropna(subset=["stated", "true"])
        largest = known.groupby(["setting", "joint"], sort=False)[["stated", "true"]].max()
        largest["inside"] = largest.true <= largest.stated
        largest["over"] = largest.stated / largest.true
        table = largest.groupby("setting", sort=False).agg(
            joints=("inside", "size"), inside=("inside", "sum"), stated_over_true=("over", "median")
        )
        tables.append(table.reset_index().assign(of=of))
    return pd.concat(tables, ignore_index=True)


def main() -> None:
    asked = arguments(__doc__, "assessment_error")
    if asked.compare:
        errors = compared_folders(asked.compare, compared)
        finest = errors[errors.setting == list(LADDER)[-1]]
        table = fitted_weights(finest, ("jump", "change", "scatter"), WEIGHTS)
        print(table.to_string(index=False, float_format="{:.3g}".format))
        return
    errors = compared(simulated_joints(asked, closed))
    write_csv(largest_of(errors), asked.output / "largest.csv")
    write_coverage(asked, coverage_of(errors), LONGEST)


if __name__ == "__main__":
    main()
