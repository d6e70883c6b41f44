"""The diagram of total error: biases, scatters and costs are those of the tables that it is of."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.inputs import InputError
from studies.accuracy.total import Cheap, Diagram, method_table, point_table, split_table

POINTS = {"coarse": {"knob": "base", "value": ""}, "fine": {"knob": "resolved", "value": 0.02}}
TOTAL = {"scene": "own", "methods": POINTS}
DIAGRAM = Diagram(TOTAL, "youngs_modulus", 3, 4000)
CHEAP = Cheap(walls=5.0, covariates=3.0)
PAIR = 1e-3  # seconds


def costs():
    rows = []
    for rock, off in (("slate", 5.0), ("chalk", -8.0)):
        for cycle in (1, 2):
            for knob, value, error, pairs in (("base", "", off, 500), ("resolved", 0.02, 0.5, 900)):
                row = {"scene": "own", "rock": rock, "knob": knob, "value": str(value)}
                row |= {"cycle": cycle, "pairs": pairs, "seconds": pairs * PAIR}
                for of in ("levels", "interval"):
                    row |= {f"{of}_error_percent": error}
                    row |= {f"{of}_low": error - 1.0, f"{of}_high": error + 1.0}
                rows.append(row)
    return pd.DataFrame(rows)


def variance():
    rows = []
    for rock, error in (("slate", 2.0), ("chalk", 1.0)):
        for cycle, worth in ((1, 40.0), (2, 0.9)):
            for parameter, response in (("base", "mean"), ("youngs_modulus", "interval")):
                row = {"rock": rock, "cycle": cycle, "parameter": parameter, "surfaces": 20}
                row |= {"response": response, "draws": "independent", "worth": worth}
                rows.append(row | {"value": 100.0, "plain_error": error})
    return pd.DataFrame(rows)


@pytest.fixture(scope="module")
def methods():
    return method_table(DIAGRAM, costs(), variance(), CHEAP)


@pytest.fixture(scope="module")
def points(methods):
    return point_table(methods)


def at(table, surfaces, **keys):
    here = np.logical_and.reduce([table[key] == value for key, value in keys.items()])
    return table[here & (table.surfaces == surfaces)]


def test_the_rock_where_the_error_is_largest_tells_it(points):
    plain = {"response": "mean", "cycle": 1, "method": "coarse", "control_variates": False}
    of_means = points[(points.response == "mean") & (points.method == "coarse")]
    few, many = at(points, 2, **plain).iloc[0], of_means.iloc[-1]
    # of two surfaces slate scatters most: 2 % of 20 surfaces
    # and its bias is known to 1 %
    both = np.hypot(1.0, 1.96 * 2.0 * np.sqrt(10.0))
    assert few.total_percent == pytest.approx(5.0 + both)
    assert few.bias_percent == 5.0
    assert few.core_minutes == pytest.approx(2 * (500 + 5) * PAIR / 60.0)
    # of many only the bias is left, which is largest of chalk
    assert many.bias_percent == 8.0


def test_an_interval_takes_all_levels(methods):
    interval = methods[(methods.response == "interval") & (methods.method == "fine")].iloc[0]
    assert interval.cost == pytest.approx(3 * (900 + 5) * PAIR)


def test_control_variates_replace_the_simulations_that_they_were_worth(points):
    own = {"response": "mean", "cycle": 1, "method": "fine"}
    adjusted = at(points, 15, control_variates=True, measured=4000, **own).iloc[0]
    left = 1.0 / 40.0 - (1.0 - 1.0 / 40.0) / (1.0 - 20 / 4000) * 20 / 4000
    explained = (1.0 - 1.0 / 40.0) / (1.0 - 20 / 4000)
    expected = 1.96 * 2.0 * np.sqrt(20 * (left / 15 + explained / 4000))
    assert adjusted.sampling_percent == pytest.approx(expected)
    assert adjusted.core_minutes == pytest.approx((15 * 905 + 4000 * 8) * PAIR / 60.0)
    assert points[points.control_variates & (points.cycle == 1)].surfaces.min() == 15


def test_what_a_bias_is_known_to_is_in_the_total_error_at_any_number_of_surfaces(points):
    """-0.5 to 1.5 %: no number of surfaces tells the mean to less than 0.5 + 1 %."""
    fine = points[(points.method == "fine") & (points.response == "mean")]
    assert (fine.bias_percent == 0.5).all()
    np.testing.assert_allclose(fine.bias_error_percent, 1.0)
    both = np.hypot(fine.bias_error_percent, fine.sampling_percent)
    np.testing.assert_allclose(fine.total_percent, 0.5 + both)
    assert fine.total_percent.min() > 1.5


def test_the_bias_of_an_interval_is_that_of_all_rocks_and_holds_their_difference(methods):
    own = methods[(methods.response == "interval") & (methods.method == "coarse")]
    # 5 and -8 %, both known to 1 %
    assert own.bias_percent.to_numpy() == pytest.approx(-1.5)
    assert (own.bias_high - own.bias_low).iloc[0] > 13.0


def test_where_the_error_of_an_interval_is_not_known_its_method_is_left_out():
    table = costs()
    unknown = (table.rock == "slate") & (table.cycle == 1) & (table.knob == "base")
    table.loc[unknown, ["interval_low", "interval_high"]] = np.nan
    found = method_table(DIAGRAM, table, variance(), CHEAP)
    coarse = found[found.method == "coarse"]
    assert set(zip(coarse.response, coarse.cycle, strict=True)) == {
        ("mean", 1), ("mean", 2), ("interval", 2),
    }  # fmt: skip
    assert {1, 2} == set(found.cycle[(found.method == "fine") & (found.response == "interval")])


def test_the_best_split_of_a_budget_is_on_the_front_and_a_larger_one_is_no_worse(points):
    splits = split_table(points, [0.1, 1.0, 10.0])
    assert splits.best.all()
    for _, part in splits.groupby(["response", "cycle"]):
        assert (part.core_minutes <= part.budget).all()
        assert (part.total_percent.diff().dropna() <= 0.0).all()
    # little time buys the cheap setting, much time the one that is off by less
    second = splits[(splits.response == "interval") & (splits.cycle == 2)]
    assert second.method.tolist()[-1] == "fine"


def test_a_setting_that_was_not_turned_is_refused_by_name():
    stated = DIAGRAM._replace(total=TOTAL | {"methods": {"swift": {"knob": "steps", "value": 2}}})
    with pytest.raises(InputError, match=r"accuracy\.total: swift = .*is no setting of own"):
        method_table(stated, costs(), variance(), CHEAP)


def test_a_table_without_the_scatter_of_a_rock_is_refused():
    for lacking in (variance().drop(columns="value"), variance()[lambda t: t.rock != "chalk"]):
        with pytest.raises(
            InputError, match=r"variance_reduction\.csv: has no worth of control variates"
        ):
            method_table(DIAGRAM, costs(), lacking, CHEAP)
