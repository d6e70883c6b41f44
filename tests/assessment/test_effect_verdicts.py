"""Verdicts on effects: whether they can be left out of a scene."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.assessment.assessed_results import ASSESSED
from jointclosure.assessment.assessment import Assessment
from jointclosure.assessment.verdicts import GIVEN_UP
from jointclosure.joint.status import BREAKAGE_NOT_AT_REST
from tests.assessment.known_closures import LADDER, closures


@pytest.mark.parametrize(("effect", "verdict"), [(0.0, "can be left out"), (0.3, "needed")])
def test_verdicts_are_those_of_the_effects_that_were_put_in(effect, verdict):
    assessment = Assessment(closures(effect=effect), LADDER, "middle", 0.05)
    assert assessment.verdict("without gouge") == verdict


def test_a_needed_effect_has_the_results_that_make_it_needed():
    closed = closures()
    assert Assessment(closed, LADDER, "middle", 0.05).needed_by("without gouge") == ""
    closed.loc[closed.variant == "without gouge", "max_closure"] *= 1.3
    found = Assessment(pd.concat([closed, closed.assign(cycle=2)]), LADDER, "middle", 0.05)
    assert found.effects["needed by"]["without gouge"] == "gross closure (cycles 1, 2)"
    assert found.verdict("without gouge") == "needed"
    assert "gross closure (cycles 1, 2)" in str(found)


def test_an_effect_without_which_all_joints_fail_has_no_value():
    closed = closures()
    closed.loc[closed.variant == "without gouge", list(ASSESSED)] = np.nan
    shown = str(Assessment(closed, LADDER, "middle", 0.05))
    assert "no value" in shown
    assert "nan" not in shown


def test_a_scene_that_fails_without_an_effect_needs_it():
    closed = closures()
    assert Assessment(closed, LADDER, "middle", 0.05).verdict("without gouge") == "can be left out"
    closed.loc[closed.index[closed.variant == "without gouge"][0], "status"] = 16
    assert Assessment(closed, LADDER, "middle", 0.05).verdict("without gouge") == "needed: fails"
    wide = Assessment(closures(effect=0.05, scatter=0.05), LADDER, "middle", 0.05)
    assert wide.verdict("without gouge") == "not decided"


def test_an_effect_without_which_breakage_takes_too_long_is_kept():
    closed = closures()
    closed.loc[closed.index[closed.variant == "without gouge"][0], "status"] = BREAKAGE_NOT_AT_REST
    assessment = Assessment(closed, LADDER, "middle", 0.05)
    assert assessment.verdict("without gouge") == GIVEN_UP == "kept: takes longer"
    assert (
        "Effects that are kept, as the joint takes longer without it, and the change was not "
        "tested: gouge."
    ) in assessment.conclusion
