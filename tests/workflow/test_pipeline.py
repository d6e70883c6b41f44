"""The pipeline on a study of seconds, and what a look at it leaves as it is."""

import base64
import json
import re

import numpy as np
import pandas as pd
import pytest
import yaml

from jointclosure.storage.netcdf import read_netcdf
from studies.commands.differences import differences
from tests.workflow.runs import (
    ROOT,
    add_code,
    changed,
    checkout,
    edit,
    planned,
    run_snakemake,
    snakemake,
    state_of,
    studies_command,
)

RESULTS = "results/tiny"

LOOKS = [
    ["-n"],
    ["-np"],
    ["-nq"],
    ["-nc1"],
    ["-n", "--forceall"],
    ["-n", f"{RESULTS}/study.nc"],
    ["--rulegraph"],
    ["--dag"],
    ["--filegraph"],
    ["--d3dag"],
    ["--report", "page.html"],
    ["--list-changes", "params"],
    ["--list-changes", "code"],
    ["--list-changes", "input"],
    ["--list-rules"],
    ["--summary"],
    ["--detailed-summary"],
    ["--lint"],
]


@pytest.mark.parametrize("look", LOOKS[:1], ids=" ".join)
def test_looking_at_another_configuration_after_an_edit_changes_no_file(planning, look):
    """As it is at its most harmful; `test_no_look_changes_a_file` has all looks."""
    code = add_code(planning)
    edit(planning, "studies/frame/simulation.py")
    other = changed(planning, "other.yaml", ("surface.hurst", 0.7))
    before = state_of(planning)
    assert "close_joints" in run_snakemake(planning, *look, config=other, **code).stdout
    assert state_of(planning) == before


@pytest.mark.slow
@pytest.mark.parametrize("edited", [False, True], ids=["as it was run", "edited"])
@pytest.mark.parametrize("other", [False, True], ids=["its keys", "other keys"])
def test_no_look_changes_a_file(copied, edited, other):
    code = add_code(copied)
    if edited:
        edit(copied, "src/jointclosure/solvers/equilibrium.py")
    config = changed(copied, "other.yaml", ("surface.hurst", 0.7)) if other else "tiny.yaml"
    before = state_of(copied)
    for look in LOOKS:
        done = run_snakemake(copied, *look, config=config, **code)
        assert state_of(copied) == before, look
        # a report of files that are not up to date is refused, and `--lint` may find fault
        assert done.returncode == 0 or other or edited or look == ["--lint"], done.stderr


def test_a_cluster_runs_the_graph_of_a_laptop(tmp_path):
    """The Slurm profile needs its plugin; its keys, with the local executor, plan the same jobs."""
    folder = checkout(tmp_path / "cluster")
    keys = yaml.safe_load((ROOT / "profiles/slurm/config.yaml").read_text())
    keys = {key: value for key, value in keys.items() if key not in ("executor", "jobs")}
    (folder / "profiles/cluster").mkdir()
    (folder / "profiles/cluster/config.yaml").write_text(yaml.safe_dump(keys))
    there = planned(folder, "--workflow-profile", "profiles/cluster")
    assert there == planned(folder)


def rules_of_the_workflow():
    """File, line, name, indentation of each rule, and the statement around it."""
    for file in [ROOT / "Snakefile", *sorted((ROOT / "workflow/rules").glob("*.smk"))]:
        around = ""
        for line in file.read_text().splitlines():
            if line and not line.startswith(" "):
                around = line
            if found := re.match(r"( *)(?:(?:use )?rule|checkpoint)\b *(.*):$", line):
                yield file, line, found[2], found[1], around


def test_every_rule_has_a_name_of_its_own():
    names = []
    for file, _, name, _, _ in rules_of_the_workflow():
        assert name, f"{file}: a rule without a name"
        names.append(name)
    assert len(names) == len(set(names)) > 20


def test_no_rule_is_made_in_a_loop():
    for file, line, _, indented, around in rules_of_the_workflow():
        assert not indented or around.startswith(("if ", "else:")), (file, line)


def figures_in(page: str) -> dict[str, dict]:
    """Results that a report has, by their path."""
    (line,) = re.findall(r"^\s*var results = (\{.*\});?$", page, re.M)
    return json.loads(line)


@pytest.mark.slow
def test_the_report_has_every_figure_with_its_caption(copied):
    snakemake(copied, "--report", "page.html")
    results = figures_in((copied / "page.html").read_text())
    figures = {path.name: path for path in (copied / RESULTS / "figures").glob("*.png")}
    assert {result["name"] for result in results.values()} == set(figures)
    for result in results.values():
        assert len(re.sub(r"<[^>]*>", "", result["caption"]).strip()) > 40, result["name"]
        content = base64.b64decode(result["data_uri"].partition("base64,")[2])
        assert content == figures[result["name"]].read_bytes()


