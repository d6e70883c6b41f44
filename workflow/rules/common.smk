# What the rules share: the checked configuration, its cases and their settings. No rules here.
#
# Snakemake makes a file again when its inputs, its script or its `params` change. It does not see
# modules that a script imports, so `params` have a digest of that code, `code(...)`. They also have
# the part of the configuration that a rule reads, as plain values in a fixed order.
import json
import os
import sys
from functools import cache, partial

from jointclosure.compilation.kernels import cache_folder
from jointclosure.compilation.code_digests import code_digest
from jointclosure.assessment.effect_selection import MOST_PAIRS, possible_scenes
from jointclosure.inputs import InputError
from jointclosure.joint.warmup import kernels_of
from jointclosure.storage.files import digest
from jointclosure.walls.scans import file_digest, files_of
from studies.assessment.larger_assessment import base_conditions
from studies.assessment.report_plan import READ as ASSESSED_QUANTITIES
from studies.assessment.report_plan import planned as planned_assessment
from studies.assessment.section import AssessmentSection
from studies.frame.cases import (
    blocks_of,
    cases_of,
    closed_keys,
    ensembles_of,
    first_with_surfaces,
    joint_grid,
    synthesis,
    wall_digests,
)
from studies.frame.configuration import configured
from studies.frame.datasets import joints_key
from studies.frame.near_strength import notes_near_strength, tried_by_strength
from studies.frame.pilots import examined
from studies.frame.experiments import case_point, experiment_named
from studies.frame.rocks import check_files, wall_files
from studies.frame.settings import BASE, joints_of, surface_settings
from studies.frame.yaml_files import configuration_text, read_plain, with_places
from studies.paper.measured_curves import curve_settings, measured_curves
from studies.paper.report.page_rendering import template_digest

DEFAULT_KEYS = "config/default.yaml"  # other files of keys are merged over it
if not Path(DEFAULT_KEYS).is_file():
    sys.exit(
        f"{DEFAULT_KEYS}: is not in this folder; start snakemake in the folder of the project, or "
        "with --directory"
    )


def refuse_configuration(error):
    """End Snakemake with the message of an error, and the files and lines of its keys.

    An exception would show this file and its line, at which nothing is wrong.
    """
    files = sorted(map(os.path.relpath, workflow.configfiles), key=DEFAULT_KEYS.__ne__)
    try:
        sys.exit(with_places(str(error), files))
    except InputError:  # a file cannot be read, which is the error
        sys.exit(str(error))


try:  # one line for each wrong key or file, before any job
    for file in workflow.configfiles:
        read_plain(file)
    STUDY = configured(config)
    check_files(STUDY.rocks)
    measured_curves(curve_settings(STUDY))
except InputError as error:
    refuse_configuration(error)
config.update(STUDY.stated)

RESULTS = f"results/{STUDY.study.name}"
PAPER_TABLE_3 = "studies/paper/paper_table_3.csv"
ENVIRONMENT = "../envs/jointclosure.yaml"

# Rocks whose walls are made from a JRC, and rocks whose walls were scanned
SYNTHETIC = [name for name, rock in STUDY.rocks.items() if not rock.walls]
SCANNED = [name for name, rock in STUDY.rocks.items() if rock.walls]

# Ensembles of joints, and the names of their datasets
#   cases:  every case of the study
#   pool:   every case on further surfaces, which all cases of a rock share
#   finest: some joints of the cases again, by the finest numerics (study.accuracy)
ENSEMBLES = ensembles_of(STUDY)
CASES = {name: {c.label: c for c in cases_of(of)} for name, of in ENSEMBLES.items()}
DATASETS = {"study": "cases"} | {name: name for name in ENSEMBLES if name == "pool"}

VARIED = any(rock.levels for rock in STUDY.rocks.values())  # is a property varied?
POOL = (
    "pool" if "pool" in ENSEMBLES else "study"
)  # dataset by which the model is judged
# are means adjusted by covariates of the walls? Those of scanned walls are not known.
ADJUSTED = STUDY.statistics.control_variates is not None and SYNTHETIC != []
MEASURED = curve_settings(STUDY)  # measured curves of rocks, by rock
CHOSEN = STUDY.effects.auto is not None  # are effects chosen, rock by rock?

