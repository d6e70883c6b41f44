"""What Snakemake plans after a change.

Plans are made on a study whose files are there and empty (`runs.pretend`).
"""

import os
import re

import yaml

from tests.workflow.runs import (
    add_code,
    changed,
    edit,
    planned,
    pretend,
    snakemake,
)

RESULTS = "results/tiny"
LEVELS = "rocks.slate.levels"


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


def test_another_level_of_another_property_plans_joints_alone(planning):
    jobs = plan_of(planning, (f"{LEVELS}.youngs_modulus_GPa", [60, 73]))
    assert "make_surfaces" not in jobs
    assert jobs["close_joints"] == 2


def test_a_title_plans_what_shows_it_alone(planning):
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


def test_a_rock_that_the_study_does_not_have_plans_nothing(planning):
    jobs = plan_of(planning, ("rocks.limestone.jrc", 9.0))
    assert set(jobs) <= {"state_configuration"}


def test_a_key_of_the_statistics_plans_what_reads_it_alone(planning):
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


def test_a_comment_in_a_module_plans_nothing(planning):
    code = add_code(planning)
    edit(planning, "studies/paper/predictive.py", "# a comment")
    edit(planning, "src/jointclosure/solvers/equilibrium.py", "# a comment")
    assert planned(planning, **code) == {}


def test_an_edited_module_plans_the_scripts_that_import_it(planning):
    code = add_code(planning)
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


def test_conclusions_depend_on_published_tables_by_their_contents_alone(planning):
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