@pytest.mark.slow
def test_kernels_are_compiled_by_the_job_that_is_there_for_it_alone(tmp_path):
    folder = checkout(tmp_path / "cold")
    with (folder / "smallest.yaml").open("a") as file:  # few kernels
        file.write("effects: {breakage: false, gouge: false, interaction: false}\n")
    # a processor for which no machine code is shipped, and an empty cache
    old = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    cold = {"JOINTCLOSURE_CACHE": str(tmp_path / "kernels")}
    target = "results/smallest/study.nc"
    printed = snakemake(folder, "--", target, config="smallest.yaml", **old, **cold)
    assert printed.count("compiling kernels") == 1  # for the user to see
    logs = (folder / "results/smallest/logs").rglob("*.log")
    assert not [log.name for log in logs if "compiling kernels" in log.read_text()]


@pytest.mark.slow
def test_the_run_writes_what_the_readme_promises(study, tmp_path):
    results = study / RESULTS
    figures = list((results / "figures").iterdir())
    assert len({path.stem for path in figures}) == 8
    assert all(path.stat().st_size > 5000 for path in figures)
    assert len(pd.read_csv(results / "tables/table_3_indifference.csv")) == 4
    assert len(pd.read_csv(results / "tables/hydraulic_aperture.csv")) == 6 * 2 * 2 * 2 * 5
    checks = pd.read_csv(results / "tables/checks.csv")
    assert checks.passed.all()
    assert set(checks.ensemble) == {"cases", "pool"}
    page = tmp_path / "page.html"
    made = studies_command("report", results, "--output", page)
    assert (made.returncode, page.read_text().count("<img") >= 8) == (0, True), made.stderr


@pytest.mark.slow
def test_a_finished_study_is_up_to_date(study):
    assert planned(study) == {}


@pytest.mark.slow
def test_a_finished_study_has_the_files_that_were_pretended(study, pretended):
    outputs = [
        {name for name in state_of(folder) if not re.search("/(?:logs|[.])", name)}
        for folder in (study, pretended)
    ]
    assert outputs[0] == outputs[1]


@pytest.mark.slow
def test_the_dataset_has_its_dimensions(study):
    dataset = read_netcdf(study / RESULTS / "study.nc")
    sizes = {"case": 6, "realization": 3, "cycle": 2, "branch": 2, "direction": 2, "stress": 5}
    assert dict(dataset.sizes) == sizes


@pytest.mark.slow
def test_the_dataset_has_its_provenance(study):
    dataset = read_netcdf(study / RESULTS / "study.nc")
    stated = ("configuration", "root_seed", "source_digest", "provenance_commit")
    assert all(dataset.attrs[attribute] for attribute in stated)


@pytest.mark.slow
def test_closures_of_the_dataset_rise_with_the_stress(study):
    dataset = read_netcdf(study / RESULTS / "study.nc")
    rises = np.diff(dataset.closure.sel(branch="loading").values, axis=-1)
    assert np.all(rises[np.isfinite(rises)] > 0.0)
    # only the last level may be missing, where the stress jumped over the target
    assert np.isfinite(rises[..., :-1]).all()


def data_of(results):
    """Dataset and tables of a study, without what states how it was run."""
    dataset = read_netcdf(results / "study.nc")
    tables = {file.name: file.read_bytes() for file in (results / "tables").iterdir()}
    del dataset.attrs["configuration"], tables["configuration.json"]
    return dataset, tables


@pytest.fixture(scope="module")
def in_parts(tmp_path_factory):
    """The tiny study, run on one core with two realisations a job."""
    folder = checkout(tmp_path_factory.mktemp("parts") / "again")
    config = changed(folder, "parts.yaml", ("study.realizations_per_job", 2))
    snakemake(folder, cores=1, config=config)
    return folder


@pytest.mark.slow
def test_a_run_on_one_core_in_parts_has_the_same_bits(study, in_parts):
    (one, tables), (other, others) = data_of(in_parts / RESULTS), data_of(study / RESULTS)
    assert differences(one, other) == []
    assert tables == others


@pytest.mark.slow
def test_a_study_is_complete_before_its_pool(in_parts):
    (log,) = (in_parts / ".snakemake/log").glob("*.log")
    rules = re.findall(r"Finished jobid: \d+ \(Rule: (\w+)\)", log.read_text())
    complete = max(rules.index("write_tables"), rules.index("draw_figures"))
    assert rules.index("aggregate") < complete < rules.index("aggregate_pool")
