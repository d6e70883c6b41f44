import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.studies.sensitivity.claims import Evidence, judge_claims

PARAMETERS = ("poisson_ratio", "youngs_modulus", "compressive_strength", "jrc")


def evidence(percents, closures=None):
    """Two rocks with the same percent intervals (cycle, parameter)."""
    rows, cases = [], []
    for rock in ("one", "two"):
        for cycle in (1, 2):
            for parameter, percent in zip(PARAMETERS, percents[cycle - 1], strict=True):
                rows.append(
                    {
                        "rock": rock,
                        "parameter": parameter,
                        "cycle": cycle,
                        "percent": percent,
                        "percent_net": percent,
                        "length": percent / 100,
                        "paper_percent": np.nan,
                        "in_paper": True,
                    }
                )
        cases.append(f"{rock}-base")
        cases += [f"{rock}-{p}-{level}" for p in PARAMETERS for level in ("low", "high")]
    closures = closures or {}
    table, values = [], {p: [] for p in PARAMETERS}
    for case in cases:
        rock, parameter, level = [*case.split("-"), "base"][:3]
        place = {"low": -1.0, "base": 0.0, "high": 1.0}[level]
        for name in PARAMETERS:
            values[name].append(place if name == parameter else 0.0)
        for cycle in (1, 2):
            slope = closures.get((parameter, cycle), 0.0)
            mean = (1.0 if cycle == 1 else 0.1) + slope * place
            table.append(
                {
                    "case": case,
                    "rock": rock,
                    "parameter": parameter,
                    "cycle": cycle,
                    "max_closure_mean_mm": mean,
                    "max_closure_net_mean_mm": mean,
                }
            )
    n = len(cases)
    rocks = [case.split("-")[0] for case in cases]
    parameters = [[*case.split("-"), "base"][1] for case in cases]
    closure = np.zeros((n, 3, 2, 2, 3))
    closure[..., 1, :] = 1e-5
    maxima = np.tile([1e-3, 1e-4], (n, 3, 1))
    study = xr.Dataset(
        {
            "closure": (("case", "realization", "cycle", "branch", "stress"), closure),
            "max_closure": (("case", "realization", "cycle"), maxima),
        },
        coords={
            "case": cases,
            "rock": ("case", rocks),
            "parameter": ("case", parameters),
            "cycle": [1, 2],
            "branch": ["loading", "unloading"],
            "stress": [0.0, 1.0, 2.0],
            "max_normal_stress": ("case", np.full(n, 2.0)),
            **{name: ("case", value) for name, value in values.items()},
        },
    )
    return Evidence(pd.DataFrame(rows), pd.DataFrame(table), study)


AS_THE_PAPER_SAYS = [[60.0, 12.0, 14.0, 10.0], [90.0, 3.0, 5.0, 30.0]]
TRENDS = {
    ("youngs_modulus", 2): -0.01,
    ("compressive_strength", 2): 0.01,
    ("jrc", 1): 0.1,
}


def verdicts(found):
    table = judge_claims(found)
    return dict(zip(table.number, table.verdict, strict=True))


def test_evidence_as_the_paper_says_reproduces_all_that_can_be_judged():
    found = verdicts(evidence(AS_THE_PAPER_SAYS, TRENDS))
    beyond = {"7", "8"}
    assert all(found[number] == "cannot be judged" for number in beyond)
    others = {number: verdict for number, verdict in found.items() if number not in beyond}
    assert set(others.values()) == {"reproduced"}, others


@pytest.mark.parametrize(
    ("number", "percents", "trends"),
    [
        ("1a, cycle 1", [[9.0, 12.0, 14.0, 10.0], AS_THE_PAPER_SAYS[1]], TRENDS),
        ("1b", [[60.0, 12.0, 14.0, 10.0], [9.0, 3.0, 5.0, 30.0]], TRENDS),
        ("2a", [AS_THE_PAPER_SAYS[0], [90.0, 6.0, 5.0, 30.0]], TRENDS),
        ("2b", [[60.0, 2.0, 14.0, 10.0], AS_THE_PAPER_SAYS[1]], TRENDS),
        ("3", [AS_THE_PAPER_SAYS[0], [90.0, 3.0, 5.0, 4.0]], TRENDS),
        ("4", [AS_THE_PAPER_SAYS[0], [90.0, 3.0, 5.0, 8.0]], TRENDS),
        ("5a", AS_THE_PAPER_SAYS, TRENDS | {("youngs_modulus", 2): 0.01}),
        ("5b", AS_THE_PAPER_SAYS, TRENDS | {("compressive_strength", 2): -0.01}),
        ("5c", AS_THE_PAPER_SAYS, TRENDS | {("jrc", 1): -0.1}),
        ("5d", AS_THE_PAPER_SAYS, TRENDS | {("jrc", 2): 0.01}),
    ],
)
def test_contrary_evidence_is_not_reproduced(number, percents, trends):
    assert verdicts(evidence(percents, trends))[number] == "not reproduced"


def test_where_no_change_is_significant_nothing_is_ranked():
    none = [np.nan] * 4
    found = verdicts(evidence([none, none], TRENDS))
    ranked = ("1a, cycle 1", "1a, cycle 2", "2a", "2a, net", "2b", "3", "4")
    assert {found[number] for number in ranked} == {"cannot be judged"}
    # a parameter without an interval is not the most sensitive, beside one that has one
    found = verdicts(evidence([none, [np.nan, np.nan, np.nan, 8.0]], TRENDS))
    assert {found[number] for number in ("2a", "3")} == {"not reproduced"}


def test_a_parameter_that_was_not_varied_cannot_be_judged():
    found = evidence(AS_THE_PAPER_SAYS, TRENDS)
    without = found._replace(
        intervals=found.intervals[found.intervals.parameter != "youngs_modulus"],
        closures=found.closures[found.closures.parameter != "youngs_modulus"],
    )
    assert verdicts(without)["2a"] == "cannot be judged"
    assert verdicts(without)["5a"] == "cannot be judged"


def test_other_rocks_are_asked_whether_the_claims_hold_without_the_papers_figures():
    found = evidence(AS_THE_PAPER_SAYS, TRENDS)
    own = found._replace(intervals=found.intervals.drop(columns=["paper_percent", "in_paper"]))
    table = judge_claims(own)
    assert list(table.columns) == ["number", "claim", "ours", "verdict"]
    assert set(table.verdict) == {"holds"}
    assert not {"7", "8"} & set(table.number)
    jrc = own._replace(
        intervals=own.intervals[own.intervals.parameter == "jrc"],
        closures=own.closures[own.closures.parameter.isin(["jrc", "base"])],
    )
    assert judge_claims(jrc).number.tolist() == ["4", "5c", "5d", "6a", "6b"]
    nothing = own._replace(
        intervals=own.intervals[:0], closures=own.closures[own.closures.parameter == "base"]
    )
    assert judge_claims(nothing).number.tolist() == ["6a", "6b"]


def test_of_rocks_that_the_paper_does_not_have_it_says_nothing():
    found = evidence(AS_THE_PAPER_SAYS, TRENDS)
    table = found.intervals.assign(in_paper=found.intervals.rock == "one")
    claims = judge_claims(found._replace(intervals=table)).set_index("number")
    assert claims.paper["2a"] == "cycle 2: one none"
    assert "two: " in claims.ours["2a"]
