# Shared by all rules: the checked configuration and its cases. No rules here.
import os
from pathlib import Path

from jointclosure.config import configuration
from jointclosure.config.files import DEFAULT, PAPER_TABLE_3, read_plain
from jointclosure.config.plain import to_plain
from jointclosure.config.wanted import measured_rocks, wanted_of
from jointclosure.config.walls import check_files, wall_files
from jointclosure.ensemble import cases
from jointclosure.ensemble import slices
from jointclosure.compilation.sources import PACKAGE, code_digest
from jointclosure.scans import files_of
from jointclosure.storage.text import read_csv, read_text
from jointclosure.measured import curves as measured
from jointclosure.joint.warmup import kernels_of

ROOT = Path(workflow.current_basedir.get_path_or_uri(secret_free=True)).parents[1]
for file in workflow.configfiles:
    read_plain(file)
CONFIGURED = configuration.configured(config, read_csv)
CONFIGURATION, NUMERICS_REMARK = CONFIGURED.typed, CONFIGURED.remark
config.update(CONFIGURED.keys)
check_files(CONFIGURATION)

STUDY = CONFIGURATION.study.name
RESULTS = f"results/{STUDY}"
ENVIRONMENT = "../envs/jointclosure.yaml"
# relative paths, so that results are still valid where the whole folder was moved
CAPTIONS = Path(os.path.relpath(PACKAGE / "report/texts"))
PAPER = os.path.relpath(PAPER_TABLE_3)
# the cases of the study, and those of its pool of common surfaces
ENSEMBLES = cases.ensembles_of(CONFIGURATION)
CASES = {
    ensemble: {case.label: case for case in cases.cases_of(settled)}
    for ensemble, settled in ENSEMBLES.items()
}
BLOCKS = {
    ensemble: {str(block.start): block for block in cases.blocks_of(settled.study)}
    for ensemble, settled in ENSEMBLES.items()
}
# the ensemble by which the model is judged
POOL = f"{RESULTS}/pool.nc" if "pool" in ENSEMBLES else f"{RESULTS}/study.nc"
ROCKS = CONFIGURATION.rocks
FLOW = CONFIGURATION.flow
WANTED = wanted_of(config)
AUTO = CONFIGURATION.effects_chosen_to is not None
CURVES = measured.curve_settings(CONFIGURATION)
# measured curves are read here, so that errors in them are reported before any job
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
    "correlations.csv",
    "elasticities.csv",
    "max_closure.csv",
    "claims.csv",
    "claim_margins.csv",
    "checks.csv",
    *(["accuracy_reached.csv"] if WANTED else []),
    *(["measured_fit.csv"] if CURVES else []),
    *(["hydraulic_aperture.csv"] if FLOW else []),
]
# figures of the study itself, and of its pool
STUDY_FIGURES = [
    "fig_3_equivalent_stress",
    "fig_5_closure",
    "closure_since_seating",
    "wall_pair",
    *(["hydraulic_aperture"] if FLOW else []),
    *(["table_3_intervals", "trends_max_closure"] if VARIED else []),
]
POOL_FIGURES = ["table_3_predictive"] if VARIED else []
FIGURES = [*STUDY_FIGURES, *POOL_FIGURES]


def code_of(*scripts):
    """Digest of scripts and of all that they import: an edit there re-runs their rules."""
    return code_digest(*(str(ROOT / f"workflow/scripts/{name}.py") for name in scripts))


# priority of the jobs of the study itself: its tables and figures are complete before its pool is closed
EARLY = 1
# covariates of the study's cases and of its pool, where asked for; of scanned walls the means are not known
SYNTHETIC = any(rock.walls is None for rock in ROCKS.values())
VARIATES = CONFIGURATION.statistics.control_variates is not None and SYNTHETIC
COVARIATES = f"{RESULTS}/covariates.nc" if VARIATES else []
POOL_COVARIATES = (
    f"{RESULTS}/pool_covariates.nc" if VARIATES and "pool" in ENSEMBLES else COVARIATES
)

# files of surfaces and closures bear these, and are refused where they differ
SURFACE_CODE = code_of("make_surfaces", "cut_surfaces")
SOLVER_CODE = code_of("close_surfaces")


def closure_of(ensemble, case, block):
    """Settings of the closures of a case and a block of realisations."""
    return slices.block_settings(
        ENSEMBLES[ensemble], CASES[ensemble], case, block, SURFACE_CODE, SOLVER_CODE
    )


def closures_of_rock(rock):
    """Settings of the closures of all cases of a rock, as plain data."""
    block = range(CONFIGURATION.study.realizations)
    return {
        label: to_plain(closure_of("cases", label, block))
        for label, case in CASES["cases"].items()
        if case.rock == rock
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


def beside(*paths):
    """The first existing table of another study, where this one is of the same model."""
    same_model = STUDY == read_plain(DEFAULT)["study"]["name"]
    existing = [path for path in paths if Path(path).exists()]
    return ancient(existing[0]) if same_model and existing else []


def rock_of(wildcards):
    """The rock of a job's case."""
    return CASES[wildcards.ensemble][wildcards.case].rock


def closed_surfaces(wildcards):
    """The surface pairs that a case closes, which may be those of its rock's base case."""
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


def drawn(figures):
    """Files of figures; Snakemake's report shows the PNG."""
    files = expand(f"{RESULTS}/figures/{{figure}}.png", figure=figures)
    shown = [
        (report(file, caption=CAPTIONS / f"{Path(file).stem}.rst", category="Figures"))
        for file in files
    ]
    return [*shown, *expand(f"{RESULTS}/figures/{{figure}}.pdf", figure=figures)]
