"""The table of a study of readings: likelihood, scatter, elasticities and claims of each."""

import numpy as np
import pandas as pd

from jointclosure.config.properties import PARAMETERS, PROPERTIES
from jointclosure.experiments.readings.design import AS_CONFIGURED, Readings
from jointclosure.experiments.readings.likelihood import (
    Question,
    implied_scatter,
    probability_of_table_3,
)
from jointclosure.experiments.readings.rounds import closures_of, in_round
from jointclosure.experiments.readings.summary import SCATTER, claims_judged, over_rocks, quantities
from jointclosure.statistics.standard_errors import rounded

_FACTORS = np.linspace(0.1, 1.6, 31)
"""Of all standard deviations, among which the likeliest is looked for."""
SEPARATE = 2.0
"""Standard errors from which on a reading counts as told from the best of its round."""


def last_rounds(ranked: list[pd.DataFrame]) -> dict[str, int]:
    """The last round that each reading entered, those of the last round first, best first."""
    last: dict[str, int] = {}
    for number in range(len(ranked) - 1, -1, -1):
        for name in ranked[number].reading:
            last.setdefault(name, number)
    return last


def readings_table(
    readings: Readings,
    ranked: list[pd.DataFrame],
    joints: pd.DataFrame,
    question: Question,
    confidence: float,
) -> pd.DataFrame:
    """A row for each reading, by its last round.

    Parameters
    ----------
    readings : Readings
    ranked : list of DataFrame
        `jointclosure.experiments.readings.rounds.round_table` of each round.
    joints : DataFrame
        As from `jointclosure.ensemble.points.close_points`, of all rounds.
    question : Question
    confidence : float
        Of the intervals by which claims are judged.

    Returns
    -------
    DataFrame
        reading, title, aspects, allowed, round, rocks, realizations; log_likelihood,
        standard_error, behind, behind_error (to the best of that round), separable; p of the
        joint test and p_error; scatter and elasticities of both cycles with errors
        (``youngs_modulus_2``, ``youngs_modulus_2_error``), means over the rocks closed; claims
        (``claim 2a``). Closures of readings whose run was closed in all rocks are their own; the
        likelihood of others is that of dolerite's changes, say, in all rocks.
    """
    reference = closures_of(readings, AS_CONFIGURED, joints, dict.fromkeys(readings.rocks))
    rows = []
    for name, number in last_rounds(ranked).items():
        one, this = readings.reading(name), readings.rounds[number]
        closed = in_round(readings, number, name, joints)
        found = ranked[number].set_index("reading").loc[name]
        row = {
            "reading": name,
            "title": one.title,
            "aspects": "; ".join(one.aspects),
            "allowed": one.allowed,
            "round": this.name,
            "rocks": "; ".join(this.rocks),
            "realizations": min(each.sizes["realization"] for each in closed.values()),
        }
        row |= found[["log_likelihood", "standard_error", "behind", "behind_error"]].to_dict()
        row["separable"] = bool(found.behind > SEPARATE * found.behind_error)
        row["p"], row["p_error"] = probability_of_table_3(question, closed, reference)
        for each in over_rocks(pd.DataFrame(quantities(closed, question.parameters))).itertuples():
            column = f"{each.quantity}_{each.cycle}"
            row |= {column: each.value, f"{column}_error": each.standard_error}
        verdicts = claims_judged(closed, question.parameters, question.groups, confidence)
        rows.append(row | {f"claim {claim}": word for claim, word in verdicts.items()})
    return pd.DataFrame(rows)


def implied_table(
    readings: Readings, ranked: list[pd.DataFrame], joints: pd.DataFrame, question: Question
) -> pd.DataFrame:
    """S/mean that Table 3 implies, by cycle, given the means of a reading.

    For the configured reading and the best of the last round: columns reading, cycle, scatter,
    low, high (mean over the rocks closed; see `ImpliedScatter`).
    """
    reference = closures_of(readings, AS_CONFIGURED, joints, dict.fromkeys(readings.rocks))
    last = last_rounds(ranked)
    rows = []
    for name in dict.fromkeys([next(iter(last)), AS_CONFIGURED]):
        closed = in_round(readings, last[name], name, joints)
        table = over_rocks(pd.DataFrame(quantities(closed, question.parameters)))
        own = table[table.quantity == SCATTER].set_index("cycle").value
        for found in implied_scatter(question, closed, reference, _FACTORS):
            scatter = own[found.cycle] * np.array([found.factor, found.low, found.high])
            rows.append(
                {"reading": name, "cycle": found.cycle}
                | dict(zip(("scatter", "low", "high"), scatter.tolist(), strict=True))
            )
    return pd.DataFrame(rows)


_SHORT = {SCATTER: "S/mean"} | {name: about.shown_symbol for name, about in PROPERTIES.items()}


def readings_markdown(table: pd.DataFrame, implied: pd.DataFrame) -> str:
    """The table as Markdown: numbers rounded to their standard errors, the best first."""
    quantities_shown = [SCATTER, *(name for name in PARAMETERS if f"{name}_1" in table)]
    columns = [(name, cycle) for name in quantities_shown for cycle in (1, 2)]
    heads = ["reading", "round", "n", "log-likelihood", "behind", "p"]
    heads += [f"{_SHORT[name]}, cycle {cycle}" for name, cycle in columns]
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for row in table.to_dict("records"):
        cells = [
            row["title"] + ("" if row["allowed"] else " *"),
            row["round"],
            str(row["realizations"]),
            rounded(row["log_likelihood"], row["standard_error"]),
            rounded(row["behind"], row["behind_error"]) + ("" if row["separable"] else " ="),
            rounded(row["p"], row["p_error"]),
        ]
        cells += [
            rounded(row[f"{name}_{cycle}"], row[f"{name}_{cycle}_error"]) for name, cycle in columns
        ]
        lines.append(f"| {' | '.join(cells)} |")
    claims = [column for column in table if column.startswith("claim ")]
    lines += ["", f"| reading | {' | '.join(claim[6:] for claim in claims)} |"]
    lines.append("|" + "---|" * (len(claims) + 1))
    for row in table.to_dict("records"):
        lines.append(f"| {row['title']} | {' | '.join(row[claim] for claim in claims)} |")
    lines += [
        "",
        "Best first, by the last round that a reading entered; `behind`: the best of that round. "
        f"`=`: not told from the best ({SEPARATE:g} standard errors). `*`: not what the paper "
        "says. S/mean and elasticities are means over the rocks closed.",
        "",
    ]
    for row in implied.itertuples():
        title = table.set_index("reading").title[row.reading]
        lines.append(
            f'Given the means of "{title}", Table 3 is likeliest with S/mean = {row.scatter:.2g} '
            f"({row.low:.2g} to {row.high:.2g}) on cycle {row.cycle}."
        )
    return "\n".join(lines) + "\n"