# Tables and figures of this study
TABLES = [
    "configuration.json",
    "table_1_rocks.csv",
    "table_2_cases.csv",
    "table_3_indifference.csv",
    "table_3_indifference.md",
    "table_3_predictive.csv",
    "table_3_joint_tests.csv",
    "correlations.csv",
    "max_closure.csv",
    "elasticities.csv",
    "claims.csv",
    "claim_margins.csv",
    "checks.csv",
]
TABLES += ["measured_fit.csv"] if MEASURED else []
TABLES += ["hydraulic_aperture.csv"] if STUDY.flow else []
TABLES += ["accuracy_reached.csv"] if STUDY.study.accuracy else []
FIGURES_OF_STUDY = [
    "fig_3_equivalent_stress",
    "fig_5_closure",
    "closure_since_seating",
    "wall_pair",
]
FIGURES_OF_STUDY += ["hydraulic_aperture"] if STUDY.flow else []
FIGURES_OF_STUDY += ["table_3_intervals", "trends_max_closure"] if VARIED else []
FIGURES = FIGURES_OF_STUDY + (["table_3_predictive"] if VARIED else [])
# The assessment in the report (assessment.smk), and the panels of the report's first screen
PLAN = planned_assessment(STUDY)
ASSESSED_TABLES = ["study_hardness.csv"]
FIRST_PANELS = ["study_hardness"]
if PLAN is not None:
    ASSESSED_TABLES += ["study_assessment.csv", "study_assessment_cost.csv"]
    if PLAN.points:
        FIRST_PANELS += ["study_effects"]
        FIRST_PANELS += ["study_accuracy"] if len(PLAN.ladder) > 1 else []
CHECKED = DATASETS | ({"finest": "finest"} if STUDY.study.accuracy else {})

# The paper's study, beside which tables of other studies are put
IS_PAPER = STUDY.study.name == read_plain(DEFAULT_KEYS)["study"]["name"]
SENSITIVITY = [
    "results/global_sensitivity/tables/global_sensitivity",
    "studies/global_sensitivity/published/global_sensitivity/global_sensitivity",
]


wildcard_constraints:
    ensemble="cases|pool|finest",
    rock="[a-z][a-z0-9_]*",
    scene="[a-z_-]+",
    change="[a-z0-9_]+(-[a-z0-9_]+)?",
    first="[0-9]+",
    last="[0-9]+",


def code(script, *functions, titles=True):
    """Return the digest of a script, and of functions (module:function), with all that they import.

    Without ``titles`` it does not depend on the titles of quantities, so that no joint is simulated
    again when one of these texts changes.
    """
    return code_digest(f"workflow/scripts/{script}", *functions, titles=titles)


def case_of(wildcards):
    """Return the case of an ensemble by its rock and its change."""
    return CASES[wildcards.ensemble][f"{wildcards.rock}-{wildcards.change}"]


def point_of(wildcards):
    """Return the point of a case, for a block of its realisations."""
    block = range(int(wildcards.first), int(wildcards.last) + 1)
    return case_point(ENSEMBLES[wildcards.ensemble], case_of(wildcards), block)


def keys_of(ensemble):
    """Return the digest of all that the joints of a case depend on, for each case by its label."""
    closing = code("close_joints.py", titles=False)
    return {
        label: joints_key(case_point(ENSEMBLES[ensemble], case, range(0)), closing)
        for label, case in sorted(CASES[ensemble].items())
    }


def dataset_key(ensemble):
    """Return the digest of all that a dataset depends on; a file with another one is not read."""
    return digest(ensemble, sorted(keys_of(ensemble).items()))


KEYS = {dataset: dataset_key(ensemble) for dataset, ensemble in DATASETS.items()}

# Cases with equal settings of surfaces share these: the first such case, by ensemble and case
SHARED = {name: first_with_surfaces(of, CASES[name]) for name, of in ENSEMBLES.items()}


def surfaces_of(ensemble, case, first, last):
    """Return the file of the surfaces of a case, for a block of its realisations."""
    return f"{RESULTS}/surfaces/{ensemble}/{SHARED[ensemble][case]}.{first}-{last}.nc"


def blocks(ensemble):
    """Return the blocks of realisations, one for each job.

    With a requested accuracy these are the blocks that are planned so far.
    """
    counts = planned_counts()  # of a requested accuracy
    if counts is None or ensemble == "pool":
        return blocks_of(ENSEMBLES[ensemble])
    return blocks_of(ENSEMBLES[ensemble], counts[ensemble])


def priority_of(ensemble):
    """Return the priority of jobs; the study precedes its pool, as its tables do not need it."""
    return 0 if ensemble == "pool" else 2


