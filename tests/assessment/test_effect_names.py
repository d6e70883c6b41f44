"""Names of sets of effects."""

from collections import Counter

import pytest

import jointclosure as jc
from jointclosure.assessment.effect_names import effects_title, joined, without
from jointclosure.parameters import well_posed_scenes

ALL = jc.Effects()


@pytest.mark.parametrize(
    ("effects", "title"),
    [
        (ALL, "all effects"),
        (ALL._replace(gouge=False), "all but gouge"),
        (ALL._replace(soft_peaks=False), "all but soft peaks"),
        (ALL._replace(breakage=False, gouge=False), "all but breakage and gouge"),
        (jc.Effects(True, False, False, False, False), "only substrate"),
        (jc.Effects(True, True, False, False, False), "only substrate and interaction"),
        (jc.Effects(False, False, False, False, False), "no effects"),
    ],
)
def test_a_set_of_effects_is_named_by_the_fewer_that_act_or_do_not(effects, title):
    assert effects_title(effects) == title


def test_every_set_of_effects_has_a_name_of_its_own():
    names = Counter(map(effects_title, well_posed_scenes()))
    assert set(names.values()) == {1}
    assert not any("_" in name or "-" in name for name in names)


def test_effects_that_are_left_out_are_listed_in_words():
    assert joined(["substrate", "interaction", "soft_peaks"]) == (
        "substrate, interaction and soft peaks"
    )
    assert without(["breakage", "gouge"]) == "without breakage and gouge"
