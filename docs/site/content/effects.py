"""Tables of docs/effects.md."""

import pandas as pd
import scipy
from stored import stored

from content.markdown import Table, markdown

CHOICE = {
    "something was left out, of {scenes:.0f} conditions": "{changed:.0f}",
    "error within the tolerance (% of all, 95 % interval)": "{held_percent:.0f} ({held_interval})",
    "largest error (%)": "{largest_error_percent:.1f}",
    "time saved, of all conditions together (%)": "{saved_percent:.1f}",
    "by the best scenes (%)": "{best_saved_percent:.1f}",
    "time saved where it is least (%)": "{least_saved_percent:.0f}",
    "largest time lost by a pilot where all effects act (%)": "{largest_lost_percent:.1f}",
}
"""Rows of the table of choices: their titles, and forms of their numbers."""
EFFECTS = ("interaction", "soft_peaks", "gouge", "breakage")


def choice() -> str:
    """Tabulate how the chosen effects held, a column for each tolerance and number of joints."""
    columns = stored("effects_auto", "effects_auto_summary").to_dict("records")
    for row in columns:
        row["held_interval"] = interval(row["held_percent"], row["scenes"])
    rows = [
        {"": title.format_map(columns[0])}
        | {
            f"{100.0 * row['tolerance']:g} %, {row['joints']} joints": form.format_map(row)
            for row in columns
        }
        for title, form in CHOICE.items()
    ]
    return markdown(pd.DataFrame(rows))


def interval(percent: float, scenes: float) -> str:
    """Write the 95 % interval (Wilson 1927) of a share [%] of a number of conditions."""
    test = scipy.stats.binomtest(round(0.01 * percent * scenes), round(scenes))
    low, high = test.proportion_ci(method="wilson")
    return f"{100.0 * low:.0f} to {100.0 * high:.0f}"


regions = Table(
    "effects_auto/effects_regions",
    {"stress / strength": "{from:g} to {to:g}", "conditions": "{conditions}"}
    | {
        f"without {effect.replace('_', ' ')} (%)": (
            f"{{{effect}!p}} ({{{effect}_least!p}} to {{{effect}_largest!p}})"
        )
        for effect in EFFECTS
    },
)