def closed_joints(ensemble, of=None):
    """Return the files of the joints of all cases of an ensemble, for the blocks ``of`` or all."""
    return [
        f"{RESULTS}/{ensemble}/{case}.{block.start}-{block.stop - 1}.nc"
        for case in CASES[ensemble]
        for block in (blocks(ensemble) if of is None else of)
    ]


def closed_surfaces(ensemble, case):
    """Return the files of the surfaces of a case, for all blocks."""
    return [
        surfaces_of(ensemble, case, block.start, block.stop - 1)
        for block in blocks(ensemble)
    ]


# Scanned walls


def scan_files(rock):
    """Return the files of the scanned walls of a rock."""
    return [
        str(file)
        for scan in wall_files(STUDY.rocks[rock].walls).values()
        for file in files_of(scan)
    ]


@cache
def walls_key(rock):
    """Return the digest of all that the prepared walls of a rock depend on."""
    return digest(scan_settings(rock), code("prepare_walls.py", titles=False))


def scan_settings(rock):
    """Return the arguments of `prepare_walls` for the scanned walls of a rock."""
    walls = STUDY.rocks[rock].walls
    return {
        "walls": walls,
        "digests": wall_digests(walls),
        "grid": STUDY.grid,
        "jrc_relation": STUDY.surface.jrc_relation,
        "unusual_values": STUDY.study.unusual_values == "allow",
        "realizations": max(of.study.realizations for of in ENSEMBLES.values()),
    }


# Kernels, and effects that are chosen


def kernel_files(points, chosen=False):
    """Return the files of the kernels that the joints of points need.

    If their effects are ``chosen``, these are the kernels of all effects that may be. The files are
    no `ancient` input: Snakemake looks for no change of params or code in jobs below one that is
    run, and an ancient input does not run them either.
    """
    models = [point.settings.conditions.model for point in points]
    kernels = kernels_of(
        (scene, *model[1:])
        for model in models
        for scene in possible_scenes(model[0], chosen=chosen)
    )
    return [f"{RESULTS}/kernels/{'.'.join(kernel)}.txt" for kernel in kernels]


def choice_of(rock):
    """Return the point on which the effects of a rock are chosen, see `examined`."""
    block = range(STUDY.study.realizations)
    of_rock = {
        label: case_point(STUDY, case, block)
        for label, case in CASES["cases"].items()
        if case.rock == rock
    }
    return examined(of_rock)


@cache
def effects_key(rock):
    """Return the digest of all that the choice of a rock's effects depends on."""
    return digest(choice_of(rock), code("choose_effects.py", titles=False))


def surfaces_of_choice(rock):
    """Return the files of the first surfaces of the case on which a rock's effects are chosen."""
    label = choice_of(rock).point.settings.case.label
    count = STUDY.study.realizations if STUDY.study.accuracy else None
    return [
        surfaces_of("cases", label, block.start, block.stop - 1)
        for block in blocks_of(STUDY, count)
        if block.start < MOST_PAIRS
    ]


# The assessment in the report (assessment.smk)


def surfaces_assessed(rock):
    """Return the files of the surfaces of a rock's base case that the assessment uses."""
    points = PLAN.points[rock]
    count = STUDY.study.realizations if STUDY.study.accuracy else None
    return [
        surfaces_of("cases", f"{rock}-{BASE}", block.start, block.stop - 1)
        for block in blocks_of(STUDY, count)
        if block.start < points[0].settings.realizations
    ]


@cache
def assessed_key(rock):
    """Return the digest of all that the joints of a rock in the assessment depend on."""
    closing = code("assess_joints.py", titles=False)
    return digest(PLAN.points[rock], ASSESSED_QUANTITIES, closing)


# Rounds of a requested accuracy (accuracy.smk)


def planned_counts():
    """Return the last plan of a requested accuracy (surfaces by ensemble); None without."""
    if STUDY.study.accuracy is None:
        return None
    number, plan = 0, read_plan(0)
    while not plan["ended"]:
        number += 1
        plan = read_plan(number)
    return plan


def read_plan(number):
    """Return the plan of a round; jobs after it are known once its checkpoint is done."""
    with open(checkpoints.plan_accuracy.get(round=number).output.plan) as file:
        return json.load(file)


def reached_plan():
    """Return the file of the last plan of a requested accuracy; none without a request."""
    counts = planned_counts()
    return [] if counts is None else f"{RESULTS}/accuracy/round_{counts['round']}.json"


