"""Tables of docs/effects.md."""

import pandas as pd
from stored import stored

from content.markdown import listed, markdown

CHOICE = {
    "changed": ("something was left out, of {scenes:.0f} conditions", "{:.0f}"),
    "held_percent": ("error within the tolerance (% of all)", "{:.0f}"),
    "largest_error_percent": ("largest error (%)", "{:.1f}"),
    "saved_percent": ("time saved, of all conditions together (%)", "{:.1f}"),
    "saved_where_changed_percent": ("where something was left out (%)", "{:.0f}"),
    "saved_where_unchanged_percent": ("where all effects act (%)", "{:.1f}"),
    "pilot_percent": ("time of the pilots, of all (%)", "{:.1f}"),
    "largest_pilot_percent": ("largest, where all effects act (%)", "{:.1f}"),
    "least_saved_percent": ("time saved where it is least (%)", "{:.0f}"),
    "timing_scatter_percent": ("scatter of times where both did the same (%)", "{:.1f}"),
}
"""Rows of the table of choices: their titles, and formats of their numbers."""
ADDED = {
    "max_closure": "max. closure (%)",
    "residual_closure": "residual closure (%)",
    "hysteresis": "hysteresis (% of work)",
    "time_ratio": "time with / without",
}


def choice() -> str:
    """Tabulate how the chosen effects held, a column for each tolerance."""
    table = stored("effects", "effects_auto_summary")
    tolerances = table.tolerance.map(lambda share: f"tolerance {100.0 * share:g} %")
    rows = [
        {"": title.format(scenes=table.scenes[0])}
        | dict(zip(tolerances, table[name].map(form.format), strict=True))
        for name, (title, form) in CHOICE.items()
    ]
    return markdown(pd.DataFrame(rows))


def contributions() -> str:
    """Tabulate what effects add, by stress: medians over rocks and roughness, and extremes."""
    columns = {
        "effect": "{effect}",
        "cycle": "{cycle}",
        "stress (MPa)": "{stress_MPa}",
        "conditions": "{known} of {conditions}",
    }
    for name, title in ADDED.items():
        columns[title] = f"{{{name}:.1f}} ({{{name}_least:.1f}} to {{{name}_largest:.1f}})"
    return listed(stored("effects", "effects_contributions"), columns)


def idle_interaction() -> str:
    """Tabulate what leaving the idle interaction out saves and changes."""
    table = stored("idle_interaction", "idle_interaction")
    changed = [name.removesuffix(" +- %") for name in table if name.endswith(" +- %")]
    columns = {
        "rock": "{rock}",
        "tolerance (%)": "{share %:g}",
        "left out up to (% of 30 MPa)": "{left out up to (% of 30 MPa):.0f}",
        "time saved (%)": "{time saved %:.0f} ± {time saved +- %:.0f}",
        "products saved (%)": "{products saved %:.0f} ± {products saved +- %:.0f}",
    }
    for name in changed:
        if not name.endswith(" saved"):
            columns[f"closure, {name} (%)"] = f"{{{name} %:+.2f}} ± {{{name} +- %:.2f}}"
    columns["single joints beyond the tolerance (%)"] = "{single closures beyond %:.0f}"
    columns["largest change of one (%)"] = "{largest of single closures %:.0f}"
    return listed(table, columns)
