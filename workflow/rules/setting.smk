# What all rules share: the checked configuration and its cases. No rules here.
from pathlib import Path

from jointclosure.config import configuration
from jointclosure.config.files import PAPER_TABLE_3, read_plain
from jointclosure.config.plain import to_plain
from jointclosure.config.wanted import wanted_of
from jointclosure.config.walls import check_files, wall_files
from jointclosure.ensemble import cases
from jointclosure.ensemble import slices
from jointclosure.compilation.sources import PACKAGE, code_digest
from jointclosure.storage.seals import settings_digest
from jointclosure.storage.text import read_csv, read_text
from jointclosure.measured import curves as measured
from jointclosure.joint.warmup import kernels_of

ROOT = Path(workflow.basedir)
for file in workflow.configfiles:
    read_plain(file)
CONFIGURED = configuration.configured(config, read_csv)
CONFIGURATION, NUMERICS_SAID = CONFIGURED.typed, CONFIGURED.said
config.update(CONFIGURED.keys)
check_files(CONFIGURATION)

STUDY = CONFIGURATION.study.name
RESULTS = f"results/{STUDY}"
ENVIRONMENT = "../envs/jointclosure.yaml"
CAPTIONS = PACKAGE / "report/texts"
# what is closed: the study's own cases, and those of its pool of common surfaces
ENSEMBLES = cases.ensembles_of(CONFIGURATION)
CASES = {
    ensemble: {case.label: case for case in cases.cases_of(settled)}
    for ensemble, settled in ENSEMBLES.items()
}
BLOCKS = {
    ensemble: {str(block.start): block for block in cases.blocks_of(settled.study)}
    for ensemble, settled in ENSEMBLES.items()
}
# the ensemble that tells what is true of the model
POOL = f"{RESULTS}/pool.nc" if "pool" in ENSEMBLES else f"{RESULTS}/study.nc"
ROCKS = CONFIGURATION.rocks
FLOW = CONFIGURATION.flow
WANTED = wanted_of(config)
AUTO = CONFIGURATION.effects_chosen_to is not None
CURVES = measured.curve_settings(CONFIGURATION)
# measured curves are read here, so that what is wrong with one is said before any job
measured.measured_curves(CURVES, read_text)
CURVE_FILES = [curve.measured.file for curve in CURVES.values()]
VARIED = any(rock.levels for rock in ROCKS.values())
TABLES = [
    "table_1_rocks.csv",
    "table_2_cases.csv",
    "table_3_indifference.csv",
    "table_3_indifference.tex",
    "table_3_indifference.md",
    "table_3_predictive.csv",
    "table_3_joint_tests.csv",
    "along_curve.csv",
    "correlations.csv",
    "elasticities.csv",
    "max_closure.csv",
    "variance_reduction.csv",
    "claims.csv",
    "claim_margins.csv",
    "checks.csv",
    *(["accuracy_reached.csv"] if WANTED else []),
    *(["measured_fit.csv"] if CURVES else []),
    *(["hydraulic_aperture.csv"] if FLOW else []),
]
FIGURES = [
    "fig_3_equivalent_stress",
    "fig_5_closure",
    "wall_pair",
    *(["hydraulic_aperture"] if FLOW else []),
    *(
        [
            "table_3_predictive",
            "table_3_intervals",
            "trends_max_closure",
            "along_curve_elasticities",
            "along_curve_intervals",
        ]
        if VARIED
        else []
    ),
]


def code_of(*scripts):
    """Digest of scripts and of all that they import: an edit there re-runs their rules."""
    return code_digest(*(str(ROOT / f"workflow/scripts/{name}.py") for name in scripts))


def seals_of(*jobs, study=RESULTS):
    """Seals of jobs: what these wrote, from what, and with what settings."""
    return [f"{study}/seals/{job}.json" for job in jobs]


