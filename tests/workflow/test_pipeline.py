"""The pipeline on a study of seconds: what Snakemake plans, what looking leaves, files and bits.

Plans are made on a study whose files are there and empty (`runs.pretend`).
"""

import base64
import json
import os
import re

import numpy as np
import pandas as pd
import pytest
import yaml

from jointclosure.storage.netcdf import read_netcdf
from studies.commands.compare import differences
from tests.workflow.runs import (
    ROOT,
    add_code,
    changed,
    checkout,
    planned,
    pretend,
    run_snakemake,
    snakemake,
    state_of,
    studies_command,
)

RESULTS = "results/tiny"
LEVELS = "rocks.slate.levels"

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


def edit(folder, module: str, statement: str = "EDITED = True") -> None:
    """Append a statement to a module of a folder with code of its own."""
    assert (folder / module).is_file()
    with (folder / module).open("a") as file:
        file.write(f"\n{statement}\n")


@pytest.mark.parametrize("look", LOOKS[:1], ids=" ".join)
def test_looking_at_another_configuration_after_an_edit_changes_no_file(planning, look):
    """As it is at its most harmful; `test_no_look_changes_a_file` has all looks."""
    code = add_code(planning)
    edit(planning, "studies/frame/closing.py")
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


def plan_of(folder, *places_and_values) -> dict[str, int]:
    """What would be done after a change of keys."""
    return planned(folder, config=changed(folder, "changed.yaml", *places_and_values))


def files_of(folder, kind: str) -> int:
    return len(list((folder / RESULTS).glob(f"{kind}/*.nc")))


CLOSING = {"make_surfaces", "cut_windows", "choose_effects", "close_joints", "close_points"}


def test_another_level_of_the_jrc_plans_its_surfaces_and_joints(pretended, planning):
    jobs = plan_of(planning, (f"{LEVELS}.jrc", [5, 8, 8.5]))
    # one of the cases, and one of the pool
    assert (jobs["make_surfaces"], jobs["close_joints"]) == (2, 2)
    for rule in ("aggregate", "aggregate_pool", "fit_correlations", "draw_figures"):
        assert jobs[rule] == 1
    assert "compile_kernels" not in jobs


def test_another_level_of_another_property_plans_joints_and_no_surfaces(planning):
    jobs = plan_of(planning, (f"{LEVELS}.youngs_modulus_GPa", [60, 73]))
    assert "make_surfaces" not in jobs
    assert jobs["close_joints"] == 2


def test_a_title_plans_what_shows_it_and_no_joint(planning):
    jobs = plan_of(planning, ("rocks.slate.title", "Slate of another name"))
    assert not CLOSING & set(jobs)
    assert {"state_configuration", "draw_figures", "draw_predictive", "write_tables"} <= set(jobs)


def test_the_hurst_exponent_plans_all_surfaces_and_joints(planning):
    jobs = plan_of(planning, ("surface.hurst", 0.7))
    assert jobs["make_surfaces"] == files_of(planning, "surfaces/*")
    assert jobs["close_joints"] == files_of(planning, "cases") + files_of(planning, "pool")


def reversed_keys(keys):
    if not isinstance(keys, dict):
        return keys
    return {key: reversed_keys(value) for key, value in reversed(keys.items())}


def test_keys_in_another_order_plan_nothing(planning):
    keys = reversed_keys(yaml.safe_load((planning / "tiny.yaml").read_text()))
    (planning / "reversed.yaml").write_text(yaml.safe_dump(keys, sort_keys=False))
    assert planned(planning, config="reversed.yaml") == {}


def test_a_rock_that_the_study_has_not_plans_no_joint_and_no_table(planning):
    jobs = plan_of(planning, ("rocks.limestone.jrc", 9.0))
    assert set(jobs) <= {"state_configuration"}


def test_a_key_of_the_statistics_plans_what_reads_it_and_no_joint(planning):
    jobs = plan_of(planning, ("statistics.significance", 0.1))
    assert not CLOSING & set(jobs)
    assert {"find_indifference_intervals", "predict_table_3", "judge_claims"} <= set(jobs)
    assert not {"fit_correlations", "check_results", "aggregate"} & set(jobs)


def test_another_split_over_jobs_plans_blocks_of_its_own(planning):
    jobs = plan_of(planning, ("study.realizations_per_job", 2))
    assert jobs["close_joints"] == 2 * (files_of(planning, "cases") + files_of(planning, "pool"))


def triggered(folder, **code: str) -> set[str]:
    """Rules whose own params or scripts have changed, by a dry run."""
    listing = snakemake(folder, "--dry-run", **code)
    rules = re.search(r"^Rules with provenance triggered jobs: (.*)$", listing, re.M)
    return set(rules.group(1).split()) if rules else set()


def test_an_edited_module_plans_the_scripts_that_import_it_and_a_comment_nothing(planning):
    code = add_code(planning)
    edit(planning, "studies/paper/predictive.py", "# a comment")
    edit(planning, "src/jointclosure/solvers/equilibrium.py", "# a comment")
    assert planned(planning, **code) == {}
    edit(planning, "studies/paper/predictive.py")
    assert triggered(planning, **code) == {"predict_table_3"}
    edit(planning, "workflow/scripts/fit_elasticities.py")
    assert triggered(planning, **code) == {"predict_table_3", "fit_elasticities"}


def test_an_edit_of_the_solver_plans_every_joint(planning):
    code = add_code(planning)
    edit(planning, "src/jointclosure/solvers/equilibrium.py")
    jobs = planned(planning, **code)
    assert jobs["close_joints"] == files_of(planning, "cases") + files_of(planning, "pool")
    assert "make_surfaces" not in jobs


