# Shared by all rules: the checked configuration and its cases. No rules here.
import functools
import os
from pathlib import Path

from studies.frame import configuration
from studies.frame.files import DEFAULT, PAPER_TABLE_3, read_plain
from studies.frame.rocks import check_files, wall_files
from studies.frame.cases import closed_keys, wall_digests
from jointclosure.compilation.sources import ROOTS, code_digest
from jointclosure.walls.scans import files_of
from jointclosure.storage.files import read_text
from studies.frame import rocks
from studies.paper.products import PRODUCTS
from studies.frame.plan import BESIDE, Plan

ROOT = Path(workflow.current_basedir.get_path_or_uri(secret_free=True)).parents[1]
for file in workflow.configfiles:
    read_plain(file)
CONFIGURED = configuration.configured(config)
CONFIGURATION = CONFIGURED.typed
config.update(CONFIGURED.keys)
check_files(CONFIGURATION.rocks)

STUDY = CONFIGURATION.study.name
RESULTS = f"results/{STUDY}"
ENVIRONMENT = "../envs/jointclosure.yaml"
# relative paths, so that results are still valid where the whole folder was moved
CAPTIONS = Path(os.path.relpath(ROOTS["studies"] / "paper/report/texts"))
PAPER = os.path.relpath(PAPER_TABLE_3)
ROCKS = CONFIGURATION.rocks
# measured curves are read here, so that errors in them are reported before any job
rocks.measured_curves(rocks.curve_settings(CONFIGURATION), read_text)


def code_of(*scripts):
    """Digest of scripts and of all that they import: an edit there re-runs their rules."""
    return code_digest(*(str(ROOT / f"workflow/scripts/{name}.py") for name in scripts))


# priority of the jobs of the study itself: its tables and figures are complete before its pool is closed
EARLY = 1

PLAN = Plan(CONFIGURED)
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
