"""Defaults of the workflow's rules, tried on a small workflow."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from studies.frame.jobs import write_seal

ROOT = Path(__file__).parents[2]


def write_number(start: int, log: Callable[[str], None]) -> pd.DataFrame:
    """Write a number."""
    log("written")
    return pd.DataFrame({"start": [start], "process": [os.getpid()]})


SNAKEFILE = f"""
import os
from studies.frame.jobs import withdraw_unmet
from studies.frame.products import Step
from studies.frame.test_rules import write_number

numbers = [f"results/small/numbers/{{size}}.csv" for size in (1, 2)]
start = int(os.environ["START"])
steps = {{
    f"double_{{size}}": Step(write_number, [file], settings={{"start": start + size}})
    for size, file in enumerate(numbers, 1)
}}
read = {{"numbers": numbers, "other": "results/other/table.csv"}}
steps["add"] = Step(write_number, ["results/small/total.csv"], read, {{"start": 0}})

rule all:
    input: "results/small/total.csv"

for NAME, STEP in steps.items():
    rule:
        name: NAME
        input: **STEP.inputs
        output: STEP.files
        log: f"results/small/logs/{{NAME}}.log", benchmark=f"results/small/benchmarks/{{NAME}}.tsv"
        params: **STEP.params()
        script: "{ROOT}/workflow/scripts/make.py"

withdraw_unmet(steps.values(), print, remove=True)
"""


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A finished run of the small workflow."""
    folder = tmp_path_factory.mktemp("small")
    (folder / "Snakefile").write_text(SNAKEFILE)
    table, seal = (folder / "results/other" / name for name in ("table.csv", "seals/sum.json"))
    seal.parent.mkdir(parents=True)
    table.write_text("1\n")
    write_seal(seal, [str(table)], {}, [])
    run(folder)
    return folder


def run(folder: Path, start: int = 0, fails: bool = False) -> str:
    answer = subprocess.run(
        [sys.executable, "-m", "snakemake", "--cores", "1"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"START": str(start)},
    )
    assert (answer.returncode != 0) == fails, answer.stdout + answer.stderr
    return answer.stdout + answer.stderr


def total(folder: Path) -> str:
    return (folder / "results/small/total.csv").read_text()


def test_rules_have_logs_benchmarks_and_seals_by_their_names(small):
    results = small / "results/small"
    for place in ("double_1", "double_2", "add"):
        assert "written" in (results / f"logs/{place}.log").read_text()
        assert (results / f"benchmarks/{place}.tsv").is_file()
        assert (results / f"seals/{place}.json").is_file()
    seal = json.loads((results / "seals/add.json").read_text())
    assert sorted(seal["made_from"]) == ["../other/table.csv", "numbers/1.csv", "numbers/2.csv"]


def test_a_changed_file_is_made_again_with_all_that_follows_and_nothing_else(small):
    before, file = total(small), small / "results/small/numbers/1.csv"
    file.write_text("7")
    assert "jointclosure: results/small/numbers/1.csv: the file is not as" in run(small)
    assert total(small) != before
    (small / "results/small/seals/double_1.json").unlink()
    assert "jointclosure: results/small/numbers/1.csv: no seal lists" in run(small)
    before = total(small)
    run(small)
    assert total(small) == before


def test_a_table_of_another_study_is_refused_if_it_was_changed(small):
    (small / "results/other/table.csv").write_text("2\n")
    (small / "results/small/total.csv").unlink()
    assert "the file is not as jointclosure wrote it" in run(small, fails=True)
    (small / "results/other/table.csv").write_text("1\n")
    run(small)


def test_a_file_of_other_settings_than_the_rule_has_now_is_made_again_also_elsewhere(small):
    shutil.rmtree(small / ".snakemake")  # as in a folder of another machine
    before = total(small)
    assert "the same of 1 more jobs" in run(small, start=5)
    assert (small / "results/small/numbers/2.csv").read_text().splitlines()[1].startswith("7,")
    assert total(small) != before
