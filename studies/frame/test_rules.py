"""Defaults of the workflow's rules, tried on a small workflow."""

import json
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from studies.frame.seals import write_seal
from tests.workflow.runs import ROOT, answer


def write_number(start: int, log: Callable[[str], None]) -> pd.DataFrame:
    """Write a number."""
    log("written")
    return pd.DataFrame({"start": [start], "process": [os.getpid()]})


SNAKEFILE = f"""
import os
from studies.frame.seals import withdraw_unmet
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
    command = [sys.executable, "-m", "snakemake", "--cores", 1]
    done = answer(command, folder, env=os.environ | {"START": str(start)})
    assert (done.returncode != 0) == fails, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_rules_have_logs_benchmarks_and_seals_by_their_names(small):
    results = small / "results/small"
    for place in ("double_1", "double_2", "add"):
        assert "written" in (results / f"logs/{place}.log").read_text()
        assert (results / f"benchmarks/{place}.tsv").is_file()
        assert (results / f"seals/{place}.json").is_file()
    seal = json.loads((results / "seals/add.json").read_text())
    assert sorted(seal["made_from"]) == ["../other/table.csv", "numbers/1.csv", "numbers/2.csv"]


def test_files_that_changed_or_are_of_other_settings_are_made_again_and_nothing_else(small):
    results = small / "results/small"
    one, two, total = (results / name for name in ("numbers/1.csv", "numbers/2.csv", "total.csv"))
    other, before = two.read_text(), total.read_text()
    one.write_text("7")
    assert "jointclosure: results/small/numbers/1.csv: the file is not as" in run(small)
    assert one.read_text() != "7"
    assert total.read_text() != before
    assert two.read_text() == other
    shutil.rmtree(small / ".snakemake")  # as in a folder of another machine
    (results / "seals/add.json").unlink()
    (small / "results/other/table.csv").write_text("2\n")
    printed = run(small, start=5, fails=True)
    assert "the same of 1 more jobs" in printed
    assert two.read_text().splitlines()[1].startswith("7,")
    assert "jointclosure: results/small/total.csv: no seal lists" in printed
    # a table of another study is not made again
    assert "results/other/table.csv: the file is not as jointclosure wrote it" in printed
    assert not total.exists()