def joints_of_round(ensemble, number):
    """Return the files of the joints that the plan of a round needs; none before the first."""
    if number < 0:
        return []
    count = read_plan(number)[ensemble]
    return closed_joints(ensemble, blocks_of(ENSEMBLES[ensemble], count))


def first_points(ensemble):
    """Return the point of the first joint of each rock's base case, without a choice of effects."""
    return [
        case_point(ENSEMBLES[ensemble], case, range(1))
        for case in CASES[ensemble].values()
        if case.parameter == "base"
    ]


# Experiments (experiments.smk)


EXPERIMENTS = {name: experiment_named(name) for name in STUDY.study_sections}
POINTS = {name: cache(partial(of.jobs, STUDY)) for name, of in EXPERIMENTS.items()}
TABLE_OF = {table: name for name, of in EXPERIMENTS.items() for table in of.tables}
FIGURE_OF = {figure: name for name, of in EXPERIMENTS.items() for figure in of.figures}

if workflow.is_main_process:
    try:
        for experiment in EXPERIMENTS.values():
            experiment.check(STUDY)
    except InputError as error:
        refuse_configuration(error)


def name_of(function):
    """Return the name of a function (module:function) for `code`."""
    return f"{function.__module__}:{function.__name__}"


@cache
def points_key(experiment, job):
    """Return the digest of all that the joints of a job of an experiment depend on."""
    closing = code("close_points.py", *makers(experiment, job), titles=False)
    return digest(
        POINTS[experiment]()[job], EXPERIMENTS[experiment].quantities, closing
    )


def makers(experiment, job):
    """Return the names of the functions that make the walls of a job."""
    return sorted({point.maker for point in POINTS[experiment]()[job] if point.maker})


def files_of_experiment(experiment):
    """Return the tables and figures of an experiment; `InputError` without its section."""
    if experiment not in EXPERIMENTS:
        raise InputError(
            f"{experiment}: the configuration has no section of this name "
            f"(studies/{experiment}/{experiment}.yaml has one)"
        )
    of = EXPERIMENTS[experiment]
    tables = [f"{RESULTS}/tables/{table}" for table in of.tables]
    figures = collect(
        f"{RESULTS}/figures/{{figure}}.{{form}}", figure=of.figures, form=["png", "pdf"]
    )
    return tables + figures


# Estimates of the time (experiments.smk): of the experiments of a configuration, or, if it has none,
# of the study


def points_estimated(name):
    """Return the points of an experiment, or those of all ensembles of the study ("study")."""
    if name in EXPERIMENTS:
        return [point for points in POINTS[name]().values() for point in points]
    return [
        case_point(of, case, range(of.study.realizations))
        for ensemble, of in ENSEMBLES.items()
        for case in CASES[ensemble].values()
    ]


def scans_estimated(name):
    """Return the first file of windows, and its settings, of each rock whose walls were scanned.

    An experiment has none, as it makes its walls.
    """
    if name in EXPERIMENTS:
        return {}
    count = STUDY.study.realizations if STUDY.study.accuracy else None
    first = blocks_of(STUDY, count)[0]
    return {
        rock: (
            surfaces_of("cases", f"{rock}-{BASE}", first.start, first.stop - 1),
            case_point(STUDY, CASES["cases"][f"{rock}-{BASE}"], first).settings,
        )
        for rock in SCANNED
    }


def notes_on_estimate():
    """Return notes on joints that take long, and on what the estimate does not contain."""
    if EXPERIMENTS:
        return notes_near_strength(
            point for name in EXPERIMENTS for point in points_estimated(name)
        )
    notes = notes_near_strength(points_estimated("study"))
    if STUDY.study.accuracy:
        notes += ["study.accuracy adds joints until it is reached"]
    if CHOSEN:
        notes += ["less if effects.auto leaves out effects"]
    return notes


# Hard cases (hard_cases.smk)


@cache
def hard_cases():
    """Return the hard cases by name; their file is read only by runs that simulate them."""
    from studies.verification.hard_cases import merged_cases

    return merged_cases(read_plain("studies/verification/hard_cases.yaml"))


def hard_case_kernels():
    """Return the files of the kernels of the hard cases."""
    from studies.verification.hard_cases import kernels_of_cases

    kernels = kernels_of_cases(hard_cases().values())
    return [f"results/hard_cases/kernels/{'.'.join(kernel)}.txt" for kernel in kernels]


# Tables of other studies (report.smk)


def existing(*files):
    """Return the first of some files that exists, as a list; empty unless IS_PAPER."""
    return [file for file in files if IS_PAPER and os.path.exists(file)][:1]
