# Shared by all rules: the checked configuration and its cases. No rules here.
import os
from pathlib import Path

from studies.frame.config import configuration
from studies.frame.config.files import DEFAULT, PAPER_TABLE_3, read_plain
from jointclosure.inputs.plain import to_plain
from studies.frame.config.walls import check_files, wall_files
from studies.frame.ensemble import cases
from studies.frame.ensemble import slices
from jointclosure.compilation.sources import ROOTS, code_digest
from jointclosure.walls.scans import files_of
from jointclosure.storage.text import read_csv, read_text
from studies.frame import measured_files as measured
from jointclosure.joint.warmup import kernels_of
from studies.paper.products import PRODUCTS
from studies.frame.products.needs import BESIDE, Plan

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
CAPTIONS = Path(os.path.relpath(ROOTS["studies"] / "paper/report/texts"))
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
ROCKS = CONFIGURATION.rocks
AUTO = CONFIGURATION.effects_chosen_to is not None
# measured curves are read here, so that errors in them are reported before any job
measured.measured_curves(measured.curve_settings(CONFIGURATION), read_text)


def code_of(*scripts):
    """Digest of scripts and of all that they import: an edit there re-runs their rules."""
    return code_digest(*(str(ROOT / f"workflow/scripts/{name}.py") for name in scripts))


# priority of the jobs of the study itself: its tables and figures are complete before its pool is closed
EARLY = 1

# files of surfaces and closures bear these, and are refused where they differ
SURFACE_CODE = code_of("make_surfaces", "cut_surfaces")
SOLVER_CODE = code_of("close_surfaces")

PLAN = Plan(CONFIGURED, SURFACE_CODE)
PLANNED = {name: product for name, product in PRODUCTS.items() if product.when(PLAN)}
# of the target `all`
COMPLETE = [
    PLAN.file(name)
    for product in PLANNED.values()
    if not product.apart
    for name in product.files(PLAN)
]
TABLES = [path for path in COMPLETE if Path(path).parent.name == "tables"]
FIGURES = [path for path in COMPLETE if path.endswith(".png")]


def caption(figure):
    """Text that describes a figure, by its file."""
    return CAPTIONS / f"{Path(figure).stem}.rst"


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
