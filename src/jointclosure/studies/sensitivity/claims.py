"""The paper's claims, held against a study: judged by rules, with numbers.

Each claim is a rule over the study's own tables. A verdict is "reproduced"
only where the rule holds for every rock; the column ``ours`` says where not.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

REPRODUCED, NOT_REPRODUCED, CANNOT_BE_JUDGED = (
    "reproduced",
    "not reproduced",
    "cannot be judged",
)

HOLDS, DOES_NOT_HOLD = "holds", "does not hold"
"""Verdicts where none of the study's rocks is the paper's: there is nothing to reproduce."""


class Evidence(NamedTuple):
    """What claims are judged by.

    ``intervals``: the indifference table, with the paper's lengths where it has a rock of it;
    ``closures``: the maximum-closure table; ``study``: the dataset.
    """

    intervals: pd.DataFrame
    closures: pd.DataFrame
    study: xr.Dataset

    @property
    def rocks(self) -> list[str]:
        return list(dict.fromkeys(self.study.rock.values.tolist()))

    @property
    def has_the_papers_rocks(self) -> bool:
        return "paper_percent" in self.intervals


def judge_claims(evidence: Evidence) -> pd.DataFrame:
    """All claims with the paper's figures, ours, and a verdict.

    In a study of other rocks only, the same rules ask whether the paper's claims
    hold for these: without its figures, and without what cannot be judged.
    """
    table = pd.DataFrame(
        [row for claims in _CLAIMS for row in claims(evidence)],
        columns=["number", "claim", "paper", "ours", "verdict"],
    )
    if evidence.has_the_papers_rocks:
        return table
    table = table[table.verdict != CANNOT_BE_JUDGED].drop(columns="paper")
    return table.replace({"verdict": {REPRODUCED: HOLDS, NOT_REPRODUCED: DOES_NOT_HOLD}})


def _row(number: str, claim: str, paper: str, holds: dict[str, tuple[bool | None, str]]) -> dict:
    """A claim's row from (whether it holds, the numbers) for each rock."""
    ours = "; ".join(
        f"{rock}: {numbers}" + ("" if good or good is None else " (does not hold)")
        for rock, (good, numbers) in holds.items()
    )
    known = [good for good, _ in holds.values() if good is not None]
    verdict = REPRODUCED if all(known) else NOT_REPRODUCED
    if not known:
        verdict = CANNOT_BE_JUDGED
    return {"number": number, "claim": claim, "paper": paper, "ours": ours, "verdict": verdict}


def _percents(evidence: Evidence, rock: str, cycle: int, column: str = "percent") -> dict:
    """Percent intervals by parameter; infinite where there is no real root."""
    table = evidence.intervals
    part = table[(table.rock == rock) & (table.cycle == cycle)]
    return {
        row.parameter: np.inf if np.isnan(getattr(row, column)) else getattr(row, column)
        for row in part.itertuples()
    }


def _listed(percents: dict) -> str:
    names = {"poisson_ratio": "nu", "youngs_modulus": "E", "compressive_strength": "sigma_c"}
    return ", ".join(
        f"{names.get(key, 'JRC')} {'none' if np.isinf(value) else f'{value:.3g} %'}"
        for key, value in percents.items()
    )


def _paper_percents(evidence: Evidence, parameter: str, cycle: int) -> str:
    if not evidence.has_the_papers_rocks:
        return ""
    table = evidence.intervals[evidence.intervals.in_paper]
    part = table[(table.parameter == parameter) & (table.cycle == cycle)]
    shown = [
        f"{row.rock} {'none' if np.isnan(row.paper_percent) else f'{row.paper_percent:g} %'}"
        for row in part.itertuples()
    ]
    return f"cycle {cycle}: " + ", ".join(shown)


def _ranked(evidence: Evidence, cycle: int, judge: Callable[[dict], bool], column="percent"):
    """A rule over the percent intervals of each rock that has all four, not all of them none."""
    holds = {}
    for rock in evidence.rocks:
        percents = _percents(evidence, rock, cycle, column)
        known = len(percents) == 4 and min(percents.values()) < np.inf
        holds[rock] = (judge(percents) if known else None, _listed(percents))
    return holds


def _poisson(evidence: Evidence) -> Iterator[dict]:
    for cycle in (1, 2):
        yield _row(
            f"1a, cycle {cycle}",
            "Poisson's ratio matters least: the widest interval in percent",
            _paper_percents(evidence, "poisson_ratio", cycle),
            _ranked(evidence, cycle, lambda p: p["poisson_ratio"] >= max(p.values())),
        )
    table = evidence.intervals[evidence.intervals.parameter == "poisson_ratio"]
    holds = {}
    for rock in evidence.rocks:
        part = table[table.rock == rock]
        if part.empty:
            holds[rock] = (None, "not varied")
            continue
        lengths = [np.inf if np.isnan(v) else v for v in part.length]
        shown = ", ".join(
            f"cycle {row.cycle} {'none' if np.isnan(row.length) else f'{row.length:.3g}'}"
            for row in part.itertuples()
        )
        holds[rock] = (min(lengths) >= 0.1, shown)
    yield _row(
        "1b",
        "No effect of Poisson's ratio within +-0.1",
        "0.140, 0.099, none, none; 0.187, 0.092, 0.121, 0.075: its own table has three below 0.1",
        holds,
    )


