"""Tables of a study of readings: rankings, likelihood, scatter, elasticities and claims."""

import numpy as np
import pandas as pd

from jointclosure.config.properties import PARAMETERS, PROPERTIES
from jointclosure.experiments.readings.design import AS_CONFIGURED, Readings
from jointclosure.experiments.readings.likelihood import (
    Question,
    answer_of,
    implied_scatter,
    probability_of_table_3,
    ranking,
)
from jointclosure.experiments.readings.pools import as_configured, in_round
from jointclosure.experiments.readings.summary import SCATTER, claims_judged, over_rocks, quantities
from jointclosure.statistics.standard_errors import rounded

_FACTORS = np.linspace(0.1, 1.6, 31)
"""Factors on standard deviations, of which the likeliest is sought."""
SEPARATE = 2.0
"""Standard errors by which a reading differs significantly from the best of its round."""


def round_table(
    readings: Readings, number: int, entrants: list[str], joints: pd.DataFrame, question: Question
) -> pd.DataFrame:
    """Rank the entrants of a round, the best first.

    Parameters
    ----------
    readings : Readings
    number : int
        Number of the round.
    entrants : list of str
        Readings that entered; the ranking of none is empty.
    joints : DataFrame
        As from `jointclosure.ensemble.points.close_points`, of all entrants, and of the configured
        reading in all rocks.
    question : Question
    """
    answers = {}
    if entrants:
        reference = as_configured(readings, joints)
        for name in entrants:
            closed = in_round(readings, number, name, joints)
            answers[name] = answer_of(question, closed, reference)
    return ranking(answers, readings.rounds[number].margin)


def last_rounds(ranked: list[pd.DataFrame]) -> dict[str, int]:
    """Return the last round of each reading, those of the last round first, best first."""
    last: dict[str, int] = {}
    for number in range(len(ranked) - 1, -1, -1):
        for name in ranked[number].reading:
            last.setdefault(name, number)
    return last


def readings_table(
    readings: Readings, ranked: list[pd.DataFrame], joints: pd.DataFrame, question: Question
) -> pd.DataFrame:
    """Summarise each reading by its last round.

    Parameters
    ----------
    readings : Readings
    ranked : list of DataFrame
        `round_table` of each round.
    joints : DataFrame
        As from `jointclosure.ensemble.points.close_points`, of all rounds.
    question : Question

    Returns
    -------
    DataFrame
        reading, title, aspects, allowed, round, rocks, realizations; log_likelihood,
        standard_error, behind, behind_error (to the best of that round), separable; p of the
        joint test and p_error; scatter and elasticities of both cycles with errors
        (``youngs_modulus_2``, ``youngs_modulus_2_error``), means over the closed rocks; claims
        (``claim 2a``). The likelihood of a reading that was closed in some rocks only assumes the
        same changes in the others.
    """
    reference = as_configured(readings, joints)
    rows = []
    for name, number in last_rounds(ranked).items():
        one, this = readings.reading(name), readings.rounds[number]
        closed = in_round(readings, number, name, joints)
        rank = ranked[number].set_index("reading").loc[name]
        row = {
            "reading": name,
            "title": one.title,
            "aspects": "; ".join(one.aspects),
            "allowed": one.allowed,
            "round": this.name,
            "rocks": "; ".join(this.rocks),
            "realizations": min(closures.sizes["realization"] for closures in closed.values()),
        }
        row |= rank[["log_likelihood", "standard_error", "behind", "behind_error"]].to_dict()
        row["separable"] = bool(rank.behind > SEPARATE * rank.behind_error)
        row["p"], row["p_error"] = probability_of_table_3(question, closed, reference)
        means = over_rocks(pd.DataFrame(quantities(closed, question.parameters)))
        for mean in means.itertuples():
            column = f"{mean.quantity}_{mean.cycle}"
            row |= {column: mean.value, f"{column}_error": mean.standard_error}
        verdicts = claims_judged(closed, question.parameters, question.groups, question.design)
        rows.append(row | {f"claim {claim}": word for claim, word in verdicts.items()})
    return pd.DataFrame(rows)


def implied_table(
    readings: Readings, ranked: list[pd.DataFrame], joints: pd.DataFrame, question: Question
) -> pd.DataFrame:
    """Compute the S/mean implied by Table 3, by cycle, given the means of a reading.

    For the configured reading and the best of the last round: columns reading, cycle, scatter,
    low, high (mean over the closed rocks; see `ImpliedScatter`).
    """
    reference, last = as_configured(readings, joints), last_rounds(ranked)
    rows = []
    for name in dict.fromkeys([next(iter(last)), AS_CONFIGURED]):
        closed = in_round(readings, last[name], name, joints)
        table = over_rocks(pd.DataFrame(quantities(closed, question.parameters)))
        scatter = table[table.quantity == SCATTER].set_index("cycle").value
        for cycle, *factors in implied_scatter(question, closed, reference, _FACTORS):
            implied = zip(("scatter", "low", "high"), factors, strict=True)
            rows.append(
                {"reading": name, "cycle": cycle}
                | {column: scatter[cycle] * factor for column, factor in implied}
            )
    return pd.DataFrame(rows)


_SHORT = {SCATTER: "S/mean"} | {name: about.shown_symbol for name, about in PROPERTIES.items()}


def readings_markdown(table: pd.DataFrame, implied: pd.DataFrame) -> str:
    """Format the tables as Markdown: numbers rounded to their standard errors, the best first."""
    shown = [SCATTER, *(name for name in PARAMETERS if f"{name}_1" in table)]
    columns = {
        f"{_SHORT[name]}, cycle {cycle}": f"{name}_{cycle}" for name in shown for cycle in (1, 2)
    }
    heads = ["reading", "round", "n", "log-likelihood", "behind", "p", *columns]
    rows = [
        [
            row["title"] + ("" if row["allowed"] else " *"),
            row["round"],
            str(row["realizations"]),
            rounded(row["log_likelihood"], row["standard_error"]),
            rounded(row["behind"], row["behind_error"]) + ("" if row["separable"] else " ="),
            *(rounded(row[name], row[f"{name}_error"]) for name in ("p", *columns.values())),
        ]
        for row in table.to_dict("records")
    ]
    claims = [column for column in table if column.startswith("claim ")]
    titles = table.set_index("reading").title
    lines = [
        *_markdown_table(heads, rows),
        "",
        *_markdown_table(
            ["reading", *(claim.removeprefix("claim ") for claim in claims)],
            table[["title", *claims]].to_numpy().tolist(),
        ),
        "",
        "Best first, by the last round of a reading; `behind`: log-likelihood below the best of "
        f"that round. `=`: not significantly different from the best ({SEPARATE:g} standard "
        "errors). `*`: contradicts the paper. S/mean and elasticities are means over the closed "
        "rocks.",
        "",
        *(
            f'Given the means of "{titles[row.reading]}", Table 3 is likeliest with '
            f"S/mean = {row.scatter:.2g} ({row.low:.2g} to {row.high:.2g}) on cycle {row.cycle}."
            for row in implied.itertuples()
        ),
    ]
    return "\n".join(lines) + "\n"


def _markdown_table(heads: list[str], rows: list[list[str]]) -> list[str]:
    """Return the lines of a Markdown table."""
    lines = [f"| {' | '.join(cells)} |" for cells in (heads, *rows)]
    return [lines[0], "|" + "---|" * len(heads), *lines[1:]]
