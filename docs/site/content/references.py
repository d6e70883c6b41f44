"""Tables that compare with exact solutions, the oracle and other codes, of several pages."""

from stored import ROOT, stored

from content.markdown import Table
from studies.frame.config.files import read_plain
from studies.verification.hard_cases import merged_cases


def hard_cases(kind: str) -> str:
    """Count hard cases: "all", "refused", "checked" by the oracle, or "without a state"."""
    cases = merged_cases(read_plain(ROOT / "studies/verification/hard_cases.yaml")).values()
    refused = sum(case["expect"] == "refused" for case in cases)
    checked = len(stored("hard_cases", "hard_case_errors"))
    counts = {"all": len(cases), "refused": refused, "checked": checked}
    return str((counts | {"without a state": len(cases) - refused - checked})[kind])


analytic = Table(
    "hard_cases/analytic",
    {
        "indenter": "{indenter}",
        "cells along the contact's radius": "{cells}",
        "force (%)": lambda group: f"{100 * group['force_error']:+.1f}",
        "order of its error": "{order:.2f}",
        "pressures (%)": lambda group: f"{100 * group['pressure_error']:.0f}",
        "cells in contact (%)": lambda group: f"{100 * group['area_error']:+.0f}",
    },
)
errors = Table(
    "hard_cases/hard_case_errors",
    {
        "cases": lambda group: str(len(group.rows)),
        "forces": "{forces max:.0e}",
        "sum of forces": "{load max:.0e}",
        "strength": "{strength max:.0e}",
    },
    rows={"group": "{group}"},
)
flow = Table(
    "flow/flow",
    {
        "cells": "{cells} x {cells}",
        "code": "{code}",
        "published flux": "{published:.12g}",
        "difference from it": "{relative error of flux:+.0e}",
        "seconds": "{median s:.2g} ({least s:.2g} to {most s:.2g})",
        "over ours": "{over ours:.1f}",
    },
)
