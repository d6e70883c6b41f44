"""Tables of docs/effects.md."""

import pandas as pd
from stored import stored

from content.markdown import Table, markdown

CHOICE = {
    "something was left out, of {scenes:.0f} conditions": "{changed:.0f}",
    "error within the tolerance (% of all)": "{held_percent:.0f}",
    "largest error (%)": "{largest_error_percent:.1f}",
    "time saved, of all conditions together (%)": "{saved_percent:.1f}",
    "where something was left out (%)": "{saved_where_changed_percent:.0f}",
    "where all effects act (%)": "{saved_where_unchanged_percent:.1f}",
    "time of the pilots, of all (%)": "{pilot_percent:.1f}",
    "largest, where all effects act (%)": "{largest_pilot_percent:.1f}",
    "time saved where it is least (%)": "{least_saved_percent:.0f}",
    "scatter of times where both did the same (%)": "{timing_scatter_percent:.1f}",
}
"""Rows of the table of choices: their titles, and forms of their numbers."""
ADDED = {
    "max. closure (%)": "max_closure",
    "residual closure (%)": "residual_closure",
    "hysteresis (% of work)": "hysteresis",
    "time with / without": "time_ratio",
}
CHANGES = ("cycle 1", "cycle 2", "loading, 1 MPa", "loading, 3 MPa", "loading, 10 MPa")


def choice() -> str:
    """Tabulate how the chosen effects held, a column for each tolerance."""
    columns = stored("effects", "effects_auto_summary").to_dict("records")
    rows = [
        {"": title.format_map(columns[0])}
        | {f"tolerance {100.0 * row['tolerance']:g} %": form.format_map(row) for row in columns}
        for title, form in CHOICE.items()
    ]
    return markdown(pd.DataFrame(rows))


contributions = Table(
    "effects/effects_contributions",
    {
        "effect": "{effect}",
        "cycle": "{cycle}",
        "stress (MPa)": "{stress_MPa}",
        "conditions": "{known} of {conditions}",
    }
    | {
        title: f"{{{name}:.1f}} ({{{name}_least:.1f}} to {{{name}_largest:.1f}})"
        for title, name in ADDED.items()
    },
)
idle_interaction = Table(
    "idle_interaction/idle_interaction",
    {
        "rock": "{rock}",
        "tolerance (%)": "{share %:g}",
        "left out up to (% of 30 MPa)": "{left out up to (% of 30 MPa):.0f}",
        "time saved (%)": "{time saved %:.0f} ± {time saved +- %:.0f}",
        "products saved (%)": "{products saved %:.0f} ± {products saved +- %:.0f}",
    }
    | {f"closure, {name} (%)": f"{{{name} %:+.2f}} ± {{{name} +- %:.2f}}" for name in CHANGES}
    | {
        "single joints beyond the tolerance (%)": "{single closures beyond %:.0f}",
        "largest change of one (%)": "{largest of single closures %:.0f}",
    },
)
