"""Digests follow what code does, through its imports."""

import ast
import re
import shutil

import pytest

from jointclosure.compilation import code_digests
from studies.frame.simulation import close_joints
from tests.studied import ROOT

JOINTS = f"{close_joints.__module__}:close_joints"


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """Copy of the library and of the studies that may be edited; digests are those of the copy."""
    for name, folder in code_digests.ROOTS.items():
        shutil.copytree(folder, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(
        code_digests, "ROOTS", {name: tmp_path / name for name in code_digests.ROOTS}
    )
    return tmp_path / "jointclosure"


def forget():
    for cached in (
        code_digests.raw_digest,
        code_digests._imports,
        code_digests._tree,
        code_digests._code,
    ):
        cached.cache_clear()


def digests(*names):
    forget()
    return [code_digests.code_digest(name) for name in names]


def edit(file, old, new):
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")


def test_an_edit_moves_the_digest_of_all_that_import_the_module(copy):
    names = ("solvers.fast", "joint.cycling", JOINTS, "statistics.indifference")
    before = digests(*names)
    edit(copy / "mechanics/contact.py", "3.0 * substrate", "3.1 * substrate")
    same = [a == b for a, b in zip(before, digests(*names), strict=True)]
    assert same == [False, False, False, True]


FUNCTIONS = '''
from functools import partial
from jointclosure.statistics import indifference as b, quadratics as p

LIMIT = 3

def _half(values):
    return b.length(values) / LIMIT

Halved = partial(_half)

def bootstrapped(values: Halved):
    """Some text."""
    return values

def paired(values):
    from jointclosure.statistics import variance_indices
    return p.mean(values)
'''


@pytest.mark.parametrize(
    ("file", "old", "new", "moved"),
    [
        ("functions.py", "Some text", "Other text", set()),
        ("functions.py", "LIMIT = 3", "LIMIT = 4", {"bootstrapped"}),
        ("functions.py", "p.mean", "p.median", {"paired"}),
        ("functions.py", "quadratics as p", "verdicts as p", {"paired"}),
        ("functions.py", "indifference as b", "verdicts as b", {"bootstrapped"}),
        ("statistics/indifference.py", "import numpy as np", "import numpy as n", {"bootstrapped"}),
        ("statistics/quadratics.py", "numpy as np", "numpy as n", {"bootstrapped", "paired"}),
        ("statistics/__init__.py", '"""\n', '"""\nADDED = 1\n', set()),
    ],
)
def test_of_the_module_of_a_function_only_what_the_function_uses_counts(
    copy, file, old, new, moved
):
    (copy / "functions.py").write_text(FUNCTIONS)
    names = ("functions:bootstrapped", "functions:paired")
    before = digests(*names)
    edit(copy / file, old, new)
    after = zip(names, before, digests(*names), strict=True)
    assert {name.partition(":")[2] for name, a, b in after if a != b} == moved


EDITED = "studies/paper/figures.py", "studies/paper/judged_claims.py"
# whatever closes joints, or makes their walls
CLOSING = {
    "choose_effects", "close_joints", "close_points", "cut_windows", "make_surfaces",
    "prepare_walls",
}  # fmt: skip


RULES = "\n".join(path.read_text("utf-8") for path in (ROOT / "workflow/rules").glob("*.smk"))
STATED = {
    script: "titles=False" not in how
    for script, how in re.findall(r'\bcode\(\s*"(\w+)\.py"(.*)', RULES)
}
"""Scripts whose digest is a parameter of a rule, and whether titles count in it."""


def all_digests():
    """Return the digests in the parameters of rules by the name of the script."""
    forget()
    folder = ROOT / "workflow/scripts"
    return {
        name: code_digests.code_digest(f"{folder}/{name}.py", titles=titles)
        for name, titles in STATED.items()
    }


@pytest.fixture(scope="module")
def unedited():
    """Digests before any edit; a copy of the package has the same ones."""
    return all_digests()


def moved(unedited):
    after = all_digests()
    return {name for name in after if unedited[name] != after[name]}


def test_a_copy_in_another_folder_has_the_same_digests(copy, unedited):
    assert moved(unedited) == set()
    assert len(set(unedited.values())) == len(unedited)


def test_every_script_that_computes_something_has_its_digest_in_the_rules():
    run = set(re.findall(r'"\.\./scripts/(\w+)\.py"', RULES))
    # these write a text that they are given, or fail because of a table
    assert run - set(STATED) == {"require_checks", "require_hard_cases", "state_configuration"}
    files = {path.stem for path in (ROOT / "workflow/scripts").glob("*.py")}
    assert files == {*run, "key_table"}


def test_an_edit_reruns_the_rules_that_need_it_alone(copy, unedited):
    for file in (*EDITED, "jointclosure/statistics/indifference.py"):
        text = (copy.parent / file).read_text(encoding="utf-8")
        (copy.parent / file).write_text(f"{text}\nADDED = 1\n", encoding="utf-8")
    scripts = moved(unedited)
    assert {"draw_figures", "judge_claims", "find_indifference_intervals"} <= scripts
    assert not {*CLOSING, "aggregate", "write_tables", "state_configuration"} & scripts


def test_an_edit_of_what_closes_joints_closes_them_again(copy, unedited):
    edit(copy / "mechanics/contact.py", "3.0 * substrate", "3.1 * substrate")
    assert CLOSING & moved(unedited) == {"choose_effects", "close_joints", "close_points"}


def with_other_texts(file, call):
    """Edit the text that is the first argument of each call; return the number of edits."""
    text, count = re.subn(rf'(\b{call}\(\s*f?")', r"\1Edited. ", file.read_text(encoding="utf-8"))
    file.write_text(text, encoding="utf-8")
    ast.parse(text)
    return count


def test_an_edited_description_closes_no_walls_again(copy, unedited):
    """A description runs the report again, and nothing else."""
    studies = copy.parent / "studies"
    sections = [*studies.glob("*/section.py"), *(studies / "frame").glob("[kr]*s.py")]
    assert sum(with_other_texts(section, "entry") for section in sections) > 50
    assert moved(unedited) == {"write_report"}


def test_an_edited_title_of_a_quantity_is_only_drawn_again(copy, unedited):
    assert with_other_texts(copy / "ensembles/quantities.py", "Quantity") > 10
    scripts = moved(unedited)
    assert {"draw_figures", "draw_experiment", "write_report"} <= scripts
    assert not {*CLOSING, "aggregate", "compile_kernels"} & scripts
