# What all rules share: the checked configuration and its cases. No rules here.
from pathlib import Path

from jointclosure.compilation import source_digest
from jointclosure.dataset import read_csv, read_text
from jointclosure.study import (
    cases,
    configuration,
    measured,
    project,
    settings,
    wall_settings,
)

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

# An edit in the package re-runs the rules whose parts of it changed.
SURFACE_CODE = source_digest(
    "surface",
    "randomness",
    "scans",
    "study/ensemble",
    "study/cases",
    "study/measured_walls",
    "dataset",
    "files",
)
SOLVER_CODE = source_digest(
    "compilation",
    "parameters",
    "mechanics",
    "solvers",
    "protocol",
    "readings",
    "simulation",
    "study/ensemble",
    "study/scene_choice",
    "study/configuration",
    "dataset",
    "files",
)
ANALYSIS_CODE = source_digest("statistics", "study", "tables", "randomness", "dataset")
REPORT_CODE = source_digest("report", "tables", "study", "dataset")
FIGURE_CODE = source_digest("plotting", "empirical", "tables", "readings", "dataset")


wildcard_constraints:
    case="[a-z0-9_-]+",
    first="[0-9]+",
