"""Tables of docs/effects.md."""

import pandas as pd
import scipy
from stored import stored

from content.markdown import Table, markdown

CHOICE = {
    "something was left out, of {scenes:.0f} conditions": "{changed:.0f}",
    "error within the tolerance (% of all)": "{held_percent:.0f}",
    "where something was left out (%)": "{held_of_changed_percent:.0f}",
    "largest error (%)": "{largest_error_percent:.1f}",
    "time saved, of all conditions together (%)": "{saved_percent:.1f}",
    "by the best scenes (%)": "{best_saved_percent:.1f}",
    "time saved, mean over conditions (%)": "{mean_saved_percent:.1f}",
    "by the best scenes, mean (%)": "{best_mean_saved_percent:.1f}",
    "regret, median": "{median_regret:.2f}",
    "time saved where it is least (%)": "{least_saved_percent:.0f}",
    "largest time lost by a pilot where all effects act (%)": "{largest_lost_percent:.1f}",
    "effectivity index, median": "{effectivity:.1f}",
    "from 1 to 5 (% of the selections that left something out)": "{effectivity_good_percent:.0f}",
    "below 1, true error above the estimate (% of the same)": "{effectivity_below_percent:.0f}",
}
"""Rows of the table of choices: their titles, and forms of their numbers."""
EFFECTS = ("interaction", "soft_peaks", "gouge", "breakage", "substrate")
ADDED = {
    "max. closure (%)": "max_closure",
    "residual closure (%)": "residual_closure",
    "hysteresis (% of work)": "hysteresis",
    "time with / without": "time_ratio",
}


def choice() -> str:
    """Tabulate how the chosen effects held, a column for each tolerance and number of joints."""
    columns = stored("effects_auto", "effects_auto_summary").to_dict("records")
    rows = [
        {"": title.format_map(columns[0])}
        | {
            f"{100.0 * row['tolerance']:g} %, {row['joints']} joints": form.format_map(row)
            for row in columns
        }
        for title, form in CHOICE.items()
    ]
    return markdown(pd.DataFrame(rows))


AIMS = {
    "error within the tolerance in at least 95 % of the conditions": ("held_percent", 95.0),
    "at least 80 % of what the best scenes save, of all together": ("share_of_best_percent", 80.0),
    "the same, mean over the conditions": ("mean_share_of_best_percent", 80.0),
    "no time lost over all conditions": ("saved_percent", 0.0),
    "effectivity index from 1 to 5 in nine of ten": ("effectivity_good_percent", 90.0),
}
"""Aims of the selection: the column of its summary, and the least value."""
LOST = "where all effects act, a pilot loses at most 1 %, or the time of one joint if that is more"


def interval(percent: float, scenes: float) -> str:
    """Write the 95 % interval (Wilson 1927) of a share [%] of a number of conditions."""
    test = scipy.stats.binomtest(round(0.01 * percent * scenes), round(scenes))
    low, high = test.proportion_ci(method="wilson")
    return f"{100.0 * low:.0f} to {100.0 * high:.0f}"


def aims() -> str:
    """Tabulate at which tolerances the aims are met (%), a column for each number of joints."""
    table = stored("effects_auto", "effects_auto_summary")
    rows = [{"aim": aim} for aim in (*AIMS, LOST)]
    for row in rows:
        column, least = AIMS.get(row["aim"], ("largest_lost_percent", None))
        for joints, part in table.groupby("joints"):
            part = part.sort_values("tolerance")
            values = part[column]
            reached = values <= max(1.0, 100.0 / joints) if least is None else values >= least
            met = "met" if reached.all() else "partly met" if reached.any() else "**not met**"
            texts = [f"{value:.1f}" for value in values]
            if column == "held_percent":
                texts = [
                    f"{text} ({interval(value, scenes)})"
                    for text, value, scenes in zip(texts, values, part.scenes, strict=True)
                ]
            row[f"{joints} joints"] = f"{', '.join(texts)}: {met}"
    return markdown(pd.DataFrame(rows))


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
