# What all rules share: the checked configuration and its cases. No rules here.
from pathlib import Path

from jointclosure.config import configuration
from jointclosure.config.files import read_plain
from jointclosure.config.plain import to_plain
from jointclosure.config.walls import check_files
from jointclosure.dataset import read_csv, read_text
from jointclosure.ensemble import cases
from jointclosure.ensemble import settings
from jointclosure.sources import code_digest
from jointclosure.studies.measured import curves as measured
from jointclosure.warmup import kernels_of

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
PAPER_TABLE_3 = "workflow/resources/paper_table_3.csv"
PAPER_CLAIMS = "workflow/resources/paper_claims.csv"
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
    "claims.csv",
    "checks.csv",
    *(["measured_fit.csv"] if CURVES else []),
]
FIGURES = [
    "fig_3_equivalent_stress",
    "fig_5_closure",
    "wall_pair",
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


# files of surfaces and closures bear these, and are refused where they differ
SURFACE_CODE = code_of("make_surfaces", "cut_surfaces")
SOLVER_CODE = code_of("close_surfaces")


def closure_of(ensemble, case, block):
    """Settings of the closures of a case and a block of realisations."""
    return settings.block_settings(
        ENSEMBLES[ensemble], CASES[ensemble], case, block, SURFACE_CODE, SOLVER_CODE
    )


def surfaces_of(wildcards):
    """Settings of the surface pairs of a case and a block of realisations, as plain data."""
    ensemble = wildcards.ensemble
    return to_plain(
        settings.surface_settings(
            ENSEMBLES[ensemble],
            CASES[ensemble][wildcards.case],
            BLOCKS[ensemble][wildcards.first],
            SURFACE_CODE,
        )
    )


wildcard_constraints:
    ensemble="cases|pool",
    case="[a-z0-9_-]+",
    first="[0-9]+",