# the seal of each ensemble's file, of the one that tells of the model, and of both
AGGREGATE_SEALS = {
    ensemble: seals_of("aggregate" if ensemble == "cases" else "aggregate_pool")[0]
    for ensemble in ENSEMBLES
}
POOL_SEALS = [AGGREGATE_SEALS["pool" if "pool" in ENSEMBLES else "cases"]]
BOTH_SEALS = list(AGGREGATE_SEALS.values())


# covariates of the study's cases and of the ensemble that tells of the model, where asked for;
# of scanned walls nothing tells their means
SYNTHETIC = any(rock.walls is None for rock in ROCKS.values())
VARIATES = CONFIGURATION.statistics.control_variates is not None and SYNTHETIC
COVARIATES = f"{RESULTS}/covariates.nc" if VARIATES else []
POOL_COVARIATES = (
    f"{RESULTS}/pool_covariates.nc" if VARIATES and "pool" in ENSEMBLES else COVARIATES
)
VARIATES_SEALS = seals_of("measure_covariates") if VARIATES else []


# of all that a study's tables and figures are; a target asks for them, so that one missing is noticed
STUDY_SEALS = BOTH_SEALS + seals_of(
    *(["measure_covariates"] if VARIATES else []),
    "fit_correlations",
    "reduce_variance",
    "find_indifference_intervals",
    "predict_table_3",
    "judge_claims",
    "follow_stress",
    "check_results",
    "write_tables",
    "draw_figures",
    *(["reach_accuracy"] if WANTED else []),
    *(["fit_measured"] if CURVES else []),
    *(["tabulate_flow"] if FLOW else []),
)


# files of surfaces and closures bear these, and are refused where they differ
SURFACE_CODE = code_of("make_surfaces", "cut_surfaces")
SOLVER_CODE = code_of("close_surfaces")


def closure_of(ensemble, case, block):
    """Settings of the closures of a case and a block of realisations."""
    return slices.block_settings(
        ENSEMBLES[ensemble], CASES[ensemble], case, block, SURFACE_CODE, SOLVER_CODE
    )


def choosing(rock):
    """What the choice of a rock's effects is told."""
    block = range(CONFIGURATION.study.realizations)
    return {
        "settings": {
            label: to_plain(closure_of("cases", label, block))
            for label, case in CASES["cases"].items()
            if case.rock == rock
        },
        "code": code_of("choose_effects"),
    }


def preparing(rock):
    """What the reading of a rock's scanned walls is told."""
    return {
        "walls": to_plain(ROCKS[rock].walls),
        "digests": slices.wall_digests(ROCKS[rock].walls),
        "grid": to_plain(CONFIGURATION.grid),
        "jrc_relation": CONFIGURATION.surface.jrc_relation,
        "realizations": max(each.study.realizations for each in ENSEMBLES.values()),
        "unusual_values": CONFIGURATION.study.unusual_values == "allow",
        "code": code_of("prepare_walls"),
    }


def surfaces_of(ensemble, case, first):
    """Settings of the surface pairs of a case and a block of realisations, as plain data."""
    return to_plain(
        slices.surface_settings(
            ENSEMBLES[ensemble],
            CASES[ensemble][case],
            BLOCKS[ensemble][first],
            SURFACE_CODE,
        )
    )


def rock_of(wildcards):
    """The rock of a job's case."""
    return CASES[wildcards.ensemble][wildcards.case].rock


def closed_surfaces(wildcards):
    """The surface pairs that a case closes: its own, or those of its rock's base case."""
    surface = CASES[wildcards.ensemble][wildcards.case].surface
    return f"{RESULTS}/{wildcards.ensemble}/{surface}.{wildcards.first}.surfaces.nc"


def closed_blocks(ensemble):
    """The files of all cases and blocks of an ensemble, in the order in which they are joined."""
    return [
        f"{RESULTS}/{ensemble}/{case}.{first}.nc"
        for case in CASES[ensemble]
        for first in BLOCKS[ensemble]
    ]


wildcard_constraints:
    ensemble="cases|pool",
    case="[a-z0-9_-]+",
    first="[0-9]+",
