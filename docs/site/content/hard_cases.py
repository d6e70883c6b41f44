"""Tables of docs/continuum.md and docs/statuses.md, of the hard cases."""

from content.markdown import Table

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
