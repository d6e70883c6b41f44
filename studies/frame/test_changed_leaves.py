"""Any leaf of the shipped configurations, changed to anything, is read or refused by our error.

`JOINTCLOSURE_LEAVES=all pytest studies/frame/test_changed_leaves.py` changes every leaf; usually a
few are, drawn by the name of the file.
"""

import copy
import datetime
import math
import os
import random

import pytest
import yaml

from jointclosure.inputs import InputError
from studies.frame.configuration import configured, merged_study
from studies.frame.experiments import experiment_named
from studies.frame.test_configuration import STUDIES
from studies.frame.yaml_files import read_plain

MOST = None if os.environ.get("JOINTCLOSURE_LEAVES") == "all" else 8
BAD = [
    None, "", "x", -1, 0, 2, 1e300, 5e-324, math.nan, math.inf, [], {}, True, [1], [None], {"a": 1},
    {"numerics": 1}, {"set": {"numerics": None}}, "auto", "flow.x", "numerics.solver",
    datetime.date(2020, 1, 1),
]  # fmt: skip


def leaves(part, path=()):
    """Generate the paths to all values of plain data, sections and lists among them."""
    entries = part.items() if isinstance(part, dict) else enumerate(part)
    for key, value in entries:
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from leaves(value, (*path, key))


def changed(keys, path, value):
    answer = copy.deepcopy(keys)
    part = answer
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = value
    return answer


def read(keys, file):
    """Check a configuration as before a run; return whether it is refused."""
    file.write_text(yaml.safe_dump(keys), encoding="utf-8")
    try:
        found = configured(merged_study(file))
        for name in found.study_sections:
            experiment_named(name).check(found)
    except InputError:
        return True
    return False


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_a_changed_leaf_is_read_or_refused(path, tmp_path):
    keys = read_plain(path)
    chance = random.Random(path.stem)
    every = list(leaves(keys))
    for leaf in chance.sample(every, len(every))[:MOST]:
        value = chance.choice(BAD)
        try:
            read(changed(keys, leaf, value), tmp_path / "changed.yaml")
        except Exception as error:
            pytest.fail(f"{'.'.join(map(str, leaf))} = {value!r}: {type(error).__name__}: {error}")
