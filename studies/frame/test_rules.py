"""Defaults of the workflow's rules, tried on a small workflow."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from studies.frame.jobs import write_seal

SNAKEFILE = """
import os
from studies.frame.rules import complete, withdraw_unmet

rule double:
    output: "results/small/numbers/{size}.csv",
    params: start=lambda wildcards: int(os.environ["START"]) + int(wildcards.size),
    script: "write.py"

rule add:
    input:
        expand("results/small/numbers/{size}.csv", size=[1, 2]),
        "results/other/table.csv",
    output: total="results/small/total.csv",
    script: "write.py"

rule all:
    default_target: True
    input: "results/small/total.csv",

complete(workflow.rules, "environment.yaml")
withdraw_unmet(workflow.rules, print, remove=True)
"""
SCRIPT = '''"""Write a number.

More is not shown.
"""
from pathlib import Path
from studies.frame.jobs import job

with job(snakemake) as log:
    Path(snakemake.output[0]).write_text(f"{snakemake.params.get('start')} {os.getpid()}")
    log("written")
'''.replace("from pathlib", "import os\nfrom pathlib")


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A finished run of the small workflow."""
    folder = tmp_path_factory.mktemp("small")
    (folder / "Snakefile").write_text(SNAKEFILE)
    (folder / "write.py").write_text(SCRIPT)
    (folder / "environment.yaml").write_text("dependencies: [python]\n")
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


def test_rules_have_logs_benchmarks_and_seals_by_their_names_and_wildcards(small):
    results = small / "results/small"
    for place in ("double/1", "double/2", "add"):
        assert "written" in (results / f"logs/{place}.log").read_text()
        assert (results / f"benchmarks/{place}.tsv").is_file()
        assert (results / f"seals/{place}.json").is_file()
    seal = json.loads((results / "seals/add.json").read_text())
    assert sorted(seal["made_from"]) == ["../other/table.csv", "numbers/1.csv", "numbers/2.csv"]


def test_a_table_of_another_study_is_refused_if_it_was_changed(small):
    (small / "results/other/table.csv").write_text("2\n")
    (small / "results/small/total.csv").unlink()
    assert "the file is not as jointclosure wrote it" in run(small, fails=True)
    (small / "results/other/table.csv").write_text("1\n")
    run(small)


def test_a_changed_file_is_made_again_with_all_that_follows_and_nothing_else(small):
    before, file = total(small), small / "results/small/numbers/1.csv"
    file.write_text("7")
    assert "jointclosure: results/small/numbers/1.csv: the file is not as" in run(small)
    assert total(small) != before
    (small / "results/small/seals/double/1.json").unlink()
    assert "jointclosure: results/small/numbers/1.csv: no seal lists" in run(small)
    before = total(small)
    run(small)
    assert total(small) == before


def test_a_file_of_other_settings_than_the_rule_has_now_is_made_again_also_elsewhere(small):
    shutil.rmtree(small / ".snakemake")  # as in a folder of another machine
    before = total(small)
    assert "the same of 1 more jobs" in run(small, start=5)
    assert (small / "results/small/numbers/2.csv").read_text().split()[0] == "7"
    assert total(small) != before