def test_a_file_that_is_gone_is_planned_alone(planning):
    (planning / RESULTS / "tables/claims.csv").unlink()
    assert planned(planning) == {"judge_claims": 1}


def test_a_report_is_planned_again_with_the_conclusions_that_it_shows(planning):
    pretend(planning, "report", "conclusions")
    edit(planning, "workflow/scripts/conclude.py")
    assert planned(planning, "report") == {"conclude": 1, "write_report": 1, "report": 1}


def test_a_report_assesses_its_study_unless_the_configuration_says_null(planning):
    assessing = {"assess_joints": 1, "tabulate_assessed": 1}
    always = {"rank_joints": 1, "draw_panels": 1, "write_report": 1}
    jobs = planned(planning, "report")
    assert assessing.items() <= jobs.items()
    assert always.items() <= jobs.items()
    without = changed(planning, "without.yaml", ("assessment", None))
    jobs = planned(planning, "report", config=without)
    assert not assessing.keys() & jobs.keys()
    assert always.items() <= jobs.items()


def test_a_key_of_the_assessment_closes_no_joint_of_the_study_again(planning):
    assert plan_of(planning, ("assessment", {"share": 0.3})) == {"state_configuration": 1}


def test_conclusions_depend_on_the_contents_of_published_tables_and_not_on_their_times(planning):
    config = changed(planning, "paper.yaml", ("study.name", "paper"))
    add_code(planning)
    pretend(planning, "conclusions", config=config)
    published = planning / "studies/paper/published/conclusions/earlier_readings.csv"
    os.utime(published)
    assert planned(planning, "conclusions", config=config) == {}
    with published.open("a") as file:
        file.write("\n")
    jobs = planned(planning, "conclusions", config=config)
    assert jobs == {"conclude": 1, "conclusions": 1}


def auto_effects_and_accuracy(folder) -> str:
    """Write a study whose effects are chosen, with a requested accuracy; its file."""
    asked = ("study.accuracy", {"within": 0.1, "most": 40}), ("study.pool", None), ("flow", False)
    return changed(folder, "auto.yaml", *asked, ("study.realizations", 20), ("effects", "auto"))


def test_effects_are_chosen_on_the_surfaces_of_blocks_that_are_closed(planning):
    config = auto_effects_and_accuracy(planning)
    listing = snakemake(planning, "--dry-run", "--", "results/tiny/effects/slate.nc", config=config)
    blocks = re.findall(r"surfaces/cases/\S+\.(\d+-\d+)\.nc", listing)
    assert set(blocks) == {"0-9", "10-19"}


def test_a_cluster_runs_the_graph_of_a_laptop(tmp_path):
    """The Slurm profile needs its plugin; its keys, with the local executor, plan the same jobs."""
    folder = checkout(tmp_path / "cluster")
    keys = yaml.safe_load((ROOT / "profiles/slurm/config.yaml").read_text())
    keys = {key: value for key, value in keys.items() if key not in ("executor", "jobs")}
    (folder / "profiles/cluster").mkdir()
    (folder / "profiles/cluster/config.yaml").write_text(yaml.safe_dump(keys))
    there = planned(folder, "--workflow-profile", "profiles/cluster")
    assert there == planned(folder)


def test_rules_have_names_and_none_is_made_in_a_loop():
    names = []
    for file in [ROOT / "Snakefile", *sorted((ROOT / "workflow/rules").glob("*.smk"))]:
        around = ""
        for line in file.read_text().splitlines():
            if line and not line.startswith(" "):
                around = line
            if found := re.match(r"( *)(?:(?:use )?rule|checkpoint)\b *(.*):$", line):
                assert found[2], f"{file}: a rule without a name"
                assert not found[1] or around.startswith(("if ", "else:")), (file, line)
                names.append(found[2])
    assert len(names) == len(set(names)) > 20


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
def test_kernels_are_compiled_by_the_job_that_is_there_for_it_and_by_no_other(tmp_path):
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
def test_a_finished_study_is_up_to_date_and_has_the_files_that_were_pretended(study, pretended):
    assert planned(study) == {}
    outputs = [
        {name for name in state_of(folder) if not re.search("/(?:logs|benchmarks|[.])", name)}
        for folder in (study, pretended)
    ]
    assert outputs[0] == outputs[1]


@pytest.mark.slow
def test_the_dataset_has_coordinates_units_and_provenance(study):
    dataset = read_netcdf(study / RESULTS / "study.nc")
    sizes = {"case": 6, "realization": 3, "cycle": 2, "branch": 2, "direction": 2, "stress": 5}
    assert dict(dataset.sizes) == sizes
    stated = ("configuration", "root_seed", "source_digest", "provenance_commit")
    assert all(dataset.attrs[attribute] for attribute in stated)
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


@pytest.mark.slow
def test_a_run_on_one_core_in_parts_has_the_same_bits_and_the_study_before_its_pool(
    study, tmp_path
):
    folder = checkout(tmp_path / "again")
    config = changed(folder, "parts.yaml", ("study.realizations_per_job", 2))
    snakemake(folder, cores=1, config=config)
    (log,) = (folder / ".snakemake/log").glob("*.log")
    rules = re.findall(r"Finished jobid: \d+ \(Rule: (\w+)\)", log.read_text())
    complete = max(rules.index("write_tables"), rules.index("draw_figures"))
    assert rules.index("aggregate") < complete < rules.index("aggregate_pool")
    (one, tables), (other, others) = data_of(folder / RESULTS), data_of(study / RESULTS)
    assert differences(one, other) == []
    assert tables == others
