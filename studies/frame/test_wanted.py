"""The accuracy of a result that is wanted: granted from what was measured, or refused by name."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.inputs import InputError
from jointclosure.statistics.total_error import method_of
from jointclosure.storage.text import read_csv
from studies.frame.config.configuration import configured
from studies.frame.config.files import METHODS, ConfigurationError, read_plain
from studies.frame.config.wanted import (
    BLOCK,
    KNOWN_AT,
    MEASURED_SURFACES,
    Wanted,
    biases,
    grant,
    measured_rocks,
    methods_of,
    preset_errors,
    wanted_of,
)
from tests.studied import ROOT, checked_study, keys_of

PRESETS = ("quick", "accurate")


def method(name, cycle, bias, adjusted, cost, known_to=0.0):
    """Scatter 10 %, of which control variates explain nearly all on the first cycle."""
    explained = 0.96 if adjusted and cycle == 1 else 0.0
    row = {"response": "mean", "cycle": cycle, "rock": "slate", "method": name}
    row |= {"control_variates": adjusted, "bias_percent": bias, "scatter": 0.1}
    row |= {"bias_low": bias - known_to, "bias_high": bias + known_to}
    row |= {"left": 1.0 - explained, "explained": explained, "cost": cost}
    return row | {"measured_cost": 1e-3, "least": 15 if adjusted else 2}


TABLE = pd.DataFrame(
    [
        method(name, cycle, bias, adjusted, cost)
        for name, bias, cost in (("quick", 6.0, 0.5), ("accurate", 1.0, 2.0))
        for cycle in (1, 2)
        for adjusted in (False, True)
    ]
)


def wanted(within, of="mean", most=400):
    return Wanted(of, within, most, None)


def test_the_cheapest_preset_that_can_reach_it_is_granted_with_the_surfaces_it_needs():
    lenient = grant(wanted(0.12), TABLE, PRESETS, 2)
    assert (lenient.preset, lenient.surfaces) == ("quick", 20)  # (1.96 0.1 / 0.06)^2 = 11
    strict = grant(wanted(0.05), TABLE, PRESETS, 2)
    assert strict.preset == "accurate"  # the other is off by more
    assert strict.surfaces == BLOCK * np.ceil((1.96 * 0.1 / 0.04) ** 2 / BLOCK)
    assert strict.total <= 0.05


def test_control_variates_are_granted_where_they_pay():
    # of two cycles the second, which they do not help, needs as many surfaces
    assert not grant(wanted(0.03), TABLE, PRESETS, 2).control_variates
    first = grant(wanted(0.03), TABLE, PRESETS, 1)
    assert first.control_variates
    assert first.surfaces == 20
    assert first.seconds == pytest.approx(20 * 2.0 + MEASURED_SURFACES * 1e-3)


def test_a_cheaper_way_that_takes_more_than_the_most_surfaces_is_not_granted():
    dear = TABLE.assign(measured_cost=1.0)
    cheapest = grant(wanted(0.03), dear, PRESETS, 1)
    assert (cheapest.control_variates, cheapest.surfaces) == (False, 100)
    within = grant(wanted(0.03, most=50), dear, PRESETS, 1)
    assert (within.control_variates, within.surfaces) == (True, 20)


def test_what_a_bias_is_known_to_is_part_of_every_total_error():
    """1.96 of its standard errors, which are half of its 95 % confidence interval."""
    rough = TABLE.assign(bias_low=TABLE.bias_percent - 3.0, bias_high=TABLE.bias_percent + 3.0)
    assert biases(rough, "quick", "mean")[1] == pytest.approx((0.06, 0.03 / 1.96))
    assert biases(TABLE, "quick", "mean")[1] == (0.06, 0.0)
    way = grant(wanted(0.06), rough, PRESETS, 2)
    assert way.total == pytest.approx(0.01 + np.hypot(0.03, 1.96 * 0.1 / way.surfaces**0.5))
    assert way.surfaces > grant(wanted(0.06), TABLE, PRESETS, 2).surfaces
    with pytest.raises(InputError, match=r"within = 0\.04: must be more than 0\.04"):
        grant(wanted(0.04), rough, PRESETS, 2)


def test_where_errors_are_known_is_as_the_study_of_them_has_it():
    typed = checked_study(read_plain(ROOT / "studies/accuracy/accuracy_biases.yaml")).typed
    assert {*typed.rocks} == {*read_csv(METHODS).rock}
    for rock in typed.rocks.values():
        assert f"{1e-6 * rock.max_normal_stress:g} MPa" in KNOWN_AT
    assert f"{typed.grid.cells_x} x {typed.grid.cells_y} cells" in KNOWN_AT


def test_a_measured_rock_has_its_errors_and_any_other_rock_the_worst():
    two = pd.concat(
        [TABLE, TABLE.assign(rock="chalk", bias_percent=2.0, bias_low=2.0, bias_high=2.0)]
    )
    assert preset_errors(two, "accurate", "mean", "slate").of_cycle[1] == (0.01, 0.0)
    chalk, other = (preset_errors(two, "accurate", "mean", rock) for rock in ("chalk", None))
    assert chalk.of_cycle == other.of_cycle
    assert chalk.measured_at == f"chalk, {KNOWN_AT}"
    assert other.measured_at == f"the worst of slate, chalk, {KNOWN_AT}"
    of_slate = grant(wanted(0.05), methods_of(two, ["slate"]), PRESETS, 2)
    of_both = grant(wanted(0.05), methods_of(two, ["slate", "chalk"]), PRESETS, 2)
    assert of_slate.surfaces < of_both.surfaces
    assert of_both.rocks == ("slate", "chalk")


def test_a_rock_with_other_properties_than_the_measured_one_counts_as_another():
    default = keys_of()
    changed = keys_of({"rocks": {"slate": {"jrc": 9.0}}})
    assert measured_rocks(default, default) == {name: name for name in default["study"]["rocks"]}
    assert measured_rocks(changed, default) == measured_rocks(default, default) | {"slate": None}


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        (wanted(0.01), "within = 0.01: must be more"),
        (
            wanted(0.011),
            r"within = 0\.011: takes about \d+ surfaces a case, more than .*most = 400",
        ),
        (wanted(0.1, of="interval"), "of = 'interval': .*2 cycles"),
    ],
)
def test_what_cannot_be_reached_is_refused_before_anything_is_closed(wish, message):
    with pytest.raises(InputError, match=message):
        grant(wish, TABLE, PRESETS, 2)


def study(*changes, **wish):
    stated = {"numerics": {"accuracy": {"of": "mean", "within": 0.05} | wish}}
    return configured(keys_of(stated, *changes), read_csv)


def test_a_study_has_the_numerics_surfaces_and_control_variates_that_were_granted():
    found = study()
    table = read_csv(METHODS)
    granted = grant(wanted_of(found.keys), table, [found.granted], 2)
    assert found.typed.study.realizations == granted.surfaces
    assert found.typed.study.realizations % found.typed.study.realizations_per_job == 0
    assert found.typed.statistics.control_variates is None  # of two cycles they help one only
    assert not granted.control_variates
    of_one = study({"study": {"cycles": 1}}, within=0.02)
    assert of_one.typed.statistics.control_variates == MEASURED_SURFACES
    assert found.typed.numerics.breakage == "resolved"
    for part in (f"preset {found.granted}", f"{granted.surfaces} surfaces", "core-minutes a case"):
        assert part in found.remark
    more = study(surfaces=70)
    assert more.typed.study.realizations == 70
    assert "70 surfaces a case" in more.remark


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"study": {"realizations": 33}}, "study.realizations = 33: must be left out"),
        ({"choices": {"largest_radius_mm": 20.0}}, "largest_radius_mm = 20.0: must be null"),
        ({"effects": {"auto": 0.2}}, "effects.auto = 0.2: must be null"),
        (
            {"rocks": {"slate": {"effects": {"interaction": False}}}},
            "rocks.slate.effects = .*: must be left out",
        ),
        ({"numerics": {"accuracy": {"surfaces": 300}}}, "surfaces = 300: must be at most .*200"),
        ({"effects": {"breakage": False, "gouge": False}}, "nothing does here"),
        ({"numerics": {"accuracy": {"within": 1.5}}}, "accuracy.within = 1.5: must be below 1"),
        ({"numerics": {"accuracy": {"off": 3}}}, "accuracy.off = 3: unknown key"),
        ({"numerics": {"tolerance": 0.01}}, "tolerance = 0.01: .* numerics.accuracy.of selects it"),
    ],
)
def test_what_contradicts_a_wanted_accuracy_is_refused_by_name(change, message):
    with pytest.raises(ConfigurationError, match=message):
        study(change)


def test_the_shipped_table_has_every_preset_for_both_cycles_of_a_mean():
    table = read_csv(METHODS)
    for preset in ("quick", "paper", "accurate"):
        assert set(biases(table, preset, "mean")) == {1, 2}
        assert 2 in biases(table, preset, "interval")
    assert all(method_of(row).cost > 0.0 for row in table.itertuples())
