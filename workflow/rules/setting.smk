# What all rules share: the checked configuration and its cases. No rules here.
from pathlib import Path

from jointclosure.sources import code_digest
from jointclosure.storage.text import read_csv, read_text
from jointclosure.ensemble import cases
from jointclosure.config import configuration
from jointclosure.studies.measured import curves as measured
from jointclosure.config import project
from jointclosure.ensemble import settings
from jointclosure.config import walls as wall_settings
from jointclosure.storage.seals import settings_digest

ROOT = Path(workflow.basedir)
for file in workflow.configfiles:
    configuration.read_plain(file)
DECIDED, NUMERICS_SAID = project.decided(config, ROOT, read_csv)
config.update(DECIDED)
configuration.checked(
    config, configuration.read_schema(ROOT / "workflow/schemas/config.schema.yaml")
)
wall_settings.check_files(config)

STUDY = config["study"]["name"]
RESULTS = f"results/{STUDY}"
ENVIRONMENT = "../envs/jointclosure.yaml"
PAPER_TABLE_3 = "workflow/resources/paper_table_3.csv"
CASES = {case.label: case for case in cases.cases_of(config)}
BLOCKS = {str(block.start): block for block in cases.blocks_of(config)}
SURFACES = {case.surface for case in CASES.values()}
ROCKS = {name: config["rocks"][name] for name in config["study"]["rocks"]}
AUTO = configuration.choice_tolerance(config) is not None
# measured curves are read here, so that what is wrong with one is said before any job
MEASURED = {
    name: config["rocks"][name]["measured"]["file"]
    for name in measured.measured_curves(config, read_text)
}
VARIED = any(values for rock in ROCKS.values() for values in rock["levels"].values())
TABLES = [
    "table_1_rocks.csv",
    "table_2_cases.csv",
    "table_3_indifference.csv",
    "table_3_indifference.tex",
    "table_3_indifference.md",
    "correlations.csv",
    "max_closure.csv",
    "claims.csv",
    "checks.csv",
    *(["measured_fit.csv"] if MEASURED else []),
]
FIGURES = [
    "fig_3_equivalent_stress",
    "fig_5_closure",
    "wall_pair",
    *(["table_3_intervals", "trends_max_closure"] if VARIED else []),
]


def code_of(*scripts):
    """Digest of scripts and of all that they import: an edit there re-runs their rules."""
    return code_digest(*(str(ROOT / f"workflow/scripts/{name}.py") for name in scripts))


def seals_of(*jobs, study=RESULTS):
    """Seals of jobs: what these wrote, from what, and with what settings."""
    return [f"{study}/seals/{job}.json" for job in jobs]


# of all that a study's tables and figures are; a target asks for them, so that one missing is noticed
STUDY_SEALS = seals_of(
    "aggregate",
    "fit_correlations",
    "find_indifference_intervals",
    "judge_claims",
    "check_results",
    "write_tables",
    "draw_figures",
    *(["fit_measured"] if MEASURED else []),
)


# files of surfaces and closures bear these, and are refused where they differ
SURFACE_CODE = code_of("make_surfaces", "cut_surfaces")
SOLVER_CODE = code_of("close_surfaces")


wildcard_constraints:
    case="[a-z0-9_-]+",
    first="[0-9]+",