def _modulus(evidence: Evidence) -> Iterator[dict]:
    def first(percents: dict) -> bool:
        return percents["youngs_modulus"] <= min(percents.values())

    paper = _paper_percents(evidence, "youngs_modulus", 2)
    claim = "Young's modulus is the most sensitive parameter on the second cycle"
    yield _row("2a", claim, paper, _ranked(evidence, 2, first))
    yield _row(
        "2a, net",
        f"{claim}, net of bulk indentation",
        paper,
        _ranked(evidence, 2, first, "percent_net"),
    )
    clear = _ranked(evidence, 1, first)
    judged = [good for good, _ in clear.values() if good is not None]
    all_first = bool(judged) and all(judged)
    yield _row(
        "2b",
        "On the first cycle Young's modulus is not clearly the most sensitive",
        _paper_percents(evidence, "youngs_modulus", 1),
        {
            rock: (None if good is None else not all_first, numbers)
            for rock, (good, numbers) in clear.items()
        },
    )


def _strength(evidence: Evidence) -> Iterator[dict]:
    yield _row(
        "3",
        "Compressive strength is the next sensitive parameter on the second cycle",
        _paper_percents(evidence, "compressive_strength", 2),
        _ranked(
            evidence,
            2,
            lambda p: (
                p["compressive_strength"] < np.inf
                and sorted(p, key=p.get).index("compressive_strength") == 1
            ),
        ),
    )


def _roughness(evidence: Evidence) -> Iterator[dict]:
    table = evidence.intervals[evidence.intervals.parameter == "jrc"]
    holds = {}
    for rock in evidence.rocks:
        length = {
            row.cycle: np.inf if np.isnan(row.length) else row.length
            for row in table[table.rock == rock].itertuples()
        }
        shown = ", ".join(
            f"cycle {cycle} {'none' if np.isinf(value) else f'{value:.3g}'}"
            for cycle, value in length.items()
        )
        known = {1, 2} <= set(length) and min(length.values()) < np.inf
        holds[rock] = (length[2] > length[1] if known else None, shown)
    yield _row(
        "4",
        "Sensitivity to JRC falls from the first cycle (about +-1) to the second",
        "cycle 1: 0.908, 0.948, 1.31, 0.726; cycle 2: 1.46, 1.99, 3.29, 3.18",
        holds,
    )


def _trend(evidence: Evidence, rock: str, parameter: str, cycle: int, column: str):
    """Mean closures over ascending levels [mm], or None where not varied."""
    table = evidence.closures
    part = table[(table.rock == rock) & (table.cycle == cycle)]
    part = part[part.parameter.isin([parameter, "base"])]
    if (part.parameter == parameter).sum() == 0:
        return None
    values = evidence.study[parameter].sel(case=part.case.to_numpy()).values
    return part[column].to_numpy()[np.argsort(values)]


def _trends(evidence: Evidence) -> Iterator[dict]:
    def row(number, claim, paper, parameter, cycle, sign, column="max_closure_mean_mm"):
        holds = {}
        for rock in evidence.rocks:
            means = _trend(evidence, rock, parameter, cycle, column)
            if means is None:
                holds[rock] = (None, "not varied")
                continue
            rising = np.all(np.diff(means) > 0.0)
            falling = np.all(np.diff(means) < 0.0)
            good = {1: rising, -1: falling}.get(sign, not (rising or falling))
            holds[rock] = (bool(good), " -> ".join(f"{mean:.5g}" for mean in means) + " mm")
        return _row(number, claim, paper, holds)

    described = "described, not shown"
    yield row("5a", "Cycle-2 closure rises when E falls", described, "youngs_modulus", 2, -1)
    yield row(
        "5a, net",
        "Cycle-2 closure rises when E falls, net of bulk indentation",
        described,
        "youngs_modulus",
        2,
        -1,
        "max_closure_net_mean_mm",
    )
    yield row(
        "5b", "Cycle-2 closure rises when sigma_c rises", described, "compressive_strength", 2, 1
    )
    yield row("5c", "Cycle-1 closure falls when JRC falls", described, "jrc", 1, 1)
    yield row("5d", "Cycle-2 closure has no such trend with JRC", described, "jrc", 2, 0)


def _hysteresis(evidence: Evidence) -> Iterator[dict]:
    study = evidence.study
    holds, stiffer = {}, {}
    for rock in evidence.rocks:
        base = study.sel(case=study.case[(study.rock == rock) & (study.parameter == "base")][0])
        half = base.closure.sel(stress=0.5 * float(base.max_normal_stress), method="nearest")
        loop = (half.sel(branch="unloading") - half.sel(branch="loading")).mean("realization")
        shown = ", ".join(
            f"cycle {int(c)} {1e3 * float(loop.sel(cycle=c)):.4g} mm" for c in study.cycle
        )
        holds[rock] = (bool((loop > 0.0).all()), f"loop at half the stress {shown}")
        means = base.max_closure.mean("realization")
        if study.sizes["cycle"] > 1:
            first, second = (1e3 * float(means.sel(cycle=c)) for c in (1, 2))
            stiffer[rock] = (second < first, f"{first:.4g} then {second:.4g} mm")
        else:
            stiffer[rock] = (None, "one cycle")
    yield _row("6a", "Unloading shows hysteresis", "Fig. 5", holds)
    yield _row("6b", "The second cycle is stiffer than the first", "Fig. 5", stiffer)


def _beyond(evidence: Evidence) -> Iterator[dict]:
    yield {
        "number": "7",
        "claim": "The step sizes are accurate enough",
        "paper": "stated, not shown",
        "ours": "one setting only here; benchmarks/limit_of_steps.py finds they are not (0010)",
        "verdict": CANNOT_BE_JUDGED,
    }
    yield {
        "number": "8",
        "claim": "The model fits Bandis' curves, dolerite worst, second cycles worse",
        "paper": "Fig. 5",
        "ours": "the measured curves are not available",
        "verdict": CANNOT_BE_JUDGED,
    }


_CLAIMS = (_poisson, _modulus, _strength, _roughness, _trends, _hysteresis, _beyond)
